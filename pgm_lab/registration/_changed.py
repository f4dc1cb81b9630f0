"""Chips that changed: textured in both images, but matched by nothing in the other."""

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view

from pgm_lab import ncc

NEIGHBOURS = 8  # accepted chips around one, that it is compared with
LEAST = 5  # accepted chips, below which nobody can say what is usual
FAR = 4.0  # times smaller than expected is the signal-to-noise ratio of what changed
HALF = 0.5  # of the variance
CHUNK = 2000  # chips at a time


def changed(
    reference: np.ndarray,
    sensed: np.ndarray,
    points: np.ndarray,
    found: ncc.Match,
    status: np.ndarray,
    chip: int,
    threshold: float,
) -> np.ndarray:
    """Say which chips (n,) fell far below what their neighbours let expect.

    The share 1 - r^2 of a chip's variance V is what the other image does not explain;
    noise is a part of these (1 - r^2) V grey values squared. With the eight nearest
    accepted chips, a chip with the texture V could have reached R in

        1 - R^2 = max(median(1 - r^2), min((1 - r^2) V) / V),

    the larger of what both images say. It changed if R would have been accepted, but
    less than half of V is explained, and the signal-to-noise ratio r^2 : (1 - r^2) is
    below a quarter of that of R. What is flat in an image cannot tell of a change.
    """
    lost = np.zeros(len(points), bool)
    accepted = np.flatnonzero(status == "accepted")
    if len(accepted) < LEAST:
        return lost
    unlike = 1 - np.maximum(found.r, 0) ** 2
    k = np.flatnonzero(unlike > HALF)  # not NaN, where nothing was compared
    among = min(NEIGHBOURS, len(accepted))
    near = accepted[scipy.spatial.cKDTree(points[accepted]).query(points[k], among)[1]]
    expected = np.median(unlike[near], axis=1)
    for image, at in ((reference, points), (sensed, found.points)):
        some = np.unique(near)
        noise = np.zeros(len(points))
        noise[some] = unlike[some] * _variances(image, at[some], chip)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = noise[near].min(axis=1) / _variances(image, at[k], chip)
        expected = np.fmin(np.maximum(expected, share), 1)  # 1 where it is flat
    far = (1 - unlike[k]) * expected < unlike[k] * (1 - expected) / FAR
    lost[k] = far & (1 - expected >= max(threshold, 0) ** 2)
    return lost


def _variances(image: np.ndarray, at: np.ndarray, chip: int) -> np.ndarray:
    """Variances (n,) of the chips around whole pixels (n, 2)."""
    every = sliding_window_view(np.ma.getdata(image), (chip, chip))
    column, row = (np.floor(at + 0.5) - chip // 2).astype(int).T
    found = [
        every[row[i : i + CHUNK], column[i : i + CHUNK]].var(axis=(1, 2), dtype=float)
        for i in range(0, len(at), CHUNK)
    ]
    return np.concatenate(found) if found else np.zeros(0)
