"""The reader's copies in work/ are made once and never touched again."""

import errno
import os
import random

import nbformat
import pytest
from nbformat import v4

from pgm_book.common import own_program as _program
from pgm_book.make import work_copy
from pgm_book.make.work_copy import RECORD, update


@pytest.fixture
def folders(tmp_path):
    source = tmp_path / "notebooks"
    source.mkdir()
    return source, tmp_path / "work"


def put(folder, name, code):
    """Store an original, with a solution that the reader must not get."""
    solved = f"{code}\n### BEGIN SOLUTION\nsecret = 1\n### END SOLUTION"
    notebook = v4.new_notebook(cells=[v4.new_code_cell(solved, id="only")])
    nbformat.write(notebook, folder / f"{name}.ipynb")


def names(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != RECORD)


def contents(folder):
    """The bytes of every notebook in a folder."""
    return {path.name: path.read_bytes() for path in folder.glob("*.ipynb")}


def test_the_first_run_gives_copies_without_solutions(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    assert update(source, work) == ["01_one.ipynb: your copy is in work/"]
    copy = nbformat.read(work / "01_one.ipynb", as_version=4)
    assert copy.cells[0].source == "x = 1\npass  # your code here"


def test_the_reader_s_program_is_begun_once(tmp_path):
    work_copy.begin_program(tmp_path)
    program = tmp_path / "my_pgm.py"
    assert program.read_text(encoding="utf-8") == work_copy.FIRST_LINES
    assert work_copy.PROGRAM == _program.FILE
    program.write_text("x = 1\n", encoding="utf-8")
    work_copy.begin_program(tmp_path)
    assert program.read_text(encoding="utf-8") == "x = 1\n"


def test_a_second_run_says_and_does_nothing(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    (work / "01_one.ipynb").write_text("the reader's work")
    before = contents(work)
    assert update(source, work) == []
    assert contents(work) == before


def test_a_changed_original_is_offered_beside_once(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    (work / "01_one.ipynb").write_text("the reader's work")
    put(source, "01_one", "x = 2")
    (line,) = update(source, work)
    assert line.startswith("01_one.ipynb: the original has changed.")
    assert line.endswith("beside it: 01_one.new.ipynb")
    assert (work / "01_one.ipynb").read_text() == "the reader's work"
    assert "x = 2" in (work / "01_one.new.ipynb").read_text()
    assert update(source, work) == []
    (work / "01_one.new.ipynb").unlink()
    assert update(source, work) == [], "declined once is declined"


def test_a_second_change_takes_the_next_name(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    for version in (2, 3, 4):
        put(source, "01_one", f"x = {version}")
        update(source, work)
    assert names(work) == [
        "01_one.ipynb",
        "01_one.new-2.ipynb",
        "01_one.new-3.ipynb",
        "01_one.new.ipynb",
    ]
    assert "x = 2" in (work / "01_one.new.ipynb").read_text()
    assert "x = 4" in (work / "01_one.new-3.ipynb").read_text()


def test_new_outputs_alone_are_no_change(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    notebook = nbformat.read(source / "01_one.ipynb", as_version=4)
    notebook.cells[0].outputs = [v4.new_output("stream", text="1\n")]
    nbformat.write(notebook, source / "01_one.ipynb")
    assert update(source, work) == []


def test_a_deleted_copy_comes_back(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    (work / "01_one.ipynb").unlink()
    assert update(source, work) == ["01_one.ipynb: your copy is in work/"]


def test_a_copy_made_by_hand_is_respected(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    work.mkdir()
    (work / "01_one.ipynb").write_text("put here by the reader")
    update(source, work)
    assert (work / "01_one.ipynb").read_text() == "put here by the reader"
    assert names(work) == ["01_one.ipynb", "01_one.new.ipynb"]


@pytest.mark.parametrize("damaged", ["", "{", "[1]", "\0"])
def test_a_damaged_record_stops_offers_but_not_the_lab(folders, damaged):
    source, work = folders
    put(source, "01_one", "x = 1")
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


class FullDisk:
    """A disk on which a file takes so many characters, and then no more."""

    def __init__(self, room):
        self.room = room

    def open(self, path, *arguments, **keywords):
        file = open(path, *arguments, **keywords)
        whole = file.write

        def write(text):
            whole(text[: self.room])
            file.flush()
            if len(text) > self.room:
                raise OSError(errno.ENOSPC, "No space left on device", str(path))

        file.write = write
        return file


@pytest.mark.parametrize("room", [0, 1, 60, 400])
def test_a_full_disk_leaves_no_half_of_a_copy(folders, monkeypatch, room):
    source, work = folders
    put(source, "01_one", "x = 1" * 100)
    with monkeypatch.context() as full:
        full.setattr(work_copy, "open", FullDisk(room).open, raising=False)
        with pytest.raises(OSError, match="No space left"):
            update(source, work)
    assert list(work.iterdir()) == [], "not even a part is left"
    assert update(source, work) == ["01_one.ipynb: your copy is in work/"]
    nbformat.validate(nbformat.read(work / "01_one.ipynb", as_version=4))


def test_a_full_disk_keeps_the_copies_and_the_record_of_before(folders, monkeypatch):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    (work / "01_one.ipynb").write_text("the reader's work")
    put(source, "01_one", "x = 2")
    before = {path.name: path.read_bytes() for path in work.iterdir()}
    with monkeypatch.context() as full:
        full.setattr(work_copy, "open", FullDisk(9).open, raising=False)
        with pytest.raises(OSError, match="No space left"):
            update(source, work)
    assert {path.name: path.read_bytes() for path in work.iterdir()} == before
    (line,) = update(source, work)
    assert line.endswith("beside it: 01_one.new.ipynb")


def test_a_run_that_is_killed_leaves_no_half_of_a_copy(folders, monkeypatch):
    """What stands under a copy's name is whole at any moment."""
    source, work = folders
    put(source, "01_one", "x = 1")
    monkeypatch.setattr(
        os, "replace", lambda part, path: whole.append(part.read_text())
    )
    whole = []
    update(source, work)
    monkeypatch.undo()
    update(source, work)
    assert whole[0] == (work / "01_one.ipynb").read_text()


@pytest.mark.parametrize("kept", [0, 1, 100, -2])
def test_a_copy_that_broke_off_is_made_whole(folders, kept):
    """Earlier versions left such files, and kept them for ever."""
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    own = work / "01_one.ipynb"
    whole = own.read_bytes()
    own.write_bytes(whole[:kept])
    (work / RECORD).unlink()
    assert update(source, work) == ["01_one.ipynb: your copy is in work/"]
    assert own.read_bytes() == whole
    assert update(source, work) == []


def test_a_copy_beside_that_broke_off_is_made_whole(folders):
    source, work = folders
    put(source, "01_one", "x = 1")
    update(source, work)
    put(source, "01_one", "x = 2")
    update(source, work)
    beside = work / "01_one.new.ipynb"
    whole = beside.read_bytes()
    beside.write_bytes(whole[:50])
    (work / RECORD).unlink()
    update(source, work)
    assert beside.read_bytes() == whole
    assert names(work) == ["01_one.ipynb", "01_one.new.ipynb"]


@pytest.mark.parametrize("seed", range(20))
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
            chance.choice([(work / RECORD).touch, lambda: unlink(work)])()
        before = contents(work)
        update(source, work)
        assert before.items() <= contents(work).items()
        assert {path.name for path in source.iterdir()} <= set(contents(work))


def unlink(work):
    (work / RECORD).unlink(missing_ok=True)
