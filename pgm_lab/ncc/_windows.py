"""Two windows of equal size: their correlation, and the line between grey values."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


@dataclass(frozen=True)
class Regression:
    """The line through the grey values of two windows: b = alpha + beta a.

    Attributes
    ----------
    alpha : float
        Offset in grey values: b where a is zero.
    beta : float
        Gain: change of b per grey value of a.
    r : float
        Correlation coefficient, between -1 and 1.
    """

    alpha: float
    beta: float
    r: float


def correlation(a: ArrayLike, b: ArrayLike) -> float:
    """Correlation coefficient of two windows of grey values.

    1 where b is a positive linear function of a, -1 for a negative one (a photo and its
    negative); near 0 for windows with nothing in common.

    Parameters
    ----------
    a, b : array_like
        Grey values, two arrays of the same shape, of at least two pixels.

    Returns
    -------
    float
        r, between -1 and 1.

    Raises
    ------
    ValueError
        If the shapes differ, a value is not finite, or a window is flat: its standard
        deviation is zero, and r would be 0/0.

    References
    ----------
    (B 2.6f), (B 3.1), (Br 1); (H 1), which sums the products under the root and not
    each square.

    Examples
    --------
    >>> a = np.array([[10, 20, 30], [40, 50, 90]], dtype=np.uint8)
    >>> round(correlation(a, 255 - a), 12)
    -1.0
    """
    a, b = _two_windows(a, b)
    a, b = _deviations(a, "a"), _deviations(b, "b")
    return _coefficient(np.sum(a * b), np.sum(a * a), np.sum(b * b))  # (B 2.6f)


def regression(a: ArrayLike, b: ArrayLike) -> Regression:
    """Offset, gain and correlation of two windows, by the computing form.

    b is regressed on a: b = alpha + beta a, as x = a and y = b in (B 2.6d). With
    a = right and b = left, h0 = alpha and h1 = beta of least squares matching (B 2.7).
    Where the mean is 10^k times the standard deviation, the computing form loses 2k of
    the 16 digits; `correlation` none.

    Parameters
    ----------
    a, b : array_like
        Grey values, two arrays of the same shape, of at least two pixels.

    Returns
    -------
    Regression

    Raises
    ------
    ValueError
        If the shapes differ, a value is not finite, or a window is flat.

    References
    ----------
    Bani 2010, (B 2.6a) to (B 2.6e). (B 2.6e) lacks the mean of y; it is
    alpha = mean(y) - beta mean(x), as in the listing.

    Examples
    --------
    >>> a = np.array([[10, 20, 30], [40, 50, 90]])
    >>> line = regression(a, 4 + 1.08 * a)
    >>> round(line.alpha, 9), round(line.beta, 9), round(line.r, 9)
    (4.0, 1.08, 1.0)
    """
    x, y = _two_windows(a, b)
    _deviations(x, "a"), _deviations(y, "b")
    n = x.size
    sxx = np.sum(x * x) - np.sum(x) ** 2 / n  # (B 2.6a)
    syy = np.sum(y * y) - np.sum(y) ** 2 / n  # (B 2.6b)
    sxy = np.sum(x * y) - np.sum(x) * np.sum(y) / n  # (B 2.6c)
    if not (sxx > 0 and syy > 0):
        raise ValueError(
            "the computing form lost all digits: the contrast of a window is too"
            " small compared with its mean. Subtract a constant from a and b first, or"
            " use correlation"
        )
    beta = sxy / sxx  # (B 2.6d)
    alpha = np.mean(y) - beta * np.mean(x)  # (B 2.6e) with the mean of y
    return Regression(float(alpha), float(beta), _coefficient(sxy, sxx, syy))


def _two_windows(a: ArrayLike, b: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    a, b = _validate.finite(a, "a"), _validate.finite(b, "b")
    if a.shape != b.shape or a.size < 2:
        raise ValueError(
            "a and b must be windows of the same shape, of at least two pixels; got"
            f" {a.shape} and {b.shape}"
        )
    return a, b


def _deviations(window: np.ndarray, name: str) -> np.ndarray:
    """The window without its mean, scaled so that no square over- or underflows."""
    if window.max() == window.min():
        raise ValueError(
            f"{name} is flat: all its grey values are {window.flat[0]:g}, and no"
            " correlation is defined. Take a larger window, or one with texture"
        )
    window = np.ldexp(window, -np.frexp(np.abs(window).max())[1])  # by a power of two
    deviations = window - window.mean()
    deviations /= np.abs(deviations).max()
    return deviations - deviations.mean()  # again, since the first mean was rounded


def _coefficient(sxy: float, sxx: float, syy: float) -> float:
    """r, kept within -1 and 1 where rounding would exceed them in the last digit."""
    return float(np.clip(sxy / np.sqrt(sxx) / np.sqrt(syy), -1.0, 1.0))
