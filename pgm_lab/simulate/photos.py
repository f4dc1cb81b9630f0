"""Photos of known and unknown points, with cameras in any attitude."""

import numpy as np

from pgm_lab import _validate, camera, rotation
from pgm_lab.camera import Camera

TRIES = 10_000  # some seconds; thirty points and 35 mm need a tenth of them
MOST = 10**6  # points of a photo


def rotations(rng: np.random.Generator, n: int) -> np.ndarray:
    """Rotation matrices (n, 3, 3), uniformly distributed over all attitudes.

    Examples
    --------
    >>> rotations(np.random.default_rng(1), 4).shape
    (4, 3, 3)
    """
    _validate.instance(rng, np.random.Generator, "rng")
    n = _validate.whole(n, "n", 1, MOST)
    q = rng.normal(size=(n, 4))
    return rotation.from_quaternion(q / np.linalg.norm(q, axis=1, keepdims=True))


def control_photo(
    lens: camera.Camera,
    n: int,
    rng: np.random.Generator,
    flat: bool = False,
    sigma: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Photo of n known points from any side, with the camera in any attitude.

    The points lie in a box of 60 x 60 x 30 units, 80 to 200 units away, and within
    20 mm of the image centre. Attitudes near the gimbal lock are left out.

    Parameters
    ----------
    lens : camera.Camera
    n : int
        Number of points.
    rng : numpy.random.Generator
        Source of the random numbers.
    flat : bool
        All points in one plane.
    sigma : float
        Standard deviation of the image coordinates, in mm.

    Returns
    -------
    exterior : ndarray (6,)
    points : ndarray (n, 3)
    image : ndarray (n, 2)
        With errors, in mm.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> exterior, points, image = control_photo(camera.Camera(35.0), 5, rng)
    >>> np.allclose(image, camera.project(camera.Camera(35.0), exterior, points))
    True
    """
    n, flat, sigma = _checked(lens, n, rng, flat, sigma)
    for _ in range(TRIES):
        turn, M = rotations(rng, 2)
        points = rng.uniform(-30, 30, (n, 3)) * [1, 1, 0 if flat else 0.5] @ turn
        centre = M.T @ [*rng.uniform(-10, 10, 2), rng.uniform(80, 200)]
        near = -(points - centre) @ M[2] < 20
        if np.any(near) or rotation.is_gimbal(M, cosine=0.01):
            continue
        exterior = np.concatenate([centre, rotation.angles(M)])
        image = camera.project(lens, exterior, points)
        if np.abs(image).max() < 20:
            return exterior, points, image + sigma * rng.normal(size=image.shape)
    raise ValueError(_does_not_fit(lens, n))


def pair(
    lens: camera.Camera,
    n: int,
    rng: np.random.Generator,
    flat: bool = False,
    sigma: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two photos of the same unknown points; the left one at the origin, zero angles.

    The right photo stands one unit to the right, up to half a unit higher or lower, and
    is turned by up to 30 degrees, about its axis by any angle. The points lie 1.5 to 4
    units away, within 20 mm of both image centres.

    Parameters
    ----------
    lens : camera.Camera
        Took both photos.
    n : int
        Number of points.
    rng : numpy.random.Generator
        Source of the random numbers.
    flat : bool
        All points in one plane.
    sigma : float
        Standard deviation of the image coordinates, in mm.

    Returns
    -------
    exterior : ndarray (6,)
        (1, by, bz, omega, phi, kappa) of the right photo.
    left, right : ndarray (n, 2)
        Image points with errors, in mm.

    Examples
    --------
    >>> truth, left, right = pair(camera.Camera(35.0), 6, np.random.default_rng(1))
    >>> print(truth[0], left.shape, right.shape)
    1.0 (6, 2) (6, 2)
    """
    n, flat, sigma = _checked(lens, n, rng, flat, sigma)
    for _ in range(TRIES):
        angles = [*rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi)]
        exterior = np.array([1.0, *rng.uniform(-0.5, 0.5, 2), *angles])
        distance = rng.uniform(1.5, 4)
        points = rng.uniform(-0.5, 0.5, (n, 3)) * distance * [1, 1, 0 if flat else 0.5]
        omega, phi = rng.uniform(-0.5, 0.5, 2)
        tilt = rotation.matrix(omega, phi, 0.0)
        points = points @ tilt + [0.5, 0, -distance]
        M = rotation.matrix(*angles)
        if np.any(points[:, 2] > -0.5) or np.any((points - exterior[:3]) @ M[2] > -0.5):
            continue
        image = camera.project(lens, np.array([np.zeros(6), exterior])[:, None], points)
        if np.abs(image).max() < 20:
            left, right = image + sigma * rng.normal(size=image.shape)
            return exterior, left, right
    raise ValueError(_does_not_fit(lens, n))


def _checked(
    lens: Camera, n: int, rng: np.random.Generator, flat: bool, sigma: float
) -> tuple[int, bool, float]:
    _validate.instance(lens, Camera, "lens")
    _validate.instance(rng, np.random.Generator, "rng")
    n = _validate.whole(n, "n", 1, MOST)
    flat = _validate.flag(flat, "flat")
    return n, flat, _validate.not_negative(sigma, "sigma", "mm")


def _does_not_fit(lens: Camera, n: int) -> str:
    return (
        f"lens and n: in {TRIES} tries no photo showed all {n} points within 20 mm of"
        f" its centre with c = {lens.c:g} mm; take a shorter principal distance, less"
        " distortion or fewer points"
    )


def rough(
    exterior: np.ndarray, rng: np.random.Generator, degrees: float, share: float
) -> np.ndarray:
    """Exterior orientation that is wrong by an angle and by a share of its distance.

    Parameters
    ----------
    exterior : ndarray (6,)
        (X0, Y0, Z0, omega, phi, kappa); the distance counts from the origin.
    rng : numpy.random.Generator
        Source of the random directions.
    degrees : float
        Angle by which the camera is turned, about any axis.
    share : float
        Distance by which it is moved, in any direction, over its own from the origin.

    Returns
    -------
    ndarray (6,)

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> start = rough(np.array([0, 0, 10.0, 0, 0, 0]), rng, degrees=30, share=0.5)
    >>> print(np.linalg.norm(start[:3] - [0, 0, 10]).round(6))
    5.0
    """
    _validate.instance(rng, np.random.Generator, "rng")
    exterior = _validate.one_point(exterior, 6, "exterior")
    degrees = _validate.number(degrees, "degrees")
    share = _validate.number(share, "share")
    if not -180 < degrees < 180:
        raise ValueError(f"degrees must lie between -180 and 180; got {degrees:g}")
    axis, aside = rng.normal(size=(2, 3))
    vector = 2 * np.tan(np.radians(degrees) / 2) * axis / np.linalg.norm(axis)
    M = rotation.from_rodrigues(vector) @ rotation.matrix(*exterior[3:])
    away = share * np.linalg.norm(exterior[:3]) * aside / np.linalg.norm(aside)
    return np.concatenate([exterior[:3] + away, rotation.angles(M)])
