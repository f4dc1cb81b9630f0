"""Corners of a chequerboard in a photo, by least squares, with their covariance.

Around a corner p two edges, at the angles t1 and t2, part dark from bright. Blurred by
a Gaussian of standard deviation s, and lit unevenly with the gradient h, one sees

    g(u) = (1 + h . (u - p)) (a + b B(d1 / s, d2 / s; r)),    r = cos(t1 - t2).

d1, d2 are the distances of u from the edges, and B(x, y; r) is the mean of
sign(x + e1) sign(y + e2) over normal e1, e2 with the correlation r: for edges at right
angles the product of two error functions, and in general (Sheppard 1899, Owen 1956)

    B = erf(x / sqrt 2) erf(y / sqrt 2)
        + 2 / pi * integral of exp(-(x^2 + y^2 - 2 x y sin q) / (2 cos^2 q)) dq

over q from 0 to arcsin r. The corner is what least squares says of p.
"""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate

MAX_ITERATIONS = 30
CONVERGED = 1e-4  # px, and radians
SMALLEST_RADIUS, LARGEST_RADIUS = 3.0, 12.0  # px of a window, a disc
BLUR = 1.0  # px, start value
LARGEST_BLUR = 0.5  # radii: then the window no longer shows that the edges end
MAX_STEP = 0.5  # radii from the start
# Neighbours up to so many pixels apart show how far the residuals depend on each other
LAGS = 3
NODES = np.polynomial.legendre.leggauss(5)
TRIALS = 18  # angles of an edge
DAMPING, MAX_DAMPING, SMALL = 1e-3, 1e6, 1e-12
SMALLEST_BLUR = 0.2  # px, of the steepest edge that pixels show
SMALLEST_SINE = 0.2  # of the angle between two edges
FLAT = 1e-8  # of the squared grey value: no texture at all
EXPLAINED = 0.9  # least share of the window's variance that the two edges explain


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners of one photo.

    Attributes
    ----------
    pixels : ndarray (k, 2)
        (column, row) in pixels; NaN unless the status is "measured".
    covariance : ndarray (k, 2, 2)
        In square pixels, from the grey values alone: the noise, and how sharp and how
        long the edges are there.
    blur : ndarray (k,)
        Standard deviation s of the blur across an edge, in pixels.
    status : ndarray (k,) of str
        "measured", "too near the border", "too small", "no corner": two straight edges
        don't explain what is there, or "not converged".
    """

    pixels: np.ndarray
    covariance: np.ndarray
    blur: np.ndarray
    status: np.ndarray


def refine(grey: ArrayLike, near: ArrayLike, radius: ArrayLike) -> Corners:
    """Measure the corners of a chequerboard, each from where it was detected.

    Parameters
    ----------
    grey : array_like (rows, columns)
        Grey values, 8 or 16 bit or float.
    near : array_like (k, 2)
        (column, row) of the corners, in pixels, off by two pixels at most.
    radius : array_like (k,) or float
        Of a disc around each, in pixels, in which nothing but its two edges is seen.
        At most 12 are used.

    Returns
    -------
    Corners

    Raises
    ------
    ValueError
        If an argument is not as described.

    Examples
    --------
    >>> import cv2
    >>> columns, rows = np.meshgrid(np.arange(40) - 20.3, np.arange(30) - 14.6)
    >>> board = np.where((columns > 0) == (rows > 0), 200.0, 50.0)
    >>> grey = cv2.GaussianBlur(board, None, 1.0)
    >>> found = refine(grey, [(20, 15)], 9.0)
    >>> print(found.status[0], found.pixels[0].round(1))
    measured [20.5 14.5]
    """
    grey = np.ma.filled(_validate.grey_image(grey, "grey").astype(float), np.nan)
    near = _validate.point_list(near, "near")
    k = len(near)
    found = Corners(
        np.full((k, 2), np.nan),
        np.full((k, 2, 2), np.nan),
        np.full(k, np.nan),
        np.full(k, "too small", dtype="<U20"),
    )
    reach = np.broadcast_to(_validate.real(radius, "radius"), k)
    reach = np.minimum(reach, LARGEST_RADIUS)
    large = reach >= SMALLEST_RADIUS
    half = int(np.ceil(reach.max(where=large, initial=0)))
    found.status[large] = "too near the border"
    axis = np.arange(-half, half + 1)
    offset = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    i, place, start = np.flatnonzero(large), near[large], None
    # Once from where it was detected, then on in a window around the corner itself
    for _ in range(2):
        middle = np.floor(place + 0.5).astype(int)
        size = np.array(grey.shape[::-1])
        inside = np.all((middle >= half) & (middle < size - half), axis=1)
        found.status[i[~inside]] = "too near the border"
        i, place, middle = i[inside], place[inside], middle[inside]
        start = None if start is None else start[inside]
        if not len(i):
            return found
        # Windows (k, n) of grey values, by offsets from the whole pixel
        g = grey[middle[:, 1:] + offset[:, 1], middle[:, :1] + offset[:, 0]]
        fit = _fit(g, offset, place - middle, reach[i], start)
        found.status[i] = fit.status
        good = fit.status == "measured"
        i, start = i[good], fit.x[good]
        place = middle[good] + start[:, :2]
    found.pixels[i], found.covariance[i] = place, fit.covariance[good]
    found.blur[i] = fit.x[good, 4]
    return found


@dataclass(frozen=True, eq=False)
class _Fit:
    """What least squares found in the windows: x = p, t1, t2, s, a, b, h."""

    x: np.ndarray  # p from the whole pixel
    covariance: np.ndarray
    status: np.ndarray


def _fit(
    g: np.ndarray,
    offset: np.ndarray,
    p: np.ndarray,
    radius: np.ndarray,
    start: np.ndarray | None,
) -> _Fit:
    """Least squares in all windows (Levenberg 1944), from `start` but for its p."""
    k = len(g)
    weight = _disc(offset, p, radius)
    x = _start(g, offset, p, weight) if start is None else start.copy()
    x[:, :2] = p
    model, J = _edges(x, offset)
    cost = np.sum(weight * (g - model) ** 2, axis=1)
    damping, step = np.full(k, DAMPING), np.full(k, np.inf)
    for _ in range(MAX_ITERATIONS):
        i = np.flatnonzero((step > CONVERGED) & (damping < MAX_DAMPING))
        if not len(i):
            break
        # Normal equations, damped in proportion to their diagonal
        w = weight[i, :, None] * J[i]
        N = w.transpose(0, 2, 1) @ J[i]
        right = np.einsum("knu,kn->ku", w, g[i] - model[i])
        diagonal = np.einsum("kuu->ku", N)
        more = damping[i, None] * diagonal + SMALL * diagonal.max(axis=1, keepdims=True)
        N += more[:, :, None] * np.eye(N.shape[1])
        dx = np.linalg.solve(N, right[..., None])[..., 0]
        tried = x[i] + dx
        tried[:, 4] = np.clip(tried[:, 4], SMALLEST_BLUR, radius[i])

        # Take the step where it lowers the residuals, else damp more
        new_model, new_J = _edges(tried, offset)
        new_cost = np.sum(weight[i] * (g[i] - new_model) ** 2, axis=1)
        better = new_cost <= cost[i]
        up = i[better]
        x[up], model[up], J[up] = tried[better], new_model[better], new_J[better]
        cost[up] = new_cost[better]
        damping[i] *= np.where(better, 0.1, 10)
        step[i] = np.abs(dx[:, :5]).max(axis=1)  # of p, t1, t2 and s
    return _judged((x, model, J), g, weight, p, radius, step)


def _judged(
    fit: tuple[np.ndarray, ...],
    g: np.ndarray,
    weight: np.ndarray,
    p: np.ndarray,
    radius: np.ndarray,
    step: np.ndarray,
) -> _Fit:
    """Status and covariance of what came out: x, model and derivatives of `fit`."""
    x, model, J = fit
    k, u = x.shape
    n, v = weight.sum(axis=1), g - model
    vv = np.sum(weight * v**2, axis=1)
    mean = np.sum(weight * g, axis=1) / n
    total = np.sum(weight * (g - mean[:, None]) ** 2, axis=1)

    # Do two edges explain what is there?
    bad = ~(total - vv > EXPLAINED * total) | (total < FLAT * n * mean**2)
    bad |= x[:, 4] > LARGEST_BLUR * radius
    bad |= np.abs(x[:, :2] - p).max(axis=1) > MAX_STEP * radius
    bad |= np.abs(np.sin(x[:, 2] - x[:, 3])) < SMALLEST_SINE
    status = np.where(step > CONVERGED, "not converged", "measured").astype("<U20")
    status[bad] = "no corner"

    # Covariance of p: noise from the residuals, as far as they depend on each other
    N = (weight[..., None] * J).transpose(0, 2, 1) @ J
    N[status != "measured"] = np.eye(u)
    Q = np.linalg.inv(N)[:, :2, :2]
    factor = _dependence((weight * v)[status == "measured"])
    covariance = (factor * vv / (n - u))[:, None, None] * Q
    return _Fit(x, covariance, status)


def _disc(offset: np.ndarray, p: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Weights (k, n): 1 within the radius, falling to 0 over one pixel."""
    away = np.linalg.norm(offset - p[:, None], axis=2)
    return np.clip(radius[:, None] + 0.5 - away, 0, 1)


