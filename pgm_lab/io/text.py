"""Tables of numbers in text files: read, naming the line of every error, and written.

Numbers are separated by white space, commas or semicolons; % begins a comment.
"""

import codecs
import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from pgm_lab.io import files

Source = str | os.PathLike

LARGEST_ID = 2**53 - 1  # the next one and the one after are the same float
LARGEST = 1e30  # squares and products of larger numbers overflow
MAX_BYTES = 2**28  # of a file: its words take some ten times as much memory

# float() would take nan, 1_000 and Arabic digits too; Fortran writes 1.5D-3
_ODD = re.compile(r"[^-+.0-9eEdD ]")
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eEdD][-+]?\d+)?", re.ASCII)
_FORTRAN = str.maketrans("dD", "ee")
_BLANK = str.maketrans(",;", "  ")
_COMMENT = re.compile(r"%[^\n]*")
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")
_DECIMAL_COMMA = re.compile(r"(?<![^\s;,])[^\s;,]*\d,\d[^\s;]*")
_MINUS = str.maketrans(dict.fromkeys("\u2212\u2010\u2011\u2012\u2013\u2014\uff0d", "-"))
_UNIT = re.compile(r"([-+.\deE]+)(mm|cm|m|um|µm|px|°|rad|deg)", re.ASCII | re.I)


class Content(NamedTuple):
    """The numbers of a file, however many stand in each line."""

    path: Path
    line: np.ndarray  # (rows,) from 1, of the lines with any
    columns: np.ndarray  # (rows,) how many
    comma: np.ndarray  # (rows,) bool: commas between them, or meant as decimal ones
    numbers: np.ndarray  # (sum of columns,)

    def table(self) -> "Table":
        """Return the rows, which are known to be of equal length."""
        values = self.numbers.reshape(len(self.line), -1)
        found = Table(self.path, self.line, values)
        large = ~np.all(np.abs(values) <= LARGEST, axis=1)
        found.refuse(large, "a number is too large, or was written wrong")
        return found


class Table(NamedTuple):
    """Numbers of a file, and where they stand in it."""

    path: Path
    line: np.ndarray  # (rows,) from 1
    values: np.ndarray  # (rows, columns)

    def refuse(self, bad: np.ndarray, reason: str, *values: np.ndarray) -> None:
        """Raise `reason`, with the values of the first bad row in it, if any is."""
        if np.any(bad):
            first = int(np.argmax(bad))
            stand = (f"{value[first]:.16g}" for value in values)
            fail(self.path, self.line[first], reason.format(*stand))

    def ids(self, column: int, name: str) -> np.ndarray:
        """Return a column of whole numbers."""
        ids = self.values[:, column]
        reason = f"{name} {{}}: an id must be a whole number"
        self.refuse(ids != np.round(ids), reason, ids)
        reason = f"{name} {{}}: an id must be below 2^53, about 9e15; number anew"
        self.refuse(np.abs(ids) > LARGEST_ID, reason, ids)
        return ids.astype(np.int64)

    def refuse_repeated(self, keys: np.ndarray, what: str, *values: np.ndarray) -> None:
        """Refuse a row whose key occurs in a row above it."""
        _, first, which = np.unique(keys, return_index=True, return_inverse=True)
        above = first[which]
        again = above != np.arange(len(keys))
        self.refuse(again, f"{what} line {{}} already", *values, self.line[above])


def fail(path: Path, line: int | None, reason: str) -> NoReturn:
    """Raise a ValueError that names the file, the line and the reason."""
    where = "" if line is None else f", line {line}"
    raise ValueError(f"{files.printable(path)}{where}: {reason}")


# --- Tables ---


def read_table(
    path: Source, what: str, columns: Sequence[str], ids: int = 1, without: str = ""
) -> Table:
    """Read a table whose first columns are ids.

    `what` is the content of the table, for messages. With two ids, the last two columns
    may be missing from all rows; `without`, where given, tells what to do then instead.
    """
    content = read_numbers(path, ids)
    short = len(columns) - 2
    may_be_short = ids == 2 and not without
    wanted = short if may_be_short and content.columns[0] == short else len(columns)
    wrong = np.flatnonzero(content.columns != wanted)
    if len(wrong):
        row = wrong[0]
        found = content.columns[row]
        reason = (
            f"{found} column(s), where {what} have {wanted}:"
            f" {' '.join(columns[:wanted])}"
        )
        if found < wanted and 2 * len(wrong) <= len(content.columns):
            reason += ", as other lines do: is it cut off?"
        elif content.comma[row]:
            reason += ". A comma separates columns; decimals need a point"
        elif without and found in (short, short + 1):
            reason += f". {without}"
        fail(content.path, content.line[row], reason)
    table = content.table()
    whole = np.all(content.comma) and np.all(table.values == np.round(table.values))
    if whole and ids == 2:  # ids are whole anyway: only what is measured tells
        reason = (
            "no number of this file has decimals: if its commas are decimal commas,"
            " write points, and separate columns by blanks"
        )
        fail(content.path, content.line[0], reason)
    return table


