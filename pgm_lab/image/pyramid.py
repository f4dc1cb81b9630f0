"""Image pyramid: the same image again and again at half the size."""

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


def pyramid(image: ArrayLike, levels: int) -> list[np.ndarray]:
    """Image pyramid: each level smoothed by 1-4-6-4-1, then every second pixel of it.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values.
    levels : int
        Number of levels, the image itself included.

    Returns
    -------
    list of ndarray
        Level 0 is the image in floats. n rows become (n + 1) // 2, columns likewise.
        The pixel (column, row) of level k lies at 2**k * (column, row) in the image:
        the pixel (0, 0) stays in its place.

    Raises
    ------
    ValueError
        If the image is not 2-D or not finite, levels is less than one, or a level with
        less than 5 x 5 pixels would have to be halved.

    Notes
    -----
    The mean of 2 x 2 pixels lies between them instead: there the pixel (column, row)
    is at 2 (column, row) + 0.5 of the level below. Beyond its outermost pixels the
    image goes on as in a mirror.

    References
    ----------
    Burt and Adelson 1983, with a = 0.375; computed by cv2.pyrDown.

    Examples
    --------
    >>> [level.shape for level in pyramid(np.zeros((101, 64)), 3)]
    [(101, 64), (51, 32), (26, 16)]
    """
    # A copy: the image is not to change with its level 0, and OpenCV wants it in order
    images = [_validate.image(image).copy()]
    levels = _validate.whole(levels, "levels", least=1)
    for k in range(1, levels):
        shape = images[-1].shape
        if min(shape) < 5:
            raise ValueError(
                f"levels must be at most {k} for an image of shape {images[0].shape}:"
                f" level {k - 1} has {shape} pixels, too few to be halved"
            )
        images.append(cv2.pyrDown(images[-1]))
    return images
