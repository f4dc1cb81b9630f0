"""Rotations about three axes in turn: omega, phi, kappa and tilt, azimuth, swing."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.rotation import check

# Below this cosine (or sine) of the middle angle the two others are not told apart.
SINGULAR = 1e-10


def matrix(omega: ArrayLike, phi: ArrayLike, kappa: ArrayLike) -> np.ndarray:
    """Rotation matrix of omega, phi, kappa: object space into image space.

    First omega turns about x, then phi about the new y, then kappa about the new z.

    Parameters
    ----------
    omega, phi, kappa : array_like
        Angles in radians; they broadcast against each other.

    Returns
    -------
    ndarray (..., 3, 3)
        M = M_kappa M_phi M_omega.

    Raises
    ------
    ValueError
        If an angle is not finite, or the shapes do not fit.

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
    return M + 0.0  # no zero printed as -0


def derivatives(omega: ArrayLike, phi: ArrayLike, kappa: ArrayLike) -> np.ndarray:
    """Derivatives of `matrix` by its three angles.

    Parameters
    ----------
    omega, phi, kappa : array_like
        Angles in radians; they broadcast against each other.

    Returns
    -------
    ndarray (..., 3, 3, 3)
        [..., k, :, :] is dM by omega, phi, kappa for k = 0, 1, 2.

    Raises
    ------
    ValueError
        If an angle is not finite, or the shapes do not fit.

    Examples
    --------
    >>> derivatives(0.0, 0.0, 0.0)[2]  # by kappa
    array([[ 0.,  1.,  0.],
           [-1.,  0.,  0.],
           [ 0.,  0.,  0.]])
    """
    M = matrix(omega, phi, kappa)
    kappa = _validate.finite(kappa, "kappa")[..., None]
    sk, ck = np.sin(kappa), np.cos(kappa)
    dM = np.zeros((*M.shape[:-2], 3, 3, 3))
    # By omega: M_omega stands to the right, so columns change places
    dM[..., 0, :, 1], dM[..., 0, :, 2] = -M[..., 2], M[..., 1]
    # By phi: the third row goes into the first two, and they into the third
    first, second, third = M[..., 0, :], M[..., 1, :], M[..., 2, :]
    dM[..., 1, 0, :], dM[..., 1, 1, :] = -ck * third, sk * third
    dM[..., 1, 2, :] = ck * first - sk * second
    # By kappa: M_kappa stands to the left, so rows change places
    dM[..., 2, 0, :], dM[..., 2, 1, :] = second, -first
    return dM + 0.0


