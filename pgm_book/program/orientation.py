"""Intersection, resection and relative orientation in a few lines, as lesson 5 writes.

`pgm_lab.orientation` does the same with lens distortion, without start values, and says
what went wrong.
"""

import numpy as np

from pgm_book.program.adjustment import adjust
from pgm_book.program.camera import derivatives, project
from pgm_lab import rotation

STEPS = 20  # Gauss-Newton steps of a resection, enough from any near start


def intersection(stations: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Point (3,) with the least sum of squared distances from all rays.

    Parameters
    ----------
    stations : array_like (n, 3)
        Where the rays begin.
    directions : array_like (n, 3)
        Their directions, of any length but 0.

    Raises
    ------
    ValueError
        If a direction is 0, or all rays are parallel.

    Examples
    --------
    >>> intersection([[0, 0, 0], [4, 0, 0]], [[0, 0, 1], [-2, 0, 1]]).round(6)
    array([0., 0., 2.])
    """
    stations, directions = np.asarray(stations, float), np.asarray(directions, float)
    largest = np.abs(directions).max(axis=1, keepdims=True)
    if not np.all(largest > 0):
        raise ValueError("directions must not be 0: such a ray has no direction")
    d = directions / largest
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    across = np.eye(3) - d[:, :, None] * d[:, None, :]
    if np.linalg.cond(across.sum(axis=0)) > 1e14:
        raise ValueError("all rays are parallel: they have no nearest point")
    right_side = np.einsum("nij,nj->i", across, stations)
    return np.linalg.solve(across.sum(axis=0), right_side)


def resection(
    start: np.ndarray, image: np.ndarray, points: np.ndarray, c: float
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
        If a step leads behind the points: start closer.

    Examples
    --------
    >>> points = [[0, 0, 0], [90, 0, 5], [0, 80, 9], [85, 70, 0], [40, 30, 2]]
    >>> image = project([40, 35, 120, 0, 0, 0.1], points, 35.0)
    >>> resection([45, 30, 110, 0, 0, 0], image, points, 35.0)[0][:3].round(6)
    array([ 40.,  35., 120.])
    """
    exterior, image = np.asarray(start, float), np.asarray(image, float)
    for _ in range(STEPS):
        A = derivatives(lambda e: project(e, points, c), exterior)
        misclosure = (image - project(exterior, points, c)).ravel()
        change, _, sigma0, Q = adjust(A, np.ones(len(A)), misclosure)
        exterior = exterior + change
    return exterior, sigma0 * np.sqrt(np.diag(Q))


def relative(left: np.ndarray, right: np.ndarray, c: float) -> np.ndarray:
    """Exterior orientation of the right photo in the frame of the left one.

    The left photo stays at the origin, not rotated. The unit is the X of the base, so
    the right photo is to the right of the left one.

    Parameters
    ----------
    left, right : array_like (n, 2)
        Photo coordinates in mm of the same points, n of at least 5.
    c : float
        Principal distance in mm, of both photos.

    Returns
    -------
    ndarray (6,)
        X0 = 1, Y0, Z0, omega, phi, kappa; angles in radians.

    References
    ----------
    Muliawan 2013, (M 2.30): base and rays span a box without volume.

    Examples
    --------
    >>> points = np.array([[0, 0, -9], [4, 0, -8], [0, 3, -7], [4, 3, -9]])
    >>> points = np.concatenate([points, points / 2 + (1, 0, -4)])
    >>> right = project([1, 0.1, 0, 0, 0.2, 0], points, 35.0)
    >>> relative(project(np.zeros(6), points, 35.0), right, 35.0).round(6) + 0.0
    array([1. , 0.1, 0. , 0. , 0.2, 0. ])
    """
    first, second = (np.insert(np.asarray(p, float), 2, -c, 1) for p in (left, right))

    def volumes(five: np.ndarray) -> np.ndarray:
        turned = second @ rotation.matrix(*five[2:])
        return np.cross(first, turned) @ np.insert(five[:2], 0, 1.0)

    five = np.zeros(5)
    for _ in range(STEPS // 2):
        A = derivatives(volumes, five)
        five = five + adjust(A, np.ones(len(A)), -volumes(five))[0]
    return np.insert(five, 0, 1.0)
