"""The course as it is handed out: the students' library, the zips, notes on paper."""

import csv
import io
import os
import subprocess
import sys
import zipfile

import pytest

from pgm_book.course import notes, pack
from pgm_book.make import tagged
from pgm_book.make.environment import ROOT

LESSON = ROOT / "notebooks" / "04_rotation_matrices.ipynb"
USE = """
import pgm_lab
from pgm_book import ch04, program, task
from pgm_book.ch04 import checks as chapter4, figures
from pgm_book.common import checks, ledger
checks.own("adjust", program.adjustment.adjust)
mine = task.start(4, "a name")
try:
    import pgm_book.course
except ModuleNotFoundError:
    print(pgm_lab.__file__)
"""


@pytest.fixture(scope="module")
def wheels():
    return pack.wheels()


def test_the_students_library_has_no_lecturer_s_part_and_no_notebook(wheels):
    whole, students = (zipfile.ZipFile(io.BytesIO(*one.values())) for one in wheels)
    assert set(students.namelist()) < set(whole.namelist())
    gone = set(whole.namelist()) - set(students.namelist())
    assert gone and all(name.startswith(pack.LECTURERS) for name in gone)
    assert not any(name.endswith(".ipynb") for name in students.namelist())
    (record,) = (n for n in students.namelist() if n.endswith("/RECORD"))
    rows = csv.reader(io.StringIO(students.read(record).decode()))
    assert {row[0] for row in rows} == set(students.namelist())


def test_the_students_library_works_alone(wheels, tmp_path):
    """A lesson's check, its task and the book's own functions, far from the project."""
    (content,) = wheels[1].values()
    zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path)
    env = os.environ | {"PYTHONPATH": str(tmp_path), "MPLBACKEND": "agg"}
    command = [sys.executable, "-S", "-c", f"import sys; sys.path += {sys.path!r}{USE}"]
    done = subprocess.run(
        command, cwd=tmp_path, env=env, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert str(tmp_path) in done.stdout


def test_a_zip_is_the_same_twice(wheels):
    """Also the wheel in it, whenever it is built."""
    assert pack.wheels() == wheels
    files = pack.student_files([LESSON], wheels[1])
    again = pack.student_files([LESSON], pack.wheels()[1])
    assert pack.archive.zipped(files) == pack.archive.zipped(again)


def test_the_notes_are_a_tagged_pdf_the_same_twice(browser):
    """Each below the title of its slide, with the pace."""
    printed = notes.print_notes(browser, [LESSON])
    assert printed == notes.print_notes(browser, [LESSON])
    pieces = tagged.read(printed["04_rotation_matrices.pdf"]).pieces
    heads = "".join(p.text for p in pieces if p.kind == "heading").split()
    assert heads[:2] == ["Notes:", "4"]
    assert "minute 17" in " ".join(heads) and "matter?" in heads
    text = " ".join("".join(p.text for p in pieces if p.kind == "text").split())
    assert text.count("two people rotate two books") == 1
