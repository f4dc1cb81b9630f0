"""Draw small faults over the whole package, each on one line of it, by a seed.

`python -m pgm_book.make.faults --seed 12 --count 300` writes
tests/mutations_drawn.csv, which `python tasks.py mutations --drawn` works through.
A line is drawn first, each with the
same chance, so that a large room gets more faults; then a kind of fault that the line
allows, then one of that kind.

Left out is what no test should hold: docstrings, comments, types, what stands in a
`raise` or in a text, `__all__`; and in what draws, all numbers and truth values, the
arithmetic with them, and the looks by name (`fontsize=`, `set_axis_off`), since these
are a matter of taste. Left out is also what any test would notice, or none could: the
order of arguments if one is a text, or if it does not matter (`np.hypot`). As there
are so many calls, their order is drawn less often than the other kinds.
"""

import argparse
import ast
import csv
import random
import sys
from collections.abc import Iterator
from pathlib import Path

from pgm_book.make.fault_sites import sites

ROOT = Path(__file__).resolve().parents[2]
DRAWN = ROOT / "tests" / "mutations_drawn.csv"
COLUMNS = ["number", "file", "line", "occurrence", "before", "after", "kind"]
COLUMNS += ["tests", "others", "verdict", "killer", "reason"]

DRAWING = ("pgm_lab/plot/", "pgm_lab/report/_figures.py")
WEIGHTS = {"the order of arguments": 0.3}  # of the kinds in the draw; others have 1


def faults(path: Path, root: Path = ROOT) -> Iterator[dict[str, str]]:
    """All faults that a module allows, as rows of the list."""
    name = path.relative_to(root).as_posix()
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    for fault in sites(text, drawing=name.startswith(DRAWING)):
        raw = lines[fault.line - 1].encode()
        after = (raw[: fault.begin] + fault.new.encode() + raw[fault.end :]).decode()
        before = lines[fault.line - 1].strip()
        earlier = [line.strip() for line in lines[: fault.line]]
        row = {"file": name, "line": str(fault.line), "before": before}
        row |= {"occurrence": str(earlier.count(before)), "after": after.strip()}
        if row["before"] != row["after"]:
            yield row | {"kind": fault.kind}


def is_python(text: str) -> bool:
    """Whether a text can be compiled."""
    try:
        ast.parse(text)
    except SyntaxError:
        return False
    return True


def put(text: str, row: dict[str, str]) -> str:
    """The text of a module with a fault, found by its line and by which one of these.

    Raises
    ------
    ValueError
        If the line is not there any more, or the fault is no change.
    """
    lines = text.splitlines()
    same = [i for i, line in enumerate(lines) if line.strip() == row["before"]]
    which = int(row["occurrence"]) - 1
    if which >= len(same) or row["before"] == row["after"]:
        raise ValueError(
            f"fault {row['number']}: the line {row['before']!r} stands {len(same)}"
            f" times in {row['file']}. Bring tests/mutations_drawn.csv up to date"
        )
    line = lines[same[which]]
    indent = line[: len(line) - len(line.lstrip())]
    lines[same[which]] = indent + row["after"]
    return "\n".join(lines) + "\n"


def tests_of(name: str, root: Path = ROOT) -> str:
    """The tests of a module's room, and the examples of the module itself."""
    parts = Path(name).parts
    room = parts[1]
    tests = [f"tests/{room}"] if len(parts) > 2 else []
    if not tests:
        stem = Path(room).stem.lstrip("_")
        tests = [f"tests/{path.name}" for path in root.glob(f"tests/test_{stem}*.py")]
    return " ".join([*tests, name])


def draw(seed: int, count: int, root: Path = ROOT) -> list[dict[str, str]]:
    """Draw so many lines of the package, and a fault of each."""
    by_line: dict[tuple[str, str], dict[str, list]] = {}
    for path in sorted((root / "pgm_lab").rglob("*.py")):
        for row in faults(path, root):
            kinds = by_line.setdefault((row["file"], row["line"]), {})
            kinds.setdefault(row["kind"], []).append(row)
    rng = random.Random(seed)
    lines = sorted(by_line)
    rng.shuffle(lines)
    drawn = []
    for line in lines:
        kinds = sorted(by_line[line])
        weights = [WEIGHTS.get(kind, 1.0) for kind in kinds]
        kind = rng.choices(kinds, weights)[0]
        row = dict.fromkeys(COLUMNS, "") | rng.choice(by_line[line][kind])
        text = (root / row["file"]).read_text(encoding="utf-8")
        if len(drawn) == count:
            break
        if is_python(put(text, row)):
            drawn.append(row | {"tests": tests_of(row["file"], root)})
    drawn.sort(key=lambda row: (row["file"], int(row["line"])))
    return [row | {"number": str(n)} for n, row in enumerate(drawn, start=1)]


def write(rows: list[dict[str, str]], path: Path = DRAWN) -> None:
    """Write the list."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main(arguments: list[str]) -> None:
    """Draw the list anew."""
    parser = argparse.ArgumentParser(prog="python -m pgm_book.make.faults")
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--out", type=Path, default=DRAWN)
    options = parser.parse_args(arguments)
    write(draw(options.seed, options.count), options.out)


if __name__ == "__main__":
    main(sys.argv[1:])
