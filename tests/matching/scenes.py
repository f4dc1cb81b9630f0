"""Pairs of photos with known truth, made of real ones."""

from functools import cache

import cv2
import numpy as np

from pgm_lab import datasets, simulate


@cache
def warped(angle=10.0, scale=1.2, perspective=2e-5, sigma=2.0, size=(500, 700)):
    """A photo and the same turned and scaled about its middle, with noise and gain.

    Returns left, right and the matrix from left to right.
    """
    grey = datasets.yellowstone().grey[300 : 300 + size[0], 200 : 200 + size[1]]
    rows, columns = grey.shape
    middle = np.array([columns / 2, rows / 2])
    a = np.radians(angle)
    H = np.eye(3)
    H[:2, :2] = scale * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    H[:2, 2] = middle - H[:2, :2] @ middle + [13.37, -9.21]
    H = H @ [[1, 0, 0], [0, 1, 0], [perspective, -perspective / 2, 1]]
    right = cv2.warpPerspective(
        grey.astype(np.float32), H, (columns, rows), flags=cv2.INTER_CUBIC
    )
    left = simulate.photograph(grey.astype(float), sigma, 1)
    return left, simulate.photograph(0.9 * right + 8, sigma, 2), H


def apply(H, points):
    """Points (n, 2) under a matrix of the plane."""
    turned = np.column_stack([points, np.ones(len(points))]) @ H.T
    return turned[:, :2] / turned[:, 2:]
