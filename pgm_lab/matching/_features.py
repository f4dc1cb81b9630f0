"""Start values from features that look the same in both photos."""

import cv2
import numpy as np
import scipy

from pgm_lab.matching._field import Field

PIXELS = 1e6  # of the reduced photo that features are sought in
FEATURES = 6000  # in a photo
RATIO = 0.8  # of the distances to the nearest and the second nearest (Lowe 2004)
FEWEST = 12  # features that fit together
SHARE = 0.25  # of those compared that have to fit together
PLANE = 0.85  # share of what the fundamental matrix explains


def field(left: np.ndarray, right: np.ndarray) -> Field:
    """Find features that fit together."""
    p, of_left = _describe(left)
    q, of_right = _describe(right)
    i, j = _alike(of_left, of_right)
    p, q = p[i], q[j]
    noise = 1.5 * reduction(right)
    fit, F = fitting(p, q, noise)
    fit[fit] = smooth(p[fit], q[fit])
    if fit.sum() < max(FEWEST, SHARE * len(p)):
        raise ValueError(
            f"only {fit.sum()} of {len(of_left)} and {len(of_right)} features of the"
            " two photos fit together: do they show the same? If they do, give points"
            ' and start, or try start="pyramid" where they differ by a shift only'
        )
    return Field(p[fit], q[fit], noise, F)


def _describe(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Features (m, 2) of a photo and their descriptors (m, 128).

    The descriptors are the square roots of those of SIFT: their distance is that of
    Hellinger (Arandjelovic and Zisserman 2012).
    """
    mask = np.ma.getmask(image)
    grey = reduced(image, reduction(image))
    here = None
    if np.ndim(mask):
        there = cv2.resize(np.asarray(mask, np.uint8), grey.shape[::-1])
        here = 1 - cv2.dilate(there, np.ones((9, 9), np.uint8))
    found, descriptors = cv2.SIFT.create(
        FEATURES, enable_precise_upscale=True
    ).detectAndCompute(grey, here)
    if descriptors is None:
        return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
    points = of_full_size(np.array([one.pt for one in found]), grey, image)
    sums = descriptors.sum(axis=1, keepdims=True)
    return points, np.sqrt(descriptors / np.maximum(sums, 1))


def eight_bit(image: np.ndarray) -> np.ndarray:
    """Grey values stretched to 8 bits; the mean where there are none."""
    values: np.ndarray = np.ma.getdata(image)
    mask = np.ma.getmask(image)
    if values.dtype == np.uint8 and not np.ndim(mask):
        return values
    good = values[~mask] if np.ndim(mask) else values
    low, high = np.percentile(good.ravel()[:: max(1, good.size // 10**6)], [0.1, 99.9])
    if not high > low:
        return np.zeros(values.shape, np.uint8)
    grey = np.clip((values - low) * (255 / (high - low)), 0, 255)
    if np.ndim(mask):
        grey[mask] = grey[~mask].mean()
    return np.rint(grey).astype(np.uint8)


def reduction(image: np.ndarray) -> float:
    """Pixels along a pixel of the reduced photo, which has a million or so."""
    return max(1.0, float(np.sqrt(image.size / PIXELS)))


def reduced(image: np.ndarray, factor: float) -> np.ndarray:
    """The photo with 8 bits, and so many times smaller."""
    grey = eight_bit(image)
    if factor == 1:
        return grey
    columns, rows = (max(1, round(n / factor)) for n in grey.shape[::-1])
    return cv2.resize(grey, (columns, rows), interpolation=cv2.INTER_AREA)


def of_full_size(points: np.ndarray, small: np.ndarray, full: np.ndarray) -> np.ndarray:
    """Points of a reduced photo in the photo itself.

    A pixel of the reduced one covers some of the other: its middle is that of theirs.
    """
    ratio = np.array(full.shape[::-1]) / small.shape[::-1]
    return (points + 0.5) * ratio - 0.5


def _alike(left: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the descriptors that choose each other, much before all others."""
    if min(len(left), len(right)) < 2:
        return np.zeros(0, int), np.zeros(0, int)
    forward, clear = _nearest(left, right)
    backward, _ = _nearest(right, left)
    i = np.flatnonzero(clear & (backward[forward] == np.arange(len(left))))
    return i, forward[i]


def _nearest(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest of the other descriptors, and whether the second is far behind."""
    nearest, clear = np.zeros(len(one), int), np.zeros(len(one), bool)
    for k in range(0, len(one), 1000):
        part = slice(k, k + 1000)
        near = one[part] @ other.T  # of vectors of length one: 1 - distance^2 / 2
        nearest[part] = near.argmax(axis=1)
        rows = np.arange(len(near))
        first = near[rows, nearest[part]]
        near[rows, nearest[part]] = -1
        second = near.max(axis=1)
        clear[part] = 1 - first < RATIO**2 * (1 - second)
    return nearest, clear


def fitting(
    p: np.ndarray, q: np.ndarray, threshold: float
) -> tuple[np.ndarray, np.ndarray | None]:
    """Which pairs fit a plane, or else a fundamental matrix, and this matrix."""
    none = np.zeros(len(p), bool)
    if len(p) < FEWEST:
        return none, None
    settings = cv2.UsacParams()  # with a seed of their own: the same each time
    settings.threshold = threshold
    settings.confidence = 0.9999
    settings.score = cv2.SCORE_METHOD_MAGSAC
    _, found = cv2.findHomography(p, q, settings)
    plane = none if found is None else found.ravel() > 0
    try:
        F, found = cv2.findFundamentalMat(p, q, settings)
    except cv2.error:  # OpenCV 5.0 fails on some photos of a plane
        return plane, None
    if F is None or F.shape != (3, 3) or found is None:
        return plane, None
    space = found.ravel() > 0
    if plane.sum() >= PLANE * space.sum():
        return plane, None
    return space, F


def smooth(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Whether a feature has moved about as its neighbours have."""
    if len(p) < FEWEST:
        return np.ones(len(p), bool)
    _, near = scipy.spatial.cKDTree(p).query(p, min(9, len(p)))
    offset = q - p
    middle = np.median(offset[near[:, 1:]], axis=1)
    away = np.linalg.norm(offset - middle, axis=1)
    spread = np.linalg.norm(offset[near[:, 1:]] - middle[:, None], axis=2)
    return away <= 5 * np.median(spread, axis=1) + 5
