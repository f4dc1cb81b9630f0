"""The box: a student's code computes in it, and can do nothing else."""

import os
import time

import numpy as np
import pytest

from pgm_book.course import box, library
from pgm_lab import ncc

WHY = box.closed()
needs_box = pytest.mark.skipif(bool(WHY), reason=WHY or "there is a box")


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    place = tmp_path_factory.mktemp("libraries")
    whole, less = place / "library", place / "less"
    whole.mkdir()
    library.write_library(whole)
    library.without(whole, less, ["pgm_lab.ncc.correlation"])
    return {"whole": whole, "less": less}


@pytest.fixture(
    params=[pytest.param(False, marks=needs_box), True], ids=["box", "trusted"]
)
def open_box(request, places):
    def opened(code, name="whole"):
        made = box.Box(places[name], trusted=request.param)
        with_files = {"seen.txt": b"a file".hex()}
        made.errors = made.ask(30, do="load", cells=[code], files=with_files)
        boxes.append(made)
        return made

    boxes = []
    yield opened
    for one in boxes:
        one.__exit__()


@pytest.fixture
def attacked(places):
    """Return what an attack, a function without arguments, comes to in a box."""

    def result(code):
        with box.Box(places["whole"]) as made:
            made.ask(30, do="load", cells=[code], files={})
            try:
                return made.function("f")(), made.remarks
            except Exception as error:
                return error, made.remarks

    return result


def test_a_function_computes_with_arrays_and_gives_its_answer(open_box):
    code = "def f(a, b=1, *, c): return {'sum': a + b, 'c': [c, (a.shape,)]}"
    f = open_box(code).function("f")
    a = np.arange(6.0).reshape(2, 3)
    found = f(a, 2, c="text")
    np.testing.assert_equal(found, {"sum": a + 2, "c": ["text", ((2, 3),)]})
    assert f.__name__ == "f" and f.boxed


def test_changed_input_is_seen_outside(open_box):
    a = np.zeros(3)
    open_box("def f(a):\n    a[1] = 5\n    return 0").function("f")(a)
    assert a.tolist() == [0, 5, 0]


def test_a_function_of_the_judges_is_called_from_inside(open_box):
    f = open_box("def f(g, x): return g(x) + g(2 * x)").function("f")
    assert f(lambda x: x**2, 3.0) == 9 + 36
    with pytest.raises(ValueError, match="negative"):
        f(lambda x: _refuse("negative"), 3.0)


def _refuse(why):
    raise ValueError(why)


@pytest.mark.parametrize(
    ("code", "kind", "said"),
    [
        ("1 / 0", ZeroDivisionError, "division"),
        ("missing", NameError, "missing"),
        ("np.linalg.inv(np.zeros((2, 2)))", np.linalg.LinAlgError, "Singular"),
        ("(_ for _ in ()).throw(type('Mine', (KeyError,), {})('k'))", KeyError, "k"),
        ("object()", TypeError, "no plain data: object"),
        ("sys.exit(7)", RuntimeError, "SystemExit: 7"),
        ("['x' * 99] * 10**5", RuntimeError, "too large"),
    ],
)  # fmt: skip
def test_errors_come_out_as_what_they_are(open_box, code, kind, said):
    f = open_box(f"import sys\nimport numpy as np\ndef f(): return {code}").function(
        "f"
    )
    with pytest.raises((kind, box.NoAnswer), match=said):
        f()


def test_a_cell_that_stops_is_named_and_the_others_run(open_box):
    made = open_box("raise SystemExit('bye')")
    assert made.errors == [[0, "SystemExit", "bye", ""]]
    assert made.ask(5, do="load", cells=["x = open('seen.txt').read()"], files={}) == []
    assert made.ask(5, do="value", name="x") == "a file"


def test_who_takes_too_long_is_stopped_and_stays_so(open_box, monkeypatch):
    monkeypatch.setattr(box, "CALLING", 0.5)
    f = open_box("def f():\n    while True: pass").function("f")
    begin = time.monotonic()
    for _ in range(2):
        with pytest.raises(box.NoAnswer, match="gave no answer in"):
            f()
    assert time.monotonic() - begin < 5


@pytest.mark.slow
def test_many_slow_answers_are_stopped_as_one_is(open_box, monkeypatch):
    monkeypatch.setattr(box, "WHOLE", 1.5)
    f = open_box("import time\ndef f(): time.sleep(0.4)").function("f")
    with pytest.raises(box.NoAnswer, match="seconds in all"):
        for _ in range(9):
            f()


def test_the_books_own_function_is_not_compiled_either(places):
    compiled = "pgm_lab/ncc/__pycache__/_windows.*.pyc"
    assert list(places["whole"].glob(compiled))
    assert not list(places["less"].glob(compiled))


