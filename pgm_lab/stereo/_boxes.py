"""What the steps of dense matching share: sums over windows, warps, bands of rows."""

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

BAND = 512  # rows at a time, so that the work fits a laptop and its cache
WHOLE = 0.999  # of a pixel, interpolated from a mask
PARTS = 32  # of a pixel, to which OpenCV before 5 rounds where it interpolates


def rounded(d: np.ndarray) -> np.ndarray:
    """Disparities at which every version of OpenCV gives the same image."""
    return np.rint(d * PARTS) / np.float32(PARTS)


def box(a: np.ndarray, n: int) -> np.ndarray:
    """Mean over n x n windows; outside is zero."""
    return cv2.boxFilter(a, cv2.CV_32F, (n, n), borderType=cv2.BORDER_CONSTANT)


class Image(NamedTuple):
    """Grey values about their mean, by their scatter; 1 where there is image."""

    grey: np.ndarray
    mask: np.ndarray

    def flipped(self) -> "Image":
        """Left and right exchanged."""
        return Image(*(np.ascontiguousarray(a[:, ::-1]) for a in self))


def warped(
    image: np.ndarray, d: np.ndarray, row: int = 0, how: int = cv2.INTER_LINEAR
) -> np.ndarray:
    """Right image where the left pixels lie by their disparities; zero outside.

    `row` is the row of the image that the first row of the disparities belongs to.
    """
    rows, columns = d.shape
    x = np.arange(columns, dtype=np.float32) - d
    y = np.arange(row, row + rows, dtype=np.float32)
    y = np.broadcast_to(y[:, None], d.shape).copy()
    return cv2.remap(image, x, y, how, borderMode=cv2.BORDER_CONSTANT, borderValue=0)


def in_bands(
    work: Callable[[slice], tuple[np.ndarray, ...]], rows: int, margin: int
) -> tuple[np.ndarray, ...]:
    """Results of all rows from work on bands of them that overlap by a margin."""
    parts = []
    for first in range(0, rows, BAND):
        band = slice(max(first - margin, 0), min(first + BAND + margin, rows))
        start = first - band.start
        keep = slice(start, start + min(BAND, rows - first))
        parts.append(tuple(a[keep] for a in work(band)))
    return tuple(np.concatenate(p) for p in zip(*parts, strict=True))
