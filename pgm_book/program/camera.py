"""Collinearity in a few lines, as lesson 5 writes it: to be read.

`pgm_lab.camera` does the same with lens distortion and derivatives, for many photos.
"""

from collections.abc import Callable

import numpy as np

from pgm_lab import rotation


def project(exterior: np.ndarray, points: np.ndarray, c: float) -> np.ndarray:
    """Photo coordinates of object points in an ideal camera.

    Parameters
    ----------
    exterior : array_like (6,)
        X0, Y0, Z0, omega, phi, kappa: perspective centre and angles in radians.
    points : array_like (n, 3)
        Object points X, Y, Z, in the unit of the perspective centre.
    c : float
        Principal distance in mm.

    Returns
    -------
    ndarray (n, 2)
        x to the right and y up, in mm, from the principal point.

    Raises
    ------
    ValueError
        If a point does not lie in front of the camera.

    References
    ----------
    Muliawan 2013, (M 2.9) and (M 2.10), with x0 = y0 = 0 and no distortion.

    Examples
    --------
    >>> project([0, 0, 1000, 0, 0, 0], [[100, 50, 0]], 30.0)
    array([[3. , 1.5]])
    """
    exterior, points = np.asarray(exterior, float), np.asarray(points, float)
    U, V, W = rotation.matrix(*exterior[3:]) @ (points - exterior[:3]).T
    if not np.all(W < 0):
        raise ValueError(
            f"point {int(np.argmax(W >= 0))} of points does not lie in front of the"
            " camera, which looks along its negative z axis"
        )
    return np.column_stack([-c * U / W, -c * V / W])


def derivatives(
    function: Callable[[np.ndarray], np.ndarray], at: np.ndarray
) -> np.ndarray:
    """Derivatives of a function of several unknowns, by central differences.

    Parameters
    ----------
    function : callable
        Takes the unknowns (u,), returns numbers of any shape, n in all.
    at : array_like (u,)
        Where the derivatives are wanted.

    Returns
    -------
    ndarray (n, u)
        One column per unknown, good to some nine digits.

    Examples
    --------
    >>> derivatives(lambda x: [x[0] ** 2, x[0] * x[1]], [3.0, 5.0]).round(6)
    array([[6., 0.],
           [5., 3.]])
    """
    at = np.asarray(at, float)
    columns = []
    for k, step in enumerate(1e-6 * np.maximum(1.0, np.abs(at))):
        there, back = at.copy(), at.copy()
        there[k] += step
        back[k] -= step
        change = np.subtract(function(there), function(back))
        columns.append(np.ravel(change) / (there[k] - back[k]))
    return np.column_stack(columns)
