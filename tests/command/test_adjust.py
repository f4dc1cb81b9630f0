"""pgm_lab adjust: its options, and each bad file with its line and what to do about it.

No traceback, one line, no half report. A case of BAD is which file, what happens to its
text, the line of the message (None: no line), and words that must be in it.
"""

import codecs
import os
import re
import sys

import numpy as np
import pytest

from pgm_lab import bundle, datasets, report
from pgm_lab.camera import PARAMETERS
from pgm_lab.command import main
from tests.command.conftest import no_work
from tests.networks import real

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
        (["--estimate", ""], "'' is not one of"),
        (["--lens", "sideways"], "invalid choice: 'sideways'"),
        (["--datum", "fixed"], "invalid choice: 'fixed'"),
        (["--sigma", "0"], "'0' is not a number above zero"),
        (["--sigma", "nan"], "'nan' is not a number above zero"),
        (["--sigma", "x"], "'x' is not a number above zero"),
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


def changed(path, change):
    """Change x and y (strings to numbers and back) of all rays of a file."""
    head, *rows = path.read_text().splitlines()
    rows = [row.split() for row in rows]
    for row in rows:
        row[2:4] = map(repr, change(*map(float, row[2:4])))
    path.write_text("\n".join([head, *map(" ".join, rows)]))


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda x, y: (x / 1000, y / 1000), "be in metres, not in millimetres"),
        (lambda x, y: (x / 0.03, y / 0.03), "be in pixels or micrometres"),
        (lambda x, y: (y, x), "have x and y exchanged"),
    ],
    ids=["metres", "pixels", "exchanged"],
)
def test_another_unit_or_frame_is_the_headline(adjust, capsys, change, words):
    changed(adjust.inputs[IMAGE], change)
    assert adjust.run() == 0
    text = " ".join(capsys.readouterr().out.split())
    headline, _, rest = text.partition("1 What to look at first")
    assert words in headline and "better than stated" not in headline
    assert rest.replace("-", "").split(":")[0].strip() == "Image coordinates"


def test_an_adjustment_that_fails_names_the_image_first(adjust, capsys):
    """With c held, y counted downwards ends in a rank defect, or nowhere."""
    changed(adjust.inputs[IMAGE], lambda x, y: (x, -y))
    message = adjust.ended(capsys)
    said = "pgm_lab adjust: The image coordinates seem to count y downwards"
    assert message.startswith(said)


# --- Bad files ---


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
        lines = whole.split("\n")
        words = lines[number - 1].split()
        words[place] = text
        return line(number, " ".join(words))(whole)

    return change


def everywhere(old, new):
    return lambda whole: "".join(
        one if one.startswith("%") else one.replace(old, new)
        for one in whole.splitlines(keepends=True)
    )


def decimal_commas(separator):
    return lambda whole: everywhere(".", ",")(everywhere(" ", separator)(whole))


def columns(number):
    """Keep so many columns."""
    return lambda whole: "\n".join(
        " ".join(one.split()[:number]) for one in whole.split("\n")[1:]
    )


COMMA = "has a decimal comma: write a point in its place"
ID = "ids must be whole numbers"
MINUS = "write the - of the keyboard"
SIGMA = "--sigma"
TEN = "has ten in a row or a column: c x0 y0"

