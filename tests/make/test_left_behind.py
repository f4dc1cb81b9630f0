"""What a test leaves behind is found, named and put back."""

import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from tests import left_behind
from tests.left_behind import Looked, put_back


def leave_a_figure():
    plt.figure()


def leave_a_setting():
    plt.rcParams["font.size"] = 5


def leave_a_variable():
    os.environ["PGM_LEFT"] = "behind"


def change_a_variable():
    os.environ["PATH"] += os.pathsep + "behind"


def leave_a_path():
    sys.path.append("behind")


def leave_another_folder():
    os.chdir(tempfile.gettempdir())


def draw_a_number():
    random.random()


def draw_a_number_of_numpy():
    np.random.random()  # noqa: NPY002


def leave_errors():
    np.seterr(divide="raise")


def leave_a_handler():
    signal.signal(signal.SIGTERM, signal.SIG_IGN)


def leave_temporary_files():
    Path(tempfile.mkdtemp(), "behind").touch()


@pytest.mark.parametrize(
    ("leave", "named"),
    [
        (leave_a_figure, "1 open figures"),
        (leave_a_setting, "rcParams: ['font.size']"),
        (leave_a_variable, "environment variables: ['PGM_LEFT']"),
        (change_a_variable, "environment variables: ['PATH']"),
        (leave_a_path, "sys.path: ['behind']"),
        (leave_another_folder, "the working folder "),
        (draw_a_number, "another state of random"),
        (draw_a_number_of_numpy, "another state of numpy.random"),
        (leave_errors, "numpy's {'divide': 'raise'"),
        (leave_a_handler, "a handler of SIGTERM"),
        (leave_temporary_files, "temporary files: "),
    ],
)
def test_what_is_left_is_named_and_put_back(leave, named):
    before = Looked()
    leave()
    (left,) = put_back(before)
    assert left.startswith(named)
    assert put_back(before) == []


def test_a_thread_that_goes_on_is_named(monkeypatch):
    monkeypatch.setattr(left_behind, "SECONDS", 0.0)
    before, end = Looked(), threading.Event()
    thread = threading.Thread(target=end.wait, name="behind")
    thread.start()
    assert put_back(before) == ["threads: ['behind']"]
    end.set()
    thread.join()
    assert put_back(before) == []


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs Linux's /proc")
def test_a_process_and_a_file_that_stay_open_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(left_behind, "SECONDS", 0.0)
    before = Looked()
    with open(tmp_path / "behind", "w"):
        assert put_back(before) == [f"open files: {[str(tmp_path / 'behind')]}"]
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=-1) as process:
        named, pipe = put_back(before)
        assert named.startswith(f"processes: [({process.pid}, ")
        assert pipe.startswith("open files: ['pipe:")
        process.communicate(b"\n")
    assert put_back(before) == []


def test_a_file_in_the_project_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(left_behind, "FOLDERS", [tmp_path])
    before = Looked()
    (tmp_path / "behind").touch()
    (left,) = put_back(before)
    assert left.endswith(f"in the project: {[str(tmp_path / 'behind')]}")


def test_each_test_and_its_file_are_watched(request):
    assert {
        "_a_test_leaves_nothing_behind",
        "_a_file_of_tests_leaves_nothing_behind",
    } <= {*request.fixturenames}
