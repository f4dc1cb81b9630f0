"""pgm_lab adjust: its options, and each bad file with its line and what to do about it.

No traceback, one line, no half report. A case of BAD is which file, what happens to its
text, the line of the message (None: no line), and words that must be in it.
"""

import os
import re

import numpy as np
import pytest

from pgm_lab import bundle, datasets, report
from pgm_lab.camera import PARAMETERS
from pgm_lab.command import main
from tests.networks import jaicov_9x50, real

INTERIOR, EXTERIOR, POINTS, IMAGE = range(4)
ABOUT = "From interior.txt, exterior.txt, points.txt, image.txt."


@pytest.fixture(scope="module")
def network():
    return real()


@pytest.fixture(scope="module")
def texts(network, tmp_path_factory):
    """The text of the four good files, with a heading in the first line of each."""
    paths = bundle.write(network, tmp_path_factory.mktemp("good"))
    return [path.read_text(encoding="utf-8") for path in paths]


# --- Options ---


def test_the_options_reach_the_adjustment(adjust, outputs, capsys):
    path = outputs / "r.txt"
    words = "--estimate c,x0,y0,K1 --lens forward --datum photos --sigma 0.0004"
    assert adjust.run(*words.split(), "--report", path) == 0
    again = bundle.read(*adjust.inputs, lens="forward", sigma=0.0004)
    result = bundle.adjust(again, ("c", "x0", "y0", "K1"), "photos")
    whole = path.read_text(encoding="utf-8")
    assert whole == report.text(result, about=ABOUT)
    assert "modelled forward" in whole and "projection centres" in whole
    short = report.text(result, about=ABOUT, short=True)
    assert capsys.readouterr().out == short + "\n"
    assert adjust.run("--estimate", "none") == 0
    assert "35  mm     held" in capsys.readouterr().out


def test_snooping_rejects_what_the_function_does(adjust, network, capsys):
    assert adjust.run("--snoop", "--estimate", "c,x0,y0,K1,K2,K3") == 0
    found = bundle.snoop(network, ("c", "x0", "y0", "K1", "K2", "K3"))
    assert len(found.removed) > 0
    rays = f"Data snooping rejected {len(found.removed)} rays"
    assert rays in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, message",
    [
        (["--estimate", "c,f"], "'f' is not one of c,x0,y0,K1"),
        (["--estimate", "c,K1,c"], "c stands there twice"),
        (["--sigma", "0"], "'0' is not a number above zero"),
    ],
)
def test_a_wrong_call_ends_with_2(adjust, capsys, words, message):
    assert message in adjust.refused(capsys, *words)


def test_the_help_names_the_columns_of_each_file(capsys):
    with pytest.raises(SystemExit):
        main(["adjust", "--help"])
    text = " ".join(capsys.readouterr().out.split())
    for columns in ("photo omega phi kappa XL YL ZL", "point photo x y sx sy"):
        assert columns in text
    assert "scale bars and several cameras have no place in the files" in text


# --- Adjustments that fail ---


def test_an_impossible_adjustment_names_what_is_missing(
    adjust, network, outputs, capsys
):
    lone = np.flatnonzero((network.point == 4) & (network.photo > 0))
    bundle.write(network.without(lone), adjust.inputs[0].parent, overwrite=True)
    message = adjust.ended(capsys, "--report", outputs / "r.html")
    assert "point 5" in message and "two rays" in message
    assert os.listdir(outputs) == []


def test_what_does_not_converge_is_not_reported(adjust, outputs, capsys, monkeypatch):
    """The start is far away, and nearly no iteration is granted."""
    original = bundle.adjust
    few = lambda *a, **k: original(*a, max_iterations=2, **k)  # noqa: E731
    monkeypatch.setattr(bundle, "adjust", few)
    message = adjust.ended(capsys, "--report", outputs / "r.html")
    assert "did not converge (too many iterations after 2 iterations)" in message
    assert "that x points right and y up" in message
    assert os.listdir(outputs) == []


def test_too_many_photos_for_the_memory_are_refused(adjust, quick, capsys, monkeypatch):
    """8 matrices of 64 x 64 floats for nine photos."""
    needed = 8 * 8 * 64**2
    for memory, code in ((needed, 0), (needed - 1, 1)):
        sizes = {"SC_PAGE_SIZE": 1, "SC_PHYS_PAGES": memory}
        monkeypatch.setattr(os, "sysconf", sizes.get, raising=False)
        assert adjust.run() == code
    assert "9 photos need about 0 GB" in capsys.readouterr().err


