"""The files in ``data/``: found, undamaged, and read."""

import csv
import hashlib
from pathlib import Path

import numpy as np

from pgm_lab import _validate


def rows(name: str) -> list[dict[str, str]]:
    """Rows of a CSV file in ``data/``, or of a folder of them, as dictionaries.

    Parameters
    ----------
    name : str
        File name, for example "harintaka2020_table1.csv", or a folder such as "audit":
        then the rows of all its files, in the order of their names.

    Raises
    ------
    FileNotFoundError
        If the file is missing; the message says how to get it back.
    ValueError
        If the file is damaged: its checksum differs, or a row has a wrong length.

    Examples
    --------
    >>> sorted({row["verdict"] for row in rows("audit")})
    ['corrected', 'not derivable', 'reproduced']
    """
    _validate.text(name, "name")
    if (folder() / name).is_dir():
        files = sorted((folder() / name).glob("*.csv"))
        return [row for file in files for row in rows(f"{name}/{file.name}")]
    with verified(name).open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file, strict=True)
        found = list(reader)
    for number, row in enumerate(found, start=2):
        if None in row or None in row.values():
            raise ValueError(
                f"data/{name} is damaged: the number of fields in row {number} differs"
                f" from that of the header. Restore it with git checkout -- data/{name}"
            )
    return found


def columns(name: str, *names: str) -> np.ndarray:
    """Columns (rows, columns) of a CSV file in ``data/``, as numbers."""
    return np.array([[float(row[column]) for column in names] for row in rows(name)])


def folder() -> Path:
    """The folder ``data/`` of the clone that pgm_lab was installed from."""
    path = Path(__file__).resolve().parents[2] / "data"
    if not path.is_dir():
        raise FileNotFoundError(
            f"the data folder {path} is missing: pgm_lab works from a clone of its"
            " repository; install it there with pip install -e ."
        )
    return path


def verified(name: str) -> Path:
    """Path of a data file that exists and, if it has a checksum, is undamaged."""
    path = folder() / name
    if not path.is_file():
        raise FileNotFoundError(
            f"data/{name} is missing. Restore it with git checkout -- data/{name}"
        )
    expected = checksums().get(name)
    if expected and hashlib.sha256(path.read_bytes()).hexdigest() != expected:
        raise ValueError(
            f"data/{name} is damaged: its SHA-256 is not the one in data/SHA256SUMS."
            f" Restore it with git checkout -- data/{name}"
        )
    return path


def checksums() -> dict[str, str]:
    """SHA-256 by name of the files that were measured elsewhere."""
    lines = (folder() / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    return {name: digest for digest, name in (line.split() for line in lines)}
