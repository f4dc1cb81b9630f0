"""Least squares matching with one defect introduced at a time.

The matching is that of (B 2.7) to (B 2.14), as `pgm_lab.lsm` does it, in fewer lines. A
printed formula or a property of the printed program can be switched on by name, to see
what it costs. For measuring use `pgm_lab.lsm`.
"""

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab.image import resample

DEFECTS = {
    "uncentred": "x and y counted from the corner of the image, not from the window",
    "cubic convolution": "resampling by cubic convolution, not by a cubic spline",
    "bilinear": "bilinear resampling",
    "rounded": "bilinear grey values, rounded to whole numbers",
    "truncated": "bilinear grey values, cut to whole numbers",
    "integer gradients": "gradients cut to whole numbers",
    "first gradients": "A of the first step kept (not in the source: to compare)",
    "or": "limits joined by or, shifts not looked at",
    "h1 without grey value": "the column of h1 is 1, as (B 2.17) prints it",
    "diagonal grid": "only the pixels of the diagonal are transformed",
    "six parameters": "no h0 and h1",
    "S0 of the listing": "root of VᵀV divided by r, instead of the root of VᵀV / r",
}
PROGRAM = (
    *("uncentred", "rounded", "integer gradients", "or"),
    *("diagonal grid", "six parameters", "S0 of the listing"),
)

# The last step moves the window by less than this, far below the noise
_SHIFT, _AFFINE = 1e-3, 1e-4  # px, px per px
_OR = 0.03  # px per px, of the listing


@dataclass(frozen=True)
class Match:
    """Matches of n points.

    Attributes
    ----------
    points : ndarray (n, 2)
        (column, row) in the right image, in pixels, wherever the iteration ended; NaN
        if the status is "singular" or "outside the image".
    sigma0 : ndarray (n,)
        Standard deviation of the grey values, S0 of the last step.
    condition : ndarray (n,)
        Condition number of AᵀA in the first step.
    iterations : ndarray (n,) of int
    status : ndarray (n,) of str
        "converged"; "not converged" after the last iteration allowed; "singular": AᵀA
        has no inverse; "outside the image".
    """

    points: np.ndarray
    sigma0: np.ndarray
    condition: np.ndarray
    iterations: np.ndarray
    status: np.ndarray


def match(
    left: np.ndarray,
    right: np.ndarray,
    points: ArrayLike,
    start: ArrayLike,
    defects: Iterable[str] = (),
    template: int = 21,
    iterations: int = 30,
) -> Match:
    """Match points by least squares, with the defects that are asked for.

    Parameters
    ----------
    left, right : ndarray (rows, columns)
        Grey values.
    points : array_like (n, 2)
        (column, row) of whole pixels in the left image.
    start : array_like (n, 2)
        Where they lie in the right image, to a pixel or so.
    defects : iterable of str
        Names out of `DEFECTS`; `PROGRAM` has those of the printed program. Without any
        the matching is correct.
    template : int
        Pixels across the template, the window of the left image, odd.
    iterations : int
        How many steps at most.

    Notes
    -----
    A step solves (B 2.14a) with P = I and adds the corrections to the parameters. It
    stops when all of them are below 0.001 px and 0.0001 px per px; with "or" when (a1
    or b2) and (a2 or b1) are below 0.03. With "uncentred", a0 and b0 are the shift at
    the corner of the image, and their corrections are compared with the same limit.

    A defect acts in every step. The printed program is better in its first one, where
    the window lies on whole pixels and the gradients keep their fractions.

    References
    ----------
    Bani 2010, (B 2.7) to (B 2.17), III.3, and the listing LSM6A, here in our own words.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> pair = simulate.texture_pair(
    ...     simulate.texture(), (60, 60), (2.3, 1, 0, -1.4, 0, 1), gain=1.1
    ... )
    >>> found = match(*pair, [(30, 30)], [(32, 29)])
    >>> found.points.round(2)
    array([[32.3, 28.6]])
    >>> print(match(*pair, [(30, 30)], [(32, 29)], ["h1 without grey value"]).status[0])
    singular
    """
    defects = set(defects)
    if unknown := defects - DEFECTS.keys():
        raise ValueError(f"defects must be of DEFECTS; got {', '.join(unknown)}")
    points, start = np.asarray(points, float), np.asarray(start, float)
    x, y, grey = _windows(left, points, template)
    origin = points if "uncentred" in defects else np.zeros_like(points)
    x, y = x + origin[:, :1], y + origin[:, 1:]
    n, u = len(start), 6 if "six parameters" in defects else 8
    p = np.tile([0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0], (n, 1))
    p[:, [0, 3]] = start - origin

    S0, condition = np.full((2, n), np.nan)
    status, steps = np.full(n, "not converged", dtype="U20"), np.zeros(n, dtype=int)
    for step in range(iterations):
        going = status == "not converged"
        if not np.any(going):
            break
        g, gx, gy = _resampled(right, _transformed(p, x, y, defects), defects)
        h0, h1 = p[:, 6:7], p[:, 7:8]
        L = grey - (h0 + h1 * g)
        if step == 0 or "first gradients" not in defects:
            A = _design(h1 * gx, h1 * gy, g, x, y, defects)[..., :u]
        inside = np.all(np.isfinite(A.sum(axis=-1) + L), axis=-1)
        A, L = np.where(inside[:, None, None], A, 0), np.where(inside[:, None], L, 0)
        X, V, cond = _solved(A, L)
        good = going & np.isfinite(X[:, 0])
        p[good, :u] += X[good]
        S0[good], steps[good] = _s0(V, u, defects)[good], step + 1
        if step == 0:
            condition = np.where(inside, cond, np.nan)
        status[good & _small(X, defects)] = "converged"
        status[going & ~good] = "singular"
        status[going & ~inside] = "outside the image"
    points = _evaluated(p, *origin.T)
    points[np.isin(status, ["singular", "outside the image"])] = np.nan
    return Match(points, S0, condition, steps, status)


