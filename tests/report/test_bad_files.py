"""Bad files on the command line: each ends with 1, its place, and what to do about it.

No traceback, one line, no half report. A case is which file, what happens to its text,
the line of the message (None: no line), and words that must stand in it.
"""

import codecs
import os
import socket
import sys

import matplotlib.pyplot as plt
import pytest

from pgm_lab import bundle
from pgm_lab.report import __main__ as command
from pgm_lab.report import _figures
from tests.networks import real

INTERIOR, EXTERIOR, POINTS, IMAGE = range(4)


@pytest.fixture(scope="module")
def texts(tmp_path_factory):
    """The text of the four good files, with a heading in the first line of each."""
    paths = bundle.write(real(), tmp_path_factory.mktemp("good"))
    return [path.read_text(encoding="utf-8") for path in paths]


@pytest.fixture
def files(texts, tmp_path):
    folder = tmp_path / "network"
    folder.mkdir()
    paths = [folder / name for name in bundle.files.NAMES]
    for path, text in zip(paths, texts):
        path.write_text(text, encoding="utf-8")
    return paths


@pytest.fixture
def reports(tmp_path):
    folder = tmp_path / "reports"
    folder.mkdir()
    return folder


def line(number, text):
    """Replace one line."""

    def change(whole):
        lines = whole.split("\n")
        lines[number - 1] = text
        return "\n".join(lines)

    return change


def word(number, place, text):
    """Replace one word of one line; from the format if it has {}."""

    def change(whole):
        lines = whole.split("\n")
        words = lines[number - 1].split()
        words[place] = text.format(words[place])
        lines[number - 1] = " ".join(words)
        return "\n".join(lines)

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
    "comma, interior": (INTERIOR, decimal_commas(" "), 2, COMMA),
    "comma, exterior": (EXTERIOR, decimal_commas(" "), 2, COMMA),
    "comma, points": (POINTS, decimal_commas(" "), 2, COMMA),
    "comma, image": (IMAGE, decimal_commas(" "), 2, COMMA),
    "comma and ;, interior": (INTERIOR, decimal_commas(";"), 2, COMMA),
    "comma and ;, exterior": (EXTERIOR, decimal_commas(";"), 2, COMMA),
    "comma and ;, points": (POINTS, decimal_commas(";"), 2, COMMA),
    "comma and ;, image": (IMAGE, decimal_commas(";"), 2, COMMA),
    "comma and tab": (IMAGE, decimal_commas("\t"), 2, COMMA),
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
        lambda text: line(2, "1 50 1.5 2 0.001 0.001")(text),
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


def ended(capsys, *arguments):
    """Return the one line with which the command fails."""
    assert command.main([str(one) for one in arguments]) == 1
    output = capsys.readouterr()
    assert output.out == "" and "Traceback" not in output.err
    (message,) = output.err.splitlines()
    assert message.isprintable() and len(message) < 700
    return message


@pytest.mark.parametrize("which, change, at, words", BAD.values(), ids=BAD.keys())
def test_a_bad_file(files, texts, reports, capsys, request, which, change, at, words):
    files[which].write_bytes(change(texts[which]).encode("utf-8"))
    which, at = AT.get(request.node.callspec.id, (which, at))
    both = ("--report", reports / "r.html", "--report", reports / "r.txt")
    message = ended(capsys, *files, *both)
    place = f"{files[which]}: " if at is None else f"{files[which]}, line {at}: "
    assert place in message and words in message
    assert os.listdir(reports) == []


def test_there_are_some_sixty_of_them_of_all_four_files():
    assert len(BAD) >= 60
    assert {which for which, *_ in BAD.values()} == {0, 1, 2, 3}


