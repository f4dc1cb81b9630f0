"""The base of two photos, without which there is no epipolar geometry."""

import numpy as np

from pgm_lab import _validate
from pgm_lab.camera.photo import Photo


def refuse_others(left: Photo, right: Photo) -> None:
    _validate.instance(left, Photo, "left")
    _validate.instance(right, Photo, "right")


def base_of(left: Photo, right: Photo) -> np.ndarray:
    refuse_others(left, right)
    return base(left.exterior, right.exterior)


def base(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """From the left to the right station."""
    base = right[:3] - left[:3]
    if np.linalg.norm(base) <= 1e-12 * np.abs([left[:3], right[:3]]).max():
        raise ValueError(
            "both photos stand at the same place: without a base there is no epipolar"
            " plane. The same photo, or the same exterior orientation, twice?"
        )
    return base
