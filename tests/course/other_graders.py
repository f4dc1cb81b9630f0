"""The real nbgrader and Otter, each in an environment of its own.

`python -m tests.course.other_graders nbgrader 04_rotation_matrices ...` prints a table:
the points of a blank submission, of a solved one, and what there is to earn.
"""

import csv
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import nbformat

from pgm_book.course.assignments import write
from pgm_book.make.environment import ROOT, environment, python_of
from pgm_book.make.student import PROGRAM

PACKAGES = {"nbgrader": "nbgrader==0.9.6", "otter": "otter-grader==7.0.0"}


class NoNetwork(Exception):
    """The program cannot be fetched."""


def installed(grader: str, folder: Path) -> Path:
    """Return the Python of a new environment with a grader and all of this one."""
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    python = python_of(folder)
    pip = [python, "-m", "pip", "install", "-q", "--disable-pip-version-check"]
    pip += ["--retries=1", "--timeout=10", PACKAGES[grader]]
    done = subprocess.run(pip, capture_output=True, text=True)
    if done.returncode:
        raise NoNetwork(done.stderr.strip().rpartition("\n")[2])
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    said = subprocess.run([python, "-c", ask], capture_output=True, text=True)
    ours = sysconfig.get_path("purelib")
    path = Path(said.stdout.strip(), "workbook.pth")
    path.write_text(f"import site; site.addsitedir({ours!r})\n", encoding="utf-8")
    return python


def points(grader: str, python: Path, stem: str, folder: Path) -> tuple[float, ...]:
    """Return what blank and solved get, and the most, of one notebook's assignment."""
    write([ROOT / "notebooks" / f"{stem}.ipynb"], folder, grader)
    return GRADERS[grader](python, stem, folder / grader)


def by_nbgrader(python: Path, stem: str, course: Path) -> tuple[float, ...]:
    """Generate, submit blank and solved, autograde, export."""
    call(python, course, "-m", "nbgrader", "generate_assignment", stem)
    release = course / "release" / stem
    source = course / "source" / stem
    assert_blank(release / f"{stem}.ipynb", source / f"{stem}.ipynb")
    for name in ("blank", "solved"):
        submitted = course / "submitted" / name / stem
        shutil.copytree(release, submitted)
        if name == "solved":
            answers(source / f"{stem}.ipynb", submitted / f"{stem}.ipynb")
    call(python, course, "-m", "nbgrader", "autograde", stem)
    call(python, course, "-m", "nbgrader", "export")
    with (course / "grades.csv").open(encoding="utf-8", newline="") as file:
        rows = {row["student_id"]: row for row in csv.DictReader(file)}
    most = float(rows["solved"]["max_score"])
    return float(rows["blank"]["score"]), float(rows["solved"]["score"]), most


def assert_blank(released: Path, solved: Path) -> None:
    """No longer line of an answer is in what students get."""
    text = released.read_text(encoding="utf-8")
    assert "BEGIN SOLUTION" not in text and "END SOLUTION" not in text
    inside, lines = False, []
    for cell in nbformat.read(solved, as_version=4).cells:
        for line in cell.source.splitlines():
            marker = "BEGIN SOLUTION" in line or "END SOLUTION" in line
            inside = "BEGIN" in line if marker else inside
            lines += [line] if inside and not marker and len(line) > 30 else []
    cells = nbformat.read(released, as_version=4).cells
    shown = {line for cell in cells for line in cell.source.splitlines()}
    assert lines and not shown & set(lines), shown & set(lines)


def answers(source: Path, submitted: Path) -> None:
    """Put the solutions of the source into a released notebook."""
    solved = {
        cell.metadata["nbgrader"]["grade_id"]: cell.source
        for cell in nbformat.read(source, as_version=4).cells
        if cell.metadata.get("nbgrader", {}).get("solution")
    }
    notebook = nbformat.read(submitted, as_version=4)
    for cell in notebook.cells:
        name = cell.metadata.get("nbgrader", {}).get("grade_id")
        cell.source = solved.get(name, cell.source)
    nbformat.write(notebook, submitted)


def by_otter(python: Path, stem: str, course: Path) -> tuple[float, ...]:
    """Divide, then run the students' notebook and the grader's, which is solved."""
    dist, name = course / stem / "dist", f"{stem}.ipynb"
    call(python, course / stem, "-m", "otter", "assign", name, "dist", "--no-run-tests")
    assert_blank(dist / "student" / name, dist / "autograder" / name)
    (autograder,) = (dist / "autograder").glob("*.zip")
    found, most = [], 0.0
    for part in ("student", "autograder"):
        out = course / stem / part
        out.mkdir()
        shutil.copy(dist / part / PROGRAM, out)
        shutil.copy(dist / part / name, out)
        arguments = ["run", "-a", autograder, "-o", out, "--no-logo", out / name]
        call(python, out, "-m", "otter", *arguments)
        tests = json.loads((out / "results.json").read_text(encoding="utf-8"))["tests"]
        scored = [test for test in tests if "score" in test]
        found.append(sum(test["score"] for test in scored))
        most = sum(test["max_score"] for test in scored)
    return *found, most


GRADERS = {"nbgrader": by_nbgrader, "otter": by_otter}


def call(python: Path, folder: Path, *arguments) -> None:
    """Run a program of an environment, which has to succeed."""
    private = {
        name: str(python.parents[1] / name.lower())
        for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR")
    }
    path = f"{python.parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [str(part) for part in (python, *arguments)],
        cwd=folder,
        env=environment(PATH=path, **private),
        capture_output=True,
        text=True,
        errors="replace",
    )
    if done.returncode:
        raise AssertionError(f"{arguments}: {done.stdout[-3000:]}{done.stderr[-3000:]}")


def main(grader: str, *stems: str) -> None:
    """Print the table of a grader, for the named notebooks."""
    with tempfile.TemporaryDirectory() as made:
        python = installed(grader, Path(made, "venv"))
        for number, stem in enumerate(stems):
            found = points(grader, python, stem, Path(made, str(number)))
            print(grader, stem, *(f"{one:g}" for one in found), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