@pytest.mark.parametrize(
    "change, words",
    [
        (lambda x, y: (x / 1000, y / 1000), "be in metres, not in millimetres"),
        (lambda x, y: (x / 0.03, y / 0.03), "be in pixels or micrometres"),
        (lambda x, y: (y, x), "have x and y exchanged"),
    ],
    ids=["metres", "pixels", "exchanged"],
)
def test_another_unit_or_frame_is_the_headline(files, texts, capsys, change, words):
    rows = [one.split() for one in texts[IMAGE].splitlines()[1:]]
    for row in rows:
        row[2:4] = map(repr, change(*map(float, row[2:4])))
    files[IMAGE].write_text("\n".join(map(" ".join, rows)))
    assert command.main([str(path) for path in files]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert text.startswith("Bundle adjustment =================")
    headline, _, rest = text.partition("1 What to look at")
    assert words in headline and "better than stated" not in headline
    first = rest.replace("-", "").split(":")[0].strip()
    assert first == "Image coordinates"


def test_an_adjustment_that_fails_names_the_image_first(files, texts, capsys):
    """With c held, y counted downwards ends in a rank defect, or nowhere."""
    rows = [one.split() for one in texts[IMAGE].splitlines()[1:]]
    for row in rows:
        row[3] = repr(-float(row[3]))
    files[IMAGE].write_text("\n".join(map(" ".join, rows)))
    message = ended(capsys, *files)
    assert message.startswith(
        "python -m pgm_lab.report: The image coordinates seem to count y downwards"
    )


# ------------------------------------------------ files that are none, and odd names

POSIX = pytest.mark.skipif(os.name == "nt", reason="no such files there")


@POSIX
@pytest.mark.parametrize("which", range(4))
def test_a_pipe_is_refused_and_not_waited_for(files, tmp_path, capsys, which):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    files[which] = pipe
    message = ended(capsys, *files)
    assert f"{pipe}: this is a pipe or a device" in message
    assert "save its content as a file" in message


@POSIX
def test_other_files_that_are_none(files, tmp_path, capsys, monkeypatch):
    assert "pipe or a device" in ended(capsys, *files[:3], "/dev/null")
    monkeypatch.chdir(tmp_path)  # the name of a socket is short
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("socket")
        assert "socket: " in ended(capsys, "socket", *files[1:])
    assert "this is a folder" in ended(capsys, tmp_path, *files[1:])


@POSIX
def test_a_circle_of_links_is_no_input_and_no_report(files, reports, capsys):
    circle = reports / "r.txt"
    circle.symlink_to(circle)
    assert f"{circle}: it cannot be read (" in ended(capsys, circle, *files[1:])
    with pytest.raises(SystemExit) as end:
        command.main([*map(str, files), "--report", str(circle / "r.txt")])
    message = capsys.readouterr().err
    assert end.value.code == 2 and "Traceback" not in message
    assert "no file can have this name" in message
    with pytest.raises(SystemExit):
        command.main([*map(str, files), "--report", str(circle)])
    assert "it exists already; --force replaces it" in capsys.readouterr().err
    assert os.path.islink(circle)


@POSIX
def test_control_characters_of_a_name_never_reach_the_terminal(
    files, tmp_path, reports, capsys
):
    odd = tmp_path / "points\x1b[31m\x07\u202e\n.txt"
    odd.write_text("1 2 x\n")
    message = ended(capsys, *files[:2], odd, files[3])
    assert "points\\x1b[31m\\x07\\u202e\\n.txt, line 1: 'x' is not a" in message
    odd.unlink()
    assert "there is no such file" in ended(capsys, *files[:2], odd, files[3])
    for name in ("r\x1b[31m.pdf", "no\x1b[31m/r.txt", "\x1b[31m.txt"):
        (reports / "\x1b[31m.txt").write_text("old")
        with pytest.raises(SystemExit):
            command.main([*map(str, files), "--report", str(reports / name)])
        assert "\x1b" not in capsys.readouterr().err
    with pytest.raises(SystemExit):
        command.main([*map(str, files), "\x1b[31m"])
    assert "\x1b" not in capsys.readouterr().err


@POSIX
def test_a_name_that_is_no_text_comes_into_the_report_all_the_same(
    files, reports, capsys, monkeypatch
):
    """Bytes of a name that are no UTF-8 cannot be written as UTF-8 either."""
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    odd = os.path.join(os.path.dirname(files[0]), os.fsdecode(b"caf\xe9\x1b.txt"))
    os.replace(files[0], odd)
    page = reports / "r.html"
    call = [odd, *map(str, files[1:]), "--estimate", "c", "--report", str(page)]
    assert command.main(call) == 0
    output = capsys.readouterr()
    assert "From caf\\udce9\\x1b.txt, exterior.txt" in output.out
    assert "caf\\udce9\\x1b.txt" in page.read_text(encoding="utf-8")


@POSIX
def test_who_reads_only_the_head_gets_no_traceback(files, capsys, monkeypatch):
    """Nor when the output is closed at last, and what is left would be written."""
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w", encoding="utf-8") as output:
        monkeypatch.setattr(sys, "stdout", output)
        assert command.main([*map(str, files), "--estimate", "c"]) == 0
    assert capsys.readouterr().err == ""


def test_utf_16_and_a_mark_of_the_byte_order_are_read(files, texts, capsys):
    files[POINTS].write_bytes(codecs.BOM_UTF16_LE + texts[POINTS].encode("utf-16-le"))
    files[IMAGE].write_bytes(codecs.BOM_UTF8 + texts[IMAGE].encode())
    assert command.main([*map(str, files), "--estimate", "c"]) == 0
