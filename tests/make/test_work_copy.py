"""The reader's copies in work/ are made once and never touched again."""

import errno
import random
from pathlib import Path

import nbformat
import pytest
from nbformat import v4

from pgm_book.make import work_copy
from pgm_book.make.environment import ROOT, work_folder
from pgm_book.make.work_copy import RECORD, mended, moved, update


@pytest.fixture
def folders(tmp_path):
    """A folder with one original, and the reader's."""
    source = tmp_path / "notebooks"
    source.mkdir()
    put(source, "01_one", "x = 1")
    return source, tmp_path / "work"


def put(folder, name, code):
    """Store an original, with a solution that the reader must not get."""
    solved = f"{code}\n### BEGIN SOLUTION\nsecret = 1\n### END SOLUTION"
    notebook = v4.new_notebook(cells=[v4.new_code_cell(solved, id="only")])
    nbformat.write(notebook, folder / f"{name}.ipynb")


def contents(folder):
    """The bytes of every notebook in a folder."""
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.ipynb"))}


def test_the_first_run_gives_copies_without_solutions_and_the_next_nothing(folders):
    source, work = folders
    assert update(source, work) == ["01_one.ipynb: your copy is in work/"]
    copy = nbformat.read(work / "01_one.ipynb", as_version=4)
    assert copy.cells[0].source == "x = 1\npass  # your code here"
    (work / "01_one.ipynb").write_text("the reader's work")
    notebook = nbformat.read(source / "01_one.ipynb", as_version=4)
    notebook.cells[0].outputs = [v4.new_output("stream", text="1\n")]
    nbformat.write(notebook, source / "01_one.ipynb")
    assert update(source, work) == [], "new outputs alone are no change"
    assert (work / "01_one.ipynb").read_text() == "the reader's work"
    (work / "01_one.ipynb").unlink()
    assert update(source, work) == ["01_one.ipynb: your copy is in work/"]


def test_a_changed_original_is_offered_beside_once(folders):
    source, work = folders
    update(source, work)
    (work / "01_one.ipynb").write_text("the reader's work")
    put(source, "01_one", "x = 2")
    (line,) = update(source, work)
    assert line.startswith("01_one.ipynb: the original has changed.")
    assert line.endswith("beside it: 01_one.new.ipynb")
    assert (work / "01_one.ipynb").read_text() == "the reader's work"
    assert "x = 2" in (work / "01_one.new.ipynb").read_text()
    assert update(source, work) == []
    for version in (3, 4):
        put(source, "01_one", f"x = {version}")
        update(source, work)
    names = ["01_one.ipynb", "01_one.new-2.ipynb", "01_one.new-3.ipynb"]
    assert list(contents(work)) == [*names, "01_one.new.ipynb"]
    assert "x = 4" in (work / "01_one.new-3.ipynb").read_text()
    (work / "01_one.new-3.ipynb").unlink()
    assert update(source, work) == [], "declined once is declined"


def test_a_copy_made_by_hand_is_respected(folders):
    source, work = folders
    work.mkdir()
    (work / "01_one.ipynb").write_text("put here by the reader")
    update(source, work)
    assert (work / "01_one.ipynb").read_text() == "put here by the reader"
    assert list(contents(work)) == ["01_one.ipynb", "01_one.new.ipynb"]


@pytest.mark.parametrize("damaged", ["", "{", "[1]", "\0"])
def test_a_damaged_record_stops_offers_but_not_the_lab(folders, damaged):
    source, work = folders
    update(source, work)
    (work / RECORD).write_text(damaged)
    put(source, "01_one", "x = 2")
    put(source, "02_two", "y = 1")
    before = contents(work)
    message, line = update(source, work)
    assert "is damaged" in message and "Delete it" in message
    assert line == "02_two.ipynb: your copy is in work/"
    assert (work / RECORD).read_text() == damaged
    assert before.items() <= contents(work).items()
    (work / RECORD).unlink()
    (line,) = update(source, work)
    assert line.endswith("beside it: 01_one.new.ipynb")


def test_a_broken_original_is_named(folders):
    source, work = folders
    notebook = v4.new_notebook(cells=[v4.new_code_cell("### BEGIN SOLUTION")])
    nbformat.write(notebook, source / "01_one.ipynb")
    with pytest.raises(ValueError, match="01_one.ipynb, cell"):
        update(source, work)


@pytest.mark.parametrize("again", [False, True])
def test_a_full_disk_leaves_no_half_of_a_copy(folders, monkeypatch, again):
    """Not even a part is left, and the copies and the record of before stay."""
    source, work = folders
    work.mkdir()
    if again:
        update(source, work)
    put(source, "01_one", "x = 2" * 100)
    before = {path.name: path.read_bytes() for path in work.iterdir()}
    whole = Path.open

    def opened(path, mode="r", **keywords):
        file = whole(path, mode, **keywords)
        if "x" in mode:
            file.write = lambda text: whole_write(file, text[:60])
        return file

    def whole_write(file, text):
        type(file).write(file, text)
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as full:
        full.setattr(Path, "open", opened)
        with pytest.raises(OSError, match="No space left"):
            update(source, work)
    assert {path.name: path.read_bytes() for path in work.iterdir()} == before
    assert len(update(source, work)) == 1