def written(columns: Sequence[str], numbers: np.ndarray, words: np.ndarray) -> str:
    """Return rows of numbers as CSV, with an id from 0 before and a word behind."""
    lines = [",".join(columns)]
    for i, (row, word) in enumerate(zip(numbers.tolist(), words)):
        # repr has the fewest digits that are read as the same number again
        cells = ("" if np.isnan(one) else repr(one) for one in row)
        lines.append(",".join([str(i), *cells, str(word)]))
    return "\n".join([*lines, ""])


# --- Numbers ---


def read_numbers(path: Source, ids: int = 0) -> Content:
    """Read a text file that holds numbers and comments, its first columns ids."""
    lines = _lines(path)
    path = Path(path)
    split = [line.split() for line in "\n".join(lines).translate(_BLANK).split("\n")]
    used = [i for i, words in enumerate(split) if words]
    if not used:
        fail(path, None, "the file holds no numbers")
    for i in used:
        if "," in lines[i] and (number := decimal_comma(lines[i])):
            reason = (
                f"{number[:40]!r} has a decimal comma: write a point in its place, in"
                " the whole file"
            )
            fail(path, i + 1, reason)
    rows = [split[i] for i in used]
    line = np.array(used) + 1
    return Content(
        path,
        line,
        np.array([len(row) for row in rows]),
        np.array(["," in lines[i] for i in used]),
        _floats(path, line, rows, ids),
    )


def decimal_comma(line: str) -> str | None:
    """Return the first number with a decimal comma, if something else separates.

    "5,1,2" are three columns and so are "5, 1, 2"; in "5;1,2" and "5 1,2" a comma can
    only be a decimal one. Semicolons at the end are those of a matrix in MATLAB.
    """
    line = line.strip().rstrip(";").strip()
    other = ";" in line or (len(line.split()) > 1 and not re.search(r"\s,|,\s", line))
    found = _DECIMAL_COMMA.search(line) if other else None
    return found[0] if found else None


def _floats(
    path: Path, line: np.ndarray, rows: list[list[str]], ids: int
) -> np.ndarray:
    """Numbers of the words of all lines; an error names the first that is none."""
    words = " ".join(word for row in rows for word in row)
    if not _ODD.search(words):
        try:
            return np.array(list(map(float, words.translate(_FORTRAN).split())))
        except ValueError:
            pass  # found below
    for number, row in zip(line, rows):
        for k, word in enumerate(row):
            if not _NUMBER.fullmatch(word):
                hint = _hint(row, k, ids, first=row is rows[0])
                fail(path, number, f"{word[:40]!r} is not a number{hint}")
    raise AssertionError("a word is odd, but each is a number")


def _hint(row: list[str], k: int, ids: int, first: bool) -> str:
    """What to do about the k-th word of a row, which is not a number."""
    word = row[k]
    numbers = sum(1 for one in row if _NUMBER.fullmatch(one))
    if _NUMBER.fullmatch(word.translate(_MINUS)):
        return ": its minus is a typographic one; write the - of the keyboard"
    if _NUMBER.fullmatch(word.strip("\"'")):
        return "; write it without quotation marks"
    if word.startswith(("#", "//", "!")):
        return "; a comment begins with %"
    if word.lower() in ("nan", "inf", "-inf", "+inf", "-", "na", "n/a"):
        return "; leave out the line of what was not measured"
    if unit := _UNIT.fullmatch(word):
        return f"; write it without the unit {unit[2]}"
    if first and numbers < len(row) / 2:
        return "; a heading needs a % before it"
    if k < ids:
        digits = re.search(r"[1-9][0-9]*", word)
        return (
            "; ids must be whole numbers: call it"
            f" {digits[0] if digits else 1}, for example, in every file"
        )
    return ""


def _lines(path: Source) -> list[str]:
    """Return the lines of a text file, without comments."""
    name = files.printable(path)
    data = files.content(path, name, MAX_BYTES + 1, empty=True)
    if len(data) > MAX_BYTES:
        raise ValueError(
            f"{name}: the file has more than {MAX_BYTES >> 20} MB, too much for a table"
            " of numbers; is it the right one?"
        )
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = data.decode("utf-16", errors="replace")
    elif found := _BINARY.search(data):
        raise ValueError(
            f"{name}, line {data.count(10, 0, found.start()) + 1}: this is not text,"
            " but perhaps a picture, a spreadsheet or a .mat file; save the numbers as"
            " plain text"
        )
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:  # a comment in an older code page
            text = data.decode("latin-1")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    return _COMMENT.sub("", text).split("\n")
