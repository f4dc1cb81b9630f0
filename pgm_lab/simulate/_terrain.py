"""The ground without anything on it: heights, and what grows there."""

import cv2
import numpy as np
import scipy
from matplotlib import cbook

from pgm_lab import datasets
from pgm_lab.simulate._cubic import enlarged

POST = 20.0  # m between two heights of the elevation model, which has 90 m in nature
HILLS = (170.0, 150.0)  # row and column of the model in the middle of the landscape
PATCH = 19.0  # m, side of a patch of meadow
SHADE = 85  # grey value below which the orthophoto shows a shadow or a dark crown


def terrain(X: np.ndarray, Y: np.ndarray, relief: float) -> np.ndarray:
    """Heights (rows, columns) in m, from 0 to `relief`, at columns X and rows Y.

    A cubic spline through the heights of the elevation model, so that neither the
    slope nor the curvature jumps at its posts; beyond its edge it is mirrored.
    """
    if relief == 0:
        return np.zeros((len(Y), len(X)), np.float32)
    name = "jacksboro_fault_dem.npz"
    with np.load(cbook.get_sample_data(name, asfileobj=False)) as data:
        posts = cv2.GaussianBlur(data["elevation"].astype(np.float32), (0, 0), 1.0)
    row = HILLS[0] - (Y - Y.mean()) / POST
    column = HILLS[1] + (X - X.mean()) / POST
    rows, columns = _around(row), _around(column)
    near = posts[np.ix_(_mirrored(rows, len(posts)), _mirrored(columns, len(posts.T)))]
    z = scipy.interpolate.RectBivariateSpline(rows, columns, near)(row, column).astype(
        np.float32
    )
    z -= z.min()
    z *= np.float32(relief) / z.max()
    return z


def _around(index: np.ndarray) -> np.ndarray:
    return np.arange(np.floor(index.min()) - 3, np.ceil(index.max()) + 4)


def _mirrored(index: np.ndarray, n: int) -> np.ndarray:
    return n - 1 - np.abs(index.astype(int) % (2 * n - 2) - (n - 1))


def meadow(shape: tuple[int, int], cell: float, rng: np.random.Generator) -> np.ndarray:
    """Grey values (rows, columns) of open ground, out of the orthophoto.

    Patches of the orthophoto without trees and shadows, each from another place, turned
    and mirrored, overlap by a third. Where n of them meet, their weighted sum is over
    the root of the sum of squared weights, not over the sum, which would flatten the
    contrast there.
    """
    tile = _tile(cell)
    side = min(round(PATCH / cell), len(tile) // 2)
    places = _open_places(tile, side)
    step = side * 2 // 3
    ramp = np.minimum(1, (np.arange(side) + 0.5) / (side - step))
    w = np.outer(*[np.minimum(ramp, ramp[::-1])] * 2).astype(np.float32)
    total = np.zeros((shape[0] + 2 * side, shape[1] + 2 * side), np.float32)
    weight = np.zeros_like(total)
    for r in range(0, shape[0] + side, step):
        for c in range(0, shape[1] + side, step):
            i, j = places[rng.integers(len(places))]
            patch = np.rot90(tile[i : i + side, j : j + side], int(rng.integers(4)))
            if rng.integers(2):
                patch = patch[:, ::-1]
            total[r : r + side, c : c + side] += w * (patch - patch.mean())
            weight[r : r + side, c : c + side] += w**2
    here = np.s_[side // 2 : side // 2 + shape[0], side // 2 : side // 2 + shape[1]]
    grey = total[here] / np.sqrt(weight[here])
    grey += 138 + 9 * clouds(shape, 35 / cell, rng) + 5 * clouds(shape, 8 / cell, rng)
    return grey


def _tile(cell: float) -> np.ndarray:
    """Orthophoto in cells of the landscape, each the mean of the pixels it covers."""
    ortho = datasets.yellowstone()
    side = round(len(ortho.grey) * ortho.gsd / cell)
    how = cv2.INTER_AREA if cell >= ortho.gsd else cv2.INTER_CUBIC
    return cv2.resize(ortho.grey.astype(np.float32), (side, side), interpolation=how)


def _open_places(tile: np.ndarray, side: int) -> np.ndarray:
    """Rows and columns where a square without trees and shadows begins."""
    smooth = cv2.GaussianBlur(tile, (0, 0), max(0.5, 1.5 * len(tile) / 1024))
    total = cv2.integral((smooth < SHADE).astype(np.float32))
    dark = total[side:, side:] - total[:-side, side:]
    dark += total[:-side, :-side] - total[side:, :-side]
    return np.argwhere(dark <= 0.004 * side**2)


def clouds(shape: tuple[int, int], size: float, rng: np.random.Generator) -> np.ndarray:
    """Smooth random field (rows, columns), sd about 1, of so many cells a wave."""
    rows, columns = (int(n / size) + 4 for n in shape)
    coarse = rng.standard_normal((rows, columns)).astype(np.float32)
    return 1.4 * enlarged(coarse, *(1 + np.arange(n) / size for n in shape))
