"""Points of the reference image to register, and the offset of two pixel grids."""

import os

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, matching
from pgm_lab.io.geotiff import Raster, same_crs, without_data
from pgm_lab.io.text import read_table

SAME_GRID = 0.01  # px that two grids may drift apart over an image


def grid(shape: tuple[int, int], step: int, margin: int = 13) -> np.ndarray:
    """Points on a square grid, centred in an image.

    Parameters
    ----------
    shape : (int, int)
        (rows, columns) of the reference image.
    step : int
        Pixels from one point to the next.
    margin : int
        Least distance of a point from the edge, in pixels: chip // 2 + radius keeps the
        chip and its search area inside the image.

    Returns
    -------
    ndarray (n, 2)
        (column, row), whole pixels, row by row.

    Raises
    ------
    ValueError
        If no pixel is left.

    Examples
    --------
    >>> grid((100, 160), 50, 20)
    array([[ 29.,  24.],
           [ 79.,  24.],
           [129.,  24.],
           [ 29.,  74.],
           [ 79.,  74.],
           [129.,  74.]])
    """
    rows, columns = (
        _validate.whole(n, "shape", 1) for n in _validate.of_shape(shape, (2,), "shape")
    )
    step = _validate.whole(step, "step", 1)
    margin = _validate.whole(margin, "margin", 0)
    if min(rows, columns) <= 2 * margin:
        raise ValueError(
            f"an image of {rows} x {columns} pixels has none that are {margin} px from"
            " its edge (margin)"
        )
    counts = [(n - 2 * margin - 1) // step + 1 for n in (columns, rows)]
    _validate.size("step", *counts, 2)
    x, y = (
        step * np.arange(m) + (n - 1 - step * (m - 1)) // 2
        for m, n in zip(counts, (columns, rows))
    )
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2).astype(float)


