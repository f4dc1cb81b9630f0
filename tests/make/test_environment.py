"""The upkeep of .venv, without installing anything."""

import os
import subprocess
import sys

import pytest

from pgm_book.make import environment
from pgm_book.make.environment import MARK, STAMP


@pytest.fixture
def ensure(tmp_path, monkeypatch):
    """Run `ensure` in a project folder; says what would be run: who, and last word."""
    calls = []

    def note(command, cwd=None, quiet=False):
        calls.append(f"{command[2]} {command[-1]}")
        if "venv" in command:
            python = environment.python_of(command[-1])
            python.parent.mkdir(parents=True, exist_ok=True)
            python.touch()

    def run(*sets, root=tmp_path):
        calls.clear()
        environment.ensure(".venv", *sets, root=root)
        return list(calls)

    (tmp_path / "requirements.txt").write_text("numpy==2.0.0\n")
    (tmp_path / "pyproject.toml").write_text(
        '[project.optional-dependencies]\ndev = ["uv"]\n'
    )
    monkeypatch.setattr(environment, "call", note)
    run.calls = calls
    return run


def first_time(root):
    """What makes an environment from nothing."""
    made = [f"venv {root / '.venv'}", "pip requirements-uv.txt"]
    return [*made, "uv requirements.txt", f"uv {root}"]


def link(path, target):
    """A symbolic link to a folder, where this user may make one."""
    try:
        path.symlink_to(target, target_is_directory=True)
    except OSError:
        pytest.skip("this user may not make symbolic links")


def interrupt(*arguments, **options):
    raise KeyboardInterrupt


def denied(*arguments, **options):
    raise PermissionError(13, "Access is denied")


def test_an_environment_is_made_once_and_then_left_alone(tmp_path, ensure):
    assert ensure("main") == first_time(tmp_path)
    assert ensure("main") == []
    uv = ["pip requirements-uv.txt", "uv requirements-publish.txt"]
    assert ensure("main", "publish") == uv
    assert ensure("main", "publish") == ensure("main") == []
    assert "uv uv" in ensure("main", "dev")  # the extra of pyproject.toml


def test_a_changed_file_brings_it_up_to_date(tmp_path, ensure):
    for name in ("requirements.txt", "pyproject.toml"):
        ensure("main")
        with open(tmp_path / name, "a") as file:
            file.write("\n")
        assert ensure("main") == first_time(tmp_path)[1:]


@pytest.mark.parametrize("stamp", ["", "[]", '{"python": 1}', "\0", None])
def test_a_damaged_or_missing_stamp_has_it_made_again(tmp_path, ensure, stamp):
    """It is written last, so an installation that was interrupted has none."""
    ensure("main")
    if stamp is None:
        (tmp_path / ".venv" / STAMP).unlink()
    else:
        (tmp_path / ".venv" / STAMP).write_text(stamp)
    assert ensure("main") == first_time(tmp_path)


def test_another_a_lost_or_a_moved_python_has_it_made_again(
    tmp_path, ensure, monkeypatch
):
    ensure("main")
    environment.python_of(tmp_path / ".venv").unlink()
    assert ensure("main") == first_time(tmp_path)
    monkeypatch.setattr(sys, "version", "3.99.0 (a later one)")
    assert ensure("main") == first_time(tmp_path)
    moved = tmp_path / "moved"
    moved.mkdir()
    for name in (".venv", "requirements.txt", "pyproject.toml"):
        (tmp_path / name).rename(moved / name)
    assert ensure("main", root=moved) == first_time(moved)


@pytest.mark.parametrize("mark", [None, MARK, STAMP])
@pytest.mark.parametrize("there", [True, False])
def test_a_link_is_refused_and_its_target_survives(tmp_path, ensure, mark, there):
    """Even where the target was made here: nobody knows who else uses it."""
    target = tmp_path / "elsewhere"
    if there:
        target.mkdir()
        (target / (mark or "thesis.txt")).write_text("three years")
    link(tmp_path / ".venv", target)
    with pytest.raises(environment.Refused, match=r"\.venv is a link to another place"):
        ensure("main")
    assert ensure.calls == [] and (tmp_path / ".venv").is_symlink()
    assert target.exists() == there
    if there:
        assert os.listdir(target) == [mark or "thesis.txt"]


def test_what_was_not_made_here_is_refused(tmp_path, ensure):
    venv = tmp_path / ".venv"
    venv.write_text("mine")
    with pytest.raises(environment.Refused, match="is a file.*Move or delete it your"):
        ensure("main")
    assert venv.read_text() == "mine"
    venv.unlink()
    venv.mkdir()
    (venv / "pyvenv.cfg").write_text("home = /usr/bin")
    with pytest.raises(environment.Refused, match="this project has not made"):
        ensure("main")
    assert os.listdir(venv) == ["pyvenv.cfg"]
    (venv / "pyvenv.cfg").unlink()
    assert ensure("main") == first_time(tmp_path)  # an empty folder is taken


