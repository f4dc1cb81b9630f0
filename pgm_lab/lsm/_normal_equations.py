"""Normal equations of least squares matching, for the windows of many points.

The left grey values are regressed on the derivatives of the left window, on one, and on
the resampled right grey values: ``A + v = h0 + h1 B + G q``. Only B changes from one
iteration to the next, therefore h1 is eliminated first and the rest is solved once.

A stands for the left grey values, B for the right ones, q for the corrections of
(a0, a1, a2, b0, b1, b2) in the axes of the left image.
"""

from dataclasses import dataclass

import numpy as np

from pgm_lab.adjustment import normal
from pgm_lab.lsm import _correlated, _fine

# Share of its sum of squares below which what is left of a window is rounding
FLAT = 1e-13
BLOCK = 16_000  # pixels of windows that stay in the nearest cache


@dataclass(frozen=True)
class Templates:
    """Left windows of m points, k pixels each, and what they alone determine.

    `rows` (m, u, k) holds G, then 1 if h0 is estimated, then A; `gram` their products;
    `Q` the inverse of the normal matrix without h1, and `a` its solution for A; `flat`
    marks windows whose grey values are all the same.
    """

    rows: np.ndarray
    gram: np.ndarray
    Q: np.ndarray
    a: np.ndarray
    singular: np.ndarray
    flat: np.ndarray

    def part(self, k: np.ndarray) -> "Templates":
        """Take the points k, in ascending order: all of them are not copied."""
        if len(k) == len(self.rows):
            return self
        return Templates(*(values[k] for values in vars(self).values()))


@dataclass(frozen=True)
class Solution:
    """Corrections q (m, 2, 3) and (h0, h1) (m, 2), vᵀv (m,), B (m, k), and its sums.

    `sums` (m, u) are the products of B with the rows of the templates, `square` (m,)
    with itself, `total` (m,) with one.
    """

    q: np.ndarray
    h: np.ndarray
    vv: np.ndarray
    B: np.ndarray
    sums: np.ndarray
    square: np.ndarray
    total: np.ndarray

    @classmethod
    def blank(cls, left: Templates) -> "Solution":
        """Room for the solutions of all points, NaN for now."""
        m, u, k = left.rows.shape
        shapes = (m, 2, 3), (m, 2), (m,), (m, k), (m, u), (m,), (m,)
        return cls(*(np.full(shape, np.nan) for shape in shapes))

    def put(self, k: np.ndarray, other: "Solution") -> None:
        """Overwrite the points k."""
        for name, values in vars(other).items():
            getattr(self, name)[k] = values

    def part(self, k: np.ndarray) -> "Solution":
        """Take the points k."""
        return Solution(*(values[k] for values in vars(self).values()))


def window_grid(half: int) -> np.ndarray:
    """(1, x, y) of the pixels of a window, from its middle: shape (3, k)."""
    y, x = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1).astype(float)
    return np.array([np.ones_like(x), x, y])


def templates(
    image: np.ndarray,
    gradients: tuple[np.ndarray, np.ndarray],
    pixels: np.ndarray,
    half: int,
    radiometric: bool,
) -> Templates:
    """Cut the windows around `pixels` (m, 2) out, and set up their normal equations."""
    _, x, y = window_grid(half)
    first = pixels[:, 1] * image.shape[1] + pixels[:, 0]
    at = first[:, None] + (y * image.shape[1] + x).astype(int)
    rows = np.empty((len(pixels), 8 if radiometric else 7, len(x)))
    for axis, g in enumerate(gradients):
        g = np.take(g, at)
        rows[:, 3 * axis] = g
        np.multiply(g, x, out=rows[:, 3 * axis + 1])
        np.multiply(g, y, out=rows[:, 3 * axis + 2])
    rows[:, 6] = 1
    rows[:, -1] = np.take(image, at)
    gram = rows @ np.swapaxes(rows, 1, 2)
    a, Q, _, singular = normal.solve(gram[:, :-1, :-1], gram[:, :-1, -1])
    # Where all lines run one way, the derivative along them is rounding
    singular |= _weakest_gradient(gram) <= FLAT * gram[:, -1, -1]
    flat = np.ptp(rows[:, -1], axis=1) == 0
    return Templates(rows, gram, Q, a, singular | flat, flat)


