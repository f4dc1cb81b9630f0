"""Stereo plotting in loops and short formulas, as the lesson writes it: to be read.

`epipolar.line`, `stereo.match_dense` and `stereo.intersect` do it for all pixels.
"""

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_book.program.registration import peak_of_parabola
from pgm_lab import _validate
from pgm_lab.ncc import correlation_map
from pgm_lab.stereo.normal import NormalPair

MOST = 100_000  # px that anybody would search


def model_point(
    x: float, y: float, parallax: float, base: float, c: float
) -> np.ndarray:
    """Point of the normal case, seen from the left perspective centre.

    Parameters
    ----------
    x, y : float
        Photo coordinates in the left normal image, mm.
    parallax : float
        x' - x'' in mm.
    base : float
        Distance of the perspective centres, m.
    c : float
        Principal distance, mm.

    Returns
    -------
    ndarray (3,)
        Along the base, across it, and against the view (negative below), m.

    Raises
    ------
    ValueError
        If the parallax is not positive: the rays do not meet before the camera.

    References
    ----------
    Harintaka 2020, (H 3) and (H 4) with by = 0 and y' = y''.

    Examples
    --------
    >>> model_point(6.0, -3.0, 12.0, base=400.0, c=24.0).tolist()
    [200.0, -100.0, -800.0]
    """
    x, y = _validate.number(x, "x"), _validate.number(y, "y")
    parallax = _validate.positive_number(parallax, "parallax", "mm")
    base = _validate.positive_number(base, "base", "m")
    c = _validate.positive_number(c, "c", "mm")
    scale = base / parallax
    return scale * np.array([x, y, -c])


def epipolar_line(
    base: ArrayLike, ray: ArrayLike, M: ArrayLike, c: float
) -> np.ndarray:
    """Epipolar line a x + b y + d = 0 in the right photo, of a ray from the left.

    Parameters
    ----------
    base : array_like (3,)
        From the left to the right perspective centre, object space.
    ray : array_like (3,)
        Direction of the left ray, object space.
    M : array_like (3, 3)
        Rotation matrix of the right photo, object to image.
    c : float
        Principal distance of the right photo, mm.

    Returns
    -------
    ndarray (3,)
        (a, b, d), of any length; x and y are ideal photo coordinates in mm.

    Raises
    ------
    ValueError
        If the ray lies along the base: there is no plane then.

    Examples
    --------
    >>> line = epipolar_line((5, 0, 0), (1, 2, -10), np.eye(3), 24.0)
    >>> (-line[2] / line[1]).item()  # y of a line along the rows
    4.8
    """
    normal = np.cross(
        _validate.of_shape(base, (3,), "base"), _validate.of_shape(ray, (3,), "ray")
    )
    if not normal.any():
        raise ValueError("ray must not lie along the base: the two span no plane")
    c = _validate.positive_number(c, "c", "mm")
    a, b, w = _validate.of_shape(M, (3, 3), "M") @ normal
    return np.array([a, b, -c * w])


