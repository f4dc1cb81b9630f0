"""The task of appendix A1: a levelling net in which one reading is wrong."""

from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.program import adjustment
from pgm_book.task import Part, likeliest, named, table
from pgm_lab import plot

SIGMA0 = 0.002  # m, of a line of 1 km
MARKS = "ABCDEFG"
KNOWN = 100.0  # m, the height of A
LIMIT = 3.29  # of |w|
WANTED: dict[str, tuple[str, Any]] = {
    "heights": ("six numbers, for B, C, D, E, F and G, in m", (6,)),
    "sd": ("six numbers, for B, C, D, E, F and G, in mm", (6,)),
    "line": ("two letters such as 'CD'", None),
    "size": ("one number, in mm", ()),
}


@dataclass(frozen=True)
class Truth:
    """The net, its true heights, and the reading that is wrong."""

    lines: list[str]
    km: np.ndarray
    observed: np.ndarray  # m
    heights: np.ndarray  # (7,), true, m
    bad: int
    size: float  # mm

    @property
    def good(self) -> np.ndarray:
        """Which lines are right."""
        return np.arange(len(self.km)) != self.bad

    @property
    def sigma(self) -> np.ndarray:
        """Standard deviations of the readings (m)."""
        return SIGMA0 * np.sqrt(self.km)

    def adjusted(
        self, p: np.ndarray, used: np.ndarray
    ) -> tuple[dict[str, Any], np.ndarray, float]:
        """Heights and their standard deviations from some lines, v, and sigma0."""
        A, observed = _design(self.lines)[used], self.observed[used]
        x, v, sigma0, Q = adjustment.adjust(
            A[:, 1:], p[used], observed - KNOWN * A[:, 0]
        )
        return {"heights": x, "sd": 1000 * SIGMA0 * np.sqrt(np.diag(Q))}, v, sigma0

    def share(self, used: np.ndarray) -> np.ndarray:
        """Redundancy numbers of some lines."""
        A = _design(self.lines)[used, 1:]
        return adjustment.redundancy_numbers(A, 1 / self.km[used])

    def tested(self, used: np.ndarray) -> np.ndarray:
        """Baarda's |w| of some lines."""
        v = self.adjusted(1 / self.km, used)[1]
        return np.abs(v) / (self.sigma[used] * np.sqrt(self.share(used)))

    @property
    def answer(self) -> dict[str, Any]:
        """What an ideal solution hands in."""
        every, p = self.km > 0, 1 / self.km
        v, r = self.adjusted(p, every)[1], self.share(every)
        size = -1000 * float(v[self.bad] / r[self.bad])
        right = self.adjusted(p, self.good)[0]
        return right | {"line": self.lines[self.bad], "size": size}


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """A net of eleven lines; one that is well controlled is wrong by far."""
    while True:
        ring, bad = chance.permutation(list(MARKS)), int(chance.uniform(0, 11))
        pairs = [(ring[k], ring[(k + 1) % 6]) for k in range(6)]
        pairs += [(ring[6], ring[k]) for k in chance.permutation(6)[:5]]
        lines = [a + b if chance.uniform() < 0.5 else b + a for a, b in pairs]
        lines = [lines[k] for k in chance.permutation(11)]
        km = np.round(chance.uniform(0.4, 4, 11), 1)
        heights = np.round(chance.uniform(80, 120, 7), 4)
        heights[0] = KNOWN
        errors = SIGMA0 * np.sqrt(km) * chance.standard_normal(11)
        size = np.rint(chance.choice([-1, 1]) * chance.uniform(30, 70))
        errors[bad] += size / 1000
        observed = np.round(_design(lines) @ heights + errors, 4)
        truth = Truth(lines, km, observed, heights, bad, float(size))
        w = truth.tested(km > 0)
        by_sigma = np.argmax(w * np.sqrt(truth.share(km > 0))) == bad  # it must need r
        # At a mark of two lines both have the same |w|, and neither can be named
        alone = np.delete(w, bad).max() < 0.75 * w[bad]
        found = alone and w[bad] > LIMIT > truth.tested(truth.good).max()
        if found and not by_sigma and _right(truth, truth.answer):
            if not any(_right(truth, one) for one in slips(truth).values()):
                break
    rows = [(*line, dh, far) for line, dh, far in zip(lines, observed, km)]
    head = "from,to,difference_m,length_km"
    return {"net.csv": table(head, "{},{},{:.4f},{:.1f}", rows)}, truth


def _design(lines: list[str]) -> np.ndarray:
    """One row for each line, one column for each mark, the known one too."""
    return np.array(
        [[1.0 * (m == b) - (m == a) for m in MARKS] for a, b in map(tuple, lines)]
    )


