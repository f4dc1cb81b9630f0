"""Where ground ends and sky begins in a photo, and where on it north lies.

A ray M^T (x, y, -c) that points below the horizontal meets level ground somewhere,
however far; one that points above it never does. The border is a straight line.
"""

import numpy as np

DIRECTIONS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")  # 45 degrees apart


def cut(polygon: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """The part of a polygon (k, d) on which `inside` (k,), linear on it, is >= 0."""
    kept = []
    for k in range(len(polygon)):
        a, b, at_a, at_b = polygon[k - 1], polygon[k], inside[k - 1], inside[k]
        if (at_a >= 0) != (at_b >= 0):
            kept.append(a + (b - a) * at_a / (at_a - at_b))
        if at_b >= 0:
            kept.append(b)
    return np.array(kept).reshape(-1, polygon.shape[1])


def ground(M: np.ndarray, c: float, corners: np.ndarray) -> np.ndarray:
    """The part (k, 2) of a photo with corners (4, 2) whose rays point downwards."""
    rays = np.column_stack([corners, np.full(len(corners), -c)]) @ M  # row by row
    return cut(corners, -rays[:, 2])


def directions(M: np.ndarray, c: float) -> list[tuple[str, np.ndarray]]:
    """Names of the directions in front of the camera, and where the horizon has them.

    North is the direction (0, 1, 0) of the object frame, east (1, 0, 0).
    """
    azimuth = np.radians(45 * np.arange(len(DIRECTIONS)))
    level = np.column_stack([np.sin(azimuth), np.cos(azimuth), np.zeros(len(azimuth))])
    U, V, W = M @ level.T
    found = zip(DIRECTIONS, U, V, W, strict=True)
    return [(name, -c * np.array([u, v]) / w) for name, u, v, w in found if w < -1e-9]