def along_row(
    left: ArrayLike,
    right: ArrayLike,
    column: int,
    row: int,
    window: int,
    low: int,
    high: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Correlation of a left window with every window of its row in the right image.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values of the normal pair.
    column, row : int
        Of the left pixel.
    window : int
        Pixels across the window, odd.
    low, high : int
        Least and greatest disparity that is tried, px.

    Returns
    -------
    disparities : ndarray (high - low + 1,) of int
    r : ndarray (high - low + 1,)

    Raises
    ------
    ValueError
        If a window leaves its image, or high is not above low.

    References
    ----------
    Harintaka 2020, (H 1).
    """
    window = _validate.window(window, "window")
    column, row = (
        _validate.whole(value, name, -MOST)
        for value, name in ((column, "column"), (row, "row"))
    )
    low = _validate.whole(low, "low", -MOST)
    high = _validate.whole(high, "high", -MOST)
    if not 0 < high - low <= MOST:
        raise ValueError(f"high must be above low; got {low} and {high}")
    half = window // 2
    target = _strip(left, "left", row, half, column - half, column + half)
    strip = _strip(right, "right", row, half, column - high - half, column - low + half)
    return np.arange(low, high + 1), correlation_map(target, strip)[0, ::-1]


def best_disparity(
    left: ArrayLike,
    right: ArrayLike,
    column: int,
    row: int,
    window: int,
    low: int,
    high: int,
) -> tuple[float, float]:
    """Disparity of one pixel by a search along its row, refined by a parabola.

    Parameters
    ----------
    left, right, column, row, window, low, high
        As for `along_row`.

    Returns
    -------
    disparity : float
        Left column minus right column, px; NaN if the best lies at the end of the
        search.
    r : float
        The highest correlation.

    Raises
    ------
    ValueError
        If a window leaves its image, or high is not above low.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> image = landsat().grey[:60, :90].astype(float)
    >>> d, r = best_disparity(image, image[:, 3:], 40, 30, 7, 0, 8)
    >>> round(d, 1), round(r, 2)
    (3.0, 1.0)
    """
    tried, r = along_row(left, right, column, row, window, low, high)
    best = int(r.argmax())
    if best in (0, len(r) - 1):
        return float("nan"), float(r[best])
    peak = peak_of_parabola(*r[best - 1 : best + 2])
    return float(tried[best] + peak), float(r[best])


def _strip(
    image: ArrayLike, name: str, row: int, half: int, first: int, last: int
) -> np.ndarray:
    """Cut rows around a row, from the first to the last column, out of an image."""
    grey = _validate.grey_image(image, name)
    rows, columns = grey.shape
    if min(first, row - half) < 0 or last >= columns or row + half >= rows:
        raise ValueError(
            f"{name}: the windows from column {first} to {last} around row {row} leave"
            f" the image of {rows} rows and {columns} columns"
        )
    strip = grey[row - half : row + half + 1, first : last + 1]
    return _validate.finite(strip, f"{name}, in the windows,")


def sigma_height(H: float, B: float, gsd: float, sigma_px: float) -> float:
    """Standard deviation of a height from that of the parallax.

    Parameters
    ----------
    H : float
        Height above the ground, m.
    B : float
        Base, m.
    gsd : float
        Size of a pixel on the ground, m.
    sigma_px : float
        Standard deviation of the parallax, px.

    Returns
    -------
    float
        In m.

    Examples
    --------
    >>> round(sigma_height(1000.0, 400.0, 0.2, 0.1), 3)
    0.05
    """
    H = _validate.positive_number(H, "H", "m")
    B = _validate.positive_number(B, "B", "m")
    gsd = _validate.positive_number(gsd, "gsd", "m")
    return H / B * gsd * _validate.not_negative(sigma_px, "sigma_px", "pixels")


def row_points(
    pair: NormalPair,
    row: int,
    columns: ArrayLike,
    window: int,
    low: int,
    high: int,
    least: float = 0.8,
) -> np.ndarray:
    """Object points of pixels in one row of the left normal image.

    Parameters
    ----------
    pair : NormalPair
    row : int
    columns : array_like (n,) of int
    window, low, high
        As for `best_disparity`.
    least : float
        Threshold of r.

    Returns
    -------
    ndarray (n, 3)
        X, Y, Z in m; NaN where r is below the threshold, or the best disparity lies
        at the end of the search.

    Raises
    ------
    ValueError
        If a window leaves its image.
    """
    _validate.instance(pair, NormalPair, "pair")
    row = _validate.whole(row, "row", 0)
    columns = _validate.finite(columns, "columns").ravel()
    least = _validate.number(least, "least")
    points = np.full((len(columns), 3), np.nan)
    for i, column in enumerate(columns):
        d, r = best_disparity(pair.left, pair.right, column, row, window, low, high)
        if r >= least and np.isfinite(d):
            x = pair.origin[0, 0] + pair.pixel_size * column
            y = pair.origin[0, 1] - pair.pixel_size * row
            model = model_point(
                x, y, float(pair.parallax(np.float64(d))), pair.base, pair.c
            )
            points[i] = pair.stations[0] + model @ pair.rotation
    return points


def coarser(pair: NormalPair) -> NormalPair:
    """Return the next level of the image pyramid: half the size, smoothed before.

    Parameters
    ----------
    pair : NormalPair

    Returns
    -------
    NormalPair
        Pixels of twice the size; pixel (0, 0) stays where it was.
    """
    _validate.instance(pair, NormalPair, "pair")
    left, right = (
        cv2.pyrDown(np.nan_to_num(a, nan=float(np.nanmean(a))))
        for a in (pair.left, pair.right)
    )
    size = 2 * pair.pixel_size
    return NormalPair(
        left, right, pair.rotation, pair.stations, pair.c, size, pair.origin
    )
