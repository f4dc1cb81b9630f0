"""The command line of a matching: exit codes, messages, files it leaves."""

import functools
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from pgm_lab import matching, observations
from pgm_lab.io import files as _files
from pgm_lab.matching import __main__ as command
from pgm_lab.report import _match_figures
from pgm_lab.report import matching as report
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
from tests.matching import photos

CALL = Call(command.main, "python -m pgm_lab.matching")
run, ended, refused = CALL.run, CALL.ended, CALL.refused


@pytest.fixture
def files(tmp_path):
    """Two photos, in a folder with a space in its name."""
    folder = tmp_path / "my photos"
    folder.mkdir()
    return photos.save(folder)


@pytest.fixture
def reports(tmp_path):
    folder = tmp_path / "reports"
    folder.mkdir()
    return folder


@pytest.fixture
def quick(monkeypatch):
    """A match and a page that take no time, for what comes around them."""
    monkeypatch.setattr(report, "html", lambda *_, **__: "the page")
    return no_match(monkeypatch, photos.result())


def no_match(monkeypatch, found, asked=None):
    """Have the command find what is given, and note what was asked."""

    @functools.wraps(matching.match)
    def match(left, right, **options):
        if asked is not None:
            asked.update(options, shapes=(left.shape, right.shape))
        return found

    monkeypatch.setattr(matching, "match", match)
    return found


# ------------------------------------------------------------------- a good run


