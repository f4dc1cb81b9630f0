"""The method of Brahmantara 2015 in loops, as the lesson writes it: to be read.

`chips` does the same for any number of chips at once, and says what went wrong.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.image import cut
from pgm_lab.ncc import correlation


def best_shift(
    reference: ArrayLike,
    sensed: ArrayLike,
    point: ArrayLike,
    chip: int = 21,
    radius: int = 3,
) -> tuple[int, int, np.ndarray]:
    """Shift of a chip to the place where the sensed image is most like it.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    point : array_like (2,)
        (column, row) of the middle of the chip, in whole pixels.
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

    Raises
    ------
    ValueError
        If the chip or a window leaves its image, or has no contrast.

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
    reference = _validate.image(reference, "reference")
    sensed = _validate.image(sensed, "sensed")
    x, y = _validate.one_point(point, 2, "point")
    chip = _validate.window(chip, "chip", 3)
    radius = _validate.whole(radius, "radius", 0)
    _validate.size("radius", 2 * radius + 1, 2 * radius + 1)
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
    """Where the parabola through three values at -1, 0 and 1 is highest.

    Parameters
    ----------
    r_left, r_middle, r_right : float
        Correlation at the shifts -1, 0 and 1; the middle one is the highest.

    Returns
    -------
    float
        Place of the peak from the middle, in pixels.

    Raises
    ------
    ValueError
        If the middle one is not the highest.

    Examples
    --------
    >>> peak_of_parabola(0.5, 0.9, 0.7)
    0.166...
    """
    left, middle, right = (
        _validate.number(value, name)
        for value, name in (
            (r_left, "r_left"), (r_middle, "r_middle"), (r_right, "r_right")
        )
    )  # fmt: skip
    curvature = 2 * middle - left - right
    if middle < max(left, right) or not curvature > 0:
        raise ValueError(
            "r_middle must be higher than r_left and r_right, to be the top of a hill;"
            f" got {left:g}, {middle:g}, {right:g}"
        )
    return (right - left) / (2 * curvature)


def rmse(dx: ArrayLike, dy: ArrayLike) -> tuple[float, float, float]:
    """Root mean squares of shifts along x, along y, and of both (Br 2-4).

    Parameters
    ----------
    dx, dy : array_like (n,)
        Shifts, sensed minus reference, in pixels or metres.

    Returns
    -------
    rmse_x, rmse_y, rmse_t : float
        In the same unit.

    Raises
    ------
    ValueError
        If dx and dy are not two lists of finite numbers of the same length.

    Examples
    --------
    >>> rmse([3.0, 3.0], [4.0, 4.0])
    (3.0, 4.0, 5.0)
    """
    x, y = _validate.finite(dx, "dx"), _validate.finite(dy, "dy")
    if x.ndim != 1 or x.shape != y.shape or not x.size:
        raise ValueError(
            "dx and dy must be two lists of the same length, with at least one shift;"
            f" got shapes {x.shape} and {y.shape}"
        )
    rmse_x, rmse_y = np.sqrt(np.mean(x**2)), np.sqrt(np.mean(y**2))
    return float(rmse_x), float(rmse_y), float(np.hypot(rmse_x, rmse_y))


def chip_shifts(
    reference: ArrayLike,
    sensed: ArrayLike,
    points: ArrayLike,
    chip: int = 21,
    radius: int = 3,
) -> np.ndarray:
    """Shifts of many chips, refined along each axis by a parabola.

    Parameters
    ----------
    reference, sensed, chip, radius
        As for `best_shift`.
    points : array_like (n, 2)
        (column, row) of the middle of each chip, in whole pixels.

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
    points = _validate.point_list(points, "points")
    radius = _validate.whole(radius, "radius", 1)
    found = np.full((len(points), 2), np.nan)
    for k, point in enumerate(points):
        dx, dy, r = best_shift(reference, sensed, point, chip, radius)
        if max(abs(dx), abs(dy)) < radius:
            row, column = dy + radius, dx + radius
            across, down = r[row, column - 1 : column + 2], r[row - 1 : row + 2, column]
            found[k] = dx + peak_of_parabola(*across), dy + peak_of_parabola(*down)
    return found
