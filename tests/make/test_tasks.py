"""tasks.py, the Makefile and what each task runs."""

import ast
import re
import subprocess
import sys

import pytest

from pgm_book.make import commands, environment

ROOT = environment.ROOT


@pytest.fixture
def tried(monkeypatch):
    """What tasks run is noted instead; `tried["fails"]` ends with 1."""
    noted = {"run": [], "fails": None}

    def started(command, *arguments, **options):
        noted["run"].append([str(part) for part in command])
        return noted["fails"] in noted["run"][-1]

    monkeypatch.setattr(commands, "ensure", lambda *sets: ROOT / "a/b/c")
    monkeypatch.setattr(commands, "settings", lambda python: {})
    monkeypatch.setattr(commands, "started", started)
    monkeypatch.setattr(commands, "waited_for", int)
    return noted


def test_tasks_start_where_python_does_not_look_beside_its_file(tmp_path):
    """With PYTHONSAFEPATH set, from any folder, with the standard library alone."""
    result = subprocess.run(
        [sys.executable, "-S", ROOT / "tasks.py"],
        cwd=tmp_path,
        env=environment.environment(PYTHONSAFEPATH="1"),
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    assert "make NAME" in result.stdout


def test_an_old_python_gets_a_clear_message():
    text = (ROOT / "tasks.py").read_text(encoding="utf-8")
    ast.parse(text, feature_version=(3, 4))
    pretend = "import sys; sys.version_info = (3, 10, 4); sys.argv = ['tasks.py']; "
    code = pretend + "import runpy; runpy.run_path('tasks.py', run_name='__main__')"
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True
    )
    assert result.returncode == 1
    assert "needs Python 3.11 or newer; this is Python 3.10" in result.stderr


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (
            subprocess.CalledProcessError(1, ["pip", "install"]),
            "could not be set up: pip install",
        ),
        (environment.Refused("/a/.venv is a file. Move it."), "\n/a/.venv is a file. "),
    ],
)
def test_a_failed_setup_ends_in_plain_words(monkeypatch, capsys, error, said):
    def fail(*arguments):
        raise error

    monkeypatch.setitem(commands.TASKS, "test", fail)
    assert commands.main(["test"]) == 1
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("task", ["test", "test-slow", "test-all", "test-publish"])
def test_a_failing_test_fails_its_task(tried, task):
    tried["fails"] = "pytest"
    assert commands.main([task, "-k", "something"]) == 1
    assert tried["run"][-1][-2:] == ["-k", "something"]


@pytest.mark.parametrize("part", ["mypy", "check", "format"])
def test_wrong_types_and_bad_style_fail_the_test(tried, part):
    tried["fails"] = part
    assert commands.main(["test"]) == 1


def test_all_the_tests_are_run_by_one_task_or_the_other(tried):
    """What `test` leaves out `test-slow` runs, and `test-all` runs all three."""
    assert commands.main(["test-all"]) == 0
    chosen = [" ".join(command) for command in tried["run"] if "pytest" in command]
    marks = [("-m not slow" in one, "-m slow" in one) for one in chosen]
    assert marks == [(True, False), (False, True), (False, False)]
    assert "tests/publish" in chosen[2]


@pytest.mark.parametrize(
    ("word", "among"),
    [
        ("3", ["notebooks/03_least_squares_matching.ipynb", "tests/audit/test_bani"]),
        ("A1", ["notebooks/A1_least_squares_adjustment.ipynb"]),
        ("8", ["tests/audit/test_harintaka"]),  # with rows that no test proves
        ("ncc", ["tests/ncc", "pgm_lab/ncc"]),
        ("make", ["tests/make"]),
        ("common", ["tests/common", "pgm_book/common"]),
        ("tests/ncc", ["tests/ncc"]),
    ],
)
def test_one_lesson_or_room_is_tested_alone(tried, word, among):
    assert commands.main(["test", word, "-x"]) == 0
    (command,) = tried["run"]
    chosen = command[command.index("not slow") + 1 :]
    for path in among:
        assert any(one.startswith(path) for one in chosen)
    assert chosen[-1] == "-x"
    paths = [ROOT / one.partition("::")[0] for one in chosen[:-1]]
    assert all(path.exists() for path in paths)


def test_the_actions_of_the_workflows_are_pinned_by_commit():
    """A tag can be moved to another commit, a commit cannot be changed."""
    files = (ROOT / ".github/workflows").glob("*.yml")
    text = "".join(file.read_text(encoding="utf-8") for file in files)
    used = re.findall(r"uses: (.*)", text)
    pinned = re.compile(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+")
    assert used and [line for line in used if not pinned.fullmatch(line)] == []


def test_an_unknown_task_is_answered_with_the_list(capsys):
    assert commands.main(["tset"]) == 2
    shown = capsys.readouterr().out
    assert "no task 'tset'" in shown
    assert all(f"  {name} " in shown for name in commands.TASKS)


def test_makefile_and_tasks_have_the_same_names():
    text = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
    names = re.search(r"^TASKS = (.*)$", text, re.MULTILINE)[1].split()
    assert names == list(commands.TASKS)
