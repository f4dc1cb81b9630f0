"""What each task of tasks.py does; standard library only, .venv may not exist yet."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import IO
from unittest.mock import patch

from pgm_book.make.environment import ROOT, Refused, ensure, environment, work_folder

# Threads of the numerical libraries would fight the parallel test workers for cores.
LARGEST_SAMPLES = "PGM_LAB_LARGEST_SAMPLES"  # what only test-all asks for
ONE_THREAD = {
    name: "1"
    for name in [
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "OPENCV_FOR_THREADS_NUM",
    ]
}

# Kernels side by side would wait for each other at a shared history file, and newer
# ones warn that a connection inside this machine is not encrypted.
KERNEL_CONFIG = """\
c = get_config()
c.HistoryManager.enabled = False
c.IPKernelApp.log_level = "ERROR"
"""


# A reader without a network should not be asked to subscribe to news.
LAB_SETTINGS = {
    "@jupyterlab/apputils-extension:notification": {
        "checkForUpdates": False,
        "fetchNews": "false",
    }
}


def lab(*arguments: str) -> int:
    """Open the workbook in JupyterLab, in the reader's own copy in work/."""
    python = ensure(".venv", "main")
    overrides = ROOT / ".venv" / "share" / "jupyter" / "lab" / "settings"
    overrides.mkdir(parents=True, exist_ok=True)
    (overrides / "overrides.json").write_text(json.dumps(LAB_SETTINGS))
    code = run([python, "-m", "pgm_book.make.work_copy"])
    if code:
        return code
    command = [python, "-m", "jupyterlab", "00_start_here.ipynb", *arguments]
    # In a container root is often the only user; JupyterLab runs for it if allowed.
    # Elsewhere its refusal stands: what a notebook of root's runs may do anything.
    if in_container():
        command.append("--allow-root")
    return run(command, cwd=work_folder(ROOT), replace=True)


def test(*arguments: str) -> int:
    """Check everything in minutes, or one lesson or room alone: test 3, test ncc."""
    python = ensure(".venv", "main")
    if arguments and not arguments[0].startswith("-"):
        chosen = [one for word in arguments for one in tests_of(word) or [word]]
        return run_tests(python, "-m", "not slow", *chosen)
    for check in (
        ["ruff", "check", "--output-format=concise", "."],
        ["ruff", "format", "--check", "--output-format=concise", "."],
    ):
        code = run([python, "-m", *check])
        if code:
            return code
    # What mypy checks, and how strictly, is set in pyproject.toml.
    with tempfile.TemporaryFile() as output:
        types = started([python, "-m", "mypy"], stdout=output)
        code = run_tests(python, "-m", "not slow", *arguments)
        code = waited_for(types) or code
        output.seek(0)
        print(output.read().decode(), end="")
    return code


def test_slow(*arguments: str) -> int:
    """Run the tests that take longer: all bad input, solved copies, large samples."""
    return run_tests(ensure(".venv", "main"), "-m", "slow", *arguments)


def test_all(*arguments: str) -> int:
    """Run test, test-slow with the largest samples, and test-publish."""
    tasks = {"test": test, "test-slow": test_slow, "test-publish": test_publish}
    with patch.dict(os.environ, {LARGEST_SAMPLES: "1"}):
        failed = [name for name, task in tasks.items() if task(*arguments)]
    if failed:
        print(f"Failed: {', '.join(failed)}")
    return int(bool(failed))


def test_oldest(*arguments: str) -> int:
    """Run the tests with the oldest allowed versions, on Python 3.11."""
    if sys.version_info[:2] != (3, 11):
        older = shutil.which("python3.11")
        if older is None:
            print("test-oldest needs Python 3.11: python3.11 tasks.py test-oldest")
            return 1
        return run([older, "tasks.py", "test-oldest", *arguments])
    return run_tests(ensure(".venv-oldest", "oldest"), *arguments)


def test_publish(*arguments: str) -> int:
    """Test slides, handouts and site in a real browser, with its network cut."""
    python = ensure(".venv", "main", "publish")
    command = [python, "-m", "pytest", "tests/publish", *in_parallel()]
    return run([*command, *arguments], settings(python))


