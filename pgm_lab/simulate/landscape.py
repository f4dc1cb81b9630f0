"""A real landscape with houses and trees on it, and every height known."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from matplotlib import cbook

from pgm_lab import datasets

OPEN, BUILDING, TREE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Landscape:
    """Ground, and what stands on it, in cells of equal size.

    Attributes
    ----------
    grey : ndarray (rows, columns)
        Grey values as seen from above.
    dtm, dsm : ndarray (rows, columns)
        Heights of the ground, and of what the sky sees, in m.
    kind : ndarray (rows, columns) of uint8
        `OPEN`, `BUILDING` or `TREE`.
    corner : (X, Y)
        Middle of the cell in row 0 and column 0, in m; Y falls with the row.
    cell : float
        Side of a cell in m.
    """

    grey: np.ndarray = field(repr=False)
    dtm: np.ndarray = field(repr=False)
    dsm: np.ndarray = field(repr=False)
    kind: np.ndarray = field(repr=False)
    corner: tuple[float, float]
    cell: float

    def at(self, layer: np.ndarray, X, Y, how: int = cv2.INTER_LINEAR) -> np.ndarray:
        """Values of a layer at (X, Y), float32, of the shape of X."""
        column = ((X - self.corner[0]) / self.cell).astype(np.float32)
        row = ((self.corner[1] - Y) / self.cell).astype(np.float32)
        return cv2.remap(layer, column, row, how, borderMode=cv2.BORDER_REPLICATE)


def landscape(extent, *, cell=0.2, relief=40.0, buildings=25, trees=400, seed=8):
    """Landscape over an extent (X least, Y least, X most, Y most) in m."""
    rng = np.random.default_rng(seed)
    xmin, ymin, xmax, ymax = extent
    columns = int(np.ceil((xmax - xmin) / cell))
    rows = int(np.ceil((ymax - ymin) / cell))
    dtm = _ground(rows, columns, relief)
    fine = _mosaic((int(rows * cell / 0.1), int(columns * cell / 0.1)), rng)
    grey = cv2.resize(fine, (columns, rows), interpolation=cv2.INTER_AREA)
    dsm, kind = dtm.copy(), np.zeros((rows, columns), np.uint8)
    for _ in range(buildings):
        _building(grey, dtm, dsm, kind, cell, rng)
    for _ in range(trees):
        _tree(grey, dtm, dsm, kind, cell, rng)
    return Landscape(grey, dtm, dsm, kind, (xmin + cell / 2, ymax - cell / 2), cell)


def _ground(rows, columns, relief):
    with np.load(
        cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)
    ) as d:
        z = d["elevation"].astype(np.float32)
    side = 60
    part = z[140 : 140 + side, 150 : 150 + int(side * columns / rows) + 1]
    smooth = cv2.GaussianBlur(part, (0, 0), 1.0)
    dtm = cv2.resize(smooth, (columns, rows), interpolation=cv2.INTER_CUBIC)
    return (dtm - dtm.min()) / np.ptp(dtm) * np.float32(relief)


def _mosaic(shape, rng, overlap=192):
    tile = datasets.yellowstone().grey.astype(np.float32)
    n = tile.shape[0]
    step = n - overlap
    ramp = np.minimum(1, (np.arange(n) + 0.5) / overlap)
    ramp = np.minimum(ramp, ramp[::-1])
    w = np.outer(ramp, ramp).astype(np.float32)
    mean = tile.mean()
    total = np.zeros((shape[0] + 2 * n, shape[1] + 2 * n), np.float32)
    weight = np.zeros_like(total)
    for r in range(0, shape[0] + n, step):
        for c in range(0, shape[1] + n, step):
            t = np.rot90(tile, rng.integers(4))
            if rng.integers(2):
                t = t[:, ::-1]
            t = (t - mean) * rng.uniform(0.8, 1.2) + rng.normal(0, 8)
            total[r : r + n, c : c + n] += w * t
            weight[r : r + n, c : c + n] += w**2
    out = total / np.sqrt(np.maximum(weight, 1e-6)) + mean
    h = n // 2
    return np.clip(out[h : h + shape[0], h : h + shape[1]], 0, 255)


def _building(grey, dtm, dsm, kind, cell, rng):
    rows, columns = dtm.shape
    w, length, h = rng.uniform(8, 14), rng.uniform(10, 24), rng.uniform(4, 12)
    a = rng.uniform(0, np.pi)
    c0, r0 = rng.uniform(0, columns), rng.uniform(0, rows)
    box = cv2.boxPoints(((c0, r0), (w / cell, length / cell), np.degrees(a)))
    mask = np.zeros(dtm.shape, np.uint8)
    cv2.fillPoly(mask, [np.round(box).astype(int)], 1)
    m = mask.astype(bool)
    if not m.any():
        return
    dsm[m] = np.maximum(dsm[m], dtm[m].max() + h)
    kind[m] = BUILDING
    rough = cv2.GaussianBlur(rng.normal(0, 30, m.shape).astype(np.float32), (0, 0), 1.0)
    grey[m] = 0.35 * (grey[m] - grey[m].mean()) + rng.uniform(90, 190) + rough[m]


def _tree(grey, dtm, dsm, kind, cell, rng):
    rows, columns = dtm.shape
    rad, h = rng.uniform(1.5, 4), rng.uniform(5, 15)
    c0, r0 = rng.uniform(0, columns), rng.uniform(0, rows)
    k = int(np.ceil(rad / cell))
    ra, rb = max(0, int(r0) - k), min(rows, int(r0) + k + 1)
    ca, cb = max(0, int(c0) - k), min(columns, int(c0) + k + 1)
    rr, cc = np.mgrid[ra:rb, ca:cb]
    q = ((rr - r0) ** 2 + (cc - c0) ** 2) * cell**2 / rad**2
    top = dtm[int(r0), int(c0)]
    crown = top + h * (0.55 + 0.45 * np.sqrt(np.maximum(0, 1 - q)))
    rough = cv2.GaussianBlur(rng.normal(0, 1.2, q.shape).astype(np.float32), (0, 0), 2)
    crown = crown + 1.5 * rough
    m = (q < 1) & (crown > dsm[ra:rb, ca:cb])
    dsm[ra:rb, ca:cb][m] = crown[m]
    kind[ra:rb, ca:cb][m] = TREE
    g = grey[ra:rb, ca:cb]
    light = 15 * (c0 - cc[m]) * cell / rad
    g[m] = np.clip(70 + 0.5 * (g[m] - g[m].mean()) + light, 0, 255)
