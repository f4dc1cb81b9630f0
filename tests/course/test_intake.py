"""Submissions as systems deliver them, and as an attacker would."""

import json
import os
import zipfile

import pytest

from pgm_book.course import grade, intake
from pgm_book.make.notebooks import FOLDER
from tests.course import classroom

CODE = "def f():\n    return 1\n"
BOOK = classroom.as_json([CODE, "x = 2"])


@pytest.mark.parametrize(
    ("name", "student"),
    [
        ("Ada Lovelace_12345_assignsubmission_file_/lesson.ipynb", "Ada Lovelace"),
        ("Ada Lovelace_12345_assignsubmission_file_lesson.ipynb", "Ada Lovelace"),
        ("ada/ncc/lesson.ipynb", "ada"),  # nbgrader
        ("photogrammetry-2-ada/work/lesson.ipynb", "photogrammetry-2-ada"),
        ("ada.ipynb", "ada"),
    ],
)
def test_a_folder_or_a_zip_a_student(tmp_path, name, student):
    folder = tmp_path / "class"
    (folder / name).parent.mkdir(parents=True)
    (folder / name).write_bytes(BOOK)
    whole = tmp_path / "class.zip"
    whole.write_bytes(classroom.zipped(folder))
    inside, _, rest = name.partition("/")
    if rest:
        alone = tmp_path / "zips" / f"{inside}.zip"
        alone.parent.mkdir()
        alone.write_bytes(classroom.zipped(folder / inside))
    places = [folder, whole] + ([alone.parent] if rest else [])
    for place in places:
        (one,) = intake.read(place)
        assert one.student == student and one.remarks == ()
        assert one.notebooks[0].cells == (CODE, "x = 2")


def test_two_students_of_one_name_stay_two(tmp_path):
    for number, kind in ((7, "file"), (7, "onlinetext"), (8, "file")):
        folder = tmp_path / f"Ada_{number}_assignsubmission_{kind}_"
        folder.mkdir()
        (folder / "a.ipynb").write_bytes(BOOK)
    two = intake.read(tmp_path)
    assert [one.student for one in two] == ["Ada 7", "Ada 8"]
    assert [len(one.notebooks) for one in two] == [2, 1]


def test_program_and_results_are_read_and_nothing_else(tmp_path):
    folder = tmp_path / "ada"
    (folder / ".ipynb_checkpoints").mkdir(parents=True)
    (folder / ".ipynb_checkpoints" / "old.ipynb").write_bytes(BOOK)
    (folder / "notes.py").write_text("1 / 0")
    (folder / "my_pgm.py").write_text("\ufeffdef f(): return 'é'\n", encoding="utf-8")
    tries = [{"task": "2", "source": "first"}, {"task": "2", "source": "last"}]
    (folder / "my_results.json").write_text(json.dumps(tries))
    (one,) = intake.read(tmp_path)
    assert one.program == "def f(): return 'é'\n" and one.tasks == {"2": "last"}
    assert one.notebooks == ()


def test_what_changes_the_code_changes_the_hidden_inputs(tmp_path):
    (tmp_path / "ada").mkdir()
    digests = set()
    for code in ("x = 1", "x = 2"):
        (tmp_path / "ada" / "my_pgm.py").write_text(code)
        digests.add(intake.read(tmp_path)[0].digest())
    assert len(digests) == 2


def test_a_zip_that_leads_out_is_not_followed(tmp_path):
    with zipfile.ZipFile(tmp_path / "eva.zip", "w") as whole:
        whole.writestr("../up.ipynb", BOOK)
        whole.writestr("/etc/root.ipynb", BOOK)
        whole.writestr("a/../../b.ipynb", BOOK)
        link = zipfile.ZipInfo("my_pgm.py")
        link.external_attr = 0o120777 << 16
        whole.writestr(link, "/etc/passwd")
    (one,) = intake.read(tmp_path)
    assert one.notebooks == () and one.program == ""
    assert sum("leads out" in remark for remark in one.remarks) == 3
    assert sum("a link" in remark for remark in one.remarks) == 1


