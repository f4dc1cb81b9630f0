"""Break the package on purpose, one line at a time, and see that the tests notice.

`python tasks.py mutations` works through tests/mutations.csv: each row is an exact
piece of text in a module, another one in its place, what that breaks, and the tests
that have to notice. A copy of the project is mutated, never the project itself.

With `--drawn` it works through tests/mutations_drawn.csv, the faults that
`python -m pgm_book.make.faults` drew by a seed. Of these the test that noticed the last
time is run first; then those of the module's room; then those of other rooms that
come past.
"""

import argparse
import csv
import multiprocessing
import os
import random
import re
import shutil
import sys
import tempfile
import time
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

from pgm_book.make import faults

ROOT = Path(__file__).resolve().parents[2]
LIST = ROOT / "tests" / "mutations.csv"
COPIED = ("pgm_lab", "pgm_book", "tests", "tools", "data", "notebooks", "docs")
COPIED_FILES = ("conftest.py", "pyproject.toml")

# What pytest's exit codes say of a mutation; 2 comes from imports that fail, 4 from a
# test that is there no more, 5 from tests that were all left out.
VERDICTS = {0: "survived", 1: "killed", 2: "killed", 4: "survived", 5: "survived"}
SLOW = "killed by the time limit"

# Where the system can fork, each run of the tests finds the large libraries loaded.
FORKS = "forkserver" in multiprocessing.get_all_start_methods()
PROCESSES = multiprocessing.get_context("forkserver" if FORKS else "spawn")
LIBRARIES = ["cv2", "hypothesis", "IPython.display", "matplotlib.pyplot"]
LIBRARIES += [
    "nbval.plugin",
    "pytest",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.stats",
]
LIBRARIES += ["skimage.feature", "skimage.transform"]


