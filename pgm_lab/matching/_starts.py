"""Start values: where the points of the left photo lie in the right one.

A `Field` of features that look the same in both photos predicts where any other point
lies, and how its window is rotated and scaled.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import scipy

from pgm_lab.image.grey import eight_bit

NEIGHBOURS = 16  # features that predict where a point lies
STIFFNESS = 30.0  # px: features within less than that do not determine a shape
REWEIGHTINGS = 5  # of the robust adjustment
MAX_PIXELS = 1e6  # of the reduced photo in which features are searched for
MAX_FEATURES = 6000  # in a photo
LOWE_RATIO = 0.8  # of the distances to the nearest and the second nearest (Lowe 2004)
MIN_INLIERS = 12  # features that fit together
MIN_INLIER_SHARE = 0.25  # of those compared
PLANE_SHARE = 0.85  # of what the fundamental matrix explains: then it is a plane


# --- The field of points found in both photos ---


@dataclass(frozen=True, eq=False)
class Field:
    """Points that were found in both photos."""

    left: np.ndarray  # (m, 2)
    right: np.ndarray  # (m, 2)
    noise: float = 1.5  # px, their uncertainty
    # Fundamental matrix: (u, v, 1) F (x, y, 1) = 0 for (x, y) left and (u, v) right;
    # None where one plane, or the rotation of a camera, explains all points
    F: np.ndarray | None = None

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 2) in the right photo, and shapes (n, 2, 2), of left points."""
        # An affine transformation of the neighbours, weighted by their distance; its
        # shape is pulled towards that of all, the more the closer they are together
        middle = self.left.mean(axis=0, keepdims=True)
        m = len(self.left)
        all_of_them = np.arange(m)[None]
        position, shape = self._affine(middle, all_of_them, np.eye(2), 1.0)
        distance, near = scipy.spatial.cKDTree(self.left).query(
            points, min(NEIGHBOURS, m)
        )
        distance, near = (a.reshape(len(points), -1) for a in (distance, near))
        reach = np.median(distance, axis=1, keepdims=True) + 1.0
        weight = 1 / (1 + (distance / reach) ** 2)
        return self._affine(points, near, shape[0], weight)

    def width(self, shape: np.ndarray) -> float:
        """How far from its line a point may lie, in pixels of the left photo."""
        scale = np.sqrt(np.abs(np.linalg.det(shape)))
        return max(1.0, 2 * self.noise / float(np.median(scale))) if len(scale) else 1.0

    def lines(self, points: np.ndarray) -> np.ndarray | None:
        """Epipolar lines (n, 3) in the right photo, if they are known."""
        if self.F is None:
            return None
        return np.c_[points, np.ones(len(points))] @ self.F.T

    def _affine(
        self,
        points: np.ndarray,
        near: np.ndarray,
        prior: np.ndarray,
        weight: np.ndarray | float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Affine transformations of the features `near` (n, k), robustly."""
        offset = self.left[near] - points[:, None]
        # What the prior does not explain: right = prior offset + t + M offset
        rest = self.right[near] - offset @ prior.T
        A = np.concatenate([np.ones((*near.shape, 1)), offset], axis=2)
        P = np.diag([0.0, STIFFNESS**2, STIFFNESS**2])
        p = np.broadcast_to(weight, near.shape)
        t = np.median(rest, axis=1)
        v = np.linalg.norm(rest - t[:, None], axis=2)
        for _ in range(REWEIGHTINGS):
            scale = np.maximum(np.median(v, axis=1, keepdims=True), 0.5)
            w = p / (1 + (v / (2 * scale)) ** 2)
            N = np.einsum("nki,nk,nkj->nij", A, w, A) + P
            x = np.linalg.solve(N, np.einsum("nki,nk,nkj->nij", A, w, rest))
            v = np.linalg.norm(rest - A @ x, axis=2)
        return x[:, 0], prior + np.swapaxes(x[:, 1:], 1, 2)


# --- From features ---


def from_features(left: np.ndarray, right: np.ndarray, precise: bool = True) -> Field:
    """Find features that fit together; fewer, but better ones, where `precise`."""
    p, of_left = _describe(left, precise)
    q, of_right = _describe(right, precise)
    for photo, features in (("left", of_left), ("right", of_right)):
        if not len(features):
            raise ValueError(
                f"{photo} shows no texture: no feature was found in it that could be"
                " looked for in the other photo"
            )
    i, j = _mutual_nearest(of_left, of_right)
    p, q = p[i], q[j]
    noise = 1.5 * reduction(right)
    fit, F = fitting(p, q, noise)
    fit[fit] = smooth(p[fit], q[fit])
    if fit.sum() < max(MIN_INLIERS, MIN_INLIER_SHARE * len(p)):
        raise ValueError(
            f"only {fit.sum()} of {len(of_left)} and {len(of_right)} features of the"
            " two photos fit together: do both show the same object? If so, give points"
            " and start"
        )
    return Field(p[fit], q[fit], noise, F)


def _describe(image: np.ndarray, precise: bool) -> tuple[np.ndarray, np.ndarray]:
    """Features (m, 2) of a photo and the square roots (m, 128) of their descriptors."""
    # The distance of the roots is that of Hellinger (Arandjelovic and Zisserman 2012)
    mask = np.ma.getmask(image)
    grey = reduced(image, reduction(image))
    here = None
    if np.ndim(mask):
        there = cv2.resize(np.asarray(mask, np.uint8), grey.shape[::-1])
        here = 1 - cv2.dilate(there, np.ones((9, 9), np.uint8))
    found, descriptors = cv2.SIFT.create(
        MAX_FEATURES, enable_precise_upscale=precise
    ).detectAndCompute(grey, here)
    if descriptors is None:
        return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
    points = of_full_size(np.array([one.pt for one in found]), grey, image)
    sums = descriptors.sum(axis=1, keepdims=True)
    return points, np.sqrt(descriptors / np.maximum(sums, 1))


def reduction(image: np.ndarray) -> float:
    """Pixels along a pixel of the reduced photo, which has a million or so."""
    return max(1.0, float(np.sqrt(image.size / MAX_PIXELS)))


def reduced(image: np.ndarray, factor: float) -> np.ndarray:
    """The photo with 8 bits, reduced by a factor."""
    grey = eight_bit(image)
    if factor == 1:
        return grey
    columns, rows = (max(1, round(n / factor)) for n in grey.shape[::-1])
    return cv2.resize(grey, (columns, rows), interpolation=cv2.INTER_AREA)


def of_full_size(points: np.ndarray, small: np.ndarray, full: np.ndarray) -> np.ndarray:
    """Points of a reduced photo in the photo itself."""
    # A pixel of the reduced one covers several of the other: their centres coincide
    ratio = np.array(full.shape[::-1]) / small.shape[::-1]
    return (points + 0.5) * ratio - 0.5


def _mutual_nearest(
    left: np.ndarray, right: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Indices of descriptors that are each other's nearest, by a clear margin."""
    if min(len(left), len(right)) < 2:
        return np.zeros(0, int), np.zeros(0, int)
    forward, clear = _nearest(left, right)
    backward, _ = _nearest(right, left)
    i = np.flatnonzero(clear & (backward[forward] == np.arange(len(left))))
    return i, forward[i]


def _nearest(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest of the other descriptors, and whether the second is much farther."""
    nearest, clear = np.zeros(len(one), int), np.zeros(len(one), bool)
    for k in range(0, len(one), 1000):
        part = slice(k, k + 1000)
        near = one[part] @ other.T  # of vectors of length one: 1 - distance^2 / 2
        nearest[part] = near.argmax(axis=1)
        rows = np.arange(len(near))
        first = near[rows, nearest[part]]
        near[rows, nearest[part]] = -1
        second = near.max(axis=1)
        clear[part] = 1 - first < LOWE_RATIO**2 * (1 - second)
    return nearest, clear


def fitting(
    p: np.ndarray, q: np.ndarray, threshold: float
) -> tuple[np.ndarray, np.ndarray | None]:
    """Which pairs fit a plane, or else a fundamental matrix, and this matrix."""
    none = np.zeros(len(p), bool)
    if len(p) < MIN_INLIERS:
        return none, None
    settings = cv2.UsacParams()  # with their own seed: the same each time
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
    if plane.sum() >= PLANE_SHARE * space.sum():
        return plane, None
    return space, F


def smooth(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Whether a feature has moved about as its neighbours have."""
    if len(p) < MIN_INLIERS:
        return np.ones(len(p), bool)
    _, near = scipy.spatial.cKDTree(p).query(p, min(9, len(p)))
    offset = q - p
    middle = np.median(offset[near[:, 1:]], axis=1)
    away = np.linalg.norm(offset - middle, axis=1)
    spread = np.linalg.norm(offset[near[:, 1:]] - middle[:, None], axis=2)
    return away <= 5 * np.median(spread, axis=1) + 5
