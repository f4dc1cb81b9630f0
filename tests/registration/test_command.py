"""The command line of a registration: exit codes, messages, files it leaves."""

import csv
import functools
import io
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from pgm_lab import datasets, registration
from pgm_lab.io import files as _files
from pgm_lab.io import geotiff as _geotiff
from pgm_lab.registration import __main__ as command
from pgm_lab.report import _registration_figures
from pgm_lab.report import registration as report
from tests.calls import (
    HOW,
    Call,
    break_,
    drawn,
    huge_header,
    image,
    tiff,
    truncated_jpeg,
)
from tests.registration import images

CALL = Call(command.main, "python -m pgm_lab.registration")
run, ended, refused = CALL.run, CALL.ended, CALL.refused
rasterio = pytest.mark.skipif(not _geotiff.installed(), reason="needs rasterio")


PLACE = "column", "row"


@pytest.fixture
def files(tmp_path):
    """Two images, in a folder with a space in its name."""
    folder = tmp_path / "my images"
    folder.mkdir()
    return images.save(folder)


@pytest.fixture
def on_map(tmp_path):
    """Two GeoTIFFs; the sensed one begins 20 columns and 10 rows later."""
    folder = tmp_path / "on map"
    folder.mkdir()
    return images.save_tiff(folder)


@pytest.fixture
def reports(tmp_path):
    folder = tmp_path / "reports"
    folder.mkdir()
    return folder


@pytest.fixture
def quick(monkeypatch):
    """A registration and a page that take no time, for what comes around them."""
    monkeypatch.setattr(report, "html", lambda *_, **__: "the page")
    return no_match(monkeypatch, images.result())


def no_match(monkeypatch, found, asked=None):
    """Have the command find what is given, and note what was asked."""

    @functools.wraps(registration.register)
    def register(reference, sensed, **options):
        if asked is not None:
            asked.update(options, shapes=(reference.shape, sensed.shape))
        return found

    monkeypatch.setattr(registration, "register", register)
    return found


# ------------------------------------------------------------------- a good run


def test_the_short_report_is_printed_and_the_long_ones_written(
    files, reports, capsys, monkeypatch
):
    monkeypatch.setattr(_registration_figures, "png", drawn)
    html, text, table = (reports / name for name in ("a.html", "b.TXT", "all.csv"))
    call = (*files, "--number", 20, "--chip", 15, "--pixel-size", 6)
    assert run(*call, "--report", html, "--report", text, "--csv", table) == 0
    output = capsys.readouterr()
    both = [np.array(Image.open(path)) for path in files]
    points = registration.pick(both[0], 20, 15, sensed=both[1])
    found = registration.register(*both, points, chip=15, refine="lsm")
    assert np.sum(found.accepted) > 15
    mean = found.accuracy.median_x, found.accuracy.median_y
    np.testing.assert_allclose(mean, images.SHIFT, atol=0.02)
    about = "Reference image reference.png, sensed image sensed.png."
    words = {"settings": {"number": 20, "chip": 15, "refine": "lsm"}, "about": about}
    words |= {"model": registration.fit(found), "pixel_size": 6.0}
    both = [registration.read(path) for path in files]
    assert output.err == ""  # no bar where nobody watches
    assert output.out == report.text(found, *both, **words, short=True) + "\n"
    assert text.read_text(encoding="utf-8") == report.text(found, *both, **words)
    assert html.read_text(encoding="utf-8") == report.html(found, *both, **words)
    assert table.read_text(encoding="utf-8") == found.csv()
    assert sorted(os.listdir(reports)) == ["a.html", "all.csv", "b.TXT"]


@pytest.mark.slow
def test_as_a_program_of_its_own_without_a_network(files, reports):
    """Where every connection is refused, and the console has no sign for ×."""
    code = """
import socket, sys
def refuse(*_, **__):
    raise AssertionError("the network was asked")
socket.socket.connect = socket.getaddrinfo = refuse
import runpy
runpy.run_module("pgm_lab.registration", run_name="__main__", alter_sys=True)
"""
    call = [sys.executable, "-c", code, *map(str, files), "--number", "12"]
    call += ["--report", str(reports / "r.html")]
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(call, capture_output=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"Image registration") and done.stderr == b""
    assert os.listdir(reports) == ["r.html"]


