"""Photos of points, with cameras in any attitude: one, two, or a whole network."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import camera, rotation
from pgm_lab.camera import Camera, imaging

TRIES = 10_000  # some seconds; thirty points and 35 mm need a tenth of them
GOLDEN_ANGLE = np.pi * (3 - 5**0.5)  # rotations by it never repeat a direction


# --- One photo, and two ---


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
    lens: Camera,
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
    >>> exterior, points, image = control_photo(Camera(35.0), 5, rng)
    >>> np.allclose(image, camera.project(Camera(35.0), exterior, points))
    True
    """
    for _ in range(TRIES):
        of_object, M = rotations(rng, 2)
        points = rng.uniform(-30, 30, (n, 3)) * [1, 1, 0 if flat else 0.5] @ of_object
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
    lens: Camera,
    n: int,
    rng: np.random.Generator,
    flat: bool = False,
    sigma: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two photos of the same unknown points; the left one at the origin, zero angles.

    The right one is one unit to the right, up to half a unit off, rotated by up to
    30 degrees, about its axis by any angle. The points are 1.5 to 4 units away, within
    20 mm of both image centres.

    Parameters
    ----------
    lens, n, rng, flat, sigma
        As in `control_photo`; the lens took both photos.

    Returns
    -------
    exterior : ndarray (6,)
        (1, by, bz, omega, phi, kappa) of the right photo.
    left, right : ndarray (n, 2)
        Image points with errors, in mm.

    Examples
    --------
    >>> truth, left, right = pair(Camera(35.0), 6, np.random.default_rng(1))
    >>> print(truth[0], left.shape, right.shape)
    1.0 (6, 2) (6, 2)
    """
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
        Rotation of the camera, about any axis; below 180.
    share : float
        Shift in any direction, relative to its distance from the origin.

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


# --- Networks for bundle adjustments ---


@dataclass(frozen=True)
class KnownNetwork:
    """A simulated network: the truth, and what was measured.

    ``bundle.Network(net.camera, net.exteriors, net.points, net.photo, net.point,
    net.xy, net.sigma)`` is the network to adjust.

    Attributes
    ----------
    camera : camera.Camera
        The true camera, which took all photos.
    exteriors : ndarray (m, 6)
        True (X0, Y0, Z0, omega, phi, kappa).
    points : ndarray (n, 3)
        True object points.
    photo, point : ndarray (k,) of int
        Indices of the rays, sorted by photo, then by point.
    xy : ndarray (k, 2)
        Measured photo coordinates, with errors; mm.
    sigma : float
        Standard deviation of these errors; mm.
    """

    camera: Camera
    exteriors: np.ndarray
    points: np.ndarray
    photo: np.ndarray
    point: np.ndarray
    xy: np.ndarray
    sigma: float


def network(
    lens: Camera,
    photos: int,
    points: int,
    rng: np.random.Generator,
    rays: float | None = None,
    *,
    convergent: bool = True,
    rolled: bool = True,
    flat: bool = False,
    block: bool = False,
    sigma: float = 0.001,
    distance: float = 2000.0,
    image_size: ArrayLike = (36.0, 24.0),
) -> KnownNetwork:
    """Simulate photos of an object from several sides, or an aerial block.

    The Z axis points from the object to the cameras. Without `block` all photos
    look at one object, as wide as their view and a fifth of their distance deep.

    Parameters
    ----------
    lens : camera.Camera
        Took all photos.
    photos, points : int
        Number of photos (at least 2) and of object points.
    rng : numpy.random.Generator
        Source of the random numbers.
    rays : float, optional
        Photos in which a point was measured, chosen at random among those that see it.
        3.4 means 3 for six points of ten and 4 for the others; None means all photos.
    convergent : bool
        Axes inclined by up to 35 degrees, each to another side (in a block all by 20
        degrees), or parallel.
    rolled : bool
        Cameras rotated about their axes by 0, 90, 180, 270, 0 ... degrees, or not at
        all.
    flat : bool
        All points in the plane Z = 0.
    block : bool
        Strips above a terrain, overlaps 80 % and 60 %; needs `rays`.
    sigma : float
        Standard deviation of the image coordinates; mm. May be 0.
    distance : float
        Distance of the cameras from the object, which sets its unit: 2000 is in mm.
    image_size : array_like (2,)
        Width and height of the image; mm.

    Returns
    -------
    KnownNetwork
        Every ray lies in front of its camera and inside the image.

    Examples
    --------
    Nine photos of fifty targets in all of them, and a large block:

    >>> lens, rng = Camera(35.0, K1=-1e-4), np.random.default_rng(1)
    >>> net = network(lens, 9, 50, rng)
    >>> net.xy.shape, net.exteriors.shape, net.points.shape
    ((450, 2), (9, 6), (50, 3))
    >>> true = camera.project(lens, net.exteriors[net.photo], net.points[net.point])
    >>> print(f"{np.std(net.xy - true):.4f} mm")
    0.0010 mm
    >>> large = network(lens, 60, 2000, rng, rays=3.4, block=True)
    >>> len(large.xy) / 2000
    3.4
    """
    rays = float(photos) if rays is None else rays

    # Stations and attitudes, with small errors of flight and pointing
    size = np.asarray(image_size, dtype=float)
    place = _strips if block else _stations
    exteriors, half_width = place(
        photos, distance * size / lens.c, distance, convergent
    )
    exteriors[:, 5] = np.arange(photos) % 4 * np.pi / 2 if rolled else 0.0
    exteriors[:, :3] += 0.01 * distance * rng.normal(size=(photos, 3))
    exteriors[:, 3:] += np.radians(0.5) * rng.normal(size=(photos, 3))

    # Points that enough photos see
    wanted = _spread(rays, points, rng)
    found, seen = np.empty((0, 3)), np.empty((photos, 0), bool)
    for _ in range(50):
        new = rng.uniform(-1, 1, (2 * points, 3)) * [*half_width, distance / 10]
        new *= [1, 1, not flat]
        visible = _visible(lens, exteriors, new, size)
        enough = visible.sum(axis=0) >= wanted.max()
        found = np.concatenate([found, new[enough]])
        seen = np.concatenate([seen, visible[:, enough]], axis=1)
        if len(found) >= points:
            break
    else:
        raise ValueError(
            f"only {len(found)} of {points} points lie in {wanted.max()} of the photos:"
            " ask for fewer rays, or give a shorter principal distance or a larger"
            " image_size"
        )

    # For each point the photos that measure it: the first ones of a random order
    order = np.argsort(rng.random((photos, points)) - seen[:, :points], axis=0)
    chosen = np.empty((photos, points), bool)
    np.put_along_axis(chosen, order, np.arange(photos)[:, None] < wanted, axis=0)
    photo, point = np.nonzero(chosen)
    xy = camera.project(lens, exteriors[photo], found[point])
    xy += sigma * rng.normal(size=xy.shape)
    return KnownNetwork(lens, exteriors, found[:points], photo, point, xy, sigma)


def _stations(
    photos: int, view: np.ndarray, distance: float, convergent: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Exteriors around one object, and half its width and height."""
    share = np.sqrt((np.arange(photos) + 0.5) / photos)  # evenly over a disk
    azimuth = GOLDEN_ANGLE * np.arange(photos)
    if convergent:
        direction = _direction(np.radians(35) * share, azimuth)
        return _looking_along(direction, distance * direction), view / 2
    aside = 0.2 * min(view) * share
    X, Y = aside * np.cos(azimuth), aside * np.sin(azimuth)
    up = _direction(np.zeros(photos), azimuth)
    return _looking_along(up, np.c_[X, Y, np.full(photos, distance)]), view / 2


