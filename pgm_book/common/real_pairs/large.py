"""The row of the table about large photos: time and memory by points, not by pixels."""

import time
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pgm_book.common.real_pairs.rows import Row
from pgm_lab import datasets, lsm

SIZE, POINTS, BESIDE = 8000, 50, 64
REPEAT = 3


def large(folder: Path) -> Iterator[Row]:
    """50 points in 8000 x 8000 pixels, beside cutting the windows by hand."""
    grey = datasets.yellowstone().grey
    times = [-(-SIZE // n) for n in grey.shape]
    left = np.tile(grey, times)[:SIZE, :SIZE]
    right = np.roll(left, (2, -3), axis=(0, 1))
    rng = np.random.default_rng(1)
    points = rng.integers(100, SIZE - 100, (POINTS, 2)).astype(float)

    def whole() -> np.ndarray:
        return lsm.match(left, right, points, points + (-2, 1)).points

    def by_hand() -> np.ndarray:
        found = []
        for point in points:
            x, y = point.astype(int) - BESIDE
            part = np.s_[y : y + 2 * BESIDE + 1, x : x + 2 * BESIDE + 1]
            middle = np.full((1, 2), float(BESIDE))
            match = lsm.match(left[part], right[part], middle, middle + (-2, 1))
            found.append(match.points[0] + (x, y))
        return np.array(found)

    seconds, answers = zip(*(_timed(way) for way in (whole, by_hand)), strict=True)
    same = np.nanmax(np.abs(answers[0] - answers[1]))
    tracemalloc.start()
    whole()
    peak = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    ratio = seconds[0] / seconds[1]
    yield (
        "large photos",
        f"{SIZE} x {SIZE}, {POINTS} points",
        f"{seconds[0] * 1e3:.0f} ms, by hand {seconds[1] * 1e3:.0f} ms: ratio"
        f" {ratio:.2f}; {peak:.0f} MB; answers differ by {same:.1g} px",
    )


def _timed(way) -> tuple[float, np.ndarray]:
    """Return the best time of some, and the answer."""
    best = np.inf
    for _ in range(REPEAT):
        start = time.perf_counter()
        answer = way()
        best = min(best, time.perf_counter() - start)
    return best, answer
