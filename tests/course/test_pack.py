"""The students' zip: nothing is given away in it, and who gets it can begin."""

import ast
import csv
import io
import json
import subprocess
import sys
from collections import Counter

import nbformat
import pytest

from pgm_book.course import notes, pack
from pgm_book.make.environment import ROOT
from pgm_book.make.student import FIRST_LINES, PLACEHOLDER, slide_type, tags

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
WHEEL = {"pgm_lab-0.1.0-py3-none-any.whl": b"the wheel"}


@pytest.fixture(scope="module")
def students():
    return pack.student_files(NOTEBOOKS, WHEEL)


def shown(notebook) -> Counter:
    """Every line that a student may see, by another way than the copies are made."""
    lines = []
    for cell in notebook.cells:
        if {"solution", "claims"} & set(tags(cell)) or slide_type(cell) == "notes":
            continue
        solved = False
        for line in cell.source.splitlines():
            if "SOLUTION" in line:
                solved = "BEGIN" in line
            elif not solved:
                lines.append(line)
    return Counter(lines)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_no_line_of_a_solution_and_no_note_is_in_it(path, students):
    """No line is there more often than where it is not solved, noted or claimed."""
    solved = nbformat.read(path, as_version=4)
    copy = nbformat.reads(students[f"notebooks/{path.name}"].decode(), 4)
    lines = Counter(one for c in copy.cells for one in c.source.splitlines())
    for line in list(lines):
        if line.strip() == PLACEHOLDER:
            del lines[line]
    assert lines == shown(solved)
    assert not any("claims" in tags(cell) for cell in copy.cells)
    assert not any(slide_type(cell) == "notes" for cell in copy.cells)
    assert not any(cell.get("outputs") for cell in copy.cells)
    assert "pgm_lab" not in copy.metadata


def test_who_gets_it_can_begin(students):
    """With an empty program, the library, what it needs, and how to begin."""
    assert students["notebooks/my_pgm.py"].decode() == FIRST_LINES
    assert students["requirements.txt"] == (ROOT / "requirements.txt").read_bytes()
    assert {"LICENSE", "LICENSE-CC-BY-4.0", *WHEEL} <= set(students)
    page = students["START.html"].decode()
    for word in ("py -3 start.py", "python3 start.py", *WHEEL, "00_start_here.ipynb"):
        assert word in page
    assert "truths" not in page and "truths.py" not in students
    ast.parse(students["start.py"].decode())


def test_a_library_is_left_without_what_makes_and_grades_the_course():
    names = ["pgm_lab/ncc.py", "pgm_book/course/grade.py", "pgm_book/make/a.ipynb"]
    record = "p-1.dist-info/RECORD"
    listed = "".join(f"{name},sha256=x,1\n" for name in [*names, record])
    kept = pack.for_students({**dict.fromkeys(names, b""), record: listed.encode()})
    assert set(kept) == {"pgm_lab/ncc.py", record}
    rows = list(csv.reader(io.StringIO(kept[record].decode())))
    assert [row[0] for row in rows] == ["pgm_lab/ncc.py", record]


def test_solutions_are_programs():
    for path in NOTEBOOKS:
        text = pack.solutions(nbformat.read(path, as_version=4))
        ast.parse(text)
        assert bool(text) == ("BEGIN SOLUTION" in path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_the_truth_behind_a_student_s_task_is_printed(tmp_path):
    script = ROOT / "pgm_book" / "course" / "templates" / "truths.py"
    command = [sys.executable, script, "4", "Siti Rahma"]
    said = [
        subprocess.run(one, cwd=tmp_path, capture_output=True, text=True, check=True)
        for one in (command, [*command, "secret"])
    ]
    assert "Task 4 for Siti Rahma" in said[0].stdout
    assert said[0].stdout != said[1].stdout


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_each_note_is_printed_once_below_its_slide(path):
    notebook = nbformat.read(path, as_version=4)
    printed = notes.for_notes(notebook, path.stem)
    text = "\n\n".join([*(cell.source for cell in printed.cells), ""])
    said = [c.source for c in notebook.cells if slide_type(c) == "notes"]
    for note in said:
        assert text.count(f"\n\n{note}\n\n") == said.count(note)
    minutes = [
        int(line.rpartition("minute ")[2])
        for line in text.splitlines()
        if line.startswith("## ") and " · minute " in line
    ]
    assert minutes == sorted(minutes) and (not minutes or minutes[-1] < 45)
    assert json.dumps(printed).count('"outputs"') == 0


def test_what_was_published_before_of_other_lessons_is_left_out(tmp_path):
    for stem in ("04_rotation_matrices", "04_of_last_year"):
        (tmp_path / f"{stem}.pdf").write_bytes(b"")
    (lesson,) = (path for path in NOTEBOOKS if path.stem == "04_rotation_matrices")
    found = pack.published([lesson], tmp_path, "handouts")
    assert set(found) == {"handouts/04_rotation_matrices.pdf"}
