"""Aerial photos of a known landscape, ray-cast through the collinearity equations."""

from dataclasses import dataclass, field

import numpy as np

from pgm_lab import _validate
from pgm_lab.camera import Camera
from pgm_lab.camera.photo import Photo
from pgm_lab.simulate._photograph import hidden as _hidden
from pgm_lab.simulate._photograph import photograph, photographs
from pgm_lab.simulate._rays import Surface
from pgm_lab.simulate.images import generator
from pgm_lab.simulate.landscape import Landscape, landscape

__all__ = ["AerialPair", "aerial_block", "aerial_pair", "photograph"]

# Harintaka (2020): f 24 mm, 1000 m above ground; a Nikon D2X has 4288 x 2848 pixels
CAMERA = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
SENSOR, PIXEL = (4288, 2848), 5.49e-3
HEIGHT = 1000.0
GSD = HEIGHT / CAMERA.c * PIXEL


@dataclass(frozen=True, eq=False)
class AerialPair:
    """Two photos of a landscape, with the truth.

    Attributes
    ----------
    left, right : Photo
    landscape : Landscape
    ground : tuple of two ndarray (rows, columns, 3)
        Object point that each pixel of left and right shows, in m: where its ray first
        meets the bilinear heights of the DSM. Such a point may lie on the wall of a
        house, which is a ramp as wide as a cell.
    hidden : tuple of two ndarray (rows, columns) of bool
        Pixels of the left photo whose point the right one does not show (something
        stands before it, or it is outside), and the other way round.
    """

    left: Photo
    right: Photo
    landscape: Landscape = field(repr=False)
    ground: tuple[np.ndarray, np.ndarray] = field(repr=False)
    hidden: tuple[np.ndarray, np.ndarray] = field(repr=False)


def aerial_pair(
    part: tuple[int, int] = (900, 650),
    *,
    overlap: float = 0.6,
    sigma: float = 2.0,
    seed: int = 8,
    relief: float = 40.0,
    cell: float = 0.15,
    buildings: int | None = None,
    trees: int | None = None,
    water: bool = False,
    camera: Camera = CAMERA,
) -> AerialPair:
    """Two photos with the flight of Harintaka (2020), or the same part of both.

    The camera (f 24 mm, 4288 x 2848 pixels of 5.49 um, the lens of a non-metric
    camera) flies 1000 m above the ground, so that a pixel is 0.229 m there, with small
    tilts.

    Parameters
    ----------
    part : (columns, rows)
        Of the sensor, in pixels, around the ground in the middle of the overlap; (4288,
        2848) is all of it. The base is that of whole photos.
    overlap : float
        Of two whole photos, 0.5 or more and below 1.
    sigma : float
        Standard deviation of the noise, in grey values.
    seed : int
        Of landscape and noise.
    relief, cell, buildings, trees, water
        As in `landscape`. Open fields, mixed ground and wood are the thirds, from west
        to east, of the ground that both photos show.
    camera : Camera
        Another lens, or none.

    Returns
    -------
    AerialPair

    Raises
    ------
    ValueError
        If a number is not as said.

    Examples
    --------
    >>> pair = aerial_pair((120, 80))
    >>> pair.left.grey.shape, pair.ground[0].shape
    ((80, 120), (80, 120, 3))
    """
    part, sigma, seed, relief = _checked(part, sigma, seed, relief, camera)
    overlap = _overlap(overlap, 0.5, "overlap")
    base = (1 - overlap) * SENSOR[0] * GSD
    tilts = np.radians([(0.8, -1.1, 2.0), (-0.6, 0.9, -1.5)])
    stations = [(-base / 2, 0, HEIGHT + 20), (base / 2, 3, HEIGHT + 24)]
    frames = [
        _frame(np.array([*s, *t]), camera, part, np.array([0.0, 0.0, relief / 2]))
        for s, t in zip(stations, tilts, strict=True)
    ]
    boxes = np.array([_footprint(frame, part) for frame in frames])
    seen = np.array([_footprint(frame, part, relief / 2) for frame in frames])
    both = seen[:, 0].max(), seen[:, 2].min()
    third = (both[1] - both[0]) / 3
    land = landscape(
        _around(boxes),
        cell=cell,
        relief=relief,
        buildings=buildings,
        trees=trees,
        seed=seed,
        borders=(both[0] + third, both[1] - third),
        water=water,
    )
    surface = Surface(land.dsm)
    (left, a), (right, b) = photographs(land, surface, frames, part, sigma, seed)
    hidden = _hidden(a, right, b, land, surface), _hidden(b, left, a, land, surface)
    return AerialPair(left, right, land, (a, b), hidden)


