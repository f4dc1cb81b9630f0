"""Points as a user would choose them, and the figures that rows of the table share."""

import cv2
import numpy as np

from pgm_book.common.real_pairs.pairs import Stereo, Warped

MARGIN = 30  # px


def picked(image: np.ndarray, number: int, margin: int = MARGIN) -> np.ndarray:
    """Points (n, 2) where texture is best in each cell, and at least the usual.

    They lie on edges of objects more often than not.
    """
    texture = cv2.cornerMinEigenVal(image.astype(np.float32), 21)
    size, least = max(6, int(np.sqrt(image.size / number))), np.median(texture)
    found = []
    rows, columns = image.shape
    for row in range(margin, rows - margin - size + 1, size):
        for column in range(margin, columns - margin - size + 1, size):
            cell = texture[row : row + size, column : column + size]
            y, x = np.unravel_index(cell.argmax(), cell.shape)
            if cell[y, x] > least:
                found.append((column + x, row + y))
    return np.array(found, float).reshape(-1, 2)


def grid(image: np.ndarray, number: int) -> np.ndarray:
    """Points (n, 2) that know nothing of the image."""
    rows, columns = image.shape
    size = int(np.sqrt(image.size / number))
    x, y = np.meshgrid(
        np.arange(MARGIN, columns - MARGIN, size),
        np.arange(MARGIN, rows - MARGIN, size),
    )
    return np.stack([x.ravel(), y.ravel()], axis=1).astype(float)


def textured(pair: Warped, number: int, margin: int = 60) -> np.ndarray:
    """Points with good texture that both photos show, well inside."""
    points = picked(pair.left, number, margin)
    truth = pair.truth(points)
    size = np.array(pair.right.shape[::-1])
    return points[np.all((truth > margin) & (truth < size - margin), axis=1)]


def smooth(pair: Stereo, number: int, template: int) -> np.ndarray:
    """Points with texture where the template sees one surface: no step of 3 px."""
    points = picked(pair.left, number)
    known = np.where(np.isnan(pair.disparity), 1e4, pair.disparity).astype(np.float32)
    window = np.ones((template, template), np.uint8)
    step = cv2.dilate(known, window) - cv2.erode(known, window)
    column, row = points.astype(int).T
    seen = ~np.isnan(pair.disparity[row, column])
    return points[seen & (step[row, column] < 3)]


def distance(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distances (n,) in pixels; NaN where nothing was found or known."""
    return np.linalg.norm(found - truth, axis=1)


def robust_sd(values: np.ndarray) -> float:
    """Standard deviation of normal values, not spoilt by some wrong ones."""
    return float(np.median(np.abs(values - np.median(values))) / 0.6745)
