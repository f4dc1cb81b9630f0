"""The stick: pins for another system, what is left out, and what start.py refuses."""

import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pgm_book.course import pack, stick
from pgm_book.make.errors import PublishError

START = Path(stick.__file__).parent / "templates" / "start.py"


def names(system: str, python: str = "3.13") -> set[str]:
    (target, *_) = stick.targets(system, python)
    return {line.partition("==")[0] for line in stick.pins(target)}


def test_the_conditions_are_those_of_the_room_not_of_this_computer():
    assert {"pywinpty", "colorama"} <= names("windows")
    assert not {"pywinpty", "colorama"} & names("linux")
    assert "appnope" in names("macos") and "appnope" not in names("linux")
    assert "pexpect" in names("linux") and "pexpect" not in names("windows")
    assert "importlib-metadata" in names("linux", "3.11")
    assert "importlib-metadata" not in names("linux", "3.12")


def test_each_package_is_pinned_once_with_its_hashes():
    for target in stick.targets("windows,linux,macos", "3.11,3.14"):
        lines = list(stick.pins(target))
        pinned = [line.partition("==")[0] for line in lines]
        assert len(pinned) == len(set(pinned)) > 100
        assert all(" --hash=sha256:" in line and ";" not in line for line in lines)


@pytest.mark.parametrize(
    ("systems", "pythons", "said"),
    [("windows,beos", "3.13", "'beos' is none of"), ("linux", "13", "'13' is no vers")],
)
def test_what_is_not_known_is_named(systems, pythons, said):
    with pytest.raises(ValueError, match=said):
        stick.targets(systems, pythons)


def test_no_stick_without_systems():
    assert stick.targets(None, "3.13") == []


@pytest.fixture
def fetched(monkeypatch):
    """What pip is asked for; it has no wheel of what is `missing` for Intel."""
    asked = {"missing": ["numpy", "scipy"], "commands": []}

    def run(command, **_):
        asked["commands"].append(command)
        pins = Path(command[-1]).read_text(encoding="utf-8").splitlines()
        for pin in (line.split()[0] for line in pins):
            intel = any("macosx" in word and "x86_64" in word for word in command)
            if intel and pin.partition("==")[0] in asked["missing"]:
                said = f"ERROR: No matching distribution found for {pin} (from -r)"
                return subprocess.CompletedProcess(command, 1, "", said)
        place = Path(command[command.index("--dest") + 1])
        (place / f"{len(asked['commands'])}.whl").write_bytes(b"")
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(stick.subprocess, "run", run)
    return asked


def test_a_system_without_all_its_wheels_is_left_out_and_named(
    fetched, tmp_path, capsys
):
    students = {"start.py": START.read_bytes()}
    wanted = stick.targets("macos", "3.13")
    folder = stick.write(tmp_path / "stick", students, wanted)
    said = capsys.readouterr().err
    assert "darwin x86_64 Python 3.13 is left out" in said
    assert "numpy==" in said and "scipy==" in said
    made_for = (folder / "wheels" / stick.MADE_FOR).read_text(encoding="utf-8")
    assert made_for == "darwin arm64 Python 3.13\n"
    assert [p.name for p in (folder / "wheels").glob("*.whl")] == ["1.whl"]
    assert (folder / "start.py").exists() and (folder / "ROOM.html").exists()


def test_an_empty_stick_is_refused(fetched, tmp_path):
    with pytest.raises(PublishError, match="no system has all its wheels"):
        stick.write(tmp_path, {}, stick.targets("macos", "3.13")[1:])


def test_where_pip_fails_its_words_are_given(monkeypatch, tmp_path):
    failed = subprocess.CompletedProcess([], 1, "", "ERROR: no network")
    monkeypatch.setattr(stick.subprocess, "run", lambda *_, **__: failed)
    (target,) = stick.targets("linux", "3.13")
    with pytest.raises(PublishError, match="ERROR: no network"):
        stick.fetch(target, tmp_path)


@pytest.mark.skipif(
    sys.platform != "darwin" and platform.machine().lower() not in ("x86_64", "amd64"),
    reason="no stick is made for this machine",
)
@pytest.mark.parametrize("ours", [True, False])
def test_start_refuses_wheels_for_another_python(tmp_path, ours):
    """It would stop at the first wheel that does not fit, in words that do not help."""
    system = {"win32": "windows", "linux": "linux", "darwin": "macos"}[sys.platform]
    here = "{}.{}".format(*sys.version_info)
    targets = stick.targets(system, here if ours else "3.99")
    (tmp_path / "wheels").mkdir()
    lines = "".join(f"{target}\n" for target in targets)
    (tmp_path / "wheels" / stick.MADE_FOR).write_text(lines, encoding="utf-8")
    (tmp_path / "start.py").write_bytes(START.read_bytes())
    code = "import start; print(start.made_for_this())"
    found = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert found.stdout == f"{ours}\n", found.stderr
    if not ours:
        command = [sys.executable, "start.py", "--install"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 1
        assert "is for another Python" in done.stdout and "3.99" in done.stdout
        assert not (tmp_path / ".venv").exists()


CUT = """
import fcntl, socket, struct, subprocess, sys
up = struct.pack("16sh14x", b"lo", 0x41)  # a kernel talks to itself
fcntl.ioctl(socket.socket(), 0x8914, up)
sys.exit(subprocess.run(sys.argv[1:]).returncode)
"""


@pytest.fixture
def cut():
    """The beginning of a command that runs what follows without a network."""
    command = ["unshare", "-rn", sys.executable, "-c", CUT]
    if not shutil.which("unshare") or subprocess.run([*command, "true"]).returncode:
        pytest.skip("this system cannot cut the network of a process")
    return command


@pytest.mark.slow
@pytest.mark.skipif(
    "PGM_LAB_LARGEST_SAMPLES" not in os.environ, reason="fetches 290 MB: in test-all"
)
def test_a_room_without_network_installs_and_runs_a_notebook(cut, tmp_path):
    pytest.importorskip("build")  # of `publish`, as for `make course`
    notebook = pack.ROOT / "notebooks" / "00_start_here.ipynb"
    students = pack.student_files([notebook], pack.wheels()[1])
    wanted = stick.targets("linux", "{}.{}".format(*sys.version_info))
    try:
        room = stick.write(tmp_path / "room", students, wanted)
    except PublishError as error:
        pytest.skip(f"no wheels were fetched: {error}")
    start = [*cut, sys.executable, "start.py", "--install"]
    subprocess.run(start, cwd=room, check=True)
    python = room / ".venv" / "bin" / "python"
    convert = ["nbconvert", "--to", "notebook", "--execute", "--output", "ran.ipynb"]
    run = [*cut, python, "-m", *convert, "notebooks/00_start_here.ipynb"]
    subprocess.run(run, cwd=room, check=True)
    assert "point is 1" in (room / "notebooks" / "ran.ipynb").read_text("utf-8")
