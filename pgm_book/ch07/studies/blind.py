"""What a blind matcher reports, and one that is shown other ground.

``python -m pgm_book.ch07.studies.blind`` writes results/blind.csv
within seconds; tests/ch07/test_studies.py repeats it.

The first draws each shift from the 49 positions of radius 3, all equally likely. The
second compares chips of the satellite image with ground more than 40 px away: a map of
r is smooth, so that its highest value lies on the border far more often.
"""

from collections.abc import Iterator

import numpy as np

from pgm_book.ch07.studies import pairs
from pgm_book.common import study
from pgm_lab import ncc

PAPER = 286  # 50 times 2.391652149^2 of Brahmantara 2015
AWAY = 40.0  # px
COLUMNS = ("quantity", "unit", "value")


def squares() -> np.ndarray:
    """Probability of each squared shift 0 to 18 where all are equally likely."""
    at = np.arange(-pairs.RADIUS, pairs.RADIUS + 1)
    squared = (at**2 + at[:, None] ** 2).ravel()
    return np.bincount(squared) / squared.size


def sums(number: int = pairs.NUMBER) -> np.ndarray:
    """Probability of each sum of squared shifts of so many chips."""
    p = np.ones(1)
    for _ in range(number):
        p = np.convolve(p, squares())
    return p


def other_ground() -> tuple[np.ndarray, np.ndarray]:
    """Whole shifts (n, 2) and r of chips that are shown ground from elsewhere."""
    scene = pairs.scene()
    points = pairs.on_grid(scene, 23)
    start = np.random.default_rng(7).permutation(points)
    far = np.hypot(*(start - points).T) > AWAY
    wide = pairs.CHIP + 2 * pairs.RADIUS
    found = ncc.match(
        *(scene, scene, points[far], start[far], pairs.CHIP, wide, -1.0, 1.0)
    )
    compared = np.isfinite(found.r)
    return (found.points - start[far])[compared], found.r[compared]


def rows() -> Iterator[tuple[str, str, str]]:
    """Rows of the table."""
    p = sums()
    n = np.arange(len(p))
    mean = p @ n
    border = 1 - (5 / 7) ** 2
    yield "uniform: mean of the sum of 50 squares", "px^2", f"{mean:.1f}"
    yield (
        "uniform: its standard deviation",
        "px^2",
        f"{np.sqrt(p @ (n - mean) ** 2):.2f}",
    )
    yield "uniform: RMSE_T of the mean", "px", f"{np.sqrt(mean / pairs.NUMBER):.4f}"
    yield "uniform: probability of 286 or less", "", f"{p[: PAPER + 1].sum():.2e}"
    yield "uniform: share of border peaks", "", f"{border:.4f}"
    d, r = other_ground()
    square = np.sum(d**2, axis=1)
    on_border = np.abs(d).max(axis=1) == pairs.RADIUS
    yield "other ground: chips", "", str(len(r))
    yield "other ground: mean square", "px^2", f"{square.mean():.2f}"
    yield "other ground: RMSE_T", "px", f"{np.sqrt(square.mean()):.3f}"
    yield "other ground: share of border peaks", "", f"{on_border.mean():.3f}"
    yield "other ground: median r", "", f"{np.median(r):.3f}"
    yield "other ground: r of one in a hundred", "", f"{np.quantile(r, 0.99):.3f}"
    yield (
        "other ground: share with r above 0.585041",
        "",
        f"{np.mean(r > 0.585041):.4f}",
    )
    yield "other ground: share with r of 0.8", "", f"{np.mean(r >= 0.8):.4f}"


if __name__ == "__main__":
    study.write("ch07", "blind", COLUMNS, rows())
