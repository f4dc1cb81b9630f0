"""The task of appendix A1: a levelling net in which one reading is wrong."""

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.program import adjustment
from pgm_book.task import Part, named, table
from pgm_lab import plot

SIGMA0 = 0.002  # m, of a line of 1 km
MARKS = "ABCDEFG"  # A is known
WANTED: dict[str, tuple[str, Any]] = {
    "heights": ("six numbers, for B, C, D, E, F and G, in m", (6,)),
    "sd": ("six numbers, for B, C, D, E, F and G, in mm", (6,)),
    "line": ("two letters such as 'CD'", None),
    "size": ("one number, in mm", ()),
}
KEYS = tuple(WANTED)
ROUND = np.radians([90, 30, -30, -90, -150, 150])  # six marks on a ring, one within
LABEL = {"facecolor": "white", "edgecolor": "none", "pad": 2}
SPOTS = np.vstack([np.column_stack([np.cos(ROUND), np.sin(ROUND)]), [(0.0, 0.0)]])


@dataclass(frozen=True)
class Truth:
    """The net, its true heights, and the reading that is wrong."""

    lines: list[str]
    km: np.ndarray
    observed: np.ndarray  # m
    heights: np.ndarray  # (7,), true, m
    bad: int
    size: float  # mm
    places: dict[str, np.ndarray]

    def adjusted(
        self, p: np.ndarray, used: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
        """Adjust some lines with some weights."""
        A = _design(self.lines)
        observed = self.observed - self.heights[0] * A[:, 0]
        return adjustment.adjust(A[used, 1:], p[used], observed[used])

    @property
    def good(self) -> np.ndarray:
        """Which lines are right."""
        return np.arange(len(self.km)) != self.bad

    @property
    def answer(self) -> dict[str, Any]:
        """What an ideal solution hands in."""
        x, _, _, Q = self.adjusted(1 / self.km, self.good)
        sd = 1000 * SIGMA0 * np.sqrt(np.diag(Q))
        return dict(zip(KEYS, (x, sd, self.lines[self.bad], self.estimate)))

    @property
    def estimate(self) -> float:
        """The size of the blunder in mm, as the other lines have it."""
        return -1000 * float(
            self.adjusted(1 / self.km, self.km > 0)[1][self.bad] / self.r
        )

    @property
    def r(self) -> float:
        """Redundancy number of the wrong reading."""
        return _control(self.lines, self.km)[0][self.bad]


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """A net of eleven lines; one that is well controlled is wrong by far."""
    while True:
        order = [MARKS[k] for k in chance.permutation(7)]
        pairs = [(order[k], order[(k + 1) % 6]) for k in range(6)]
        pairs += [(order[6], order[k]) for k in chance.permutation(6)[:5]]
        pairs = [pairs[k] for k in chance.permutation(11)]
        lines = [a + b if chance.uniform() < 0.5 else b + a for a, b in pairs]
        km = np.round(chance.uniform(0.4, 4, 11), 1)
        heights = np.round(chance.uniform(80, 120, 7), 4)
        errors = SIGMA0 * np.sqrt(km) * chance.standard_normal(11)
        w, size = chance.uniform(10, 15), chance.choice([-1, 1])
        r, alike = _control(lines, km)
        # Its w must stand out; without it no other line may be suspected by chance
        usable = np.flatnonzero((r > 0.3) & (alike < 0.75))
        if usable.size:
            bad = int(usable[int(chance.uniform(0, usable.size))])
            size *= round(1000 * w * SIGMA0 * np.sqrt(km[bad] / r[bad]))
            wrong = 1e-3 * size * (np.arange(11) == bad)
            observed = np.round(_design(lines) @ heights + errors + wrong, 4)
            places = dict(zip(order, SPOTS))
            truth = Truth(lines, km, observed, heights, bad, float(size), places)
            if _hidden(truth) and _quiet(truth) and _right(truth, truth.answer):
                if not any(_right(truth, one) for one in slips(truth).values()):
                    break
    rows = [(*line, dh, far) for line, dh, far in zip(lines, observed, km)]
    net = table("from,to,difference_m,length_km", "{},{},{:.4f},{:.1f}", rows)
    known = f"mark,height_m\nA,{heights[0]:.4f}\n"
    return {"net.csv": net, "known.csv": known}, truth


def _design(lines: list[str]) -> np.ndarray:
    """One row for each line, one column for each mark, the known one too."""
    return np.array(
        [[1.0 * (m == b) - (m == a) for m in MARKS] for a, b in map(tuple, lines)]
    )


def _control(lines: list[str], km: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Redundancy numbers, and how much alike the most alike w of another line is."""
    A = _design(lines)[:, 1:] / np.sqrt(km)[:, None]
    R = np.eye(len(km)) - A @ np.linalg.inv(A.T @ A) @ A.T
    r = np.diag(R)
    return r, np.max(np.abs(R / np.sqrt(np.outer(r, r))) - 2 * np.eye(len(km)), axis=1)


def _hidden(truth: Truth) -> bool:
    """Whether others have the largest residual, and the largest v / σ."""
    v = np.abs(truth.adjusted(1 / truth.km, truth.km > 0)[1])
    largest = {int(np.argmax(one)) for one in (v, v / np.sqrt(truth.km))}
    return truth.bad not in largest


def _quiet(truth: Truth) -> bool:
    """Whether no other line is suspected once the wrong one is gone."""
    good = truth.good
    v = truth.adjusted(1 / truth.km, good)[1]
    r, _ = _control(
        [line for line, one in zip(truth.lines, good) if one], truth.km[good]
    )
    return bool(np.all(np.abs(v) < 3 * SIGMA0 * np.sqrt(truth.km[good] * r)))


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far heights, their standard deviations and the blunder are off."""
    found, right = _read(result), truth.answer
    N = np.linalg.inv(truth.adjusted(1 / truth.km, truth.good)[3])
    d = (found["heights"] - truth.heights[1:]) / SIGMA0
    sd = 1000 * SIGMA0 * np.sqrt(truth.km[truth.bad] / truth.r)
    return [
        Part("heights", float(np.sqrt(d @ N @ d / len(d))), 2),
        Part("sd", float(np.abs(found["sd"] - right["sd"]).max()), 0.1, "mm"),
        Part("line", float(set(found["line"]) != set(right["line"])), 0),
        Part("size", abs(found["size"] - truth.size) / sd),
    ]


def _right(truth: Truth, result: object) -> bool:
    return all(part.holds for part in judge(truth, result))


def _read(result: object) -> dict[str, Any]:
    """Return the values of an answer, or say what is wanted."""
    if isinstance(result, dict):
        result = {
            key: [one.get(mark) for mark in MARKS[1:]] if isinstance(one, dict) else one
            for key, one in result.items()
        }
    found = named(result, WANTED)
    line = "".join(c for c in str(found["line"]).upper() if c.isalpha())
    if len(line) != 2 or not set(line) <= set(MARKS):
        raise CheckFailed(f"line must be {WANTED['line'][0]}")
    return found | {"line": line}


def slips(truth: Truth) -> dict[str, dict[str, Any]]:
    """Return what the likeliest wrong programs give."""
    every, p, right = truth.km > 0, 1 / truth.km, truth.answer

    def solved(p: np.ndarray, used: np.ndarray) -> dict[str, Any]:
        x, _, _, Q = truth.adjusted(p, used)
        return {"heights": x, "sd": 1000 * SIGMA0 * np.sqrt(np.diag(Q))}

    sigma0, v = truth.adjusted(p, truth.good)[2], truth.adjusted(p, every)[1]
    changes = {
        "The wrong reading is still among those that give the heights.": solved(
            p, every
        ),
        "A longer line is less precise: does it get less weight?": solved(
            truth.km, truth.good
        ),
        "The lines have no weights, though they differ in length.": solved(
            p**0, truth.good
        ),
        "The heights begin at a known one.": {
            "heights": right["heights"] - truth.heights[0]
        },
        "The known height goes to the other side of its equations with a minus.": {
            "heights": right["heights"] - 2 * truth.heights[0]
        },
        "The ± must follow from the stated 2 mm, not from the residuals.": {
            "sd": right["sd"] * sigma0 / SIGMA0
        },
        "The ± are those of all eleven readings, and one is gone.": {
            "sd": solved(p, every)["sd"]
        },
        "The ± are wanted in millimetres.": {"sd": right["sd"] / 1000},
        "The ± of a line of 1 km is missing in those of the heights.": {
            "sd": right["sd"] / (1000 * SIGMA0)
        },
        "The largest residual need not be that of the wrong reading.": {
            "line": truth.lines[int(np.argmax(np.abs(v)))]
        },
        "Is the reading too large or too small?": {"size": -right["size"]},
        "A residual shows only a share of a blunder.": {"size": -1000 * v[truth.bad]},
        "The size is wanted in millimetres.": {"size": right["size"] / 1000},
    }
    return {words: right | change for words, change in changes.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first slip that explains what is wrong."""
    found, right = _read(result), truth.answer
    wrong = [part.name for part in judge(truth, result) if not part.holds]
    for words, slip in slips(truth).items():
        changed = [k for k in KEYS if not _same(k, slip, right)]
        if set(changed) & set(wrong) and all(_same(k, found, slip) for k in changed):
            return words
    return f"Look again at {' and '.join(wrong)}. Which readings fit your heights?"


def _same(key: str, one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether two answers agree in a value, numbers to what rounding may change."""
    if key == "line":
        return set(one[key]) == set(other[key])
    near = {"heights": 1e-4, "sd": 0.02, "size": 0.5}[key]
    return bool(np.all(np.abs(np.subtract(one[key], other[key])) < near))


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the net with the wrong line, and the errors of the heights with their ±."""
    found = _read(result)
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2))
    for line in truth.lines:
        a, b = (truth.places[mark] for mark in line)
        wrong = set(line) == set(found["line"])
        look = {"arrowstyle": "-|>", "color": plot.RED if wrong else plot.SKY}
        left.annotate("", b, a, arrowprops=look | {"linewidth": 3})
        if wrong:
            words = f"{found['size']:+.0f} mm".replace("-", "−")
            left.text(*((a + b) / 2), words, ha="center", bbox=LABEL)
    for mark, place in truth.places.items():
        left.plot(*place, "^" if mark == "A" else "o", color=plot.BLACK, markersize=12)
        at = 1.24 * place if place.any() else np.array([0.17, 0.3])
        left.text(*at, mark, weight="bold", ha="center", va="center")
    left.set(aspect="equal", xlim=(-1.4, 1.4), ylim=(-1.4, 1.4))
    left.axis("off")
    off = 1000 * (found["heights"] - truth.heights[1:])
    right.errorbar(range(6), off, found["sd"], fmt="o", capsize=6, linewidth=2)
    right.axhline(0, color=plot.BLACK)
    right.set(xticks=range(6), xticklabels=MARKS[1:], ylabel="height, off (mm)")
    each = ", ".join(
        f"{m} {e:+.1f} ± {s:.1f}" for m, e, s in zip(MARKS[1:], off, found["sd"])
    )
    return fig, (
        f"Left, the net, its wrong line {found['line']} in red. Right, how far the"
        f" heights are off, with their standard deviations: {each} mm."
    )
