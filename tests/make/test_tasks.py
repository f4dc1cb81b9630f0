"""tasks.py, the Makefile and the upkeep of .venv, without installing anything."""

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig

import pytest

from pgm_book.make import commands, environment

ROOT = environment.ROOT


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A project folder in which commands are noted instead of run."""
    calls = []

    def note(command, cwd=None, quiet=False):
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
    monkeypatch.setattr(environment, "has_own_index", lambda python: False)
    return calls


def ensure(tmp_path, calls, *sets):
    """What `ensure` ran, in short: who, and the last word of the command."""
    calls.clear()
    environment.ensure(".venv", *sets, root=tmp_path)
    return short(calls)


def short(calls):
    return [f"{call[2]} {call[-1]}" for call in calls]


def first_time(tmp_path):
    return [
        f"venv {tmp_path / '.venv'}",
        "pip requirements-uv.txt",
        "uv requirements.txt",
        f"uv {tmp_path}",
    ]


def link(path, target):
    """A symbolic link to a folder, where this user may make one."""
    try:
        path.symlink_to(target, target_is_directory=True)
    except OSError:
        pytest.skip("this user may not make symbolic links")


def test_the_first_run_makes_the_environment(tmp_path, made):
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)
    assert made[0] == [sys.executable, "-m", "venv", str(tmp_path / ".venv")]


def test_an_up_to_date_environment_is_left_alone(tmp_path, made):
    ensure(tmp_path, made, "main")
    assert ensure(tmp_path, made, "main") == []


def test_publishing_is_installed_only_when_asked_for(tmp_path, made):
    ensure(tmp_path, made, "main")
    assert "uv requirements-publish.txt" in ensure(tmp_path, made, "main", "publish")
    assert ensure(tmp_path, made, "main", "publish") == []
    assert ensure(tmp_path, made, "main") == []


def test_the_dev_extra_comes_from_pyproject(tmp_path, made):
    ensure(tmp_path, made, "main")
    assert "uv uv" in ensure(tmp_path, made, "main", "dev")


@pytest.mark.parametrize("name", ["requirements.txt", "pyproject.toml"])
def test_a_changed_file_makes_it_stale(tmp_path, made, name):
    ensure(tmp_path, made, "main")
    with open(tmp_path / name, "a") as file:
        file.write("\n")
    assert "uv requirements.txt" in ensure(tmp_path, made, "main")


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
    def fail(python, arguments, quiet=False):
        raise subprocess.CalledProcessError(1, ["pip"])

    with monkeypatch.context() as broken:
        broken.setattr(environment, "pip", fail)
        with pytest.raises(subprocess.CalledProcessError):
            ensure(tmp_path, made, "main")
    assert not (tmp_path / ".venv" / environment.STAMP).exists()
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def refusal(tmp_path, calls):
    """How a folder is refused, with nothing run and nothing left behind."""
    with pytest.raises(environment.Refused) as refused:
        ensure(tmp_path, calls, "main")
    assert calls == []
    assert not (tmp_path / ".venv" / environment.MARK).exists()
    message = str(refused.value)
    assert "Move or delete it yourself, then run the task again." in message
    return message


@pytest.mark.parametrize("mark", [None, environment.MARK, environment.STAMP])
def test_a_link_is_refused_and_its_target_survives(tmp_path, made, mark):
    """Even where the target was made here: nobody knows who else uses it."""
    target = tmp_path / "elsewhere"
    target.mkdir()
    (target / "thesis.txt").write_text("three years")
    if mark:
        (target / mark).write_text("")
    link(tmp_path / ".venv", target)
    before = sorted(target.iterdir())
    with pytest.raises(environment.Refused, match=r"\.venv is a link to another place"):
        ensure(tmp_path, made, "main")
    assert made == []
    assert sorted(target.iterdir()) == before
    assert (target / "thesis.txt").read_text() == "three years"
    assert (tmp_path / ".venv").is_symlink()


def test_a_link_to_nowhere_is_refused(tmp_path, made):
    link(tmp_path / ".venv", tmp_path / "nowhere")
    assert "is a link to another place" in refusal(tmp_path, made)
    assert not (tmp_path / "nowhere").exists()


def test_a_junction_counts_as_a_link(tmp_path, monkeypatch):
    """Python 3.11 takes a junction of Windows for a folder; its tag tells."""
    assert not environment.is_link(tmp_path)
    found = os.lstat(tmp_path)

    class Junction:
        st_mode, st_reparse_tag = found.st_mode, environment.JUNCTION

    monkeypatch.setattr(environment.os, "lstat", lambda path: Junction)
    assert environment.is_link(tmp_path)


def test_a_file_is_refused(tmp_path, made):
    (tmp_path / ".venv").write_text("mine")
    assert "is a file" in refusal(tmp_path, made)
    assert (tmp_path / ".venv").read_text() == "mine"


def test_a_folder_that_was_not_made_here_is_refused(tmp_path, made):
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "pyvenv.cfg").write_text("home = /usr/bin")
    assert "this project has not made" in refusal(tmp_path, made)
    assert os.listdir(tmp_path / ".venv") == ["pyvenv.cfg"]


def test_an_empty_folder_is_taken(tmp_path, made):
    (tmp_path / ".venv").mkdir()
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


@pytest.mark.parametrize("mark", [environment.MARK, environment.STAMP])
def test_a_marked_folder_is_emptied_without_following_links(tmp_path, made, mark):
    """What an interruption leaves behind goes, what a link in it points at stays."""
    venv, mine = tmp_path / ".venv", tmp_path / "mine"
    (venv / "lib" / "deep").mkdir(parents=True)
    mine.mkdir()
    (mine / "thesis.txt").write_text("three years")
    (venv / mark).write_text("")
    (venv / "half.whl").write_text("half a packa")
    link(venv / "link", mine)
    link(venv / "lib" / "deep" / "link", mine)
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)
    assert (mine / "thesis.txt").read_text() == "three years"
    bin_name = environment.python_of(venv).parent.name
    assert {path.name for path in venv.iterdir()} == {
        environment.MARK,
        environment.STAMP,
        bin_name,
    }


def test_a_moved_environment_is_made_again(tmp_path, made, monkeypatch):
    project, moved = tmp_path / "project", tmp_path / "moved"
    project.mkdir()
    for path in [*tmp_path.glob("*.txt"), tmp_path / "pyproject.toml"]:
        path.rename(project / path.name)
    python = environment.python_of(project / ".venv")
    python.parent.mkdir(parents=True)
    (project / ".venv" / environment.MARK).touch()
    environment.ensure(".venv", "main", root=project)
    python.parent.mkdir(parents=True, exist_ok=True)
    python.touch()
    assert ensure(project, made, "main") == []
    project.rename(moved)
    assert ensure(moved, made, "main") == first_time(moved)


def interrupt(*arguments, **options):
    raise KeyboardInterrupt


@pytest.mark.parametrize("moment", ["is_usable", "shutil.rmtree", "call", "uv", "pip"])
def test_the_mark_survives_an_interruption(tmp_path, made, monkeypatch, moment):
    """Before, while and after the folder is emptied, and while it is filled."""
    venv = tmp_path / ".venv"
    (venv / "lib").mkdir(parents=True)
    (venv / environment.STAMP).write_text("an older one")
    with monkeypatch.context() as interrupted:
        interrupted.setattr(f"pgm_book.make.environment.{moment}", interrupt)
        with pytest.raises(KeyboardInterrupt):
            ensure(tmp_path, made, "main")
    assert (venv / environment.MARK).exists()
    assert not (venv / environment.STAMP).exists()
    assert ensure(tmp_path, made, "main") == first_time(tmp_path)


def test_the_mark_comes_before_the_stamp_goes(tmp_path, made, monkeypatch):
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / environment.STAMP).write_text("an older one")
    monkeypatch.setattr(environment.Path, "unlink", interrupt)
    with pytest.raises(KeyboardInterrupt):
        ensure(tmp_path, made, "main")
    assert (tmp_path / ".venv" / environment.MARK).exists()


def test_what_cannot_be_emptied_or_written_is_refused(tmp_path, made, monkeypatch):
    """On Windows a program that runs keeps its files."""

    def fail(*arguments, **options):
        raise PermissionError(13, "Access is denied")

    (tmp_path / ".venv" / "lib").mkdir(parents=True)
    (tmp_path / ".venv" / environment.MARK).touch()
    with monkeypatch.context() as locked:
        locked.setattr(environment.shutil, "rmtree", fail)
        with pytest.raises(environment.Refused, match="Access is denied\nClose what"):
            ensure(tmp_path, made, "main")
    with monkeypatch.context() as locked:
        locked.setattr(environment.Path, "mkdir", fail)
        with pytest.raises(environment.Refused, match="cannot be written"):
            ensure(tmp_path, made, "main")


def test_a_current_environment_is_not_touched(tmp_path, made):
    """Not even for a mark, which those of earlier versions lack."""
    ensure(tmp_path, made, "main")
    (tmp_path / ".venv" / environment.MARK).unlink()
    before = sorted((tmp_path / ".venv").rglob("*"))
    assert ensure(tmp_path, made, "main") == []
    assert sorted((tmp_path / ".venv").rglob("*")) == before


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("step", ["requirements-uv.txt", "requirements.txt"])
def test_pip_takes_over_where_uv_fails(
    tmp_path, made, monkeypatch, capsys, step, whole
):
    """In an environment made anew if uv left half a package, with all of its sets."""
    ensure(tmp_path, made, "main")
    note = environment.call

    def fail_once(command, cwd=None, quiet=False):
        note(command, cwd, quiet)
        if quiet and step in command:
            assert step == "requirements-uv.txt" or command[2] == "uv"
            message = "WARNING: again\n\n  × Failed to fetch\n  ╰─▶ no route to host\n"
            raise subprocess.CalledProcessError(2, command, stderr=message)

    monkeypatch.setattr(environment, "call", fail_once)
    monkeypatch.setattr(environment, "is_usable", lambda venv: whole)
    done = ensure(tmp_path, made, "main", "publish")
    anew = [] if whole else first_time(tmp_path)[:1]
    tried = ["pip requirements-uv.txt", "uv requirements.txt"]
    assert done == [
        *anew,
        *tried[: 1 + (step == "requirements.txt")],
        *anew,
        "pip requirements.txt",
        "pip requirements-publish.txt",
        f"pip {tmp_path}",
    ]
    said = capsys.readouterr().err
    assert said == "pip installs instead of uv, which is slower: Failed to fetch\n"
    assert ensure(tmp_path, made, "main", "publish") == []


def test_pip_does_it_all_where_it_asks_an_index_of_its_own(
    tmp_path, made, monkeypatch, capsys
):
    monkeypatch.setattr(
        environment, "is_usable", lambda venv: environment.python_of(venv).exists()
    )
    monkeypatch.setattr(environment, "has_own_index", lambda python: True)
    assert ensure(tmp_path, made, "main") == [
        first_time(tmp_path)[0],
        "pip requirements.txt",
        f"pip {tmp_path}",
    ]
    assert "pip is set to an index or a proxy of its own" in capsys.readouterr().err


@pytest.mark.parametrize(
    "line", ["index-url = https://example.org/simple", "no-index = true"]
)
@pytest.mark.parametrize("section", ["global", "install"])
def test_an_index_in_the_settings_of_pip_is_seen(tmp_path, monkeypatch, section, line):
    settings = tmp_path / "pip.conf"
    settings.write_text(f"[{section}]\n{line}\n")
    monkeypatch.setenv("PIP_CONFIG_FILE", str(settings))
    assert environment.has_own_index(sys.executable)


@pytest.mark.parametrize("name", ["PIP_INDEX_URL", "PIP_NO_INDEX", "PIP_PROXY"])
def test_an_index_in_a_variable_is_seen(monkeypatch, name):
    monkeypatch.setenv(name, "http://127.0.0.1:9")
    assert environment.has_own_index(sys.executable)


def test_other_settings_of_pip_are_no_hindrance(monkeypatch):
    class Listed:
        stdout = (
            b"global.cert='/etc/index-url=x'\nglobal.extra-index-url='file:///simple'\n"
            b":env:.find-links='no-index'\n:env:.default-timeout='180'\n"
        )

    monkeypatch.setattr(
        environment.subprocess, "run", lambda command, **options: Listed
    )
    assert not environment.has_own_index(sys.executable)


def test_settings_of_uv_do_not_reach_it(tmp_path, monkeypatch):
    """But the place of its cache does, and which environment to install into."""
    run = {}
    monkeypatch.setattr(
        environment.subprocess,
        "run",
        lambda command, **options: run.update(options, command=command),
    )
    monkeypatch.setenv("UV_DEFAULT_INDEX", "https://example.org/simple")
    monkeypatch.setenv("UV_HTTP_RETRIES", "100")
    monkeypatch.setenv("UV_CACHE_DIR", "somewhere")
    monkeypatch.setenv("VIRTUAL_ENV", "another")
    python = environment.python_of(tmp_path / ".venv")
    environment.uv(python, environment.SETS["main"])
    seen = {name: run["env"][name] for name in run["env"] if name.startswith("UV_")}
    assert seen == environment.UV_SETTINGS | {"UV_CACHE_DIR": "somewhere"}
    assert "VIRTUAL_ENV" not in run["env"]
    words = " ".join(run["command"])
    assert f"--no-config --quiet --python {python} " in words
    assert words.endswith("--require-hashes -r requirements.txt")
    assert run["cwd"] == tmp_path and run["check"] and run["capture_output"]


def test_uv_is_installed_with_its_hashes_and_not_built(tmp_path, made):
    ensure(tmp_path, made, "main")
    (call,) = (call for call in made if call[-1] == "requirements-uv.txt")
    assert {"--require-hashes", "--only-binary=:all:", "--retries=1"} <= set(call)
    for name in ("main", "publish", "oldest"):
        assert "--require-hashes" in environment.arguments_for(name)


def test_an_environment_with_half_a_package_is_not_whole(tmp_path):
    folder = sysconfig.get_path("purelib", "venv", {"base": str(tmp_path)})
    package = environment.Path(folder) / "numpy-2.0.0.dist-info"
    package.mkdir(parents=True)
    assert not environment.is_whole(tmp_path)
    record, module = package / "RECORD", package.parent / "numpy.py"
    record.write_text("numpy.py,sha256=00,3\nnumpy-2.0.0.dist-info/RECORD,,\n")
    assert not environment.is_whole(tmp_path)
    module.write_text("pi")
    assert not environment.is_whole(tmp_path)
    module.write_text("pi4")
    assert environment.is_whole(tmp_path)
    record.write_text("numpy.p")
    assert not environment.is_whole(tmp_path)


def test_a_usable_environment_is_not_made_again(tmp_path, monkeypatch):
    venv = tmp_path / ".venv"
    venv.mkdir()
    monkeypatch.setattr(environment, "has_pip", lambda venv: True)
    monkeypatch.setattr(environment, "is_whole", lambda venv: True)
    version = ".".join(map(str, sys.version_info[:3]))
    for text, usable in {
        f"version = {version}\ncommand = python -m venv {venv}\n": True,
        f"version = {version}\ncommand = python -m venv /elsewhere\n": False,
        f"version = 3.9.1\ncommand = python -m venv {venv}\n": False,
        "": False,
    }.items():
        (venv / "pyvenv.cfg").write_text(text)
        assert environment.is_usable(venv) is usable
    (venv / "pyvenv.cfg").write_text(
        f"version = {version}\ncommand = python -m venv {venv}\n"
    )
    for part in ("has_pip", "is_whole"):
        with monkeypatch.context() as broken:
            broken.setattr(environment, part, lambda venv: False)
            assert not environment.is_usable(venv)


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

    def __call__(self, command, cwd=None, quiet=False):
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
    code = "from pgm_book.common.checks import chapter1; chapter1.corner((11.8, -7.9))"
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


def test_a_refused_folder_ends_in_plain_words(monkeypatch, capsys):
    def refuse(*arguments):
        raise environment.Refused("/a/.venv is a file. Move it.")

    monkeypatch.setitem(commands.TASKS, "test", refuse)
    assert commands.main(["test"]) == 1
    assert capsys.readouterr().err == "\n/a/.venv is a file. Move it.\n"


@pytest.fixture
def tried(monkeypatch):
    """What tasks run is noted instead; `tried["fails"]` ends with 1."""
    noted = {"run": [], "fails": None}

    def started(command, *arguments, **options):
        noted["run"].append([str(part) for part in command])
        return noted["fails"] in noted["run"][-1]

    monkeypatch.setattr(commands, "ensure", lambda *sets: environment.ROOT / "a/b/c")
    monkeypatch.setattr(commands, "settings", lambda python: {})
    monkeypatch.setattr(commands, "started", started)
    monkeypatch.setattr(commands, "waited_for", int)
    return noted


@pytest.mark.parametrize("task", ["test", "test-slow", "test-all", "test-publish"])
def test_a_failing_test_fails_its_task(tried, task):
    tried["fails"] = "pytest"
    assert commands.main([task, "-k", "something"]) == 1
    assert tried["run"][-1][-2:] == ["-k", "something"]


def test_wrong_types_and_bad_style_fail_the_test(tried):
    for tried["fails"] in ("mypy", "check", "format"):
        assert commands.main(["test"]) == 1


def test_all_the_tests_are_run_by_one_task_or_the_other(tried):
    """What `test` leaves out `test-slow` runs, and `test-all` runs all three."""
    assert commands.main(["test-all"]) == 0
    chosen = [" ".join(command) for command in tried["run"] if "pytest" in command]
    assert [("-m not slow" in one, "-m slow" in one) for one in chosen] == [
        (True, False),
        (False, True),
        (False, False),
    ]
    assert "tests/publish" in chosen[2]


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
    assert len(used) == 10
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
