"""Scattered points become a surface in cells of equal size."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.stereo.heights import Points

# Layers of `Surface.source`: where a height comes from, or why there is none
SOURCES = ("measured", "interpolated", "outside the points", "gap too wide")


@dataclass(frozen=True, eq=False)
class Surface:
    """Heights in cells of equal size.

    Attributes
    ----------
    z : ndarray (rows, columns)
        Heights in m; NaN where the points determine none.
    corner : (X, Y)
        Centre of the cell in row 0 and column 0; Y decreases with the row.
    cell : float
        Side of a cell in m.
    measured : ndarray (rows, columns) of bool
        Whether a point lies in the cell; the others are interpolated.
    n : ndarray (rows, columns) of int, optional
        Number of points in the cell.
    sd : ndarray (rows, columns), optional
        Standard deviation of their heights; NaN for fewer than two.
    outside : ndarray (rows, columns) of bool, optional
        Whether the cell lies outside the hull of the points.
    largest_gap : float, optional
        Width in m of the widest gap that was interpolated; infinite for any.
    crs : str, optional
        Coordinate reference system, where it is known.
    """

    z: np.ndarray = field(repr=False)
    corner: tuple[float, float]
    cell: float
    measured: np.ndarray = field(repr=False)
    n: np.ndarray | None = field(default=None, repr=False)
    sd: np.ndarray | None = field(default=None, repr=False)
    outside: np.ndarray | None = field(default=None, repr=False)
    largest_gap: float | None = None
    crs: str | None = field(default=None, repr=False)

    @cached_property
    def source(self) -> np.ndarray:
        """Where each height comes from (rows, columns): index into `SOURCES`."""
        missing = np.isnan(self.z)
        outside = missing if self.outside is None else missing & self.outside
        return np.select(
            [outside, missing, self.measured], [2, 3, 0], default=1
        ).astype(np.uint8)

    @cached_property
    def filled(self) -> float:
        """Share of the heights that are interpolated; NaN if there are none."""
        known = ~np.isnan(self.z)
        return float((known & ~self.measured).sum() / (known.sum() or np.nan))

    @property
    def message(self) -> str:
        """How many cells have a height, how many of these are filled, in words."""
        known, gap = np.mean(~np.isnan(self.z)), self.largest_gap
        width = "any width" if gap == np.inf else f"up to {gap or 0:.3g} m"
        return (
            f"{known:.0%} of the cells have a height; {self.filled:.0%} of these are"
            f" interpolated{'' if gap is None else f', in gaps of {width}'}"
        )

    def grid(self) -> tuple[np.ndarray, np.ndarray]:
        """X and Y (rows, columns) of the centres of the cells."""
        rows, columns = self.z.shape
        x = self.corner[0] + self.cell * np.arange(columns)
        y = self.corner[1] - self.cell * np.arange(rows)
        return tuple(np.meshgrid(x, y))


def surface(
    points: Points | ArrayLike,
    cell: float,
    *,
    extent: tuple[float, ...] | None = None,
    largest_gap: float | None = None,
) -> Surface:
    """Grid of heights by linear interpolation between points.

    The points of a cell are represented by the one of median height, on which a blunder
    has little effect; triangles between these (Delaunay) give the heights at the cell
    centres. Outside the hull of the points there is no height.

    Parameters
    ----------
    points : Points or array_like (n, 3)
        Object points in m, in any order; rows with NaN are left out.
    cell : float
        Side of a cell in m.
    extent : (X least, Y least, X most, Y most), optional
        What the cells cover, from outer edge to outer edge; default: all points.
        Points outside help to interpolate at its edge.
    largest_gap : float, optional
        Width in m of the widest gap between cells with points that is interpolated:
        in a triangle with a side longer than this and a cell, the others have no
        height. When missing four times the mean spacing of the points, or two cells if
        that is more: wider gaps are not by chance (no point lies in the circle around a
        triangle: exp(-4 pi)), but water, shadow or hidden ground. With `np.inf` any gap
        inside the hull is filled.

    Returns
    -------
    Surface

    Raises
    ------
    ValueError
        If an argument is not as described here, the points lie in fewer than three
        cells or on one line, or the cells would be more than 10^8.

    Examples
    --------
    >>> corners = [(0, 0, 1), (4, 0, 1), (4, 4, 5), (0, 4, 5)]
    >>> surface(corners, 1.0).z
    array([[4.5, 4.5, 4.5, 4.5],
           [3.5, 3.5, 3.5, 3.5],
           [2.5, 2.5, 2.5, 2.5],
           [1.5, 1.5, 1.5, 1.5]])
    """
    crs = points.crs if isinstance(points, Points) else None
    points = _known(points.xyz if isinstance(points, Points) else points)
    cell = _validate.positive_number(cell, "cell", "in metres")
    largest_gap = gap_width(largest_gap)
    low, high = _box(points, extent)
    shape = _shape(low, high, cell)

    # For each cell with points, the one of median height
    position = np.stack([points[:, 0] - low[0], high[1] - points[:, 1]], -1) / cell
    at = np.floor(position).astype(np.int64)
    at[position == shape[::-1]] -= 1  # the last edge belongs to the last cell
    middle, cells, n, sd = _one_each(position, points[:, 2], at)
    inside = ((cells >= 0) & (cells < shape[::-1])).all(-1)
    columns, rows = cells[inside].T
    number, spread = np.zeros(shape, np.int32), np.full(shape, np.nan)
    number[rows, columns], spread[rows, columns] = n[inside], sd[inside]
    measured = number > 0

    # Triangles between them
    linear, centres = _triangles(middle), _centres(shape) - middle[0, :2]
    z = linear(centres)
    outside = np.isnan(z) & ~measured
    corners = linear.tri.points[linear.tri.simplices]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    if largest_gap is None:
        # One point stands for the n of its cell
        spacing = np.median(sides) / np.sqrt(n.mean())
        largest_gap = float(cell * max(4 * spacing, 2))
    if largest_gap < np.inf:
        wide = sides.max(-1) > largest_gap / cell + 1
        z[wide[linear.tri.find_simplex(centres)]] = np.nan
    # A cell with a point has its height also at a rim, where the centre has none
    rim = np.isnan(z[rows, columns])
    z[rows[rim], columns[rim]] = middle[inside][rim, 2]
    corner = (float(low[0] + cell / 2), float(high[1] - cell / 2))
    return Surface(z, corner, cell, measured, number, spread, outside, largest_gap, crs)


def gap_width(largest_gap: float | None) -> float | None:
    """Return the width of a gap as one number above zero, infinity too, or None."""
    if largest_gap is None or isinstance(largest_gap, float) and largest_gap == np.inf:
        return largest_gap
    return _validate.positive_number(largest_gap, "largest_gap", "in metres")


def _known(points: ArrayLike) -> np.ndarray:
    points = _validate.real(points, "points")
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(
            f"points must have shape (n, 3), one (X, Y, Z) a row; got {points.shape}"
        )
    _validate.refuse(np.isinf(points).any(-1), "points{} are infinite")
    known = points[~np.isnan(points).any(-1)]
    if len(known) < 3:
        raise ValueError(f"a surface needs three points or more; got {len(known)}")
    return known


def _box(
    points: np.ndarray, extent: tuple[float, ...] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest (X, Y) of what the cells cover."""
    if extent is None:
        return points[:, :2].min(0), points[:, :2].max(0)
    box = _validate.of_shape(extent, (4,), "extent")
    if not (box[:2] < box[2:]).all():
        raise ValueError(
            f"extent must be (X least, Y least, X most, Y most); got {box.tolist()}"
        )
    return box[:2], box[2:]


