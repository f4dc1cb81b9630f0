"""A piece of ground around a place, as the figure of two chips draws it."""

import numpy as np

AROUND = 51  # px


def around(image: np.ndarray, at: np.ndarray, name: str) -> np.ndarray:
    """The ground around a place, or what is wrong with it."""
    x, y = np.floor(np.clip(at, -AROUND, max(image.shape) + AROUND) + 0.5).astype(int)
    half = AROUND // 2
    left, top = x - half, y - half
    if min(left, top) < 0 or x + half >= image.shape[1] or y + half >= image.shape[0]:
        raise ValueError(
            f"points: what lies around ({x}, {y}) leaves the {name} image of"
            f" {image.shape[1]} columns and {image.shape[0]} rows"
        )
    return image[top : top + AROUND, left : left + AROUND]