def _edges(x: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Grey values (k, n) of the model, and their derivatives (k, n, 9)."""
    p, t, s, a, b, h = x[:, :2], x[:, 2:4], x[:, 4], x[:, 5], x[:, 6], x[:, 7:]
    away = offset - p[:, None]  # (k, n, 2)
    normal = np.stack([-np.sin(t), np.cos(t)], axis=-1)  # (k, 2 edges, 2)
    along = np.stack([np.cos(t), np.sin(t)], axis=-1)
    z = away @ normal.transpose(0, 2, 1) / s[:, None, None]  # (k, n, 2)
    r = np.cos(t[:, :1] - t[:, 1:])
    B, by_z, by_r = _two_edges(z[..., 0], z[..., 1], r)
    light = 1 + np.einsum("kni,ki->kn", away, h)
    pattern = a[:, None] + b[:, None] * B
    contrast = b[:, None] * light
    by_d = contrast[..., None] * by_z / s[:, None, None]
    turned = contrast * by_r * np.sin(t[:, :1] - t[:, 1:])  # by t2; -turned by t1
    J = np.empty((*away.shape[:2], 9))
    J[..., :2] = -by_d @ normal - h[:, None] * pattern[..., None]
    J[..., 2:4] = -by_d * (away @ along.transpose(0, 2, 1))
    J[..., 2:4] += np.stack([-turned, turned], axis=-1)
    J[..., 4] = -np.sum(by_d * z, axis=2)
    J[..., 5] = light
    J[..., 6] = light * B
    J[..., 7:] = away * pattern[..., None]
    return light * pattern, J


def _two_edges(
    x: np.ndarray, y: np.ndarray, r: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B (k, n) of distances x, y (k, n) and r (k, 1), by (x, y) and by r."""
    erf = scipy.special.erf
    squares, product = -(x**2 + y**2) / 2, x * y
    limit = np.arcsin(r)
    B = erf(x / np.sqrt(2)) * erf(y / np.sqrt(2))
    for node, weight in zip(*NODES):
        q = limit * (node + 1) / 2
        B += (
            weight
            * limit
            / np.pi
            * np.exp((squares + product * np.sin(q)) / np.cos(q) ** 2)
        )
    rest = np.sqrt(1 - r**2)
    by = [
        np.sqrt(2 / np.pi)
        * np.exp(-(one**2) / 2)
        * erf((other - r * one) / (rest * np.sqrt(2)))
        for one, other in ((x, y), (y, x))
    ]
    by_r = 2 / np.pi / rest * np.exp((squares + r * product) / rest**2)
    return B, np.stack(by, axis=-1), by_r


def _start(
    g: np.ndarray, offset: np.ndarray, p: np.ndarray, weight: np.ndarray
) -> np.ndarray:
    """Start values (k, 9) but for p: of many pairs of edges, the best correlated."""
    n = weight.sum(axis=1)
    mean = np.sum(weight * g, axis=1) / n
    centred = weight * (g - mean[:, None])
    away = offset - p[:, None]
    angle = np.arctan2(away[..., 1], away[..., 0])
    trial = np.arange(TRIALS) * np.pi / TRIALS
    sides = np.sign(np.sin(angle[..., None] - trial))  # (k, n, trials)
    score = np.einsum("kn,knt,knu->ktu", centred, sides, sides, optimize=True)
    first, second = np.triu_indices(TRIALS, 3)
    first, second = (t[second - first <= TRIALS - 3] for t in (first, second))
    best = np.argmax(np.abs(score[:, first, second]), axis=1)
    first, second = first[best], second[best]
    x = np.zeros((len(g), 9))
    x[:, 2], x[:, 3] = trial[first], trial[second]
    x[:, 4], x[:, 5], x[:, 6] = BLUR, mean, score[np.arange(len(g)), first, second] / n
    return x


def _dependence(v: np.ndarray) -> float:
    """By how much dependent residuals (k, n) of windows inflate a variance.

    Sum of their correlations over the neighbours, as Newey and West (1987) weight it.
    """
    size = round(v.shape[1] ** 0.5)
    v = v.reshape(-1, size, size)
    total = np.sum(v**2)
    if not total > 0:
        return 1.0
    factor = 1.0
    lags = [(dr, dc) for dr in range(-LAGS, LAGS + 1) for dc in range(LAGS + 1)]
    for dr, dc in lags:
        if dc > 0 or dr > 0:  # each pair once
            one = v[:, max(dr, 0) : size + min(dr, 0), dc:]
            other = v[:, max(-dr, 0) : size + min(-dr, 0), : size - dc]
            share = (1 - abs(dr) / (LAGS + 1)) * (1 - dc / (LAGS + 1))
            factor += 2 * share * float(np.sum(one * other)) / total
    return max(factor, 1.0)
