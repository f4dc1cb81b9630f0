"""Scattered points become a surface in cells of equal size."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import LinearNDInterpolator


@dataclass(frozen=True, eq=False)
class Surface:
    """Heights in cells of equal size.

    Attributes
    ----------
    z : ndarray (rows, columns)
        Heights in m; NaN outside the hull of the points.
    corner : (X, Y)
        Middle of the cell in row 0 and column 0; Y falls with the row.
    cell : float
        Side of a cell.
    measured : ndarray (rows, columns) of bool
        Whether a point lies in the cell; the others are interpolated.
    """

    z: np.ndarray = field(repr=False)
    corner: tuple[float, float]
    cell: float
    measured: np.ndarray = field(repr=False)


def surface(points: ArrayLike, cell: float, *, extent=None) -> Surface:
    """Grid of heights by linear interpolation between points (n, 3)."""
    points = np.asarray(points, float)
    low, high = points[:, :2].min(0), points[:, :2].max(0)
    if extent is not None:
        low, high = np.array(extent[:2], float), np.array(extent[2:], float)
    columns, rows = np.ceil((high - low) / cell).astype(int)
    x = low[0] + cell * (np.arange(columns) + 0.5)
    y = high[1] - cell * (np.arange(rows) + 0.5)
    z = LinearNDInterpolator(points[:, :2], points[:, 2])(*np.meshgrid(x, y))
    c = ((points[:, 0] - low[0]) / cell).astype(int)
    r = ((high[1] - points[:, 1]) / cell).astype(int)
    inside = (c >= 0) & (c < columns) & (r >= 0) & (r < rows)
    has = np.zeros((rows, columns), bool)
    has[r[inside], c[inside]] = True
    return Surface(z, (float(x[0]), float(y[0])), cell, has)
