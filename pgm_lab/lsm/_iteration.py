"""The iteration of least squares matching, for some points at a time.

Parts of the right image around the points are cut out once and resampled in each
iteration: quickly at first, then by the spline of `half_pixels`. Points that fail are
tried again, starting from a match of blurred images.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import scipy

from pgm_lab.image.resampling import mirrored
from pgm_lab.lsm import _normal_equations, half_pixels
from pgm_lab.lsm._normal_equations import put, take
from pgm_lab.ncc.search_area import cut_out

STATUS = "<U40"
CHUNK = 128  # points at a time, or more if their windows have so many pixels in all:
PIXELS = CHUNK * 21**2  # then they stay in the cache
MAX_REMAP = 32_766  # px, what cv2.remap can address
SPLINE = -1  # besides OpenCV's names
METHODS = cv2.INTER_LINEAR, cv2.INTER_LANCZOS4, SPLINE  # from rough to fine
CROSS = np.array([[[0, 1, 0], [1, 1, 1], [0, 1, 0]]])  # a pixel and its neighbours
COARSE = 1.0, 0.25  # px, at which the next, finer resampling takes over
AROUND = (
    half_pixels.RADIUS + 1
)  # px to each side that the spline, and all others, depend on
PATIENCE = 4  # iterations before the derivatives of both windows are used
SLACK = 1.0  # px a window may move before its part is cut anew; then twice as much
MAX_STRETCH = 3  # half windows that a corner may lie from the centre along x or y
BLUR = 3.0  # px, standard deviation: for windows outside the pull-in range
BLURRED_TOLERANCE = 0.3  # px, at which the sharp images take over
FAILED = -1
# What a start from blurred images may cure
RETRIED = (
    *("diverged", "not converged", "below threshold"),
    *("window leaves the image", "no data in the window"),
)


@dataclass(frozen=True)
class Settings:
    """Arguments of `match`."""

    half: int
    radiometric: bool
    threshold: float
    tolerance: float
    max_iterations: int
    correlated: bool
    smooth: float


@dataclass(frozen=True)
class Found:
    """Transformations and all that goes with them; NaN where not converged."""

    T: np.ndarray  # (m, 2, 3)
    h: np.ndarray  # (m, 2) of grey values minus their means
    Q: np.ndarray  # (m, u, u) covariance of (q, h0, h1)
    means: np.ndarray  # (m, 2) left and right
    sigma0: np.ndarray
    effective_pixels: np.ndarray
    r: np.ndarray
    iterations: np.ndarray
    status: np.ndarray


def at_once(half: int) -> int:
    """Points whose windows OpenCV can address in one array, and the cache can hold."""
    size = 2 * ((MAX_STRETCH + 1) * half + AROUND + margin(BLUR) + 2) + 1
    return max(1, min(max(CHUNK, PIXELS // (2 * half + 1) ** 2), MAX_REMAP // size))


def find(
    left: np.ndarray, right: np.ndarray, pixels: np.ndarray, T: np.ndarray, s: Settings
) -> Found:
    """Match the windows around left pixels (m, 2), from the transformations T."""
    # Points that failed get a second attempt, from a match of blurred images: there the
    # texture is coarser and the pull-in range wider.
    found = attempt(left, right, pixels, T, s)
    k = np.flatnonzero(np.isin(found.status, RETRIED))
    if not len(k):
        return found
    template, means, _, status = _windows(left, right, pixels[k], T[k], s, BLUR)
    goals = [(cv2.INTER_LINEAR, BLURRED_TOLERANCE)]
    start, _, n = _iterate(template, right, means[:, 1], T[k], s, goals, status, BLUR)
    found.iterations[k] += n
    arrived = status == "accepted"
    k, start = k[arrived], start[arrived]
    if not len(k):
        return found
    again = attempt(left, right, pixels[k], start, s)
    again.iterations[:] += found.iterations[k]
    better = again.status == "accepted"
    put(found, k[better], take(again, np.flatnonzero(better)))
    return found


def attempt(
    left: np.ndarray, right: np.ndarray, pixels: np.ndarray, T: np.ndarray, s: Settings
) -> Found:
    """Match the windows once, and estimate the precision."""
    template, means, textured, status = _windows(left, right, pixels, T, s, s.smooth)
    goals = zip(METHODS, (*COARSE, s.tolerance), strict=True)
    T, last, iterations = _iterate(
        template, right, means[:, 1], T, s, list(goals), status, s.smooth
    )
    good = np.flatnonzero(status == "accepted")
    template, last = take(template, good), take(last, good)
    Q, sigma0, effective, singular = _normal_equations.precision(
        template, T[good], last, s.correlated, s.smooth
    )
    # Saturated pixels have no noise: they do not show how large it is in the others
    k, u = template.rows.shape[2], Q.shape[1]
    n = textured[good]
    most = np.where(n < k, k * (n - u) / (k - u), np.inf)
    Q *= np.maximum(effective / most, 1)[:, None, None]
    effective = np.minimum(effective, most)
    r = _normal_equations.correlation(template, last)
    status[good[~(np.abs(r) >= s.threshold)]] = "below threshold"
    status[good[singular]] = "position not determined"
    # Grey values that are all the same have no correlation: nothing was matched
    status[good[np.isnan(r)]] = "flat window"

    def of_all(values: np.ndarray) -> np.ndarray:
        """The values of the points that converged, and NaN for the others."""
        found = np.full((len(T), *values.shape[1:]), np.nan)
        found[good] = values
        return found

    h, Q, sigma0, effective, r = map(of_all, (last.h, Q, sigma0, effective, r))
    return Found(T, h, Q, means, sigma0, effective, r, iterations, status)


def _windows(
    left: np.ndarray,
    right: np.ndarray,
    pixels: np.ndarray,
    T: np.ndarray,
    s: Settings,
    blur: float = 0.0,
) -> tuple[_normal_equations.Templates, np.ndarray, np.ndarray, np.ndarray]:
    """Left windows around pixels (m, 2), means, number of textured pixels, status."""
    # The means (m, 2) are of both windows: counted from them, grey values keep more
    # digits. The status is "not converged" of all that can be matched, for now.
    grey = cut(left, pixels, s.half + half_pixels.RADIUS + margin(blur))
    means = np.stack([grey.mean(axis=(1, 2))] * 2, axis=1)
    no_data = np.isnan(means[:, 0])
    if s.radiometric:
        here = np.rint(T[:, :, 0]).astype(int)
        around = cut(right, here, s.half)
        known = np.count_nonzero(~np.isnan(around), axis=(1, 2))
        means[:, 1] = np.nansum(around, axis=(1, 2)) / np.maximum(known, 1)
    grey -= means[:, 0, None, None]
    grey[no_data] = 0
    m, size, _ = grey.shape
    stack = blurred(grey.reshape(-1, size), blur)
    middle = np.stack([np.zeros(m, int), np.arange(m) * size], axis=1) + size // 2
    template = _normal_equations.templates(
        stack, half_pixels.gradient(stack), middle, s.half, s.radiometric
    )
    status = np.full(m, "not converged", dtype=STATUS)
    status[template.singular] = "position not determined"
    textured = _textured(template.rows[:, -1].reshape(m, 2 * s.half + 1, -1))
    few = textured < 2 * (8 if s.radiometric else 6)
    status[template.flat | few] = "flat template"
    status[no_data] = "no data in the template"
    return template, means, textured, status


def _textured(grey: np.ndarray) -> np.ndarray:
    """How many pixels of windows (m, w, w) do not lie inside a saturated area."""
    # Inside: as bright as the brightest or as dark as the darkest, like all neighbours
    inside = np.zeros(grey.shape, bool)
    for extreme in (np.max, np.min):
        same = grey == extreme(grey, axis=(1, 2), keepdims=True)
        inside |= scipy.ndimage.binary_erosion(same, CROSS, border_value=1)
    return grey[0].size - inside.sum(axis=(1, 2))


def _iterate(
    template: _normal_equations.Templates,
    image: np.ndarray,
    means: np.ndarray,
    T: np.ndarray,
    s: Settings,
    goals: list[tuple[int, float]],
    status: np.ndarray,
    blur: float = 0.0,
) -> tuple[np.ndarray, _normal_equations.Solution, np.ndarray]:
    """Iterate from T (m, 2, 3), by one resampling to its goal, then by the next."""
    # Returns the transformations, the last solution and the numbers of iterations. The
    # status becomes "accepted" where the last goal was reached.
    T, first, half = T.copy(), T[:, :, 0].copy(), s.half
    grid = _normal_equations.window_grid(half)
    iterations = np.zeros(len(T), int)
    last = _normal_equations.Solution.blank(template)

    usable = status == "not converged"
    level = np.where(usable, 0, FAILED)  # goals that a point has reached

    def step(parts: Parts, k: np.ndarray, method: int, goal: float) -> None:
        """Iterate the points k once."""
        B = parts.at(T[k] @ grid, k, method)
        found = _normal_equations.solve(take(template, k), B)
        put(last, k, found)
        q, slow = found.q, iterations[k] >= PATIENCE
        if slow.any():
            q[slow] = _normal_equations.step_of_both(
                take(template, k[slow]), B[slow], found.h[slow, 1]
            )
        dT = T[k][:, :, 1:] @ q
        T[k] += dT
        iterations[k] += 1
        lost = _lost(T[k], first[k], half)
        status[k[lost]] = "diverged"
        status[k[np.isnan(found.vv)]] = "flat window"
        status[k[np.isnan(found.total)]] = "no data in the window"
        gone = ~lost & outside(T[k], half, image.shape)
        status[k[gone]] = "window leaves the image"
        level[k[_farthest(dT, half) <= goal]] += 1
        level[k[lost | gone]] = FAILED

    def going() -> np.ndarray:
        unfinished = (level != FAILED) & (level < len(goals))
        return unfinished & (iterations < s.max_iterations)

    slack = SLACK
    while len(k := np.flatnonzero(going())):
        before, reach = T.copy(), half * np.abs(T[k][:, :, 1:]).sum(axis=2).max()
        parts = Parts.of(image, means, T, k, reach + slack, blur)
        for n, (method, goal) in enumerate(goals):
            while np.any(
                now := going() & (level == n) & (_farthest(T - before, half) <= slack)
            ):
                step(parts, np.flatnonzero(now), method, goal)
        slack = min(2 * slack, half)
    status[level == len(goals)] = "accepted"
    return T, last, iterations


def _farthest(dT: np.ndarray, half: int) -> np.ndarray:
    """Pixels (m,) that the change dT (m, 2, 3) may move a corner along x or y."""
    return (np.abs(dT) @ [1, half, half]).max(axis=1)


def outside(T: np.ndarray, half: int, image_shape: tuple[int, ...]) -> np.ndarray:
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
    return ~(near & (area > 1 / 4) & (area < 4) & (reach < MAX_STRETCH))


# --- Parts of the right image, ready to be resampled ---


@dataclass(frozen=True)
class Parts:
    """The image around m windows, cut once for all methods of resampling."""

    grey: np.ndarray  # (m, size, size) in single precision
    corner: np.ndarray  # (n, 2) top left pixel of the part of each point
    place: np.ndarray  # (n,) index of that part

    @classmethod
    def of(
        cls,
        image: np.ndarray,
        means: np.ndarray,
        T: np.ndarray,
        k: np.ndarray,
        reach: float,
        blur: float = 0.0,
    ) -> "Parts":
        """Prepare the windows k of T (m, 2, 3), to `reach`, minus their means."""
        pixels = np.rint(T[k, :, 0]).astype(int)
        beside = int(np.ceil(reach + 0.5)) + AROUND + margin(blur)
        size = 2 * beside + 1
        grey = cut(image, pixels, beside)
        grey -= means[k, None, None]
        grey = blurred(grey.astype(np.float32).reshape(-1, size), blur)
        corner, place = np.zeros((len(T), 2)), np.zeros(len(T))
        corner[k], place[k] = pixels - beside, np.arange(len(k))
        return cls(grey.reshape(-1, size, size), corner, place)

    @cached_property
    def fine(self) -> np.ndarray:
        """Coefficients of splines through the grey values."""
        return half_pixels.inner_coefficients(self.grey)

    def at(self, X: np.ndarray, k: np.ndarray, method: int) -> np.ndarray:
        """Grey values at X (j, 2, pixels) of the windows k (j,)."""
        # The spline is good to a thousandth of the contrast; the others are quick, at
        # X to 1/32 px, where every version of OpenCV gives the same. The parts are
        # stacked one below the other.
        x, y = np.moveaxis(X - self.corner[k, :, None], 1, 0)
        size = self.grey.shape[1]
        place = self.place[k, None]
        if method == SPLINE:
            inner = size - 2 * half_pixels.RADIUS
            y = y - half_pixels.RADIUS + place * inner
            fine = self.fine.reshape(-1, 2 * inner)
            return half_pixels.sample(fine, x - half_pixels.RADIUS, y)
        y += place * size
        x, y = (np.rint(32 * at).astype(np.float32) / 32 for at in (x, y))
        return cv2.remap(self.grey.reshape(-1, size), x, y, method).astype(float)


def cut(image: np.ndarray, pixels: np.ndarray, reach: int) -> np.ndarray:
    """Parts (m, size, size) of an image around pixels; NaN where there is no data."""
    # Beyond its edge the image is mirrored, as the filters of `half_pixels` do
    size = 2 * reach + 1, 2 * reach + 1
    grey = np.ma.getdata(image)
    with np.errstate(over="ignore"):  # too large for a float becomes infinite
        found = cut_out(grey, pixels, size, mirrored).astype(float)
    if grey.dtype.kind == "f":
        found[~np.isfinite(found)] = np.nan
    if np.ma.is_masked(image):
        mask = np.ma.getmaskarray(image)
        found[cut_out(mask, pixels, size, mirrored)] = np.nan
    return found


def margin(blur: float) -> int:
    """Pixels to each side that a blurred grey value depends on."""
    return int(np.ceil(3 * blur))


def blurred(grey: np.ndarray, blur: float) -> np.ndarray:
    """Grey values under a Gaussian of standard deviation `blur`; as they are if 0."""
    size = 2 * margin(blur) + 1
    return cv2.GaussianBlur(grey, (size, size), blur) if blur else grey
