"""Parts of the right photo as the left one sees them, one below the other."""

import cv2
import numpy as np

# Pixels of the right photo for one of the left: from where on they are blurred, and
# from where on no more
SOFT, MOST = 1.2, 10.0


def canvas(
    image: np.ndarray, start: np.ndarray, shape: np.ndarray, size: int
) -> np.ndarray:
    """Square parts of an image around n places, each turned and scaled by its shape.

    Parameters
    ----------
    image : ndarray or MaskedArray (rows, columns)
    start : ndarray (n, 2)
        The middles of the parts.
    shape : ndarray (n, 2, 2)
        From an offset in the canvas to one in the image.
    size : int
        Pixels across a part, odd.

    Returns
    -------
    ndarray (n size, size) of float32
        Grey values, bilinearly; NaN where the image has none.
    """
    half = size // 2
    offset = np.arange(-half, half + 1)
    v, u = np.meshgrid(offset, offset, indexing="ij")
    parts = np.full((len(start), size, size), np.nan, np.float32)
    reach = half * np.abs(shape).sum(axis=2) + 2  # of the corners, (n, 2)
    first = np.floor(np.clip(start - reach, 0, image.shape[::-1])).astype(int)
    end = np.ceil(np.clip(start + reach + 1, 0, image.shape[::-1])).astype(int)
    for i, (a, b) in enumerate(shape):
        (left, top), (right, bottom) = first[i], end[i]
        if min(right - left, bottom - top) < 2:
            continue
        part = _softened(_floats(image[top:bottom, left:right]), shape[i])
        x = start[i, 0] - left + a[0] * u + a[1] * v
        y = start[i, 1] - top + b[0] * u + b[1] * v
        parts[i] = cv2.remap(
            part,
            x.astype(np.float32),
            y.astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float("nan"),
        )
    return parts.reshape(-1, size)


def _floats(part: np.ndarray) -> np.ndarray:
    """Grey values in single precision, NaN where masked."""
    values = np.ma.getdata(part).astype(np.float32)
    mask = np.ma.getmask(part)
    if np.any(mask):
        values[mask] = np.nan
    return values


def _softened(part: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """The part without detail that the left photo is too coarse for."""
    scale = min(np.sqrt(abs(np.linalg.det(shape))), MOST)
    if scale < SOFT:
        return part
    return cv2.GaussianBlur(part, (0, 0), 0.5 * np.sqrt(scale**2 - 1))
