"""Images and photos with exactly known truth, for tests and experiments."""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from pgm_lab import _validate, camera, rotation

# Grey values are integrated over each pixel by Gauss-Legendre quadrature: five nodes a
# side leave less than 1e-3 of a grey value for a blur of half a pixel and more.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


def target(
    centre: ArrayLike,
    diameter: float = 10.0,
    shape: tuple[int, int] = (21, 21),
    foreground: float = 200.0,
    background: float = 40.0,
    blur: float = 0.7,
) -> np.ndarray:
    """Images of circular targets with exactly known centres, without noise.

    A disc with a soft edge, integrated over the area of each pixel. The edge falls from
    foreground to background as the distribution function of a normal distribution with
    the standard deviation `blur`, so the centre is exact by symmetry.

    Parameters
    ----------
    centre : array_like (..., 2)
        (column, row) of the centres in pixels, integers at pixel centres.
    diameter : float
        Diameter of the disc at half height, in pixels. Below four times the blur the
        profile has a peak that the quadrature over the pixel misses a little.
    shape : (rows, columns)
        Shape of each image.
    foreground, background : float
        Grey values inside and outside; a dark target has foreground < background.
    blur : float
        Width of the edge (standard deviation), in pixels; at least 0.3.

    Returns
    -------
    ndarray (..., rows, columns)
        Grey values, not rounded.

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite, or the edge is too sharp for the
        quadrature.

    Examples
    --------
    >>> image = target((10.25, 9.5), diameter=8)
    >>> image.shape
    (21, 21)
    >>> print(f"{image.max():.1f}")
    200.0
    """
    centre = _validate.points(centre, 2, "centre")
    diameter = float(_validate.positive(diameter, "diameter", "px"))
    if _validate.number(blur, "blur") < 0.3:
        raise ValueError(f"blur must be at least 0.3 px to be exact; got {blur}")
    rows, columns = shape
    nodes = _NODES / 2
    x = (np.arange(columns)[:, None] + nodes).ravel() - centre[..., None, 0]
    y = (np.arange(rows)[:, None] + nodes).ravel() - centre[..., None, 1]
    radius = np.hypot(x[..., None, :], y[..., :, None])
    profile = (1 - erf((radius - diameter / 2) / (np.sqrt(2) * blur))) / 2
    n = len(nodes)
    weights = _WEIGHTS / 2
    fine = profile.reshape(*centre.shape[:-1], rows, n, columns, n)
    disc = np.einsum("...injm,n,m->...ij", fine, weights, weights)
    return background + (foreground - background) * disc


def photograph(
    image: ArrayLike, noise: float, seed: int, bits: int | None = None
) -> np.ndarray:
    """Add normal noise to an image and, if wanted, round it as a camera does.

    Parameters
    ----------
    image : array_like
        Grey values of any shape; not changed.
    noise : float
        Standard deviation of the noise, in grey values.
    seed : int
        Seed of the random numbers: the same seed gives the same noise.
    bits : int, optional
        Round to whole grey values and clip to 0 ... 2**bits - 1. Not rounded without.

    Returns
    -------
    ndarray
        Noisy grey values as floats.

    Examples
    --------
    >>> photograph([100.0, 300.0], noise=0.0, seed=1, bits=8)
    array([100., 255.])
    """
    image = np.asarray(image, dtype=float)
    noisy = image + np.random.default_rng(seed).normal(0.0, noise, image.shape)
    return noisy if bits is None else np.clip(np.round(noisy), 0, 2**bits - 1)


def rotations(rng: np.random.Generator, n: int) -> np.ndarray:
    """Rotation matrices (n, 3, 3), uniformly distributed over all attitudes.

    Examples
    --------
    >>> rotations(np.random.default_rng(1), 4).shape
    (4, 3, 3)
    """
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
    while True:
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
    while True:
        angles = [*rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi)]
        exterior = np.array([1.0, *rng.uniform(-0.5, 0.5, 2), *angles])
        distance = rng.uniform(1.5, 4)
        points = rng.uniform(-0.5, 0.5, (n, 3)) * distance * [1, 1, 0 if flat else 0.5]
        tilt = rotation.matrix(*rng.uniform(-0.5, 0.5, 2), 0.0)
        points = points @ tilt + [0.5, 0, -distance]
        M = rotation.matrix(*exterior[3:])
        if np.any(points[:, 2] > -0.5) or np.any((points - exterior[:3]) @ M[2] > -0.5):
            continue
        image = camera.project(lens, np.array([np.zeros(6), exterior])[:, None], points)
        if np.abs(image).max() < 20:
            return exterior, *(image + sigma * rng.normal(size=image.shape))


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
    axis, aside = rng.normal(size=(2, 3))
    vector = 2 * np.tan(np.radians(degrees) / 2) * axis / np.linalg.norm(axis)
    M = rotation.from_rodrigues(vector) @ rotation.matrix(*exterior[3:])
    away = share * np.linalg.norm(exterior[:3]) * aside / np.linalg.norm(aside)
    return np.concatenate([exterior[:3] + away, rotation.angles(M)])
