"""Sun on a surface: slopes that face it are bright, and what stands throws a shadow."""

import numpy as np

AZIMUTH, ELEVATION = np.radians(235.0), np.radians(48.0)  # of the sun
SKY = 0.5  # share of the light that comes from the whole sky, on level ground
TALLEST = 25.0  # m, no shadow is longer than that of a tree so tall
BAND = 256  # rows at a time


def lighten(albedo: np.ndarray, dsm: np.ndarray, cell: float) -> np.ndarray:
    """Grey values (rows, columns) under the sun; level ground in it stays as it is."""
    shadow = _shadow(dsm, cell)
    east, north, up = (
        np.cos(ELEVATION) * np.sin(AZIMUTH),
        np.cos(ELEVATION) * np.cos(AZIMUTH),
        np.sin(ELEVATION),
    )
    grey = np.empty_like(albedo)
    for a in range(0, len(dsm), BAND):
        b = min(a + BAND, len(dsm))
        first = max(0, a - 1)
        z = dsm[first : b + 1]
        down, right = np.gradient(z, cell)
        inner = np.s_[a - first : a - first + b - a]
        p, q = np.clip(right[inner], -1.5, 1.5), np.clip(-down[inner], -1.5, 1.5)
        towards = (up - p * east - q * north) / (up * np.sqrt(1 + p**2 + q**2))
        lit = 1 - np.clip((shadow[a:b] - dsm[a:b]) / 0.6, 0, 1)
        light = SKY + (1 - SKY) * lit * np.clip(towards, 0, 1.3)
        grey[a:b] = np.clip(albedo[a:b] * light, 12, 238)
    return grey


def _shadow(dsm: np.ndarray, cell: float) -> np.ndarray:
    """Height below which the sun does not reach, at each cell.

    The shadow of a point falls off with the distance; the highest over all distances up
    to 2^n cells is that up to 2^(n-1), and the same from so many cells further on.
    """
    height = dsm.copy()
    drop = np.tan(ELEVATION) * cell
    rows, columns = dsm.shape
    length = 1
    while length * drop < TALLEST:
        dc = round(-length * np.sin(AZIMUTH))  # away from the sun
        dr = round(length * np.cos(AZIMUTH))
        if abs(dr) >= rows or abs(dc) >= columns:
            break
        to_r, from_r = _moved(dr, rows)
        to_c, from_c = _moved(dc, columns)
        lower = height[from_r, from_c] - np.float32(length * drop)
        np.maximum(height[to_r, to_c], lower, out=height[to_r, to_c])
        length *= 2
    return height


def _moved(by: int, n: int) -> tuple[slice, slice]:
    """Where n values land that move by so many cells, and which of them do."""
    return slice(max(0, by), n + min(0, by)), slice(max(0, -by), n - max(0, by))
