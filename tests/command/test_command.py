"""The command: exit codes, messages, interruptions, and the files that it leaves."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from pgm_lab import __version__, command
from pgm_lab.command import COMMANDS, main
from tests.command.calls import HOW, break_
from tests.command.conftest import WORK, no_work

POSIX = pytest.mark.skipif(os.name == "nt", reason="no such files or signals there")
ONE_THREAD = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def program(*words, **more):
    """Run the command as a program of its own."""
    call = [sys.executable, "-m", "pgm_lab", *map(str, words)]
    settings = {"capture_output": True, "timeout": 120, "env": ONE_THREAD} | more
    return subprocess.run(call, **settings)


# --- Help ---


def test_the_help_lists_all_subcommands_without_waiting_for_numpy():
    code = """
import sys
from pgm_lab.command import main
try:
    main(["--help"])
finally:
    slow = {"numpy", "scipy", "cv2", "matplotlib", "jinja2"} & set(sys.modules)
    assert not slow, slow
"""
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    for name, what in COMMANDS.items():
        assert f"{name} {what}" in " ".join(done.stdout.split())
    again = program("--help")
    assert again.stdout.decode().split() == done.stdout.split()


@pytest.mark.parametrize(
    "words, said",
    [
        ([], "the following arguments are required: COMMAND"),
        (["bundle"], "invalid choice: 'bundle'"),
        (["\x1b[31m"], "invalid choice: '\\x1b[31m'"),
        (["--colour", "match"], "the following arguments are required: left, right"),
    ],
)
def test_a_call_without_a_subcommand_ends_with_2(capsys, words, said):
    with pytest.raises(SystemExit) as end:
        main(words)
    output = capsys.readouterr()
    assert end.value.code == 2 and output.out == ""
    assert said in output.err and "\x1b" not in output.err


def test_the_version_is_that_of_the_package(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == f"pgm_lab {__version__}\n"


def test_the_readme_shows_calls_that_are_understood():
    text = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    calls = re.findall(r"pgm_lab (\w+) ([^`\n]+ --[^`\n]+)`?\n", text)
    assert {name for name, _ in calls} == set(COMMANDS)
    for name, words in calls:
        module = __import__(f"pgm_lab.command._{name}", fromlist=["add_options"])
        options = command._parser(name, module).parse_args([name, *words.split()])
        assert options.report or name == "board"


# --- A good run ---


@pytest.mark.usefixtures("quick")
def test_the_short_report_is_printed_and_the_long_ones_written(call, outputs, capsys):
    html, text = outputs / "a.html", outputs / "b.TXT"
    assert call.run("--report", html, "--report", text) == 0
    output = capsys.readouterr()
    assert output.out.startswith(f"{call.begins}\n=====") and output.err == ""
    assert html.read_text(encoding="utf-8") == "the page"
    whole = text.read_text(encoding="utf-8")
    assert whole.startswith(call.begins) and len(whole) > len(output.out)
    assert sorted(os.listdir(outputs)) == ["a.html", "b.TXT"]


@pytest.mark.parametrize("watched", [True, False])
def test_a_bar_is_shown_where_somebody_watches(
    call, quick, capsys, monkeypatch, watched
):
    asked = {}
    no_work(monkeypatch, call.name, asked=asked)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: watched)
    assert call.run() == 0
    shown = "reading" in capsys.readouterr().err
    assert (asked["progress"] if call.name == "adjust" else shown) == watched


@pytest.mark.slow
def test_as_a_program_of_its_own_without_a_network(call, outputs):
    """Every connection is refused, and the console has no sign for µ and ×."""
    code = """
import socket, sys
def refuse(*_, **__):
    raise AssertionError("the network was asked")
