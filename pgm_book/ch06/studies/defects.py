"""What each defect of the printed bundle adjustment does to the network of 2013.

``python -m pgm_book.ch06.studies.defects`` writes results/defects.csv in half a minute;
tests/ch06/test_defects.py repeats a part.
"""

from itertools import combinations

import numpy as np
from tqdm import tqdm

from pgm_book.ch06.defects import PROGRAM, adjust, network
from pgm_book.common import study
from pgm_lab import datasets

COLUMNS = (
    *("part", "defects", "sorted_by", "status", "steps", "rms_um", "best_rms_um"),
    *("own_rms_um", "kept", "c_mm", "off_published_mrad"),
)
MISCLOSURE = ("x/c", "centre twice", "2 P1 xy")
# What changes the solution, and not only what is said about its accuracy
MOVING = (*("sign", "short", "rows"), *MISCLOSURE, "pinv", "stop")
# Repaired together: the three terms of the misclosure, the approximate columns with
# the rows
GROUPS = {
    "sign": ("sign",),
    "rows": ("rows", "short"),
    "misclosure": MISCLOSURE,
    "pinv": ("pinv",),
    "stop": ("stop",),
}
MAX_ITERATIONS = 100


def row(part: str, defects, order: str = "point", label: str | None = None) -> tuple:
    """One run; what a diverging one ends with is chance and stays empty."""
    run = adjust(*network(order), defects, max_iterations=MAX_ITERATIONS)
    published = datasets.muliawan2013().published_exteriors[:, 3:]
    numbers = [""] * 7
    if run.status in ("converged", "stopped"):
        off = np.abs(run.exteriors[-1, :, 3:] - published).max()
        numbers = [
            len(run.corrections),
            f"{1000 * run.rms[-1]:.3f}",
            f"{1000 * run.rms.min():.3f}",
            f"{1000 * run.own_rms[-1]:.3f}",
            run.kept,
            f"{run.interior[-1, 0]:.4f}",
            f"{1000 * off:.4f}",
        ]
    name = label or " + ".join(defects) or "none"
    return part, name, order, run.status, *numbers


def alone() -> list[tuple]:
    """Each defect alone in a correct adjustment."""
    rows = [row("alone", (), "photo")]
    for name in (*MOVING[:2], "rho", *MOVING[2:], "pinv of NumPy"):
        orders = ("photo", "point") if name == "rows" else ("photo",)
        rows += [row("alone", (name,), order) for order in orders]
    return [*rows, row("alone", MISCLOSURE, "photo")]


def program() -> list[tuple]:
    """The whole program, and the program without one defect or with another one."""
    rows = [row("program", PROGRAM, order, "all") for order in ("point", "photo")]
    for name in MOVING:
        rest = tuple(other for other in PROGRAM if other != name)
        rows.append(row("program", rest, label=f"all but {name}"))
    other = [n for n in PROGRAM if n != "pinv"]
    rows.append(row("program", (*other, "pinv of NumPy"), label="NumPy's pinv"))
    return [*rows, row("program", (*PROGRAM, "rho"), label="all and rho")]


def repairs() -> list[tuple]:
    """All ways to repair some of the five groups of defects."""
    rows = []
    for n in range(len(GROUPS) + 1):
        for left in combinations(GROUPS, n):
            defects = tuple(name for group in left for name in GROUPS[group])
            label = "repaired: " + (
                ", ".join(group for group in GROUPS if group not in left) or "nothing"
            )
            rows.append(row("repairs", defects, label=label))
    return rows[::-1]


if __name__ == "__main__":
    table = []
    for part in tqdm((alone, program, repairs)):
        table += part()
    study.write("ch06", "defects", COLUMNS, table)