def test_an_adjustment_that_fails_names_the_image_first(adjust, capsys):
    """With c held, y counted downwards ends in a rank defect, or nowhere."""
    path = adjust.inputs[IMAGE]
    head, *rows = path.read_text().splitlines()
    rows = [row.split() for row in rows]
    rows = [" ".join([*row[:3], repr(-float(row[3])), *row[4:]]) for row in rows]
    path.write_text("\n".join([head, *rows]))
    message = adjust.ended(capsys)
    said = "pgm_lab adjust: The image coordinates seem to count y downwards"
    assert message.startswith(said)


# --- Bad files, beyond what tests/bundle/test_files.py tries ---


def line(number, text):
    """Replace one line."""

    def change(whole):
        lines = whole.split("\n")
        lines[number - 1] = text
        return "\n".join(lines)

    return change


def word(number, place, text):
    """Replace one word of one line."""

    def change(whole):
        words = whole.split("\n")[number - 1].split()
        words[place] = text
        return line(number, " ".join(words))(whole)

    return change


def decimal_commas(separator):
    return lambda whole: "".join(
        one if one.startswith("%") else one.replace(" ", separator).replace(".", ",")
        for one in whole.splitlines(keepends=True)
    )


def columns(number):
    """Keep so many columns."""
    return lambda whole: "\n".join(
        " ".join(one.split()[:number]) for one in whole.split("\n")[1:]
    )


COMMA, POINT = "has a decimal comma: write a point in its place", "decimals need a poin"
COLUMN = "35,1\n" + "0\n" * 9
SIX = "1,1,4,2,1,0\n1,2,3,2,1,5\n"
BAD = {
    "comma and semicolon": (IMAGE, decimal_commas(";"), 2, COMMA),
    "comma in a column": (INTERIOR, lambda text: COLUMN, 10, POINT),
    "comma that makes six columns": (
        IMAGE,
        lambda text: SIX,
        1,
        "if its commas are decimal commas",
    ),
    "DSC1 in image": (IMAGE, word(2, 1, "DSC1"), 2, "call it 1"),
    "file name as id": (EXTERIOR, word(3, 0, "IMG_0042.JPG"), 3, "call it 42"),
    "en dash": (IMAGE, word(2, 2, "\u20134.2"), 2, "write the - of the keyboard"),
    "a unit": (INTERIOR, word(2, 0, "35mm"), 2, "without the unit mm"),
    "# comment": (IMAGE, line(4, "# a comment"), 4, "a comment begins with %"),
    "escape sequence": (POINTS, word(4, 2, "\x1b[31m"), 4, "this is not text"),
    "no sx, sy": (IMAGE, columns(4), 1, "--sigma"),
    "c in metres": (INTERIOR, word(2, 0, "0.035"), 2, "is c in metres?"),
    "utf-16 without a mark": (POINTS, lambda text: "1\0 2\0", 1, "save the numbers as"),
}
AT = {"c in metres": (IMAGE, 2)}  # the first file that contradicts it


@pytest.mark.parametrize("which, change, at, words", BAD.values(), ids=BAD.keys())
def test_a_bad_file(adjust, texts, outputs, capsys, request, which, change, at, words):
    adjust.inputs[which].write_bytes(change(texts[which]).encode("utf-8"))
    which, at = AT.get(request.node.callspec.id, (which, at))
    both = ("--report", outputs / "r.html", "--report", outputs / "r.txt")
    message = adjust.ended(capsys, *both)
    place = "" if at is None else f", line {at}"
    assert f"{adjust.inputs[which]}{place}: " in message and words in message
    assert os.listdir(outputs) == []


# --- The sample ---


def test_the_sample_gives_what_another_program_found(capsys):
    """JAICOV adjusted the same network."""
    files = [datasets.folder() / "sample" / name for name in bundle.files.NAMES]
    assert main(["adjust", *map(str, files), "--lens", "forward"]) == 0
    output = capsys.readouterr()
    data = jaicov_9x50()
    assert f"redundancy {data.redundancy}" in output.out and output.err == ""
    for name, value in zip(PARAMETERS[:3], data.adjusted_interior):
        shown = re.search(rf"^{name} +(-?[0-9.]+)", output.out, re.M)[1]
        assert float(shown) == pytest.approx(value, abs=5.1e-5)


def test_the_sample_is_the_network_of_the_tables():
    data = jaicov_9x50()
    files = [datasets.folder() / "sample" / name for name in bundle.files.NAMES]
    network = bundle.read(*files, lens="forward")
    for name in ("exteriors", "points", "photo", "point", "xy", "sigma"):
        assert np.array_equal(getattr(network, name), getattr(data, name)), name
    assert np.array_equal(network.interior[0], data.interior)
    readme = (datasets.folder() / "README.md").read_text(encoding="utf-8")
    assert all(f"`sample/{path.name}`" in readme for path in files)