@rasterio
def test_images_on_the_map_are_compared_there_and_resampled(on_map, reports, capsys):
    """They begin at different corners; the shift is that of the map, in metres."""
    table, again = reports / "all.csv", reports / "again.tif"
    call = ("--number", 30, "--csv", table, "--resampled", again)
    assert run(*on_map, *call) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert (
        "The sensed image lies 1.25 px (7.5 m) east and 0.50 px (3.0 m) north" in said
    )
    rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
    x, y = images.CORNER
    for row in rows:
        column, down = (float(row[f"{one} in the reference (px)"]) for one in PLACE)
        assert column >= 20 + 3 and down >= 10 + 3  # what the sensed image shows
        assert float(row["x on the map"]) == x + (column + 0.5) * images.SIZE
        assert float(row["y on the map"]) == y - (down + 0.5) * images.SIZE
    assert {row["status"] for row in rows} >= {"accepted"}
    reference, new = registration.read(on_map[0]), registration.read(again)
    np.testing.assert_array_equal(new.transform, reference.transform)
    assert new.grey.shape == reference.grey.shape and new.crs == reference.crs
    assert new.mask[:8].all() and new.mask[:, :18].all()  # not in the sensed image
    points = registration.pick(reference.grey, 30, sensed=new.values)
    left = registration.register(reference.values, new.values, points, refine="lsm")
    assert left.accepted.mean() > 0.8 and left.rmse_t < 0.02


@rasterio
def test_points_may_be_map_coordinates(on_map, tmp_path, monkeypatch, capsys):
    asked = {}
    no_match(monkeypatch, images.result(2), asked)
    points = tmp_path / "points.csv"
    points.write_text("% x, y\n700303, 9319397\n700603, 9319697\n")
    assert run(*on_map, "--map-points", points) == 0
    np.testing.assert_allclose(asked["points"], [(50, 100), (100, 50)])
    np.testing.assert_allclose(asked["offset"], (-20, -10))


def test_the_options_reach_the_registration(files, tmp_path, monkeypatch, capsys):
    asked = {}
    no_match(monkeypatch, images.result(2), asked)
    options = "--chip 31 --radius 5 --refine parabola --threshold 0.8 --offset 4 -3.5"
    options += " --largest-sd 0.3 --smooth 0.5"
    chosen = tmp_path / "points.csv"
    chosen.write_text("% column, row\n100.5,80\n120,90.25\n")
    assert run(*files, *options.split(), "--points", chosen) == 0
    np.testing.assert_array_equal(asked.pop("points"), [(100.5, 80), (120, 90.25)])
    np.testing.assert_array_equal(asked.pop("offset"), (4, -3.5))
    assert asked == {
        "chip": 31, "radius": 5, "refine": "parabola", "threshold": 0.8,
        "largest_sd": 0.3, "smooth": 0.5,
        "shapes": ((160, 200), (160, 200)),
    }  # fmt: skip
    no_match(monkeypatch, images.result(2, sd=0.289), asked)
    assert run(*files, "--grid", 4, "--chip", 11, "--refine", "none") == 0
    assert asked["refine"] is None
    steps = np.unique(np.diff(np.unique(asked["points"][:, 0])))
    np.testing.assert_array_equal(steps, [4])
    low, high = asked["points"].min(axis=0), asked["points"].max(axis=0)
    assert 8 <= low.min() < 12 and np.all(high <= (200 - 9, 160 - 9))


def test_band_and_no_data_reach_the_reading(files, quick, monkeypatch, capsys):
    asked = []
    read = registration.read

    def noted(path, band=None, *, nodata=None):
        asked.append((band, nodata))
        return read(path, band, nodata=nodata)

    monkeypatch.setattr(registration, "read", noted)
    assert run(*files, "--band", 1, "--nodata", 0) == 0
    assert asked == [(1, 0.0)] * 2


