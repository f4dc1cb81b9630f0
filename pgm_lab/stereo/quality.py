"""How good heights are, compared with the truth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Quality:
    """Errors of heights: their number, mean, RMSE, NMAD, and share of cells with one.

    NMAD is 1.4826 times the median of the distances from the median: for normal errors
    the standard deviation, and blunders hardly change it.
    """

    n: int
    mean: float
    rmse: float
    nmad: float
    completeness: float


def quality(
    heights: ArrayLike, truth: ArrayLike, where: ArrayLike | None = None
) -> Quality:
    """Compare heights (NaN where there are none) with the truth, where asked for."""
    e = np.asarray(heights, float) - np.asarray(truth, float)
    e = e[np.asarray(where)] if where is not None else e.ravel()
    known = e[np.isfinite(e)]
    nmad = 1.4826 * np.median(np.abs(known - np.median(known)))
    rmse = np.sqrt(np.mean(known**2))
    return Quality(known.size, known.mean(), rmse, nmad, known.size / e.size)
