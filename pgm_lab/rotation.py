"""Rotation matrices: from object space into image space, and every way to write them.

`matrix` gives M = M_kappa M_phi M_omega. It rotates a vector of object space into the
image space of a camera that looks along its negative z axis: (U, V, W) = M (X - X0).
The rows of M are the camera's axes in object space. Angles are in radians; a positive
one rotates the camera counter-clockwise as seen from the tip of the axis. Rodrigues
vectors and quaternions have the same sense.

All functions take stacks: leading axes (...) broadcast. A matrix that is not a
rotation, or any other argument that is not as described, raises ValueError.
"""

import warnings

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate

__all__ = [
    "angle_between",
    "angles",
    "best_fit",
    "defect",
    "derivatives",
    "from_quaternion",
    "from_rodrigues",
    "from_tilt_azimuth_swing",
    "is_gimbal",
    "matrix",
    "nearest",
    "small_angle",
    "to_quaternion",
    "to_rodrigues",
    "to_tilt_azimuth_swing",
]

# Below this cosine (or sine) of the middle angle the two others cannot be separated.
SINGULAR = 1e-10

# cos(angle / 2) below which a rotation counts as one by 180 degrees.
HALF_TURN = 1e-9


# --- Omega, phi, kappa ---


def matrix(omega: ArrayLike, phi: ArrayLike, kappa: ArrayLike) -> np.ndarray:
    """Rotation matrix M = M_kappa M_phi M_omega, (..., 3, 3), of omega, phi, kappa.

    It rotates object space into image space: first omega rotates about x, then phi
    about the new y, then kappa about the new z.

    Parameters
    ----------
    omega, phi, kappa : array_like
        Angles in radians; they broadcast against each other.

    References
    ----------
    Muliawan 2013, (M 2.2) to (M 2.9), transposed (M 2.56) to (M 2.62); Bani 2010,
    (B 2), (B 3). In (M 2.62) and (B 3) elements are misprinted.

    Examples
    --------
    >>> matrix(0.0, 0.0, np.radians(30)).round(3)
    array([[ 0.866,  0.5  ,  0.   ],
           [-0.5  ,  0.866,  0.   ],
           [ 0.   ,  0.   ,  1.   ]])
    """
    omega, phi, kappa = _angles(omega=omega, phi=phi, kappa=kappa)
    so, sp, sk = np.sin(omega), np.sin(phi), np.sin(kappa)
    co, cp, ck = np.cos(omega), np.cos(phi), np.cos(kappa)
    M = np.empty((*omega.shape, 3, 3))
    M[..., 0, 0] = cp * ck
    M[..., 0, 1] = so * sp * ck + co * sk
    M[..., 0, 2] = -co * sp * ck + so * sk
    M[..., 1, 0] = -cp * sk
    M[..., 1, 1] = -so * sp * sk + co * ck
    M[..., 1, 2] = co * sp * sk + so * ck
    M[..., 2, 0] = sp
    M[..., 2, 1] = -so * cp
    M[..., 2, 2] = co * cp
    return M + 0.0  # so that no zero prints as -0


def derivatives(omega: ArrayLike, phi: ArrayLike, kappa: ArrayLike) -> np.ndarray:
    """Derivatives (..., 3, 3, 3) of `matrix` with respect to its three angles.

    [..., k, :, :] is dM by omega, phi, kappa for k = 0, 1, 2; arguments are those
    of `matrix`.

    Examples
    --------
    >>> derivatives(0.0, 0.0, 0.0)[2]  # by kappa
    array([[ 0.,  1.,  0.],
           [-1.,  0.,  0.],
           [ 0.,  0.,  0.]])
    """
    M = matrix(omega, phi, kappa)
    kappa = np.asarray(kappa, dtype=float)[..., None]
    sk, ck = np.sin(kappa), np.cos(kappa)
    first, second, third = M[..., 0, :], M[..., 1, :], M[..., 2, :]
    dM = np.zeros((*M.shape[:-2], 3, 3, 3))
    # By omega: M_omega is the right factor, so columns change places
    dM[..., 0, :, 1], dM[..., 0, :, 2] = -M[..., 2], M[..., 1]
    # By phi: the third row goes into the first two, and they into the third
    dM[..., 1, 0, :], dM[..., 1, 1, :] = -ck * third, sk * third
    dM[..., 1, 2, :] = ck * first - sk * second
    # By kappa: M_kappa is the left factor, so rows change places
    dM[..., 2, 0, :], dM[..., 2, 1, :] = second, -first
    return dM + 0.0