def small_angle(omega: ArrayLike, phi: ArrayLike, kappa: ArrayLike) -> np.ndarray:
    """Unit matrix plus first-order change: `matrix` for very small angles, (..., 3, 3).

    It is no rotation: lengths grow by half the squared angle. Angles in radians.

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
    """Angles omega, phi, kappa of a rotation matrix.

    phi lies between -pi/2 and pi/2, the others between -pi and pi. Where cos(phi) = 0
    (gimbal lock, see `is_gimbal`), only omega + kappa (phi = pi/2) or omega - kappa
    (phi = -pi/2) is fixed: kappa is then set to 0, and a warning says so.

    Parameters
    ----------
    M : array_like (..., 3, 3)
        Rotation matrices, object space into image space.
    tolerance : float
        Largest |M Mᵀ - I| that is accepted; printed matrices need more.

    Returns
    -------
    ndarray (..., 3)
        (omega, phi, kappa) in radians; `matrix` of them gives M again, always.

    Raises
    ------
    ValueError
        If M is not a rotation.

    References
    ----------
    Muliawan 2013, (M 2.10), with the quadrant settled.

    Examples
    --------
    >>> angles(matrix(2.0, 0.5, -3.0)).round(12)
    array([ 2. ,  0.5, -3. ])
    """
    M = check.rotation(M, tolerance)
    locked = np.hypot(M[..., 0, 0], M[..., 1, 0]) < SINGULAR
    check.ambiguous(locked, "gimbal lock", "omega and kappa", "kappa is set to 0")
    phi = np.arctan2(M[..., 2, 0], np.hypot(M[..., 0, 0], M[..., 1, 0]))
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
    """Whether cos(phi) is below `cosine`, so that omega and kappa are not told apart.

    Parameters
    ----------
    M : array_like (..., 3, 3)
        Rotation matrices, object space into image space.
    tolerance : float
        Largest |M Mᵀ - I| that is accepted.
    cosine : float
        Limit of cos(phi).

    Returns
    -------
    ndarray (...) of bool

    Raises
    ------
    ValueError
        If M is not a rotation.

    Examples
    --------
    >>> print(is_gimbal(matrix(0.3, np.pi / 2, 0.1)))
    True
    """
    cosine = _validate.not_negative(cosine, "cosine", "of phi")
    M = check.rotation(M, tolerance)
    return np.hypot(M[..., 0, 0], M[..., 1, 0]) < cosine


def from_tilt_azimuth_swing(
    tilt: ArrayLike, azimuth: ArrayLike, swing: ArrayLike
) -> np.ndarray:
    """Rotation matrix of tilt, azimuth, swing: object space into image space.

    Parameters
    ----------
    tilt, azimuth, swing : array_like
        Radians, broadcasting. The tilt is the angle between the camera axis and the
        vertical. The azimuth is that of the principal line, clockwise from the Y axis.
        The swing leads, clockwise in the photo, from its y axis to the nadir point.

    Returns
    -------
    ndarray (..., 3, 3)
        The same M as `matrix` gives for the same camera.

    Raises
    ------
    ValueError
        If an angle is not finite, or the shapes do not fit.

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
    # Turn by the azimuth about Z, tip by the tilt about x, turn by the swing about z
    upright = matrix(0.0, 0.0, -azimuth)
    tipped = matrix(tilt, 0.0, 0.0)
    return matrix(0.0, 0.0, swing - np.pi) @ tipped @ upright


def to_tilt_azimuth_swing(M: ArrayLike, tolerance: float = 1e-6) -> np.ndarray:
    """Tilt, azimuth, swing of a rotation matrix.

    The tilt lies between 0 and pi, the others between -pi and pi. Where sin(tilt) = 0
    (a vertical photo), only swing - azimuth (tilt 0) or swing + azimuth (tilt pi) is
    fixed: the swing is then set to pi, and a warning says so. The azimuth is then that
    of the photo's y axis.

    Parameters
    ----------
    M : array_like (..., 3, 3)
        Rotation matrices, object space into image space.
    tolerance : float
        Largest |M Mᵀ - I| that is accepted.

    Returns
    -------
    ndarray (..., 3)
        (tilt, azimuth, swing) in radians.

    Raises
    ------
    ValueError
        If M is not a rotation.

    Examples
    --------
    >>> to_tilt_azimuth_swing(from_tilt_azimuth_swing(0.1, 2.0, -1.0)).round(12)
    array([ 0.1,  2. , -1. ])
    """
    M = check.rotation(M, tolerance)
    vertical = np.hypot(M[..., 0, 2], M[..., 1, 2]) < SINGULAR
    check.ambiguous(
        vertical, "vertical photo", "azimuth and swing", "the swing is set to pi"
    )
    tilt = np.arctan2(np.hypot(M[..., 0, 2], M[..., 1, 2]), M[..., 2, 2])
    swing = np.where(vertical, np.pi, np.arctan2(-M[..., 0, 2], -M[..., 1, 2]))
    # (-cos azimuth, sin azimuth, 0), full size even for a small tilt
    sin, cos = np.sin(swing)[..., None], np.cos(swing)[..., None]
    row = cos * M[..., 0, :] - sin * M[..., 1, :]
    azimuth = np.arctan2(row[..., 1], -row[..., 0])
    return np.stack([tilt, azimuth, swing], axis=-1)


def _angles(**angles: ArrayLike) -> list[np.ndarray]:
    """Angles as float arrays of one common shape."""
    arrays = [_validate.finite(value, name) for name, value in angles.items()]
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ValueError(
            f"{', '.join(angles)} must broadcast against each other;"
            f" got shapes {shapes}"
        ) from None
