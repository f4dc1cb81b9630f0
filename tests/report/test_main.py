"""The command line of the bundle adjustment: exit codes, messages, files it leaves."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import bundle, datasets, report
from pgm_lab.camera import PARAMETERS
from pgm_lab.io import files as _files
from pgm_lab.report import __main__ as command
from pgm_lab.report import _figures
from tests.networks import real


@pytest.fixture(scope="module")
def network():
    return real()


@pytest.fixture(scope="module")
def result(network):
    return bundle.adjust(network)


@pytest.fixture
def quick(result, monkeypatch):
    """An adjustment and a page that take no time, for what comes around them."""
    monkeypatch.setattr(bundle, "adjust", lambda *_, **__: result)
    monkeypatch.setitem(command.WRITERS, ".html", lambda *_, **__: "the page")


@pytest.fixture
def files(network, tmp_path):
    """The four files of the source, in a folder with a space in its name."""
    folder = tmp_path / "my network"
    return [str(path) for path in bundle.write(network, folder)]


@pytest.fixture
def reports(tmp_path):
    folder = tmp_path / "reports"
    folder.mkdir()
    return folder


def run(*arguments):
    return command.main([str(argument) for argument in arguments])


def refused(capsys, *arguments):
    """Return what a wrong call says; it ends with 2 and prints nothing else."""
    with pytest.raises(SystemExit) as end:
        run(*arguments)
    output = capsys.readouterr()
    assert end.value.code == 2 and output.out == ""
    return output.err


def test_the_short_report_is_printed_and_the_long_ones_written(
    files, reports, result, capsys, monkeypatch
):
    monkeypatch.setattr(_figures, "png", lambda figure: plt.close(figure) or "png")
    html, text = reports / "a.html", reports / "b.TXT"
    assert run(*files, "--report", html, "--report", text) == 0
    output = capsys.readouterr()
    about = "From interior.txt, exterior.txt, points.txt, image.txt."
    assert output.out == report.text(result, about=about, short=True) + "\n"
    assert output.err == ""
    assert text.read_text(encoding="utf-8") == report.text(result, about=about)
    assert html.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert sorted(os.listdir(reports)) == ["a.html", "b.TXT"]


def test_as_a_program_of_its_own(files, reports):
    """Printed as bytes, so that the output does not depend on the code page here."""
    call = [sys.executable, "-m", "pgm_lab.bundle", *files]
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "OMP_NUM_THREADS": "1"}
    call += ["--estimate", "c,x0,y0", "--report", str(reports / "r.txt")]
    done = subprocess.run(call, capture_output=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    assert b"so the image coordinates are about 2.5 times better" in done.stdout
    assert b"0.4 ?m" in done.stdout  # a console without the sign must not break
    assert done.stderr == b""  # no progress bar where nobody watches
    assert os.listdir(reports) == ["r.txt"]


def test_the_options_reach_the_adjustment(files, network, reports, capsys):
    options = (
        "--estimate c,x0,y0,K1 --lens forward --datum photos --sigma 0.0004".split()
    )
    assert run(*files, *options, "--report", reports / "r.txt") == 0
    again = bundle.read(*files, lens="forward", sigma=0.0004)
    result = bundle.adjust(again, ("c", "x0", "y0", "K1"), "photos")
    about = "From interior.txt, exterior.txt, points.txt, image.txt."
    written = (reports / "r.txt").read_text(encoding="utf-8")
    assert written == report.text(result, about=about)
    assert "modelled forward" in written and "projection centres" in written
    assert run(*files, "--estimate", "none") == 0
    assert "35  mm     held" in capsys.readouterr().out


def test_snooping_takes_out_what_the_function_does(files, network, capsys):
    assert run(*files, "--snoop", "--estimate", "c,x0,y0,K1,K2,K3") == 0
    found = bundle.snoop(network, ("c", "x0", "y0", "K1", "K2", "K3"))
    assert len(found.removed) > 0
    rays = f"Data snooping took out {len(found.removed)} rays"
    assert rays in capsys.readouterr().out


def spoil(path, line, text):
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    lines[line - 1] = text
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))


SPOILT = {
    "not a number": (2, 40, "39 1 2 three", "'three' is not a number"),
    "columns": (1, 3, "2 1.29 0.06 3.05", "4 column(s), where exterior orientations"),
    "unknown id": (3, 9, "51 1 1 1 0.001 0.001", "point 51 is not in points.txt"),
    "degrees": (1, 2, "1 74.9 4.8 84.2 111 373 362", "radians are expected"),
    "sigma": (
        3,
        2,
        "1 1 -4.23 1.05 0 0.001",
        "a standard deviation must be above zero",
    ),
    "twice": (2, 3, "1 1 2 3", "point 1 stands in line 2 already"),
}


@pytest.mark.parametrize(
    "which, line, text, reason", SPOILT.values(), ids=SPOILT.keys()
)
def test_a_bad_file_ends_with_1_and_its_line_and_leaves_nothing(
    files, reports, capsys, which, line, text, reason
):
    spoil(files[which], line, text)
    assert run(*files, "--report", reports / "r.html") == 1
    output = capsys.readouterr()
    assert f"{files[which]}, line {line}: " in output.err and reason in output.err
    assert "Traceback" not in output.err and output.out == ""
    assert len(output.err.splitlines()) == 1
    assert os.listdir(reports) == []


def test_a_missing_file_ends_with_1(files, capsys):
    assert run(*files[:3], files[3] + "x") == 1
    assert "image.txtx: there is no such file" in capsys.readouterr().err


def test_an_impossible_adjustment_ends_with_1_and_names_what_is_missing(
    files, network, reports, capsys
):
    lone = np.flatnonzero((network.point == 4) & (network.photo > 0))
    bundle.write(network.without(lone), os.path.dirname(files[0]), overwrite=True)
    assert run(*files, "--report", reports / "r.html") == 1
    output = capsys.readouterr()
    assert "point 5" in output.err and "two rays" in output.err and output.out == ""
    assert os.listdir(reports) == []


def test_what_does_not_converge_is_not_reported(files, reports, capsys, monkeypatch):
    """The start lies far away, and nearly no iteration is granted."""
    monkeypatch.setattr(
        bundle,
        "adjust",
        lambda *a, adjust=bundle.adjust, **k: adjust(*a, max_iterations=2, **k),
    )
    assert run(*files, "--report", reports / "r.html") == 1
    output = capsys.readouterr()
    assert "did not converge (too many iterations after 2 iterations)" in output.err
    assert "that x points right and y up" in output.err
    assert output.out == "" and os.listdir(reports) == []


def test_a_report_is_replaced_only_by_force(files, reports, capsys):
    report = reports / "r.txt"
    report.write_text("mine")
    message = refused(capsys, *files, "--report", report)
    assert "it exists already; --force replaces it" in message
    assert report.read_text() == "mine"
    assert run(*files, "--report", report, "--force") == 0
    assert report.read_text(encoding="utf-8").startswith("Bundle adjustment")


def test_a_report_that_another_wrote_meanwhile_stays(
    files, reports, capsys, monkeypatch
):
    report, adjust = reports / "r.txt", bundle.adjust

    def meanwhile(*arguments, **options):
        report.write_text("theirs")
        return adjust(*arguments, **options)

    monkeypatch.setattr(bundle, "adjust", meanwhile)
    assert run(*files, "--report", report) == 1
    assert "r.txt already exists, and is not overwritten" in capsys.readouterr().err
    assert report.read_text() == "theirs" and os.listdir(reports) == ["r.txt"]


def test_an_input_is_never_replaced(files, reports, capsys):
    before = Path(files[2]).read_bytes()
    message = refused(capsys, *files, "--report", files[2], "--force")
    assert f"this is the input {files[2]}" in message
    report = ["--report", reports / "r.html"]
    assert "another output" in refused(capsys, *files, *report, *report)
    assert Path(files[2]).read_bytes() == before


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--report", "r.pdf"], "the name must end in .html, .htm, .txt"),
        (["--report", "nowhere/r.html"], "there is no folder nowhere"),
        (["--estimate", "c,f"], "'f' is not one of c,x0,y0,K1"),
        (["--estimate", ""], "'' is not one of"),
        (["--lens", "sideways"], "invalid choice: 'sideways'"),
        (["--datum", "fixed"], "invalid choice: 'fixed'"),
        (["--sigma", "0"], "'0' is not a number above zero"),
        (["--sigma", "nan"], "'nan' is not a number above zero"),
        (["--sigma", "x"], "'x' is not a number above zero"),
        (["--colour"], "unrecognized arguments"),
    ],
)
def test_a_wrong_call_ends_with_2(files, capsys, arguments, message):
    assert message in refused(capsys, *files, *arguments)


def test_too_few_files_end_with_2(files, capsys):
    assert "image" in refused(capsys, *files[:3])


@pytest.mark.parametrize("failure", ["drawing", "writing", "renaming", "the second"])
@pytest.mark.parametrize("how", ["disk full", "interrupted"])
def test_nothing_half_written_is_left(
    files, reports, quick, capsys, monkeypatch, failure, how
):
    """In the middle of a report; an older report stays as it was."""

    def full(*_, **__):
        if how == "interrupted":
            raise KeyboardInterrupt
        raise OSError(28, "No space left on device")

    old = reports / "r.txt"
    old.write_text("old")
    new = reports / "r.html"
    with monkeypatch.context() as patch:
        if failure == "drawing":
            patch.setitem(command.WRITERS, ".html", full)
        else:
            name = "open" if failure == "writing" else "replace"
            nth = 2 if failure == "the second" else 1
            patch.setattr(_files.Path, name, broken(name, full, nth))
        assert run(*files, "--report", old, "--report", new, "--force") == 1
    said = {"disk full": "No space left", "interrupted": "interrupted"}[how]
    assert said in capsys.readouterr().err
    assert os.listdir(reports) == ["r.txt"]
    assert old.read_text() == "old"
    assert run(*files, "--report", new, "--report", old, "--force") == 0
    assert sorted(os.listdir(reports)) == ["r.html", "r.txt"]
    assert old.read_text(encoding="utf-8").startswith("Bundle adjustment")


def broken(name, full, nth):
    """Return a method of Path that breaks off at the n-th new file."""
    original = getattr(_files.Path, name)
    calls = []

    def method(self, *arguments, **options):
        if self.suffix != ".part" or name == "open" and arguments[:1] != ("x",):
            return original(self, *arguments, **options)
        calls.append(self)
        if len(calls) != nth:
            return original(self, *arguments, **options)
        if name == "open":
            with original(self, *arguments, **options) as file:
                file.write("<!DOCTYPE ht")
        return full()

    return method


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no such signal there")
@pytest.mark.parametrize(
    "signal_name",
    [
        "SIGTERM",
        *(pytest.param(s, marks=pytest.mark.slow) for s in ("SIGINT", "SIGHUP")),
    ],
)
def test_who_ends_the_program_while_it_writes_leaves_nothing(
    files, reports, signal_name
):
    code = """
