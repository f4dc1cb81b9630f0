"""Measuring in one image: the centre of a target from its grey values."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


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
        Grey value that was taken off before weighting.
    sigma : ndarray (...)
        Standard deviation of the grey values that the covariance rests on.
    status : ndarray (...) of str
        "ok"; "flat": no target stands out of the noise; "border": the target reaches
        the edge of the window, a part of it is missing: take a larger window.
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
        Taken off every weight, in grey values; pixels that stay below it are left out.
        Three sigma is a good choice. With 0 the whole window counts, noise of both
        signs included.
    dark : bool
        True for a dark target on a bright background.

    Returns
    -------
    Centroid
        Position, covariance, background, sigma and status of each window.

    Raises
    ------
    ValueError
        If the window is too small, has NaN, or sigma is negative.

    Notes
    -----
    With weights w and W = sum(w), error propagation gives d x / d g_i = (x_i - x) / W.
    The covariance holds for independent noise of equal size. It leaves out
    that with a threshold the noise also decides which pixels count (with three sigma
    the standard deviation holds to 15 per cent, and is too large by up to a half when
    the window is five times as wide as the target), rounding to whole grey values,
    uneven background, and that a circle seen at an angle is an ellipse whose centre is
    not the image of the circle's centre.

    References
    ----------
    Muliawan 2013, (2.15), after Shortis et al. 1994; with columns and rows counted from
    0 as in (2.17), and with the background taken off.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> result = centroid(simulate.target((10.25, 9.5)), sigma=2.0)
    >>> result.position.round(4)
    array([10.25,  9.5 ])
    >>> print(result.status)
    ok
    """
    g = _windows(window)
    ring = _ring(g.shape[-2:])
    if background is None:
        level = g[..., ring].mean(axis=-1)
    else:
        level = np.broadcast_to(background, g.shape[:-2]).astype(float)
    if sigma is not None and not np.all(np.asarray(sigma) >= 0):
        raise ValueError(f"sigma must not be negative or NaN; got {sigma}")

    sign = -1.0 if dark else 1.0
    weight = sign * (g - level[..., None, None])
    used = weight > threshold if threshold > 0 else np.ones_like(weight, dtype=bool)
    weight = np.where(used, weight - threshold, 0.0)
    status = _status(g, weight, used, ring, sigma)
    if sigma is None:
        sigma = g[..., ring].std(axis=-1, ddof=1)
    sigma = np.broadcast_to(sigma, g.shape[:-2]).astype(float)

    unusable = status != "ok"
    xy = _pixel_coordinates(g.shape[-2:])
    total = np.where(unusable, 1.0, weight.sum(axis=(-2, -1)))
    position = np.einsum("...rc,rck->...k", weight, xy) / total[..., None]
    position = np.where(unusable[..., None], np.nan, position)
    jacobian = np.where(used[..., None], xy - position[..., None, None, :], 0.0)
    jacobian /= total[..., None, None, None]
    if background is None:
        jacobian -= ring[..., None] / ring.sum() * jacobian.sum((-3, -2), keepdims=True)
    covariance = np.einsum("...rci,...rcj->...ij", jacobian, jacobian)
    covariance *= sigma[..., None, None] ** 2
    return Centroid(position, covariance, level, sigma, status)


def _windows(window: ArrayLike) -> np.ndarray:
    g = _validate.finite(window, "window")
    if g.ndim < 2 or min(g.shape[-2:]) < 3:
        raise ValueError(
            "window must have shape (..., rows, columns) with at least 3 x 3 pixels;"
            f" got shape {g.shape}"
        )
    return g


def _ring(shape: tuple[int, int]) -> np.ndarray:
    """True for the outermost pixels of a window."""
    ring = np.ones(shape, dtype=bool)
    ring[1:-1, 1:-1] = False
    return ring


def _pixel_coordinates(shape: tuple[int, int]) -> np.ndarray:
    """(column, row) of every pixel, shape (rows, columns, 2)."""
    rows, columns = np.indices(shape)
    return np.stack([columns, rows], axis=-1).astype(float)


def _status(g, weight, used, ring, sigma) -> np.ndarray:
    """Name what is wrong with a window: its target is missing, or cut by the border.

    Median and median deviation of the ring, since a target that reaches the ring would
    spoil its mean and standard deviation.
    """
    level = np.median(g[..., ring], axis=-1)
    outlying = np.abs(g - level[..., None, None])
    spread = 1.4826 * np.median(outlying[..., ring], axis=-1)
    noise = spread if sigma is None else sigma
    total = weight.sum(axis=(-2, -1))
    flat = total <= 5 * noise * np.sqrt(used.sum(axis=(-2, -1)))
    highest = outlying[..., ring].max(axis=-1)
    cut = (highest > 6 * spread) & (highest > outlying.max(axis=(-2, -1)) / 4)
    return np.where(cut, "border", np.where(flat, "flat", "ok"))
