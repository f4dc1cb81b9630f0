"""Rotations about one axis: quaternions and Rodrigues vectors."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.rotation import check

# cos(angle / 2) below which a rotation counts as a half turn.
HALF_TURN = 1e-9


def from_quaternion(quaternion: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Rotation matrix of a unit quaternion (w, x, y, z), the scalar first.

    It turns the camera, as omega, phi, kappa do: (cos(a/2), 0, 0, sin(a/2)) is
    kappa = a. A quaternion and its negative give the same matrix.

    Parameters
    ----------
    quaternion : array_like (..., 4)
        (w, x, y, z), of length 1.
    tolerance : float
        Largest difference of the length from 1 that is accepted and then removed.

    Returns
    -------
    ndarray (..., 3, 3)
        Object space into image space.

    Raises
    ------
    ValueError
        If the last axis is not 4 long, a number is not finite or the length is not 1.

    Examples
    --------
    >>> from_quaternion([0.6, 0.0, 0.0, 0.8]).round(2)  # kappa = 2 arctan(4/3)
    array([[-0.28,  0.96,  0.  ],
           [-0.96, -0.28,  0.  ],
           [ 0.  ,  0.  ,  1.  ]])
    """
    tolerance = _validate.not_negative(tolerance, "tolerance", "of the length")
    q = _validate.finite(quaternion, "quaternion")
    if q.ndim == 0 or q.shape[-1] != 4:
        raise ValueError(
            f"quaternion must have shape (..., 4), (w, x, y, z); got shape {q.shape}"
        )
    length = np.linalg.norm(q, axis=-1, keepdims=True)
    off = np.abs(length - 1).max(initial=0.0)
    if off > tolerance:
        raise ValueError(
            f"quaternion must have length 1; it differs by up to {off:.2g}, more than"
            f" {tolerance:g}. Divide it by its length to make it one"
        )
    w, x, y, z = np.moveaxis(q / length, -1, 0)
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), w * w - x * x + y * y - z * z, 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def to_quaternion(M: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Unit quaternion (w, x, y, z) of a rotation matrix, with w >= 0.

    Parameters
    ----------
    M : array_like (..., 3, 3)
        Rotation matrices, object space into image space.
    tolerance : float
        Largest |M Mᵀ - I| that is accepted.

    Returns
    -------
    ndarray (..., 4)
        (w, x, y, z), the scalar first.

    Raises
    ------
    ValueError
        If M is not a rotation.

    Examples
    --------
    >>> to_quaternion([[1, 0, 0], [0, -1, 0], [0, 0, -1]])  # omega = pi
    array([0., 1., 0., 0.])
    """
    M = check.rotation(M, tolerance)
    xx, yy, zz = M[..., 0, 0], M[..., 1, 1], M[..., 2, 2]
    wx, wy, wz = (
        M[..., 1, 2] - M[..., 2, 1],
        M[..., 2, 0] - M[..., 0, 2],
        M[..., 0, 1] - M[..., 1, 0],
    )
    xy, xz, yz = (
        M[..., 0, 1] + M[..., 1, 0],
        M[..., 0, 2] + M[..., 2, 0],
        M[..., 1, 2] + M[..., 2, 1],
    )
    # Four times the products of the elements; the row of the largest one is divided
    # by a number that cannot be small, whatever the rotation
    products = np.array(
        [
            [1 + xx + yy + zz, wx, wy, wz],
            [wx, 1 + xx - yy - zz, xy, xz],
            [wy, xy, 1 - xx + yy - zz, yz],
            [wz, xz, yz, 1 - xx - yy + zz],
        ]
    )
    largest = np.argmax(np.einsum("ii...->i...", products), axis=0)
    q = np.take_along_axis(products, largest[None, None], axis=0)[0]
    q = np.moveaxis(q / np.linalg.norm(q, axis=0), 0, -1)
    return np.where(q[..., :1] < 0, -q, q)


def from_rodrigues(vector: ArrayLike) -> np.ndarray:
    """Rotation matrix of a Rodrigues vector (a, b, c) = 2 tan(angle / 2) axis.

    It turns the camera, as omega, phi, kappa do: (0, 0, 2 tan(kappa / 2)) is kappa.
    The formula of Muliawan gives the matrix from image to object: its transpose.
    OpenCV's vector is another: angle times axis.

    Parameters
    ----------
    vector : array_like (..., 3)
        (a, b, c), no unit.

    Returns
    -------
    ndarray (..., 3, 3)
        Object space into image space.

    Raises
    ------
    ValueError
        If the last axis is not 3 long, or a number is not finite.

    References
    ----------
    Muliawan 2013, (M 2.14), transposed.

    Examples
    --------
    >>> from_rodrigues([0.0, 0.0, 1.0]).round(2)  # kappa = 2 arctan(1/2)
    array([[ 0.6,  0.8,  0. ],
           [-0.8,  0.6,  0. ],
           [ 0. ,  0. ,  1. ]])
    """
    vector = _validate.points(vector, 3, "vector")
    q = np.concatenate([np.ones_like(vector[..., :1]), vector / 2], axis=-1)
    # Divided by the largest first: the square of a huge number would overflow
    q = q / np.abs(q).max(axis=-1, keepdims=True)
    return from_quaternion(q / np.linalg.norm(q, axis=-1, keepdims=True))


def to_rodrigues(M: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Rodrigues vector (a, b, c) = 2 tan(angle / 2) axis of a rotation matrix.

    Parameters
    ----------
    M : array_like (..., 3, 3)
        Rotation matrices, object space into image space.
    tolerance : float
        Largest |M Mᵀ - I| that is accepted.

    Returns
    -------
    ndarray (..., 3)

    Raises
    ------
    ValueError
        If M is not a rotation, or turns by 180 degrees: the tangent is infinite.

    Examples
    --------
    >>> to_rodrigues(from_rodrigues([0.1, -0.2, 0.3])).round(12)
    array([ 0.1, -0.2,  0.3])
    """
    q = to_quaternion(M, tolerance)
    half_turn = q[..., 0] < HALF_TURN
    if np.any(half_turn):
        raise ValueError(
            f"{check.which(half_turn)} turns by 180 degrees and has no Rodrigues vector"
            " (the tangent is infinite); use to_quaternion"
        )
    return 2 * q[..., 1:] / q[..., :1]


def angle_between(first: ArrayLike, second: ArrayLike) -> np.ndarray | float:
    """Angle in radians by which one camera must be turned to stand as another.

    Parameters
    ----------
    first, second : array_like (..., 3, 3)
        Rotation matrices, object space into image space; they broadcast.

    Examples
    --------
    >>> turned = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]
    >>> print(f"{angle_between(turned, np.eye(3)):.3f} rad")
    0.927 rad
    """
    second = np.swapaxes(check.rotation(second, 1e-6, "second"), -1, -2)
    q = to_quaternion(check.rotation(first, 1e-6, "first") @ second)
    return 2 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), q[..., 0])
