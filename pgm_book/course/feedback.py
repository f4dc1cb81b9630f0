"""Grades as a table, a page of feedback a student, and the lecturer's page."""

import csv
import io
import itertools
import re
import unicodedata
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import jinja2
from markupsafe import Markup
from nbformat import NotebookNode

from pgm_book.course import look
from pgm_book.course.intake import Submission
from pgm_book.make.student import student_copy
from pgm_lab import datasets
from pgm_lab.io.files import save

if TYPE_CHECKING:
    from pgm_book.course.grade import Exercise, Mark

BOOK = "the book's solution"
# What Moodle's import of a worksheet looks for (mod/assign/feedback/offline).
WORKSHEET = ["Identifier", "Grade", "Last modified (grade)"]


def number(value: float) -> str:
    """Write points without needless zeros."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def shown(value: object) -> object:
    """Return a text without characters that turn what follows it around."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    return "".join(one for one in value if unicodedata.category(one) != "Cf")


PAGES = jinja2.Environment(
    loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
    autoescape=True,
    finalize=shown,
    trim_blocks=True,
    lstrip_blocks=True,
    undefined=jinja2.StrictUndefined,
)
PAGES.filters["number"] = number


def write(
    folder: Path,
    submissions: list[Submission],
    asked: "list[Exercise]",
    marks: "dict[str, list[Mark]]",
    notebooks: list[NotebookNode],
    trusted: bool,
) -> list[Path]:
    """Write ``grades.csv``, ``class.html`` and ``feedback/``; return their paths.

    `notebooks` are those of the book, solved.
    """
    solved = code_of(notebooks)
    given = code_of([student_copy(notebook) for notebook in notebooks])
    known = frozenset(cell.strip() for cell in [*solved, *given])
    pages: dict[Path, str] = {folder / "grades.csv": table(submissions, asked, marks)}
    rows = []
    for one in submissions:
        mine = marks[one.student]
        remarks = [*one.remarks, *remarks_on(mine), *faked(one, mine)]
        remarks += look.at_cells(one, known)
        points = number(sum(mark.points for mark in mine))
        rows.append((one.student, points, remarks))
        page = folder / "feedback" / f"{file_name(one.student)}.html"
        while page in pages:  # two names that a file system takes for one
            page = page.with_stem(f"{page.stem}-2")
        pages[page] = PAGES.get_template("student.html.j2").render(
            student=one.student,
            points=points,
            most=number(sum(mark.most for mark in mine)),
            lessons=by_lesson(mine),
            remarks=one.remarks,
        )
    names = {name for exercise in asked for name in exercise.names}
    book = Submission(BOOK, (), "\n\n".join(solved), {}, ())
    answers = {one.student: look.functions(one, names) for one in [*submissions, book]}
    template = look.functions(replace(book, program="\n\n".join(given)), names)
    pages[folder / "class.html"] = PAGES.get_template("class.html.j2").render(
        rows=rows,
        most=number(sum(exercise.most for exercise in asked)),
        pairs=look.near_equal(answers, template),
        trusted=trusted,
    )
    # What strangers wrote may hold half a character, which no file can
    whole = {path: text.encode("utf-8", "replace") for path, text in pages.items()}
    for old in {*(folder / "feedback").glob("*.html")} - pages.keys():
        old.unlink()  # a page of another class
    save(whole, overwrite=True)
    return [folder / "grades.csv", folder / "class.html", folder / "feedback"]


def code_of(notebooks: Iterable[NotebookNode]) -> list[str]:
    """Return the sources of all code cells."""
    cells = [cell for notebook in notebooks for cell in notebook.cells]
    return [cell.source for cell in cells if cell.cell_type == "code"]


def table(
    submissions: list[Submission],
    asked: "list[Exercise]",
    marks: "dict[str, list[Mark]]",
) -> str:
    """Write the grades as CSV: a row a student, a column an exercise.

    Where Moodle's numbers are known, three columns more make it a grading worksheet
    that Moodle takes: it skips the row without a number.
    """
    moodle = any(one.number for one in submissions)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    most = [exercise.most for exercise in asked]
    names = [f"{exercise.lesson} {exercise.name}" for exercise in asked]
    writer.writerow(["student", *names, "total", *WORKSHEET * moodle])
    rows = [("of", most, "")]
    for one in submissions:
        points = [mark.points for mark in marks[one.student]]
        rows.append(
            (safe(one.student), points, one.number and f"Participant {one.number}")
        )
    for first, points, who in rows:
        row = [first, *map(number, [*points, sum(points)])]
        writer.writerow([*row, *[who, who and row[-1], ""] * moodle])
    return text.getvalue()


def safe(text: str) -> str:
    """Return a text that a spreadsheet does not take for a formula.

    Examples
    --------
    >>> safe("=1+1")
    "'=1+1"
    """
    text = text.replace(";", ",")  # begins a cell where numbers have a comma
    return f"'{text}" if text.lstrip().startswith(("=", "+", "-", "@")) else text


def file_name(student: str) -> str:
    """Return a name for a student's page that every system takes."""
    name = re.sub(r"[^\w -]", "_", student)[:80].strip(" .")
    reserved = r"(?i)(con|prn|aux|nul|com\d|lpt\d)"  # of Windows
    return f"_{name}" if not name or re.fullmatch(reserved, name) else name


def by_lesson(marks: "Iterable[Mark]") -> "list[tuple[str, list[Mark]]]":
    """Return marks by the titles of their lessons."""
    titles = {row["number"]: row["title"] for row in datasets.rows("chapters.csv")}
    groups = itertools.groupby(marks, key=lambda mark: mark.lesson)
    return [(f"{number} · {titles[number]}", list(some)) for number, some in groups]


def remarks_on(marks: "Iterable[Mark]") -> list[str]:
    """Return what the boxes told of a student's exercises."""
    said: dict[str, list[str]] = {}
    for mark in marks:
        for remark in mark.remarks:
            said.setdefault(remark, []).append(f"{mark.lesson} {mark.exercise}")
    return [f"{', '.join(names)}: {remark}" for remark, names in said.items()]


def faked(submission: Submission, marks: "Iterable[Mark]") -> list[str]:
    """Name exercises whose stored outputs say that they passed, which they did not."""
    said = "\n".join(notebook.said for notebook in submission.notebooks)
    return [
        f"{mark.lesson} {mark.exercise}: an output says that it passed its check"
        for mark in marks
        if mark.points == 0 and f"✓ {mark.exercise}:" in said
    ]
