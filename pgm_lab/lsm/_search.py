"""The right image, ready to be resampled around the points that are matched."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.lsm import _fine

LARGEST = 32_766  # px, what cv2.remap can address


@dataclass(frozen=True)
class Search:
    """Part of the right image around the start points, ready to be resampled."""

    grey: np.ndarray
    coefficients: np.ndarray
    corner: np.ndarray
    shape: tuple[int, int]

    @classmethod
    def of(
        cls, image: np.ndarray, mean: float, centres: np.ndarray, reach: int
    ) -> "Search":
        """Prepare an image around the centres (n, 2), as far as windows may reach."""
        part, corner = crop(image, centres, reach + _fine.REACH)
        if max(part.shape) > LARGEST:
            raise ValueError(
                f"the points extend over {part.shape[1]} x {part.shape[0]} px of the"
                f" right image; match at most {LARGEST} px at a time"
            )
        part = part - mean
        fine = _fine.coefficients(part)
        return cls(part.astype(np.float32), fine, corner, image.shape)

    def bilinear(self, X: np.ndarray) -> np.ndarray:
        """Grey values at X (m, 2, k), quick and rough."""
        return self._remapped(X, cv2.INTER_LINEAR)

    def lanczos(self, X: np.ndarray) -> np.ndarray:
        """Grey values at X (m, 2, k); OpenCV 4 rounds X to 1/32 px."""
        return self._remapped(X, cv2.INTER_LANCZOS4)

    def _remapped(self, X: np.ndarray, method: int) -> np.ndarray:
        x, y = np.moveaxis(X - self.corner[:, None], 1, 0).astype(np.float32)
        grey = cv2.remap(self.grey, x, y, method)
        return grey.astype(float)

    def fine(self, X: np.ndarray) -> np.ndarray:
        """Grey values at X (m, 2, k), good to a thousandth of the contrast."""
        x, y = np.moveaxis(X - self.corner[:, None], 1, 0)
        return _fine.sample(self.coefficients, x, y)


def crop(
    image: np.ndarray, centres: np.ndarray, margin: int
) -> tuple[np.ndarray, np.ndarray]:
    """Part of an image around all centres (n, 2), and the pixel of its corner."""
    if not len(centres):
        centres = np.zeros((1, 2))
    first = np.maximum(np.floor(centres.min(axis=0)).astype(int) - margin, 0)
    end = np.ceil(centres.max(axis=0)).astype(int) + margin + 1
    return image[first[1] : end[1], first[0] : end[0]], first


def start(points: np.ndarray, shape: ArrayLike | None) -> np.ndarray:
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