# What only runs a module in the environment: the sets of packages, what is run, help.
MODULES = {
    "chapter": (
        ["main"],
        ["pgm_book.make.chapter"],
        "Begin a chapter: NUMBER name, for example 10 cloud_shadows.",
    ),
    "notebooks": (
        ["main"],
        ["pgm_book.make.notebooks"],
        "Execute every notebook, or the named ones, and store the outputs.",
    ),
    "slides": (
        ["main", "publish"],
        ["pgm_book.make", "slides"],
        "Make the slides for lecturers and for students, one HTML file each.",
    ),
    "handouts": (
        ["main", "publish"],
        ["pgm_book.make", "handouts"],
        "Make the handouts, one PDF a chapter, in build/handouts.",
    ),
    "site": (
        ["main", "publish"],
        ["pgm_book.make", "site"],
        "Make the website, in build/site; it needs no server and no network.",
    ),
    "student": (
        ["main"],
        ["pgm_book.make", "student"],
        "Make the copies for students and instructors, or --format nbgrader or otter.",
    ),
    "course": (
        ["main", "publish"],
        ["pgm_book.course.pack"],
        "Make the zips for students and instructors, and a stick with --wheels.",
    ),
    "release": (
        ["main", "publish"],
        ["pgm_book.make.release"],
        "Make all files of a release from the commit, with --check twice.",
    ),
    "grade": (
        ["main"],
        ["pgm_book.course.grade"],
        "Grade a folder of submissions, each in a closed box, into build/grades.",
    ),
    "quiz": (
        ["main"],
        ["pgm_book.course.quiz"],
        "Write all questions for exam systems: GIFT, Moodle XML, QTI; in build/quiz.",
    ),
    "exam": (
        ["main", "publish"],
        ["pgm_book.course.exam"],
        "Make a two-hour paper and its key: SEED, and lessons if not all.",
    ),
    "requirements": (
        ["main", "dev"],
        ["pgm_book.make.requirements"],
        "Derive requirements*.txt and environment.yml from pyproject.toml.",
    ),
    "benchmark": (
        ["main", "dev"],
        ["pytest", "tests/benchmarks"],
        "Measure the times in tests/benchmarks.",
    ),
    "mutations": (
        ["main"],
        ["pgm_book.make.mutations"],
        "Break the package one line at a time, and check that the tests notice (slow).",
    ),
    "house": (
        ["main"],
        ["pgm_book.make.house"],
        "Draw the map of both packages, docs/house.svg, and check its rules.",
    ),
}


def run_module(name: str, *arguments: str) -> int:
    """Run one of `MODULES`, with personal settings kept out."""
    sets, module, _ = MODULES[name]
    python = ensure(".venv", *sets)
    return run([python, "-m", *module, *arguments], settings(python))


def in_container() -> bool:
    """Whether Docker, Podman or the like report that they run this process."""
    marks = [Path("/.dockerenv"), Path("/run/.containerenv")]
    return "container" in os.environ or any(mark.exists() for mark in marks)


TASKS: dict[str, Callable[..., int]] = {
    "lab": lab,
    "test": test,
    "test-slow": test_slow,
    "test-all": test_all,
    "test-oldest": test_oldest,
    "test-publish": test_publish,
    **{name: partial(run_module, name) for name in MODULES},
}


def tests_of(word: str) -> list[str]:
    """Name the tests of a lesson ("3", "A1") or of a room ("ncc"), by their folders.

    A lesson has its folder, the proofs that `data/audit` names for it, and notebooks.
    """
    number = word.removeprefix("ch").zfill(2)
    patterns = [
        f"tests/{word}",
        f"tests/test_{word}.py",
        f"pgm_lab/{word}",
        f"pgm_lab/{word}.py",
    ]
    if word in ("common", "program", "course"):
        patterns.append(f"pgm_book/{word}")
    if re.fullmatch(r"\d\d|A\d", number):
        patterns = [f"tests/ch{number}", f"notebooks/{number}_*.ipynb"]
        patterns += [f"pgm_book/ch{number}/*.py"]
    found = [path for pattern in patterns for path in sorted(ROOT.glob(pattern))]
    names = [path.relative_to(ROOT).as_posix() for path in found]
    proofs = ROOT / "data" / "audit" / f"{number}.csv"
    if proofs.exists():
        with proofs.open(encoding="utf-8", newline="") as file:
            proving = dict.fromkeys(row["test"] for row in csv.DictReader(file))
        # A row that was read and not proved has "-: ..."
        names += [f"tests/audit/{test}" for test in proving if test[0] != "-"]
    return names


