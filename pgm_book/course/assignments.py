"""Assignments for nbgrader and Otter, made from the notebooks.

``make student FORMAT=nbgrader`` or ``FORMAT=otter``. An exercise with the check after
it becomes a solution with its autograded test; its points are the rubric's, or 10.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_notebook, new_raw_cell

from pgm_book.course import grade, intake
from pgm_book.make.student import (
    FIRST_LINES,
    PLACEHOLDER,
    PROGRAM,
    student_copy,
)
from pgm_lab import datasets
from pgm_lab.io.files import save

POINTS = 10.0  # of an exercise that the rubric does not have
MARKER = re.compile(r"^(\s*)#+ *((?:BEGIN|END) SOLUTION)", re.MULTILINE)
TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class Question(grade.Asked):
    """An exercise that is checked, with its points."""

    points: float = POINTS


def write(notebooks: Iterable[Path], build: Path, style: str) -> list[Path]:
    """Write ``build/nbgrader`` or ``build/otter``; return the paths."""
    assignment, place, guide = FORMATS[style]
    written = []
    for path in notebooks:
        notebook = nbformat.read(path, as_version=4)
        asked = list(questions(notebook, path.stem))
        if asked:
            made = assignment(with_answers(notebook, asked), asked, path.stem)
            target = build / style / place.format(path.stem) / path.name
            text = nbformat.writes(made) + "\n"
            program = target.with_name(PROGRAM)
            save({target: text, program: FIRST_LINES}, overwrite=True)
            written.append(target)
    target = build / style / guide
    content = (TEMPLATES / guide).read_text(encoding="utf-8")
    save({target: content.replace("{placeholder}", PLACEHOLDER)}, overwrite=True)
    return [*written, target]


def questions(notebook: NotebookNode, stem: str) -> Iterator[Question]:
    """Yield what a notebook asks and checks, with its points."""
    numbers = {row["notebook"]: row["number"] for row in datasets.rows("chapters.csv")}
    points = {(one.lesson, one.name): one.most for one in grade.exercises()}
    for one in grade.asked_in(notebook):
        if one.call:
            most = points.get((numbers.get(stem, ""), one.name), POINTS)
            yield Question(**vars(one), points=most)


def with_answers(notebook: NotebookNode, asked: list[Question]) -> NotebookNode:
    """Return the students' copy in which the answers to the questions are solved."""
    solved = {cell.id: cell.source for cell in notebook.cells}
    result = student_copy(notebook)
    for cell in result.cells:
        if cell.id in {question.answer for question in asked}:
            cell.source = solved[cell.id]
    return result


# --- nbgrader ---


def nbgrader(notebook: NotebookNode, asked: list[Question], _: str) -> NotebookNode:
    """Give the cells of answers and checks what nbgrader keeps in their metadata.

    The checksum is left to ``nbgrader generate_assignment``.
    """
    answers = {question.answer: question for question in asked}
    checks = {question.check: question for question in asked}
    for cell in notebook.cells:
        is_check = cell.id in checks
        question = checks.get(cell.id) or answers.get(cell.id)
        if question:
            cell.metadata["nbgrader"] = {
                "grade": is_check,
                "grade_id": question.name + "-check" * is_check,
                "locked": is_check,
                "schema_version": 3,
                "solution": not is_check,
                "task": False,
            } | ({"points": question.points} if is_check else {})
    return notebook


# --- Otter ---

CONFIG = """\
# ASSIGNMENT CONFIG
name: {stem}
solutions_pdf: false
export_cell: false
files: [{program}]
tests:
  ok_format: false
"""


def otter(notebook: NotebookNode, asked: list[Question], stem: str) -> NotebookNode:
    """Put Otter's raw cells around each answer, with its test below.

    The book's own check stays, since it keeps the function in ``my_pgm.py``.
    """
    answers = {question.answer: question for question in asked}
    cells = [new_raw_cell(CONFIG.format(stem=stem, program=PROGRAM), id="config")]
    for cell in notebook.cells:
        question = answers.get(cell.id)
        cells += _asked(cell, question) if question else [cell]
    return new_notebook(cells=cells, metadata=notebook.metadata)


def _asked(answer: NotebookNode, question: Question) -> list[NotebookNode]:
    """Return a question of Otter: an answer between raw cells, and its test."""
    answer.source = MARKER.sub(r"\1# \2", answer.source)
    names = intake.names_of(question.call).used
    test = f"def test({', '.join(sorted(names))}):\n    {question.call}"
    lines = [
        f"# BEGIN QUESTION\nname: {question.name}\npoints: {question.points:g}",
        "# BEGIN SOLUTION",
        answer,
        "# END SOLUTION",
        "# BEGIN TESTS",
        new_code_cell(test, id=f"{answer.id}-test"),
        "# END TESTS",
        "# END QUESTION",
    ]
    return [
        new_raw_cell(one, id=f"{answer.id}-{number}") if isinstance(one, str) else one
        for number, one in enumerate(lines)
    ]


Assignment = Callable[[NotebookNode, list[Question], str], NotebookNode]
# What makes one, the folder of a notebook, and a file that says how it goes on.
FORMATS: dict[str, tuple[Assignment, str, str]] = {
    "nbgrader": (nbgrader, "source/{}", "nbgrader_config.py"),
    "otter": (otter, "{}", "otter.md"),
}
