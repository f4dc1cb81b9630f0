"""TEACHING.md says of chapters, decks, commands and weights what the project has."""

import re

import pytest

from pgm_book.make import teaching
from pgm_book.make.chapters import ROOT
from pgm_book.make.commands import TASKS
from pgm_lab import datasets

TEXT = teaching.TEACHING.read_text(encoding="utf-8")


def test_its_tables_are_current():
    """If not: python -m pgm_book.make.teaching."""
    assert teaching.renewed(TEXT) == TEXT


def test_every_command_exists():
    named = set(re.findall(r"`make ([a-z-]+)", TEXT))
    assert named and named <= set(TASKS)


def test_every_file_that_it_links_and_every_deck_exist():
    linked = re.findall(r"\]\(([^)#]+)\)", TEXT)
    decks = re.findall(r"`(?:build/slides/\w+/)?([0-9A]\w+)(?:\.html)?`", TEXT)
    files = [ROOT / one for one in linked if "://" not in one]
    files += [ROOT / "notebooks" / f"{deck}.ipynb" for deck in decks]
    assert len(decks) > 20 and [path for path in files if not path.exists()] == []


def test_every_chapter_is_taught_once_in_fourteen_weeks():
    taught = [c.number for week in teaching.weeks() for c in week.chapters]
    assert len(teaching.weeks()) == 14
    assert taught == [row["number"] for row in datasets.rows("chapters.csv")]


def test_the_decks_of_a_week_leave_time_for_questions_and_a_break():
    for week in teaching.weeks():
        lecture = sum(c.lecture for c in week.chapters)
        assert 0 < lecture <= teaching.TWO_HOURS - 15, week.row["week"]


@pytest.mark.parametrize(
    "row", datasets.rows("course_short.csv"), ids=lambda r: r["unit"]
)
def test_a_unit_of_a_short_course_leaves_a_quarter_for_exercises(row):
    known = teaching.chapters()
    lecture = sum(known[number].lecture for number in row["chapters"].split())
    assert lecture <= 0.75 * int(row["minutes"])


def test_weights_sum_to_100_as_the_sentence_below_them_says():
    rows = datasets.rows("course_weeks.csv")
    exams = sum(weight for _, _, weight in teaching.EXAMS.values())
    assert sum(int(row["weight"]) for row in rows) + exams == 100
    tasks = sum(int(r["weight"]) for r in rows if r["indicator"].startswith("Task"))
    pages = sum(int(r["weight"]) for r in rows if r["indicator"].startswith("A page"))
    report = int(rows[-1]["weight"])
    said = f"ten tasks {tasks}, three pages on cases {pages}, the report {report}"
    assert f"{said}, two examinations {exams}" in TEXT.replace("\n", " ")


def test_every_reading_is_listed():
    for row in datasets.rows("course_weeks.csv"):
        name = row["reading"].split()[0]
        assert name == "the" or TEXT.count(name) > 1, row["reading"]


def test_there_are_twenty_mistakes():
    part = TEXT.partition("## Twenty usual")[2].partition("\n## ")[0]
    assert len(re.findall(r"^\| [0-9A]", part, re.MULTILINE)) == 20
