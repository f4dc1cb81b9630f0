"""The parts of an image around the points that are matched, ready to be resampled."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.lsm import _fine

LARGEST = 32_766  # px, what cv2.remap can address
SPLINE = -1  # besides OpenCV's names
# Methods of resampling, from rough to fine, and the pixels to each side they rest on
# (the spline takes coefficients up to a pixel away)
METHODS = {cv2.INTER_LINEAR: 1, cv2.INTER_LANCZOS4: 4, SPLINE: _fine.REACH + 1}


@dataclass(frozen=True)
class Parts:
    """The image around m windows: the parts stand below each other in one array.

    `grey` holds grey values in single precision, or the coefficients of a spline;
    `corner` (m, 2) takes columns and rows of the image to those of the array.
    """

    grey: np.ndarray
    corner: np.ndarray
    method: int

    @classmethod
    def of(
        cls,
        image: np.ndarray,
        means: np.ndarray,
        T: np.ndarray,
        k: np.ndarray,
        reach: float,
        method: int,
        blur: float = 0.0,
    ) -> "Parts":
        """Prepare the windows k of T (m, 2, 3), as far as `reach`, less their means."""
        pixels = np.rint(T[k, :, 0]).astype(int)
        beside = int(np.ceil(reach + 0.5)) + METHODS[method] + margin(blur)
        size = 2 * beside + 1
        grey = cut(image, pixels, beside) - means[k, None, None]
        grey = blurred(grey.astype(np.float32).reshape(-1, size), blur)
        corner = np.full((len(T), 2), np.nan)
        corner[k] = pixels - beside
        corner[k, 1] -= np.arange(len(k)) * size
        return cls(
            _fine.coefficients(grey) if method == SPLINE else grey, corner, method
        )

    def at(self, X: np.ndarray, k: np.ndarray) -> np.ndarray:
        """Grey values at X (j, 2, pixels) of the windows k (j,).

        The spline is good to a thousandth of the contrast; the others are quick, and
        OpenCV 4 rounds X to 1/32 px for them.
        """
        x, y = np.moveaxis(X - self.corner[k, :, None], 1, 0)
        if self.method == SPLINE:
            return _fine.sample(self.grey, x, y)
        x, y = x.astype(np.float32), y.astype(np.float32)
        return cv2.remap(self.grey, x, y, self.method).astype(float)


def cut(image: np.ndarray, pixels: np.ndarray, reach: int) -> np.ndarray:
    """Parts (m, size, size) of an image, as far to each side of the pixels (m, 2).

    Beyond its edge the image is mirrored, as the filters of `_fine` do. Pixels that are
    masked, NaN or infinite become NaN: what rests on them is NaN too.
    """
    size, shape = 2 * reach + 1, np.array(image.shape[::-1])
    found = np.empty((len(pixels), size, size))
    grey, mask = np.ma.getdata(image), np.ma.getmask(image)
    inside = np.all((pixels >= reach) & (pixels + reach < shape), axis=1)
    column, row = pixels[inside].T - reach
    beside = np.arange(-reach, reach + 1)
    columns, rows = (
        _mirrored(pixels[~inside, axis, None] + beside, n)
        for axis, n in enumerate(shape)
    )
    mirrored = rows[:, :, None], columns[:, None, :]

    def parts(values: np.ndarray, into: np.ndarray) -> None:
        if inside.any():
            into[inside] = sliding_window_view(values, (size, size))[row, column]
        if not inside.all():
            into[~inside] = values[mirrored]

    with np.errstate(over="ignore"):  # of long doubles: infinity says it
        parts(grey, found)
    if grey.dtype.kind == "f":
        found[~np.isfinite(found)] = np.nan
    if mask is not np.ma.nomask:
        masked = np.empty(found.shape, bool)
        parts(mask, masked)
        found[masked] = np.nan
    return found


def margin(blur: float) -> int:
    """Pixels to each side that a blurred grey value rests on."""
    return int(np.ceil(3 * blur))


def blurred(grey: np.ndarray, blur: float) -> np.ndarray:
    """Grey values under a Gaussian of standard deviation `blur`; as they are if 0."""
    size = 2 * margin(blur) + 1
    return cv2.GaussianBlur(grey, (size, size), blur) if blur else grey


def _mirrored(index: np.ndarray, n: int) -> np.ndarray:
    """Indices below n of a row of n pixels, mirrored at its first and its last one."""
    if n == 1:
        return np.zeros_like(index)
    index = np.abs(index) % (2 * n - 2)
    return np.minimum(index, 2 * n - 2 - index)


def transformations(points: np.ndarray, shape: ArrayLike | None) -> np.ndarray:
    """Transformations (n, 2, 3) that the first iteration starts from."""
    T = np.zeros((len(points), 2, 3))
    T[:, :, 0] = points
    shape = np.eye(2) if shape is None else _validate.finite(shape, "shape")
    if shape.shape not in ((2, 2), (len(points), 2, 2)):
        raise ValueError(
            "shape must be ((a1, a2), (b1, b2)), one for all points or one for each,"
            f" (2, 2) or ({len(points)}, 2, 2); got {shape.shape}"
        )
    T[:, :, 1:] = shape
    return T