def mutations(path: Path = LIST) -> list[dict[str, str]]:
    """The rows of the list."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, strict=True))


def mutated(row: dict[str, str], root: Path = ROOT) -> str:
    """The text of a module after a mutation.

    Raises
    ------
    ValueError
        If the old text is not found exactly once, or the line of a drawn fault not at
        all: the module has changed, and the list has to follow it.
    """
    text = (root / row["file"]).read_text(encoding="utf-8")
    if "occurrence" in row:
        return faults.put(text, row)
    times = text.count(row["old"])
    if times != 1 or row["old"] == row["new"]:
        raise ValueError(
            f"mutation {row['number']}: {row['old']!r} stands {times} times in"
            f" {row['file']}, not once. Bring tests/mutations.csv up to date"
        )
    return text.replace(row["old"], row["new"])


def copied(root: Path, folder: Path) -> None:
    """Copy what the tests need of a project."""
    for name in COPIED:
        if (root / name).is_dir():
            shutil.copytree(
                root / name, folder / name, ignore=shutil.ignore_patterns("__pycache__")
            )
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
    with (
        output.open("w", encoding="utf-8") as file,
        redirect_stdout(file),
        redirect_stderr(file),
    ):
        import pytest

        options = ["-x", "-q", "-rfE", "-p", "no:cacheprovider", "-p", "no:benchmark"]
        # The libraries are loaded already
        options += ["-W", "ignore::pytest.PytestAssertRewriteWarning"]
        code = pytest.main([*options, "-m", marks, *tests])
    sys.exit(int(code))


def changed(path: Path, text: bytes) -> None:
    """Write a module, and remove its bytecode.

    Its time and size do not tell: a mutation may be as long, and as young, as what it
    replaces. The bytecode of all others, and of the tests, saves most of the time.
    """
    path.write_bytes(text)
    for compiled in (path.parent / "__pycache__").glob(f"{path.stem}.*"):
        compiled.unlink()


def verdict(
    tests: list[str], folder: Path, seconds: float | None, marks: str = ""
) -> str:
    """What becomes of a mutation when the tests are run in the copy that has it."""
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


def stages(row: dict[str, str]) -> list[list[str]]:
    """Lists of tests, to be run one after the other until one notices."""
    # The killer is one test, whose name may hold spaces
    found = [[row["killer"]]] if row.get("killer") else []
    return found + [
        row[name].split(" ") for name in ("tests", "others") if row.get(name)
    ]


def killer(output: Path) -> str:
    """Which test noticed: pytest names it in its last lines."""
    text = output.read_text(encoding="utf-8")
    named = re.findall(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", text, re.MULTILINE)
    return named[-1] if named else ""


def tried(
    rows: list[dict[str, str]],
    root: Path,
    seconds: float,
    trust: bool = False,
    marks: str = "",
) -> dict[str, tuple[str, str]]:
    """Verdict on each mutation and the test that noticed, by the mutation's number.

    Raises
    ------
    ValueError
        If the list is outdated, or if the tests fail without any mutation; that they
        pass is taken for granted with `trust`.
    """
    found = {}
    texts = [mutated(row, root) for row in rows]
    tests = sorted({name for row in rows for name in row["tests"].split(" ")})
    if FORKS:
        PROCESSES.set_forkserver_preload(LIBRARIES)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        output = folder / "output.txt"
        copied(root, folder)
        if not trust and verdict(tests, folder, None, marks) != "survived":
            told = output.read_text(encoding="utf-8")
            raise ValueError(f"{told}\nthe tests fail without any mutation")
        for row, text in zip(rows, texts, strict=True):
            start, path = time.perf_counter(), folder / row["file"]
            kept = path.read_bytes()
            changed(path, text.encode())
            for some in stages(row):
                answer = verdict(some, folder, seconds, marks)
                if answer != "survived":
                    break
            noticed = answer == "killed"
            found[row["number"]] = answer, killer(output) if noticed else ""
            changed(path, kept)
            took = f"{time.perf_counter() - start:.0f} s"
            what = row.get("breaks") or f"{row['kind']}: {row['after']}"
            line = f"{row['number']:>3} {answer}, {took}: {row['file']}, {what}"
            print(line, flush=True)
    return found


def record(column: str, found: dict[str, tuple[str, str]], path: Path = LIST) -> None:
    """Write verdicts into a column of the list; the drawn ones with their killers."""
    rows = mutations(path)
    for row in rows:
        before = row.get(column, ""), row.get("killer", "")
        row[column], noticed = found.get(row["number"], before)
        if "killer" in row:
            row["killer"] = noticed
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def chosen(options: argparse.Namespace) -> list[dict[str, str]]:
    """The rows that were asked for."""
    rows = mutations(faults.DRAWN if options.drawn else LIST)
    if options.alive:
        rows = [row for row in rows if row["verdict"] not in ("killed", SLOW)]
    if options.only:
        words = options.only
        rows = [
            row
            for row in rows
            if any(word in row["file"] or word == row["number"] for word in words)
        ]
    if options.sample is not None:
        count = min(options.sample, len(rows))
        drawn = random.Random(options.seed).sample(range(len(rows)), count)
        rows = [rows[i] for i in sorted(drawn)]
    return rows


def main(arguments: list[str]) -> int:
    """Try the mutations; the exit code is 0 if none survives."""
    parser = argparse.ArgumentParser(prog="python tasks.py mutations")
    parser.add_argument(
        "--drawn", action="store_true", help="the faults that were drawn by a seed"
    )
    parser.add_argument(
        "--alive", action="store_true", help="of these, what was not killed before"
    )
    parser.add_argument("--only", nargs="+", help="parts of file names, or numbers")
    parser.add_argument("--sample", type=int, help="draw so many of them")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--seconds", type=float, default=300, help="limit of each")
    parser.add_argument("--record", help="write the verdicts into this column")
    parser.add_argument(
        "--trust", action="store_true", help="do not run the tests without mutation"
    )
    parser.add_argument(
        "--fast", action="store_true", help="by the tests alone that `make test` runs"
    )
    parser.add_argument("--project", type=Path, default=ROOT, help="another checkout")
    options = parser.parse_args(arguments)
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        rows = chosen(options)
        marks = "not slow" if options.fast else ""
        found = tried(rows, options.project, options.seconds, options.trust, marks)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    if options.record:
        record(options.record, found, faults.DRAWN if options.drawn else LIST)
    counts = Counter(answer for answer, _ in found.values())
    print(", ".join(f"{n} {word}" for word, n in counts.most_common()) or "none chosen")
    return int("survived" in counts)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
