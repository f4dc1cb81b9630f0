"""What ``data/chapters.csv`` says of a notebook."""

import csv
from pathlib import Path


def form_of(notebook: Path) -> str:
    """Return "lesson" or "case" for a notebook, an empty text where it is neither."""
    chapters = notebook.resolve().parents[1] / "data" / "chapters.csv"
    if not chapters.is_file():
        return ""
    with chapters.open(encoding="utf-8", newline="") as lines:
        rows = {row["notebook"]: row["form"] for row in csv.DictReader(lines)}
    form = rows.get(notebook.stem, "")
    return form if form in ("lesson", "case") else ""
