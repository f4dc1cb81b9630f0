"""Windows of an image, and grey values between the pixels."""

from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate

CHUNK = 2**14  # points at a time: what is computed of them stays in the cache


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
    far = max(np.shape(image)) + size  # as much outside as any beyond
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


def resample(
    image: ArrayLike,
    points: ArrayLike,
    method: str = "spline3",
    outside: float | None = None,
) -> np.ndarray:
    """Grey values of an image at any points between its pixels.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values, 8 or 16 bit or float; at least 2 x 2; not changed.
    points : array_like (..., 2)
        (column, row) in pixels, integers at pixel centres.
    method : str
        "nearest": value of the nearest pixel (of four equally near, the one with the
        highest column and row). "bilinear": the four pixels around, each weighted by
        how near it is. "cubic": cubic convolution of 4 x 4 pixels. "spline3",
        "spline5": cubic and quintic spline through all pixels.
    outside : float, optional
        Grey value beyond the centres of the outermost pixels, NaN if you want. Without
        it, such a point is an error.

    Returns
    -------
    ndarray (...) of float
        Grey values, not rounded.

    Raises
    ------
    ValueError
        If the image is not 2-D, not finite or too small, points are not (..., 2) or not
        finite, the method is unknown, or points lie outside and `outside` is not given.

    Notes
    -----
    Bilinear reproduces a plane, cubic convolution a polynomial of degree two, the
    splines those of degree three and five; at the edge, where the image is mirrored,
    this no longer holds. A spline needs a pass over the whole image, however few the
    points. Match with splines: bilinear and cubic convolution shift a soft texture by
    up to 0.013 px, a cubic spline by 0.0007 px
    (pgm_book/ch03/results/interpolation_bias.csv).

    References
    ----------
    Bani 2010, II.1.1.4.2, names the first three. Keys 1981 for cubic convolution with
    a = -0.5; OpenCV takes a = -0.75. Thevenaz et al. 2000 for the splines.

    Examples
    --------
    >>> image = np.array([[0, 10], [20, 50]], dtype=np.uint8)
    >>> resample(image, [(0.5, 0.5), (1, 0)], "bilinear")
    array([20., 10.])
    >>> resample(image, [(0, 1), (1.2, 0)], "bilinear", outside=np.nan)
    array([20., nan])
    """
    image = _validate.image(image, least=2)
    points = _validate.points(points, 2, "points")
    method = _validate.choice(method, "method", METHODS)
    nan = isinstance(outside, np.floating | float) and np.isnan(outside)
    if outside is not None and not nan:
        outside = _validate.number(outside, "outside")
    far_corner = np.array(image.shape[::-1]) - 1
    x, y = np.moveaxis(points, -1, 0)
    beyond = (x < 0) | (y < 0) | (x > far_corner[0]) | (y > far_corner[1])
    if outside is None:
        _validate.refuse(
            np.atleast_1d(beyond),
            f"{np.sum(beyond)} of {beyond.size} points lie outside the image, whose"
            f" pixel centres end at {tuple(map(int, far_corner))} (column, row): points"
            " {}. Leave them out, or give outside=numpy.nan",
        )
    else:
        x, y = np.clip(x, 0, far_corner[0]), np.clip(y, 0, far_corner[1])
    if method in _ORDERS:
        yx = np.stack([y.ravel(), x.ravel()])  # SciPy needs at least one axis
        grey = scipy.ndimage.map_coordinates(
            image, yx, order=_ORDERS[method], mode="mirror"
        )
    else:
        pieces = max(1, x.size // CHUNK)
        parts = zip(*(np.array_split(c.ravel(), pieces) for c in (x, y)), strict=True)
        weights = _WEIGHTS[method]
        grey = np.concatenate([weighted_sum(image, u, v, weights) for u, v in parts])
    grey = grey.reshape(x.shape)
    return grey if outside is None else np.where(beyond, float(outside), grey)


def weighted_sum(
    image: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    weights: Callable[[np.ndarray], tuple[np.ndarray, list]],
) -> np.ndarray:
    """Sum of the pixels around each point; `weights`: the first, and those from it."""
    rows, columns = image.shape
    column, along_columns = weights(x)
    row, along_rows = weights(y)
    across = [mirrored(column + i, columns) for i in range(len(along_columns))]
    grey = np.zeros(x.shape)
    for j, weight in enumerate(along_rows):
        line = mirrored(row + j, rows) * columns
        part = sum(
            w * image.take(line + i) for w, i in zip(along_columns, across, strict=True)
        )
        grey += weight * part
    return grey


def mirrored(index: np.ndarray, n: int) -> np.ndarray:
    """Indices of a row of n pixels, mirrored beyond its ends: -1 is 1, n is n - 2."""
    if n == 1:
        return np.zeros_like(index)
    while True:
        index = n - 1 - np.abs(n - 1 - np.abs(index))
        if not index.size or index.min() >= 0:
            return index


def _nearest(x: np.ndarray) -> tuple[np.ndarray, list]:
    return np.floor(x + 0.5).astype(int), [1.0]


def _bilinear(x: np.ndarray) -> tuple[np.ndarray, list]:
    first = np.floor(x)
    t = x - first
    return first.astype(int), [1 - t, t]


def cubic_weights(x: np.ndarray, a: float = -0.5) -> tuple[np.ndarray, list]:
    """Cubic convolution; only with a = -0.5 is it exact for second degree."""

    def near(s: np.ndarray) -> np.ndarray:  # distance 0 to 1
        return ((a + 2) * s - (a + 3)) * s**2 + 1

    def far(s: np.ndarray) -> np.ndarray:  # distance 1 to 2
        return a * (((s - 5) * s + 8) * s - 4)

    first = np.floor(x)
    t = x - first
    return first.astype(int) - 1, [far(1 + t), near(t), near(1 - t), far(2 - t)]


_WEIGHTS = {"nearest": _nearest, "bilinear": _bilinear, "cubic": cubic_weights}
_ORDERS = {"spline3": 3, "spline5": 5}
METHODS = (*_WEIGHTS, *_ORDERS)
