"""Small turns of a rotation, which have no gimbal lock, and the way to its angles.

R = matrix(omega, phi, kappa).T turns image (or model) space into object space. A small
turn psi about the axes of object space makes it R + [psi]x R.
"""

import warnings

import numpy as np

from pgm_lab import rotation
from pgm_lab.camera import imaging

# Beyond this standard deviation of a turn (rad) its linear propagation is a guess.
WEAK = 0.1


def axes(angles: np.ndarray) -> np.ndarray:
    """Axes (..., 3, 3), one a column, about which each angle turns matrix(angles).T."""
    angles = np.asarray(angles)
    M = rotation.matrix(*np.moveaxis(angles, -1, 0))
    return np.swapaxes(M, -1, -2) @ imaging.axes_of_angles(M, angles[..., 2])


def angles(R: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
    """Angles (3,) of R, their derivatives (3, 3) by small turns, and if it is gimbal.

    With gimbal lock the rows of omega and kappa are NaN.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # told by the return value
        found = rotation.angles(R.T)
    by_turns = np.linalg.pinv(axes(found), rcond=1e-12)
    locked = bool(rotation.is_gimbal(R.T))
    if locked:
        by_turns[[0, 2]] = np.nan
    return found, by_turns, locked


def cross_matrix(vectors: np.ndarray) -> np.ndarray:
    """Matrices [a]x (..., 3, 3) with [a]x b = a x b."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