BAD = {
    # decimal commas, in every file and with every separator of a spreadsheet
    **{
        f"comma and {separator!r}, {which}": (
            which,
            decimal_commas(separator),
            2,
            COMMA,
        )
        for separator in " ;\t"
        for which in (INTERIOR, EXTERIOR, POINTS, IMAGE)
    },
    "one decimal comma": (POINTS, word(7, 2, "1,5"), 7, COMMA),
    "thousands": (POINTS, word(7, 2, "1,234.5"), 7, COMMA),
    "comma and comma": (POINTS, decimal_commas(","), 2, "decimals need a point"),
    "comma in a column": (
        INTERIOR,
        lambda text: "35,1\n" + "0\n" * 9,
        10,
        "decimals need a point",
    ),
    "comma, four columns": (
        IMAGE,
        lambda text: decimal_commas(" ")(columns(4)(text)),
        1,
        COMMA,
    ),
    "comma that makes six columns": (
        IMAGE,
        lambda text: "1,1,4,2,1,0\n1,2,3,2,1,5\n",
        1,
        "if its commas are decimal commas",
    ),
    # ids
    "id DSC1": (EXTERIOR, word(2, 0, "DSC1"), 2, ID),
    "id DSC1 of a photo in image": (IMAGE, word(2, 1, "DSC1"), 2, "call it 1"),
    "id P7 in points": (POINTS, word(8, 0, "P7"), 8, "call it 7"),
    "file name as id": (EXTERIOR, word(3, 0, "IMG_0042.JPG"), 3, "call it 42"),
    "id with letters after": (POINTS, word(3, 0, "12a"), 3, ID),
    "id 1.5": (POINTS, word(3, 0, "1.5"), 3, "an id must be a whole number"),
    "id 2^53": (POINTS, word(3, 0, "9007199254740992"), 3, "below 2^53"),
    "id 2^53 + 1": (POINTS, word(3, 0, "9007199254740993"), 3, "below 2^53"),
    "id 1e300": (EXTERIOR, word(3, 0, "1e300"), 3, "below 2^53"),
    "point twice": (POINTS, word(3, 0, "1"), 3, "point 1 stands in line 2 already"),
    "photo twice": (EXTERIOR, word(3, 0, "1"), 3, "photo 1 stands in line 2 already"),
    "ray twice": (IMAGE, word(3, 0, "1"), 3, "was measured in photo 1 in line 2"),
    "unknown point": (IMAGE, word(3, 0, "99"), 3, "point 99 is not in points.txt"),
    "unknown photo": (IMAGE, word(3, 1, "99"), 3, "photo 99 is not in exterior.txt"),
    "photo before point": (
        IMAGE,
        line(2, "1 50 1.5 2 0.001 0.001"),
        2,
        "the columns are point photo x y sx sy",
    ),
    # words that are no numbers
    "unicode minus": (EXTERIOR, word(2, 2, "\u22120.5"), 2, MINUS),
    "en dash": (IMAGE, word(2, 2, "\u20134.23"), 2, MINUS),
    "hyphen": (POINTS, word(2, 1, "\u20101"), 2, MINUS),
    "a unit": (INTERIOR, word(2, 0, "35mm"), 2, "without the unit mm"),
    "degree signs": (EXTERIOR, word(2, 1, "84.2°"), 2, "without the unit °"),
    "nan": (IMAGE, word(5, 2, "nan"), 5, "leave out the line"),
    "inf": (POINTS, word(5, 2, "inf"), 5, "leave out the line"),
    "a dash for nothing": (IMAGE, word(5, 2, "-"), 5, "leave out the line"),
    "a heading": (POINTS, line(1, "id X Y Z"), 1, "a heading needs a % before it"),
    "a heading of a camera": (INTERIOR, line(1, "c x0 y0"), 1, "a heading needs a %"),
    "# comment": (IMAGE, line(4, "# a comment"), 4, "a comment begins with %"),
    "// comment": (IMAGE, line(4, "// a comment"), 4, "a comment begins with %"),
    "letters": (IMAGE, word(4, 2, "three"), 4, "'three' is not a number"),
    "letter l for 1": (IMAGE, word(4, 2, "l.5"), 4, "'l.5' is not a number"),
    "two points": (IMAGE, word(4, 2, "1.2.3"), 4, "'1.2.3' is not a number"),
    "underscore": (POINTS, word(4, 2, "1_0"), 4, "'1_0' is not a number"),
    "hexadecimal": (POINTS, word(4, 2, "0x1F"), 4, "'0x1F' is not a number"),
    "quotation marks": (POINTS, word(4, 0, '"3"'), 4, "is not a number"),
    "arabic digits": (POINTS, word(4, 2, "\u0661\u0662"), 4, "is not a number"),
    "escape sequence": (POINTS, word(4, 2, "\x1b[31m"), 4, "this is not text"),
    "C1 control": (POINTS, word(4, 2, "\x9b31m"), 4, "'\\x9b31m' is not a number"),
    "a very long word": (POINTS, word(4, 2, "x" * 10**5), 4, "is not a number"),
    "too large": (POINTS, word(4, 2, "1e999"), 4, "a number is too large"),
    # columns
    "no sx, sy": (IMAGE, columns(4), 1, SIGMA),
    "no sy": (IMAGE, columns(5), 1, SIGMA),
    "a row without sx, sy": (IMAGE, line(6, "6 1 2.5 1.5"), 6, SIGMA),
    "a row too short": (POINTS, line(6, "5 1 2"), 6, "point X Y Z"),
    "a row too long": (POINTS, line(6, "5 1 2 3 4"), 6, "object points have 4"),
    "four columns": (
        EXTERIOR,
        line(3, "1 1.29 0.06 3.05"),
        3,
        "4 column(s), where exterior orientations",
    ),
    "broken off": (IMAGE, lambda text: text[:-12], 451, "image coordinates have 6"),
    "nine of a camera": (INTERIOR, line(2, "35 0 0 0 0 0 0 0 0"), 2, TEN),
    "two cameras": (INTERIOR, line(3, "35 0 0 0 0 0 0 0 0 0"), 3, TEN),
    # values
    "c = 0": (INTERIOR, word(2, 0, "0"), 2, "c = 0 must be above zero"),
    "c below 0": (INTERIOR, word(2, 0, "-35"), 2, "c = -35 must be above zero"),
    "c in metres": (INTERIOR, word(2, 0, "0.035"), 2, "is c in metres?"),
    "degrees": (EXTERIOR, word(2, 3, "84.2"), 2, "radians are expected, not degrees"),
    "sigma 0": (IMAGE, word(5, 4, "0"), 5, "must be above zero"),
    "sigma below 0": (IMAGE, word(5, 5, "-0.001"), 5, "must be above zero"),
    "pixels": (IMAGE, word(5, 2, "1936"), 5, "are expected, not pixels"),
    # what is no text, or none of ours
    "empty": (POINTS, lambda text: "", None, "the file holds no numbers"),
    "comments only": (POINTS, lambda text: "% nothing", None, "holds no numbers"),
    "a picture": (POINTS, lambda text: "\x89PNG\n\x1a\n\0", 3, "this is not text"),
    "utf-16 without a mark": (POINTS, lambda text: "1\0 2\0", 1, "save the numbers as"),
    "html": (POINTS, lambda text: "<html>\n" + text, 1, "'<html>' is not a number"),
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


def test_utf_16_and_a_mark_of_the_byte_order_are_read(adjust, texts):
    for which, mark, code in (
        (POINTS, codecs.BOM_UTF16_LE, "utf-16-le"),
        (IMAGE, codecs.BOM_UTF8, "utf-8"),
    ):
        adjust.inputs[which].write_bytes(mark + texts[which].encode(code))
    assert adjust.run("--estimate", "c") == 0


@pytest.mark.skipif(os.name == "nt", reason="no such names there")
def test_a_name_that_is_no_text_comes_into_the_report_all_the_same(
    adjust, outputs, capsys, monkeypatch
):
    """Bytes of a name that are no UTF-8 cannot be written as UTF-8 either."""
    if sys.platform == "darwin":
        pytest.skip("its file system has no such names")
    no_work(monkeypatch, "adjust")
    odd = os.path.join(adjust.inputs[0].parent, os.fsdecode(b"caf\xe9\x1b.txt"))
    os.replace(adjust.inputs[0], odd)
    page = outputs / "r.txt"
    words = [odd, *adjust.inputs[1:]]
    assert adjust.run("--report", page, inputs=words) == 0
    assert "From caf\\udce9\\x1b.txt, exterior.txt" in capsys.readouterr().out
    assert "caf\\udce9\\x1b.txt" in page.read_text(encoding="utf-8")


# --- The sample ---


def test_the_sample_gives_what_another_program_found(capsys):
    """JAICOV adjusted the same network."""
    files = [datasets.folder() / "sample" / name for name in bundle.files.NAMES]
    assert main(["adjust", *map(str, files), "--lens", "forward"]) == 0
    output = capsys.readouterr()
    data = datasets.jaicov_9x50()
    assert f"redundancy {data.redundancy}" in output.out and output.err == ""
    for name, value in zip(PARAMETERS[:3], data.adjusted_interior):
        shown = re.search(rf"^{name} +(-?[0-9.]+)", output.out, re.M)[1]
        assert float(shown) == pytest.approx(value, abs=5.1e-5)


def test_the_sample_is_the_network_of_the_tables():
    data = datasets.jaicov_9x50()
    files = [datasets.folder() / "sample" / name for name in bundle.files.NAMES]
    network = bundle.read(*files, lens="forward")
    for name in ("exteriors", "points", "photo", "point", "xy", "sigma"):
        assert np.array_equal(getattr(network, name), getattr(data, name)), name
    assert np.array_equal(network.interior[0], data.interior)
    readme = (datasets.folder() / "README.md").read_text(encoding="utf-8")
    assert all(f"`sample/{path.name}`" in readme for path in files)


def test_the_guide_names_the_columns_of_the_four_files():
    readme = (datasets.folder().parent / "docs" / "own_network.md").read_text(
        encoding="utf-8"
    )
    files = bundle.files
    for names in (PARAMETERS, files.EXTERIOR, files.POINT, files.RAY):
        assert f"| {', '.join(names)}" in readme
