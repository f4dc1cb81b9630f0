"""The sensed image drawn again in the pixels of the reference image."""

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.image import resample as grey_between
from pgm_lab.image.resampling import METHODS
from pgm_lab.io.geotiff import MAX_PIXELS, without_data
from pgm_lab.registration.model import Model

STRIP = 1_000_000  # pixels at a time
# Pixels around a place that its grey value rests on. Of a spline these are all, but
# the share of a pixel falls to 0.27 of its neighbour's (0.43 of the quintic spline's).
REACH = {"nearest": 1, "bilinear": 1, "cubic": 2, "spline3": 20, "spline5": 30}


def resample(
    sensed: ArrayLike,
    model: Model,
    shape: tuple[int, int],
    *,
    method: str = "spline3",
) -> np.ma.MaskedArray:
    """Resample the sensed image into the pixels of the reference image.

    Parameters
    ----------
    sensed : array_like (rows, columns)
        Grey values, 8 or 16 bit or float; masked or NaN where there are none.
    model : Model
        From `fit`.
    shape : (int, int)
        (rows, columns) of the reference image.
    method : {"nearest", "bilinear", "cubic", "spline3", "spline5"}
        How grey values between pixels are found, as in `image.resample`.

    Returns
    -------
    MaskedArray (rows, columns)
        In the type of the sensed image, rounded and clipped to what it holds. Masked
        outside the sensed image, and where one of the 4 x 4 pixels around has no data
        (of the 2 x 2 if bilinear, the nearest if nearest); 0 under the mask.

    Raises
    ------
    ValueError
        If an argument is not what is described here.

    Notes
    -----
    It works strip by strip: besides both images it needs little memory.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> from pgm_lab.registration import fit, grid, register
    >>> image = landsat().grey[:300, :300]
    >>> moved = np.roll(image, (-2, -1), axis=(0, 1))
    >>> found = register(image, moved, grid(image.shape, 40, 20), refine="lsm")
    >>> again = resample(moved, fit(found), image.shape)
    >>> again.shape, again.dtype, abs(again.astype(float) - image).mean() < 1
    ((300, 300), dtype('uint16'), np.True_)
    """
    sensed = _validate.grey_image(sensed, "sensed", least=2)
    grey, bad = np.ma.getdata(sensed), without_data(sensed)
    _validate.instance(model, Model, "model")
    rows, columns = (
        _validate.whole(n, "shape", 1) for n in _validate.of_shape(shape, (2,), "shape")
    )
    if rows * columns > MAX_PIXELS:
        raise ValueError(
            f"shape asks for {rows} x {columns} pixels; the limit is {MAX_PIXELS}. It"
            " must be (rows, columns) of the reference image"
        )
    method = _validate.choice(method, "method", METHODS)
    values = np.zeros((rows, columns), grey.dtype)
    mask = np.ones((rows, columns), bool)
    at_once = max(1, STRIP // columns)
    for top in range(0, rows, at_once):
        part = slice(top, min(top + at_once, rows))
        row, column = np.mgrid[part, 0:columns]
        places = model.apply(np.stack([column, row], axis=-1))
        _draw(values[part], mask[part], grey, bad, places, method)
    return np.ma.array(values, mask=mask)


def _draw(
    values: np.ndarray,
    mask: np.ndarray,
    grey: np.ndarray,
    bad: np.ndarray,
    places: np.ndarray,
    method: str,
) -> None:
    """Put grey values of a strip into `values`, and uncover what has some."""
    rows, columns = grey.shape
    x, y = np.moveaxis(places, -1, 0)
    inside = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    if not inside.any():
        return
    places = places[inside]
    reach = REACH[method]
    first = np.maximum(np.floor(places.min(axis=0)).astype(int) - reach, 0)
    last = np.minimum(
        np.floor(places.max(axis=0)).astype(int) + reach + 2, (columns, rows)
    )
    first = np.minimum(first, last - 2)
    window = np.s_[first[1] : last[1], first[0] : last[0]]
    piece, places = grey[window].astype(float), places - first
    known = np.ones(len(places), bool)
    if bad[window].any():
        holes = bad[window]
        if holes.all():
            return
        known = ~_touches(holes, places, method)
        nearest = scipy.ndimage.distance_transform_edt(
            holes, return_distances=False, return_indices=True
        )
        piece = piece[tuple(nearest)]  # so that no spline swings at the holes
    found = grey_between(piece, places[known], method)
    k = np.flatnonzero(inside)[known]
    values.reshape(-1)[k] = _in_type(found, grey.dtype)
    mask.reshape(-1)[k] = False


def _touches(holes: np.ndarray, places: np.ndarray, method: str) -> np.ndarray:
    """Whether a pixel around each place, which its value rests on, has no data."""
    if method == "nearest":
        first, many = np.floor(places + 0.5).astype(int), 1
    elif method == "bilinear":
        first, many = np.floor(places).astype(int), 2
    else:
        first, many = np.floor(places).astype(int) - 1, 4
    across = np.clip(first[:, 0] + np.arange(many)[:, None], 0, holes.shape[1] - 1)
    down = np.clip(first[:, 1] + np.arange(many)[:, None], 0, holes.shape[0] - 1)
    return np.any(holes[down[:, None], across[None]], axis=(0, 1))


def _in_type(values: np.ndarray, dtype: np.dtype) -> np.ndarray:
    """Grey values in a type, rounded and clipped to what it holds."""
    if dtype.kind == "f":
        return values.astype(dtype)
    if dtype.kind == "b":
        return np.round(values).astype(bool)
    limits = np.iinfo(dtype)
    return np.clip(np.round(values), limits.min, limits.max).astype(dtype)
