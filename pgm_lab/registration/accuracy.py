"""Shifts summed up: RMSE, circular error, and what a few blunders cannot change."""

from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate

ROBUST_SD = 1.4826  # sd of a normal distribution over its median absolute deviation
CIRCULAR_SD = 1.1774  # median of the radius over the sd of a coordinate


@dataclass(frozen=True)
class Accuracy:
    """What n shifts say about two images, in the unit of the shifts.

    Attributes
    ----------
    n : int
        Number of shifts.
    mean_x, mean_y : float
        Mean shift.
    rmse_x, rmse_y, rmse_t : float
        Root mean squares of the shifts, and of both together (Br 2-4).
    ce90 : float
        Circular error: nine tenths of the shifts are not longer.
    median_x, median_y : float
        Median shift, which a few blunders hardly move.
    spread_x, spread_y : float
        Robust standard deviation about the median: 1.4826 times the median absolute
        deviation.
    """

    n: int
    mean_x: float
    mean_y: float
    rmse_x: float
    rmse_y: float
    rmse_t: float
    ce90: float
    median_x: float
    median_y: float
    spread_x: float
    spread_y: float

    def times(self, pixel_size: float) -> Self:
        """Return the same in metres, from pixels of this size in metres."""
        size = _validate.positive_number(pixel_size, "pixel_size", "m")
        names = [f.name for f in fields(self) if f.name != "n"]
        return replace(self, **{name: getattr(self, name) * size for name in names})


def accuracy(dx: ArrayLike, dy: ArrayLike) -> Accuracy:
    """Sum up shifts by their means, root mean squares and quantiles (Br 2-4)."""
    dx, dy = _validate.finite(dx, "dx"), _validate.finite(dy, "dy")
    if dx.ndim != 1 or dx.shape != dy.shape or not len(dx):
        raise ValueError(
            "dx and dy must be two lists of the same length, with at least one shift;"
            f" got shapes {dx.shape} and {dy.shape}"
        )
    x, y = np.median(dx), np.median(dy)
    rmse_x, rmse_y = np.sqrt(np.mean(dx**2)), np.sqrt(np.mean(dy**2))
    return Accuracy(
        len(dx),
        *map(
            float,
            (dx.mean(), dy.mean(), rmse_x, rmse_y, np.hypot(rmse_x, rmse_y),
             np.quantile(np.hypot(dx, dy), 0.9), x, y,
             ROBUST_SD * np.median(np.abs(dx - x)),
             ROBUST_SD * np.median(np.abs(dy - y))),
        ),
    )  # fmt: skip
