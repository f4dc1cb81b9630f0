"""pgm_lab register: its options, images that are none, and images on the map."""

import csv
import importlib.util
import io
import os
import re

import numpy as np
import pytest
from PIL import Image

from pgm_lab import datasets, registration, report
from pgm_lab.command import _register, main
from pgm_lab.report import _figures
from tests.command.calls import NO_IMAGE, drawn, image
from tests.command.conftest import no_work
from tests.registration import images

RASTERIO = importlib.util.find_spec("rasterio") is not None
rasterio = pytest.mark.skipif(not RASTERIO, reason="needs rasterio")


@pytest.fixture
def on_map(register, folder):
    """Two GeoTIFFs; the sensed one begins 20 columns and 10 rows later."""
    register.inputs[:] = images.save_tiff(folder)
    return register


def test_reports_and_tables_are_those_of_the_functions(
    register, outputs, capsys, monkeypatch
):
    monkeypatch.setattr(_figures, "png", drawn)
    html, text, table = (outputs / name for name in ("a.html", "b.txt", "all.csv"))
    words = ("--number", 20, "--chip", 15, "--pixel-size", 6, "--csv", table)
    assert register.run(*words, "--report", html, "--report", text) == 0
    both = [np.array(Image.open(path)) for path in register.inputs]
    points = registration.pick(both[0], 20, 15, sensed=both[1])
    found = registration.register(*both, points, chip=15, refine="lsm")
    assert np.sum(found.accepted) > 15
    mean = found.accuracy.median_x, found.accuracy.median_y
    np.testing.assert_allclose(mean, images.SHIFT, atol=0.02)
    about = "Reference image reference.png, sensed image sensed.png."
    more = {"settings": {"number": 20, "chip": 15, "refine": "lsm"}, "about": about}
    more |= {"model": registration.fit(found), "pixel_size": 6.0}
    both = [registration.read(path) for path in register.inputs]
    short = report.registration.text(found, *both, **more, short=True)
    assert capsys.readouterr().out == short + "\n"
    for path, expected in (
        (html, report.registration.html(found, *both, **more)),
        (text, report.registration.text(found, *both, **more)),
        (table, found.csv()),
    ):
        assert path.read_text(encoding="utf-8") == expected


def test_the_options_reach_the_registration(register, tmp_path, monkeypatch):
    asked = {}
    no_work(monkeypatch, "register", images.result(2), asked)
    words = "--chip 31 --radius 5 --refine parabola --threshold 0.8 --offset 4 -3.5"
    words += " --largest-sd 0.3 --smooth 0.5"
    chosen = tmp_path / "points.csv"
    chosen.write_text("% column, row\n100.5,80\n120,90.25\n")
    assert register.run(*words.split(), "--points", chosen) == 0
    np.testing.assert_array_equal(asked.pop("points"), [(100.5, 80), (120, 90.25)])
    np.testing.assert_array_equal(asked.pop("offset"), (4, -3.5))
    assert asked == {
        "chip": 31, "radius": 5, "refine": "parabola", "threshold": 0.8,
        "largest_sd": 0.3, "smooth": 0.5,
    }  # fmt: skip
    no_work(monkeypatch, "register", images.result(2, sd=0.289), asked)
    assert register.run("--grid", 4, "--chip", 11, "--refine", "none") == 0
    assert asked["refine"] is None
    steps = np.unique(np.diff(np.unique(asked["points"][:, 0])))
    np.testing.assert_array_equal(steps, [4])
    low, high = asked["points"].min(axis=0), asked["points"].max(axis=0)
    assert 8 <= low.min() < 12 and np.all(high <= (200 - 9, 160 - 9))


def test_band_and_no_data_reach_the_reading(register, quick, monkeypatch):
    asked, read = [], registration.read

    def noted(path, band=None, *, nodata=None):
        asked.append((band, nodata))
        return read(path, band, nodata=nodata)

    monkeypatch.setattr(registration, "read", noted)
    assert register.run("--band", 1, "--nodata", 0) == 0
    assert asked == [(1, 0.0)] * 2
    grey = np.array(Image.open(register.inputs[1])) // 256
    image(np.dstack([grey * 0, grey, grey]).astype(np.uint8))(register.inputs[1])
    assert register.run("--band", 1, "--sensed-band", 2) == 0
    assert asked[2:] == [(1, None), (2, None)]


def test_every_option_is_described_and_every_setting_an_option(capsys):
    assert set(_register.OPTIONS) <= set(report.registration.SETTINGS)
    with pytest.raises(SystemExit):
        main(["register", "--help"])
    text = capsys.readouterr().out
    for name in set(report.registration.SETTINGS) - {"ratio", "start"}:
        assert f"--{name.replace('_', '-')}" in text


def test_an_affine_model_is_fitted_where_asked(register, outputs):
    path = outputs / "r.txt"
    assert register.run("--model", "affine", "--number", 30, "--report", path) == 0
    text = path.read_text(encoding="utf-8")
    assert "Model: affine" in text and re.search("^b2 ", text, re.MULTILINE)


@pytest.mark.parametrize(
    "words, message",
    [
        (["--csv", "r.xlsx"], "the name must end in .csv, .txt"),
        (["--resampled", "r.png"], "the name must end in .tif, .tiff"),
        (["--grid", "9", "--number", "9"], "not allowed with argument"),
        (["--points", "p", "--map-points", "q"], "not allowed with argument"),
        (["--offset", "1"], "expected 2 arguments"),
        (["--offset", "1", "nan"], "'nan' is not a number"),
    ],
)
def test_a_wrong_call_ends_with_2(register, capsys, words, message):
    assert message in register.refused(capsys, *words)