def solve(left: Templates, B: np.ndarray) -> Solution:
    """Solve for q, h0 and h1, given the resampled right windows B (m, k).

    NaN where nothing is left of B, as in a flat window.
    """
    sums = (left.rows @ B[..., None])[..., 0]
    square = np.einsum("mk,mk->m", B, B)
    DB, AB = sums[:, :-1], sums[:, -1]
    DA, AA = left.gram[:, :-1, -1], left.gram[:, -1, -1]
    b = np.einsum("mij,mj->mi", left.Q, DB)
    # What the derivatives and the constant leave of A and B
    aa = AA - np.einsum("mi,mi->m", DA, left.a)
    ab = AB - np.einsum("mi,mi->m", DB, left.a)
    bb = square - np.einsum("mi,mi->m", DB, b)
    total = B.sum(axis=1)
    spread = square - total**2 / B.shape[1]
    bb[np.minimum(bb, spread) <= FLAT * square] = np.nan
    h = np.zeros((len(B), 2))
    h[:, 1] = 1
    if left.a.shape[1] == 7:
        h[:, 1] = ab / bb
        h[:, 0] = left.a[:, 6] - h[:, 1] * b[:, 6]
    q = left.a[:, :6] - h[:, 1:] * b[:, :6]
    vv = np.maximum(aa - 2 * h[:, 1] * ab + h[:, 1] ** 2 * bb, 0)
    q[np.isnan(bb)] = np.nan
    return Solution(q.reshape(-1, 2, 3), h, vv, B, sums, square, total)