def test_every_option_is_described_and_every_setting_an_option():
    text = command.parser().format_help()
    for name in set(command.SETTINGS) - {"ratio"}:
        assert f"--{name.replace('_', '-')}" in text


def test_an_affine_model_is_fitted_where_asked(files, reports, capsys):
    path = reports / "r.txt"
    assert run(*files, "--model", "affine", "--number", 30, "--report", path) == 0
    text = path.read_text(encoding="utf-8")
    assert "Model: affine" in text and re.search("^b2 ", text, re.MULTILINE)


# ------------------------------------------------------------ images that are none

BAD = {
    "missing": (lambda path: path.unlink(), "there is no such file"),
    "empty": (lambda path: path.write_bytes(b""), "the file is empty"),
    "text": (lambda path: path.write_text("1 2 3\n" * 9), "not an image"),
    "truncated": (truncated_jpeg, "damaged"),
    "a folder": (lambda path: (path.unlink(), path.mkdir()), "this is a folder"),
    "huge header": (lambda path: path.write_bytes(huge_header()), "sensed"),
    "one pixel": (image(np.zeros((1, 1), np.uint8)), ""),
    "one row": (image(np.zeros((1, 240), np.uint8)), ""),
    "featureless": (image(np.full((160, 200), 99, np.uint8)), ""),
    "colours": (image(np.zeros((160, 200, 3), np.uint8)), "--band 1, for example"),
    "nothing but NaN": (tiff(np.full((160, 200), np.nan, np.float32)), "no data"),
    "other place": (image(datasets.yellowstone().grey[:160, :200]), "the same place"),
    "other end": (
        lambda path: image(images.pair()[1][:, ::-1])(path),
        "neither turned",
    ),
}


@pytest.mark.parametrize("spoil, words", BAD.values(), ids=BAD.keys())
def test_a_bad_image_ends_with_1_and_one_line_and_leaves_nothing(
    files, reports, capsys, spoil, words
):
    """With points given, too: picking them fails where there is nothing to pick."""
    spoil(files[1])
    outputs = ("--report", reports / "r.html", "--csv", reports / "r.csv")
    assert words in ended(capsys, *files, "--number", 20, *outputs)
    points = reports.parent / "points.csv"
    points.write_text("% column, row\n100,80\n120,90\n")
    assert words in ended(capsys, *files, "--points", points, *outputs)
    assert os.listdir(reports) == []


def test_two_scenes_of_different_places_are_not_registered(files, reports, capsys):
    """Nothing is accepted, and the message says what to check."""
    scene = datasets.landsat().grey
    for path, part in zip(files, (scene[:300, :400], scene[600:900, 500:900])):
        image(part)(path)
    message = ended(capsys, *files, "--report", reports / "r.html")
    assert "none of 100 points was accepted; most often (" in message
    for words in ("same place", "same band", "--radius", "--offset COLUMN ROW"):
        assert words in message
    assert os.listdir(reports) == []


def test_a_shift_beyond_the_radius_is_found_from_an_offset(files, capsys):
    scene = datasets.landsat().grey
    for path, top in zip(files, (50, 38)):
        image(scene[top : top + 300, 100:400])(path)
    message = ended(capsys, *files)
    assert "Are they farther apart than --radius?" in message
    assert run(*files, "--offset", 0, 10) == 0
    assert "2.00 px lower" in " ".join(capsys.readouterr().out.split())


def test_images_of_two_sizes_need_an_offset(files, capsys):
    values = images.pair()[1]
    image(values[10:, 20:].copy())(files[1])
    message = ended(capsys, *files)
    assert (
        "(160, 200) and (150, 180)" in message and "by --offset COLUMN ROW" in message
    )
    assert run(*files, "--offset", -20, -10) == 0
    assert "1.25 px farther to the right" in " ".join(capsys.readouterr().out.split())


def test_an_image_that_lacks_data_in_part_is_registered_elsewhere(files, capsys):
    values = images.pair()[1].astype(np.float32)
    values[:, :60] = np.nan
    tiff(values)(files[1])
    assert run(*files, "--number", 20) == 0
    assert "points were accepted" in capsys.readouterr().out


