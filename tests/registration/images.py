"""Two ortho images with a known shift, as arrays and files, and made registrations."""

from functools import cache

import numpy as np
from PIL import Image

from pgm_lab import registration, simulate

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