@pytest.mark.skipif(os.name != "posix", reason="links need rights on Windows")
def test_links_are_not_followed(tmp_path):
    key = tmp_path / "key.ipynb"
    key.write_bytes(BOOK)
    folder = tmp_path / "class"
    (folder / "eva").mkdir(parents=True)
    (folder / "eva" / "lesson.ipynb").symlink_to(key)
    (folder / "eva" / "more").symlink_to(tmp_path)
    (folder / "tom").symlink_to(tmp_path)
    for one in intake.read(folder):
        assert one.notebooks == () and "link" in one.remarks[0]


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ipynb", b"{"),
        ("a.ipynb", b'{"cells": 7}'),
        ("a.ipynb", b'{"cells": [{"cell_type": "code"}]}'),
        ("a.ipynb", b"[" * 100_000),
        (
            "a.ipynb",
            b'{"cells": [{"cell_type": "code", "source": "", "outputs": [""]}]}',
        ),
        ("a.ipynb", classroom.as_json(["x = 1"] * (intake.CELLS + 1))),
        ("a.ipynb", classroom.as_json(["x = 1\n" * intake.CODE])),
        ("my_pgm.py", b"x = 1\n" * intake.CODE),
        ("a.ipynb", b"\xff\xfe"),
        ("my_pgm.py", b"\xff\xfe"),
        ("my_results.json", b'{"task": 1}'),
        ("a.ipynb", b" " * (intake.LARGEST + 1)),
    ],
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, name, content):
    (tmp_path / "tom").mkdir()
    (tmp_path / "tom" / name).write_bytes(content)
    with zipfile.ZipFile(tmp_path / "eva.zip", "w", zipfile.ZIP_DEFLATED) as whole:
        whole.writestr(name, content)  # 20 MB of blanks take 20 kB
    for one in intake.read(tmp_path):
        assert one.notebooks == () and name in one.remarks[0]
        assert "not read" in one.remarks[0] or "cannot be read" in one.remarks[0]


