"""Epipolar plane, line and epipole, from the coplanarity condition."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo


def line(left: Photo, right: Photo, pixels: ArrayLike) -> np.ndarray:
    """Epipolar line (a, b, d) in the right photo: a x + b y + d = 0, ideal mm."""
    base = right.exterior[:3] - left.exterior[:3]
    normal = np.cross(base, left.rays(pixels))
    a, b, w = np.moveaxis(normal @ attitude(right.exterior).T, -1, 0)
    lines = np.stack([a, b, -right.camera.c * w], -1)
    return lines / np.linalg.norm(lines[..., :2], axis=-1, keepdims=True)


def curve(
    left: Photo, right: Photo, pixel: ArrayLike, heights: ArrayLike
) -> np.ndarray:
    """Pixels (k, 2) in the right photo of a left pixel, were it at these heights Z."""
    u = left.rays(pixel)
    X0 = left.exterior[:3]
    return right.project(X0 + (np.asarray(heights)[:, None] - X0[2]) / u[2] * u)


def fundamental(left: Photo, right: Photo) -> np.ndarray:
    """Fundamental matrix (3, 3) of two photos without lens distortion, in pixels."""
    raise NotImplementedError
