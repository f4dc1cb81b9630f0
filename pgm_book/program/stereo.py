"""Stereo plotting in loops and short formulas, as the lesson writes it: to be read.

`epipolar.line`, `stereo.match_dense` and `stereo.intersect` do it for all pixels.
"""

import numpy as np

from pgm_book.program.registration import peak_of_parabola
from pgm_lab.image import cut
from pgm_lab.ncc import correlation_map


def model_point(
    x: float, y: float, parallax: float, base: float, c: float
) -> np.ndarray:
    """Point (3,) of the normal case, seen from the left perspective centre, in m.

    Along the base, across it, and against the view (negative below).

    Parameters
    ----------
    x, y : float
        Photo coordinates in the left normal image, mm.
    parallax : float
        x' - x'' in mm; must be positive, or the rays do not meet in front of the
        camera.
    base : float
        Distance of the perspective centres, m.
    c : float
        Principal distance, mm.

    References
    ----------
    Harintaka 2020, (H 3) and (H 4) with by = 0 and y' = y''.

    Examples
    --------
    >>> model_point(6.0, -3.0, 12.0, base=400.0, c=24.0).tolist()
    [200.0, -100.0, -800.0]
    """
    if not parallax > 0:
        raise ValueError(f"parallax must be positive (mm); got {parallax:g}")
    return base / parallax * np.array([x, y, -c])


def epipolar_line(
    base: np.ndarray, ray: np.ndarray, M: np.ndarray, c: float
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
        If the ray lies along the base: then there is no plane.

    Examples
    --------
    >>> line = epipolar_line((5, 0, 0), (1, 2, -10), np.eye(3), 24.0)
    >>> (-line[2] / line[1]).item()  # y of a line along the rows
    4.8
    """
    normal = np.cross(base, ray)
    if not normal.any():
        raise ValueError("ray must not lie along the base: the two span no plane")
    a, b, w = np.asarray(M) @ normal
    return np.array([a, b, -c * w])


def along_row(
    left: np.ndarray,
    right: np.ndarray,
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
        Smallest and largest disparity that is tried, px.

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
    column, row, half = int(column), int(row), window // 2
    first, last = column - high - half, column - low + half
    if first < 0 or last >= np.shape(right)[1]:
        raise ValueError(
            f"right: the windows from column {first} to {last} leave the image of"
            f" {np.shape(right)[1]} columns"
        )
    target = cut(left, (column, row), window)
    strip = np.asarray(right)[row - half : row + half + 1, first : last + 1]
    return np.arange(low, high + 1), correlation_map(target, strip)[0, ::-1]


def best_disparity(
    left: np.ndarray,
    right: np.ndarray,
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


def sigma_height(H: float, B: float, gsd: float, sigma_px: float) -> float:
    """Standard deviation of a height, m, from that of the parallax, px.

    `H` is the height above the ground and `B` the base, m; `gsd` the size of a pixel on
    the ground, m.

    Examples
    --------
    >>> round(sigma_height(1000.0, 400.0, 0.2, 0.1), 3)
    0.05
    """
    return H / B * gsd * sigma_px
