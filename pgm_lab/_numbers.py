"""Tables of numbers in text files: read, with the line of every error, and written."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from pgm_lab import _text
from pgm_lab._files import printable

Source = str | os.PathLike

LARGEST_ID = 2**53 - 1  # the next one and the one after are the same float


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
        reason = f"{name} {{}}: an id must be a whole number"
        self.refuse(ids != np.round(ids), reason, ids)
        reason = f"{name} {{}}: an id must be below 2^53, about 9e15; number anew"
        self.refuse(np.abs(ids) > LARGEST_ID, reason, ids)
        return ids.astype(np.int64)

    def refuse_repeated(self, keys: np.ndarray, what: str, *values: np.ndarray) -> None:
        """Refuse a row whose key stands in a row above it."""
        _, first, which = np.unique(keys, return_index=True, return_inverse=True)
        above = first[which]
        again = above != np.arange(len(keys))
        self.refuse(again, f"{what} line {{}} already", *values, self.line[above])


def fail(path: Path, line: int | None, reason: str) -> NoReturn:
    """Raise a ValueError that names the file, the line and the reason."""
    place = "" if line is None else f", line {line}"
    raise ValueError(f"{printable(path)}{place}: {reason}")


def read_table(
    path: Source, what: str, columns: tuple, ids: int = 1, without: str = ""
) -> Table:
    """Read a table whose first columns are ids.

    Parameters
    ----------
    path : str or path
    what : str
        What stands in it, for messages.
    columns : tuple of str
        Their names.
    ids : int
        How many of them are ids.
    without : str
        What to do without the last two columns, which are then asked for; if empty, no
        row has them, or every row.
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
        if content.comma[row]:
            reason += ". A comma separates columns; decimals need a point"
        elif without and found in (short, short + 1):
            reason += f". {without}"
        fail(content.path, content.line[row], reason)
    table = content.table()
    if np.all(content.comma) and np.all(table.values == np.round(table.values)):
        reason = (
            "no number of this file has decimals: if its commas are decimal commas,"
            " write points, and separate columns by blanks"
        )
        # ids are whole anyway: only where something measured follows them
        if ids == 2:
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


def read_numbers(path: Source, ids: int = 0) -> Content:
    """Read a text file that holds numbers and comments, its first columns ids."""
    path = Path(path)
    lines = _text.lines(path)
    rows = _text.words(lines)
    line = np.flatnonzero(np.array([len(row) for row in rows]))
    if not len(line):
        fail(path, None, "the file holds no numbers")
    for i in line:
        if "," in lines[i] and (number := _text.decimal_comma(lines[i])):
            reason = (
                f"{number[:40]!r} has a decimal comma: write a point in its place, in"
                " the whole file"
            )
            fail(path, int(i) + 1, reason)
    rows = [rows[i] for i in line]
    return Content(
        path,
        line + 1,
        np.array([len(row) for row in rows]),
        np.array(["," in lines[i] for i in line]),
        _floats(path, line + 1, rows, ids),
    )


def _floats(
    path: Path, line: np.ndarray, rows: list[list[str]], ids: int
) -> np.ndarray:
    """Turn the words of all lines into numbers, or say which word is none."""
    words = " ".join(word for row in rows for word in row)
    if not _text.ODD.search(words):
        try:
            return np.array(list(map(float, words.translate(_text.FORTRAN).split())))
        except ValueError:
            pass  # found below
    for number, row in zip(line, rows):
        for place, word in enumerate(row):
            if not _text.NUMBER.fullmatch(word):
                hint = _text.hint(row, place, ids, first=row is rows[0])
                fail(path, number, f"{word[:40]!r} is not a number{hint}")
    raise AssertionError("a word is odd, but each is a number")
