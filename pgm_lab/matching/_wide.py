"""Features of photos from places far apart, matched where they themselves were found.

The surface around a feature need not move as its neighbours do: least squares begin at
the feature, in windows of several widths, and witnesses say which of them are right.
"""

from typing import NamedTuple

import numpy as np
import scipy

from pgm_lab import lsm
from pgm_lab._robust import SD_OF_MAD
from pgm_lab.matching._starts import Field

WIDTHS = 1.0, 0.7, 0.5, 0.4, 0.3  # of the template: each has about half the pixels
MIN_TEMPLATE, MIN_WIDTH = 7, 5  # px
AGREE = 0.25  # px between windows of two widths: texture leaves a tenth open
AROUND = 64  # matches from which the effect of curved surfaces is estimated
DENIED = "parts disagree", "left-right check failed", "diverged", "diverged"


class Tried(NamedTuple):
    """What least squares found in windows of one width, or of several (w, ...)."""

    points: np.ndarray  # (n, 2)
    covariance: np.ndarray  # (n, 2, 2)
    shape: np.ndarray  # (n, 2, 2)
    r: np.ndarray  # (n,)
    status: np.ndarray  # (n,)
    missed: np.ndarray  # (n,) px in the left photo, matched back

    def of(self, width: np.ndarray, k: np.ndarray) -> "Tried":
        """Return the points k, each in one of several widths."""
        return Tried(*(values[width, k] for values in self))

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

    Each gets the window that most others confirm, the widest of several such windows.
    """
    points, start, n = field.left[chosen], field.right[chosen], np.arange(len(chosen))
    _, shape = field.at(points)
    widths = {max(MIN_WIDTH, int(w * template / 2) * 2 + 1) for w in WIDTHS}
    width = np.array(sorted(widths, reverse=True))
    several = [
        _both_ways(left, right, points, start, shape, one, threshold) for one in width
    ]
    tried = Tried(*map(np.stack, zip(*several, strict=True)))
    off = _witnesses(tried, start, field.lines(points), field.noise, back)
    q = 1 / (1 + off.max(axis=0) ** 2)
    confirmed = (q >= least_quality) & (q > 0)
    best = confirmed.sum(axis=1).argmax(axis=0)
    found, confirmed, q = tried.of(best, n), confirmed[best, :, n], q[best, :, n]
    bad, closest = ~confirmed.any(axis=1), off[0, best, :, n].argmin(axis=1)
    denied = np.array(DENIED)[off[:, best, closest, n].argmax(axis=0)]
    found.status[:] = np.where(bad & (found.status == "accepted"), denied, found.status)
    quality = np.where(bad & (found.status != DENIED[0]), np.nan, q.max(axis=1))
    for values in (found.points, found.covariance, found.shape):
        values[bad] = np.nan
    k = np.flatnonzero(~bad)
    if len(k):
        one, other = best[k], confirmed.argmax(axis=1)[k]
        share = 1 - (width[other] / width[one]) ** 2
        surface = _of_surface(points[k], tried.of(one, k), tried.of(other, k), share)
        # Least squares see the curvature of some windows, and their covariance has it
        more = np.maximum(surface - found.variances[k], 0)
        found.covariance[k[:, None], [0, 1], [0, 1]] += more
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
    tried: Tried,
    start: np.ndarray,
    lines: np.ndarray | None,
    noise: float,
    back: float | None,
) -> np.ndarray:
    """How far (4, w, w, n) matches are from witnesses, by what each may be wrong."""
    # They are a window of another width, the match back, descriptor and epipolar line
    x, ((a1, a2), (b1, b2)) = tried.points, np.moveaxis(tried.shape, (2, 3), (0, 1))
    scale = np.maximum(np.sqrt(np.abs(a1 * b2 - a2 * b1)), 1)
    off = np.zeros((4, len(x), *scale.shape))
    off[0] = np.linalg.norm(x[:, None] - x, axis=3) / (AGREE * scale[:, None])
    off[0, np.arange(len(x)), np.arange(len(x))] = np.nan  # none is its own witness
    if back is not None:
        off[1] = tried.missed[:, None] / back
    off[2] = (np.linalg.norm(x - start, axis=2) / (noise * scale))[:, None]
    if lines is not None:
        a, b, c = lines.T
        away = np.abs(a * x[..., 0] + b * x[..., 1] + c) / np.hypot(a, b)
        off[3] = (away / (noise * scale))[:, None]
    return np.nan_to_num(off, nan=np.inf)


def _of_surface(
    points: np.ndarray, one: Tried, other: Tried, share: np.ndarray
) -> np.ndarray:
    """Variances (n, 2) that come from surfaces that are no planes, near each match."""
    # What a window sees of a surface grows with its area, and what it sees beyond a
    # narrower one is new: two widths differ by this share of its variance, and by noise
    share = share[:, None]
    moved = np.abs(one.points - other.points) / np.sqrt(np.abs(share))
    of_noise = np.maximum((other.variances - one.variances) / share, 0)
    number = np.arange(1, min(AROUND, len(points)) + 1)
    _, near = scipy.spatial.cKDTree(points).query(points, number)
    seen = (SD_OF_MAD * np.median(moved[near], axis=1)) ** 2
    return np.maximum(seen - np.median(of_noise[near], axis=1), 0)