def _strips(
    photos: int, view: np.ndarray, distance: float, convergent: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Exteriors in strips over a terrain, and half its width and height."""
    in_strip = int(np.ceil(np.sqrt(1.5 * photos)))
    strip, place = np.divmod(np.arange(photos), in_strip)
    grid = np.transpose([place, strip]) * view * [0.2, 0.4]
    grid -= (grid.max(axis=0) + grid.min(axis=0)) / 2
    tilt = np.full(photos, np.radians(20) if convergent else 0.0)
    up = _direction(tilt, GOLDEN_ANGLE * np.arange(photos))
    exteriors = _looking_along(up, np.c_[grid, np.full(photos, distance)])
    return exteriors, grid.max(axis=0) + view / 4


def _direction(tilt: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Unit vectors (..., 3), inclined against the Z axis."""
    sin = np.sin(tilt)
    return np.transpose([sin * np.cos(azimuth), sin * np.sin(azimuth), np.cos(tilt)])


def _looking_along(back: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Exteriors (m, 6) of cameras at `centre` with `back` on their z axes, kappa 0."""
    # The third row of M is (sin phi, -sin omega cos phi, cos omega cos phi)
    omega, phi = np.arctan2(-back[:, 1], back[:, 2]), np.arcsin(back[:, 0])
    return np.c_[centre, omega, phi, np.zeros(len(back))]


def _visible(
    lens: Camera, exteriors: np.ndarray, points: np.ndarray, size: np.ndarray
) -> np.ndarray:
    """Which photo sees which point: (m, n) of bool."""
    rays, _ = imaging.ray(exteriors[:, None], points)
    ideal, _, _ = imaging.perspective(lens.c, rays)
    visible = (rays[..., 2] < 0) & np.all(np.abs(ideal) < size / 2, axis=-1)
    # The lens is evaluated only for what the ideal camera sees
    photo, point = np.nonzero(visible)
    measured = camera.project(lens, exteriors[photo], points[point])
    visible[photo, point] = np.all(np.abs(measured) < size / 2, axis=-1)
    return visible


def _spread(rays: float, points: int, rng: np.random.Generator) -> np.ndarray:
    """Whole numbers (points,) of rays with this mean, in random order."""
    below = np.full(points, int(rays))
    below[: round((rays - int(rays)) * points)] += 1
    return rng.permutation(below)
