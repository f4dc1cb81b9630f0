"""Intersection and resection in a few lines, as lesson 5 writes them: to be read.

`intersect` and `resect` do the same with a lens, from no start values, and say what
went wrong.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_book.program import adjustment as least_squares
from pgm_book.program import camera as collinearity
from pgm_lab import _validate

STEPS = 20  # Gauss-Newton steps of a resection, enough from any near start


def intersection(stations: ArrayLike, directions: ArrayLike) -> np.ndarray:
    """Point with the least sum of squared distances from all rays.

    Parameters
    ----------
    stations : array_like (n, 3)
        Where the rays begin.
    directions : array_like (n, 3)
        Where they go, of any length but 0.

    Returns
    -------
    ndarray (3,)

    Raises
    ------
    ValueError
        If the shapes do not fit, a number is not finite, a direction is 0, or all rays
        are parallel.

    Examples
    --------
    >>> intersection([[0, 0, 0], [4, 0, 0]], [[0, 0, 1], [-2, 0, 1]]).round(6)
    array([0., 0., 2.])
    """
    stations = _validate.finite(stations, "stations")
    directions = _validate.finite(directions, "directions")
    if stations.ndim != 2 or stations.shape[1] != 3 or not len(stations):
        raise ValueError(f"stations must have shape (n, 3); got {stations.shape}")
    if directions.shape != stations.shape:
        raise ValueError(
            "directions must have the shape of stations, one a ray; got"
            f" {directions.shape} and {stations.shape}"
        )
    largest = np.abs(directions).max(axis=1, keepdims=True)
    if not np.all(largest > 0):
        raise ValueError("directions must not be 0: such a ray goes nowhere")
    d = directions / largest
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    across = np.eye(3) - d[:, :, None] * d[:, None, :]
    if np.linalg.cond(across.sum(axis=0)) > 1e14:
        raise ValueError("all rays are parallel: they have no nearest point")
    right_side = np.einsum("nij,nj->i", across, stations)
    return np.asarray(np.linalg.solve(across.sum(axis=0), right_side))


def resection(
    start: ArrayLike, image: ArrayLike, points: ArrayLike, c: float
) -> tuple[np.ndarray, np.ndarray]:
    """Exterior orientation of one photo from control points, by a short loop.

    Parameters
    ----------
    start : array_like (6,)
        Approximate X0, Y0, Z0, omega, phi, kappa; angles in radians.
    image : array_like (n, 2)
        Measured photo coordinates in mm, from the principal point.
    points : array_like (n, 3)
        The control points, n of at least 3.
    c : float
        Principal distance in mm.

    Returns
    -------
    exterior : ndarray (6,)
        The adjusted exterior orientation.
    sd : ndarray (6,)
        Standard deviations; NaN without redundancy.

    Raises
    ------
    ValueError
        If the shapes do not fit, or a step leads behind the points: start nearer.

    Examples
    --------
    >>> points = [[0, 0, 0], [90, 0, 5], [0, 80, 9], [85, 70, 0], [40, 30, 2]]
    >>> image = collinearity.project([40, 35, 120, 0, 0, 0.1], points, 35.0)
    >>> resection([45, 30, 110, 0, 0, 0], image, points, 35.0)[0][:3].round(6)
    array([ 40.,  35., 120.])
    """
    exterior = _validate.finite(start, "start").copy()
    image = _validate.finite(image, "image")
    points = _validate.finite(points, "points")
    if exterior.shape != (6,) or points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(
            "start must have shape (6,) and points (n, 3); got"
            f" {exterior.shape} and {points.shape}"
        )
    if image.ndim != 2 or image.shape != (len(points), 2):
        raise ValueError(
            "image must have shape (n, 2), one row a point of points; got"
            f" {image.shape} and {points.shape}"
        )
    sd = np.full(6, np.nan)
    for _ in range(STEPS):
        A = collinearity.derivatives(
            lambda e: collinearity.project(e, points, c), exterior
        )
        misclosure = (image - collinearity.project(exterior, points, c)).ravel()
        change, _, sigma0, Q = least_squares.adjust(A, np.ones(len(A)), misclosure)
        exterior = exterior + change
        sd = sigma0 * np.sqrt(np.diag(Q))
    return exterior, sd
