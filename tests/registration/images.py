"""Two ortho images with a known shift, as arrays and files, and made registrations."""

from functools import cache

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates

from pgm_lab import registration, simulate
from pgm_lab.datasets import landsat

ROWS, COLUMNS = 160, 200
SHIFT = np.array([1.25, -0.5])  # columns, rows
AFFINE = (1.25, 1, 0, -0.5, 0, 1)
CRS = "EPSG:32748"
CORNER = (700_000.0, 9_320_000.0)
SIZE = 6.0  # m


@cache
def pair(affine=AFFINE, **more):
    """Images of 16 bit, the sensed one moved by `SHIFT`, darker and noisy."""
    texture = simulate.texture(seed=3)
    values = {"gain": 0.9, "sigma": 0.5, "seed": 1} | more
    both = simulate.texture_pair(texture, (ROWS, COLUMNS), affine, **values)
    return [np.clip(np.round(100 * one), 0, 65535).astype(np.uint16) for one in both]


@cache
def uneven(shift=(0.0, 0.0), amplitude=4.0, size=600, blur=0.0, noise=20.0, gamma=1.0):
    """A part of a Landsat scene, the same seen with an uneven shift, and the shift.

    The sensed image may be less sharp, with other contrast. The shift of points (n, 2)
    is a sum of waves of 200 px and more, with this amplitude.
    """

    def truth(points):
        x, y = np.moveaxis(points / 200, -1, 0)
        waves = np.sin(5 * x + 1) * np.cos(4 * y), np.sin(4 * x - 3 * y)
        return amplitude * np.stack(waves, axis=-1) + shift

    scene = landsat().grey[:size, :size].astype(float)
    pixels = np.stack(np.meshgrid(*[np.arange(float(size))] * 2), axis=-1)
    places = pixels - shift
    for _ in range(
        30
    ):  # which point of the reference a pixel of the sensed image shows
        places = pixels - truth(places)
    sensed = map_coordinates(scene, np.moveaxis(places, -1, 0)[::-1], order=5)
    sensed = gaussian_filter(sensed, blur) if blur else sensed
    low, high = scene.min(), scene.max()
    sensed = low + (high - low) * np.clip((sensed - low) / (high - low), 0, 1) ** gamma
    random = np.random.default_rng(1)
    both = (one + random.normal(0, noise, one.shape) for one in (scene, sensed))
    return (*(np.round(one).astype(np.uint16) for one in both), truth)


def save(folder):
    """Return both as PNG files."""
    paths = [folder / "reference.png", folder / "sensed.png"]
    for path, values in zip(paths, pair()):
        Image.fromarray(values).save(path)
    return paths


def raster(values, corner=CORNER, size=SIZE, crs=CRS):
    """An image on the map, its first pixel at a corner, north up."""
    transform = np.array([[size, 0, corner[0]], [0, -size, corner[1]]])
    mask = np.zeros(values.shape, bool)
    return registration.Raster(values, mask, transform, crs, np.array([size, size]))


def save_tiff(folder, cut=(10, 20), **more):
    """Return both as GeoTIFF; of the sensed one the first (rows, columns) are cut."""
    reference, sensed = pair()
    down, right = cut
    corner = CORNER[0] + right * SIZE, CORNER[1] - down * SIZE
    both = raster(reference), raster(sensed[down:, right:], corner, **more)
    paths = [folder / "reference.tif", folder / "sensed.tif"]
    return [registration.write(*one) for one in zip(paths, both)]


def result(n=40, status=None, shift=SHIFT, sd=0.02, scatter=0.02, seed=1, **more):
    """A Registration of n points on a grid, all accepted unless a status says not."""
    columns = int(np.ceil(np.sqrt(n)))
    place = np.stack(np.divmod(np.arange(n), columns)[::-1], axis=1) + 0.5
    points = np.round(place / columns * (COLUMNS, ROWS))
    status = np.array(["accepted"] * n if status is None else status, "<U40")
    d = shift + np.random.default_rng(seed).normal(0, scatter, (n, 2))
    covariance = np.tile(sd**2 * np.eye(2), (n, 1, 1))
    covariance[status != "accepted"] = np.nan
    values = {
        "points": points,
        "dx": d[:, 0],
        "dy": d[:, 1],
        "r": np.linspace(0.8, 0.99, n),
        "second": np.where(np.arange(n) % 2, 0.4, -1.0),
        "covariance": covariance,
    }
    return registration.Registration(status=status, **values | more)
