"""The frame of the normal case, and where two photos lie in it."""

import numpy as np

from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo


def rotation(left: Photo, right: Photo) -> np.ndarray:
    """Object to normal frame (3, 3): x along the base, z against the mean view."""
    x = right.exterior[:3] - left.exterior[:3]
    x = x / np.linalg.norm(x)
    z = attitude(left.exterior)[2] + attitude(right.exterior)[2]
    z = z - x * (z @ x)
    if np.linalg.norm(z) < 1e-3:
        raise ValueError(
            "the photos look along the base: there is no normal case of it"
        )
    z = z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])


def rays(xy: np.ndarray, R: np.ndarray, c: float) -> np.ndarray:
    """Directions (..., 3) in object space of places (..., 2) in the normal frame."""
    return np.concatenate([xy, np.full((*xy.shape[:-1], 1), -c)], -1) @ R


def normal_places(directions: np.ndarray, R: np.ndarray, c: float) -> np.ndarray:
    """Places (..., 2) in mm in the normal frame; NaN where it does not see them."""
    u = directions @ R.T
    z = np.where(u[..., 2:] < 0, u[..., 2:], np.nan)
    return -c * u[..., :2] / z
