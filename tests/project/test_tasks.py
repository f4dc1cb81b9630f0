"""tasks.py, the Makefile and the upkeep of .venv, without installing anything."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys

import pytest

from tools import commands, environment

ROOT = environment.ROOT


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A project folder in which commands are noted instead of run."""
    calls = []

    def note(command, cwd=None):
        calls.append([str(part) for part in command])
        if "venv" in calls[-1]:
            python = environment.python_of(tmp_path / ".venv")
            python.parent.mkdir(parents=True, exist_ok=True)
            python.touch()

    for name in ("requirements.txt", "requirements-publish.txt"):
        (tmp_path / name).write_text("numpy==2.0.0\n")
    (tmp_path / "pyproject.toml").write_text(
        '[project.optional-dependencies]\ndev = ["uv"]\n'
    )
    monkeypatch.setattr(environment, "call", note)
    return calls


def ensure(tmp_path, calls, *sets):
    """What `ensure` ran, in short: the last two words of each command."""
    calls.clear()
    environment.ensure(".venv", *sets, root=tmp_path)
    return [" ".join(call[-2:]) for call in calls]


def first_time(tmp_path):
    return [
        f"--clear {tmp_path / '.venv'}",
        "-r requirements.txt",
        f"-e {tmp_path}",
    ]


def test_the_first_run_makes_the_environment(tmp_path, made):
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def test_an_up_to_date_environment_is_left_alone(tmp_path, made):
    ensure(tmp_path, made, "main")
    assert ensure(tmp_path, made, "main") == []


def test_publishing_is_installed_only_when_asked_for(tmp_path, made):
    ensure(tmp_path, made, "main")
    assert ensure(tmp_path, made, "main", "publish") == ["-r requirements-publish.txt"]
    assert ensure(tmp_path, made, "main", "publish") == []
    assert ensure(tmp_path, made, "main") == []


def test_the_dev_extra_comes_from_pyproject(tmp_path, made):
    ensure(tmp_path, made, "main")
    assert ensure(tmp_path, made, "main", "dev") == ["--no-user uv"]


@pytest.mark.parametrize("name", ["requirements.txt", "pyproject.toml"])
def test_a_changed_file_makes_it_stale(tmp_path, made, name):
    ensure(tmp_path, made, "main")
    with open(tmp_path / name, "a") as file:
        file.write("\n")
    assert "-r requirements.txt" in ensure(tmp_path, made, "main")


def test_another_python_makes_it_stale(tmp_path, made, monkeypatch):
    ensure(tmp_path, made, "main")
    monkeypatch.setattr(sys, "version", "3.99.0 (a later one)")
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def test_a_damaged_stamp_makes_it_stale(tmp_path, made):
    ensure(tmp_path, made, "main")
    for damaged in ("", "[]", '{"fingerprint": 1}', "\0"):
        (tmp_path / ".venv" / "pgm_lab_stamp.json").write_text(damaged)
        assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def test_a_lost_python_makes_it_stale(tmp_path, made):
    ensure(tmp_path, made, "main")
    environment.python_of(tmp_path / ".venv").unlink()
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def test_a_failed_installation_leaves_no_stamp(tmp_path, made, monkeypatch):
    def fail(python, arguments):
        raise subprocess.CalledProcessError(1, ["pip"])

    with monkeypatch.context() as broken:
        broken.setattr(environment, "pip", fail)
        with pytest.raises(subprocess.CalledProcessError):
            ensure(tmp_path, made, "main")
    assert not (tmp_path / ".venv" / "pgm_lab_stamp.json").exists()
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def test_a_usable_environment_is_not_made_again(tmp_path, monkeypatch):
    venv = tmp_path / ".venv"
    venv.mkdir()
    monkeypatch.setattr(environment, "has_pip", lambda venv: True)
    version = ".".join(map(str, sys.version_info[:3]))
    for text, usable in {
        f"version = {version}\ncommand = python -m venv {venv}\n": True,
        f"version = {version}\ncommand = python -m venv /elsewhere\n": False,
        f"version = 3.9.1\ncommand = python -m venv {venv}\n": False,
        "": False,
    }.items():
        (venv / "pyvenv.cfg").write_text(text)
        assert environment.is_usable(venv) is usable


def test_an_environment_without_pip_is_not_usable(tmp_path):
    assert not environment.has_pip(tmp_path)


def test_settings_of_the_caller_do_not_reach_the_tests(monkeypatch):
    for name in environment.DISTURBING:
        monkeypatch.setenv(name, "something")
    monkeypatch.setenv("SOMETHING_ELSE", "kept")
    seen = environment.environment(EXTRA="1")
    assert not set(environment.DISTURBING) & set(seen)
    assert seen["PYTHONUTF8"] == "1"
    assert (seen["SOMETHING_ELSE"], seen["EXTRA"]) == ("kept", "1")


def test_pip_installs_into_the_environment_whatever_its_settings(tmp_path, monkeypatch):
    """With ``user = true`` pip would refuse, or install for the user."""
    settings = tmp_path / "pip.conf"
    settings.write_text("[global]\nuser = true\nno-index = true\n")
    monkeypatch.setenv("PIP_CONFIG_FILE", str(settings))
    monkeypatch.setattr(environment, "call", run_dry := DryRun())
    environment.pip(environment.Path(sys.executable), ["pip"])
    assert run_dry.code == 0


