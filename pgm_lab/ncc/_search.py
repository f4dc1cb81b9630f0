"""Which positions in the right image are searched, and where a peak may be cut off."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


def size(search: int | tuple[int, int], template: int) -> tuple[int, int]:
    """Rows and columns of the search window."""
    given = search if isinstance(search, tuple | list) else (search, search)
    if len(given) != 2:
        raise ValueError(
            "search must be one number or (rows, columns); got"
            f" {_validate.shown(search)}"
        )
    rows, columns = (_validate.window(one, "search") for one in given)
    if min(rows, columns) < template + 2:
        raise ValueError(
            f"search must be at least template + 2 = {template + 2}, or there is"
            f" nothing to search; got {search}"
        )
    return rows, columns


def normal_form(lines: ArrayLike, n: int) -> np.ndarray:
    """Lines (n, 3) with normals (a, b) of length one."""
    array = _validate.of_shape(lines, (n, 3), "lines")
    length = np.hypot(array[:, 0], array[:, 1])
    _validate.refuse(length == 0, "lines{} have a = b = 0: they are no lines")
    return array / length[:, None]


def foot(point: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """The places (n, 2) on the lines that are nearest to the points."""
    return point - distance(point, lines)[:, None] * lines[:, :2]


def distance(point: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """How far (n,) points lie from their lines, on the side of the normal."""
    return np.sum(lines[:, :2] * point, axis=1) + lines[:, 2]


def through(point: np.ndarray, lines: np.ndarray) -> np.ndarray:
    """The lines (n, 3) that run through the points, parallel to others."""
    normal = lines[:, :2]
    return np.column_stack([normal, -np.sum(normal * point, axis=1)])


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