def pick(
    image: ArrayLike,
    number: int,
    chip: int = 21,
    radius: int = 3,
    *,
    sensed: ArrayLike | None = None,
    offset: ArrayLike = (0.0, 0.0),
) -> np.ndarray:
    """Pick points whose chips have texture, spread over the reference image.

    Texture is the smaller eigenvalue of the gradient matrix, as in `matching.pick`.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values of the reference image, 8 or 16 bit or float; masked or NaN where
        there are none.
    number : int
        How many points.
    chip : int
        Pixels across a chip, odd.
    radius : int
        Pixels that `register` searches to each side.
    sensed : array_like (rows, columns), optional
        The sensed image: no point is picked where it has no data within the radius.
    offset : array_like (2,)
        As for `register`.

    Returns
    -------
    ndarray (m, 2)
        (column, row), whole pixels, the best first; fewer than `number`, perhaps none,
        if there is too little overlap or texture.

    Raises
    ------
    ValueError
        If an image is smaller than a chip.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat_pair
    >>> one, other = landsat_pair()
    >>> points = pick(one.grey, 50, sensed=other.grey)
    >>> len(points), points.min() >= 13
    (50, np.True_)
    """
    image = _validate.grey_image(image, "image")
    chip = _validate.window(chip, "chip")
    radius = _validate.whole(radius, "radius", 0)
    offset = _validate.of_shape(offset, (2,), "offset")
    if sensed is not None:
        sensed = _validate.grey_image(sensed, "sensed")
    for one, name in ((image, "image"), (sensed, "sensed")):
        if one is not None and min(np.shape(one)) < chip:
            raise ValueError(
                f"{name} must have at least {chip} x {chip} pixels, as many as a chip;"
                f" got {np.shape(one)}"
            )
    if sensed is not None:
        none = without_data(image)
        mask = none | _unseen(image.shape, sensed, radius, offset)
        if mask.all() and not none.all():
            return np.zeros((0, 2))
        image = np.ma.array(np.ma.getdata(image), mask=mask)
    return matching.pick(image, number, chip, margin=chip // 2 + radius)


def _unseen(
    shape: tuple[int, ...], sensed: np.ndarray, radius: int, offset: np.ndarray
) -> np.ndarray:
    """Where the sensed image has no data within the radius, in reference pixels."""
    unseen = np.ones(shape, np.uint8)
    across, down = np.round(np.clip(offset, -(2**31), 2**31)).astype(int)
    left, top = max(0, -across), max(0, -down)
    right = min(shape[1], sensed.shape[1] - across)
    bottom = min(shape[0], sensed.shape[0] - down)
    if left < right and top < bottom:
        part = np.s_[top + down : bottom + down, left + across : right + across]
        unseen[top:bottom, left:right] = without_data(sensed[part])
    size = 2 * radius + 1
    return cv2.dilate(unseen, np.ones((size, size), np.uint8)) > 0


def read_points(path: str | os.PathLike, raster: Raster | None = None) -> np.ndarray:
    """Read points of the reference image from a text file.

    Parameters
    ----------
    path : str or path
        Two numbers a line, separated by a blank or a comma: column and row of a
        point, whole numbers at pixel centres.
    raster : Raster, optional
        The reference image: then the numbers are x and y on its map.

    Returns
    -------
    ndarray (n, 2)
        (column, row), in pixels.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If a line is not two numbers, or the raster has no georeference.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "points.csv")
    ...     _ = file.write_text("12, 34.5")
    ...     points = read_points(file)
    >>> points
    array([[12. , 34.5]])
    """
    names = ("column", "row") if raster is None else ("x", "y")
    points = read_table(path, "points", names, 0).values
    if raster is None:
        return points
    return _validate.instance(raster, Raster, "raster").pixels(points)


def offset(reference: Raster, sensed: Raster) -> np.ndarray:
    """Offset of the pixel indices between the two grids.

    A point of the map at (column, row) in the reference image is at (column, row) +
    offset in the sensed one: the argument of `register` and `fit`.

    Parameters
    ----------
    reference, sensed : Raster
        Either both with a georeference, in the same coordinate reference system and
        with the same pixel size, or both without.

    Returns
    -------
    ndarray (2,)
        In pixels, not rounded; zeros without georeference.

    Raises
    ------
    ValueError
        If the grids do not fit together (the message says what to do) or do not
        overlap.

    Examples
    --------
    >>> zeros = np.zeros((100, 100), np.uint8), np.zeros((100, 100), bool)
    >>> one = Raster(*zeros, np.array([[6.0, 0, 700_000], [0, -6, 9_320_000]]))
    >>> other = Raster(*zeros, np.array([[6.0, 0, 700_060], [0, -6, 9_320_015]]))
    >>> offset(one, other)
    array([-10. ,   2.5])
    """
    _validate.instance(reference, Raster, "reference")
    _validate.instance(sensed, Raster, "sensed")
    if reference.transform is None and sensed.transform is None:
        return np.zeros(2)
    for one, name in ((reference, "sensed"), (sensed, "reference")):
        if one.transform is None:
            raise ValueError(
                f"{one.path or 'one image'} has no georeference and the {name} image"
                " has one: cut both to the same area and remove it, or give the offset"
                " in pixels"
            )
    if not same_crs(reference.crs, sensed.crs):
        raise ValueError(
            "the images have different coordinate reference systems,"
            f" {reference.crs or 'none':.60} and {sensed.crs or 'none':.60}."
            f" {_advice(reference)}"
        )
    A, corner = reference.affine()
    other, other_corner = sensed.affine()
    size = max(*reference.grey.shape, *sensed.grey.shape)
    if np.abs(np.linalg.solve(A, other) - np.eye(2)).max() * size > SAME_GRID:
        sizes = (" x ".join(f"{s:.9g}" for s in np.hypot(*m)) for m in (A, other))
        raise ValueError(
            "the images have pixels of different size or direction,"
            f" {' and '.join(sizes)} map units. {_advice(reference)}"
        )
    found = np.linalg.solve(A, corner - other_corner)
    first = np.maximum(-found, 0)
    last = np.minimum(sensed.grey.shape[::-1] - found, reference.grey.shape[::-1])
    if np.any(last <= first):
        raise ValueError(
            "the images have no part of the map in common: the sensed one begins"
            f" {-found[0]:.0f} columns and {-found[1]:.0f} rows from the reference's"
            " first pixel"
        )
    return found


def _advice(reference: Raster) -> str:
    """What to do with a sensed image on another grid."""
    across, down = np.hypot(*reference.affine()[0])
    return (
        "Bring the sensed image onto the reference's grid first, for example with"
        f" gdalwarp -t_srs {reference.crs or 'none':.60} -tr {across:.9g} {down:.9g}"
        " -r cubic sensed.tif aligned.tif"
    )
