"""Grey values of an image: statistics, histogram, equalisation, gradients, pyramid."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate

CONTRAST = 0.1, 99.9  # percentiles of the grey values that become 0 and 255
SAMPLE = 10**6  # grey values that say which these are


@dataclass(frozen=True)
class Statistics:
    """Statistics of the grey values of an image.

    Attributes
    ----------
    mean : float
        Brightness.
    sd : float
        Contrast: standard deviation, with one degree of freedom less than pixels.
    minimum, maximum : float
    """

    mean: float
    sd: float
    minimum: float
    maximum: float


def statistics(image: ArrayLike) -> Statistics:
    """Mean (brightness) and standard deviation (contrast) of the grey values.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values; at least two pixels.

    Returns
    -------
    Statistics

    Raises
    ------
    ValueError
        If the image is not 2-D, not finite, or has fewer than two pixels.

    References
    ----------
    Bani 2010, (B 2.1).

    Examples
    --------
    >>> statistics([[1, 2], [3, 6]])
    Statistics(mean=3.0, sd=2.16..., minimum=1.0, maximum=6.0)
    """
    g = _validate.image(image)
    if g.size < 2:
        raise ValueError(f"image must have two pixels or more; got shape {g.shape}")
    mean = g.sum() / g.size
    sd = np.sqrt(np.sum((g - mean) ** 2) / (g.size - 1))  # (B 2.1)
    return Statistics(float(mean), float(sd), float(g.min()), float(g.max()))


def histogram(image: ArrayLike, bins: int = 256) -> tuple[np.ndarray, np.ndarray]:
    """Count the pixels of each grey value.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values. The bins of an unsigned 8 or 16 bit image cover all values that it
        could have, those of any other the values from its smallest to its largest.
    bins : int
        Number of bins. With 256, each grey value of an 8 bit image has its own.

    Returns
    -------
    counts : ndarray (bins,) of int
    edges : ndarray (bins + 1,)
        The first at -0.5 for an 8 or 16 bit image: whole grey values lie inside bins.

    Raises
    ------
    ValueError
        If the image is not 2-D, not finite or empty, or bins is less than one.

    Examples
    --------
    >>> counts, edges = histogram(np.array([[0, 255], [7, 7]], dtype=np.uint8))
    >>> counts[[0, 7, 255]], edges[[0, -1]]
    (array([1, 2, 1]), array([ -0.5, 255.5]))
    """
    g = _validate.image(image)
    bins = _validate.whole(bins, "bins", least=1)
    highest = _highest(image)
    limits = None if highest is None else (-0.5, highest + 0.5)
    return np.histogram(g, bins, range=limits)


def equalize(image: ArrayLike) -> np.ndarray:
    """Equalise the histogram: spread the grey values evenly, keeping their order.

    A grey value becomes the share of pixels that are not brighter, scaled so that the
    darkest becomes 0 and the brightest the highest value there is.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values; not changed.

    Returns
    -------
    ndarray (rows, columns)
        Whole numbers of the same type for an unsigned 8 or 16 bit image, 0 ... 255 or
        65535; floats from 0 to 1 for any other.

    Raises
    ------
    ValueError
        If the image is not 2-D or not finite, or has one grey value only.

    Notes
    -----
    For 8 bits this is cv2.equalizeHist, which has no other depth. A pixel's new value
    depends on the whole image: the same point gets two different values in two photos
    that show different things around it.

    References
    ----------
    Bani 2010, III.3 step 4: equalises the brightness and contrast of the two photos,
    after normalized cross correlation and before least squares matching.

    Examples
    --------
    >>> equalize(np.array([[10, 11], [12, 200]], dtype=np.uint8))
    array([[  0,  85],
           [170, 255]], dtype=uint8)
    """
    g = _validate.image(image)
    values, place, counts = np.unique(g, return_inverse=True, return_counts=True)
    if len(values) < 2:
        raise ValueError(
            "image must have two different grey values or more to spread;"
            f" all of its pixels are {values}"
        )
    darker = np.cumsum(counts) - counts[0]
    share = (darker / darker[-1])[place].reshape(g.shape)
    highest = _highest(image)
    if highest is None:
        return share
    return np.round(highest * share).astype(np.asarray(image).dtype)


def eight_bit(image: np.ndarray) -> np.ndarray:
    """Grey values stretched to 8 bits, as libraries need them; masked ones the mean."""
    values: np.ndarray = np.ma.getdata(image)
    mask = np.ma.getmask(image)
    if values.dtype == np.uint8 and not np.ndim(mask):
        return values
    good = values[~mask] if np.ndim(mask) else values
    sample = good.ravel()[:: max(1, good.size // SAMPLE)]
    low, high = (float(v) for v in np.percentile(sample, CONTRAST))
    if not high > low:
        return np.zeros(values.shape, np.uint8)
    grey = np.clip((values - low) * (255 / (high - low)), 0, 255)
    if np.ndim(mask):
        grey[mask] = grey[~mask].mean()
    return np.rint(grey).astype(np.uint8)


def as_type(values: np.ndarray, dtype: np.dtype) -> np.ndarray:
    """Grey values in a type, rounded and clipped to its range."""
    if dtype.kind == "f":
        return values.astype(dtype)
    if dtype.kind == "b":
        return np.round(values).astype(bool)
    limits = np.iinfo(dtype)
    return np.clip(np.round(values), limits.min, limits.max).astype(dtype)


def _highest(image: ArrayLike) -> int | None:
    """Highest grey value that an 8 or 16 bit image can have; None for any other."""
    dtype = np.asarray(image).dtype  # of any byte order, as a file may have it
    short = dtype.kind == "u" and dtype.itemsize <= 2
    return np.iinfo(dtype).max if short else None


def gradient(image: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Gradients of the grey values by central differences.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values; at least 3 x 3.

    Returns
    -------
    gx, gy : ndarray (rows, columns)
        Along columns (to the right) and rows (downwards), in grey values per pixel. In
        the outermost pixels, where a neighbour is missing, one-sided differences.

    Raises
    ------
    ValueError
        If the image is not 2-D, not finite or smaller than 3 x 3.

    Notes
    -----
    For a wave of f cycles per pixel the central difference gives sin(2 pi f) / (2 pi f)
    of the slope: 76 per cent at f = 0.2, 23 per cent at 0.4.

    References
    ----------
    Bani 2010, (B 2.12) and (B 2.13), the same as (B 3.2) and (B 3.3).

    Examples
    --------
    >>> gx, gy = gradient([[0, 1, 4], [10, 11, 14], [20, 21, 24]])
    >>> gx[1], gy[:, 1]
    (array([1., 2., 3.]), array([10., 10., 10.]))
    """
    gy, gx = np.gradient(_validate.image(image, least=3))
    return gx, gy


def pyramid(image: ArrayLike, levels: int) -> list[np.ndarray]:
    """Image pyramid: each level smoothed by 1-4-6-4-1, then every second pixel kept.

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
        the pixel (0, 0) keeps its position.

    Raises
    ------
    ValueError
        If the image is not 2-D or not finite, levels is less than one, or a level with
        less than 5 x 5 pixels would have to be halved.

    Notes
    -----
    The mean of 2 x 2 pixels lies between them instead: there the pixel (column, row)
    is at 2 (column, row) + 0.5 of the level below. Beyond its outermost pixels the
    image is mirrored.

    References
    ----------
    Burt and Adelson 1983, with a = 0.375; computed by cv2.pyrDown.

    Examples
    --------
    >>> [level.shape for level in pyramid(np.zeros((101, 64)), 3)]
    [(101, 64), (51, 32), (26, 16)]
    """
    # A copy: level 0 is not the caller's array, and OpenCV needs it contiguous
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
