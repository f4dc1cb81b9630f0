"""What the orientations share: small rotations, and fits that are equally good.

R = matrix(omega, phi, kappa).T rotates image (or model) space into object space. A
small rotation psi about the axes of object space makes it R + [psi]x R. It has no
gimbal lock, unlike the angles.
"""

import warnings

import numpy as np
import scipy

from pgm_lab import rotation
from pgm_lab.camera import imaging

# Beyond this standard deviation of a rotation (rad) its linear propagation is a guess.
WEAK = 0.1

# Probability with which errors of known size stay below the limit.
KNOWN = 0.999


def axes(angles: np.ndarray) -> np.ndarray:
    """Axes (..., 3, 3), one a column, about which the angles rotate."""
    M = rotation.matrix(*np.moveaxis(angles, -1, 0))
    return np.swapaxes(M, -1, -2) @ imaging.axes_of_angles(M, angles[..., 2])


def angles(R: np.ndarray) -> tuple[np.ndarray, np.ndarray, bool]:
    """Angles (3,) of R, their derivatives (3, 3), and if in gimbal lock."""
    # In gimbal lock the rows of omega and kappa are NaN
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # the return value says it
        found = rotation.angles(R.T)
    by_rotation = np.linalg.pinv(axes(found), rcond=1e-12)
    locked = bool(rotation.is_gimbal(R.T))
    if locked:
        by_rotation[[0, 2]] = np.nan
    return found, by_rotation, locked


def cross_matrix(vectors: np.ndarray) -> np.ndarray:
    """Matrices [a]x (..., 3, 3) with [a]x b = a x b."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def extents(points: np.ndarray) -> np.ndarray:
    """Length, width, (depth) of a set of points (n, 2) or (n, 3), in their unit."""
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)


def largest_objective(
    least: float, redundancy: int, sigma: float | None, level: float
) -> float:
    """Largest sum of squares vᵀv that fits as well as the least one."""
    # By chi-square if sigma is known, else by the `level` quantile of two sums' ratio
    if sigma is not None:
        return max(least, sigma**2 * scipy.special.chdtri(redundancy, 1 - KNOWN))
    return least * scipy.special.fdtri(redundancy, redundancy, level)