# --- Images that are none, or do not fit ---

BAD = NO_IMAGE | {
    "colours": (image(np.zeros((160, 200, 3), np.uint8)), "--sensed-band 1, for"),
    "other place": (
        image(datasets.yellowstone().grey[:160, :200]),
        "accepted, nor do reduced images agree on any shift up to a quarter of",
    ),
    "a negative": (
        image(65_535 - images.pair()[1]),
        "is inverted, dark where the other is bright. Take in its place, in",
    ),
}


@pytest.mark.parametrize("spoil, words", BAD.values(), ids=BAD.keys())
def test_a_bad_image_ends_with_1_and_leaves_nothing(
    register, outputs, tmp_path, capsys, spoil, words
):
    """With points given, too: picking them fails where there is nothing to pick."""
    spoil(register.inputs[1])
    points = tmp_path / "points.csv"
    points.write_text("% column, row\n100,80\n120,90\n")
    files = ("--report", outputs / "r.html", "--csv", outputs / "r.csv")
    for where in (("--number", 20), ("--points", points)):
        assert words in register.ended(capsys, *where, *files)
    assert os.listdir(outputs) == []


def test_images_of_two_sizes_need_an_offset(register, capsys):
    image(images.pair()[1][10:, 20:].copy())(register.inputs[1])
    message = register.ended(capsys)
    assert "(160, 200) and (150, 180)" in message
    assert "by --offset COLUMN ROW" in message
    assert register.run("--offset", -20, -10) == 0
    assert "1.25 px farther to the right" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("offset", [(1e300, 0), (0, -160), (200, 0)])
def test_an_offset_that_leaves_no_overlap_is_refused(register, capsys, offset):
    message = register.ended(capsys, "--offset", *offset)
    assert "the images do not overlap: they have 200 x 160 and 200 x 160" in message
    assert f"{offset[0]:g} columns" in message and "another --offset" in message
    near = np.sign(offset) * (190, 150)  # some rows or columns are left, but no chip
    assert "no texture" in register.ended(capsys, "--offset", *near)


# --- On the map ---


@rasterio
def test_images_on_the_map_are_compared_there_and_resampled(on_map, outputs, capsys):
    """They begin at different corners; the shift is that of the map, in metres."""
    table, again = outputs / "all.csv", outputs / "again.tif"
    assert on_map.run("--number", 30, "--csv", table, "--resampled", again) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "sensed image lies 1.25 px (7.5 m) east and 0.50 px (3.0 m) north" in said
    rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
    x, y = images.CORNER
    for row in rows:
        column, down = (
            float(row[f"{one} in the reference (px)"]) for one in ("column", "row")
        )
        assert column >= 20 + 3 and down >= 10 + 3  # what the sensed image shows
        assert float(row["x on the map"]) == x + (column + 0.5) * images.SIZE
        assert float(row["y on the map"]) == y - (down + 0.5) * images.SIZE
    assert "accepted" in {row["status"] for row in rows}
    reference, new = map(registration.read, (on_map.inputs[0], again))
    np.testing.assert_array_equal(new.transform, reference.transform)
    assert new.grey.shape == reference.grey.shape and new.crs == reference.crs
    assert new.mask[:8].all() and new.mask[:, :18].all()  # not in the sensed image
    points = registration.pick(reference.grey, 30, sensed=new.values)
    left = registration.register(reference.values, new.values, points, refine="lsm")
    assert left.accepted.mean() > 0.8 and left.rmse_t < 0.02


@rasterio
def test_points_may_be_map_coordinates(on_map, tmp_path, monkeypatch):
    asked = {}
    no_work(monkeypatch, "register", images.result(2), asked)
    points = tmp_path / "points.csv"
    points.write_text("% x, y\n700303, 9319397\n700603, 9319697\n")
    assert on_map.run("--map-points", points) == 0
    np.testing.assert_allclose(asked["points"], [(50, 100), (100, 50)])
    np.testing.assert_allclose(asked["offset"], (-20, -10))


@rasterio
def test_one_image_on_the_map_and_one_not_are_refused_unless_an_offset_is_given(
    on_map, folder, capsys
):
    on_map.inputs[1] = images.save(folder)[1]
    assert "has no georeference" in on_map.ended(capsys)
    assert on_map.run("--offset", 0, 0) == 0
    assert "(7.5 m) east" in capsys.readouterr().out


@rasterio
def test_a_pixel_size_that_the_file_states_is_not_given_again(on_map, capsys):
    message = on_map.ended(capsys, "--pixel-size", 10)
    assert "its pixels have 6 x 6 m: leave out --pixel-size" in message


def test_without_rasterio_no_image_is_promised(register, outputs, capsys, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    message = register.refused(capsys, "--resampled", outputs / "new.tif")
    assert "--resampled needs rasterio: pip install" in message


@rasterio
def test_without_rasterio_a_geotiff_says_how_to_get_it(on_map, capsys, monkeypatch):
    from pgm_lab.io import geotiff

    monkeypatch.setattr(geotiff, "installed", lambda: False)
    assert geotiff.INSTALL in on_map.ended(capsys)
