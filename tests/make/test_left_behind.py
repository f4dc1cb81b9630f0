"""What a test leaves behind is found, named and put back."""

import os
import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

from tests import left_behind
from tests.left_behind import Looked, put_back


@pytest.mark.parametrize(
    ("leave", "named"),
    [
        (plt.figure, "1 open figures"),
        (lambda: plt.rcParams.update({"font.size": 5}), "rcParams: ['font.size']"),
        (
            lambda: os.environ.update(PGM_LEFT="behind"),
            "environment variables: ['PGM_LEFT']",
        ),
        (lambda: os.environ.update(PATH="behind"), "environment variables: ['PATH']"),
        (lambda: sys.path.append("behind"), "sys.path: ['behind']"),
        (lambda: os.chdir(tempfile.gettempdir()), "the working folder "),
        (random.random, "another state of random"),
        (np.random.random, "another state of numpy.random"),  # noqa: NPY002
        (lambda: np.seterr(divide="raise"), "numpy's {'divide': 'raise'"),
        (
            lambda: signal.signal(signal.SIGTERM, signal.SIG_IGN),
            "a handler of SIGTERM",
        ),
        (lambda: Path(tempfile.mkdtemp(), "behind").touch(), "temporary files: "),
    ],
)
def test_what_is_left_is_named_and_put_back(leave, named):
    before = Looked()
    leave()
    (left,) = put_back(before)
    assert left.startswith(named)
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


def test_each_test_and_its_file_are_watched(request):
    assert {
        "_a_test_leaves_nothing_behind",
        "_a_file_of_tests_leaves_nothing_behind",
    } <= {*request.fixturenames}
