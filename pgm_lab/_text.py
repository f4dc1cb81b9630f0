"""Text files that people write: their lines and words, and what is odd about them."""

import codecs
import os
import re
import stat
from pathlib import Path

from pgm_lab._files import printable

# float() would take nan, 1_000 and Arabic digits too; Fortran writes 1.5D-3
ODD = re.compile(r"[^-+.0-9eEdD ]")
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?", re.ASCII)
FORTRAN = str.maketrans("dD", "ee")
_BLANK = str.maketrans(",;", "  ")
_COMMENT = re.compile(r"%[^\n]*")
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")
_DECIMAL_COMMA = re.compile(r"[^\s;,]*\d,\d[^\s;]*")
_MINUS = str.maketrans(dict.fromkeys("\u2212\u2010\u2011\u2012\u2013\u2014\uff0d", "-"))
_UNIT = re.compile(r"([-+.\deE]+)(mm|cm|m|um|µm|px|°|rad|deg)", re.ASCII | re.I)


def lines(path: Path) -> list[str]:
    """Return the lines of a file, without comments."""
    text = _read(path).replace("\r\n", "\n").replace("\r", "\n")
    if "%" in text:  # a comment, as for MATLAB
        text = _COMMENT.sub("", text)
    return text.split("\n")


def words(lines: list[str]) -> list[list[str]]:
    """Split lines at white space, commas and semicolons."""
    return [line.split() for line in "\n".join(lines).translate(_BLANK).split("\n")]


def decimal_comma(line: str) -> str | None:
    """Return the first number with a decimal comma, if something else separates.

    "5,1,2" are three columns and so are "5, 1, 2"; in "5;1,2" and "5 1,2" a comma can
    only be a decimal one. Semicolons at the end are those of a matrix in MATLAB.
    """
    line = line.strip().rstrip(";").strip()
    other = ";" in line or (len(line.split()) > 1 and not re.search(r"\s,|,\s", line))
    found = _DECIMAL_COMMA.search(line) if other else None
    return found[0] if found else None


def hint(row: list[str], place: int, ids: int, first: bool) -> str:
    """Say what to do about a word that is no number."""
    word = row[place]
    numbers = sum(1 for one in row if NUMBER.fullmatch(one))
    if NUMBER.fullmatch(word.translate(_MINUS)):
        return ": its minus is a typographic one; write the - of the keyboard"
    if word.startswith(("#", "//", "!")):
        return "; a comment begins with %"
    if word.lower() in ("nan", "inf", "-inf", "+inf", "-", "na", "n/a"):
        return "; leave out the line of what was not measured"
    if unit := _UNIT.fullmatch(word):
        return f"; write it without the unit {unit[2]}"
    if first and numbers < len(row) / 2:
        return "; a heading needs a % before it"
    if place < ids:
        digits = re.search(r"[1-9][0-9]*", word)
        return (
            "; ids must be whole numbers: call it"
            f" {digits[0] if digits else 1}, for example, in every file"
        )
    return ""


def _read(path: Path) -> str:
    name = printable(path)
    try:
        mode = os.stat(path).st_mode
        data = path.read_bytes() if stat.S_ISREG(mode) else b""
    except FileNotFoundError:
        raise FileNotFoundError(f"{name}: there is no such file") from None
    except OSError as error:  # no permission, a circle of links, too long a name
        raise OSError(f"{name}: it cannot be read ({error.strerror})") from None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(f"{name}: this is a folder, not a file")
    if not stat.S_ISREG(mode):
        reason = "this is a pipe or a device, not a file; save the numbers as a file"
        raise OSError(f"{name}: {reason}")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    if found := _BINARY.search(data):
        raise ValueError(
            f"{name}, line {data.count(10, 0, found.start()) + 1}: this is not text,"
            " but perhaps a picture, a spreadsheet or a .mat file; save the numbers as"
            " plain text"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # a comment in an older code page
        return data.decode("latin-1")
