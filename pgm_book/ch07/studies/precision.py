"""Predicted and sampled standard deviations of shifts, and the pair without a shift.

``python -m pgm_book.ch07.studies.precision`` writes
results/precision.csv and results/null.csv in a few minutes;
tests/ch07/test_studies.py repeats a part.

Repeated with new noise, a shift scatters (`sampled`) about a mean that need not be the
truth (`bias`, RMS over the chips): an alias, or a bias of the parabola, is the same
each time. `predicted_over_sampled` compares with the scatter alone, and
`predicted_over_rms` with the whole error. These are chips that are accepted in nine of
ten repeats: one in a hundred is refused by chance, as noise pretends a curved surface.

The null pair: two scenes of one pass, each processed by itself. A shift d of the one
makes their grey values differ by -d times the gradient. Solved for d over the whole
overlap, and for a d that changes linearly across it, this is a measurement without
chips: `explained` is the share of the variance of the differences that goes with it.
"""

from collections.abc import Iterator

import numpy as np
import scipy

from pgm_book.ch07.studies import pairs
from pgm_book.common import study
from pgm_lab import datasets, registration, simulate

REPEATS = 60
OFTEN = 0.9  # share of the repeats in which a chip is accepted, at least
CASES = [((2, 1), 4), ((1, 1), 2), ((1, 2), 3)]  # shift in the scene's pixels, factor
COLUMNS = (
    *("blur", "factor", "fraction_x", "fraction_y", "noise", "method", "chips"),
    *("sampled", "predicted", "bias", "predicted_over_sampled", "predicted_over_rms"),
)
NULL = (
    *("what", "chips", "accepted", "mean_x", "mean_y", "spread_x", "spread_y"),
    *("slope_spread_x", "slope_spread_y", "predicted_sd", "explained"),
)


def row(
    blur: float, shift: tuple[int, int], factor: int, noise: float, method: str,
    repeats: int = REPEATS,
) -> tuple:  # fmt: skip
    """Row of the table: one ground, noise drawn anew `repeats` times."""
    clean = simulate.ortho_pair(pairs.scene(), shift, factor, blur=blur)
    ground = clean.reference, pairs.GAIN * clean.sensed
    points = pairs.picked(clean.reference)
    error, variance = [], []
    for seed in range(repeats):
        images = (
            simulate.photograph(grey, noise, [7, seed, k], 16).astype(np.uint16)
            for k, grey in enumerate(ground)
        )
        found = registration.register(*images, points, refine=method)
        # What was not accepted has no variance
        shifts = found.shifts - clean.shift
        shifts[~found.accepted] = np.nan
        error.append(shifts)
        variance.append(np.diagonal(found.covariance, axis1=1, axis2=2))
    of, said = np.array(error), np.array(variance)
    use = np.isfinite(of).all(axis=2).mean(axis=0) >= OFTEN
    of, said = of[:, use], said[:, use]
    sampled = np.sqrt(np.mean(np.nanvar(of, axis=0, ddof=1)))
    bias = np.sqrt(np.mean(np.nanmean(of, axis=0) ** 2))
    predicted, rms = np.sqrt(np.nanmean(said)), np.sqrt(np.nanmean(of**2))
    return (
        *(blur, factor, *(f"{s / factor:.3f}" for s in shift), noise, method),
        *(use.sum(), *(f"{v:.5f}" for v in (sampled, predicted, bias))),
        *(f"{predicted / sampled:.2f}", f"{predicted / rms:.2f}"),
    )


def rows(repeats: int = REPEATS) -> Iterator[tuple]:
    """Rows of the table."""
    for blur in (pairs.BAND_LIMITED, pairs.ALIASED):
        for shift, factor in CASES:
            for noise in (15.0, 60.0):
                for method in ("parabola", "lsm"):
                    yield row(blur, shift, factor, noise, method, repeats)


def null() -> Iterator[tuple]:
    """Rows of the null pair: chips picked and side by side, and without chips."""
    one, other = (scene.grey for scene in datasets.landsat_pair())
    for name, points in (
        ("50 picked", pairs.picked(one)),
        ("side by side", pairs.on_grid(one)),
    ):
        for method in (None, "parabola", "lsm"):
            found = registration.register(one, other, points, refine=method)
            good = found.accepted
            x, y = found.dx[good], found.dy[good]
            sd = np.sqrt(np.mean(found.sd[good] ** 2))
            rest = [without_slope(points[good], d) for d in (x, y)]
            yield (
                *(f"{name}, {method or 'integer'}", len(points), f"{good.mean():.3f}"),
                *(f"{v:.4f}" for v in (x.mean(), y.mean(), x.std(), y.std())),
                *(f"{r:.4f}" for r in rest),
                *(f"{sd:.4f}", ""),
            )
    for degree, name in ((0, "gradients, one shift"), (1, "gradients, with slopes")):
        mean, spread, explained = by_gradients(degree)
        yield (
            *(name, "", ""),
            *(f"{v:.4f}" for v in (*mean, *spread)),
            *("", "", "", f"{explained:.3f}"),
        )


def without_slope(points: np.ndarray, shift: np.ndarray) -> float:
    """Standard deviation of shifts about a plane over the points."""
    A = np.column_stack([np.ones(len(points)), points])
    v = shift - A @ np.linalg.lstsq(A, shift)[0]
    return np.sqrt(v @ v / max(len(v) - 3, 1))


def by_gradients(degree: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean shift of the null pair, how much it varies, and the share explained."""
    one, other = (scene.grey.astype(float) for scene in datasets.landsat_pair())
    inside = (slice(5, -5), slice(5, -5))
    difference = (other - one)[inside].ravel()
    gradient = np.stack([g[inside].ravel() for g in slopes((one + other) / 2)], axis=1)
    y, x = np.indices(one.shape)
    points = np.stack([x[inside].ravel(), y[inside].ravel()], axis=1).astype(float)
    T = np.ones((len(points), 1))
    if degree:
        T = np.hstack([T, (points - points.mean(axis=0)) / 500])
    A = -np.hstack([gradient[:, [k]] * T for k in (0, 1)])
    p = np.linalg.lstsq(A, difference)[0]
    field = np.stack([T @ part for part in np.split(p, 2)])
    left = difference - A @ p
    return field.mean(axis=1), field.std(axis=1), 1 - left.var() / difference.var()


def slopes(grey: np.ndarray) -> list[np.ndarray]:
    """Derivatives by column and row of the cubic spline through the pixels."""
    c = scipy.ndimage.spline_filter(grey, mode="mirror")
    value, slope = np.array([1, 4, 1]) / 6, np.array([-1, 0, 1]) / 2
    return [
        scipy.ndimage.correlate1d(
            scipy.ndimage.correlate1d(c, slope, along, mode="mirror"),
            *(value, 1 - along),
            mode="mirror",
        )
        for along in (1, 0)
    ]


if __name__ == "__main__":
    study.write("ch07", "null", NULL, null())
    study.write("ch07", "precision", COLUMNS, rows())