socket.socket.connect = socket.getaddrinfo = refuse
import runpy
runpy.run_module("pgm_lab", run_name="__main__", alter_sys=True)
"""
    few = {"adjust": ("--estimate", "c,x0,y0")}.get(call.name, ("--number", 10))
    words = [call.name, *call.inputs, *few, "--report", outputs / "r.html"]
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, words)],
        capture_output=True,
        env=ONE_THREAD | {"PYTHONIOENCODING": "ascii"},
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(call.begins.encode())
    assert done.stderr == b""  # no bar where nobody watches
    assert os.listdir(outputs) == ["r.html"]
    if call.name == "adjust":
        assert b"in place of 1 ?m" in b" ".join(done.stdout.split())


# --- Files that are not written ---


@pytest.mark.parametrize(
    "words, message",
    [
        (["--report", "r.pdf"], "the name must end in .html, .htm, .txt"),
        (["--report", "nowhere/r.html"], "there is no folder nowhere"),
        (["--report", "file/r.html"], "file is not a folder"),
        (["--report", "folder.html", "--force"], "is there already and is not a file"),
        (["--report", "r" * 252 + ".txt"], "no file can have this name"),
        (["--report", "R.html", "--report", "r.HTML"], "is the same file"),
        (["--report", "a.txt", "--report", "link.txt", "--force"], "is the same file"),
        pytest.param(
            ["--report", "no\x1b[31m/r.txt"], "no folder no\\x1b[31m", marks=POSIX
        ),
        (["--report", "\x1b[31m.pdf"], "\\x1b[31m.pdf: the name must end in"),
        (["--mask"], "unrecognized arguments"),
        (["\x1b[31m"], "unrecognized arguments: \\x1b[31m"),
    ],
)
def test_a_wrong_call_ends_with_2_before_the_work(
    call, outputs, capsys, monkeypatch, words, message
):
    monkeypatch.chdir(outputs)
    Path("file").write_text("")
    Path("folder.html").mkdir()
    Path("a.txt").write_text("old")
    Path("link.txt").symlink_to("a.txt")
    assert message in call.refused(capsys, *words)
    assert Path("a.txt").read_text() == "old"


def test_a_folder_that_may_not_be_written_is_named_before_the_work(
    call, outputs, capsys, monkeypatch
):
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    message = call.refused(capsys, "--report", outputs / "r.html")
    assert "nothing may be written into the folder" in message


OUTPUTS = [
    *((name, "--report", "r.html") for name in WORK),
    ("match", "--csv", "r.csv"),
    ("match", "--image-csv", "r.txt"),
    ("register", "--csv", "r.csv"),
    ("register", "--resampled", "r.tif"),
]


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("name, option, file", OUTPUTS)
def test_a_file_is_replaced_only_by_force(request, outputs, capsys, name, option, file):
    if option == "--resampled":
        pytest.importorskip("rasterio")
    call, path = request.getfixturevalue(name), outputs / file
    more = ("--pixel-size", 0.005) if option == "--image-csv" else ()
    path.write_text("mine")
    message = call.refused(capsys, option, path, *more)
    assert "it exists already; --force replaces it" in message
    assert path.read_text() == "mine"
    assert call.run(option, path, *more, "--force") == 0
    assert path.read_bytes() != b"mine" and os.listdir(outputs) == [file]


@pytest.mark.parametrize("by", ["name", "symlink", "hard link", "dots"])
def test_an_input_is_never_replaced(call, outputs, capsys, by):
    path = call.inputs[-1].rename(call.inputs[-1].with_suffix(".txt"))
    call.inputs[-1], before, other = path, path.read_bytes(), outputs / "r.txt"
    if by == "name":
        other = path
    elif by == "symlink":
        other.symlink_to(path)
    elif by == "hard link":
        os.link(path, other)
    else:
        other = outputs / ".." / path.relative_to(outputs.parent)
    message = call.refused(capsys, "--report", other, "--force")
    assert f"this is the input {path}" in message
    assert path.read_bytes() == before


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("how", HOW)
@pytest.mark.parametrize("where", ["working", "drawing", "renaming the second"])
def test_nothing_half_written_is_left(call, outputs, capsys, monkeypatch, where, how):
    """An older report stays as it was, and afterwards all goes well."""
    old, new = outputs / "r.txt", outputs / "r.html"
    old.write_text("old")
    work, _, drawing = WORK[call.name]
    words = ("--report", old, "--report", new, "--force")
    with monkeypatch.context() as patch:
        break_(patch, where, how, {"working": work, "drawing": drawing})
        assert HOW[how][1] in call.ended(capsys, *words)
    assert os.listdir(outputs) == ["r.txt"] and old.read_text() == "old"
    assert call.run(*words) == 0
    assert sorted(os.listdir(outputs)) == ["r.html", "r.txt"]
    assert old.read_text(encoding="utf-8").startswith(call.begins)


# --- Interruptions ---


@POSIX
@pytest.mark.parametrize("when", ["importing", "working"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_interruption_is_said_in_one_line(call, capsys, monkeypatch, name, when):
    """From the first moment on; and afterwards the signal does what it did before."""
    number = signal.Signals[name]
    before = signal.getsignal(number)
    own = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
    place = (command.importlib, "import_module")
    if when == "working":
        place, *_ = WORK[call.name]
    monkeypatch.setattr(*place, lambda *_, **__: signal.raise_signal(number))
    signal.signal(number, own)
    try:
        assert call.ended(capsys) == f"pgm_lab {call.name}: interrupted"
        assert signal.getsignal(number) is own
    finally:
        signal.signal(number, before)


@POSIX
def test_who_reads_only_the_head_gets_no_traceback(call, quick, capsys, monkeypatch):
    """Nor when the output is closed at last, and what is left would be written."""
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w", encoding="utf-8") as output:
        monkeypatch.setattr(sys, "stdout", output)
        assert call.run() == 0
    assert capsys.readouterr().err == ""


# --- Inputs that are no files, and odd names ---


@POSIX
@pytest.mark.parametrize("which", [0, -1])
def test_an_input_that_is_no_file_ends_with_1(call, outputs, capsys, which):
    """A pipe is not waited for."""
    call.inputs[which] = outputs.parent / "none.x"
    message = call.ended(capsys, "--report", outputs / "r.html")
    assert "none.x: there is no such file" in message and os.listdir(outputs) == []
    os.mkfifo(call.inputs[which])
    assert "none.x: this is a pipe or a device" in call.ended(capsys)


@POSIX
def test_control_characters_of_a_name_never_reach_the_terminal(call, quick, capsys):
    odd = call.inputs[0].with_name("a\x1b[31m\x07\u202e\n" + call.inputs[0].suffix)
    call.inputs[0] = call.inputs[0].rename(odd)
    assert call.run() == 0
    output = capsys.readouterr()
    assert "\x1b" not in output.out + output.err
    assert "a\\x1b[31m\\x07\\u202e\\n." in output.out
    odd.write_text("1 2 x\n")
    assert "a\\x1b[31m\\x07\\u202e\\n." in call.ended(capsys)


@pytest.mark.parametrize("name", ["match", "register"])
def test_the_same_image_twice_is_refused(request, outputs, capsys, name):
    call = request.getfixturevalue(name)
    link = outputs / "link.png"
    link.symlink_to(call.inputs[0])
    for second in (call.inputs[0], link):
        message = call.ended(capsys, inputs=[call.inputs[0], second])
        assert "are the same file: two" in message
