"""Normal equations of least squares matching, for the windows of many points.

The left grey values are regressed on the derivatives of the left window, on one, and on
the resampled right grey values: ``A + v = h0 + h1 B + G q``. Only B changes from one
iteration to the next, therefore h1 is eliminated first and the rest is solved once.

A stands for the left grey values, B for the right ones, q for the corrections of
(a0, a1, a2, b0, b1, b2) in the axes of the left image.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import scipy

from pgm_lab.adjustment import normal
from pgm_lab.lsm import half_pixels

# Share of its sum of squares below which what is left of a window is rounding
ROUNDING = 1e-13
BLOCK = 16_000  # pixels of windows that stay in the nearest cache
# Distances (x, y) in pixels at which residuals are compared, with their opposites
Lags = tuple[tuple[int, int], ...]
LAGS: Lags = (1, 0), (0, 1), (1, 1), (-1, 1), (2, 0), (0, 2)
DECAY = 3  # standard deviations of a Gaussian, up to which smoothed noise is correlated
POSITION = [0, 3]  # rows of a0 and b0 in the design matrix
MAX_GAIN = 2.0  # effective pixels per pixel: noise to which texture is insensitive
SIGNIFICANCE = 0.01  # of a curved surface: noise pretends one as often
MEDIAN = 0.4549  # of the square of a normal variable, in parts of its variance


@dataclass(frozen=True)
class Templates:
    """Left windows of m points, k pixels each, and what they alone determine."""

    rows: np.ndarray  # (m, u, k): G, then 1 if h0 is estimated, then A
    gram: np.ndarray  # products of the rows
    Q: np.ndarray  # inverse of the normal matrix without h1
    a: np.ndarray  # its solution for A
    singular: np.ndarray
    flat: np.ndarray  # all grey values are the same


@dataclass(frozen=True)
class Solution:
    """Solution of the normal equations of m points, for right windows B."""

    q: np.ndarray  # (m, 2, 3) corrections
    h: np.ndarray  # (m, 2) h0 and h1
    vv: np.ndarray  # (m,) vᵀv
    B: np.ndarray  # (m, k)
    sums: np.ndarray  # (m, u) products of B with the rows of the templates
    square: np.ndarray  # (m,) of B with itself
    total: np.ndarray  # (m,) of B with one

    @classmethod
    def blank(cls, left: Templates) -> "Solution":
        """Room for the solutions of all points, NaN for now."""
        m, u, k = left.rows.shape
        shapes = (m, 2, 3), (m, 2), (m,), (m, k), (m, u), (m,), (m,)
        return cls(*(np.full(shape, np.nan) for shape in shapes))


Stack = TypeVar("Stack")  # a dataclass of arrays whose first axis are the points


def take(stack: Stack, k: np.ndarray) -> Stack:
    """Take the points k, in ascending order: all of them are not copied."""
    arrays = vars(stack).values()
    if len(k) == len(next(iter(arrays))):
        return stack
    return type(stack)(*(values[k] for values in arrays))


def put(stack: Stack, k: np.ndarray, other: Stack) -> None:
    """Overwrite the points k."""
    for name, values in vars(other).items():
        getattr(stack, name)[k] = values


def window_grid(half: int) -> np.ndarray:
    """(1, x, y) of the pixels of a window, from its centre: shape (3, k)."""
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
    # Where all edges are parallel, the derivative along them is rounding error
    singular |= _weakest_gradient(gram) <= ROUNDING * gram[:, -1, -1]
    flat = np.ptp(rows[:, -1], axis=1) == 0
    return Templates(rows, gram, Q, a, singular | flat, flat)


def solve(left: Templates, B: np.ndarray) -> Solution:
    """Solve for q, h0 and h1, given right windows B (m, k); NaN where B is flat."""
    sums = (left.rows @ B[..., None])[..., 0]
    square = np.einsum("mk,mk->m", B, B)
    DB, AB = sums[:, :-1], sums[:, -1]
    DA, AA = left.gram[:, :-1, -1], left.gram[:, -1, -1]
    b = np.einsum("mij,mj->mi", left.Q, DB)
    # Remainders of A and B after the derivatives and the constant
    aa = AA - np.einsum("mi,mi->m", DA, left.a)
    ab = AB - np.einsum("mi,mi->m", DB, left.a)
    bb = square - np.einsum("mi,mi->m", DB, b)
    total = B.sum(axis=1)
    spread = square - total**2 / B.shape[1]
    bb[np.minimum(bb, spread) <= ROUNDING * square] = np.nan
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
    """Corrections q (m, 2, 3) by the mean derivatives of the left and right windows."""
    # Where the left window is sharper, or both are aliased, the left derivatives
    # overestimate the effect of a step, and the iteration slows down or oscillates. The
    # mean of both is right to the second order (Benhimane and Malis 2004).
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


def correlation(left: Templates, found: Solution) -> np.ndarray:
    """Correlation (B 2.6f) in its computing form; NaN where a window is flat."""
    *_, k = left.rows.shape
    total = left.rows[:, -1].sum(axis=1)
    xx = left.gram[:, -1, -1] - total**2 / k
    yy = found.square - found.total**2 / k
    xy = found.sums[:, -1] - total * found.total / k
    both = xx * yy
    return xy / np.sqrt(np.where(both > 0, both, np.nan))


# --- Precision ---


def precision(
    left: Templates,
    T: np.ndarray,
    found: Solution,
    correlated: bool = True,
    smooth: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Covariance (m, u, u) of (q, h0, h1), sigma0, effective pixels, singular (m,)."""
    # The design matrix is made of noisy grey values: on the average N is too large by
    # S, the noise in its columns, and AᵀL varies by S times the variance that the other
    # image adds to a residual. With N0 = N - S the covariance is N0^-1 (variance N0 +
    # other S) N0^-1, here to the second order in S: what is left between two photos is
    # not all noise, and the whole series would reject good matches.
    _, rows, k = left.rows.shape
    u = 8 if rows == 8 else 6
    half = (round(k**0.5) - 1) // 2
    # Noise that was smoothed before is interpolated without loss
    gain = np.ones(len(T)) if smooth else _noise_gain(T, half)
    # Share of each image's noise in a residual, as parts of vᵀv / (k - u)
    of_right = found.h[:, 1] ** 2
    # Interpolation averages noise, but not the part that the derivatives pick out
    interpolated = 1 + of_right * gain
    kept = interpolated / (1 + of_right)
    of_left = found.vv / (k - u) / interpolated
    of_right = of_left * of_right
    variance = of_left + of_right
    N = np.empty((len(T), u, u))
    m = left.a.shape[1]
    N[:, :m, :m] = left.gram[:, :m, :m]
    if u > m:
        N[:, :m, m] = N[:, m, :m] = found.sums[:, :m]
        N[:, m, m] = found.square
    # S is diagonal: sums over a window of x, of y and of xy are zero
    squares = half_pixels.derivative_gain(smooth) * (window_grid(half) ** 2).sum(axis=1)
    S, other = np.zeros((2, len(T), u))
    S[:, :3] = S[:, 3:6] = of_left[:, None] * squares
    other[:, :6] = of_right[:, None]
    if u > m:
        S[:, m] = of_left * gain * k
        other[:, m] = of_left
    _, Q, _, singular = normal.solve(N, np.zeros(S.shape))
    QS = Q * S[:, None]
    QSQ, QR = QS @ Q, Q * (S * other)[:, None]
    covariance = variance[:, None, None] * (Q + QSQ + QS @ QSQ)
    covariance += QR @ Q + QS @ QR @ Q + QR @ QSQ
    pixels, moves = np.full(len(T), float(k)), np.zeros((len(T), u))
    if correlated:
        points = max(1, BLOCK // k)
        for first in range(0, len(T), points):
            block = np.s_[first : first + points]
            design, v = _observation_equations(left, found, block)
            pixels[block] = effective_pixels(design, Q[block], v, kept[block], smooth)
            moves[block] = moved_by_curvature(design, Q[block], v, k / pixels[block])
        covariance *= (k / pixels)[:, None, None]
        # Each move is one of many that might be: its square over the median one is the
        # variance that is as often too large as too small
        covariance += moves[:, :, None] * moves[:, None] / MEDIAN
    # Nor is a position determined whose covariance no number holds
    singular |= ~np.isfinite(covariance).all(axis=(1, 2))
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
    """Mean of `half_pixels.noise_gain` over some pixels of the windows T (m, 2, 3)."""
    some = np.rint(np.linspace(-half, half, 7))
    x, y = (part.ravel() for part in np.meshgrid(some, some))
    column, row = np.moveaxis(T @ np.array([np.ones_like(x), x, y]), 1, 0)
    return half_pixels.noise_gain(column, row).mean(axis=1)


def _weakest_gradient(N: np.ndarray) -> np.ndarray:
    """Sum of the squared gradients (m,) in the direction where it is least."""
    xx, yy, xy = N[:, 0, 0], N[:, 3, 3], N[:, 0, 3]
    return (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)


# --- What a curved surface moves ---


def moved_by_curvature(
    design: np.ndarray, Q: np.ndarray, v: np.ndarray, larger: np.ndarray
) -> np.ndarray:
    """How far a surface moves the parameters (m, u); 0 if it is a plane."""
    # The variances of the residuals v (m, k) are `larger` (m,) than with white noise.
    # (B 2.8), (B 2.9) describe a plane. On any other surface second powers of x and y
    # displace the pixels, too: with these six additional parameters the adjustment
    # finds another position, if they are significant (Fisher's test).
    m, u, k = design.shape
    _, x, y = window_grid((round(k**0.5) - 1) // 2).astype(np.float32)
    powers = np.array([x * x, x * y, y * y])
    curved = (design[:, POSITION, None] * powers).reshape(m, -1, k)
    more = curved.shape[1]
    # Reduced to the additional parameters p; without them the others are Q Xᵀ p off
    X, n = curved @ np.swapaxes(design, 1, 2), (curved @ v[..., None])[..., 0]
    off = Q @ np.swapaxes(X, 1, 2)
    p, _, _, singular = normal.solve(curved @ np.swapaxes(curved, 1, 2) - X @ off, n)
    explained = np.einsum("mi,mi->m", p, n)
    rest = k - u - more
    left = (np.einsum("mk,mk->m", v, v) - explained) / rest * np.maximum(larger, 1)
    least = more * scipy.special.fdtri(more, rest, 1 - SIGNIFICANCE)
    found = ~singular & (explained > least * left)
    return np.where(found[:, None], (off @ p[..., None])[..., 0], 0)


# --- How many independent pixels the grey values of a window are worth ---
#
# What is left between two photos is no white noise: neighbours are correlated where an
# image was compressed, blurred or resampled, and residuals are larger where the texture
# is strong. For residuals with the covariance matrix C the covariance of the parameters
# is N^-1 (G^T C G) N^-1: here we find by what factor it is larger for the position.


def effective_pixels(
    design: np.ndarray,
    Q: np.ndarray,
    v: np.ndarray,
    gain: np.ndarray,
    smooth: float = 0.0,
) -> np.ndarray:
    """Independent pixels (m,) that would determine the position as well."""
    # The residuals v (m, k) are row by row of square windows; interpolation keeps the
    # share `gain` (m,) of the variance of white noise in v. White noise also shows some
    # correlation, by chance: a factor that differs from one by no more than its
    # standard deviation is halved, and a large one is used in full.
    _, u, k = design.shape
    # In single precision, for speed: sums of squares near one need no more
    vv = np.einsum("mk,mk->m", v, v)
    v = v * np.sqrt((k - u) / np.where(vv > 0, vv, 1))[:, None]
    lags = _lags(smooth, round(k**0.5))
    design, v = _spaced(design, k, lags), _spaced(v[:, None], k, lags)
    influence = Q.astype(np.float32) @ design
    position = influence[:, POSITION]
    c, s = _covariances(design, influence, v, k, lags)
    g, n = _sums(position, position, k, lags)
    alike = (c * g).sum(axis=0) / g[0]
    weight = (position**2).sum(axis=1)
    larger = _where_texture_is_strong(design, influence, v, weight, c[0], s)
    # With white noise c(d) scatters by c(0)^2 / n(d) (Bartlett 1946), v^2 by 2
    chance = (2 * g[1:] ** 2 / n[1:]).sum(axis=0) / g[0] ** 2
    chance += 2 * (weight**2).sum(axis=1) / weight.sum(axis=1) ** 2
    excess = alike * larger * gain - 1
    factor = 1 + excess**3 / (excess**2 + chance)
    return np.where(vv > 0, k / np.clip(factor, 1 / MAX_GAIN, k / u), k)


def _lags(smooth: float, width: int) -> Lags:
    """Distances at which residuals of smoothed images are compared, in such windows."""
    if not smooth:
        return LAGS
    most = min(DECAY * smooth, width // 2)
    whole = range(-int(most), int(most) + 1)
    half = ((x, y) for x in whole for y in whole if (y, x) > (0, 0))
    return tuple((x, y) for x, y in half if x * x + y * y <= most**2)


def _reach(lags: Lags) -> int:
    return max(max(abs(x), y) for x, y in lags)


def _covariances(
    design: np.ndarray, influence: np.ndarray, v: np.ndarray, k: int, lags: Lags
) -> tuple[np.ndarray, np.ndarray]:
    """Covariances c (lags, m) of two residuals, first their variance, and s (m,)."""
    # The adjustment has taken u dimensions from the residuals, those that the texture
    # occupies: with the projector H = G Q G^T on them, E(v v^T) = (I - H) C (I - H).
    # Let s be the mean variance there, and h(d) the sum of all elements of H for pixels
    # d apart. Then the products of n(d) pairs of residuals add up to n(d) c(d) - s
    # h(d), and s is the mean of c(d) with the weights h(d): both follow from each
    # other.
    u = design.shape[1]
    vv, n = _sums(v, v, k, lags)
    h, _ = _sums(influence, design, k, lags)
    s = (vv * h / n).sum(axis=0) / (u - (h * h / n).sum(axis=0))
    return (vv + s * h) / n, s


def _where_texture_is_strong(
    design: np.ndarray,
    influence: np.ndarray,
    v: np.ndarray,
    weight: np.ndarray,
    variance: np.ndarray,
    s: np.ndarray,
) -> np.ndarray:
    """Variance (m,) of position by each pixel's residual, over that by their mean."""
    # Squared residuals, with the squared influence of their pixels for weights (White
    # 1980), divided by what the adjustment leaves of their variance
    H = np.einsum("mik,mik->mk", influence, design)
    left = variance[:, None] - s[:, None] * H
    left = np.maximum(left, variance[:, None] / 2)
    found = np.einsum("mk,mk->m", weight, v[:, 0] ** 2)
    return found / np.einsum("mk,mk->m", weight, left)


def _sums(
    a: np.ndarray, b: np.ndarray, k: int, lags: Lags = LAGS
) -> tuple[np.ndarray, np.ndarray]:
    """Sums (lags, m) of a times b moved by each lag, and numbers of pairs (lags, 1)."""
    # First without a move; then by each lag and its opposite
    width = round(k**0.5)
    sums, n = [np.vecdot(a, b).sum(axis=1)], [k]
    for x, y in lags:
        shift = y * (width + _reach(lags)) + x
        pairs = np.vecdot(a[..., : a.shape[-1] - shift], b[..., shift:])
        sums.append(2 * pairs.sum(axis=1))
        n.append(2 * (width - abs(x)) * (width - y))
    return np.array(sums), np.array(n, float)[:, None]


def _spaced(rows: np.ndarray, k: int, lags: Lags = LAGS) -> np.ndarray:
    """Windows (..., k) with zeros after each row: no shift leads into another row."""
    width = round(k**0.5)
    spaced = np.zeros((*rows.shape[:-1], width, width + _reach(lags)), np.float32)
    spaced[..., :width] = rows.reshape(*rows.shape[:-1], width, width)
    return spaced.reshape(*rows.shape[:-1], -1)
