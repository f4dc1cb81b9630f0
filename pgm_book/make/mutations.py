"""Break the package on purpose, one line at a time, and check that the tests notice.

`python tasks.py mutations` works through tests/mutations.csv: each row is an exact
piece of text in a module, another one in its place, what that breaks, and the tests
that have to notice. A copy of the project is broken, never itself.
"""

import argparse
import csv
import multiprocessing
import os
import shutil
import sys
import tempfile
import time
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = ROOT / "tests" / "mutations.csv"
COPIED = ("pgm_lab", "pgm_book", "tests", "data", "notebooks", "docs")
COPIED_FILES = ("conftest.py", "pyproject.toml")

# What pytest's exit codes say of a fault; 2 comes from imports that fail, 4 from a
# test that is there no more, 5 from tests that were all left out.
VERDICTS = {0: "survived", 1: "killed", 2: "killed", 4: "survived", 5: "survived"}
SLOW = "killed by the time limit"

# Where the system can fork, each run of the tests finds the large libraries loaded.
FORKS = "forkserver" in multiprocessing.get_all_start_methods()
PROCESSES = multiprocessing.get_context("forkserver" if FORKS else "spawn")
LIBRARIES = [
    "cv2",
    "hypothesis",
    "IPython.display",
    "matplotlib.pyplot",
    "nbval.plugin",
    "pytest",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.stats",
    "skimage.feature",
    "skimage.transform",
]

Row = dict[str, str]


def listed(path: Path = LIST) -> list[Row]:
    """Return the rows of a list."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, strict=True))


def mutated(row: Row, root: Path = ROOT) -> str:
    """Return the text of a module with a fault; ValueError if the list is outdated."""
    text = (root / row["file"]).read_text(encoding="utf-8")
    old, new = row["old"], row["new"]
    if (times := text.count(old)) != 1 or old == new:
        raise ValueError(
            f"fault {row['number']}: {old!r} occurs {times} times in {row['file']}."
            " Bring the list up to date"
        )
    return text.replace(old, new)


def copied(root: Path, folder: Path) -> None:
    """Copy what the tests need of a project."""
    ignored = shutil.ignore_patterns("__pycache__")
    for name in COPIED:
        if (root / name).is_dir():
            shutil.copytree(root / name, folder / name, ignore=ignored)
    for name in COPIED_FILES:
        shutil.copy2(root / name, folder / name)


def run_tests(folder: Path, tests: list[str], output: Path, marks: str) -> None:
    """Run tests in a copy of the project; the exit code is that of pytest."""
    for name in list(sys.modules):  # of the project, not of the copy
        if name.split(".")[0] in COPIED:
            del sys.modules[name]
    os.environ["PYTHONPATH"] = str(folder)
    sys.path.insert(0, str(folder))
    os.chdir(folder)
    with output.open("w", encoding="utf-8") as file:
        with redirect_stdout(file), redirect_stderr(file):
            import pytest

            plain = ["-x", "-q", "-rfE", "-p", "no:cacheprovider", "-p", "no:benchmark"]
            # The libraries are loaded already
            plain += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
            code = pytest.main([*plain, "-m", marks, *tests])
    sys.exit(int(code))


def verdict(tests: list[str], folder: Path, seconds: float | None, marks: str) -> str:
    """Return what becomes of a fault when these tests are run in its copy."""
    output = folder / "output.txt"
    process = PROCESSES.Process(target=run_tests, args=(folder, tests, output, marks))
    process.start()
    process.join(seconds)
    if process.is_alive():
        process.kill()
        process.join()
        return SLOW
    if process.exitcode not in VERDICTS:
        raise RuntimeError(output.read_text(encoding="utf-8"))
    return VERDICTS[process.exitcode]


def tried(
    rows: list[Row],
    root: Path = ROOT,
    seconds: float = 300,
    marks: str = "",
    trust: bool = False,
) -> dict[str, str]:
    """Return the verdict on each fault, by its number.

    That the tests pass without a fault is tried first, unless with `trust`.
    """
    found = {}
    texts = [mutated(row, root) for row in rows]
    if FORKS:
        PROCESSES.set_forkserver_preload(LIBRARIES)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copied(root, folder)
        every = sorted({test for row in rows for test in row["tests"].split()})
        if not trust and verdict(every, folder, None, marks) != "survived":
            told = (folder / "output.txt").read_text(encoding="utf-8")
            raise ValueError(f"{told}\nthe tests fail without any fault")
        for row, text in zip(rows, texts, strict=True):
            start, path = time.perf_counter(), folder / row["file"]
            kept = path.read_bytes()
            changed(path, text.encode())
            answer = verdict(row["tests"].split(), folder, seconds, marks)
            found[row["number"]] = answer
            changed(path, kept)
            took = f"{time.perf_counter() - start:.0f} s"
            print(
                f"{row['number']:>3} {answer}, {took}: {row['file']}, {row['breaks']}"
            )
    return found


def changed(path: Path, text: bytes) -> None:
    """Write a module, and remove its bytecode: time and size may not differ."""
    path.write_bytes(text)
    for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*"):
        compiled.unlink()


def record(column: str, found: dict[str, str], path: Path = LIST) -> None:
    """Write verdicts into a column of the list."""
    rows = listed(path)
    for row in rows:
        row[column] = found.get(row["number"], row.get(column, ""))
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main(arguments: list[str]) -> int:
    """Try the faults; the exit code is 0 if none survives."""
    parser = argparse.ArgumentParser(prog="python tasks.py mutations")
    add = parser.add_argument
    add("--only", nargs="+", help="parts of file names, or numbers")
    add("--fast", action="store_true", help="by the tests that `make test` runs")
    add("--trust", action="store_true", help="do not run the tests without a fault")
    add("--seconds", type=float, default=300, help="limit of each")
    add("--record", metavar="COLUMN", help="write the verdicts into this column")
    options = parser.parse_args(arguments)
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    rows = [
        row
        for row in listed()
        if not options.only
        or any(word in row["file"] or word == row["number"] for word in options.only)
    ]
    marks = "not slow" if options.fast else ""
    try:
        found = tried(rows, ROOT, options.seconds, marks, options.trust)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    if options.record:
        record(options.record, found)
    counts = Counter(found.values())
    print(", ".join(f"{n} {word}" for word, n in counts.most_common()) or "none chosen")
    return int("survived" in counts)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
