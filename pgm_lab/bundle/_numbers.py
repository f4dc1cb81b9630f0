"""Tables of numbers in text files: read with the line of every error, written whole."""

import codecs
import os
import re
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

Source = str | os.PathLike

# float() would take nan, 1_000 and Arabic digits too; Fortran writes 1.5D-3
_ODD = re.compile(r"[^-+.0-9eEdD ]")
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?", re.ASCII)
_FORTRAN = str.maketrans("dD", "ee")
_BLANK = str.maketrans(",;", "  ")
_COMMENT = re.compile(r"%[^\n]*")
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")
_LARGEST_ID = 2**53  # floats hold every whole number up to here


class Content(NamedTuple):
    """The numbers of a file, however many stand in each line."""

    path: Path
    line: np.ndarray  # (rows,) from 1, of the lines with any
    columns: np.ndarray  # (rows,) how many
    comma: np.ndarray  # (rows,) bool: commas between them, or meant as decimal ones
    numbers: np.ndarray  # (sum of count,)

    def table(self) -> "Table":
        """Return the rows, which are known to be of equal length."""
        values = self.numbers.reshape(len(self.line), -1)
        found = Table(self.path, self.line, values)
        found.refuse(~np.all(np.isfinite(values), axis=1), "a number is too large")
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
        broken = (ids != np.round(ids)) | (np.abs(ids) > _LARGEST_ID)
        self.refuse(broken, f"{name} {{}}: an id must be a whole number", ids)
        return ids.astype(np.int64)

    def refuse_repeated(self, keys: np.ndarray, what: str, *values: np.ndarray) -> None:
        """Refuse a row whose key stands in a row above it."""
        _, first, which = np.unique(keys, return_index=True, return_inverse=True)
        above = first[which]
        again = above != np.arange(len(keys))
        self.refuse(again, f"{what} line {{}} already", *values, self.line[above])


def fail(path: Path, line: int | None, reason: str) -> NoReturn:
    """Raise a ValueError that names the file, the line and the reason."""
    raise ValueError(f"{path}{'' if line is None else f', line {line}'}: {reason}")


def read_table(path: Source, what: str, columns: tuple, optional: int = 0) -> Table:
    """Read a table; no row has its last `optional` columns, or every row."""
    content = read_numbers(path)
    first = content.columns[0]
    wanted = first if first == len(columns) - optional else len(columns)
    wrong = np.flatnonzero(content.columns != wanted)
    if len(wrong):
        row = wrong[0]
        hint = ". A comma separates columns; decimals need a point"
        reason = (
            f"{content.columns[row]} column(s), where {what} have {wanted}:"
            f" {' '.join(columns[:wanted])}{hint if content.comma[row] else ''}"
        )
        fail(content.path, content.line[row], reason)
    return content.table()


def read_numbers(path: Source) -> Content:
    """Read a text file that holds numbers and comments."""
    path = Path(path)
    text = _text(path).replace("\r\n", "\n").replace("\r", "\n")
    if "%" in text:  # a comment, as for MATLAB
        text = _COMMENT.sub("", text)
    lines = text.split("\n")
    fields = [line.split() for line in text.translate(_BLANK).split("\n")]
    line = np.flatnonzero(np.array([len(row) for row in fields]))
    if not len(line):
        fail(path, None, "the file holds no numbers")
    rows = [fields[i] for i in line]
    return Content(
        path,
        line + 1,
        np.array([len(row) for row in rows]),
        np.array(["," in lines[i] for i in line]),
        _floats(path, line + 1, rows),
    )


def _floats(path: Path, line: np.ndarray, rows: list[list[str]]) -> np.ndarray:
    """Turn the words of all lines into numbers, or say which word is none."""
    words = " ".join(word for row in rows for word in row)
    if not _ODD.search(words):
        try:
            return np.array(list(map(float, words.translate(_FORTRAN).split())))
        except ValueError:
            pass  # found below
    for number, row in zip(line, rows):
        for word in row:
            if not _NUMBER.fullmatch(word):
                hint = "; a heading needs a % before it" if row is rows[0] else ""
                fail(path, number, f"{word[:40]!r} is not a number{hint}")
    raise AssertionError("a word is odd, but each is a number")


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FileNotFoundError(f"{path}: there is no such file") from None
    except IsADirectoryError:
        raise IsADirectoryError(f"{path}: this is a folder, not a file") from None
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    if found := _BINARY.search(data):
        reason = (
            "this is not text, but perhaps a picture, a spreadsheet or a .mat file;"
            " save the numbers as plain text"
        )
        fail(path, data.count(b"\n", 0, found.start()) + 1, reason)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # a comment in an older code page
        return data.decode("latin-1")


def save(path: Source, text: str, *, overwrite: bool = False) -> None:
    """Write a text file whole or not at all: beside its place first, then renamed."""
    path = Path(path)
    if not overwrite:
        refuse_existing(path)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def refuse_existing(*paths: Source) -> None:
    """Raise FileExistsError if one of the files is there."""
    for path in map(Path, paths):
        if path.exists():
            raise FileExistsError(f"{path} is there already, and is not overwritten")
