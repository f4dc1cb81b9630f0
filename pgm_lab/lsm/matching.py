"""Least squares matching of many points at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._statuses import Matched
from pgm_lab.lsm import _iteration


@dataclass(frozen=True)
class Match(Matched):
    """Result of `match` for n points.

    Attributes
    ----------
    points : ndarray (n, 2)
        Points in the right image, (column, row) in pixels; NaN unless accepted.
    covariance : ndarray (n, 2, 2)
        Their covariance in square pixels; NaN unless accepted.
    sigma0 : ndarray (n,)
        Standard deviation, before interpolation, of a left grey value minus (h0 + h1
        times the right one).
    effective_pixels : ndarray (n,)
        Pixels with white noise of sigma0 that would give the covariance, but for what a
        curved surface adds to it: fewer than the template has where neighbouring
        residuals are correlated, or larger on strong texture, or pixels are saturated.
    parameters : ndarray (n, 8)
        (a0, a1, a2, b0, b1, b2, h0, h1) of (B 2.7) to (B 2.9), about the left point.
    parameter_covariance : ndarray (n, 8, 8)
        Their covariance; zero for h0 and h1 if they were not estimated. Noise in the
        right window makes h1 too small, by the fraction sigma^2 / variance(B), which
        the covariance does not include; the position is not affected.
    r : ndarray (n,)
        Correlation coefficient (B 2.6f) of the left and the resampled right window.
    redundancy : int
        Grey values minus parameters.
    iterations : ndarray (n,) of int
        Iterations, coarse and fine.
    status : ndarray (n,) of str
        "accepted", or what went wrong: one of `matching.STATUSES`, which explains it.
        A template is flat, too, if saturation leaves fewer than twice as many pixels as
        parameters; "diverged" is by more than half a window.
    """

    points: np.ndarray
    covariance: np.ndarray
    sigma0: np.ndarray
    effective_pixels: np.ndarray
    parameters: np.ndarray
    parameter_covariance: np.ndarray
    r: np.ndarray
    redundancy: int
    iterations: np.ndarray
    status: np.ndarray


def match(
    left: ArrayLike,
    right: ArrayLike,
    points: ArrayLike,
    start: ArrayLike | None = None,
    template: int = 21,
    *,
    radiometric: bool = True,
    shape: ArrayLike | None = None,
    threshold: float = 0.7,
    tolerance: float = 0.02,
    max_iterations: int = 20,
    correlated: bool = True,
    smooth: float = 0.0,
) -> Match:
    """Match windows around points of the left image in the right one.

    Each iteration resamples the right window at (B 2.8), (B 2.9) and solves (B 2.10)
    for the corrections. At the solution h1 B'_x and h1 B'_y of (B 2.11) are the
    derivatives of the left window, rotated by a1, a2, b1, b2; therefore the left window
    is differentiated, once and on its own pixels, and only grey values are
    interpolated. From the fifth iteration on the mean of the derivatives of both
    windows is used. Points that do not converge even so are tried again, starting from
    a match of images blurred by three pixels.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values, 8 or 16 bit or float. Pixels may be masked (`numpy.ma`), NaN or
        infinite: points whose windows depend on them get a status.
    points : array_like (n, 2)
        Points in the left image, (column, row) in pixels, integers at pixel centres.
        The window lies around the nearest pixel.
    start : array_like (n, 2), optional
        Where they are in the right image, to three pixels or so with a template of 21;
        default: at `points`.
    template : int
        Pixels across the template, the window of the left image, odd, at least 5.
    radiometric : bool
        False leaves h0 = 0 and h1 = 1.
    shape : array_like (2, 2) or (n, 2, 2), optional
        Start values ((a1, a2), (b1, b2)); default: the identity, as in (B 2.20).
    threshold : float
        Smallest correlation r, or -r of a negative, that counts as a match.
    tolerance : float
        Converged when an iteration moves no pixel of the window by more than this (px).
    max_iterations : int
        Limit of iterations for a point; as many again in a second attempt.
    correlated : bool
        False treats the noise as white and the surface as plane, as the textbook does.
    smooth : float
        Standard deviation in pixels, 0.3 to 3, of a Gaussian that smooths both images
        first; 0 for none. 1 px removes most aliasing and, where there is noise alone,
        costs a tenth of the precision.

    Returns
    -------
    Match

    Raises
    ------
    ValueError
        If an image is not two-dimensional or is smaller than the window, the window is
        even or below 5, or the points do not fit together. What happens to a single
        point is shown by its status.

    Notes
    -----
    The covariance is that of least squares with white noise, equal in both images; it
    allows for the noise in the gradients and for that which interpolation removes.
    Residuals that are correlated up to two pixels
    apart, or larger where the texture is strong, count as fewer pixels
    (`effective_pixels`). (B 2.8), (B 2.9) hold on a plane: where second powers of x and
    y, six more parameters, are significant in the residuals (Fisher's test, 1 %), the
    square of how far they would move the position is part of its covariance. What moves
    a window without leaving such residuals is not accounted for: a part of the
    aliasing, a weaker curvature.

    References
    ----------
    Bani 2010, (B 2.7) to (B 2.20), where (B 2.20b) has a wrong sign; Gruen 1985;
    Benhimane and Malis 2004 for the mean of both derivatives.
    White 1980 and Newey and West 1987, for the covariance of correlated residuals.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=1)
    >>> affine = (3.25, 1.01, 0.02, -1.5, -0.01, 0.99)
    >>> left, right = simulate.texture_pair(texture, (60, 60), affine, sigma=1.0)
    >>> found = match(left, right, [(30, 28)], [(34, 26)])
    >>> truth = (3.25 + 1.01 * 30 + 0.02 * 28, -1.5 - 0.01 * 30 + 0.99 * 28)
    >>> bool(np.abs(found.points[0] - truth).max() < 0.02)
    True
    >>> print(found.status[0], found.iterations[0])
    accepted 3
    """
    template = _validate.window(template, "template", 5)
    radiometric = _validate.flag(radiometric, "radiometric")
    half = template // 2
    left = _validate.grey_image(left, "left", template)
    right = _validate.grey_image(right, "right", template)
    points = _validate.point_list(points, "points")
    n = len(points)
    start = _validate.point_list(points if start is None else start, "start", n)
    tolerance = _validate.positive_number(tolerance, "tolerance", "px")
    threshold = _validate.between(threshold, "threshold", 0, 1)
    correlated = _validate.flag(correlated, "correlated")
    max_iterations = _validate.whole(max_iterations, "max_iterations", 1)
    # Clip points far outside: larger numbers do not fit an integer
    pixels = np.rint(np.clip(points, -1, max(left.shape))).astype(int)
    T = np.zeros((n, 2, 3))
    T[:, :, 0] = start
    T[:, :, 1:] = _validate.window_shapes(shape, n)
    status = np.full(n, "not converged", dtype=_iteration.STATUS)
    status[_iteration.outside(T, half, right.shape)] = "window leaves the image"
    windows = np.zeros_like(T) + np.eye(2, 3, 1)
    windows[..., 0] = pixels
    status[_iteration.outside(windows, half, left.shape)] = "template leaves the image"
    usable = np.flatnonzero(status == "not converged")
    u = 8 if radiometric else 6
    parameters, covariance = np.full((n, 8), np.nan), np.full((n, 8, 8), np.nan)
    sigma0, effective_pixels, r = np.full((3, n), np.nan)
    iterations = np.zeros(n, int)
    smooth = _validate.smoothing(smooth)
    settings = _iteration.Settings(
        half, radiometric, threshold, tolerance, max_iterations, correlated, smooth
    )
    chunk = _iteration.at_once(half)
    for first in range(0, len(usable), chunk):
        k = usable[first : first + chunk]
        found = _iteration.find(left, right, pixels[k], T[k], settings)
        parameters[k], covariance[k] = _of_left_point(found, points[k] - pixels[k])
        sigma0[k], r[k] = found.sigma0, found.r
        effective_pixels[k] = found.effective_pixels
        iterations[k], status[k] = found.iterations, found.status
    for values in (parameters, covariance, sigma0, effective_pixels, r):
        values[status != "accepted"] = np.nan
    return Match(
        points=parameters[:, [0, 3]],
        covariance=covariance[:, [[0], [3]], [[0, 3]]],
        sigma0=sigma0,
        effective_pixels=effective_pixels,
        parameters=parameters,
        parameter_covariance=covariance,
        r=r,
        redundancy=template**2 - u,
        iterations=iterations,
        status=status,
    )


def _of_left_point(
    found: _iteration.Found, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Parameters (m, 8) and covariance counted from the point, not from its pixel."""
    T, h, Q = found.T, found.h, found.Q
    left_mean, right_mean = found.means.T
    parameters = np.concatenate([T.reshape(-1, 6), h], axis=1)
    # Derivatives of the eight parameters by (q, h0, h1)
    P = np.zeros((len(T), 8, Q.shape[-1]))
    P[:, :6, :6] = np.kron(T[:, :, 1:], np.eye(3))
    if Q.shape[-1] == 8:
        P[:, 6, 6] = P[:, 7, 7] = 1
        P[:, 6, 7] = -right_mean
    parameters[:, 6] += left_mean - h[:, 1] * right_mean
    x, y = offset.T
    for values in (parameters, P):
        for a in (0, 3):
            values[:, a] += (x * values[:, a + 1].T + y * values[:, a + 2].T).T
    return parameters, P @ Q @ np.swapaxes(P, 1, 2)
