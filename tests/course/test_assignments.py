"""Assignments for nbgrader and Otter, also graded by the real programs."""

import ast
import os

import nbformat
import pytest

from pgm_book.course import grade
from pgm_book.course.assignments import POINTS, questions, with_answers, write
from pgm_book.make.__main__ import main
from pgm_book.make.environment import ROOT
from pgm_book.make.student import PROGRAM, tags
from tests.course import other_graders

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
LESSON = ROOT / "notebooks" / "04_rotation_matrices.ipynb"


def asked(path):
    notebook = nbformat.read(path, as_version=4)
    return notebook, list(questions(notebook, path.stem))


def test_all_that_is_checked_is_asked_with_the_points_of_the_rubric():
    """But for the tasks, whose data a grader makes from the student's name."""
    found = {}
    for path in NOTEBOOKS:
        notebook, made = asked(path)
        checks = [cell for cell in notebook.cells if "check" in tags(cell)]
        assert [one.check for one in made] == [cell.id for cell in checks]
        assert len({one.name for one in made}) == len(made)
        number = next((n for n, nb in grade.notebooks().items() if nb == notebook), "")
        found |= {(number, one.name): one.points for one in made}
    rubric = {
        (one.lesson, one.name): one.most
        for one in grade.exercises()
        if one.name != grade.TASK
    }
    assert rubric.items() <= found.items()
    assert {found[key] for key in found.keys() - rubric.keys()} <= {POINTS}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_only_the_answers_are_solved(path):
    notebook, made = asked(path)
    answers = {one.answer for one in made}
    for cell in with_answers(notebook, made).cells:
        assert ("SOLUTION" in cell.source) == (cell.id in answers)
        assert "claims" not in tags(cell)


def test_nbgrader_finds_its_metadata(tmp_path):
    source, config = write([LESSON], tmp_path, "nbgrader")
    assert source.relative_to(tmp_path).parts[:2] == ("nbgrader", "source")
    cells = nbformat.read(source, as_version=4).cells
    marked = [
        cell.metadata["nbgrader"] for cell in cells if "nbgrader" in cell.metadata
    ]
    assert [one["grade_id"] for one in marked[:2]] == ["plane_turn", "plane_turn-check"]
    for answer, check in zip(marked[::2], marked[1::2]):
        assert (answer["solution"], answer["grade"], answer["locked"]) == (1, 0, 0)
        assert (check["solution"], check["grade"], check["locked"]) == (0, 1, 1)
        assert check["points"] == 10 and "points" not in answer
        assert {one["schema_version"] for one in (answer, check)} == {3}
    assert "pass  # your code here" in config.read_text(encoding="utf-8")
    ast.parse(config.read_text(encoding="utf-8"))
    assert source.with_name(PROGRAM).exists()


def test_otter_finds_its_raw_cells(tmp_path):
    source, guide = write([LESSON], tmp_path, "otter")
    cells = nbformat.read(source, as_version=4).cells
    raw = [cell.source.split("\n")[0] for cell in cells if cell.cell_type == "raw"]
    assert raw[0] == "# ASSIGNMENT CONFIG"
    kinds = ["QUESTION", "SOLUTION", "SOLUTION", "TESTS", "TESTS", "QUESTION"]
    ends = ["BEGIN", "BEGIN", "END", "BEGIN", "END", "END"]
    assert raw[1:7] == [f"# {end} {kind}" for end, kind in zip(ends, kinds)]
    tests = [
        c.source for c in cells if c.cell_type == "code" and "def test(" in c.source
    ]
    assert tests[0] == (
        "def test(chapter4, plane_turn):\n    chapter4.plane_turn(plane_turn)"
    )
    assert not any("### BEGIN" in cell.source for cell in cells)
    assert "otter assign" in guide.read_text(encoding="utf-8")


def test_what_a_task_defines_is_asked_for_by_name(tmp_path):
    """Lesson 5 looks it up, since it may be missing; a test of Otter gets None."""
    path = ROOT / "notebooks" / "05_intersection.ipynb"
    (relative,) = (one for one in asked(path)[1] if one.name == "relative")
    assert relative.call.startswith("chapter5.relative(relative)")


def test_the_command_takes_a_format(tmp_path, capsys):
    assert main(["student", "04", "--format", "otter", "--build", str(tmp_path)]) == 0
    assert "otter.md" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["slides", "--format", "otter"])
    assert "for the students' copies" in capsys.readouterr().err


# --- The real programs ---


@pytest.fixture(scope="module", params=["nbgrader", "otter"])
def grader(request, tmp_path_factory):
    """A program in an environment of its own."""
    try:
        folder = tmp_path_factory.mktemp(request.param) / "venv"
        return request.param, other_graders.installed(request.param, folder)
    except other_graders.NoNetwork as error:
        pytest.skip(f"{request.param} cannot be fetched: {error}")


@pytest.mark.slow
@pytest.mark.skipif(
    "PGM_LAB_LARGEST_SAMPLES" not in os.environ, reason="fetches programs: in test-all"
)
@pytest.mark.parametrize("stem", ["04_rotation_matrices", "05_intersection"])
def test_blank_gets_nothing_and_solved_gets_all(grader, stem, tmp_path):
    name, python = grader
    blank, solved, most = other_graders.points(name, python, stem, tmp_path)
    assert (blank, solved) == (0, most)
    path = ROOT / "notebooks" / f"{stem}.ipynb"
    assert most == sum(one.points for one in asked(path)[1])
