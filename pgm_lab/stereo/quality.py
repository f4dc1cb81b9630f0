"""How good heights are, compared with the truth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate

# Median of the absolute deviations of normal errors of standard deviation 1, inverted
NORMAL = 1.4826


@dataclass(frozen=True)
class Quality:
    """Errors of heights, all but the counts in the unit of the heights.

    Attributes
    ----------
    n : int
        Heights that were compared.
    mean, rmse : float
        Mean error (height minus truth) and root mean square error.
    nmad : float
        1.4826 times the median distance of the errors from their median: for normal
        errors the standard deviation, and blunders hardly change it.
    completeness : float
        Share of the cells asked for that have a height.
    le95 : float
        95 of 100 errors are smaller, regardless of sign.
    """

    n: int
    mean: float
    rmse: float
    nmad: float
    completeness: float
    le95: float


def quality(
    heights: ArrayLike, truth: ArrayLike, where: ArrayLike | None = None
) -> Quality:
    """Compare heights with the truth.

    Parameters
    ----------
    heights : array_like (...)
        NaN where there are none.
    truth : array_like (...)
        Of the same shape; NaN where it is not known, and nothing is compared.
    where : array_like (...) of bool, optional
        Which to compare; all when missing.

    Returns
    -------
    Quality
        With errors NaN if no height is left to compare.

    Raises
    ------
    ValueError
        If shapes do not fit, or a height is infinite.

    References
    ----------
    Höhle, J., Höhle, M. (2009): Accuracy assessment of digital elevation models by
    means of robust statistical methods. ISPRS Journal of Photogrammetry and Remote
    Sensing 64(4), 398-406.

    Examples
    --------
    >>> quality([1.1, 1.9, 3.1, np.nan], [1.0, 2.0, 3.0, 4.0]).completeness
    0.75
    """
    heights, truth = (
        _validate.real(heights, "heights"),
        _validate.real(truth, "truth"),
    )
    if heights.shape != truth.shape:
        raise ValueError(
            f"heights and truth must have one shape; got {heights.shape} and"
            f" {truth.shape}"
        )
    for name, values in (("heights", heights), ("truth", truth)):
        _validate.refuse(np.isinf(values), name + "{} are infinite")
    asked = np.isfinite(truth)
    if where is not None:
        asked = asked & _mask(where, truth.shape)
    error = (heights - truth)[asked]
    known = error[np.isfinite(error)]
    if not known.size:
        return Quality(0, np.nan, np.nan, np.nan, 0.0 if error.size else np.nan, np.nan)
    return Quality(
        n=known.size,
        mean=float(known.mean()),
        rmse=float(np.sqrt(np.mean(known**2))),
        nmad=float(NORMAL * np.median(np.abs(known - np.median(known)))),
        completeness=known.size / error.size,
        le95=float(np.quantile(np.abs(known), 0.95)),
    )


def _mask(where: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    _validate.real(where, "where")
    mask = np.asarray(where)
    if mask.dtype != bool or mask.shape != shape:
        raise ValueError(
            f"where must be True or False in shape {shape}; got {mask.dtype} in shape"
            f" {mask.shape}"
        )
    return mask