def aerial_block(
    strips: int,
    photos: int,
    part: tuple[int, int] = (900, 650),
    *,
    overlap: float = 0.6,
    sidelap: float = 0.3,
    sigma: float = 2.0,
    seed: int = 8,
    relief: float = 40.0,
    cell: float = 0.15,
    buildings: int | None = None,
    trees: int | None = None,
    camera: Camera = CAMERA,
) -> tuple[list[Photo], Landscape]:
    """Strips of photos that overlap, of one landscape, flown as `aerial_pair`.

    Parameters
    ----------
    strips, photos : int
        How many strips, from north to south, and photos in each, from west to east.
    part : (columns, rows)
        The middle of the sensor is read out: the photos are so large, and overlap as
        such. With less than the whole sensor, (4288, 2848), the base is shorter.
    overlap, sidelap : float
        Between the photos of a strip, 0.5 or more, and between strips, 0 or more.
    sigma, seed, relief, cell, buildings, trees, camera
        As in `aerial_pair`; stations and angles vary a little, too.

    Returns
    -------
    photos : list of Photo
        Strip by strip, each from west to east.
    landscape : Landscape

    Raises
    ------
    ValueError
        If a number is not as said, or the landscape would have more than 10^8 cells.

    Examples
    --------
    >>> photos, land = aerial_block(1, 2, (120, 80), cell=0.3)
    >>> len(photos), photos[1].grey.shape
    (2, (80, 120))
    """
    strips = _validate.whole(strips, "strips", 1, 1000)
    count = _validate.whole(photos, "photos", 1, 1000)
    part, sigma, seed, relief = _checked(part, sigma, seed, relief, camera)
    overlap = _overlap(overlap, 0.5, "overlap")
    sidelap = _overlap(sidelap, 0.0, "sidelap")
    along, across = (
        (1 - o) * n * GSD for o, n in zip((overlap, sidelap), part, strict=True)
    )
    rng = generator([seed, 1])
    frames = []
    for i in range(strips):
        for j in range(count):
            X = (j - (count - 1) / 2) * along
            Y = ((strips - 1) / 2 - i) * across
            shake = rng.normal(0, 0.004, 2) * (along, across)
            Z = HEIGHT + relief / 2 + rng.normal(0, 1)
            tilt = np.radians(rng.normal(0, 0.02, 3))
            exterior = np.array([X + shake[0], Y + shake[1], Z, *tilt])
            corner = tuple((np.array(SENSOR) - part) // 2)
            frames.append(
                Photo(np.zeros((1, 1)), camera, exterior, PIXEL, SENSOR, corner)
            )
    boxes = np.array([_footprint(frame, part) for frame in frames])
    land = landscape(
        _around(boxes),
        cell=cell,
        relief=relief,
        buildings=buildings,
        trees=trees,
        seed=seed,
    )
    taken = photographs(land, Surface(land.dsm), frames, part, sigma, seed)
    return [photo for photo, _ in taken], land


def _frame(
    exterior: np.ndarray, camera: Camera, part: tuple[int, int], middle: np.ndarray
) -> Photo:
    """Photo without grey values, of the part of the sensor around a point's image."""
    blank = Photo(np.zeros((1, 1)), camera, exterior, PIXEL, SENSOR)
    corner = np.round(blank.project(middle) - np.array(part) / 2).astype(int)
    c, r = (int(v) for v in np.clip(corner, 0, np.array(SENSOR) - part))
    return Photo(np.zeros((1, 1)), camera, exterior, PIXEL, SENSOR, (c, r))


def _footprint(frame: Photo, part: tuple[int, int], Z: float = 0.0) -> np.ndarray:
    """Least and most X and Y (4,) that a photo shows of level ground."""
    edge = [np.linspace(0, n - 1, 9) for n in part]
    u = frame.rays(np.stack(np.meshgrid(*edge), -1)).reshape(-1, 3)
    down = (Z - frame.exterior[2]) / u[:, 2]
    XY = frame.exterior[:2] + down[:, None] * u[:, :2]
    return np.concatenate([XY.min(0), XY.max(0)])


def _around(boxes: np.ndarray) -> tuple[float, float, float, float]:
    """Box around boxes, with a margin."""
    west, south = boxes[:, :2].min(0) - 4
    east, north = boxes[:, 2:].max(0) + 4
    return float(west), float(south), float(east), float(north)


def _checked(
    part: tuple[int, int], sigma: float, seed: int, relief: float, camera: Camera
) -> tuple[tuple[int, int], float, int, float]:
    """What a pair and a block have in common."""
    columns, rows = (
        _validate.whole(n, "part", 8, most)
        for n, most in zip(_validate.of_shape(part, (2,), "part"), SENSOR, strict=True)
    )
    sigma = _validate.not_negative(sigma, "sigma", "grey values")
    seed = _validate.whole(seed, "seed", 0)
    _validate.instance(camera, Camera, "camera")
    relief = _validate.not_negative(relief, "relief", "m")
    if relief > HEIGHT / 2:
        raise ValueError(f"relief must be at most {HEIGHT / 2:g} m; got {relief:g}")
    return (columns, rows), sigma, seed, relief


def _overlap(value: float, least: float, name: str) -> float:
    one = _validate.number(value, name)
    if not least <= one < 1:
        raise ValueError(f"{name} must be from {least:g} to below 1; got {one:g}")
    return one
