"""The small tables that seeded studies have written: ``results/`` of each chapter."""

import csv
from pathlib import Path

BOOK = Path(__file__).parents[1]


def rows(chapter: str, name: str) -> list[dict[str, str]]:
    """Rows of a table of results as dictionaries, by the folder of its chapter.

    Examples
    --------
    >>> rows("ch02", "windows")[0]["scene"]
    'stereo pair'
    """
    path = BOOK / chapter / "results" / f"{name}.csv"
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, strict=True))