@pytest.mark.parametrize("seed", range(10))
def test_no_byte_of_an_existing_file_ever_changes(folders, seed):
    """Whatever readers and authors do in whatever order, update only adds files."""
    source, work = folders
    chance = random.Random(seed)
    work.mkdir()
    for step in range(30):
        name = chance.choice(["01_one", "02_two"])
        action = chance.choice(["author", "author", "solve", "delete", "damage"])
        files = sorted(work.glob("*.ipynb"))
        if action == "author":
            put(source, name, f"x = {chance.randrange(4)}")
        elif action == "solve" and files:
            chance.choice(files).write_text(f"solved in step {step}")
        elif action == "delete" and files:
            chance.choice(files).unlink()
        elif action == "damage":
            record = work / RECORD
            record.unlink(missing_ok=True) if chance.random() < 0.5 else record.touch()
        before = contents(work)
        update(source, work)
        assert before.items() <= contents(work).items()
        assert {path.name for path in source.iterdir()} <= set(contents(work))


# --- An older edition ---

PROGRAM = '''"""My program."""

import numpy as np
import pgm_lab.camera.textbook as textbook
from pgm_lab.adjustment.textbook import adjust
from pgm_lab.ncc import correlation
from pgm_lab.registration import peak_of_parabola as top


def mine(x):
    return np.sqrt(x)  # from pgm_lab.adjustment.textbook
'''
MENDED = '''"""My program."""

import numpy as np
from pgm_book.program import camera as textbook
from pgm_book.program.adjustment import adjust
from pgm_lab.ncc import correlation
from pgm_book.program.registration import peak_of_parabola as top


def mine(x):
    return np.sqrt(x)  # from pgm_lab.adjustment.textbook
'''


@pytest.fixture
def lab(folders, monkeypatch):
    """Run what `make lab` runs first, in a project of its own."""
    source, work = folders
    monkeypatch.setattr(work_copy, "ROOT", source.parent)
    return work_copy.main


def test_the_program_is_begun_once(lab, folders):
    program = folders[1] / "my_pgm.py"
    assert lab() == 0
    assert program.read_text(encoding="utf-8") == work_copy.FIRST_LINES
    program.write_text("x = 1\n", encoding="utf-8")
    assert lab() == 0
    assert program.read_text(encoding="utf-8") == "x = 1\n"


@pytest.mark.parametrize(
    "old",
    [
        "from pgm_lab import checks, datasets",
        "from pgm_lab.checks import chapter3",
        "from pgm_lab.adjustment import textbook",
        "import pgm_lab.ledger as ledger",
    ],
)
def test_the_new_edition_is_laid_beside_an_older_one(lab, folders, capsys, old):
    source, work = folders
    put(source, "01_one", old)
    update(source, work)
    put(source, "01_one", "from pgm_book.common import checks")
    (work / "my_pgm.py").write_text(PROGRAM, encoding="utf-8")
    before = {path.name: path.read_bytes() for path in work.iterdir()}
    assert lab() == 0
    new = work_folder(source.parent)
    assert new.name == "work-2" and list(contents(new)) == ["01_one.ipynb"]
    assert (new / "my_pgm.py").read_text(encoding="utf-8") == MENDED
    assert {path.name: path.read_bytes() for path in work.iterdir()} == before
    said = capsys.readouterr().out
    assert "work/ contains notebooks of an older edition" in said
    assert "new edition is in work-2/, your program my_pgm.py along" in said
    assert lab() == 0, "from now on this is the reader's folder"
    assert capsys.readouterr().out == "" and work_folder(source.parent) == new


@pytest.mark.parametrize("code", ["from pgm_lab import nothing", "import (", "x = 1"])
def test_other_changes_are_no_older_edition(lab, folders, code):
    source, work = folders
    put(source, "01_one", code)
    assert lab() == 0
    put(source, "01_one", "x = 2")
    (work / "notes.ipynb").write_text("no notebook")
    assert lab() == 0
    assert work_folder(source.parent) == work
    assert (work / "01_one.new.ipynb").exists()


def test_a_program_that_cannot_be_read_comes_along_as_it_is(lab, folders):
    source, work = folders
    put(source, "01_one", "from pgm_lab import checks")
    update(source, work)
    put(source, "01_one", "x = 1")
    (work / "my_pgm.py").write_text("def broken(:\n", encoding="utf-8")
    assert lab() == 0
    program = work_folder(source.parent) / "my_pgm.py"
    assert program.read_text(encoding="utf-8") == "def broken(:\n"


def test_old_names_lead_to_modules_that_are_there():
    assert moved("pgm_lab.checks.chapter3c") == "pgm_book.ch03.case_checks"
    assert moved("pgm_lab.checks.chapterA1.f") == "pgm_book.chA1.checks.f"
    assert moved("pgm_lab.checks.compare") == "pgm_book.common.checks.compare"
    assert moved("pgm_lab.checksum") == moved("pgm_lab.ncc") == moved("numpy") == ""
    assert mended(MENDED) == MENDED
    if (ROOT / "pgm_book" / "program").is_dir():
        for old, new in work_copy.MOVED.items():
            module = ROOT / new.replace(".", "/")
            there = module.with_suffix(".py").exists() or module.is_dir()
            function = module.parent.with_suffix(".py")
            named = f"def {module.name}(" in function.read_text() if not there else True
            assert named, f"{old} is not in {new}"
