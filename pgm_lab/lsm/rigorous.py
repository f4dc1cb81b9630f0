"""Least squares matching as the textbook writes it, on the adjustment core."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import Adjustment
from pgm_lab.adjustment import adjust as least_squares
from pgm_lab.lsm import half_pixels
from pgm_lab.lsm._normal_equations import window_grid

NAMES = ("a0", "a1", "a2", "b0", "b1", "b2", "h0", "h1")


def adjust(
    left: ArrayLike,
    right: ArrayLike,
    points: ArrayLike,
    parameters: ArrayLike,
    template: int = 21,
    *,
    radiometric: bool = True,
    line_search: bool = True,
    max_iterations: int = 50,
) -> Adjustment:
    """Adjust (B 2.10) with derivatives (B 2.11), both from the resampled right window.

    The reference for the tests of `match`: slower, and with the full result of an
    adjustment, such as residuals and redundancy numbers of each grey value.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values.
    points : array_like (n, 2)
        Points in the left image, (column, row) in pixels.
    parameters : array_like (n, 8)
        Start values (a0, a1, a2, b0, b1, b2, h0, h1), as `Match.parameters`: the point
        in the right image is (a0, b0), and x, y count from the left point.
    template : int
        Pixels across the template, the window of the left image, odd, at least 5.
    radiometric : bool
        False holds h0 = 0 and h1 = 1, whatever the start values say.
    line_search, max_iterations
        As in `adjustment.adjust`.

    Returns
    -------
    Adjustment
        A stack of n problems, the grey values of each row by row. Status "diverged"
        where the window leaves the right image.

    Raises
    ------
    ValueError
        As `match`; also if the window around a left point leaves the left image.

    Notes
    -----
    Its covariance, unlike that of `match`, treats the gradients as free of errors and
    the grey values of the right image as no less noisy after interpolation.

    References
    ----------
    (B 2.7) to (B 2.19), (B Table 2.2); (B 2.17) lacks the grey value at h1.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> left, right = simulate.texture_pair(
    ...     simulate.texture(seed=1), (60, 60), (3.25, 1, 0, -1.5, 0, 1), sigma=1.0
    ... )
    >>> found = adjust(left, right, [(30, 28)], [(33, 1, 0, 26, 0, 1, 0, 1)])
    >>> bool(np.abs(found.x[0, [0, 3]] - (33.25, 26.5)).max() < 0.02)
    True
    >>> found.residuals.shape, int(found.redundancy[0])
    ((1, 441), 433)
    """
    template = _validate.window(template, "template", 5)
    radiometric = _validate.flag(radiometric, "radiometric")
    half = template // 2
    left = _validate.image(left, "left", template)
    right = _validate.image(right, "right", template)
    points = _validate.point_list(points, "points")
    start = _validate.finite(parameters, "parameters")
    if start.shape != (len(points), 8):
        raise ValueError(
            f"parameters must be {(len(points), 8)}, one row {NAMES} per point;"
            f" got {start.shape}"
        )
    _, x, y = window_grid(half)
    line_search = _validate.flag(line_search, "line_search")
    pixels = np.rint(np.clip(points, -1, max(left.shape))).astype(int)
    columns, rows = pixels[:, :1] + x.astype(int), pixels[:, 1:] + y.astype(int)
    inside = (pixels >= half) & (pixels < np.array(left.shape[::-1]) - half)
    _validate.refuse(
        ~inside.all(axis=1), "the windows of points {} leave the left image"
    )
    mean = right.mean()
    fine = half_pixels.coefficients(right - mean)
    last_row, last_column = np.array(right.shape) - 1
    u = 8 if radiometric else 6

    def grey_values(p, offset):
        """Computed grey values (B 2.10), and their derivatives (B 2.11)."""
        a0, a1, a2, b0, b1, b2 = (p[:, [i]] for i in range(6))
        h0, h1 = (p[:, [6]], p[:, [7]]) if radiometric else (0.0, 1.0)
        X, Y = x - offset[:, :1], y - offset[:, 1:]
        column, row = a0 + a1 * X + a2 * Y, b0 + b1 * X + b2 * Y
        B = mean + half_pixels.sample(fine, column, row)
        Bx, By = half_pixels.sample_gradient(fine, column, row)
        outside = (column < 0) | (column > last_column) | (row < 0) | (row > last_row)
        B[outside] = np.nan
        A = np.stack(
            [h1 * g for g in (Bx, X * Bx, Y * Bx, By, X * By, Y * By)]
            + [np.ones_like(B), B],
            axis=-1,
        )
        return h0 + h1 * B, A[..., :u]

    return least_squares(
        grey_values,
        start[:, :u],
        left[rows, columns],
        args=(points - pixels,),
        names=NAMES[:u],
        line_search=line_search,
        max_iterations=max_iterations,
    )