def test_a_zip_with_spoilt_bytes_is_named(tmp_path):
    with zipfile.ZipFile(tmp_path / "ada.zip", "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("é.ipynb", BOOK)
    whole = (tmp_path / "ada.zip").read_bytes()
    begin = 30 + whole[26] + whole[28]  # after the head of its only file
    spoilt = {
        "eva": whole.replace("é".encode(), b"\xff\xff"),
        "tom": whole[:begin] + b"\xff" * 8 + whole[begin + 8 :],
    }
    for name, content in spoilt.items():
        (tmp_path / f"{name}.zip").write_bytes(content)
    _, eva, tom = intake.read(tmp_path)
    assert "not a zip" in eva.remarks[0]
    assert "not a zip" in tom.remarks[0]


def test_the_files_of_a_student_have_a_limit_in_all(tmp_path, monkeypatch):
    monkeypatch.setattr(intake, "ROOM", 2 * len(BOOK))
    (tmp_path / "eva").mkdir()
    for name in "abc":
        (tmp_path / "eva" / f"{name}.ipynb").write_bytes(BOOK)
    (one,) = intake.read(tmp_path)
    assert len(one.notebooks) == 2
    assert one.remarks == ("c.ipynb: too much in all, not read",)


@pytest.mark.parametrize("nested", [False, True])
def test_a_zip_with_too_much_in_it_is_not_unpacked(tmp_path, monkeypatch, nested):
    large = b" " * intake.LARGEST  # 20 kB in the zip
    many = {f"{k}.ipynb": large for k in range(6)}
    few = {"a.ipynb": BOOK} | {f"{k}.pdf": b"" for k in range(intake.MOST)}
    opened = []
    read = zipfile.ZipFile.read
    monkeypatch.setattr(
        zipfile.ZipFile, "read", lambda *a, **k: opened.append(a[1]) or read(*a, **k)
    )
    monkeypatch.setattr(intake, "MEMBERS", 200)
    for who, content in {
        "eva": many,
        "ida": {f"{k}.ipynb": BOOK for k in range(intake.MOST + 1)},
        "ada": few,
        "tom": {f"{k}.pdf": b"" for k in range(intake.MEMBERS + 1)},
    }.items():
        folder = tmp_path / "class" / who
        folder.mkdir(parents=True)
        with zipfile.ZipFile(folder / "all.zip", "w", zipfile.ZIP_DEFLATED) as whole:
            for name, text in content.items():
                whole.writestr(name, text)
    place = tmp_path / "class"
    if nested:
        place = tmp_path / "class.zip"
        place.write_bytes(classroom.zipped(tmp_path / "class"))
    ada, *others = intake.read(place)
    assert len(ada.notebooks) == 1 and ada.remarks == ()
    for one in others:
        assert one.notebooks == () and len(one.remarks) == 2  # and: nothing was read
        assert "all.zip: more than 100 files, or 100 MB, in it" in one.remarks[0]
    assert {name.filename for name in opened if not name.filename.endswith("zip")} == {
        "a.ipynb"
    }


def test_many_empty_lines_are_read_at_once():
    cell = "\n" * 100_000 + "f("
    assert intake.python_of(cell) == cell


def test_no_submission_and_no_zip_are_said(tmp_path):
    with pytest.raises(ValueError, match="no submission was found"):
        intake.read(tmp_path)
    with pytest.raises(ValueError, match="there is no such folder"):
        intake.read(tmp_path / "missing")
    (tmp_path / "eva.zip").write_bytes(b"PK no zip")
    assert "not a zip" in intake.read(tmp_path)[0].remarks[0]


def test_lines_of_a_notebook_alone_do_not_stop_a_cell():
    cell = "%matplotlib inline\n!ls\nif x:\n    %time f()\nf?\ny = 5 % 3"
    read = intake.python_of(cell)
    compile(read, "cell", "exec")
    assert read.count("pass") == 3 and read.endswith("\nf\ny = 5 % 3")
    valid = "a = 5 \\\n% 3"
    assert intake.python_of(valid) == valid


def test_only_the_cells_that_a_name_needs():
    cells = (
        "import numpy as np",
        "heavy = np.ones(9)",
        "def g(x): return h(x)",
        "def f(x): return g(x) + np.pi",
        "def h(x): return x",
        "print(heavy)",
        "f(",
        "mine.hand_in(f(2))",
    )
    assert intake.needed(cells, {"f"}) == [cells[k] for k in (0, 2, 3, 4)]
    assert intake.needed(cells, set(), True) == [cells[k] for k in (0, 2, 3, 4, 7)]
    assert intake.needed(cells, {"missing"}) == []


def test_a_cell_that_gives_a_name_another_value_later_is_not_run():
    cells = (
        "n, table = 1, []",
        "n += 1",
        "if n: n = 3",
        "for k in range(9): table.append(k)",
        "table[0] = n",
        "heavy = [n for n in range(10**9)]\nk = 5",
        "def f(x): return table[x + n]",
        "n = table = 0\nprint(f(1))",
        "k = 7\nfor k in range(k): print(k)",
    )
    assert intake.needed(cells, {"f"}) == [cells[k] for k in (0, 1, 2, 3, 4, 6)]
    assert intake.needed(cells, {"k"}) == [cells[8]]
    assert intake.needed((*cells, cells[6]), {"f"})[-2:] == [cells[7], cells[6]]


def test_a_notebook_is_known_by_its_cells_or_its_name():
    names = {"02_normalized_cross_correlation": "2", "06_case_eleven_defects": "6c"}
    for stem, lesson in names.items():
        content = (FOLDER / f"{stem}.ipynb").read_bytes()
        assert grade.lesson_of(intake._notebook("renamed (1).ipynb", content)) == lesson
        assert grade.lesson_of(intake._notebook(f"{stem}-1.ipynb", BOOK)) == lesson
    assert grade.lesson_of(intake._notebook("other.ipynb", BOOK)) == ""


def test_whoever_handed_in_anything_has_a_row(tmp_path):
    folder = tmp_path / "class"
    for name in ("Ada_1_assignsubmission_file_", "Bob_2_assignsubmission_file_", "Eva"):
        (folder / name).mkdir(parents=True)
    (folder / "Ada_1_assignsubmission_file_" / "report.pdf").write_bytes(b"%PDF")
    inner = tmp_path / "inner"
    inner.mkdir()
    (inner / "lesson.IPYNB").write_bytes(BOOK)
    zipped = classroom.zipped(inner)
    (folder / "Bob_2_assignsubmission_file_" / "all.zip").write_bytes(zipped)
    whole = tmp_path / "class.zip"
    whole.write_bytes(classroom.zipped(folder))
    ada, bob, eva = intake.read(folder)
    assert [ada.student, bob.student, eva.student] == ["Ada", "Bob", "Eva"]
    assert ada.remarks == eva.remarks == (intake.NOTHING_READ,)
    assert bob.notebooks[0].cells == (CODE, "x = 2") and bob.remarks == ()
    ada, bob = intake.read(whole)
    assert ada.remarks == (intake.NOTHING_READ,)
    assert bob.notebooks[0].cells == (CODE, "x = 2")