import os, signal, sys
from pgm_lab.io import files as _files
from pgm_lab.camera import PARAMETERS
from pgm_lab.report import __main__ as command
from pgm_lab.report import _figures
command.WRITERS[".html"] = lambda *_, **__: "page"
replace, calls = _files.Path.replace, []
def killed(self, target):
    calls.append(target)
    if len(calls) == 2:  # the first report has its name already
        os.kill(os.getpid(), signal.{0})
    return replace(self, target)
_files.Path.replace = killed
signal.signal(signal.SIGHUP, signal.SIG_DFL)
sys.exit(command.main(sys.argv[1:]))
"""
    call = [sys.executable, "-c", code.format(signal_name), *files, "--estimate", "c"]
    for name in ("a.html", "b.html"):
        call += ["--report", str(reports / name)]
    done = subprocess.run(call, capture_output=True, timeout=120)
    assert done.returncode == 1 and done.stdout == b""
    assert done.stderr.strip() == b"python -m pgm_lab.report: interrupted"
    assert os.listdir(reports) == []


def test_a_long_name_is_written_or_refused(files, reports, capsys):
    """255 bytes is the longest that a file can have on most systems."""
    longest = reports / ("r" * 251 + ".txt")
    assert run(*files, "--estimate", "c", "--report", longest) == 0
    assert os.listdir(reports) == [longest.name]
    capsys.readouterr()
    message = refused(capsys, *files, "--report", reports / ("r" * 252 + ".txt"))
    assert "no file can have this name" in message and "Traceback" not in message


@pytest.mark.parametrize("link", ["symlink", "hard link", "dots"])
def test_an_input_by_another_name_is_never_replaced(
    files, reports, tmp_path, capsys, link
):
    before = Path(files[3]).read_bytes()
    other = reports / "r.txt"
    if link == "symlink":
        other.symlink_to(files[3])
    elif link == "hard link":
        os.link(files[3], other)
    else:
        other = reports / ".." / "my network" / "image.txt"
    message = refused(capsys, *files, "--report", other, "--force")
    assert f"this is the input {files[3]}" in message
    assert Path(files[3]).read_bytes() == before


def test_two_names_of_one_report_are_refused(files, reports, capsys):
    """Where case does not count, the second would replace the first."""
    call = [*files, "--report", reports / "R.html", "--report", reports / "r.HTML"]
    assert "is the same file" in refused(capsys, *call)
    link = reports / "link.txt"
    (reports / "r.txt").write_text("old")
    link.symlink_to(reports / "r.txt")
    call = [*files, "--report", reports / "r.txt", "--report", link, "--force"]
    assert "is the same file" in refused(capsys, *call)


def test_what_is_there_and_no_file_is_never_replaced(files, reports, capsys):
    (reports / "r.html").mkdir()
    call = [*files, "--report", reports / "r.html", "--force"]
    assert "is not a file" in refused(capsys, *call)
    (reports / "f").write_text("")
    call = [*files, "--report", reports / "f" / "r.html"]
    assert "is not a folder" in refused(capsys, *call)


def test_a_folder_that_may_not_be_written_is_named_before_the_work(
    files, reports, capsys, monkeypatch
):
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    call = [*files, "--report", reports / "r.html"]
    assert "nothing may be written into the folder" in refused(capsys, *call)


def test_all_reports_are_made_before_the_first_is_written(
    files, reports, capsys, monkeypatch
):
    seen = []
    for suffix in (".html", ".txt"):
        writer = lambda *_, **__: seen.append(os.listdir(reports)) or "page"  # noqa: E731
        monkeypatch.setitem(command.WRITERS, suffix, writer)
    call = ["--report", reports / "a.txt", "--report", reports / "b.html"]
    assert run(*files, "--estimate", "c", *call) == 0
    assert seen == [[], []]


def test_too_many_photos_for_the_memory_are_refused(files, capsys, monkeypatch):
    """8 matrices of 64 x 64 floats for nine photos."""
    size = {"SC_PAGE_SIZE": 1}
    for memory, code in ((8 * 8 * 64**2, 0), (8 * 8 * 64**2 - 1, 1)):
        sysconf = lambda name, memory=memory: size.get(name, memory)  # noqa: E731
        monkeypatch.setattr(os, "sysconf", sysconf, raising=False)
        assert run(*files, "--estimate", "c") == code
    assert "9 photos need about 0 GB" in capsys.readouterr().err


def test_memory_that_runs_out_all_the_same_is_said(files, capsys, monkeypatch):
    def exhausted(*_, **__):
        raise MemoryError

    monkeypatch.setattr(bundle, "adjust", exhausted)
    assert run(*files) == 1
    message = "there is not enough memory for this network: adjust parts of it"
    assert message in capsys.readouterr().err


def test_a_bar_is_shown_where_somebody_watches(files, capsys, monkeypatch):
    asked = []
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    adjust = bundle.adjust
    monkeypatch.setattr(
        bundle, "adjust", lambda *a, **k: asked.append(k["progress"]) or adjust(*a, **k)
    )
    assert run(*files, "--estimate", "c") == 0
    assert asked == [True]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no such signal there")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_interruption_is_said_in_one_line(files, capsys, monkeypatch, name):
    """And afterwards the signal does what it did before."""
    number = signal.Signals[name]
    before = signal.getsignal(number)
    own = signal.default_int_handler if name == "SIGINT" else signal.SIG_DFL
    monkeypatch.setattr(bundle, "read", lambda *_, **__: signal.raise_signal(number))
    signal.signal(number, own)
    try:
        assert run(*files) == 1
        assert signal.getsignal(number) is own
    finally:
        signal.signal(number, before)
    assert capsys.readouterr().err == "python -m pgm_lab.report: interrupted\n"


def test_the_help_names_the_columns_of_each_file(capsys):
    with pytest.raises(SystemExit) as end:
        run("--help")
    assert end.value.code == 0
    text = " ".join(capsys.readouterr().out.split())
    for columns in ("photo omega phi kappa XL YL ZL", "point photo x y sx sy"):
        assert columns in text
    assert "scale bars and several cameras have no place in the files" in text


def test_the_sample_gives_what_another_program_found(reports, capsys, monkeypatch):
    """As the README calls it; JAICOV adjusted the same network."""
    readme = (datasets.folder().parent / "README.md").read_text(encoding="utf-8")
    (call,) = re.findall(r"-m pgm_lab\.report (data/sample.*)", readme)
    folder = datasets.folder().parent
    words = [str(folder / w) if w.startswith("data/") else w for w in call.split()]
    words[-1] = str(reports / words[-1])
    monkeypatch.setitem(command.WRITERS, ".html", lambda *_, **__: "the page")
    assert run(*words) == 0
    output = capsys.readouterr()
    data = datasets.jaicov_9x50()
    assert f"redundancy {data.redundancy}" in output.out and output.err == ""
    for name, value in zip(PARAMETERS[:3], data.adjusted_interior):
        shown = re.search(rf"^{name} +(-?[0-9.]+)", output.out, re.M)[1]
        assert float(shown) == pytest.approx(value, abs=5.1e-5)
    assert os.listdir(reports) == ["report.html"]


def test_the_sample_is_the_network_of_the_tables():
    data = datasets.jaicov_9x50()
    files = [datasets.folder() / "sample" / name for name in bundle.files.NAMES]
    network = bundle.read(*files, lens="forward")
    for name in ("exteriors", "points", "photo", "point", "xy", "sigma"):
        assert np.array_equal(getattr(network, name), getattr(data, name)), name
    assert np.array_equal(network.interior[0], data.interior)
    readme = (datasets.folder() / "README.md").read_text(encoding="utf-8")
    assert all(f"`sample/{path.name}`" in readme for path in files)


def test_the_readme_names_the_columns_of_the_four_files():
    readme = (datasets.folder().parent / "README.md").read_text(encoding="utf-8")
    for columns in (
        PARAMETERS,
        bundle.files.EXTERIOR,
        bundle.files.POINT,
        bundle.files.RAY,
    ):
        assert f"| {', '.join(columns)}" in readme
