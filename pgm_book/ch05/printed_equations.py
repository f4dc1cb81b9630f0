"""The derivatives of collinearity as they are printed in (M 2.24), and as they are.

To examine the printed formulas. Nothing here is for use in a computation: that is
`camera.collinearity`.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import camera, rotation

STEP = 1e-5  # of the finite differences: in radians, and as a share of the distance


def coefficients(f: float, exterior: ArrayLike, point: ArrayLike) -> np.ndarray:
    """The coefficients b11 to b26 as they are printed in (M 2.24), right or wrong.

    b13, b22, b23 and b26 are misprinted.

    Parameters
    ----------
    f : float
        Principal distance in mm.
    exterior : array_like (6,)
        (X0, Y0, Z0, omega, phi, kappa).
    point : array_like (3,)
        Object point.

    Returns
    -------
    ndarray (2, 6)
        Rows x and y; columns omega, phi, kappa, X, Y, Z.

    References
    ----------
    (M 2.24).

    Examples
    --------
    >>> exterior, point = [0, 0, 100, 0, 0, 0], [20, 0, 0]
    >>> off = coefficients(50.0, exterior, point) - moved_by_each(50.0, exterior, point)
    >>> np.argwhere(np.abs(off) > 1e-6) + 1  # here b23 alone, whose sign is wrong
    array([[2, 3]])
    """
    exterior, point = np.array(exterior, float), np.array(point, float)
    m = rotation.matrix(*exterior[3:])
    dX, dY, dZ = d = point - exterior[:3]
    r, s, q = m @ d
    (so, sp, sk), (co, cp, ck) = np.sin(exterior[3:]), np.cos(exterior[3:])
    by_omega = -m[:, 2] * dY + m[:, 1] * dZ  # of r, s, q
    q_by_phi = cp * dX + so * sp * dY - co * sp * dZ
    r_by_phi = -sp * ck * dX + so * cp * ck * dY - co * cp * ck * dZ
    s_by_phi = -sp * sk * dX - so * cp * sk * dY - co * cp * sk * dZ
    x_row = [
        r * by_omega[2] - q * by_omega[0],
        r * q_by_phi - q * r_by_phi,
        -q * (m[0, 1] * dX + m[1, 1] * dY + m[1, 2] * dZ),
        *(r * m[2] - q * m[0]),
    ]
    y_row = [
        s * by_omega[2] - q * by_omega[1],
        s * q_by_phi - q * s_by_phi,
        -q * (m[0] @ d),
        *(s * m[2, :2] - q * m[1, :2]),
        s * m[2, 1] - q * m[1, 2],
    ]
    return f / q**2 * np.array([x_row, y_row])


def moved_by_each(f: float, exterior: ArrayLike, point: ArrayLike) -> np.ndarray:
    """How x and y change when each unknown is moved a little: central differences.

    Arguments and columns as for `coefficients`.

    Examples
    --------
    >>> moved_by_each(50.0, [0, 0, 100, 0, 0, 0], np.zeros(3)).round(6)[:, 3:]
    array([[0.5, 0. , 0. ],
           [0. , 0.5, 0. ]])
    """
    one = camera.Camera(f)
    unknown = np.concatenate([exterior, point]).astype(float)
    # The error falls with the square of the step, rounding grows with its inverse
    step = np.diag(STEP * np.repeat([1.0, np.linalg.norm(unknown[:3])], [3, 3]))
    step = np.insert(step, 0, np.zeros((3, 6)), axis=1)
    ahead, behind = unknown + step, unknown - step
    change = camera.project(one, ahead[:, :6], ahead[:, 6:])
    change = change - camera.project(one, behind[:, :6], behind[:, 6:])
    return (change / (2 * step.max(axis=1)[:, None])).T
