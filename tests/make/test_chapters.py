"""README, chapter 0 and the notebooks say the same of the chapters."""

import json
import re

import pytest

from pgm_book.common import chapters
from pgm_book.make import notebooks
from pgm_book.make.chapters import BEGIN, END, README, renewed
from pgm_lab import datasets

READY = [row for row in datasets.rows("chapters.csv") if row["notebook"]]


def cells(row):
    path = notebooks.FOLDER / f"{row['notebook']}.ipynb"
    return json.loads(path.read_text(encoding="utf-8"))["cells"]


def test_the_table_in_readme_is_current():
    """If not: python -m pgm_book.make.chapters."""
    text = README.read_text(encoding="utf-8")
    assert renewed(text) == text


def test_every_notebook_is_listed_once():
    stored = sorted(path.stem for path in notebooks.FOLDER.glob("*.ipynb"))
    assert sorted(row["notebook"] for row in READY) == stored


@pytest.mark.parametrize("row", READY, ids=lambda row: row["notebook"])
def test_title_and_minutes_are_those_at_the_head_of_the_notebook(row):
    text = "\n".join("".join(cell["source"]) for cell in cells(row))
    assert f"# {row['number']} · {row['question']}" in text
    minutes = re.search(r"About \*\*(\d+) minutes\*\*", text)
    assert minutes and minutes[1] == row["minutes"]


def test_a_stale_table_is_renewed_and_the_rest_of_readme_is_kept():
    stale = f"before\n{BEGIN}\n\n| 1 | an old title |\n{END}\nafter\n"
    new = renewed(stale)
    assert new.startswith("before\n") and new.endswith("\nafter\n")
    assert "an old title" not in new and "(notebooks/00_start_here.ipynb)" in new
    assert renewed(new) == new
    with pytest.raises(ValueError, match="must contain"):
        renewed("no table here")


def test_a_chapter_without_notebook_is_to_come(monkeypatch):
    rows = [dict(READY[0], number="9", notebook="", title="Clouds")]
    monkeypatch.setattr(datasets, "rows", lambda name: READY + rows)
    assert chapters.markdown().endswith("\n\nTo come: 9 Clouds.")
    monkeypatch.setattr(datasets, "rows", lambda name: READY)
    assert "To come" not in chapters.markdown()
