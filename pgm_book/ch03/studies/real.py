"""Least squares matching of real images whose shift is known.

``python -m pgm_book.ch03.studies.real`` writes results/real.csv within a minute;
tests/ch03/test_studies.py repeats a part.

The orthophoto is cut twice, shifted by whole pixels, and averaged down by 2 or 4. The
means hold detail too fine for the new pixels, an alias that does not move with the
ground: the model of the adjustment does not contain it, and iterations converge more
slowly. Therefore two tolerances, the usual one and one that leaves nothing.

Landsat: the same ground in two scenes of one pass, where the shift is zero.
"""

from collections.abc import Iterator

import numpy as np

from pgm_book.ch03.studies import scene as lsm_scene
from pgm_book.common import study
from pgm_lab import datasets, lsm, simulate

SHIFTS = {
    2: [(0, 1), (1, 0), (1, 1), (7, -3)],
    4: [(0, 1), (1, 0), (1, 1), (2, 2), (2, 1), (1, 3), (-9, 6)],
}
WINDOWS = (11, 21, 31)
TOLERANCES = (0.02, 0.001)  # px; the first is that of lsm.match
FALSE = 0.5  # px
COLUMNS = (
    *("image", "factor", "shift_x", "shift_y", "window", "tolerance"),
    *("points", "converged", "false", "mean_x", "mean_y", "sd", "rms", "median_error"),
    *("median_predicted_sd", "rms_z", "median_z", "median_sigma0"),
)


def shrunk(
    factor: int, shift: tuple[int, int], windows: tuple[int, ...] = WINDOWS
) -> Iterator[tuple]:
    """Rows of the table for one shift of the orthophoto."""
    pair = simulate.shrunk_pair(datasets.yellowstone().grey, shift, factor)
    return rows("orthophoto", factor, pair, np.array(shift) / factor, windows)


def landsat(windows: tuple[int, ...] = WINDOWS) -> Iterator[tuple]:
    """Rows of the table for the pair of satellite images."""
    pair = tuple(scene.grey for scene in datasets.landsat_pair())
    return rows("Landsat", 1, pair, np.zeros(2), windows)


def rows(
    name: str, factor: int, pair: tuple, truth: np.ndarray, windows: tuple[int, ...]
) -> Iterator[tuple]:
    """Rows of the table for a pair of images, by window and tolerance."""
    for window in windows:
        for tolerance in TOLERANCES:
            numbers = summary(*pair, truth, window, tolerance)
            yield (name, factor, *truth, window, tolerance, *numbers)


def summary(
    left: np.ndarray,
    right: np.ndarray,
    shift: np.ndarray,
    window: int,
    tolerance: float,
) -> tuple:
    """Numbers of a row: windows side by side, starts rounded to whole pixels."""
    margin = window // 2 + 12
    columns, rows = (
        np.arange(margin, n - margin, window + 1.0) for n in left.shape[::-1]
    )
    points = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    truth = points + shift
    found = lsm.match(
        left,
        right,
        points,
        np.rint(truth),
        window,
        tolerance=tolerance,
        max_iterations=50,
    )
    error = found.points - truth
    far = np.hypot(*error.T) > FALSE
    good = found.accepted & ~far
    error, C = error[good], found.covariance[good]
    z2 = lsm_scene.squared(error, C)
    sd = np.sqrt(np.diagonal(C, axis1=1, axis2=2))
    return (
        *(len(points), f"{found.accepted.mean():.4f}"),
        f"{np.mean(found.accepted & far):.4f}",
        *(f"{mean:.4f}" for mean in error.mean(axis=0)),
        f"{np.sqrt(np.mean(error.var(axis=0))):.4f}",
        f"{np.sqrt(np.mean(error**2)):.4f}",
        f"{np.median(np.abs(error)):.4f}",
        f"{np.median(sd):.4f}",
        f"{np.sqrt(np.mean(z2)):.2f}",
        f"{np.sqrt(np.median(z2)):.2f}",
        f"{np.median(found.sigma0[good]):.2f}",
    )


if __name__ == "__main__":
    table = [
        row
        for factor, shifts in SHIFTS.items()
        for shift in shifts
        for row in shrunk(factor, shift)
    ]
    study.write("ch03", "real", COLUMNS, [*table, *landsat()])
