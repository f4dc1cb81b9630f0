"""From coarse to fine: each level searches around what the level above has found."""

import numpy as np

from pgm_lab.stereo._boxes import Image, warped
from pgm_lab.stereo._correlate import Peaks, search
from pgm_lab.stereo._planes import on_planes
from pgm_lab.stereo._pyramid import filled, finer, pyramid

REACH = 3  # px, search on all levels but the coarsest
TRUSTED = 0.6  # r on coarse levels; less is filled from the neighbours
AGREE = 1.0  # px between the two directions


def coarse_to_fine(
    left: Image, right: Image, levels: int, window: int, reach: int
) -> tuple[Peaks, np.ndarray]:
    """Peaks of the finest level, and whether both directions agree there.

    The way back is the same search with both images exchanged and seen in a mirror, in
    which a disparity keeps its sign.
    """
    lefts, rights = pyramid(left, levels), pyramid(right, levels)
    there = back = np.zeros(lefts[-1].grey.shape, np.float32)
    for k in reversed(range(levels)):
        L, R = lefts[k], rights[k]
        if k < levels - 1:
            there, back = (finer(a, L.grey.shape) for a in (there, back))
        how = window, reach if k == levels - 1 else REACH, 0.5 if k else 1.0
        one = search(L, R, there, *how)
        two = search(R.flipped(), L.flipped(), back, *how)
        agree = agreement(one.d, two.d)
        if k:
            there = _smooth(one, agree, window)
            back = _smooth(two, agreement(two.d, one.d), window)
    return one, agree


def agreement(there: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Whether the way there, and back in the mirror, ends where it began."""
    mirrored = np.ascontiguousarray(back[:, ::-1])
    return np.abs(there - warped(mirrored, there)) < AGREE


def _smooth(peaks: Peaks, agree: np.ndarray, window: int) -> np.ndarray:
    """Disparities on their local planes; those not to be trusted from neighbours."""
    good = agree & peaks.inside & (peaks.r > TRUSTED)
    return filled(on_planes(peaks.d, good, window), good)
