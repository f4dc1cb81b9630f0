"""Windows cut out of an image."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate


def cut(image: np.ndarray, centre: ArrayLike, size: int) -> np.ndarray:
    """Square window around a pixel.

    Parameters
    ----------
    image : ndarray (rows, columns)
    centre : array_like (2,)
        (column, row); the window lies around the nearest whole pixel.
    size : int
        Odd width of the window.

    Returns
    -------
    ndarray (size, size)
        A view of the image.

    Raises
    ------
    ValueError
        If the size is even, the window leaves the image, or a grey value in it is NaN.

    Examples
    --------
    >>> cut(np.arange(20).reshape(4, 5), (2, 1), 3)
    array([[ 1,  2,  3],
           [ 6,  7,  8],
           [11, 12, 13]])
    """
    image = _validate.grey_image(image)
    size = _validate.window(size, "size", 1)
    centre = _validate.one_point(centre, 2, "centre")
    far = max(np.shape(image)) + size  # outside as any place beyond
    column, row = np.floor(np.clip(centre, -far, far) + 0.5).astype(int)
    top, left = row - size // 2, column - size // 2
    window = image[max(top, 0) : top + size, max(left, 0) : left + size]
    if window.shape != (size, size):
        raise ValueError(
            f"a window of {size} x {size} around (column, row) ({column}, {row}) leaves"
            f" the image of {image.shape} (rows, columns); take a smaller one"
        )
    _validate.finite(window, "image, in the window,")  # the rest of it may be large
    return np.asarray(window)
