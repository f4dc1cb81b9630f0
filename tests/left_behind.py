"""No test leaves anything behind: what it left is put back, and the test fails.

A plugin of pytest, loaded by conftest.py. Each test, and each file of tests with its
fixtures, is looked at from before to after. Filters of warnings are not among what is
looked at, since pytest itself puts them back after each test.
"""

import functools
import os
import random
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from multiprocessing import resource_tracker, util
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from jupyter_core.utils import run_sync
from matplotlib import pyplot as plt
from tqdm import tqdm

ROOT = Path(__file__).resolve().parent.parent

# Made by tools, not by tests
OF_TOOLS = ("__pycache__", "build", "work")

# What a library keeps for the whole process, once it is loaded: matplotlib the files of
# its fonts, PROJ its table, rasterio where certificates are, Python's multiprocessing
# two helpers; pytest says which test is running.
KEPT_VARIABLES = ("GDAL_CURL_CA_BUNDLE", "PROJ_CURL_CA_BUNDLE", "PYTEST_CURRENT_TEST")
KEPT_FILES = ("/fonts/", "/proj.db", "anon_inode:", "/dev/")
KEPT_TEMPORARY = ("pymp-", ".org.chromium.")  # the browser of all tests has its own
KEPT_PROCESSES = ("multiprocessing.resource_tracker", "multiprocessing.forkserver")
SECONDS = 5.0  # that a thread or process which was told to end may take for it


def pytest_configure():
    """Give this process a temporary folder of its own, so that all in it is known.

    The folders of `tmp_path` stay where pytest keeps them, to be looked at later.
    """
    matplotlib.use("agg")  # whatever the screen
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", tempfile.gettempdir())
    own = tempfile.mkdtemp(prefix="pgm_lab_")
    for name in ("TMPDIR", "TEMP", "TMP"):
        os.environ[name] = own
    tempfile.tempdir = None
    tqdm.monitor_interval = 0  # no thread that watches progress bars
    # What is started in the background ignores Ctrl-C; asyncio would change that later
    signal.signal(signal.SIGINT, signal.default_int_handler)
    # What two libraries keep for the whole process, once they need it, is made now.
    run_sync(run_inside)()
    if os.name == "posix":
        resource_tracker.ensure_running()
    # After multiprocessing has removed its own folder in it, which has priority -100
    util.Finalize(None, shutil.rmtree, (own, True), exitpriority=-200)


async def run_inside():
    """Make the two event loops, one in a thread, of jupyter_core."""

    async def nothing():
        pass

    run_sync(nothing)()


class Looked:
    """What a test could leave behind, as it is now."""

    def __init__(self):
        self.figures = set(plt.get_fignums())
        self.style = dict.copy(matplotlib.rcParams)
        self.variables = dict(os.environ)
        self.path = list(sys.path)
        self.folder = os.getcwd()
        self.random = random.getstate()
        self.numpy = np.random.get_state()  # noqa: NPY002
        self.errors = np.geterr()
        self.signals = {s: signal.getsignal(s) for s in (signal.SIGINT, signal.SIGTERM)}
        self.threads = set(threading.enumerate())
        self.processes = processes()
        self.files = open_files()
        self.temporary = set(os.listdir(tempfile.gettempdir()))
        self.tree = tree()


