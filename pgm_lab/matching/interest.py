"""Points of a photo that can be matched well: texture in all directions, spread out."""

import itertools
from collections.abc import Callable

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.io.geotiff import without_data

TILE = 1000  # pixels along a side of what is done at a time
LSM_REACH = 10  # pixels around a template that `lsm.match` uses, and one to spare
SHRINK = 1.2  # by which the cells shrink until there are enough points


def pick(
    image: ArrayLike,
    number: int,
    template: int = 21,
    *,
    margin: int | None = None,
    least: float = 0.01,
    seen: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Pick points whose templates have texture, spread over the photo.

    The best point of each grid cell is taken; the cells are as large as possible for
    this number.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values, 8 or 16 bit or float; masked or NaN where there are none.
    number : int
        How many points.
    template : int
        Pixels across the template that is matched around each point, odd.
    margin : int, optional
        Pixels from the edge of the photo to a point, at least template // 2, which is
        the default.
    least : float
        Smallest texture, as a share of that of the best points (the 95th percentile of
        all cells); between 0 and 1.
    seen : function, optional
        Which points (m, 2) the other image shows (m,): no others are picked.

    Returns
    -------
    ndarray (m, 2)
        (column, row), whole pixels, the best first. Fewer than `number` where the photo
        has no more texture; perhaps none.

    Raises
    ------
    ValueError
        If an argument is not as described here, or the photo is smaller than a
        template.

    Notes
    -----
    Texture is the smaller eigenvalue of the matrix of the products of both gradients,
    summed over the template: the inverse of the larger variance that a match can have
    (Foerstner and Guelch 1987; Shi and Tomasi 1994).

    Examples
    --------
    >>> from pgm_lab import datasets
    >>> points = pick(datasets.yellowstone().grey, 100)
    >>> len(points), points.min() >= 10, points.max() <= 1525
    (100, np.True_, np.True_)
    """
    number = _validate.whole(number, "number", 1)
    template = _validate.window(template, "template")
    grey = _validate.grey_image(image, "image", template)
    if grey.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        grey = grey.astype(float)
    mask = without_data(grey)
    if mask.all():
        raise ValueError("image has no data: all pixels are masked, NaN or infinite")
    if not mask.any():
        mask = np.broadcast_to(False, mask.shape)  # of no size in memory
    half = template // 2
    margin = half if margin is None else _validate.whole(margin, "margin", half)
    if not 0 <= _validate.number(least, "least") < 1:
        raise ValueError(f"least must be at least 0 and below 1; got {least}")
    space = np.sqrt(grey.size / number)  # between points, if all were textured
    cell = max(2, half, int(space / 4))
    points, texture = _best_of_cells(np.ma.getdata(grey), mask, template, margin, cell)
    if seen is not None:
        texture[~seen(points)] = 0
    good = texture >= max(least * np.percentile(texture, 95), np.finfo(float).tiny)
    points, texture = points[good], texture[good]
    order = np.argsort(-texture, kind="stable")
    return points[order][spread(points[order], number, space, cell)].astype(float)


def _best_of_cells(
    grey: np.ndarray, mask: np.ndarray, template: int, margin: int, cell: int
) -> tuple[np.ndarray, np.ndarray]:
    """Best point (m, 2) of each square cell, and its texture (m,); tile by tile."""
    rows, columns = grey.shape
    border = template // 2 + LSM_REACH  # what the texture of a pixel depends on
    side = max(1, TILE // cell) * cell
    points, texture = [], []
    for corner in itertools.product(range(0, rows, side), range(0, columns, side)):
        (y, top), (x, left) = ((max(0, at - border), at) for at in corner)
        part = np.s_[y : top + side + border, x : left + side + border]
        found = _texture(grey[part], mask[part], template)
        found = found[top - y :, left - x :][:side, :side]
        for values, first, n in ((found, top, rows), (found.T, left, columns)):
            at = first + np.arange(len(values))
            values[(at < margin) | (at >= n - margin)] = 0
        found = np.pad(found, [(0, -n % cell) for n in found.shape])
        wide = found.shape[1] // cell
        of_cells = found.reshape(-1, cell, wide, cell).swapaxes(1, 2)
        cells = of_cells.reshape(-1, wide, cell * cell)
        best = cells.argmax(axis=2)
        i, j = np.indices(best.shape)
        at = np.stack([j * cell + best % cell, i * cell + best // cell], -1)
        points.append((at + (left, top)).reshape(-1, 2))
        texture.append(cells.max(axis=2).ravel())
    return np.concatenate(points), np.concatenate(texture)


def _texture(grey: np.ndarray, mask: np.ndarray, template: int) -> np.ndarray:
    """The smaller eigenvalue for the template around each pixel; 0 without data."""
    if mask.all():
        return np.zeros(grey.shape, np.float32)
    values = grey.astype(np.float32)
    masked = mask.any()
    if masked:
        values[mask] = values[~mask].mean()
    found = cv2.cornerMinEigenVal(values, template, ksize=3)
    if masked:
        around = np.ones((template + 2 * LSM_REACH, template + 2 * LSM_REACH), np.uint8)
        found[cv2.dilate(mask.astype(np.uint8), around) > 0] = 0
    return found


def spread(points: np.ndarray, number: int, space: float, least: float) -> np.ndarray:
    """Indices of at most `number` points, the first ones, as far apart as possible."""
    space = max(space, least)
    chosen = _apart(points, space)
    while len(chosen) < number and space > least:
        space = max(space / SHRINK, least)
        chosen = _apart(points, space)
    return chosen[:number]


def _apart(points: np.ndarray, space: float) -> np.ndarray:
    """Indices of the first points of each cell, none close to an earlier one."""
    cell = np.floor(points / space).astype(np.int64)
    _, first = np.unique(cell, axis=0, return_index=True)
    k = np.sort(first)
    tree = scipy.spatial.cKDTree(points[k])
    close = tree.query_pairs(space / 2, output_type="ndarray")
    return np.delete(k, np.unique(close.max(axis=1))) if len(close) else k
