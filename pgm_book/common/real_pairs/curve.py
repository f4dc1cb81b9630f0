"""Share of wrong matches against the share that is kept, as the quality rises.

``python -m pgm_book.common.real_pairs FOLDER curve`` writes data/results/matching_quality.csv.
"""

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pgm_book.common.real_pairs.choice import grid, picked
from pgm_book.common.real_pairs.pairs import stereo_pairs
from pgm_book.common.real_pairs.rows import Row, errors_and_quality

TABLE = Path(__file__).parents[1] / "results" / "matching_quality.csv"
LIMITS = (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98)
COLUMNS = ("pair", "points", "matches", "least_quality", "kept", "wrong")


def curve(folder: Path) -> Iterator[Row]:
    """Kept and wrong at each limit, for each pair with truth and both choices."""
    lines = []
    for pair in stereo_pairs(folder):
        for how, choose in (("picked", picked), ("grid", grid)):
            points = choose(pair.left, 1600)
            truth = pair.truth(points)
            known = ~np.isnan(truth[:, 0])
            _, error, q = errors_and_quality(pair, points[known], truth[known])
            shares = [
                (np.mean(q >= limit), np.mean(error[q >= limit] > 1))
                for limit in LIMITS
            ]
            lines += [
                (pair.name, how, len(q), limit, f"{kept:.3f}", f"{wrong:.4f}")
                for limit, (kept, wrong) in zip(LIMITS, shares, strict=True)
            ]
            yield (
                "curve: kept/wrong",
                f"{pair.name}, {how}",
                " ".join(f"{kept:.0%}/{wrong:.1%}" for kept, wrong in shares),
            )
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *lines])