def judge(truth: Truth, result: object) -> list[Part]:
    """Return how far heights, their standard deviations and the blunder are off."""
    found, right = _read(result), truth.answer
    A = _design(truth.lines)[truth.good, 1:] / truth.sigma[truth.good, None]
    d = A @ (found["heights"] - truth.heights[1:])  # whatever the covariance
    r = truth.share(truth.km > 0)[truth.bad]
    sd = 1000 * truth.sigma[truth.bad] / np.sqrt(r)
    return [
        Part("heights", float(np.sqrt(d @ d / 6)), 2),
        Part("sd", float(np.abs(found["sd"] - right["sd"]).max()), 0.1, "mm"),
        Part("line", float(set(found["line"]) != set(right["line"])), 0),
        Part("size", abs(found["size"] - truth.size) / sd),
    ]


def _right(truth: Truth, result: object) -> bool:
    return all(part.holds for part in judge(truth, result))


def _read(result: object) -> dict[str, Any]:
    """Return the values of an answer, or say what is wanted."""
    found = named(result, WANTED)
    line = "".join(c for c in str(found["line"]).upper() if c.isalpha())
    if len(line) != 2 or not set(line) <= set(MARKS):
        raise CheckFailed(f"line must be {WANTED['line'][0]}")
    return found | {"line": line}


def slips(truth: Truth) -> dict[str, dict[str, Any]]:
    """Return what the likeliest wrong programs give."""
    every, good, p, right = truth.km > 0, truth.good, 1 / truth.km, truth.answer
    heights, sd, size = right["heights"], right["sd"], right["size"]
    (spoiled, v, _), sigma0 = truth.adjusted(p, every), truth.adjusted(p, good)[2]
    largest = truth.lines[int(np.argmax(np.abs(v)))]
    changes: dict[str, dict[str, Any]] = {
        "The wrong reading is still among those that give the heights.": spoiled,
        "A longer line is less precise: does it get less weight?": (
            truth.adjusted(truth.km, good)[0]
        ),
        "The lines have no weights, though they differ in length.": (
            truth.adjusted(p**0, good)[0]
        ),
        "The heights begin at a known one.": {"heights": heights - KNOWN},
        "The heights are wanted in metres.": {"heights": 1000 * heights},
        "The known height goes to the other side of its equations with a minus.": {
            "heights": heights - 2 * KNOWN
        },
        "The ± must follow from the stated 2 mm, not from the residuals.": {
            "sd": sd * sigma0 / SIGMA0
        },
        "The ± are wanted in millimetres.": {"sd": sd / 1000},
        "The ± of a line of 1 km is missing in those of the heights.": {
            "sd": sd / (1000 * SIGMA0)
        },
        "The largest residual need not be that of the wrong reading.": {
            "line": largest
        },
        "Is the reading too large or too small?": {"size": -size},
        "A residual shows only a share of a blunder.": {"size": -1000 * v[truth.bad]},
        "The size is wanted in millimetres.": {"size": size / 1000},
    }
    return {words: right | change for words, change in changes.items()}


def hint(truth: Truth, result: object) -> str:
    """Return the hint to the first slip that explains what is wrong."""
    found = _read(result)
    wrong = [part.name for part in judge(truth, result) if not part.holds]
    otherwise = f"Look again at {' and '.join(wrong)}. Which readings fit your heights?"
    return likeliest(slips(truth), truth.answer, found, wrong, _same) or otherwise


def _same(key: str, one: Any, other: Any) -> bool:
    """Whether two values agree, numbers to what rounding may change."""
    if key == "line":
        return set(one) == set(other)
    near = {"heights": 1e-4, "sd": 0.02, "size": 0.5}[key]
    return bool(np.all(np.abs(np.subtract(one, other)) < near))


def picture(truth: Truth, result: object) -> tuple[Figure, str]:
    """Draw the net with the wrong line, and the errors of the heights with their ±."""
    found, turn = _read(result), np.pi * np.arange(7) / 3.5
    places = dict(zip(MARKS, np.column_stack([np.sin(turn), np.cos(turn)])))
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2))
    for line in truth.lines:
        colour = plot.RED if set(line) == set(found["line"]) else plot.SKY
        look = {"arrowstyle": "-|>", "color": colour, "linewidth": 3}
        left.annotate("", places[line[1]], places[line[0]], arrowprops=look)
    for mark, place in places.items():
        left.text(*(1.15 * place), mark, weight="bold", ha="center", va="center")
    left.set(aspect="equal", xlim=(-1.4, 1.4), ylim=(-1.4, 1.4))
    left.axis("off")
    off = 1000 * (found["heights"] - truth.heights[1:])
    right.errorbar(range(6), off, found["sd"], fmt="o", capsize=6, linewidth=2)
    right.axhline(0, color=plot.BLACK)
    right.set(xticks=range(6), xticklabels=MARKS[1:], ylabel="height, off (mm)")
    each = zip(MARKS[1:], off, found["sd"])
    errors = ", ".join(f"{m} {e:+.1f} ± {s:.1f}" for m, e, s in each)
    return fig, (
        f"Left, the net, its wrong line {found['line']} in red. Right, how far the"
        f" heights are off, with their standard deviations: {errors} mm."
    )