def test_the_short_report_is_printed_and_the_long_ones_written(
    files, reports, capsys, monkeypatch
):
    monkeypatch.setattr(_match_figures, "png", drawn)
    html, text, table = (reports / name for name in ("a.html", "b.TXT", "all.csv"))
    call = (*files, "--number", 20, "--template", 15)
    assert run(*call, "--report", html, "--report", text, "--csv", table) == 0
    output = capsys.readouterr()
    settings = {"number": 20, "template": 15}
    found = matching.match(*files, **settings)
    about = "From left.png, right.png."
    words = {"settings": settings, "about": about}
    assert np.sum(found.accepted) > 15
    assert output.err == ""  # no bar where nobody watches
    assert output.out == report.text(found, about=about, short=True) + "\n"
    assert text.read_text(encoding="utf-8") == report.text(found, **words)
    assert html.read_text(encoding="utf-8") == report.html(found, *files, **words)
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
sys.argv[0] = "matching"
import runpy
runpy.run_module("pgm_lab.matching", run_name="__main__", alter_sys=True)
"""
    call = [sys.executable, "-c", code, *map(str, files), "--number", "10"]
    call += ["--report", str(reports / "r.html")]
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(call, capture_output=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"Image matching") and done.stderr == b""
    assert os.listdir(reports) == ["r.html"]


def test_the_image_file_is_what_a_bundle_reads(files, reports, capsys):
    path = reports / "image.txt"
    call = ("--number", 20, "--image-csv", path, "--pixel-size", 0.005)
    assert run(*files, *call) == 0
    found = matching.match(*files, number=20)
    seen = observations.from_matches(
        found.chosen, {2: found}, photos.SIZE, 0.005, left=1
    )
    rows = np.loadtxt(path, delimiter=",", comments="%")
    np.testing.assert_array_equal(rows[:, :2].T, (seen.point, seen.photo))
    np.testing.assert_array_equal(rows[:, 2:4], seen.xy)


def test_photos_of_two_sizes_make_no_image_file(files, reports, capsys):
    Image.fromarray(photos.pair()[1][:-5]).save(files[1])
    outputs = ("--report", reports / "r.txt", "--image-csv", reports / "i.txt")
    message = ended(capsys, *files, *outputs, "--pixel-size", 0.005, "--number", 9)
    assert "(240, 200) and (240, 195) pixels" in message and "--image-csv" in message
    assert os.listdir(reports) == []


def test_the_options_reach_the_matching(files, tmp_path, monkeypatch, capsys):
    asked = {}
    no_match(monkeypatch, photos.result(2), asked)
    options = "--template 31 --start pyramid --search 61 --colour grey --threshold 0.8"
    options += " --ratio 0.85 --back 0.5 --quality 0.4"
    chosen = tmp_path / "points.csv"
    chosen.write_text("% column, row\n100.5, 80\n120 90.25\n")
    assert run(*files, *options.split(), "--points", chosen) == 0
    np.testing.assert_array_equal(asked.pop("points"), [(100.5, 80), (120, 90.25)])
    assert asked == {
        "template": 31, "start": "pyramid", "search": 61, "colour": "grey",
        "threshold": 0.8, "ratio": 0.85, "back": 0.5, "least_quality": 0.4,
        "shapes": ((200, 240), (200, 240)),
    }  # fmt: skip


def test_every_setting_is_an_argument_of_the_function_and_an_option():
    known = set(matching.match.__kwdefaults__) | {"points"}
    assert set(command.SETTINGS) == known - {"shape"}  # a matrix for each point
    text = command.parser().format_help()
    for name in command.SETTINGS:
        assert f"--{name.removeprefix('least_')}" in text


def test_colours_are_refused_in_words_of_the_command_and_taken_where_asked(
    files, quick, capsys
):
    colours = np.stack([photos.pair()[0]] * 3, axis=-1)
    colours[..., 0] //= 2
    Image.fromarray(colours).save(files[0])
    message = ended(capsys, *files)
    assert "has colours" in message and "--colour grey turns it into" in message
    assert run(*files, "--colour", "grey") == 0


# ------------------------------------------------------------- photos that are none


def grey_noise(seed):
    """What shows nothing that another photo shows."""
    rng = np.random.default_rng(seed)
    return rng.integers(0, 255, photos.SIZE[::-1], np.uint8)


BAD = {
    "missing": (lambda path: path.unlink(), "there is no such file"),
    "empty": (lambda path: path.write_bytes(b""), "the file is empty"),
    "text": (lambda path: path.write_text("1 2 3\n" * 9), "not an image"),
    "a table": (lambda path: path.write_text("<html></html>"), "not an image"),
    "truncated": (truncated_jpeg, "the image is damaged"),
    "a folder": (lambda path: (path.unlink(), path.mkdir()), "this is a folder"),
    "huge header": (lambda path: path.write_bytes(huge_header()), "right"),
    "one pixel": (image(np.zeros((1, 1), np.uint8)), ""),
    "one row": (image(np.zeros((1, 240), np.uint8)), ""),
    "featureless": (image(np.full((200, 240), 99, np.uint8)), ""),
    "no overlap": (image(grey_noise(5)), ""),
    "nothing but NaN": (tiff(np.full((200, 240), np.nan, np.float32)), "no data"),
}


@pytest.mark.parametrize("spoil, words", BAD.values(), ids=BAD.keys())
@pytest.mark.parametrize("start", ["features", "pyramid"])
def test_a_bad_photo_ends_with_1_and_one_line_and_leaves_nothing(
    files, reports, capsys, spoil, words, start
):
    """With points given, too: picking them fails where there is nothing to pick."""
    spoil(files[1])
    outputs = ("--report", reports / "r.html", "--csv", reports / "r.csv")
    message = ended(capsys, *files, "--start", start, "--number", 20, *outputs)
    assert words in message
    points = reports.parent / "points.txt"
    points.write_text("100 80\n120 90\n")
    message = ended(capsys, *files, "--start", start, "--points", points, *outputs)
    assert words in message
    assert os.listdir(reports) == []


def test_a_photo_that_holds_nan_in_part_is_matched_elsewhere(files, capsys):
    values = photos.pair()[1].astype(np.float32)
    values[:, :60] = np.nan
    tiff(values)(files[1])
    assert run(*files, "--number", 20) == 0
    assert "points were found" in capsys.readouterr().out


def test_the_same_file_twice_is_refused(files, reports, capsys, tmp_path):
    call = ("--report", reports / "r.html")
    assert "are the same file" in ended(capsys, files[0], files[0], *call)
    link = tmp_path / "link.png"
    link.symlink_to(files[0])
    assert "are the same file" in ended(capsys, files[0], link, *call)
    assert os.listdir(reports) == []


def test_a_copy_of_the_photo_is_matched_and_called_the_same_photo(files, capsys):
    files[1].write_bytes(files[0].read_bytes())
    assert run(*files, "--number", 20) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "No parallax: Between the photos a usual point moved by less than" in said
    assert "Is it the same photo twice?" in said


def test_without_any_match_the_commonest_reason_is_said(
    files, reports, capsys, monkeypatch
):
    status = ["ambiguous", "below threshold", "ambiguous"]
    no_match(monkeypatch, photos.result(3, status))
    message = ended(capsys, *files, "--report", reports / "r.html")
    assert 'none of 3 points was found; most often (2) the reason is "ambig' in message
    assert "Take a larger template" in message
    assert os.listdir(reports) == []


# ------------------------------------------------------------------- points as text


POINTS = {
    "not a number": ("10 20\n30 x\n", 2, "'x' is not a number"),
    "a heading": ("column row\n10 20\n", 1, "a heading needs a % before it"),
    "three columns": ("1 10 20\n", 1, "3 column(s), where points have 2: column row"),
    "one column": ("10\n", 1, "1 column(s)"),
    "decimal comma": ("10,5 20,5\n", 1, "decimal comma"),
    "nan": ("10 20\nnan 5\n", 2, "leave out the line"),
    "empty": ("", None, "the file holds no numbers"),
    "a picture": ("\x89PNG\0\n", 1, "this is not text"),
}


@pytest.mark.parametrize("text, line, words", POINTS.values(), ids=POINTS.keys())
def test_bad_points_end_with_1_and_their_line(
    files, reports, tmp_path, capsys, text, line, words
):
    points = tmp_path / "points.csv"
    points.write_bytes(text.encode("latin-1"))
    call = ("--points", points, "--report", reports / "r.html")
    message = ended(capsys, *files, *call)
    place = f"{points}: " if line is None else f"{points}, line {line}: "
    assert place in message and words in message
    assert os.listdir(reports) == []


def test_missing_points_end_with_1(files, tmp_path, capsys):
    message = ended(capsys, *files, "--points", tmp_path / "none.csv")
    assert "none.csv: there is no such file" in message


# -------------------------------------------------------------------- wrong calls


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--report", "r.pdf"], "the name must end in .html, .htm, .txt"),
        (["--report", "nowhere/r.html"], "there is no folder nowhere"),
        (["--csv", "r.xlsx"], "the name must end in .csv, .txt"),
        (["--image-csv", "r.csv"], "--image-csv needs --pixel-size"),
        (["--points", "p.csv", "--number", "9"], "--points and --number exclude"),
        (["--number", "0"], "'0' is not a whole number from 1"),
        (["--number", "2.5"], "'2.5' is not a whole number from 1"),
        (["--template", "20"], "'20' is even"),
        (["--search", "x"], "'x' is not a whole number"),
        (["--start", "guess"], "invalid choice: 'guess'"),
        (["--colour", "blue"], "invalid choice: 'blue'"),
        (["--threshold", "1.5"], "'1.5' is not a number from 0 to 1"),
        (["--quality", "nan"], "'nan' is not a number from 0 to 1"),
        (["--pixel-size", "0,01"], "a decimal needs a point"),
        (["--mask"], "unrecognized arguments"),
    ],
)
def test_a_wrong_call_ends_with_2(files, capsys, arguments, message):
    assert message in refused(capsys, *files, *arguments)


def test_one_photo_is_too_few(files, capsys):
    assert "right" in refused(capsys, files[0])


def test_existing_files_are_replaced_only_by_force(files, reports, quick, capsys):
    for option, name in (("--report", "r.html"), ("--csv", "r.csv")):
        path = reports / name
        path.write_text("mine")
        message = refused(capsys, *files, option, path)
        assert "it exists already; --force replaces it" in message
        assert path.read_text() == "mine"
        assert run(*files, option, path, "--force") == 0
        assert path.read_text(encoding="utf-8") != "mine"
        capsys.readouterr()


def test_a_photo_is_never_replaced_and_no_output_by_another(files, reports, capsys):
    path = files[0].rename(files[0].with_suffix(".txt"))
    message = refused(capsys, path, files[1], "--csv", path, "--force")
    assert f"this is the input {path}" in message
    both = ("--report", reports / "r.txt", "--csv", reports / "R.TXT")
    assert "is the same file" in refused(capsys, *files, *both)


def test_a_folder_that_may_not_be_written_is_named_before_the_work(
    files, reports, capsys, monkeypatch
):
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    message = refused(capsys, *files, "--csv", reports / "r.csv")
    assert "nothing may be written into the folder" in message


# ------------------------------------------------------------- what goes wrong later


@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("where", ["matching", "drawing", "writing", "renaming"])
def test_nothing_half_written_is_left(
    files, reports, quick, capsys, monkeypatch, where, how
):
    """An older report stays as it was."""
    old = reports / "r.txt"
    old.write_text("old")
    functions = {"matching": (matching, "match"), "drawing": (command.report, "html")}
    break_(monkeypatch, where, how, functions)
    outputs = ("--report", old, "--report", reports / "r.html", "--force")
    assert HOW[how][1] in ended(capsys, *files, *outputs)
    assert os.listdir(reports) == ["r.txt"] and old.read_text() == "old"


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="no such pipes there")
def test_who_reads_only_the_head_gets_no_traceback(files):
    call = [sys.executable, "-m", "pgm_lab.matching", *map(str, files)]
    reader, writer = os.pipe()
    os.close(reader)
    call += ["--number", "5"]
    done = subprocess.run(call, stdout=writer, stderr=subprocess.PIPE, timeout=120)
    os.close(writer)
    assert done.stderr == b"" and done.returncode == 0


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
    assert "a\\x1b[31m" in ended(capsys, odd, odd)


def test_the_readme_shows_a_call_that_is_understood():
    text = (_files.Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    (words,) = re.findall(r"python -m pgm_lab\.matching (.+)\n", text)
    options = command.parser().parse_args(words.split())
    assert options.report and options.left != options.right