def small_angle(omega: ArrayLike, phi: ArrayLike, kappa: ArrayLike) -> np.ndarray:
    """Unit matrix plus first-order change: `matrix` for very small angles, (..., 3, 3).

    It is not a rotation: lengths grow by half the squared angle. Angles in radians.

    Examples
    --------
    >>> small_angle(0.01, 0.02, 0.03)
    array([[ 1.  ,  0.03, -0.02],
           [-0.03,  1.  ,  0.01],
           [ 0.02, -0.01,  1.  ]])
    """
    angles = np.stack(_angles(omega=omega, phi=phi, kappa=kappa), axis=-1)
    return np.eye(3) + np.tensordot(angles, derivatives(0.0, 0.0, 0.0), axes=1)


def angles(M: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Angles (omega, phi, kappa), (..., 3) in radians, of a rotation matrix.

    phi lies between -pi/2 and pi/2, the others between -pi and pi. Where cos(phi) = 0
    (gimbal lock, see `is_gimbal`), only omega + kappa (phi = pi/2) or omega - kappa
    (phi = -pi/2) is fixed: kappa is then set to 0, and a warning says so. `matrix` of
    the angles gives M again, always.

    Parameters
    ----------
    M : array_like (..., 3, 3)
        Rotation matrices, object space into image space.
    tolerance : float
        Largest |M Mᵀ - I| that is accepted; printed matrices need more.

    References
    ----------
    Muliawan 2013, (M 2.10), with the quadrant resolved.

    Examples
    --------
    >>> angles(matrix(2.0, 0.5, -3.0)).round(12)
    array([ 2. ,  0.5, -3. ])
    """
    M = _rotation(M, tolerance)
    cosine = np.hypot(M[..., 0, 0], M[..., 1, 0])
    locked = cosine < SINGULAR
    _warn_ambiguous(locked, "gimbal lock", "omega and kappa", "kappa is set to 0")
    phi = np.arctan2(M[..., 2, 0], cosine)
    kappa = np.where(locked, 0.0, np.arctan2(-M[..., 1, 0], M[..., 0, 0]))
    # (0, cos omega, sin omega), the second row of M_kappa' M: full size even where
    # (M 2.10) would divide two tiny numbers
    sk, ck = np.sin(kappa)[..., None], np.cos(kappa)[..., None]
    row = sk * M[..., 0, :] + ck * M[..., 1, :]
    omega = np.arctan2(row[..., 2], row[..., 1])
    return np.stack([omega, phi, kappa], axis=-1)


def is_gimbal(
    M: ArrayLike, tolerance: float = 1e-6, cosine: float = SINGULAR
) -> np.ndarray:
    """Whether cos(phi) is below `cosine`, so that omega and kappa cannot be separated.

    M and tolerance are those of `angles`.

    Examples
    --------
    >>> print(is_gimbal(matrix(0.3, np.pi / 2, 0.1)))
    True
    """
    cosine = _validate.not_negative(cosine, "cosine", "of phi")
    M = _rotation(M, tolerance)
    return np.hypot(M[..., 0, 0], M[..., 1, 0]) < cosine


# --- Tilt, azimuth, swing ---


def from_tilt_azimuth_swing(
    tilt: ArrayLike, azimuth: ArrayLike, swing: ArrayLike
) -> np.ndarray:
    """Rotation matrix (..., 3, 3) of tilt, azimuth, swing, object to image.

    Parameters
    ----------
    tilt, azimuth, swing : array_like
        In radians; they broadcast. The tilt is the angle between the camera axis and
        the vertical. The azimuth is that of the principal line, clockwise from the Y
        axis. The swing is the clockwise angle in the photo from its y axis to the nadir
        point.

    References
    ----------
    Muliawan 2013, (M 2.13).

    Examples
    --------
    >>> from_tilt_azimuth_swing(0.0, 0.0, np.pi).round(12) + 0.0
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    tilt, azimuth, swing = _angles(tilt=tilt, azimuth=azimuth, swing=swing)
    # Rotate by the azimuth about Z, the tilt about x, the swing about z
    upright = matrix(0.0, 0.0, -azimuth)
    tipped = matrix(tilt, 0.0, 0.0)
    return matrix(0.0, 0.0, swing - np.pi) @ tipped @ upright


def to_tilt_azimuth_swing(M: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Tilt, azimuth, swing (..., 3) of a rotation matrix, in radians.

    The tilt lies between 0 and pi, the others between -pi and pi. Where sin(tilt) = 0
    (a vertical photo), only swing - azimuth (tilt 0) or swing + azimuth (tilt pi) is
    fixed: the swing is then set to pi, and a warning says so. The azimuth is then that
    of the photo's y axis. M and tolerance are those of `angles`.

    Examples
    --------
    >>> to_tilt_azimuth_swing(from_tilt_azimuth_swing(0.1, 2.0, -1.0)).round(12)
    array([ 0.1,  2. , -1. ])
    """
    M = _rotation(M, tolerance)
    sine = np.hypot(M[..., 0, 2], M[..., 1, 2])
    vertical = sine < SINGULAR
    _warn_ambiguous(
        vertical, "vertical photo", "azimuth and swing", "the swing is set to pi"
    )
    tilt = np.arctan2(sine, M[..., 2, 2])
    swing = np.where(vertical, np.pi, np.arctan2(-M[..., 0, 2], -M[..., 1, 2]))
    # (-cos azimuth, sin azimuth, 0), full size even for a small tilt
    sin, cos = np.sin(swing)[..., None], np.cos(swing)[..., None]
    row = cos * M[..., 0, :] - sin * M[..., 1, :]
    azimuth = np.arctan2(row[..., 1], -row[..., 0])
    return np.stack([tilt, azimuth, swing], axis=-1)


# --- One axis: quaternions and Rodrigues vectors ---


def from_quaternion(quaternion: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Rotation matrix (..., 3, 3) of a unit quaternion (w, x, y, z), the scalar first.

    It rotates the camera, as omega, phi, kappa do: (cos(a/2), 0, 0, sin(a/2)) is
    kappa = a. A quaternion and its negative give the same matrix.

    Parameters
    ----------
    quaternion : array_like (..., 4)
        (w, x, y, z), of length 1.
    tolerance : float
        Largest difference of the length from 1 that is accepted and then removed.

    Examples
    --------
    >>> from_quaternion([0.6, 0.0, 0.0, 0.8]).round(2)  # kappa = 2 arctan(4/3)
    array([[-0.28,  0.96,  0.  ],
           [-0.96, -0.28,  0.  ],
           [ 0.  ,  0.  ,  1.  ]])
    """
    tolerance = _validate.not_negative(tolerance, "tolerance", "of the length")
    q = _validate.finite(quaternion, "quaternion")
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
    """Unit quaternion (..., 4), (w, x, y, z) with w >= 0, of a rotation matrix.

    M and tolerance are those of `angles`.

    Examples
    --------
    >>> to_quaternion([[1, 0, 0], [0, -1, 0], [0, 0, -1]])  # omega = pi
    array([0., 1., 0., 0.])
    """
    M = _rotation(M, tolerance)
    xx, yy, zz = M[..., 0, 0], M[..., 1, 1], M[..., 2, 2]
    wx, wy, wz = (M[..., i, j] - M[..., j, i] for i, j in ((1, 2), (2, 0), (0, 1)))
    xy, xz, yz = (M[..., i, j] + M[..., j, i] for i, j in ((0, 1), (0, 2), (1, 2)))
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
    """Rotation matrix (..., 3, 3) of a Rodrigues vector 2 tan(angle / 2) axis.

    It rotates the camera, as omega, phi, kappa do: (0, 0, 2 tan(kappa / 2)) is kappa.
    (OpenCV's vector is another: angle times axis.)

    Parameters
    ----------
    vector : array_like (..., 3)
        (a, b, c), without unit.

    References
    ----------
    Muliawan 2013, (M 2.14), transposed: his matrix is from image to object.

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
    """Rodrigues vector (..., 3), 2 tan(angle / 2) axis, of a rotation matrix.

    M and tolerance are those of `angles`. A rotation by 180 degrees has none:
    ValueError.

    Examples
    --------
    >>> to_rodrigues(from_rodrigues([0.1, -0.2, 0.3])).round(12)
    array([ 0.1, -0.2,  0.3])
    """
    q = to_quaternion(M, tolerance)
    half_turn = q[..., 0] < HALF_TURN
    if np.any(half_turn):
        raise ValueError(
            f"{_which(half_turn)} rotates by 180 degrees and has no Rodrigues vector"
            " (the tangent is infinite); use to_quaternion"
        )
    return 2 * q[..., 1:] / q[..., :1]


def angle_between(first: ArrayLike, second: ArrayLike) -> np.ndarray | float:
    """Angle in radians of the rotation from one attitude to another.

    Parameters
    ----------
    first, second : array_like (..., 3, 3)
        Rotation matrices, object space into image space; they broadcast.

    Examples
    --------
    >>> rotated = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]
    >>> print(f"{angle_between(rotated, np.eye(3)):.3f} rad")
    0.927 rad
    """
    second = np.swapaxes(_rotation(second, 1e-6, "second"), -1, -2)
    q = to_quaternion(_rotation(first, 1e-6, "first") @ second)
    return 2 * np.arctan2(np.linalg.norm(q[..., 1:], axis=-1), q[..., 0])


# --- Is it a rotation, and which is the nearest? ---


def defect(M: ArrayLike) -> np.ndarray | float:
    """Largest element of |M Mᵀ - I|: how far a matrix is from being orthogonal.

    A reflection has no defect either; its determinant is -1.

    References
    ----------
    (M 2.11), (M 2.12).

    Examples
    --------
    >>> print(f"{defect([[1, 0, 0], [0, 1, 0.1], [0, 0, 1]]):.2f}")
    0.10
    """
    M = _square(M)
    return np.abs(M @ np.swapaxes(M, -1, -2) - np.eye(3)).max(axis=(-2, -1))


def nearest(M: ArrayLike) -> np.ndarray:
    """Rotation nearest to a matrix: the sum of squared differences is smallest.

    A matrix that mirrors or flattens space has none: ValueError.

    Examples
    --------
    >>> nearest([[0.7, 0.9, 0.0], [-0.9, 0.7, 0.0], [0.0, 0.0, 1.0]]).round(3) + 0.0
    array([[ 0.614,  0.789,  0.   ],
           [-0.789,  0.614,  0.   ],
           [ 0.   ,  0.   ,  1.   ]])
    """
    M = _square(M)
    bad = np.linalg.det(M) <= 0
    if np.any(bad):
        raise ValueError(
            f"the determinant of {_which(bad)} is not positive: the matrix mirrors or"
            " flattens space, and no rotation is near. Check the sign of each row and"
            " column"
        )
    return best_fit(M)[0]


def best_fit(product: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Rotation R for which R s comes nearest to t, summed over pairs of vectors.

    Parameters
    ----------
    product : array_like (..., 3, 3)
        Sum of t s' over the pairs, with their weights if they have any.

    Returns
    -------
    R : ndarray (..., 3, 3)
        The rotation with the least sum of |t - R s|^2.
    singular : ndarray (..., 3)
        Singular values of the product, the largest first; their sum is that of all
        tᵀ R s. The last is negative if a reflection would come nearer.

    References
    ----------
    Umeyama 1991, "Least-squares estimation of transformation parameters between two
    point patterns", IEEE PAMI 13(4).

    Examples
    --------
    >>> source = np.eye(3)
    >>> target = source @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]  # kappa = 90 degrees
    >>> best_fit(target.T @ source)[0] @ [1.0, 0.0, 0.0]
    array([0., 1., 0.])
    """
    U, singular, Vt = np.linalg.svd(_square(product, "product"))
    sign = np.sign(np.linalg.det(U @ Vt))
    U[..., -1] *= sign[..., None]
    singular[..., -1] *= sign
    return U @ Vt, singular


# --- Argument validation ---


def _angles(**angles: ArrayLike) -> list[np.ndarray]:
    """Angles as float arrays of one common shape."""
    arrays = [_validate.finite(value, name) for name, value in angles.items()]
    return list(np.broadcast_arrays(*arrays))


def _square(M: ArrayLike, name: str = "M") -> np.ndarray:
    M = _validate.finite(M, name)
    if M.shape[-2:] != (3, 3):
        raise ValueError(f"{name} must have shape (..., 3, 3); got shape {M.shape}")
    return M


def _rotation(M: ArrayLike, tolerance: float, name: str = "M") -> np.ndarray:
    """M as a float array, if all its matrices are rotations."""
    M = _square(M, name)
    tolerance = _validate.not_negative(tolerance, "tolerance", "of elements of M")
    size = defect(M)
    if np.any(size > tolerance):
        raise ValueError(
            f"{_which(size > tolerance, name)} is not a rotation: |{name} {name}' - I|"
            f" reaches {np.max(size):.2g}, more than {tolerance:g}. For a matrix copied"
            " from print, set the tolerance to a few units of its last digit, or use"
            " nearest(M)"
        )
    mirror = np.linalg.det(M) < 0
    if np.any(mirror):
        raise ValueError(
            f"{_which(mirror, name)} is not a rotation but a reflection: its"
            " determinant is -1. Reverse the sign of one axis; y or z may point the"
            " other way"
        )
    return M


def _which(bad: np.ndarray | bool, name: str = "M") -> str:
    """Name of the first bad matrix, and how many there are."""
    if np.ndim(bad) == 0:
        return name
    first = ", ".join(str(i) for i in np.argwhere(bad)[0])
    return f"{name}[{first}] (one of {np.sum(bad)})"


def _warn_ambiguous(where: np.ndarray, case: str, pair: str, choice: str) -> None:
    """Warn that two angles of some matrices cannot be separated, and what is chosen."""
    if np.any(where):
        warnings.warn(
            f"{case}: {pair} of {_which(where)} cannot be separated; {choice}",
            RuntimeWarning,
            stacklevel=3,
        )