def _windows(
    image: np.ndarray, centres: np.ndarray, size: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y from the centre of the window, and grey values (n, pixels)."""
    half = size // 2
    y, x = (part.ravel() for part in np.mgrid[-half : half + 1, -half : half + 1])
    column, row = np.moveaxis(centres.astype(int)[:, :, None] + [x, y], 1, 0)
    return x, y, image[row, column]


def _evaluated(p: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """x', y' by (B 2.8) and (B 2.9), in the last axis."""
    p = np.moveaxis(p, -1, 0).reshape(8, -1, *[1] * (np.ndim(x) - 1))
    return np.stack([p[0] + p[1] * x + p[2] * y, p[3] + p[4] * x + p[5] * y], axis=-1)


def _transformed(
    p: np.ndarray, x: np.ndarray, y: np.ndarray, defects: Collection[str]
) -> np.ndarray:
    """Pixels of the windows in the right image (n, pixels, 2)."""
    if "diagonal grid" not in defects:
        return _evaluated(p, x, y)
    side = math.isqrt(x.shape[1])
    square = (len(p), side, side)
    diagonal = _evaluated(p, x[:, :: side + 1], y[:, :: side + 1])
    columns = np.broadcast_to(diagonal[:, None, :, 0], square)
    rows = np.broadcast_to(diagonal[:, :, None, 1], square)
    return np.stack([columns, rows], axis=-1).reshape(*x.shape, 2)


def _resampled(
    image: np.ndarray, points: np.ndarray, defects: Collection[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Grey values of the right image, and their gradients by (B 2.12) and (B 2.13)."""
    method = "spline3"
    if "cubic convolution" in defects:
        method = "cubic"
    if {"bilinear", "rounded", "truncated"} & set(defects):
        method = "bilinear"

    steps = (0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)
    around = np.stack([points + step for step in steps])
    g = resample(image, around, method, np.nan)  # together: it filters the whole image
    if "rounded" in defects:
        g = np.floor(g + 0.5)
    elif "truncated" in defects:
        g = np.floor(g)
    gx, gy = (g[1] - g[2]) / 2, (g[3] - g[4]) / 2
    if "integer gradients" in defects:
        gx, gy = np.trunc(gx), np.trunc(gy)
    return g[0], gx, gy


def _design(
    gx: np.ndarray,
    gy: np.ndarray,
    g: np.ndarray,
    x: np.ndarray,
    y: np.ndarray,
    defects: Collection[str],
) -> np.ndarray:
    """Derivatives below (B 2.11), in the order of (B 2.18): (n, pixels, 8)."""
    one = np.ones_like(g)
    h1 = one if "h1 without grey value" in defects else g
    return np.stack([gx, gx * x, gx * y, gy, gy * x, gy * y, one, h1], axis=-1)


def _solved(A: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """X (B 2.14a), NaN where AᵀA is singular, V (B 2.14c), and the condition of AᵀA."""
    N = A.swapaxes(-1, -2) @ A
    condition = np.linalg.cond(N)
    regular = (condition < 1 / np.finfo(float).eps)[:, None]
    N = np.where(regular[..., None], N, np.eye(N.shape[-1]))
    X = np.linalg.solve(N, A.swapaxes(-1, -2) @ L[..., None])
    return np.where(regular, X[..., 0], np.nan), (A @ X)[..., 0] - L, condition


def _s0(V: np.ndarray, u: int, defects: Collection[str]) -> np.ndarray:
    """Standard deviation of the grey values by (B 2.14e), or as in the listing."""
    r = V.shape[-1] - u  # (B 2.14d)
    square = (V**2).sum(axis=-1)
    if "S0 of the listing" in defects:
        return np.sqrt(square) / r
    return np.sqrt(square / r)


def _small(X: np.ndarray, defects: Collection[str]) -> np.ndarray:
    """Whether the corrections say that the iteration may stop."""
    a0, a1, a2, b0, b1, b2 = np.abs(X[:, :6]).T
    if "or" in defects:
        return (np.minimum(a1, b2) <= _OR) & (np.minimum(a2, b1) <= _OR)
    return (np.maximum(a0, b0) < _SHIFT) & (np.max([a1, a2, b1, b2], axis=0) < _AFFINE)