def _shape(low: np.ndarray, high: np.ndarray, cell: float) -> tuple[int, int]:
    """Rows and columns; an edge that is off by rounding makes no cell of its own."""
    columns, rows = np.maximum(np.ceil((high - low) / cell - 1e-9), 1)
    if rows * columns > _validate.MAX_NUMBERS:
        raise ValueError(
            f"cells of {cell:g} m would be {rows:.0f} x {columns:.0f}, more than 10^8:"
            " take larger cells or a smaller extent"
        )
    return int(rows), int(columns)


def _one_each(
    position: np.ndarray, z: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """For each cell with points: the one of median height, cell, number and spread."""
    order = np.lexsort((z, at[:, 0], at[:, 1]))
    xyz = np.column_stack([position, z])[order]
    at = at[order]
    new = np.ones(len(at), bool)
    new[1:] = (at[1:] != at[:-1]).any(-1)
    first = np.flatnonzero(new)
    n = np.diff(first, append=len(at))
    if len(first) < 3:
        raise ValueError(
            f"all points lie in {len(first)} cell(s), and a surface needs three or"
            " more: take smaller cells"
        )
    # For an even number the mean of the two middle ones, which lies on their plane
    middle = (xyz[first + (n - 1) // 2] + xyz[first + n // 2]) / 2
    heights = xyz[:, 2] - np.repeat(middle[:, 2], n)
    sums, squares = (np.add.reduceat(v, first) for v in (heights, heights**2))
    with np.errstate(invalid="ignore", divide="ignore"):
        sd = np.sqrt(np.maximum(squares - sums**2 / n, 0) / np.where(n > 1, n - 1, 0))
    return middle, at[first], n, sd


def _triangles(middle: np.ndarray) -> scipy.interpolate.LinearNDInterpolator:
    """Heights of triangles between points, whose positions count from the first one."""
    try:
        return scipy.interpolate.LinearNDInterpolator(
            middle[:, :2] - middle[0, :2], middle[:, 2]
        )
    except scipy.spatial.QhullError:
        raise ValueError(
            "the points lie on one line, seen from above: there is no surface between"
            " them"
        ) from None


def _centres(shape: tuple[int, int]) -> np.ndarray:
    """Column and row (rows, columns, 2) of the centres of the cells."""
    return np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in shape[::-1])), -1)
