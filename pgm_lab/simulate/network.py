"""Networks of photos with exactly known truth, for bundle adjustments."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, camera
from pgm_lab.camera import imaging

GOLDEN_ANGLE = np.pi * (3 - 5**0.5)  # a turn that never comes back to the same side


@dataclass(frozen=True)
class KnownNetwork:
    """What is true in a simulated network, and what was measured in it.

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

    camera: camera.Camera
    exteriors: np.ndarray
    points: np.ndarray
    photo: np.ndarray
    point: np.ndarray
    xy: np.ndarray
    sigma: float


def network(
    lens: camera.Camera,
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

    The Z axis points from the object to the cameras. Without `block` all photos look at
    one object, as wide as their view and deep by a fifth of their distance, from
    stations around its normal. With `block` they stand in strips above a terrain.

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
        The axes are inclined against the normal of the object: up to 35 degrees, each
        to another side; in a block all by 20 degrees. False leaves them parallel.
    rolled : bool
        The cameras are turned about their axes by 0, 90, 180, 270, 0 ... degrees. False
        leaves them upright.
    flat : bool
        All points in the plane Z = 0.
    block : bool
        Photos in strips, with overlaps of 80 % and 60 %; then `rays` is needed.
    sigma : float
        Standard deviation of the image coordinates, normally distributed; mm. May be 0.
    distance : float
        Distance of the cameras from the object, which sets its unit: 2000 is in mm.
    image_size : array_like (2,)
        Width and height of the image; mm.

    Returns
    -------
    KnownNetwork
        Every ray lies in front of its camera and inside the image.

    Raises
    ------
    ValueError
        If a number makes no sense, or the photos have too little of the object in
        common.

    Examples
    --------
    Nine photos of fifty targets in all of them, and a large block:

    >>> lens, rng = camera.Camera(35.0, K1=-1e-4), np.random.default_rng(1)
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
    _validate.instance(lens, camera.Camera, "lens")
    _validate.instance(rng, np.random.Generator, "rng")
    flags = {"convergent": convergent, "rolled": rolled, "flat": flat, "block": block}
    for name, value in flags.items():
        _validate.flag(value, name)
    photos = _validate.whole(photos, "photos", 2)
    points = _validate.whole(points, "points", 1)
    _validate.size("the points in all photos", photos, points)
    distance = _validate.positive_number(distance, "distance", "unit of the object")
    size = _validate.pair(image_size, "image_size", "mm")
    sigma = _validate.not_negative(sigma, "sigma", "mm")
    if rays is None and block:
        raise ValueError(
            "a block needs a value for rays: no point lies in all of its photos"
        )
    rays = float(photos) if rays is None else _validate.number(rays, "rays")
    if not 2 <= rays <= photos:
        raise ValueError(f"rays must lie between 2 and the {photos} photos; got {rays}")

    place = _strips if block else _stations
    exteriors, half_width = place(
        photos, distance * size / lens.c, distance, convergent
    )
    exteriors[:, 5] = np.arange(photos) % 4 * np.pi / 2 if rolled else 0.0
    exteriors[:, :3] += 0.01 * distance * rng.normal(size=(photos, 3))
    exteriors[:, 3:] += np.radians(0.5) * rng.normal(size=(photos, 3))

    # points, and for each the photos that see it: the first ones of a random order
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
    # the third row of M is (sin phi, -sin omega cos phi, cos omega cos phi)
    omega, phi = np.arctan2(-back[:, 1], back[:, 2]), np.arcsin(back[:, 0])
    return np.c_[centre, omega, phi, np.zeros(len(back))]


def _visible(
    lens: camera.Camera, exteriors: np.ndarray, points: np.ndarray, size: np.ndarray
) -> np.ndarray:
    """Which photo sees which point: (m, n) of bool."""
    rays, _ = imaging.ray(exteriors[:, None], points)
    ideal, _, _ = imaging.perspective(lens.c, rays)
    visible = (rays[..., 2] < 0) & np.all(np.abs(ideal) < size / 2, axis=-1)
    # the lens is asked only about what the ideal camera sees
    photo, point = np.nonzero(visible)
    measured = camera.project(lens, exteriors[photo], points[point])
    visible[photo, point] = np.all(np.abs(measured) < size / 2, axis=-1)
    return visible


def _spread(rays: float, points: int, rng: np.random.Generator) -> np.ndarray:
    """Whole numbers (points,) of rays with this mean, in random order."""
    below = np.full(points, int(rays))
    below[: round((rays - int(rays)) * points)] += 1
    return rng.permutation(below)
