"""The task of appendix A1: a levelling net in which one reading is wrong."""

from dataclasses import dataclass, replace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_book.common.checks import CheckFailed
from pgm_book.program.adjustment import adjust, redundancy_numbers
from pgm_book.task import Answer, Part, likeliest, named, table
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
    """The right answer, the net, and the reading that is wrong."""

    answer: Answer
    lines: list[str]
    A: np.ndarray  # (11, 6)
    observed: np.ndarray  # m, from or to the known height
    p: np.ndarray  # weights of the lines
    bad: int

    @property
    def good(self) -> np.ndarray:
        """Which lines are right."""
        return np.arange(len(self.lines)) != self.bad

    @property
    def sigma(self) -> np.ndarray:
        """Standard deviations of the readings (m)."""
        return SIGMA0 / np.sqrt(self.p)

    def adjusted(
        self, p: np.ndarray, used: np.ndarray
    ) -> tuple[Answer, np.ndarray, float]:
        """Heights and their standard deviations from some lines, v, and sigma0."""
        x, v, sigma0, Q = adjust(self.A[used], p[used], self.observed[used])
        return {"heights": x, "sd": 1000 * SIGMA0 * np.sqrt(np.diag(Q))}, v, sigma0

    def tested(self, used: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals of some lines, their redundancy numbers, and Baarda's |w|."""
        v = self.adjusted(self.p, used)[1]
        r = redundancy_numbers(self.A[used], self.p[used])
        return v, r, np.abs(v) / (self.sigma[used] * np.sqrt(r))


def make(chance: np.random.RandomState) -> tuple[dict[str, str], Truth]:
    """A net of eleven lines; one that is well controlled is wrong by far."""
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
    # One row for each line, one column for each mark, the known one too
    A = np.array([[1.0 * (m == b) - (m == a) for m in MARKS] for a, b in lines])
    observed = np.round(A @ heights + errors, 4)
    truth = Truth({}, lines, A[:, 1:], observed - KNOWN * A[:, 0], 1 / km, bad)
    found = truth.adjusted(truth.p, truth.good)[0]
    answer = found | {"heights": heights[1:], "line": lines[bad], "size": float(size)}
    truth = replace(truth, answer=answer)

    v, r, w = truth.tested(truth.p > 0)
    found |= {"size": -1000 * v[bad] / r[bad]}
    # At a mark of two lines both have the same |w|, and neither can be named
    alone = np.delete(w, bad).max() < 0.75 * w[bad]
    clear = alone and w[bad] > LIMIT > truth.tested(truth.good)[2].max()
    simple = np.argmax(w * np.sqrt(r)) == bad  # it must need r
    passing = [_right(truth, one) for one in slips(truth).values()]
    if simple or not clear or not _right(truth, found) or any(passing):
        return make(chance)
    rows = [(*line, dh, far) for line, dh, far in zip(lines, observed, km)]
    head = "from,to,difference_m,length_km"
    return {"net.csv": table(head, "{},{},{:.4f},{:.1f}", rows)}, truth


def read(result: object) -> Answer:
    """Return the values of an answer, or say what is wanted."""
    found = named(result, WANTED)
    line = "".join(c for c in str(found["line"]).upper() if c.isalpha())
    if len(line) != 2 or not set(line) <= set(MARKS):
        raise CheckFailed(f"line must be {WANTED['line'][0]}")
    return found | {"line": line}


def judge(truth: Truth, found: Answer) -> list[Part]:
    """Return how far heights, their standard deviations and the blunder are off."""
    right, bad = truth.answer, truth.bad
    A = truth.A[truth.good] / truth.sigma[truth.good, None]
    d = A @ (found["heights"] - right["heights"])  # whatever the covariance
    r = redundancy_numbers(truth.A, truth.p)[bad]
    sd = 1000 * truth.sigma[bad] / np.sqrt(r)
    return [
        Part("heights", float(np.sqrt(d @ d / 6)), 2),
        Part("sd", float(np.abs(found["sd"] - right["sd"]).max()), 0.1, "mm"),
        Part("line", float(set(found["line"]) != set(right["line"])), 0),
        Part("size", abs(found["size"] - right["size"]) / sd),
    ]


def _right(truth: Truth, values: Answer) -> bool:
    """Whether an answer with these values passes."""
    return all(part.holds for part in judge(truth, truth.answer | values))


def slips(truth: Truth) -> dict[str, Answer]:
    """Return what the likeliest wrong programs give."""
    good, p, size = truth.good, truth.p, truth.answer["size"]
    spoiled, v, _ = truth.adjusted(p, p > 0)
    ideal, _, sigma0 = truth.adjusted(p, good)
    heights, sd = ideal.values()
    return {
        "The wrong reading is still among those that give the heights.": spoiled,
        "A longer line is less precise: does it get less weight?": (
            truth.adjusted(1 / p, good)[0]
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
            "line": truth.lines[np.argmax(np.abs(v))]
        },
        "Is the reading too large or too small?": {"size": -size},
        "A residual shows only a share of a blunder.": {"size": -1000 * v[truth.bad]},
        "The size is wanted in millimetres.": {"size": size / 1000},
    }


def hint(truth: Truth, found: Answer, wrong: list[str]) -> str:
    """Return the hint to the slip that explains a part, or to all that is wrong."""
    otherwise = f"Look again at {' and '.join(wrong)}. Which readings fit your heights?"
    return likeliest(judge, truth, found, wrong, slips(truth)) or otherwise


def picture(truth: Truth, found: Answer) -> tuple[Figure, str]:
    """Draw the net with the wrong line, and the errors of the heights with their ±."""
    turn = np.pi * np.arange(7) / 3.5
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
    off = 1000 * (found["heights"] - truth.answer["heights"])
    right.errorbar(range(6), off, found["sd"], fmt="o", capsize=6, linewidth=2)
    right.axhline(0, color=plot.BLACK)
    right.set(xticks=range(6), xticklabels=MARKS[1:], ylabel="height, off (mm)")
    each = zip(MARKS[1:], off, found["sd"])
    errors = ", ".join(f"{m} {e:+.1f} ± {s:.1f}" for m, e, s in each)
    return fig, (
        f"Left, the net, its wrong line {found['line']} in red. Right, how far the"
        f" heights are off, with their standard deviations: {errors} mm."
    )
