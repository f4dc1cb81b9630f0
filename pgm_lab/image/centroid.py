"""The centre of a target from its grey values."""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._robust import SD_OF_MAD


@dataclass(frozen=True)
class Centroid:
    """Weighted centroid of one target, or of a stack of them (leading axes ...).

    Attributes
    ----------
    position : ndarray (..., 2)
        (column, row) in the window, in pixels, integers at pixel centres; NaN unless
        the status is "ok".
    covariance : ndarray (..., 2, 2)
        Covariance of the position, in square pixels; NaN unless the status is "ok".
    background : ndarray (...)
        Grey value that was subtracted before weighting.
    sigma : ndarray (...)
        Standard deviation of the grey values, on which the covariance is based.
    status : ndarray (...) of str
        "ok"; "flat": nothing stands out from the noise; "border": part of the target is
        outside, take a larger window.
    """

    position: np.ndarray
    covariance: np.ndarray
    background: np.ndarray
    sigma: np.ndarray
    status: np.ndarray


def centroid(
    window: ArrayLike,
    background: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
    threshold: float = 0.0,
    dark: bool = False,
) -> Centroid:
    """Centre of a target: the mean of the pixel coordinates, weighted by grey value.

    The weights are the grey values above the background, or below it for a dark target.
    Without a given background it is the mean of the outermost ring of pixels, and its
    own uncertainty is part of the covariance.

    Parameters
    ----------
    window : array_like (..., rows, columns)
        Grey values of a window around the target; at least 3 x 3.
    background : array_like (...), optional
        Known grey value of the background.
    sigma : array_like (...), optional
        Standard deviation of the noise, in grey values; estimated from the ring of
        border pixels if not given.
    threshold : float
        Subtracted from every weight, in grey values; pixels below it are left out.
        Three sigma is a good choice. With 0 the whole window counts, noise of both
        signs included.
    dark : bool
        True for a dark target on a bright background.

    Returns
    -------
    Centroid

    Raises
    ------
    ValueError
        If the window is too small, a number is not finite, a shape does not fit, or
        sigma or the threshold is negative.

    Notes
    -----
    With weights w and W = sum(w), error propagation gives d x / d g_i = (x_i - x) / W,
    for independent noise of equal size. The covariance leaves out that with a threshold
    the noise also decides which pixels count, rounding to whole grey values, uneven
    background, and that a circle seen at an angle is an ellipse whose centre is not the
    image of the circle's centre.

    References
    ----------
    Muliawan 2013, (M 2.15), after Shortis et al. 1994; with columns and rows counted
    from 0 as in (M 2.17), and with the background subtracted.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> result = centroid(simulate.target((10.25, 9.5)), sigma=2.0)
    >>> result.position.round(4)
    array([10.25,  9.5 ])
    >>> print(result.status)
    ok
    """
    g = _validate.finite(window, "window")
    if g.ndim < 2 or min(g.shape[-2:]) < 3:
        raise ValueError(
            "window must have shape (..., rows, columns) with at least 3 x 3 pixels;"
            f" got shape {g.shape}"
        )
    ring = np.ones(g.shape[-2:], dtype=bool)  # the outermost pixels
    ring[1:-1, 1:-1] = False
    threshold = _validate.number(threshold, "threshold")
    dark = _validate.flag(dark, "dark")
    if threshold < 0:
        raise ValueError(f"threshold must not be negative; got {threshold}")
    if background is None:
        level = g[..., ring].mean(axis=-1)
    else:
        level = _one_each(background, "background", g.shape[:-2])
    if sigma is None:
        noise = g[..., ring].std(axis=-1, ddof=1)
    else:
        noise = _one_each(sigma, "sigma", g.shape[:-2])
        if np.any(noise < 0):
            raise ValueError(f"sigma must not be negative; got {noise}")

    sign = -1.0 if dark else 1.0
    weight = sign * (g - level[..., None, None])
    used = weight > threshold if threshold > 0 else np.ones_like(weight, dtype=bool)
    weight = np.where(used, weight - threshold, 0.0)
    # From here on, the pixels of a window are one row
    weight, used = (a.reshape(*level.shape, -1) for a in (weight, used))
    total = weight.sum(axis=-1)
    estimated = ring.sum() if background is None else np.inf
    flat = _is_flat(total, ring.size, threshold, noise, estimated)
    status = np.where(_is_cut(g, ring), "border", np.where(flat, "flat", "ok"))

    total = np.where(status == "ok", total, np.nan)[..., None]
    rows, columns = np.indices(g.shape[-2:])
    xy = np.stack([columns.ravel(), rows.ravel()]).astype(float)
    position = weight @ xy.T / total  # (M 2.15)
    lever = (xy - position[..., None]) * used[..., None, :]
    jacobian = lever / total[..., None]  # of the position by each grey value
    if background is None:  # each pixel of the ring moves the background of all
        share = ring.ravel() / ring.sum()
        jacobian -= share * jacobian.sum(axis=-1, keepdims=True)
    covariance = jacobian @ jacobian.swapaxes(-1, -2) * noise[..., None, None] ** 2
    return Centroid(position, covariance, level, noise, status)


def _one_each(values: ArrayLike, name: str, shape: tuple[int, ...]) -> np.ndarray:
    """One number for each window of a stack."""
    array = _validate.finite(values, name)
    if array.shape not in ((), shape):
        raise ValueError(
            f"{name} must be one number, or one for each window, shape {shape};"
            f" got shape {array.shape}"
        )
    return np.broadcast_to(array, shape)


def _is_flat(
    total: np.ndarray, n: int, threshold: float, sigma: np.ndarray, ring_pixels: float
) -> np.ndarray:
    """Whether n weights add up to no more than noise alone would."""
    # The weights of n empty pixels have the sum `mean`, with the standard deviation
    # `sd`, in units of sigma; the level of the ring has an error of its own.
    if threshold == 0:
        mean, sd = 0.0, np.sqrt(n + n**2 / ring_pixels)
    else:
        k = threshold / np.maximum(sigma, 1e-300)
        above = scipy.special.ndtr(-k)
        density = np.exp(-(k**2) / 2) / np.sqrt(2 * np.pi)
        each = density - k * above
        variance = (1 + k**2) * above - k * density - each**2
        mean, sd = n * each, np.sqrt(n * variance + (n * above) ** 2 / ring_pixels)
    # Generous, since sigma may be estimated and rare peaks are not normal
    return total <= sigma * (1.5 * mean + 6 * sd + 10)


def _is_cut(g: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Whether a target reaches the ring: a quarter of its height, above all noise."""
    # Median and median deviation, since the target would spoil mean and deviation
    outlying = np.abs(g - np.median(g[..., ring], axis=-1)[..., None, None])
    highest = outlying[..., ring].max(axis=-1)
    noise = SD_OF_MAD * np.median(outlying[..., ring], axis=-1)
    return (highest > 6 * noise) & (highest > outlying.max(axis=(-2, -1)) / 4)