def test_the_books_own_function_is_not_there_when_it_is_asked_for(open_box):
    code = (
        "import pgm_lab.ncc\nfrom pgm_lab import ncc\n"
        "def f(a, b): return ncc.correlation(a, b)\n"
        "def g(a, b):\n    from importlib import import_module as load\n"
        "    return load('pgm_lab.ncc').correlation(a, b)\n"
    )
    a, b = np.random.default_rng(1).normal(size=(2, 3, 4))
    for name in ("f", "g"):
        assert open_box(code).function(name)(a, b) == ncc.correlation(a, b)
        less = open_box(code, "less")
        with pytest.raises(box.BooksOwn, match="correlation is the book's own"):
            less.function(name)(a, b)
        assert less.remarks == ["calls the book's own function"]


def test_the_library_knows_no_answer(places):
    files = [path for path in places["whole"].rglob("*.py") if path.is_file()]
    names = {path.relative_to(places["whole"]).as_posix() for path in files}
    assert {"pgm_book/program/bundle.py", "pgm_book/ch02/checks.py"} <= names
    for path in files:
        text = path.read_text(encoding="utf-8")
        if (
            path.stem.removeprefix("case_") in library.LEFT_OUT
            and "ch" in path.parent.name
        ):
            assert "def " not in text, path
    assert not list(places["whole"].rglob("predictions.csv"))
    assert not [n for n in names if "course" in n or n.startswith("pgm_book/make")]


# --- Attacks: they find nothing, reach nobody and leave nothing ---


BEFORE = """
import ctypes, multiprocessing, os, socket, subprocess
import numpy as np

def write(line):  # where the answers go
    for number in range(3, 9):
        try:
            os.write(number, line + bytes([10]))
        except OSError:
            pass

"""


@needs_box
@pytest.mark.parametrize(
    ("code", "remark"),
    [
        ("os.fork()", "another process"),
        ("subprocess.run(['id'])", "another process"),
        ("__import__('threading').Thread(target=print).start()", "a thread"),
        ("os.posix_spawn('/usr/bin/id', ['id'], {})", "another process"),
        ("os.system('id') and 1 / 0", "ZeroDivisionError"),
        (
            "multiprocessing.get_context('fork').Process(target=print).start()",
            "process",
        ),
        ("os.memfd_create('x')", "another process"),
        ("1 / (ctypes.CDLL(None).shmget(0, 4096, 0o1600) + 1)", "ZeroDivisionError"),
        ("socket.create_connection(('192.0.2.1', 80), 1)", "network"),
        ("np.ones(3 * 2**27)", "memory"),
        ("open('/library/pgm_lab/__init__.py', 'w')", "outside its folder"),
        ("open('/box/worker.py', 'a')", "outside its folder"),
        ("open('/anywhere', 'w')", "outside its folder"),
        ("open('/dev/shm/x', 'w')", "outside its folder"),
        ("[open(str(k), 'wb').write(bytes(2**23)) for k in range(99)]", "64 MB"),
        ("open('one', 'wb').write(bytes(2**25))", "16 MB"),
        ("os._exit(0)", "ended its process"),
        ("os.kill(os.getpid(), 9)", "ended its process"),
        ("write(b'no json')", "not readable"),
        ("write(b'[' * 10**5)", "not readable"),
        ("write(b'[' * 10**5 + b']' * 10**5)", "not readable"),
        ("write(b'9' * 10**5)", "not readable"),
        ("write(b'x' * 10**7)", "too long"),
        ("'x' * 10**8", "too large"),
    ],
)
def test_an_attack_is_refused_and_named(attacked, code, remark):
    found, remarks = attacked(f"{BEFORE}def f(): return {code}")
    assert isinstance(found, Exception)
    assert any(remark in one for one in remarks), (found, remarks)


@needs_box
def test_what_an_error_says_is_short(attacked):
    line = "b'{\"error\": [\"KeyError\", \"' + b'x' * 10**6 + b'\"]}'"
    found, remarks = attacked(f"{BEFORE}def f(): write({line})")
    assert len(str(found)) < 999 and len(remarks[0]) < 999


@needs_box
@pytest.mark.parametrize(
    ("code", "seen"),
    [
        ("sorted(os.listdir('/home'))", ["student"]),
        ("os.listdir()", []),
        ("[one for one in ('/etc', '/tmp', '/sys') if os.path.exists(one)]", []),
        ("os.environ.get('SECRET_WORD')", None),
        ("[one for one in ('/proc', '/proc/1/mem') if os.path.exists(one)]", []),
        ("os.path.exists(FOLDER)", False),
    ],
)
def test_there_is_nothing_to_be_found(attacked, code, seen, monkeypatch, tmp_path):
    monkeypatch.setenv("SECRET_WORD", "word")
    found, _ = attacked(f"{BEFORE}FOLDER = {str(tmp_path)!r}\ndef f(): return {code}")
    assert found == seen


@needs_box
def test_nothing_stays_behind(places, tmp_path):
    with box.Box(places["whole"]) as made:
        folder = made.folder.name
        made.ask(30, do="load", cells=["open('left', 'w').write('x')"], files={})
        assert os.listdir(folder) == []  # its room lies in memory
        number = made.process.pid
    assert not os.path.exists(folder)
    with pytest.raises(ProcessLookupError):
        os.kill(number, 0)
