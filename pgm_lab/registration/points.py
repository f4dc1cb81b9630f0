"""Points of the reference image to register, and the offset of two pixel grids."""

import os
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, matching
from pgm_lab.image.grey import as_type
from pgm_lab.io.geotiff import INSTALL, Raster, installed, same_crs, without_data
from pgm_lab.io.text import read_table
from pgm_lab.matching.interest import LSM_REACH

ANY_MAP = "EPSG:3857"  # of two images whose map has no name
EXACT = 1e-3  # px that a resampled position may be off
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
    >>> grid((100, 160), 50, 20)[[0, -1]]
    array([[ 29.,  24.],
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
    chip = _validate.window(chip, "chip")
    reach = chip // 2 + _validate.whole(radius, "radius", 0)
    seen = None
    if sensed is not None:
        sensed = _validate.grey_image(sensed, "sensed", chip)
        offset = _validate.of_shape(offset, (2,), "offset")
        seen = partial(_seen, sensed, offset, reach)
    return matching.pick(image, number, chip, margin=reach, seen=seen)


def _seen(
    sensed: np.ndarray, offset: np.ndarray, reach: int, points: np.ndarray
) -> np.ndarray:
    """Whether the sensed image has data in all that is searched for points (m, 2)."""
    at = np.round(points + offset)
    seen = np.all((at >= reach) & (at + reach < sensed.shape[::-1]), axis=1)
    for k in np.flatnonzero(seen):
        left, top = np.maximum(at[k] - reach - LSM_REACH, 0).astype(int)
        right, bottom = at[k].astype(int) + reach + LSM_REACH + 1
        seen[k] = not without_data(sensed[top:bottom, left:right]).any()
    return seen


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
    if misfit := _misfit(reference, sensed):
        cure = "registration.common_grid brings both onto one grid"
        if (reference.crs is None) != (sensed.crs is None):
            cure = "Write the missing one into its file, by gdal_edit.py -a_srs"
        raise ValueError(f"the images have {misfit}. {cure}")
    A, corner = reference.affine()
    other_corner = sensed.affine()[1]
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


def _misfit(reference: Raster, sensed: Raster) -> str:
    """In what the grids of two images on the map differ, if they do."""
    if not same_crs(reference.crs, sensed.crs):
        names = (f"{one.crs or 'none':.60}" for one in (reference, sensed))
        return f"different coordinate reference systems, {' and '.join(names)}"
    A, other = reference.affine()[0], sensed.affine()[0]
    size = max(*reference.grey.shape, *sensed.grey.shape)
    if np.abs(np.linalg.solve(A, other) - np.eye(2)).max() * size <= SAME_GRID:
        return ""
    sizes = (" x ".join(f"{s:.9g}" for s in np.hypot(*m)) for m in (A, other))
    return f"pixels of different size or direction, {' and '.join(sizes)} map units"


def common_grid(reference: Raster, sensed: Raster) -> tuple[Raster, Raster]:
    """Bring two images of different maps, or pixels, onto one grid.

    It is that of the reference; with the pixels of the sensed image, if those are
    larger. Images that have one grid already are returned as they are.

    Parameters
    ----------
    reference, sensed : Raster
        As for `offset`.

    Returns
    -------
    reference, sensed : Raster
        Resampled by GDAL, cubic; the means of smaller pixels. Masked where there is no
        data.

    Raises
    ------
    ImportError
        If they have to be resampled, and rasterio is not installed.
    ValueError
        If one of them alone has a georeference or a coordinate reference system, or
        nothing of both is in the same place.

    Examples
    --------
    >>> grey = np.random.default_rng(1).integers(0, 255, (90, 90), dtype=np.uint8)
    >>> fine = Raster(grey, grey < 0, np.array([[2.0, 0, 0], [0, -2, 180]]))
    >>> coarse = Raster(grey, grey < 0, np.array([[6.0, 0, 0], [0, -6, 180]]))
    >>> [one.grey.shape for one in common_grid(fine, coarse)]
    [(30, 30), (30, 30)]
    """
    _validate.instance(reference, Raster, "reference")
    _validate.instance(sensed, Raster, "sensed")
    pair = reference, sensed
    placed = [one.transform is not None for one in pair]
    if not any(placed) or (all(placed) and not _misfit(*pair)):
        return pair
    if not all(placed) or (reference.crs is None) != (sensed.crs is None):
        offset(*pair)  # says what is wrong
    if not installed():
        raise ImportError(f"to bring both images onto one map, do this: {INSTALL}")
    from rasterio.errors import CRSError
    from rasterio.warp import transform

    # Area of a pixel in the middle of the sensed image, in pixels of the reference
    A, corner = reference.affine()
    middle = np.array(sensed.grey.shape[::-1]) / 2
    outline = sensed.map(middle + [(0, 0), (1, 0), (0, 1)])
    systems = (one.crs or ANY_MAP for one in (sensed, reference))
    try:
        there = np.column_stack(transform(*systems, *outline.T))
    except CRSError as error:
        raise ValueError(f"{sensed.path}: {error}") from None
    if not np.isfinite(there).all():
        raise ValueError("the images have no part of the map in common")
    area = np.linalg.det(np.linalg.solve(A, (there[1:] - there[0]).T))
    times = np.sqrt(np.abs(area))
    # The coarser of both
    if times > 1 + SAME_GRID / max(reference.grey.shape):
        # As many whole pixels as fit in, whatever the last digits of their size
        fit = times * (1 - SAME_GRID / max(reference.grey.shape))
        shape = [max(1, int(n / fit)) for n in reference.grey.shape]
        pixel = reference.pixel_size
        grid = replace(
            reference,
            grey=np.zeros(shape, np.uint8),
            mask=np.zeros(shape, bool),
            transform=np.column_stack([times * A, corner]),
            pixel_size=None if pixel is None else times * pixel,
        )
        reference = _warped(reference, grid)
    sensed = _warped(sensed, reference)
    if sensed.mask.all():
        raise ValueError("the images have no part of the map in common")
    return reference, sensed


def _warped(raster: Raster, grid: Raster) -> Raster:
    """An image in the pixels of another one; no data where it has none."""
    import rasterio
    from rasterio.io import MemoryFile
    from rasterio.vrt import WarpedVRT
    from rasterio.warp import Resampling

    there, here = (
        {
            **dict(zip(("height", "width"), one.grey.shape)),
            "transform": rasterio.Affine(*np.column_stack(one.affine()).ravel()),
            "crs": one.crs or ANY_MAP,
        }
        for one in (raster, grid)
    )
    there |= {"driver": "GTiff", "count": 1, "dtype": "float32", "nodata": np.nan}
    here |= {"tolerance": EXACT, "resampling": Resampling.cubic}
    with MemoryFile() as memory:
        with memory.open(**there) as file:
            file.write(np.where(raster.mask, np.nan, raster.grey).astype(np.float32), 1)
        # `rasterio.warp.reproject` is off by up to an eighth of a pixel
        with memory.open() as file, WarpedVRT(file, **here) as warped:
            found = warped.read(1)
    mask = ~np.isfinite(found)
    found[mask] = 0
    grey = as_type(found, raster.grey.dtype)
    place = {name: getattr(grid, name) for name in ("transform", "crs", "pixel_size")}
    return replace(raster, grey=grey, mask=mask, remark="", **place)