@pytest.mark.parametrize("mark", [MARK, STAMP])
def test_a_marked_folder_is_emptied_without_following_links(tmp_path, ensure, mark):
    """What an interruption leaves behind goes, what a link in it points at stays."""
    venv, mine = tmp_path / ".venv", tmp_path / "mine"
    (venv / "lib" / "deep").mkdir(parents=True)
    mine.mkdir()
    (mine / "thesis.txt").write_text("three years")
    (venv / mark).write_text("")
    (venv / "half.whl").write_text("half a packa")
    link(venv / "link", mine)
    link(venv / "lib" / "deep" / "link", mine)
    assert ensure("main") == first_time(tmp_path)
    assert (mine / "thesis.txt").read_text() == "three years"
    folder = environment.python_of(venv).parent.name
    assert set(os.listdir(venv)) == {MARK, STAMP, folder}


@pytest.mark.parametrize(
    "moment", ["Path.unlink", "shutil.rmtree", "call", "uv", "pip"]
)
def test_the_mark_survives_an_interruption(tmp_path, ensure, monkeypatch, moment):
    """While the folder is emptied, and while it is filled; then no stamp is left."""
    venv = tmp_path / ".venv"
    (venv / "lib").mkdir(parents=True)
    (venv / STAMP).write_text("an older one")
    with monkeypatch.context() as interrupted:
        interrupted.setattr(f"pgm_book.make.environment.{moment}", interrupt)
        with pytest.raises(KeyboardInterrupt):
            ensure("main")
    assert (venv / MARK).exists()
    assert (venv / STAMP).exists() == (moment == "Path.unlink")
    assert ensure("main") == first_time(tmp_path)


@pytest.mark.parametrize("what", ["shutil.rmtree", "Path.mkdir"])
def test_what_cannot_be_emptied_or_written_is_refused(
    tmp_path, ensure, monkeypatch, what
):
    """On Windows a program that runs keeps its files."""
    (tmp_path / ".venv" / "lib").mkdir(parents=True)
    (tmp_path / ".venv" / MARK).touch()
    monkeypatch.setattr(f"pgm_book.make.environment.{what}", denied)
    with pytest.raises(environment.Refused, match="Access is denied\nClose what uses"):
        ensure("main")


def test_a_set_that_cannot_be_added_leaves_the_others(tmp_path, ensure, monkeypatch):
    """Without the network the slides cannot be made, but the workbook still opens."""
    ensure("main")
    with monkeypatch.context() as offline:
        error = subprocess.CalledProcessError(1, ["pip"])
        offline.setattr(
            environment, "pip", lambda *_, **__: (_ for _ in ()).throw(error)
        )
        with pytest.raises(subprocess.CalledProcessError):
            ensure("main", "publish")
    assert ensure("main") == []


@pytest.mark.parametrize("step", ["requirements-uv.txt", "requirements.txt"])
def test_pip_takes_over_where_uv_fails(tmp_path, ensure, monkeypatch, capsys, step):
    note = environment.call

    def fail(command, cwd=None, quiet=False):
        note(command, cwd, quiet)
        if quiet and step in command:
            message = "WARNING: again\n\n  × Failed to fetch\n  ╰─▶ no route to host\n"
            raise subprocess.CalledProcessError(2, command, stderr=message)

    monkeypatch.setattr(environment, "call", fail)
    tried = first_time(tmp_path)[: 2 if "uv" in step else 3]
    assert ensure("main") == [*tried, "pip requirements.txt", f"pip {tmp_path}"]
    said = capsys.readouterr().err
    assert said == "pip installs instead of uv, which is slower: Failed to fetch\n"
    assert ensure("main") == []


def test_uv_and_pip_are_run_with_hashes_and_without_foreign_settings(
    tmp_path, monkeypatch
):
    """But the place of uv's cache stays, and which environment to install into."""
    run = {}

    def noted(command, **options):
        run.update(options, command=" ".join(map(str, command)))

    monkeypatch.setattr(environment.subprocess, "run", noted)
    for name in (*environment.DISTURBING, "UV_DEFAULT_INDEX", "UV_HTTP_RETRIES"):
        monkeypatch.setenv(name, "something")
    monkeypatch.setenv("UV_CACHE_DIR", "somewhere")
    python = environment.python_of(tmp_path / ".venv")
    environment.uv(python, environment.SETS["main"])
    assert f"--no-config --quiet --python {python} " in run["command"]
    assert run["command"].endswith("--require-hashes -r requirements.txt")
    assert run["cwd"] == tmp_path and run["check"] and run["capture_output"]
    assert "UV_DEFAULT_INDEX" not in run["env"]
    assert (run["env"]["UV_HTTP_RETRIES"], run["env"]["UV_CACHE_DIR"]) == (
        "1",
        "somewhere",
    )
    assert not environment.DISTURBING & set(run["env"])
    for name in ("main", "publish", "oldest"):
        assert "--require-hashes" in environment.arguments_for(name)
    assert environment.environment(EXTRA="1")["EXTRA"] == "1"
    assert run["env"]["PYTHONUTF8"] == "1"  # a check's tick can be printed everywhere