class DryRun:
    """Run a command of pip without installing anything, and keep its exit code."""

    def __call__(self, command, cwd=None):
        command = [*map(str, command), "--dry-run"]
        self.code = subprocess.run(command, env=environment.environment()).returncode


def test_tasks_start_where_python_does_not_look_beside_its_file(tmp_path):
    """With PYTHONSAFEPATH set, and from any folder."""
    result = subprocess.run(
        [sys.executable, ROOT / "tasks.py"],
        cwd=tmp_path,
        env=environment.environment(PYTHONSAFEPATH="1"),
        capture_output=True,
        text=True,
    )
    assert result.returncode == 0, result.stderr
    assert "make NAME" in result.stdout


@pytest.mark.parametrize("character_set", ["cp1252", "ascii", "latin-1"])
def test_the_tick_of_a_check_can_be_printed_everywhere(monkeypatch, character_set):
    """Whatever the caller's character set, what a task runs prints in UTF-8."""
    monkeypatch.setenv("PYTHONIOENCODING", character_set)
    monkeypatch.setenv("PYTHONUTF8", "0")
    code = "from pgm_lab.checks import chapter1; chapter1.corner((11.8, -7.9))"
    result = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        env=environment.environment(),
        capture_output=True,
    )
    assert result.returncode == 0, result.stderr
    assert "✓" in result.stdout.decode("utf-8")


def test_a_failed_setup_ends_in_plain_words(monkeypatch, capsys):
    def fail(*arguments):
        raise subprocess.CalledProcessError(1, ["pip", "install"])

    monkeypatch.setitem(commands.TASKS, "test", fail)
    assert commands.main(["test"]) == 1
    assert "could not be set up: pip install" in capsys.readouterr().err


@pytest.mark.parametrize("task", ["test", "test-publish"])
def test_a_failing_test_fails_its_task(monkeypatch, task):
    commands_run = []

    def fail(command, *arguments, **options):
        commands_run.append([str(part) for part in command])
        return 1 if "pytest" in command else 0

    monkeypatch.setattr(commands, "ensure", lambda *sets: environment.ROOT / "a/b/c")
    monkeypatch.setattr(commands, "settings", lambda python: {})
    monkeypatch.setattr(commands, "run", fail)
    assert commands.main([task, "-k", "something"]) == 1
    assert commands_run[-1][-2:] == ["-k", "something"]


@pytest.mark.parametrize("inside", [True, False])
def test_root_opens_the_lab_in_a_container_only(monkeypatch, tmp_path, inside):
    commands_run = []
    python = environment.python_of(tmp_path / ".venv")
    monkeypatch.setattr(commands, "ROOT", tmp_path)
    monkeypatch.setattr(commands, "ensure", lambda *sets: python)
    monkeypatch.setattr(commands, "in_container", lambda: inside)
    monkeypatch.setattr(
        commands, "run", lambda command, **options: commands_run.append(command) or 0
    )
    assert commands.lab() == 0
    assert ("--allow-root" in commands_run[-1]) == inside


def test_a_container_is_known_by_its_marks(monkeypatch):
    monkeypatch.setattr(commands.Path, "exists", lambda path: False)
    monkeypatch.delenv("container", raising=False)
    assert not commands.in_container()
    monkeypatch.setenv("container", "podman")
    assert commands.in_container()


def test_the_actions_of_the_workflows_are_pinned_by_commit():
    """A tag can be moved to another commit, a commit cannot be changed."""
    files = (ROOT / ".github/workflows").glob("*.yml")
    text = "".join(file.read_text(encoding="utf-8") for file in files)
    used = re.findall(r"uses: (.*)", text)
    pinned = re.compile(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+")
    assert len(used) == 8
    assert [line for line in used if not pinned.fullmatch(line)] == []


@pytest.mark.skipif(os.name == "nt", reason=".ci/run is a script for bash")
@pytest.mark.parametrize(("code", "found"), [(0, True), (1, False), (None, False)])
def test_only_a_browser_that_starts_counts(tmp_path, code, found):
    """Ubuntu's chromium asks for a snap and ends with an error."""
    script = (ROOT / ".ci/run").read_text(encoding="utf-8")
    function = re.search(r"^has_browser\(\) \{.*?^\}", script, re.S | re.M)[0]
    if code is not None:
        stub = tmp_path / "chromium-browser"
        stub.write_text(f"#!/bin/sh\nexit {code}\n")
        stub.chmod(0o755)
    bash = shutil.which("bash")
    done = subprocess.run(
        [bash, "-c", function + "\nhas_browser"], env={"PATH": str(tmp_path)}
    )
    assert (done.returncode == 0) == found


def test_an_unknown_task_is_answered_with_the_list(capsys):
    assert commands.main(["tset"]) == 2
    shown = capsys.readouterr().out
    assert "no task 'tset'" in shown
    assert all(f"  {name} " in shown for name in commands.TASKS)


def test_makefile_and_tasks_have_the_same_names():
    text = (ROOT / "Makefile").read_text(encoding="utf-8").replace("\\\n", " ")
    names = re.search(r"^TASKS = (.*)$", text, re.MULTILINE)[1].split()
    assert names == list(commands.TASKS)


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


def test_the_environment_variables_of_a_run_are_text(tmp_path):
    settings = commands.settings(environment.python_of(tmp_path / ".venv"))
    assert settings["OMP_NUM_THREADS"] == "1"
    assert os.path.isdir(settings["IPYTHONDIR"])
    assert json.dumps(settings)
