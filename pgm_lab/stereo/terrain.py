"""From the surface to the terrain: isolate what stands on it, interpolate below."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy.interpolate import LinearNDInterpolator

from pgm_lab.stereo.grid import Surface

# Layers of `Terrain.origin`
ORIGINS = ("ground", "interpolated under an object", "interpolated", "nothing")


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights of the ground.

    Attributes
    ----------
    z : ndarray (rows, columns)
    origin : ndarray (rows, columns) of uint8
        Where each height comes from: index into `ORIGINS`.
    corner, cell
        As in `Surface`.
    """

    z: np.ndarray = field(repr=False)
    origin: np.ndarray = field(repr=False)
    corner: tuple[float, float]
    cell: float


def filter_terrain(
    dsm: Surface, *, slope: float = 0.3, widest: float = 40.0, least: float = 0.5
) -> Terrain:
    """DTM of a DSM: a slope-aware morphological filter in growing windows."""
    z = np.where(np.isnan(dsm.z), np.nanmax(dsm.z), dsm.z).astype(np.float32)
    objects = np.zeros(z.shape, bool)
    size, last = 3, z
    while size * dsm.cell <= widest:
        opened = cv2.morphologyEx(last, cv2.MORPH_OPEN, np.ones((size, size), np.uint8))
        objects |= last - opened > least + slope * (size // 2) * dsm.cell
        last, size = opened, 2 * size + 1
    ground = ~objects & ~np.isnan(dsm.z)
    r, c = np.nonzero(ground)
    filled = LinearNDInterpolator(np.stack([c, r], -1)[::3], dsm.z[r, c][::3])
    R, C = np.nonzero(objects)
    out = np.where(ground, dsm.z, np.nan)
    out[R, C] = filled(C, R)
    origin = np.where(objects, 1, np.where(dsm.measured, 0, 2)).astype(np.uint8)
    origin[np.isnan(out)] = 3
    return Terrain(out, origin, dsm.corner, dsm.cell)
