"""The parts of an image around the points that are matched, ready to be resampled."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.lsm import _fine

LARGEST = 32_766  # px, what cv2.remap can address
SPLINE = -1  # besides OpenCV's names
METHODS = cv2.INTER_LINEAR, cv2.INTER_LANCZOS4, SPLINE  # from rough to fine
AROUND = _fine.REACH + 1  # px to each side that the spline, and all others, rest on


@dataclass(frozen=True)
class Parts:
    """The image around m windows, cut once for all methods of resampling.

    `grey` (m, size, size) holds grey values in single precision; `corner` (n, 2) is the
    top left pixel of a part in the image, `place` (n,) its index, by the point.
    """

    grey: np.ndarray
    corner: np.ndarray
    place: np.ndarray

    @classmethod
    def of(
        cls,
        image: np.ndarray,
        means: np.ndarray,
        T: np.ndarray,
        k: np.ndarray,
        reach: float,
        blur: float = 0.0,
    ) -> "Parts":
        """Prepare the windows k of T (m, 2, 3), as far as `reach`, less their means."""
        pixels = np.rint(T[k, :, 0]).astype(int)
        beside = int(np.ceil(reach + 0.5)) + AROUND + margin(blur)
        size = 2 * beside + 1
        grey = cut(image, pixels, beside)
        grey -= means[k, None, None]
        grey = blurred(grey.astype(np.float32).reshape(-1, size), blur)
        corner, place = np.zeros((len(T), 2)), np.zeros(len(T))
        corner[k], place[k] = pixels - beside, np.arange(len(k))
        return cls(grey.reshape(-1, size, size), corner, place)

    @cached_property
    def fine(self) -> np.ndarray:
        """Coefficients of splines through the grey values."""
        return _fine.inner_coefficients(self.grey)

    def at(self, X: np.ndarray, k: np.ndarray, method: int) -> np.ndarray:
        """Grey values at X (j, 2, pixels) of the windows k (j,).

        The spline is good to a thousandth of the contrast; the others are quick, and
        OpenCV 4 rounds X to 1/32 px for them. The parts stand below each other.
        """
        x, y = np.moveaxis(X - self.corner[k, :, None], 1, 0)
        size = self.grey.shape[1]
        place = self.place[k, None]
        if method == SPLINE:
            inner = size - 2 * _fine.REACH
            y = y - _fine.REACH + place * inner
            fine = self.fine.reshape(-1, 2 * inner)
            return _fine.sample(fine, x - _fine.REACH, y)
        y += place * size
        x, y = x.astype(np.float32), y.astype(np.float32)
        return cv2.remap(self.grey.reshape(-1, size), x, y, method).astype(float)


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
        parts(np.asarray(mask), masked)
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
    T[:, :, 1:] = _validate.window_shapes(shape, len(points))
    return T
