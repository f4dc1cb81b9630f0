"""pgm_lab match: its options, and photos and points that are none."""

import os

import numpy as np
import pytest
from PIL import Image

from pgm_lab import matching, observations, report
from pgm_lab.command import _match, main
from pgm_lab.report import _figures
from tests.command.calls import NO_IMAGE, drawn, image
from tests.command.conftest import no_work
from tests.matching import photos


def test_reports_and_tables_are_those_of_the_functions(
    match, outputs, capsys, monkeypatch
):
    monkeypatch.setattr(_figures, "png", drawn)
    files = [outputs / name for name in ("a.html", "b.txt", "all.csv", "image.txt")]
    html, text, table, seen = files
    words = ("--number", 20, "--template", 15, "--report", html, "--report", text)
    words += ("--csv", table, "--image-csv", seen, "--pixel-size", 0.005)
    assert match.run(*words) == 0
    settings = {"number": 20, "template": 15}
    found = matching.match(*match.inputs, **settings)
    assert np.sum(found.accepted) > 15
    about = "From left.png, right.png."
    short = report.matching.text(found, about=about, short=True)
    assert capsys.readouterr().out == short + "\n"
    more = {"settings": settings, "about": about}
    for path, expected in (
        (html, report.matching.html(found, *match.inputs, **more)),
        (text, report.matching.text(found, **more)),
        (table, found.csv()),
    ):
        assert path.read_text(encoding="utf-8") == expected
    # What pgm_lab adjust reads
    chosen = found.chosen, {2: found}, photos.SIZE, 0.005
    expected = observations.from_matches(*chosen, left=1)
    rows = np.loadtxt(seen, delimiter=",", comments="%")
    np.testing.assert_array_equal(rows[:, :2].T, (expected.point, expected.photo))
    np.testing.assert_array_equal(rows[:, 2:4], expected.xy)


def test_the_options_reach_the_matching(match, tmp_path, monkeypatch):
    asked = {}
    no_work(monkeypatch, "match", photos.result(2), asked)
    words = "--template 31 --start wide --search 61 --colour grey --threshold 0.8"
    words += " --ratio 0.85 --back 0.5 --quality 0.4"
    chosen = tmp_path / "points.csv"
    chosen.write_text("% column, row\n100.5, 80\n120 90.25\n")
    assert match.run(*words.split(), "--points", chosen) == 0
    np.testing.assert_array_equal(asked.pop("points"), [(100.5, 80), (120, 90.25)])
    assert asked == {
        "template": 31, "start": "wide", "search": 61, "colour": "grey",
        "threshold": 0.8, "ratio": 0.85, "back": 0.5, "least_quality": 0.4,
    }  # fmt: skip


def test_every_setting_is_an_argument_of_the_function_and_an_option(capsys):
    known = set(matching.match.__kwdefaults__) | {"points"}
    assert set(report.matching.SETTINGS) == known - {"shape"}  # one for each point
    assert set(_match.OPTIONS) == known - {"shape", "points", "number"}
    with pytest.raises(SystemExit):
        main(["match", "--help"])
    text = capsys.readouterr().out
    for name in known - {"shape"}:
        assert f"--{name.removeprefix('least_')}" in text


@pytest.mark.parametrize(
    "words, message",
    [
        (["--csv", "r.xlsx"], "the name must end in .csv, .txt"),
        (["--image-csv", "r.csv"], "--image-csv needs --pixel-size"),
        (["--points", "p.csv", "--number", "9"], "not allowed with argument --points"),
        (["--number", "0"], "'0' is not a whole number from 1"),
        (["--template", "20"], "'20' is even"),
        (["--quality", "nan"], "'nan' is not a number from 0 to 1"),
        (["--pixel-size", "0,01"], "a decimal needs a point"),
    ],
)
def test_a_wrong_call_ends_with_2(match, capsys, words, message):
    assert message in match.refused(capsys, *words)


def test_colours_are_refused_in_words_of_the_command_and_taken_where_asked(
    match, quick, capsys
):
    colours = np.stack([photos.pair()[0]] * 3, axis=-1)
    colours[..., 0] //= 2
    image(colours)(match.inputs[0])
    message = match.ended(capsys)
    assert "has colours" in message and "--colour grey turns it into" in message
    assert match.run("--colour", "grey") == 0


# --- Photos that are none, or do not fit ---

NOISE = np.random.default_rng(5).integers(0, 255, photos.SIZE[::-1], np.uint8)
BAD = NO_IMAGE | {"no overlap": (image(NOISE), "")}


@pytest.mark.parametrize("spoil, words", BAD.values(), ids=BAD.keys())
def test_a_bad_photo_ends_with_1_and_leaves_nothing(
    match, outputs, tmp_path, capsys, spoil, words
):
    """With points given, too: picking them fails where there is nothing to pick."""
    spoil(match.inputs[1])
    points = tmp_path / "points.txt"
    points.write_text("100 80\n120 90\n")
    files = ("--report", outputs / "r.html", "--csv", outputs / "r.csv")
    for where in (("--number", 20), ("--points", points)):
        assert words in match.ended(capsys, *where, *files)
    assert os.listdir(outputs) == []


def test_photos_of_two_sizes_make_no_image_file(match, outputs, capsys):
    Image.fromarray(photos.pair()[1][:-5]).save(match.inputs[1])
    files = ("--report", outputs / "r.txt", "--image-csv", outputs / "i.txt")
    message = match.ended(capsys, *files, "--pixel-size", 0.005, "--number", 9)
    assert "(240, 200) and (240, 195) pixels" in message and "--image-csv" in message
    assert os.listdir(outputs) == []


def test_without_any_match_the_commonest_reason_is_said(
    match, outputs, capsys, monkeypatch
):
    status = ["ambiguous", "below threshold", "ambiguous"]
    no_work(monkeypatch, "match", photos.result(3, status))
    message = match.ended(capsys, "--report", outputs / "r.html")
    assert 'none of 3 points was found; most often (2) the reason is "ambig' in message
    assert "Take a larger template" in message
    assert os.listdir(outputs) == []


@pytest.mark.parametrize("name", ["match", "register"])
def test_bad_points_end_with_1(request, outputs, tmp_path, capsys, name):
    call, points = request.getfixturevalue(name), tmp_path / "points.csv"
    files = ("--points", points, "--report", outputs / "r.html")
    assert "points.csv: there is no such file" in call.ended(capsys, *files)
    points.write_text("column row\n10 20\n")
    message = call.ended(capsys, *files)
    assert "points.csv, line 1: 'column' is not a number; a heading" in message
    assert os.listdir(outputs) == []
