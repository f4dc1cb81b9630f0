"""The position of a peak between the pixels, and its covariance."""

import numpy as np

from pgm_lab.ncc._map import centred, few, inner
from pgm_lab.ncc._search import Peaks


def paraboloid(
    peaks: Peaks, line: tuple[np.ndarray, np.ndarray, float] | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Top of the paraboloid through 3 x 3 values, covariance, ridges, directions."""
    # r = r0 + D x - xᵀ K x / 2 with central differences for D and K. Where a line (its
    # normal, the distance of the peak, the largest) determines more than the photos do,
    # the top is sought on it, in its direction (k, 2); else zero.
    r = peaks.near
    step, D, K, ridge = _top(r)
    r0 = r[:, 1, 1]
    # The paraboloid may rise above 1, which would imply negative noise
    top = np.minimum(r0 + np.sum(step * D, axis=1) / 2, 1 - (1 - r0) / 10)
    top[ridge] = r0[ridge]
    S = _covariance_of_slope(peaks.left, peaks.right, top)
    inverse = np.linalg.inv(_solvable(K, ridge))
    Q = inverse @ S @ inverse
    ridge |= ~_determined(step, Q)
    along = np.zeros((len(r), 2))
    if line is not None:
        normal, off, distance = line
        on, cov, u = _on_line(D, K, S, normal, off, distance)
        better = np.trace(cov, axis1=1, axis2=2) < np.trace(Q, axis1=1, axis2=2)
        crossed = _determined(on, cov) & (ridge | better)
        for values, of_line in ((step, on), (Q, cov), (along, u)):
            values[crossed] = of_line[crossed]
        ridge &= ~crossed
    return step, Q, ridge, along


def _determined(step: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Whether the top is at this peak, and known to a pixel."""
    near = np.abs(step).max(axis=1) <= 1
    return near & (np.trace(Q, axis1=1, axis2=2) <= 1)


def _on_line(
    D: np.ndarray,
    K: np.ndarray,
    S: np.ndarray,
    normal: np.ndarray,
    off: np.ndarray,
    distance: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Highest point on a line past the peak, its covariance, the line's direction."""
    # x = u s - n d with the distance d of the peak: uᵀ(D - K x) = 0. The error of the
    # line, anything up to the largest distance, has the variance distance^2 / 3.
    u = np.stack([normal[:, 1], -normal[:, 0]], axis=1)
    uD = np.sum(u * D, axis=1)
    uKu = np.einsum("ki,kij,kj->k", u, K, u)
    uKn = np.einsum("ki,kij,kj->k", u, K, normal)
    uSu = np.einsum("ki,kij,kj->k", u, S, u)
    uKu = np.maximum(uKu, 1e-9)  # no top: what follows is far off, and not accepted
    s = (uD + off * uKn) / uKu
    m = normal - (uKn / uKu)[:, None] * u
    Q = (uSu / uKu**2)[:, None, None] * u[:, :, None] * u[:, None, :]
    Q += distance**2 / 3 * m[:, :, None] * m[:, None, :]
    return s[:, None] * u - off[:, None] * normal, Q, u


def _covariance_of_slope(
    left: np.ndarray, right: np.ndarray, r: np.ndarray
) -> np.ndarray:
    """Covariance (k, 2, 2) of D, from white noise in both centred windows."""
    # p, q: shares of noise in the variances of the left and the right window
    of_left, of_right = (inner(one, one) for one in (left, right))
    p, q = _shares(of_left, of_right, r)
    # The gradients of the window with less noise, without what noise adds to them
    less = p <= q
    share = np.where(less, p, q)[:, None, None]
    clean = left if less.all() else np.where(less[:, None, None], left, right)
    G = _gradients(clean) - share / 2 * np.eye(2)
    G = _at_least(G, share[:, 0, 0] / np.sqrt(2 * left[0].size)) / (1 - share)
    p, q = p[:, None, None], q[:, None, None]
    n, w = left[0].size, left.shape[2]
    # Noise times noise: p q / 2 in D, and as much again, by simulation, through K
    S = G * (p * (1 - q) + q * (1 - p)) + p * q * np.eye(2)
    # What enters and leaves the right window changes its norm: noise does, and, since
    # noise is in the norm but not in the product, so do the grey values themselves
    S += (1 - p) * q**2 * (q + (1 - q) / 2) / w * np.eye(2)
    d = q[:, :, 0] / 2 * _one_sided(left)
    return S / n + d[:, :, None] * d[:, None, :]


def _one_sided(windows: np.ndarray) -> np.ndarray:
    """Squares in the last minus the first column, and row, by those in the window."""
    first, last = (
        np.stack([np.sum(windows[:, :, i] ** 2, 1), np.sum(windows[:, i] ** 2, 1)], 1)
        for i in (0, -1)
    )
    return (last - first) / inner(windows, windows)[:, None]


def _shares(
    left: np.ndarray, right: np.ndarray, r: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Shares p, q of noise in the variances of two windows: (1 - p)(1 - q) = r^2."""
    a, b = 1 / left, 1 / right
    c = 1 - np.maximum(r, 0.1) ** 2
    x = 2 * c / (a + b + np.sqrt((a - b) ** 2 + 4 * a * b * (1 - c)))
    return a * x, b * x


def _gradients(windows: np.ndarray) -> np.ndarray:
    """Mean of g gᵀ over each centred window, divided by its variance."""
    twice = (
        windows[:, 1:-1, 2:] - windows[:, 1:-1, :-2],
        windows[:, 2:, 1:-1] - windows[:, :-2, 1:-1],
    )
    variance = inner(windows, windows) / windows[0].size
    G = np.empty((len(windows), 2, 2))
    for i, j in ((0, 0), (0, 1), (1, 1)):
        products = inner(twice[i], twice[j])
        G[:, i, j] = G[:, j, i] = products / (4 * twice[0][0].size * variance)
    return G


def _at_least(G: np.ndarray, smallest: np.ndarray) -> np.ndarray:
    """Symmetric matrices, with their eigenvalues raised to what is given."""
    values, vectors = np.linalg.eigh(G)
    values = np.maximum(values, smallest[:, None])
    return vectors * values[:, None] @ vectors.swapaxes(1, 2)


def systematic_errors(
    templates: np.ndarray, wider: np.ndarray, step: np.ndarray, along: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Two errors (k, 2) of the paraboloid without noise, in pixels."""
    # The first is the offset of the top for the template in its own surroundings
    # (`wider` by one pixel on each side), since pixels enter and leave the window. The
    # second is pixel locking: for a wave of w radians per pixel the top is found at
    # tan(w s) / (2 tan(w/2)) instead of s, short of s by about s (1 - 4 s^2) w^2 / 12.
    # Where the top was sought `along` a line, both lie on it.
    t = centred(templates)
    offset, D, K, _ = _top(few(t, centred(wider), wider))
    middle = t[:, 1:-1, 1:-1]
    second = (
        t[:, 1:-1, :-2] - 2 * middle + t[:, 1:-1, 2:],
        t[:, :-2, 1:-1] - 2 * middle + t[:, 2:, 1:-1],
    )
    bend = np.stack([np.mean(d * d, axis=(1, 2)) for d in second], axis=1)
    curvature = np.maximum(np.diagonal(K, axis1=1, axis2=2), 1e-9)
    w2 = bend / curvature / t.var(axis=(1, 2))[:, None]
    locking = -w2 / 12 * step * (1 - 4 * step**2)
    on_line = np.flatnonzero(along.any(axis=1))
    u = along[on_line]
    uKu = np.einsum("ki,kij,kj->k", u, K[on_line], u)
    offset[on_line] = u * (np.sum(u * D[on_line], axis=1) / uKu)[:, None]
    locking[on_line] = u * np.sum(u * locking[on_line], axis=1)[:, None]
    # A top further off than a pixel would have been called a ridge
    return np.clip(offset, -1, 1), np.clip(locking, -1, 1)


def _top(r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Top, slope (k, 2), curvature (k, 2, 2) of 3 x 3 values; where no top exists."""
    r0 = r[:, 1, 1]
    D = np.stack([r[:, 1, 2] - r[:, 1, 0], r[:, 2, 1] - r[:, 0, 1]], axis=1) / 2
    Kxx = 2 * r0 - r[:, 1, 2] - r[:, 1, 0]
    Kyy = 2 * r0 - r[:, 2, 1] - r[:, 0, 1]
    Kxy = (r[:, 0, 2] + r[:, 2, 0] - r[:, 0, 0] - r[:, 2, 2]) / 4
    K = np.stack([Kxx, Kxy, Kxy, Kyy], axis=1).reshape(-1, 2, 2)
    ridge = Kxx * Kyy - Kxy**2 <= 1e-6 * (Kxx + Kyy) ** 2
    return np.linalg.solve(_solvable(K, ridge), D[..., None])[..., 0], D, K, ridge


def _solvable(K: np.ndarray, ridge: np.ndarray) -> np.ndarray:
    return np.where(ridge[:, None, None], np.eye(2), K)