def test_the_same_file_twice_is_refused(files, reports, capsys, tmp_path):
    call = ("--report", reports / "r.html")
    assert "are the same file" in ended(capsys, files[0], files[0], *call)
    link = tmp_path / "link.png"
    link.symlink_to(files[0])
    assert "are the same file" in ended(capsys, files[0], link, *call)
    assert os.listdir(reports) == []


def test_a_copy_of_the_image_is_called_the_same_image(files, capsys):
    files[1].write_bytes(files[0].read_bytes())
    assert run(*files, "--number", 20) == 0
    assert "Is it the same image twice?" in " ".join(capsys.readouterr().out.split())


# --------------------------------------------------------------------- on the map


@rasterio
@pytest.mark.parametrize(
    "more, words",
    [
        ({"crs": "EPSG:32648"}, "different coordinate reference systems"),
        ({"size": 3.0}, "pixels of different size"),
        ({"cut": (10, 20), "crs": None}, "different coordinate reference systems"),
    ],
)
def test_images_on_different_maps_are_refused(tmp_path, reports, capsys, more, words):
    files = images.save_tiff(tmp_path, **more)
    message = ended(capsys, *files, "--report", reports / "r.html")
    assert words in message and "gdalwarp" in message
    assert os.listdir(reports) == []


@rasterio
def test_one_image_on_the_map_and_one_not_are_refused_unless_an_offset_is_given(
    files, on_map, capsys
):
    assert "has no georeference" in ended(capsys, on_map[0], files[1])
    assert run(on_map[0], files[1], "--offset", 0, 0) == 0
    assert "(7.5 m) east" in capsys.readouterr().out


@rasterio
def test_a_pixel_size_that_the_file_states_is_not_given_again(on_map, capsys):
    message = ended(capsys, *on_map, "--pixel-size", 10)
    assert "its pixels have 6 x 6 m: leave out --pixel-size" in message


@rasterio
def test_map_coordinates_need_a_map(files, tmp_path, capsys):
    points = tmp_path / "points.csv"
    points.write_text("700303 9319397\n")
    message = ended(capsys, *files, "--map-points", points)
    assert "reference.png has no georeference" in message


def test_without_rasterio_no_image_is_promised(files, reports, capsys, monkeypatch):
    monkeypatch.setattr(_geotiff, "installed", lambda: False)
    message = refused(capsys, *files, "--resampled", reports / "new.tif")
    assert "--resampled needs rasterio: pip install" in message


@rasterio
def test_without_rasterio_a_geotiff_says_how_to_get_it(on_map, capsys, monkeypatch):
    monkeypatch.setattr(_geotiff, "installed", lambda: False)
    assert _geotiff.INSTALL in ended(capsys, *on_map)


# ------------------------------------------------------------------- points as text

POINTS = {
    "a heading": ("column,row\n10,20\n", "line 1: 'column' is not a number; a heading"),
    "not a number": ("10 20\n30 x\n", "line 2: 'x' is not a number"),
    "three columns": ("1 10 20\n", "3 column(s), where points have 2: column row"),
    "empty": ("", "the file holds no numbers"),
    "no numbers": ("% column row\n", "the file holds no numbers"),
    "a picture": ("\x89PNG\0\n", "this is not text"),
}


@pytest.mark.parametrize("text, words", POINTS.values(), ids=POINTS.keys())
def test_bad_points_end_with_1(files, reports, tmp_path, capsys, text, words):
    points = tmp_path / "points.csv"
    points.write_bytes(text.encode("latin-1"))
    call = ("--points", points, "--report", reports / "r.html")
    message = ended(capsys, *files, *call)
    assert "points.csv" in message and words in message
    assert os.listdir(reports) == []


def test_missing_points_end_with_1(files, tmp_path, capsys):
    assert "none.csv" in ended(capsys, *files, "--points", tmp_path / "none.csv")


