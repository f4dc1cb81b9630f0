"""Two tests of one residual at a time: Baarda's w and Pope's tau.

Both divide a residual by its own standard deviation. Baarda's takes sigma0 as it was
stated before the adjustment, Pope's as the adjustment estimates it.
"""

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate

NAMES = {"w": "Baarda's w", "tau": "Pope's tau"}


def residual_test(sigma0_prior: float | None) -> str:
    """Return "w" if sigma0 was stated before the adjustment, else "tau"."""
    return "tau" if sigma0_prior is None else "w"


def critical_w(alpha: float = 0.001) -> float:
    """Limit that the absolute value of Baarda's w exceeds with probability alpha.

    w is standard normal if the stated sigmas are right and there is no blunder.

    Parameters
    ----------
    alpha : float
        Probability of a false alarm in one test, two-sided; between 0 and 1.

    References
    ----------
    Baarda 1968, "A testing procedure for use in geodetic networks".

    Examples
    --------
    >>> print(f"{critical_w():.2f}")
    3.29
    """
    return -float(scipy.special.ndtri(_validate.probability(alpha, "alpha") / 2))


def critical_tau(redundancy: ArrayLike, alpha: float = 0.001) -> float | np.ndarray:
    """Limit that the absolute value of Pope's tau exceeds with probability alpha.

    ``tau = t sqrt(r) / sqrt(r - 1 + t^2)`` with r the redundancy and t the limit of
    Student's t with r - 1 degrees of freedom. A blunder enlarges the sigma0 that it is
    divided by: no tau is above the root of r. The limit tends to that of w.

    Parameters
    ----------
    redundancy : array_like (...) of int
        Degrees of freedom of sigma0.
    alpha : float
        Probability of a false alarm in one test, two-sided; between 0 and 1.

    Returns
    -------
    float or ndarray (...)
        inf where the redundancy is below 2: then each tau is 1 or 0.

    References
    ----------
    Pope 1976, "The statistics of residuals and the detection of outliers".

    Examples
    --------
    >>> critical_tau([4, 18, 693]).round(2)
    array([1.98, 2.94, 3.28])
    """
    alpha = _validate.probability(alpha, "alpha")
    r = _validate.finite(redundancy, "redundancy")
    known = np.where(r < 2, np.nan, r)
    t = -scipy.special.stdtrit(known - 1, alpha / 2)
    tau = t * np.sqrt(known) / np.sqrt(known - 1 + t**2)
    return np.where(r < 2, np.inf, tau)[()]
