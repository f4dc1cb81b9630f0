"""What is searched in the right image: windows, lines, pixels without data."""

from collections.abc import Callable

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

# --- Windows cut out of an image ---


def inside(centre: np.ndarray, size: int, shape: tuple[int, ...]) -> np.ndarray:
    """Whether a window of that size around each centre lies in an image."""
    half = size // 2
    return np.all((centre >= half) & (centre + half < shape[::-1]), axis=-1)


def windows(
    image: np.ndarray, centre: np.ndarray, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray | None]:
    """Windows (n, rows, columns) of an image, and where they lack data, or None."""
    # Missing pixels get the lowest grey value of their window, which does no harm to
    # the sums
    masked = np.ma.getmask(image) is not np.ma.nomask
    cut = cut_out(np.ma.getdata(image), centre, size)
    missing = cut_out(np.ma.getmaskarray(image), centre, size) if masked else None
    if cut.dtype.kind == "f":
        if cut.dtype.itemsize > 8:  # too large for double becomes infinite
            with np.errstate(over="ignore"):
                cut = cut.astype(float)
        bad = ~np.isfinite(cut)
        missing = bad if missing is None else missing | bad
    if missing is None or not missing.any():
        return cut, None
    highest = np.inf if cut.dtype.kind == "f" else cut.max(initial=0)
    lowest = np.where(missing, highest, cut).min(axis=(1, 2), keepdims=True)
    lowest = np.where(missing.all(axis=(1, 2), keepdims=True), 0, lowest)
    return np.where(missing, lowest, cut).astype(cut.dtype), missing


def touching(missing: np.ndarray, size: int) -> np.ndarray:
    """Which windows of that size, at each position, touch a pixel that is missing."""
    n = np.pad(missing.cumsum(axis=1).cumsum(axis=2), ((0, 0), (1, 0), (1, 0)))
    n = n[:, size:] - n[:, :-size]
    return n[:, :, size:] > n[:, :, :-size]


def nearest(place: np.ndarray, n: int) -> np.ndarray:
    """Rows or columns of n that stand for those at any place: the last, repeated."""
    return np.clip(place, 0, n - 1)


def cut_out(
    grey: np.ndarray,
    centre: np.ndarray,
    size: tuple[int, int],
    beyond: Callable[[np.ndarray, int], np.ndarray] = nearest,
) -> np.ndarray:
    """Windows of an image, which may go on beyond its edge."""
    half = np.array(size[::-1]) // 2
    first = (centre - half).astype(int)
    last = first + size[::-1]
    if np.all((first >= 0) & (last <= grey.shape[::-1])) and len(centre):
        column, row = first.T
        return sliding_window_view(grey, size)[row, column]
    column = beyond(first[:, :1] + np.arange(size[1]), grey.shape[1])
    row = beyond(first[:, 1:] + np.arange(size[0]), grey.shape[0])
    return grey[row[:, :, None], column[:, None, :]]


# --- Positions of the template in a search window ---


def overlaps(
    centre: np.ndarray, size: tuple[int, int], shape: tuple[int, ...], template: int
) -> np.ndarray:
    """Whether a template fits into what the image and each search window share."""
    half = np.array(size[::-1]) // 2
    first = np.maximum(centre - half, 0)
    end = np.minimum(centre + half + 1, shape[::-1])
    return np.all(end - first >= template, axis=1)


def positions(
    centre: np.ndarray, size: tuple[int, int], template: int
) -> tuple[np.ndarray, np.ndarray]:
    """Columns (n, 1, C) and rows (n, R, 1) of the template all over search windows."""
    rows, columns = (
        np.arange(one - template + 1) - (one - template) // 2 for one in size
    )
    return (centre[:, :1] + columns)[:, None, :], (centre[:, 1:] + rows)[:, :, None]


def within(
    column: np.ndarray, row: np.ndarray, template: int, shape: tuple[int, ...]
) -> np.ndarray:
    """Positions (n, R, C) where the template lies in the image."""
    half = template // 2
    across = (column >= half) & (column + half < shape[1])
    down = (row >= half) & (row + half < shape[0])
    return np.logical_and(across, down)


def near(
    column: np.ndarray, row: np.ndarray, lines: np.ndarray, distance: float
) -> np.ndarray:
    """Positions (n, R, C) that are not farther from their lines than that."""
    a, b, c = lines.T[:, :, None, None]
    away = np.abs(a * column + b * row + c)
    return np.asarray(away <= distance)


def beside(marked: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Whether one of the eight neighbours of a position is marked."""
    padded = np.pad(marked, ((0, 0), (1, 1), (1, 1)))
    n, around = np.arange(len(marked))[:, None, None], np.arange(3)
    rows, columns = row[:, None, None] + around[:, None], column[:, None, None] + around
    return np.asarray(padded[n, rows, columns].any(axis=(1, 2)))


def rim(size: tuple[int, ...]) -> np.ndarray:
    """True in the first and last row and column of a map."""
    marked = np.ones(size[-2:], dtype=bool)
    marked[1:-1, 1:-1] = False
    return marked


# --- Lines, with normals of length one ---


def foot(point: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """The points (n, 2) on the lines that are nearest to the given ones."""
    return point - distance(point, lines)[:, None] * lines[:, :2]


def distance(point: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """How far (n,) points lie from their lines, on the side of the normal."""
    return np.sum(lines[:, :2] * point, axis=1) + lines[:, 2]


def through(point: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """The lines (n, 3) that run through the points, parallel to others."""
    normal = lines[:, :2]
    return np.column_stack([normal, -np.sum(normal * point, axis=1)])