def step_of_both(left: Templates, B: np.ndarray, h1: np.ndarray) -> np.ndarray:
    """Corrections q (m, 2, 3) by the mean derivatives of the left and right windows.

    The left derivatives alone are quicker to use, and right where both windows look
    alike. Where the left one is sharper, or both are aliased, they overrate what a step
    changes: each falls short, and the iteration creeps or circles. The mean of both is
    right to the second order (Benhimane and Malis 2004).
    """
    m, u, k = left.rows.shape
    _, x, y = window_grid((round(k**0.5) - 1) // 2)
    C, A = left.rows[:, : 8 if u == 8 else 6].copy(), left.rows[:, -1]
    square = B.reshape(m, round(k**0.5), -1)
    for axis, g in enumerate(np.gradient(square, axis=(2, 1))):
        g = h1[:, None] * g.reshape(m, k)
        of_left = C[:, 3 * axis : 3 * axis + 3]
        of_left += (np.stack([g, g * x, g * y], axis=1) - of_left) / 2
    if u == 8:
        C[:, 7] = B
    else:
        A = A - B
    n = (C @ A[..., None])[..., 0]
    x, *_ = normal.solve(C @ np.swapaxes(C, 1, 2), n)
    return x[:, :6].reshape(-1, 2, 3)


def precision(
    left: Templates,
    T: np.ndarray,
    found: Solution,
    noise: tuple[float, float] = (1.0, 1.0),
    correlated: bool = True,
    smooth: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Covariance (m, u, u) of (q, h0, h1), sigma0, effective pixels, N singular (m,).

    The noise of the left image to that of the right one is as `noise` says. The design
    matrix is made of noisy grey values: on the average N is too large by S, the noise
    that is in its columns, and AᵀL varies by S times the variance that the other image
    adds to a residual. With N0 = N - S the covariance is
    N0^-1 (variance N0 + other S) N0^-1, here to the second order in S: what is left
    between two photos is not all noise, and the whole series would reject good matches.
    """
    _, rows, k = left.rows.shape
    u = 8 if rows == 8 else 6
    half = (round(k**0.5) - 1) // 2
    # Noise that was smoothed before is interpolated without a loss
    gain = np.ones(len(T)) if smooth else _noise_gain(T, half)
    # What the noise of each image does to a residual, in parts of vᵀv / (k - u)
    of_left, of_right = noise[0] ** 2, (noise[1] * found.h[:, 1]) ** 2
    # Interpolation averages noise, but not what the derivatives pick out of it
    interpolated = of_left + of_right * gain
    kept = interpolated / (of_left + of_right)
    part = found.vv / (k - u) / interpolated
    of_left, of_right = part * of_left, part * of_right
    variance = of_left + of_right
    N = np.empty((len(T), u, u))
    m = left.a.shape[1]
    N[:, :m, :m] = left.gram[:, :m, :m]
    if u > m:
        N[:, :m, m] = N[:, m, :m] = found.sums[:, :m]
        N[:, m, m] = found.square
    # S is diagonal: sums over a window of x, of y and of xy are zero
    squares = _fine.derivative_gain(smooth) * (window_grid(half) ** 2).sum(axis=1)
    S, other = np.zeros((2, len(T), u))
    S[:, :3] = S[:, 3:6] = of_left[:, None] * squares
    other[:, :6] = of_right[:, None]
    if u > m:
        S[:, m] = part * noise[1] ** 2 * gain * k
        other[:, m] = of_left
    _, Q, _, singular = normal.solve(N, np.zeros(S.shape))
    QS = Q * S[:, None]
    QSQ, QR = QS @ Q, Q * (S * other)[:, None]
    covariance = variance[:, None, None] * (Q + QSQ + QS @ QSQ)
    covariance += QR @ Q + QS @ QR @ Q + QR @ QSQ
    pixels = np.full(len(T), float(k))
    if correlated:
        points = max(1, BLOCK // k)
        for first in range(0, len(T), points):
            block = np.s_[first : first + points]
            design, v = _observation_equations(left, found, block)
            pixels[block] = _correlated.effective_pixels(
                design, Q[block], v, kept[block], smooth
            )
        covariance *= (k / pixels)[:, None, None]
    return covariance, np.sqrt(variance), pixels, singular


def _observation_equations(
    left: Templates, found: Solution, block: slice
) -> tuple[np.ndarray, np.ndarray]:
    """Design matrix (m, u, k) of (q, h0, h1), a row per parameter, and residuals."""
    rows, B, q = left.rows[block], found.B[block], found.q[block].reshape(-1, 1, 6)
    h0, h1 = found.h[block].T[..., None]
    v = rows[:, -1] - h0 - h1 * B - (q @ rows[:, :6])[:, 0]
    if rows.shape[1] == 7:
        return rows[:, :6], v
    return np.concatenate([rows[:, :7], B[:, None]], axis=1, dtype=np.float32), v


def _noise_gain(T: np.ndarray, half: int) -> np.ndarray:
    """Mean of `_fine.noise_gain` over some pixels of the windows T (m, 2, 3)."""
    some = np.rint(np.linspace(-half, half, 7))
    x, y = (part.ravel() for part in np.meshgrid(some, some))
    column, row = np.moveaxis(T @ np.array([np.ones_like(x), x, y]), 1, 0)
    return _fine.noise_gain(column, row).mean(axis=1)


def _weakest_gradient(N: np.ndarray) -> np.ndarray:
    """Sum of the squared gradients (m,) in the direction where it is least."""
    xx, yy, xy = N[:, 0, 0], N[:, 3, 3], N[:, 0, 3]
    return (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)


def correlation(left: Templates, found: Solution) -> np.ndarray:
    """Correlation coefficient (B 2.6f), in its computing form (B 2.6a) to (B 2.6c).

    NaN where a window is flat.
    """
    *_, k = left.rows.shape
    total = left.rows[:, -1].sum(axis=1)
    xx = left.gram[:, -1, -1] - total**2 / k
    yy = found.square - found.total**2 / k
    xy = found.sums[:, -1] - total * found.total / k
    both = xx * yy
    return xy / np.sqrt(np.where(both > 0, both, np.nan))
