"""What the seeded studies share: they write a small table of results beside them."""

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path

BOOK = Path(__file__).parents[1]


def write(
    chapter: str, name: str, columns: Sequence[str], rows: Iterable[Sequence[object]]
) -> None:
    """Write a table into the ``results/`` of a chapter; `results.rows` reads it."""
    path = BOOK / chapter / "results" / f"{name}.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([columns, *rows])
