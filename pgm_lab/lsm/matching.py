"""Least squares matching of many points at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.lsm import _fine, _normal_equations
from pgm_lab.lsm._search import LARGEST, METHODS, Parts, cut, start

CHUNK = 128  # points: their windows stay in the cache
STRETCH = 3  # half windows that a corner may lie from the middle along x or y
PATIENCE = 4  # iterations before the derivatives of both windows are used
SLACK = 1.0  # px that a window may move before its part is prepared anew
STATUS = "<U25"
COARSE = 1.0, 0.25  # px, where bilinear and Lanczos resampling have done their part


@dataclass(frozen=True)
class Match:
    """Result of `match` for n points.

    Attributes
    ----------
    points : ndarray (n, 2)
        Points in the right image, (column, row) in pixels; NaN unless converged.
    covariance : ndarray (n, 2, 2)
        Their covariance in square pixels; NaN unless converged.
    sigma0 : ndarray (n,)
        Standard deviation of a grey value of the left image minus h0 + h1 times one of
        the right: sqrt(vᵀv / redundancy), freed from the smoothing that interpolation
        does to noise.
    parameters : ndarray (n, 8)
        (a0, a1, a2, b0, b1, b2, h0, h1) of (B 2.7) to (B 2.9), with x and y counted
        from the left point.
    parameter_covariance : ndarray (n, 8, 8)
        Their covariance; zero for h0 and h1 if they were not estimated. It does not
        know that noise in the right window makes h1 too small, by the share
        sigma^2 / variance(B); the position does not suffer.
    r : ndarray (n,)
        Correlation coefficient (B 2.6f) of the left window and the right one, as it was
        resampled for the last time.
    redundancy : int
        Grey values minus parameters.
    iterations : ndarray (n,) of int
        Iterations, coarse and fine.
    status : ndarray (n,) of str
        "converged"; "template leaves the image"; "left the image" (the right window
        did, at the start or later); "singular" (no texture, or lines that all run one
        way); "diverged" (moved by more than half a window or took an impossible shape);
        "too many iterations"; "below threshold" (it converged, but to something else).
    """

    points: np.ndarray
    covariance: np.ndarray
    sigma0: np.ndarray
    parameters: np.ndarray
    parameter_covariance: np.ndarray
    r: np.ndarray
    redundancy: int
    iterations: np.ndarray
    status: np.ndarray

    @property
    def converged(self) -> np.ndarray:
        """Whether the status is "converged": ndarray (n,) of bool."""
        return self.status == "converged"


def match(
    left: ArrayLike,
    right: ArrayLike,
    left_points: ArrayLike,
    right_points: ArrayLike,
    window: int = 21,
    *,
    radiometric: bool = True,
    shape: ArrayLike | None = None,
    threshold: float = 0.7,
    tolerance: float = 0.02,
    max_iterations: int = 20,
) -> Match:
    """Match windows around points of the left image in the right one.

    Each iteration resamples the right window at (B 2.8), (B 2.9) and solves (B 2.10)
    for the corrections. At the solution h1 B'_x and h1 B'_y of (B 2.11) are the
    derivatives of the left window, turned by a1, a2, b1, b2; therefore the left window
    is differentiated, once and on its own pixels, and only grey values are
    interpolated: quickly at first, then by a cubic spline on a doubled grid.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values, 8 or 16 bit or float.
    left_points : array_like (n, 2)
        Points in the left image, (column, row) in pixels, integers at pixel centres.
        The window lies around the nearest pixel.
    right_points : array_like (n, 2)
        Where they are in the right image: to half the shortest wave of the texture,
        two pixels where it is soft and one where it is sharp.
    window : int
        Pixels across the window, odd, at least 5.
    radiometric : bool
        False leaves h0 = 0 and h1 = 1.
    shape : array_like (2, 2) or (n, 2, 2), optional
        Start values ((a1, a2), (b1, b2)); the identity when missing, as in (B 2.20).
    threshold : float
        Smallest correlation r, or -r of a negative, that counts as a match.
    tolerance : float
        The end is reached when an iteration moves no pixel of the window by more, in
        pixels. What is left then is a hundredth of it where (B 2.10) holds, and up to a
        third in images with much aliasing or noise.
    max_iterations : int
        Most iterations for a point.

    Returns
    -------
    Match

    Raises
    ------
    ValueError
        If an image is not two-dimensional, is smaller than the window or not finite,
        the window is even or below 5, or the points do not fit together. What happens
        to a single point is told by its status.

    Notes
    -----
    The covariance is that of least squares with equal white noise in both images. It
    allows for the noise in the gradients and for what interpolation takes from the
    noise. It does not account for windows that are not related by (B 2.7) to (B 2.9),
    as at the edge of a roof, for aliasing, or for noise that neighbouring pixels share.

    References
    ----------
    Bani 2010, (B 2.7) to (B 2.20), where (B 2.20b) has a sign turned; Gruen 1985.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=1)
    >>> affine = (3.25, 1.01, 0.02, -1.5, -0.01, 0.99)
    >>> left, right = simulate.texture_pair(texture, (60, 60), affine, sigma=1.0)
    >>> found = match(left, right, [(30, 28)], [(34, 26)])
    >>> truth = (3.25 + 1.01 * 30 + 0.02 * 28, -1.5 - 0.01 * 30 + 0.99 * 28)
    >>> bool(np.abs(found.points[0] - truth).max() < 0.02)
    True
    >>> print(found.status[0], found.iterations[0])
    converged 3
    """
    window = _validate.window(window, "window", 5)
    radiometric = _validate.flag(radiometric, "radiometric")
    half = window // 2
    left = _validate.image(left, "left", window)
    right = _validate.image(right, "right", window)
    left_points = _validate.point_list(left_points, "left_points")
    n = len(left_points)
    right_points = _validate.point_list(right_points, "right_points", n)
    tolerance = _validate.positive_number(tolerance, "tolerance", "px")
    if not 0 <= _validate.number(threshold, "threshold") <= 1:
        raise ValueError(f"threshold must lie between 0 and 1; got {threshold}")
    max_iterations = _validate.whole(max_iterations, "max_iterations", 1)
    # Far outside is outside; larger numbers do not fit whole pixels
    pixels = np.rint(np.clip(left_points, -1, max(left.shape))).astype(int)
    T = start(right_points, shape)
    status = np.full(n, "too many iterations", dtype=STATUS)
    status[_outside(T, half, right.shape)] = "left the image"
    windows = np.zeros_like(T) + np.eye(2, 3, 1)
    windows[..., 0] = pixels
    status[_outside(windows, half, left.shape)] = "template leaves the image"
    usable = np.flatnonzero(status == "too many iterations")
    u = 8 if radiometric else 6
    parameters, covariance = np.full((n, 8), np.nan), np.full((n, 8, 8), np.nan)
    sigma0, r = np.full((2, n), np.nan)
    iterations = np.zeros(n, int)
    largest = 2 * (STRETCH * half + max(METHODS.values()) + 3) + 1
    chunk = min(CHUNK, LARGEST // largest)
    for first in range(0, len(usable), chunk):
        k = usable[first : first + chunk]
        template, means = _template(left, pixels[k], half, radiometric)
        if radiometric:
            here = np.rint(T[k, :, 0]).astype(int)
            means[:, 1] = cut(right, here, half).mean(axis=(1, 2))
        T_k, found, iterations[k], status[k] = _iterate(
            template, right, means[:, 1], T[k], half, tolerance, max_iterations
        )
        good = np.flatnonzero(status[k] == "converged")
        template, found = template.part(good), found.part(good)
        Q, s, singular = _normal_equations.precision(template, T_k[good], found)
        k = k[good]
        parameters[k], covariance[k] = _of_left_point(
            T_k[good], found.h, Q, left_points[k] - pixels[k], means[good]
        )
        sigma0[k], r[k] = s, _normal_equations.correlation(template, found)
        status[k[singular]] = "singular"
        status[k[np.abs(r[k]) < threshold]] = "below threshold"
    for values in (parameters, covariance, sigma0, r):
        values[status != "converged"] = np.nan
    return Match(
        points=parameters[:, [0, 3]],
        covariance=covariance[:, [[0], [3]], [[0, 3]]],
        sigma0=sigma0,
        parameters=parameters,
        parameter_covariance=covariance,
        r=r,
        redundancy=window**2 - u,
        iterations=iterations,
        status=status,
    )


def _template(
    image: np.ndarray, pixels: np.ndarray, half: int, radiometric: bool
) -> tuple[_normal_equations.Templates, np.ndarray]:
    """Left windows around pixels (m, 2), and (m, 2) the mean of each, twice.

    Counted from their mean, grey values keep more digits.
    """
    grey = cut(image, pixels, half + _fine.REACH)
    means = grey.mean(axis=(1, 2))
    m, size, _ = grey.shape
    grey = (grey - means[:, None, None]).reshape(-1, size)
    middle = np.stack([np.zeros(m, int), np.arange(m) * size], axis=1) + size // 2
    template = _normal_equations.templates(
        grey, _fine.gradient(grey), middle, half, radiometric
    )
    return template, np.stack([means, means], axis=1)


def _iterate(
    template: _normal_equations.Templates,
    image: np.ndarray,
    means: np.ndarray,
    T: np.ndarray,
    half: int,
    tolerance: float,
    max_iterations: int,
) -> tuple[np.ndarray, _normal_equations.Solution, np.ndarray, np.ndarray]:
    """Iterate from the transformations T (m, 2, 3), resampling more and more finely."""
    first, grid = T[:, :, 0].copy(), _normal_equations.window_grid(half)
    status = np.full(len(T), "too many iterations", dtype=STATUS)
    status[template.singular] = "singular"
    iterations = np.zeros(len(T), int)
    last = _normal_equations.Solution.blank(template)

    def stage(k: np.ndarray, method: int, goal: float) -> tuple[np.ndarray, np.ndarray]:
        """Iterate the points k; return which arrived, and which moved by `SLACK`."""
        before, reach = T.copy(), half * np.abs(T[k][:, :, 1:]).sum(axis=2).max()
        parts = Parts.of(image, means, T, k, reach + SLACK, method)
        k, arrived, away = k[iterations[k] < max_iterations], [k[:0]], [k[:0]]
        while len(k):
            B = parts.at(T[k] @ grid, k)
            found = _normal_equations.solve(template.part(k), B)
            last.put(k, found)
            q, slow = found.q, iterations[k] >= PATIENCE
            if slow.any():
                q[slow] = _normal_equations.step_of_both(
                    template.part(k[slow]), B[slow], found.h[slow, 1]
                )
            dT = T[k][:, :, 1:] @ q
            T[k] += dT
            iterations[k] += 1
            moved = np.abs(dT) @ [1, half, half]
            lost = _lost(T[k], first[k], half)
            status[k[lost]] = "diverged"
            status[k[np.isnan(found.vv)]] = "singular"
            gone = ~lost & _outside(T[k], half, image.shape)
            status[k[gone]] = "left the image"
            going = ~lost & ~gone
            there = going & (moved.max(axis=1) <= goal)
            arrived.append(k[there])
            going &= ~there & (iterations[k] < max_iterations)
            far = (np.abs(T[k] - before[k]) @ [1, half, half]).max(axis=1) > SLACK
            away.append(k[going & far])
            k = k[going & ~far]
        return np.sort(np.concatenate(arrived)), np.sort(np.concatenate(away))

    k = np.flatnonzero(~template.singular)
    for method, goal in zip(METHODS, (*COARSE, tolerance), strict=True):
        arrived = [k[:0]]
        while len(k):
            there, k = stage(k, method, goal)
            arrived.append(there)
        k = np.sort(np.concatenate(arrived))
    status[k] = "converged"
    return T, last, iterations, status


def _outside(T: np.ndarray, half: int, image_shape: tuple[int, ...]) -> np.ndarray:
    """Whether a corner of the transformed window lies outside the pixel centres."""
    reach = half * np.abs(T[:, :, 1:]).sum(axis=2)
    last = np.array(image_shape[::-1]) - 1
    centre = T[:, :, 0]
    return np.any((centre - reach < 0) | (centre + reach > last), axis=1)


def _lost(T: np.ndarray, start: np.ndarray, half: int) -> np.ndarray:
    """Whether a window drifted too far, or became too large, too small, or mirrored."""
    area = T[:, 0, 1] * T[:, 1, 2] - T[:, 0, 2] * T[:, 1, 1]
    near = np.all(np.abs(T[:, :, 0] - start) <= half, axis=1)
    reach = np.abs(T[:, :, 1:]).sum(axis=2).max(axis=1)
    return ~(near & (area > 1 / 4) & (area < 4) & (reach < STRETCH))


def _of_left_point(
    T: np.ndarray,
    h: np.ndarray,
    Q: np.ndarray,
    offset: np.ndarray,
    means: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Parameters (m, 8) and covariance counted from the point, not from its pixel."""
    parameters = np.concatenate([T.reshape(-1, 6), h], axis=1)
    # Derivatives of the eight parameters by (q, h0, h1)
    P = np.zeros((len(T), 8, Q.shape[-1]))
    P[:, :6, :6] = np.kron(T[:, :, 1:], np.eye(3))
    if Q.shape[-1] == 8:
        P[:, 6, 6] = P[:, 7, 7] = 1
        P[:, 6, 7] = -means[:, 1]
    parameters[:, 6] += means[:, 0] - h[:, 1] * means[:, 1]
    x, y = offset.T
    for values in (parameters, P):
        for a in (0, 3):
            values[:, a] += (x * values[:, a + 1].T + y * values[:, a + 2].T).T
    return parameters, P @ Q @ np.swapaxes(P, 1, 2)
