"""The method of Brahmantara 2015 in loops, as the lesson writes it: to be read.

`pgm_lab.registration` does the same for many chips, and says what went wrong.
"""

import numpy as np

from pgm_lab.image import cut


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    """Correlation coefficient of two windows, (Br 1); NaN where one of them is flat.

    Examples
    --------
    >>> a = np.array([[10, 20, 30], [40, 50, 90]])
    >>> round(correlation(a, 255 - a), 12), correlation(a, 0 * a)
    (-1.0, nan)
    """
    a, b = a - np.mean(a), b - np.mean(b)
    with np.errstate(invalid="ignore"):
        return float(np.sum(a * b) / np.sqrt(np.sum(a * a) * np.sum(b * b)))


def best_shift(
    reference: np.ndarray,
    sensed: np.ndarray,
    point: np.ndarray,
    chip: int = 21,
    radius: int = 3,
) -> tuple[int, int, np.ndarray]:
    """Shift of a chip to the position where the sensed image is most similar.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    point : array_like (2,)
        (column, row) of the centre of the chip, in whole pixels.
    chip : int
        Pixels across the chip, odd.
    radius : int
        Pixels searched to each side.

    Returns
    -------
    dx, dy : int
        Columns and rows, sensed minus reference, in pixels.
    r : ndarray (2 radius + 1, 2 radius + 1)
        Correlation for each shift; row dy + radius, column dx + radius.

    References
    ----------
    Brahmantara 2015, (Br 1) and section 2.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> image = landsat().grey[:100, :100]
    >>> dx, dy, r = best_shift(image, image[1:, 2:], (50, 50))
    >>> dx, dy, r.shape
    (-2, -1, (7, 7))
    """
    x, y = point
    target = cut(reference, (x, y), chip)
    steps = range(-radius, radius + 1)
    r = np.array(
        [
            [correlation(target, cut(sensed, (x + dx, y + dy), chip)) for dx in steps]
            for dy in steps
        ]
    )
    row, column = np.unravel_index(r.argmax(), r.shape)
    return int(column) - radius, int(row) - radius, r


def peak_of_parabola(r_left: float, r_middle: float, r_right: float) -> float:
    """Where the parabola through three r at -1, 0 and 1 is highest, px from the centre.

    The middle one must be the highest, or it raises ValueError.

    Examples
    --------
    >>> peak_of_parabola(0.5, 0.9, 0.7)
    0.166...
    """
    curvature = 2 * r_middle - r_left - r_right
    if r_middle < max(r_left, r_right) or not curvature > 0:
        raise ValueError(
            "r_middle must be higher than r_left and r_right, or there is no peak;"
            f" got {r_left:g}, {r_middle:g}, {r_right:g}"
        )
    return (r_right - r_left) / (2 * curvature)


def rmse(dx: np.ndarray, dy: np.ndarray) -> tuple[float, float, float]:
    """Root mean squares of shifts (n,) along x, along y, and of both (Br 2-4).

    Examples
    --------
    >>> rmse([3.0, 3.0], [4.0, 4.0])
    (3.0, 4.0, 5.0)
    """
    rmse_x, rmse_y = np.sqrt(np.mean(np.square(dx))), np.sqrt(np.mean(np.square(dy)))
    return float(rmse_x), float(rmse_y), float(np.hypot(rmse_x, rmse_y))


def chip_shifts(
    reference: np.ndarray,
    sensed: np.ndarray,
    points: np.ndarray,
    chip: int = 21,
    radius: int = 3,
) -> np.ndarray:
    """Shifts of many chips, refined along each axis by a parabola.

    Parameters
    ----------
    reference, sensed, chip, radius
        As for `best_shift`.
    points : array_like (n, 2)
        (column, row) of the centre of each chip, in whole pixels.

    Returns
    -------
    ndarray (n, 2)
        (dx, dy) of each chip in pixels; NaN where the peak lies on the border of the
        search, for the true shift may lie beyond it.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> image = landsat().grey[:100, :100]
    >>> found = chip_shifts(image, image[1:, 2:], [(50, 50), (40, 60)])
    >>> bool(abs(found - (-2, -1)).max() < 0.1)
    True
    """
    found = np.full((len(points), 2), np.nan)
    for k, point in enumerate(points):
        dx, dy, r = best_shift(reference, sensed, point, chip, radius)
        if max(abs(dx), abs(dy)) < radius:
            row, column = dy + radius, dx + radius
            across, down = r[row, column - 1 : column + 2], r[row - 1 : row + 2, column]
            found[k] = dx + peak_of_parabola(*across), dy + peak_of_parabola(*down)
    return found
