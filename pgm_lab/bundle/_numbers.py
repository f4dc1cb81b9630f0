"""Tables of numbers in text files: read with the line of every error, written whole."""

import codecs
import os
import re
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

Source = str | os.PathLike

# float() would take nan, 1_000 and Arabic digits too; Fortran writes 1.5D-3
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eEdD][-+]?\d+)?", re.ASCII)
_FORTRAN = str.maketrans("dD", "ee")
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f]")
_LARGEST_ID = 2**53  # floats hold every whole number up to here


class Row(NamedTuple):
    """A line that holds something besides a comment."""

    line: int  # from 1
    fields: list[str]
    comma: bool  # whether commas separate the fields, or were meant as decimal ones


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


def table(path: Source, what: str, columns: tuple, optional: int = 0) -> Table:
    """Read a table; no row has its last `optional` columns, or every row."""
    path, rows = read_rows(path)
    allowed = {len(columns), len(columns) - optional}
    allowed &= {len(rows[0].fields)} or allowed
    for row in rows:
        if len(row.fields) not in (allowed or {len(columns)}):
            hint = ". A comma separates columns; decimals need a point"
            reason = (
                f"{len(row.fields)} column(s), where {what} have {len(columns)}:"
                f" {' '.join(columns)}{hint if row.comma else ''}"
            )
            fail(path, row.line, reason)
    return as_table(path, rows)


def read_rows(path: Source) -> tuple[Path, list[Row]]:
    """Read what stands in the lines of a text file, proven to be numbers."""
    path = Path(path)
    text = _text(path).replace("\r\n", "\n").replace("\r", "\n")
    rows = []
    for line, content in enumerate(text.split("\n"), start=1):
        content = content.partition("%")[0]  # a comment, as for MATLAB
        if fields := content.replace(",", " ").replace(";", " ").split():
            rows.append(Row(line, fields, "," in content))
    if not rows:
        fail(path, None, "the file holds no numbers")
    for row in rows:
        for field in row.fields:
            if not _NUMBER.fullmatch(field):
                hint = "; a heading needs a % before it" if row is rows[0] else ""
                fail(path, row.line, f"{field[:40]!r} is not a number{hint}")
    return path, rows


def as_table(path: Path, rows: list[Row]) -> Table:
    """Turn rows of equal length into numbers."""
    numbers = [float(f.translate(_FORTRAN)) for row in rows for f in row.fields]
    values = np.array(numbers).reshape(len(rows), -1)
    found = Table(path, np.array([row.line for row in rows]), values)
    found.refuse(~np.all(np.isfinite(values), axis=1), "a number is too large")
    return found


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