# -------------------------------------------------------------------- wrong calls


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--report", "r.pdf"], "the name must end in .html, .htm, .txt"),
        (["--report", "nowhere/r.html"], "there is no folder nowhere"),
        (["--csv", "r.xlsx"], "the name must end in .csv, .txt"),
        (["--resampled", "r.png"], "the name must end in .tif, .tiff"),
        (["--points", "p.csv", "--number", "9"], "not allowed with argument --points"),
        (["--grid", "9", "--number", "9"], "not allowed with argument"),
        (["--points", "p", "--map-points", "q"], "not allowed with argument"),
        (["--number", "0"], "'0' is not a whole number from 1"),
        (["--chip", "20"], "'20' is even"),
        (["--radius", "x"], "'x' is not a whole number"),
        (["--refine", "best"], "invalid choice: 'best'"),
        (["--model", "spline"], "invalid choice: 'spline'"),
        (["--threshold", "1.5"], "'1.5' is not a number from 0 to 1"),
        (["--offset", "1"], "expected 2 arguments"),
        (["--offset", "1", "nan"], "'nan' is not a number"),
        (["--nodata", "none"], "'none' is not a number"),
        (["--pixel-size", "0,01"], "a decimal needs a point"),
        (["--mask"], "unrecognized arguments"),
    ],
)
def test_a_wrong_call_ends_with_2(files, capsys, arguments, message):
    assert message in refused(capsys, *files, *arguments)


def test_existing_files_are_replaced_only_by_force(files, reports, quick, capsys):
    outputs = [("--report", "r.html"), ("--csv", "r.csv")]
    outputs += [("--resampled", "r.tif")] if _geotiff.installed() else []
    for option, name in outputs:
        path = reports / name
        path.write_text("mine")
        message = refused(capsys, *files, option, path)
        assert "it exists already; --force replaces it" in message
        assert path.read_text() == "mine"
        assert run(*files, option, path, "--force") == 0
        assert path.read_bytes() != b"mine"
        capsys.readouterr()


@rasterio
def test_an_image_is_never_replaced_and_no_output_by_another(files, reports, capsys):
    path = files[1].rename(files[1].with_suffix(".tif"))
    message = refused(capsys, files[0], path, "--resampled", path, "--force")
    assert f"this is the input {path}" in message
    both = ("--report", reports / "r.txt", "--csv", reports / "R.TXT")
    assert "is the same file" in refused(capsys, files[0], path, *both)


# ------------------------------------------------------------- what goes wrong later


@rasterio
@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize(
    "where", ["registering", "resampling", "drawing", "writing", "renaming"]
)
def test_nothing_half_written_is_left(
    files, reports, quick, capsys, monkeypatch, where, how
):
    """An older report stays as it was."""
    old = reports / "r.txt"
    old.write_text("old")
    functions = {
        "registering": (registration, "register"),
        "resampling": (registration, "resample"),
        "drawing": (command.report, "html"),
    }
    outputs = ("--report", old, "--report", reports / "r.html", "--force")
    outputs += ("--resampled", reports / "new.tif")
    break_(monkeypatch, where, how, functions)
    assert HOW[how][1] in ended(capsys, *files, *outputs)
    assert os.listdir(reports) == ["r.txt"] and old.read_text() == "old"


def test_a_bar_is_shown_where_somebody_watches(files, quick, capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    assert run(*files) == 0
    assert "reading" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="no such names there")
def test_control_characters_of_a_name_never_reach_the_terminal(files, quick, capsys):
    odd = files[0].rename(files[0].with_name("a\x1b[31m\u202e.png"))
    assert run(odd, files[1]) == 0
    output = capsys.readouterr()
    assert "\x1b" not in output.out + output.err and "a\\x1b[31m" in output.out
    odd.write_text("no image")
    assert "a\\x1b[31m" in ended(capsys, odd, files[1])


def test_the_readme_shows_a_call_that_is_understood():
    text = (_files.Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    calls = re.findall(r"python -m pgm_lab\.registration (.+)\n", text)
    assert calls
    for words in calls:
        options = command.parser().parse_args(words.split())
        assert options.reference != options.sensed
