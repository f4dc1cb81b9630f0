"""The wheel works alone: data, lessons, predictions, checks and the command."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
USE = """
import json, pathlib, sys
import pgm_book, pgm_lab
from pgm_book.ch02 import checks as chapter2, figures
from pgm_book.common import checks, ledger, results
from pgm_book import program
from pgm_lab import datasets, ncc
checks.predict("2.1")
correlation = lambda a, b: ncc.correlation(a, b)
chapter2.correlation(correlation)
assert datasets.bani2010().pixels.shape == (2, 10, 2)
assert len(ledger.verdicts()) > 300 and results.rows("ch02", "windows")
print(json.dumps([pgm_lab.__file__, pgm_book.__file__]))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel as `python -m build` makes it, from a copy of the project."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir"]
    clone = ["git", "clone", "-q", "--depth", "1", ROOT.as_uri(), str(folder / "clone")]
    subprocess.run(clone, check=True)
    subprocess.run([*command, folder], cwd=folder / "clone", check=True)
    (made,) = folder.glob("*.whl")
    return made


def test_it_holds_both_packages_with_all_their_files_and_nothing_else(wheel):
    with zipfile.ZipFile(wheel) as archive:
        held = {name for name in archive.namelist() if ".dist-info/" not in name}
    tracked = subprocess.run(
        ["git", "ls-files", "pgm_lab", "pgm_book", "data"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    wanted = {f"pgm_lab/{name}" if name[:5] == "data/" else name for name in tracked}
    assert held == wanted


def test_what_is_said_of_it_can_be_shown_on_pypi(wheel):
    command = [sys.executable, "-m", "twine", "check", "--strict", wheel]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_installed_alone_it_teaches_and_computes(wheel, tmp_path):
    """In a folder beside the dependencies, far from the repository."""
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    env = os.environ | {"PYTHONPATH": str(site), "MPLBACKEND": "agg"}
    run = {"cwd": tmp_path, "env": env, "capture_output": True, "text": True}
    done = subprocess.run([sys.executable, "-c", USE], **run)
    assert done.returncode == 0, done.stderr
    places = json.loads(done.stdout.splitlines()[-1])
    assert all(Path(place).is_relative_to(site) for place in places)
    sample = site / "pgm_lab" / "data" / "sample"
    files = [sample / f"{n}.txt" for n in ("interior", "exterior", "points", "image")]
    command = [sys.executable, "-m", "pgm_lab", "adjust", *files, "--lens", "forward"]
    done = subprocess.run([*command, "--report", tmp_path / "r.html"], **run)
    assert done.returncode == 0 and (tmp_path / "r.html").exists(), done.stderr
