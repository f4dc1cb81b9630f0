"""Small turns of a rotation, which have no gimbal lock, and the way to its angles.

R = matrix(omega, phi, kappa).T turns image (or model) space into object space. A small
turn psi about the axes of object space makes it R + [psi]x R.
"""

import warnings

import numpy as np

from pgm_lab import rotation

# Beyond this standard deviation of a turn (rad) its linear propagation is a guess.
WEAK = 0.1


def axes(angles: np.ndarray) -> np.ndarray:
    """Axes (..., 3, 3), one a column, about which each angle turns matrix(angles).T."""
    angles = np.moveaxis(np.asarray(angles), -1, 0)
    M = rotation.matrix(*angles)[..., None, :, :]
    skew = np.swapaxes(rotation.derivatives(*angles), -1, -2) @ M
    parts = skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]
    return np.stack(parts, axis=-2)


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
