"""A photo at half its size, again and again: for coarse search and for drawing."""

import cv2
import numpy as np

SMALLEST = 40  # pixels across the coarsest level, at least
TYPES = (np.uint8, np.uint16, np.float32)  # that OpenCV halves fast


def levels(grey: np.ndarray) -> list[np.ndarray]:
    """Return the photo and its halves; pixel p of level k lies at 2**k p in it.

    Where a pixel has no data stands the median of the others.
    """
    first = np.ma.masked_invalid(grey, copy=False)
    mask = np.ma.getmaskarray(first) if np.ma.is_masked(first) else None
    image = np.asarray(first.data)
    if image.dtype not in TYPES:
        image = image.astype(np.float32)
    if mask is not None:
        image = np.where(mask, np.median(image[~mask]), image).astype(image.dtype)
    found = [image]
    while min(found[-1].shape) >= 2 * SMALLEST:
        found.append(cv2.pyrDown(found[-1]))
    return found