def run_tests(python: Path, *arguments: str) -> int:
    """One pytest run over tests, doctests and notebooks, on up to four cores."""
    command = [python, "-m", "pytest", "--nbval", *in_parallel()]
    return run([*command, *arguments], settings(python))


def in_parallel() -> list:
    """Arguments that let pytest use up to four cores, a file of tests on each."""
    workers = min(4, os.cpu_count() or 1)
    # In the order of conftest.py; pytest-benchmark, where it is installed, cannot
    # measure in parallel.
    options = ["--dist", "loadfile", "--no-loadscope-reorder", "-p", "no:benchmark"]
    return ["-n", workers, "-q", *options]


def settings(python: Path) -> dict[str, str]:
    """Environment variables that keep personal settings out of the outputs."""
    private = python.parents[1] / "isolated"
    profile = private / "ipython" / "profile_default"
    profile.mkdir(parents=True, exist_ok=True)
    (profile / "ipython_config.py").write_text(KERNEL_CONFIG, encoding="utf-8")
    folders = {
        "IPYTHONDIR": private / "ipython",
        "JUPYTER_CONFIG_DIR": private / "jupyter",
        "JUPYTER_DATA_DIR": private / "jupyter-data",
        "MPLCONFIGDIR": private / "matplotlib",
    }
    return ONE_THREAD | {name: str(folder) for name, folder in folders.items()}


def run(
    command: list,
    extra: dict[str, str] | None = None,
    cwd: Path = ROOT,
    replace: bool = False,
) -> int:
    """Run a command to its end and give its exit code.

    With `replace` the command takes the place of this process where the system can do
    that, so that whoever stops this process stops the command.
    """
    if replace and os.name == "posix":
        command = [str(part) for part in command]
        os.chdir(cwd)
        os.execve(command[0], command, environment(**(extra or {})))
    return waited_for(started(command, extra, cwd))


def started(
    command: list,
    extra: dict[str, str] | None = None,
    cwd: Path = ROOT,
    stdout: IO[bytes] | None = None,
) -> subprocess.Popen:
    """Start a command, with the environment variables that it may have."""
    command = [str(part) for part in command]
    variables = environment(**(extra or {}))
    return subprocess.Popen(command, cwd=cwd, env=variables, stdout=stdout)


def waited_for(process: subprocess.Popen) -> int:
    """Wait for a command and give its exit code.

    Ctrl-C goes to the command, which stops in its own way.
    """
    while True:
        try:
            return process.wait()
        except KeyboardInterrupt:
            continue


def main(arguments: list[str]) -> int:
    """Run the task named first, with the arguments after it."""
    if not arguments or arguments[0] not in TASKS:
        if arguments and arguments[0] not in ("-h", "--help", "help"):
            print(f"There is no task {arguments[0]!r}.\n")
        print("python tasks.py NAME [arguments], or make NAME. The tasks:\n")
        for name, task in TASKS.items():
            print(
                f"  {name:13} {MODULES[name][2] if name in MODULES else task.__doc__}"
            )
        return 0 if arguments[:1] in ([], ["-h"], ["--help"], ["help"]) else 2
    try:
        return TASKS[arguments[0]](*arguments[1:])
    except KeyboardInterrupt:
        return 130
    except Refused as reason:
        print(f"\n{reason}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(
            f"\nThe environment could not be set up: {' '.join(error.cmd)}\n"
            "failed, see the message above it. The first run needs the network; run "
            "the task again to retry.",
            file=sys.stderr,
        )
        return 1
