"""Aerial photos of a known landscape, ray-cast through the collinearity equations."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from pgm_lab.camera import Camera
from pgm_lab.camera.photo import Photo
from pgm_lab.simulate.landscape import Landscape, landscape

# Harintaka (2020): f 24 mm, 1000 m above ground; a Nikon D2X has 4288 x 2848 pixels
CAMERA = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
SENSOR, PIXEL = (4288, 2848), 5.49e-3
HEIGHT = 1000.0


@dataclass(frozen=True, eq=False)
class AerialPair:
    """Two photos of a landscape, with the truth.

    Attributes
    ----------
    left, right : Photo
    landscape : Landscape
    ground : tuple of two ndarray (rows, columns, 3)
        Object point that each pixel of left and right shows, in m.
    hidden : tuple of two ndarray (rows, columns) of bool
        Pixels of the left photo whose point the right one does not show (something
        stands before it, or it is outside), and the other way round.
    """

    left: Photo
    right: Photo
    landscape: Landscape = field(repr=False)
    ground: tuple[np.ndarray, np.ndarray] = field(repr=False)
    hidden: tuple[np.ndarray, np.ndarray] = field(repr=False)


def aerial_pair(part=(900, 650), *, overlap=0.6, sigma=2.0, seed=8) -> AerialPair:
    """Two photos with the flight of Harintaka (2020), or the same part of both."""
    gsd = HEIGHT / CAMERA.c * PIXEL
    base = (1 - overlap) * SENSOR[0] * gsd
    half = (np.array(part) / 2 + 260) * gsd
    land = landscape((-half[0], -half[1], half[0], half[1]), seed=seed)
    tilt = np.radians([(0.8, -1.1, 2.0), (-0.6, 0.9, -1.5)])
    stations = [(-base / 2, 0, HEIGHT + 20), (base / 2, 3, HEIGHT + 24)]
    photos, points = [], []
    for k in (0, 1):
        exterior = np.array([*stations[k], *tilt[k]])
        blank = Photo(np.zeros((1, 1)), CAMERA, exterior, PIXEL, SENSOR)
        middle = blank.project(np.array([0.0, 0.0, 20.0]))
        corner = tuple(int(v) for v in np.round(middle - np.array(part) / 2))
        photo, ground = photograph(
            land, CAMERA, exterior, PIXEL, SENSOR, corner, part, sigma, seed + k
        )
        photos.append(photo)
        points.append(ground)
    hidden = tuple(_hidden(land, points[k], photos[1 - k]) for k in (0, 1))
    return AerialPair(*photos, land, tuple(points), hidden)


def photograph(
    land, camera, exterior, pixel_size, image_size, corner, part, sigma=2.0, seed=0
):
    """Photo of a landscape, and the object point (rows, columns, 3) of each pixel."""
    columns, rows = part
    blank = Photo(
        np.zeros((rows, columns)), camera, exterior, pixel_size, image_size, corner
    )
    pixels = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1)
    u = blank.rays(pixels)
    dx, dy = (u[..., :2] / u[..., 2:]).astype(np.float32).transpose(2, 0, 1)
    X0, Y0, Z0 = exterior[:3]

    def surface(z):
        return land.at(land.dsm, X0 + (z - Z0) * dx, Y0 + (z - Z0) * dy)

    # Down in steps until the ray is below the surface, then halve
    step, low = 0.5, land.dsm.min() - 0.1
    z = land.dsm.max() + 0.1
    under = np.full((rows, columns), low, np.float32)
    found = np.zeros((rows, columns), bool)
    while z > low:
        hit = ~found & (surface(z) >= z)
        under[hit] = z
        found |= hit
        z -= step
    above = under + step
    for _ in range(12):
        middle = (under + above) / 2
        below = surface(middle) >= middle
        under = np.where(below, middle, under)
        above = np.where(below, above, middle)
    Z = (under + above) / 2
    X, Y = X0 + (Z - Z0) * dx, Y0 + (Z - Z0) * dy
    grey = land.at(land.grey, X, Y, cv2.INTER_CUBIC)
    r2 = (blank.to_photo(pixels) ** 2).sum(-1) / camera.c**2
    grey = grey * (1 - 0.6 * r2 + 0.2 * r2**2).clip(0.5, 1)
    grey = grey + np.random.default_rng(seed).normal(0, sigma, grey.shape)
    grey = np.clip(np.round(grey), 0, 255).astype(np.uint8)
    photo = Photo(grey, camera, exterior, pixel_size, image_size, corner)
    return photo, np.stack([X, Y, Z], -1)


def _hidden(land, points, other: Photo):
    """Where something stands between the points and the other station."""
    X0, Y0, Z0 = other.exterior[:3]
    hidden = np.zeros(points.shape[:2], bool)
    top = land.dsm.max()
    for rise in np.arange(0.3, top - land.dsm.min(), 0.5):
        z = points[..., 2] + rise
        t = rise / (Z0 - points[..., 2])
        X, Y = (
            points[..., i] + t * (other.exterior[i] - points[..., i]) for i in (0, 1)
        )
        hidden |= land.at(land.dsm, X, Y) > z
    pixels = other.project(points.reshape(-1, 3)).reshape(*points.shape[:2], 2)
    size = np.array(other.grey.shape[::-1]) - 1
    return hidden | ((pixels < 0) | (pixels > size)).any(-1)
