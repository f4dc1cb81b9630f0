"""Features of photos from places far apart, matched where they themselves were found.

The surface around a feature need not move as its neighbours do: least squares begin at
the feature, in windows of several widths, and witnesses say whether they are right.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from pgm_lab import lsm
from pgm_lab._robust import SD_OF_MAD
from pgm_lab.matching._starts import Field

WIDTHS = 1.0, 0.7, 0.5, 0.4  # of the template: each has about half the pixels
MIN_TEMPLATE, MIN_WIDTH = 7, 5  # px
AGREE = 0.3  # px between windows of two widths: three times what texture leaves open
AROUND = 64  # matches from which the effect of curved surfaces is estimated
DENIED = "parts disagree", "left-right check failed", "diverged", "diverged"


class Tried(NamedTuple):
    """What least squares found in windows of one width."""

    points: np.ndarray  # (n, 2)
    covariance: np.ndarray  # (n, 2, 2)
    shape: np.ndarray  # (n, 2, 2)
    r: np.ndarray  # (n,)
    status: np.ndarray  # (n,)
    missed: np.ndarray  # (n,) px in the left photo, matched back

    def of(self, k: np.ndarray) -> "Tried":
        """Return the points k."""
        return Tried(*(values[k] for values in self))

    @property
    def variances(self) -> np.ndarray:
        """Variances (n, 2) of column and row."""
        return self.covariance[:, [0, 1], [0, 1]]


def match(
    left: np.ndarray,
    right: np.ndarray,
    field: Field,
    chosen: np.ndarray,
    template: int,
    threshold: float,
    back: float | None,
    least_quality: float,
) -> tuple[Tried, np.ndarray]:
    """Match chosen features of a field, and return the quality (n,) of the matches.

    Each gets the widest window with which all witnesses agree.
    """
    points, start = field.left[chosen], field.right[chosen]
    _, shape = field.at(points)
    lines = field.lines(points)
    widths = sorted({max(MIN_WIDTH, int(w * template / 2) * 2 + 1) for w in WIDTHS})

    def tried(k: np.ndarray, width: int) -> Tried:
        return _both_ways(left, right, points[k], start[k], shape[k], width, threshold)

    k = np.arange(len(points))
    wide = tried(k, template)
    found, quality = wide.of(k), np.full(len(k), np.nan)
    curved, chance = np.zeros((2, len(k), 2))
    for width, smaller in pairwise(widths[::-1]):
        small = tried(k, smaller)
        line = None if lines is None else lines[k]
        off = _witnesses(wide, small, start[k], line, field.noise, back)
        q = 1 / (1 + off.max(axis=0) ** 2)
        fits = wide.status == "accepted"
        good = fits & (q >= least_quality) & (q > 0)
        if width == template:
            denied = np.array(DENIED)[off.argmax(axis=0)]
            found.status[:] = np.where(fits & ~good, denied, wide.status)
            quality[:] = np.where(found.status == DENIED[0], q, np.nan)
        # A curved surface moves a window by the square of its width: what two widths
        # say differently is this share of it, and has the variance that noise leaves
        share = 1 - (smaller / width) ** 2
        moved = (wide.points - small.points) / share
        of_noise = np.maximum(small.variances - wide.variances, 0) / share**2
        new = (*wide, q, moved, of_noise)
        for values, one in zip((*found, quality, curved, chance), new, strict=True):
            values[k[good]] = one[good]
        k, wide = k[~good], small.of(~good)
    bad = found.status != "accepted"
    for values in (found.points, found.covariance, found.shape):
        values[bad] = np.nan
    k = np.flatnonzero(~bad)
    if len(k):
        # Least squares see the curvature of some windows, and their covariance has it
        more = _of_curvature(points[k], curved[k], chance[k]) - found.variances[k]
        found.covariance[k[:, None], [0, 1], [0, 1]] += np.maximum(more, 0)
    return found, quality


def _both_ways(
    left: np.ndarray,
    right: np.ndarray,
    points: np.ndarray,
    start: np.ndarray,
    shape: np.ndarray,
    width: int,
    threshold: float,
) -> Tried:
    """Match points, and what was found back in the left photo."""
    fine = lsm.match(
        left, right, points, start, width, shape=shape, threshold=threshold
    )
    A, missed = fine.parameters[:, [[1, 2], [4, 5]]], np.full(len(points), np.nan)
    k = np.flatnonzero(fine.accepted)
    back = lsm.match(
        *(right, left, fine.points[k], points[k], width),
        shape=np.linalg.inv(A[k]), threshold=threshold,
    )  # fmt: skip
    missed[k] = np.hypot(*(back.points - points[k]).T)
    return Tried(fine.points, fine.covariance, A, fine.r, fine.status, missed)


def _witnesses(
    wide: Tried,
    small: Tried,
    start: np.ndarray,
    lines: np.ndarray | None,
    noise: float,
    back: float | None,
) -> np.ndarray:
    """How far (4, n) matches are from witnesses, by what each may be wrong."""
    # They are a smaller window, the match back, the descriptor and the epipolar line
    x, ((a1, a2), (b1, b2)) = wide.points, np.moveaxis(wide.shape, 0, 2)
    scale = np.maximum(np.sqrt(np.abs(a1 * b2 - a2 * b1)), 1)
    off = np.zeros((4, len(x)))
    off[0] = np.hypot(*(x - small.points).T) / (AGREE * scale)
    if back is not None:
        off[1] = wide.missed / back
    off[2] = np.hypot(*(x - start).T) / (noise * scale)
    if lines is not None:
        a, b, c = lines.T
        away = np.abs(a * x[:, 0] + b * x[:, 1] + c) / np.hypot(a, b)
        off[3] = away / (noise * scale)
    return np.nan_to_num(off, nan=np.inf)


def _of_curvature(
    points: np.ndarray, moved: np.ndarray, of_noise: np.ndarray
) -> np.ndarray:
    """Variances (n, 2) that come from curved surfaces, among the nearest matches."""
    number = np.arange(1, min(AROUND, len(points)) + 1)
    _, near = scipy.spatial.cKDTree(points).query(points, number)
    seen = (SD_OF_MAD * np.median(np.abs(moved)[near], axis=1)) ** 2
    return np.maximum(seen - np.median(of_noise[near], axis=1), 0)
