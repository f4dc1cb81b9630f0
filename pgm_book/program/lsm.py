"""Least squares matching of one point, as lesson 3 writes it: to be read.

`pgm_lab.lsm` does the same for any number of points at once, and says what went wrong.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from pgm_book.program.adjustment import adjust
from pgm_lab.image import resample

LIMIT = 0.01  # px: a step that moves no pixel of the window farther ends the iteration
MAX_ITERATIONS = 40


def row_shift(A: np.ndarray, B: np.ndarray) -> float:
    """Shift of one row of grey values onto another, in one step of least squares.

    Parameters
    ----------
    A, B : array_like (n,)
        Grey values of the left and of the right row, at least three.

    Returns
    -------
    float
        a in pixels, for B(x + a) = A(x); exact where the rows are straight lines.

    References
    ----------
    Bani 2010, (B 2.10) with a0 alone; slopes by (B 2.12).

    Examples
    --------
    >>> row_shift([10, 12, 14, 16], [9, 11, 13, 15])
    0.5
    """
    A, B = np.asarray(A, float), np.asarray(B, float)
    slope = (B[2:] - B[:-2]) / 2
    if not np.any(slope):
        raise ValueError("B has no slope: a flat row fits everywhere")
    return float(slope @ (A - B)[1:-1] / (slope @ slope))


def match(
    left: np.ndarray,
    right: np.ndarray,
    point: Sequence[int] | np.ndarray,
    start: ArrayLike,
    size: int,
) -> tuple[np.ndarray, float, np.ndarray]:
    """Match one window by least squares, with eight parameters.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values.
    point : array_like (2,)
        (column, row) of the centre of the left window, in whole pixels.
    start : array_like (8,)
        Start values of a0, a1, a2, b0, b1, b2, h0, h1; (a0, b0) is a position in the
        right photo, in pixels.
    size : int
        Pixels across the window, odd.

    Returns
    -------
    trail : ndarray (k + 1, 8)
        The parameters at the start and after each of k iterations; the last row is the
        result.
    sigma0 : float
        Standard deviation of a grey value.
    Q : ndarray (8, 8)
        Cofactor matrix of the parameters: sigma0 squared times Q is their covariance.

    Raises
    ------
    ValueError
        If a window leaves its photo, the texture does not determine the parameters, or
        the iteration does not converge.

    References
    ----------
    Bani 2010, (B 2.7) to (B 2.13); (B 2.17) as corrected.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=1)
    >>> shape, affine = (60, 60), [2.3, 1, 0, -1.6, 0, 1]
    >>> left, right = simulate.texture_pair(texture, shape, affine, sigma=0)
    >>> trail, _, _ = match(left, right, (30, 30), [32, 1, 0, 28, 0, 1, 0, 1], 21)
    >>> print(trail[-1, [0, 3]].round(2))
    [32.3 28.4]
    """
    left, (column, row), half = np.asarray(left), map(int, point), size // 2
    rows, columns = left.shape
    if not (half <= column < columns - half and half <= row < rows - half):
        raise ValueError("the window leaves the left photo: choose another point")
    y, x = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
    A = left[row + y, column + x].astype(float)
    trail = [np.asarray(start, float)]
    for _ in range(MAX_ITERATIONS):
        p = trail[-1]
        B, Bx, By = resampled(right, p, x, y)
        J = design(B, Bx, By, x, y, p[7])
        observed = A - (p[6] + p[7] * B)
        step, _, sigma0, Q = adjust(J, np.ones(len(A)), observed)
        trail.append(p + step)
        reach = np.abs(step[:6]).reshape(2, 3) @ (1, half, half)  # of the far corner
        if reach.max() <= LIMIT:
            return np.array(trail), sigma0, Q
    raise ValueError(
        f"not converged after {MAX_ITERATIONS} iterations: the start may be too far"
        " from the match"
    )


def resampled(
    right: np.ndarray, p: np.ndarray, x: np.ndarray, y: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grey values of the right window, and their slopes along columns and rows.

    Parameters
    ----------
    right : array_like (rows, columns)
        Grey values.
    p : array_like (8,) or (6,)
        Parameters; the first six say where the window lies.
    x, y : array_like (n,)
        Pixels of the left window, from its centre.

    Returns
    -------
    B, Bx, By : ndarray (n,)
        By (B 2.8), (B 2.9), (B 2.12) and (B 2.13).
    """
    a0, a1, a2, b0, b1, b2 = p[:6]
    at = np.column_stack([a0 + a1 * x + a2 * y, b0 + b1 * x + b2 * y])

    steps = np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)])
    five = resample(right, at + steps[:, None], "spline3")  # one spline for all
    B, east, west, south, north = five
    return B, (east - west) / 2, (south - north) / 2


def design(
    B: np.ndarray,
    Bx: np.ndarray,
    By: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    h1: float,
) -> np.ndarray:
    """Design matrix: derivatives of h0 + h1 B by the eight parameters.

    Parameters
    ----------
    B, Bx, By : array_like (n,)
        Grey values of the right window and their slopes.
    x, y : array_like (n,)
        Pixels of the left window, from its centre.
    h1 : float
        Contrast.

    Returns
    -------
    ndarray (n, 8)
        In the order a0, a1, a2, b0, b1, b2, h0, h1.

    References
    ----------
    Bani 2010, (B 2.11).

    Examples
    --------
    >>> design([90], [2], [1], [-3], [4], 1.5)
    array([[ 3. , -9. , 12. ,  1.5, -4.5,  6. ,  1. , 90. ]])
    """
    gx, gy = h1 * np.asarray(Bx), h1 * np.asarray(By)
    one = np.ones(len(gx))
    return np.column_stack(
        [gx, np.multiply(x, gx), np.multiply(y, gx)]
        + [gy, np.multiply(x, gy), np.multiply(y, gy), one, B]
    )
