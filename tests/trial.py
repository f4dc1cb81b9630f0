"""A small copy of the project in which the command began a chapter: 97, a trial."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from pgm_book.make.environment import ROOT

FOLDERS = ("pgm_lab", "data", "notebooks", "pgm_book", "tests", "docs")
FILES = ("README.md", "pyproject.toml", "conftest.py")
SKIPPED = shutil.ignore_patterns("results", ".ipynb_checkpoints")


def project(folder: Path) -> Path:
    """Copy what a chapter touches."""
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, ignore=SKIPPED)
    for name in FILES:
        shutil.copy(ROOT / name, folder / name)
    return folder


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess:
    """Run a module of Python, or -c and code, in the copy and with its package."""
    module = [] if arguments[0] == "-c" else ["-m"]
    return subprocess.run(
        [sys.executable, *module, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder), "PYTHONUTF8": "1"},
        capture_output=True,
        text=True,
    )


def begun(folder: Path) -> Path:
    """Make the copy and begin chapter 97 in it by the command; return the lesson."""
    result = run(project(folder), "pgm_book.make.chapter", "97", "trial")
    assert result.returncode == 0, result.stdout + result.stderr
    return folder / "notebooks" / "97_trial.ipynb"


LESSON_ONLY = """\
from pgm_book.make import chapter, notebooks
lesson, *_ = chapter.begin("97", "trial")
raise SystemExit(notebooks.main([lesson.stem]))
"""


def lesson(folder: Path) -> Path:
    """Make the copy with the lesson alone executed, which takes a third of the time."""
    result = run(project(folder), "-c", LESSON_ONLY)
    assert result.returncode == 0, result.stdout + result.stderr
    return folder / "notebooks" / "97_trial.ipynb"
