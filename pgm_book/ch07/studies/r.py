"""Whether r is accuracy: chips accepted by r and by other tests, right and wrong.

``python -m pgm_book.ch07.studies.r`` writes results/tests.csv,
results/r_and_error.csv and results/beyond.csv within a minute;
tests/ch07/test_studies.py repeats a part.

Chips 21 x 21 side by side, radius 3, refined by a parabola. A chip is wrong by more
than 1 px, in column or row. Tests: r at least, the second peak over the first at most,
the predicted standard deviation at most, no peak on the border of the search, and what
`register` makes of them all. The area under the curve (receiver operating
characteristic) is the probability that a test puts a right chip above a wrong one: 0.5
tells nothing, 1 all. Nothing is tested that `ncc.match` cannot predict: such chips
count as failed.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from pgm_book.ch07.studies import pairs
from pgm_book.common import study
from pgm_lab import ncc, registration, simulate

WRONG = 1.0  # px
FACTOR, INSIDE, BEYOND = 2, (3, -1), (9, 1)  # 1.5 px and -0.5 px; 4.5 px and 0.5 px
SEVERE = {"haze": 0.6, "sigma": 100.0, "changed": 0.4}
CONDITIONS = {
    "noise 15": ("Landsat", INSIDE, pairs.ALIASED, {}),
    "noise 150": ("Landsat", INSIDE, pairs.ALIASED, {"sigma": 150.0}),
    "haze": ("Landsat", INSIDE, pairs.ALIASED, {"haze": 0.6}),
    "changed fields": ("Landsat", INSIDE, pairs.ALIASED, {"changed": 0.4}),
    "all of these": ("Landsat", INSIDE, pairs.ALIASED, SEVERE),
    "all, band-limited": ("Landsat", INSIDE, pairs.BAND_LIMITED, SEVERE),
    "beyond the radius": ("Landsat", BEYOND, pairs.ALIASED, {}),
    "beyond, band-limited": ("Landsat", BEYOND, pairs.BAND_LIMITED, {}),
    "canals": ("canals", INSIDE, pairs.BAND_LIMITED, {}),
    "plantation": ("plantation", (2, -2), pairs.BAND_LIMITED, {}),
}
TESTS = {
    "r": (0.6, 0.7, 0.8, 0.9, 0.95),
    "second peak": (0.5, 0.7, 0.8, 0.9, 0.95),
    "predicted sd": (0.02, 0.05, 0.1, 0.2),
    "border": (),
    "status": (),
}
COLUMNS = (
    *("condition", "chips", "wrong", "test", "limit"),
    *("wrong_accepted", "right_accepted", "wrong_of_accepted", "area"),
)
CORRELATIONS = (
    *("condition", "which", "chips", "median_r", "median_shift", "median_error"),
    *("rank_r_shift", "rank_r_error"),
)

FAR = (
    *("blur", "shift_x", "which", "chips", "r_07", "r_08", "r_09"),
    *("border", "accepted"),
)


@dataclass(frozen=True)
class Chips:
    """What is known of chips: the tests, the error in px, and the status."""

    r: np.ndarray
    second: np.ndarray
    sd: np.ndarray
    border: np.ndarray
    status: np.ndarray
    shift: np.ndarray
    error: np.ndarray

    @property
    def wrong(self) -> np.ndarray:
        """Whether a chip is wrong."""
        return self.error > WRONG


def ground(kind: str) -> np.ndarray:
    """Scene: as it is, or a fiftieth of its contrast under canals or rows of trees."""
    scene = pairs.scene().astype(float)
    if kind == "Landsat":
        return scene
    y, x = np.indices(scene.shape)
    weak = 7000 + 0.02 * (scene - scene.mean())
    if kind == "canals":  # along 1 : 2, at random distances
        profile = simulate.photograph(np.zeros(4000), 800.0, seed=7)
        return weak + profile[(x + 2 * y) // 8]
    period = 3.0 * FACTOR
    return weak + 400 * (
        np.cos(2 * np.pi * x / period) + np.cos(2 * np.pi * y / period)
    )


def chips(condition: str, step: int = 21, seed: int = 1) -> Chips:
    """Match the chips of one condition."""
    kind, shift, blur, change = CONDITIONS[condition]
    how = {"gain": pairs.GAIN, "sigma": pairs.NOISE, **change}
    pair = simulate.ortho_pair(
        ground(kind), shift, FACTOR, blur=blur, dtype=np.uint16, seed=seed, **how
    )
    points = pairs.on_grid(pair.reference, step)
    images = pair.reference, pair.sensed
    raw = ncc.match(
        *(*images, points, None, pairs.CHIP, pairs.CHIP + 2 * pairs.RADIUS, -1.0, 1.0),
        refine="parabola",
    )
    judged = registration.register(*images, points, refine="parabola")
    found = np.isfinite(raw.r)
    shifts = (raw.points - points)[found]
    return Chips(
        raw.r[found],
        (raw.second / raw.r)[found],
        np.sqrt(np.trace(raw.covariance, axis1=1, axis2=2) / 2)[found],
        (raw.status == "peak on the border of the search")[found],
        judged.status[found],
        np.hypot(*shifts.T),
        np.abs(shifts - pair.shift).max(axis=1),
    )


def passes(c: Chips, test: str, limit: float | None) -> np.ndarray:
    """Whether chips pass a test."""
    if test == "r":
        return c.r >= limit
    if test == "second peak":
        return c.second <= limit
    if test == "predicted sd":
        return c.sd <= limit
    return ~c.border if test == "border" else c.status == "accepted"


def area(c: Chips, test: str) -> float:
    """Area under the curve of a test (Mann and Whitney)."""
    score = {
        "r": c.r,
        "second peak": -c.second,
        "predicted sd": -c.sd,
        "border": ~c.border,
        "status": c.status == "accepted",
    }[test].astype(float)
    rank = scipy.stats.rankdata(np.where(np.isfinite(score), score, -np.inf))
    right, wrong = np.sum(~c.wrong), np.sum(c.wrong)
    if not right or not wrong:
        return np.nan
    return (rank[~c.wrong].sum() - right * (right + 1) / 2) / (right * wrong)


def rows(condition: str) -> Iterator[tuple]:
    """Rows of the table of tests for one condition."""
    c = chips(condition)
    for test, limits in TESTS.items():
        for limit in limits or (None,):
            good = passes(c, test, limit)
            yield (
                *(condition, len(c.r), share(c.wrong, c.r >= -1), test, limit or ""),
                *(share(good, c.wrong), share(good, ~c.wrong), share(c.wrong, good)),
                number(area(c, test)),
            )


def correlations(condition: str) -> Iterator[tuple]:
    """Rows of the second table: whether r goes with the shift, or with the error."""
    c = chips(condition)
    for which, k in (("right", ~c.wrong), ("all", np.ones(len(c.r), bool))):
        if k.any():
            medians = (np.median(v[k]) for v in (c.r, c.shift, c.error))
            ranks = (
                scipy.stats.spearmanr(c.r[k], v[k]).statistic
                for v in (c.shift, c.error)
            )
            yield (condition, which, k.sum(), *map(number, (*medians, *ranks)))


def beyond() -> Iterator[tuple]:
    """Rows of the third table: shifts that the radius does not reach."""
    for blur in (pairs.ALIASED, pairs.BAND_LIMITED, 1.2):
        for shift in (7, 8, 9, 10, 12):
            pair = pairs.pair((shift, 1), FACTOR, blur, seed=1)
            for kind, choose in (("side by side", pairs.on_grid), ("picked", most)):
                points = choose(pair.reference)
                found = registration.register(
                    pair.reference, pair.sensed, points, refine="parabola"
                )
                r = found.r[np.isfinite(found.r)]
                border = found.status == "peak on the border of the search"
                yield (
                    *(blur, f"{shift / FACTOR:.1f}", kind, len(r)),
                    *(f"{np.mean(r >= limit):.3f}" for limit in (0.7, 0.8, 0.9)),
                    *(f"{np.mean(border):.3f}", f"{found.accepted.mean():.3f}"),
                )


def most(reference: np.ndarray) -> np.ndarray:
    """Two hundred chips on crossings."""
    return pairs.picked(reference, 200)


def share(these: np.ndarray, of: np.ndarray) -> str:
    """Share of `these` among `of`; empty if there are none."""
    return f"{np.mean(these[of]):.4f}" if of.any() else ""


def number(value: float) -> str:
    """Three digits; empty if there is none."""
    return f"{value:.3f}" if np.isfinite(value) else ""


if __name__ == "__main__":
    study.write("ch07", "tests", COLUMNS, (row for c in CONDITIONS for row in rows(c)))
    both = (row for c in CONDITIONS for row in correlations(c))
    study.write("ch07", "r_and_error", CORRELATIONS, both)
    study.write("ch07", "beyond", FAR, beyond())