def put_back(before: Looked) -> list[str]:
    """Undo what was left behind since then; return what it was."""
    left = []
    if figures := set(plt.get_fignums()) - before.figures:
        left.append(f"{len(figures)} open figures")
        for number in figures:
            plt.close(number)
    style = dict.copy(matplotlib.rcParams)
    if changed := [k for k, v in before.style.items() if not style[k] == v]:
        left.append(f"rcParams: {changed}")
        dict.update(matplotlib.rcParams, before.style)
    now = dict(os.environ)
    names = sorted({n for n, _ in now.items() ^ before.variables.items()})
    if names := [name for name in names if name not in KEPT_VARIABLES]:
        left.append(f"environment variables: {names}")
        for name in names:
            if name in before.variables:
                os.environ[name] = before.variables[name]
            else:
                del os.environ[name]
    if sys.path != before.path:
        left.append(f"sys.path: {sorted({*sys.path} ^ {*before.path})}")
        sys.path[:] = before.path
    if os.getcwd() != before.folder:
        left.append(f"the working folder {os.getcwd()}")
        os.chdir(before.folder)
    if random.getstate() != before.random:
        left.append("another state of random")
        random.setstate(before.random)
    now = np.random.get_state()  # noqa: NPY002
    if any(np.any(a != b) for a, b in zip(now, before.numpy)):
        left.append("another state of numpy.random")
        np.random.set_state(before.numpy)  # noqa: NPY002
    if np.geterr() != before.errors:
        left.append(f"numpy's {np.geterr()}")
        np.seterr(**before.errors)
    for number, handler in before.signals.items():
        if signal.getsignal(number) is not handler:
            left.append(f"a handler of {number.name}")
            signal.signal(number, handler)
    if threads := lasting(lambda: set(threading.enumerate()) - before.threads):
        left.append(f"threads: {sorted(t.name for t in threads)}")
    if found := lasting(lambda: processes().items() - before.processes.items()):
        left.append(f"processes: {sorted(found)}")
    if files := lasting(lambda: open_files() - before.files):
        left.append(f"open files: {sorted(files)}")
    temporary = Path(tempfile.gettempdir())
    files = set(os.listdir(temporary)) - before.temporary
    if files := {f for f in files if not f.startswith(KEPT_TEMPORARY)}:
        left.append(f"temporary files: {sorted(files)}")
        for name in files:
            remove(temporary / name)
    if files := tree() ^ before.tree:
        left.append(f"files made or removed in the project: {sorted(files)}")
    return left


def lasting(left):
    """What is still there after the time that it may take to end."""
    end = time.monotonic() + SECONDS
    while (found := left()) and time.monotonic() < end:
        time.sleep(0.01)
    return found


def processes() -> dict[int, str]:
    """Child processes by their number, where the system lists them as files."""
    found = {}
    for task in Path("/proc/self/task").glob("*/children"):
        try:
            for number in task.read_text().split():
                command = Path(f"/proc/{number}/cmdline").read_text().replace("\0", " ")
                if not any(kept in command for kept in KEPT_PROCESSES):
                    found[int(number)] = command
        except OSError:  # it has just ended
            continue
    return found


def open_files() -> set[str]:
    """What the numbers of open files stand for, where the system says."""
    found = set()
    for number in Path("/proc/self/fd").glob("*"):
        try:
            found.add(os.readlink(number))
        except OSError:  # that of the listing itself
            continue
    return {one for one in found if not any(kept in one for kept in KEPT_FILES)}


def folders(folder: Path) -> Iterator[Path]:
    """A folder and all in it, but for those of tools, which hold far more files."""
    yield folder
    for one in folder.iterdir():
        ours = not one.name.startswith((".", "work-")) and one.name not in OF_TOOLS
        if ours and one.is_dir():
            yield from folders(one)


FOLDERS = list(folders(ROOT))


def tree() -> frozenset[str]:
    """The files of the project, but for those of tools."""
    return frozenset().union(
        *(listed(folder, os.stat(folder).st_mtime_ns) for folder in FOLDERS)
    )


@functools.cache
def listed(folder: Path, _changed: int) -> frozenset[str]:
    """The names in a folder, read again when its time says that it has changed."""
    names = [name for name in os.listdir(folder) if not name.startswith(".")]
    return frozenset(str(folder / name) for name in names if name not in OF_TOOLS)


def remove(path: Path) -> None:
    """Remove a file, or a folder and all in it."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


@pytest.fixture(autouse=True, scope="module")
def _a_file_of_tests_leaves_nothing_behind():
    before = Looked()
    yield
    if left := put_back(before):
        pytest.fail("the fixtures of this file leave behind " + "; ".join(left))


@pytest.fixture(autouse=True)
def _a_test_leaves_nothing_behind(_a_file_of_tests_leaves_nothing_behind):
    before = Looked()
    yield
    if left := put_back(before):
        pytest.fail("this test leaves behind " + "; ".join(left))
