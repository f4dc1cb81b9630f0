"""Grey values of a photo in the pixels of another image, in bands of rows."""

from collections.abc import Callable

import cv2
import numpy as np
import scipy

from pgm_lab.camera.photo import Photo

# Places are computed exactly for every so many pixels, and linearly between
STEP = 4

# Rows that are filled at once
BAND = 256

# Pixels of the photo in one of the image from which fine texture is taken out before
FINER = 1.2


def resampled(
    photo: Photo,
    rays: Callable[[np.ndarray, np.ndarray], np.ndarray],
    size: tuple[int, int],
    ratio: float,
) -> np.ndarray:
    """Image (rows, columns) of float32; NaN where the photo shows nothing.

    `rays` tells the directions in object space of a mesh of columns and rows; `ratio`
    is how many pixels of the photo go into one of the image.
    """
    columns, rows = size
    # Two more than are needed at the end, between which the last pixels lie
    x, y = (STEP * np.arange((n - 1) // STEP + 2.0) for n in size)
    places = photo.seen_at(rays(x, y))
    spline, lacking = _prepared(photo.grey, ratio)
    last = np.array(spline.shape[::-1]) - 1
    image = np.empty((rows, columns), np.float32)
    for first in range(0, rows, BAND):
        band = slice(first, min(first + BAND, rows))
        at = _between(places, np.arange(band.start, band.stop), columns)
        # A hair of rounding does not push the outermost pixel out
        out = ~((at >= -1e-6) & (at <= last + 1e-6)).all(-1)
        at[out] = 0
        grey = scipy.ndimage.map_coordinates(
            spline, [at[..., 1], at[..., 0]], output=np.float32, order=3,
            mode="mirror", prefilter=False,
        )  # fmt: skip
        if lacking is not None:
            x, y = np.moveaxis(at.astype(np.float32), -1, 0)
            out |= cv2.remap(lacking, x, y, cv2.INTER_LINEAR) > 0
        grey[out] = np.nan
        image[band] = grey
    return image


def _between(places: np.ndarray, rows: np.ndarray, columns: int) -> np.ndarray:
    """Places (rows, columns, 2) by linear interpolation."""

    def interpolated(values: np.ndarray, n: np.ndarray, axis: int) -> np.ndarray:
        k, t = n // STEP, n % STEP / STEP
        t = t[:, None, None] if axis == 0 else t[:, None]
        a, b = values.take(k, axis), values.take(k + 1, axis)
        return a + t * (b - a)

    return interpolated(interpolated(places, rows, 0), np.arange(columns), 1)


def _prepared(grey: np.ndarray, ratio: float) -> tuple[np.ndarray, np.ndarray | None]:
    """Coefficients of a cubic spline, and 1 where there are no grey values."""
    values: np.ndarray = np.ma.getdata(grey).astype(np.float32)
    none = ~np.isfinite(values) | np.ma.getmaskarray(grey)
    lacking = None
    if none.any():
        if none.all():
            raise ValueError("a photo has no grey values at all")
        lacking = none.astype(np.float32)
        # The nearest grey value, so that no spline swings at the holes
        nearest = scipy.ndimage.distance_transform_edt(
            none, return_distances=False, return_indices=True
        )
        values = values[tuple(nearest)]
    if ratio > FINER:
        values = cv2.GaussianBlur(values, (0, 0), 0.5 * np.sqrt(ratio**2 - 1))
    spline = scipy.ndimage.spline_filter(values, 3, output=np.float32, mode="mirror")
    return spline, lacking
