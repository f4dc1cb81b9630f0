"""Whether a measure with a larger standard deviation over the search is safer.

``python -m pgm_book.ch07.studies.spread`` writes results/spread.csv
within a minute; tests/ch07/test_studies.py repeats a part.

Chips 21 x 21 side by side, radius 3, a shift of whole pixels: a match is right when the
highest of the 49 values stands at the shift. Pearson's r beside the sum of products
over the norms with the means left in, least differences and their absolute values, the
correlation of ranks and of phases; and beside increasing functions of r, of 49 values
of which the highest stays the highest, whatever becomes of their standard deviation.

`spread` is the mean over the chips of the standard deviation of the 49 values. `area`
asks whether the standard deviation of a chip's own 49 values tells a right match from a
wrong one (0.5: nothing, 1: all), `area_highest` the same of the highest value.
"""

from collections.abc import Callable, Iterator

import numpy as np
import scipy

from pgm_book.ch07.studies import pairs
from pgm_book.common import study

FACTOR, SHIFT = 2, (2, -4)  # 1 px and -2 px
CONDITIONS: dict[str, dict[str, float]] = {
    "noise 15, gain 1": {"gain": 1.0},
    "gain 0.9": {},
    "gain 0.9, offset 700": {"offset": 700.0},
    "noise 400": {"gain": 1.0, "sigma": 400.0},
    "haze": {"haze": 0.6},
    "changed fields": {"changed": 0.4},
    "all of these": {"haze": 0.6, "sigma": 100.0, "changed": 0.4},
}
COLUMNS = (
    *("condition", "measure", "chips", "right", "spread"),
    *("area", "area_highest"),
)


def pearson(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(Br 1) of chips x (..., 441) and y (..., 441)."""
    return products(x - x.mean(axis=-1, keepdims=True), y - y.mean(-1, keepdims=True))


def products(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Sum of products over the two norms: the means are left in."""
    return np.sum(x * y, -1) / np.sqrt(np.sum(x**2, -1) * np.sum(y**2, -1))


def squares(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Sum of squared differences, with the sign reversed: the highest is best."""
    return -np.sum((x - y) ** 2, -1)


def differences(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Sum of absolute differences, likewise."""
    return -np.sum(np.abs(x - y), -1)


def ranks(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Pearson's r of the ranks of the grey values (Spearman)."""
    return pearson(scipy.stats.rankdata(x, axis=-1), scipy.stats.rankdata(y, axis=-1))


MEASURES: dict[str, Callable] = {
    "Pearson r": pearson,
    "means left in": products,
    "squared differences": squares,
    "absolute differences": differences,
    "rank correlation": ranks,
    "r^3": lambda x, y: pearson(x, y) ** 3,
    "arctanh r": lambda x, y: np.arctanh(pearson(x, y)),
    "r / 10": lambda x, y: pearson(x, y) / 10,
}


def phases(x: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Correlation of the phases of a chip with the window at the start (7, 7)."""
    middle = windows[pairs.RADIUS, pairs.RADIUS].reshape(pairs.CHIP, pairs.CHIP)
    soft = np.outer(np.hanning(pairs.CHIP), np.hanning(pairs.CHIP))
    one, other = (
        np.fft.fft2((g - g.mean()) * soft) for g in (x.reshape(middle.shape), middle)
    )
    cross = other * np.conj(one)
    found = np.fft.ifft2(cross / np.maximum(np.abs(cross), 1e-12)).real
    at = np.arange(-pairs.RADIUS, pairs.RADIUS + 1)
    return found[np.ix_(at, at)]


def maps(condition: str, step: int = pairs.CHIP) -> dict[str, np.ndarray]:
    """Maps (n, 7, 7) of each measure for the chips of one condition."""
    pair = pairs.pair(SHIFT, FACTOR, pairs.ALIASED, seed=2, **CONDITIONS[condition])
    found: dict[str, list] = {name: [] for name in (*MEASURES, "phase correlation")}
    half, wide = pairs.CHIP // 2, pairs.CHIP // 2 + pairs.RADIUS
    for c, r in pairs.on_grid(pair.reference, step).astype(int):
        x = pair.reference[r - half : r + half + 1, c - half : c + half + 1]
        area = pair.sensed[r - wide : r + wide + 1, c - wide : c + wide + 1]
        windows = np.lib.stride_tricks.sliding_window_view(area, x.shape)
        x = x.reshape(-1).astype(float)
        windows = windows.reshape(7, 7, -1).astype(float)
        for name, measure in MEASURES.items():
            found[name].append(measure(x, windows))
        found["phase correlation"].append(phases(x, windows))
    return {name: np.stack(values) for name, values in found.items()}


def rows(condition: str, step: int = pairs.CHIP) -> Iterator[tuple]:
    """Rows of the table for one condition."""
    shift = np.array(SHIFT) // FACTOR
    for name, found in maps(condition, step).items():
        values = found.reshape(len(found), -1)
        y, x = np.divmod(values.argmax(axis=1), 2 * pairs.RADIUS + 1)
        right = (x - pairs.RADIUS == shift[0]) & (y - pairs.RADIUS == shift[1])
        yield (
            *(condition, name, len(values), f"{right.mean():.4f}"),
            *(f"{values.std(axis=1).mean():.4g}", area(values.std(axis=1), right)),
            area(values.max(axis=1), right),
        )


def area(score: np.ndarray, right: np.ndarray) -> str:
    """Probability that a right match has a higher score than a wrong one."""
    n, m = np.sum(right), np.sum(~right)
    if not n or not m:
        return ""
    ranks = scipy.stats.rankdata(score)[right].sum()
    return f"{(ranks - n * (n + 1) / 2) / (n * m):.3f}"


if __name__ == "__main__":
    study.write("ch07", "spread", COLUMNS, (row for c in CONDITIONS for row in rows(c)))
