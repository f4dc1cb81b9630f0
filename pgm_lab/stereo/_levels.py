"""From coarse to fine: each level searches around what the level above has found."""

import cv2
import numpy as np

from pgm_lab.stereo._boxes import warped
from pgm_lab.stereo._correlate import Peaks, search
from pgm_lab.stereo._pyramid import filled, finer, pyramid

REACH = 3  # px, search on all levels but the coarsest
TRUSTED = 0.6  # r on coarse levels; less is filled from the neighbours
AGREE = 1.0  # px between the two directions


def coarse_to_fine(left, right, levels: int, window: int, reach: int):
    """Peaks of the finest level, and whether both directions agree.

    left, right: (grey values, mask). The other direction is the same search with both
    images mirrored and exchanged, so that disparities keep their sign.
    """
    lefts, rights = pyramid(*left, levels), pyramid(*right, levels)
    there = back = np.zeros(lefts[-1][0].shape, np.float32)
    for k in reversed(range(levels)):
        L, R = lefts[k], rights[k]
        if k < levels - 1:
            there, back = finer(there, L[0].shape), finer(back, L[0].shape)
        q = reach if k == levels - 1 else REACH
        least = 0.5 if k else 1.0
        one = search(L, R, there, window, q, least)
        two = _mirrored(search(_flip(R), _flip(L), _flip([back])[0], window, q, least))
        agree = agreement(one.d, two.d)
        if k:
            there = filled(one.d, agree & (one.r > TRUSTED) & one.inside)
            good = agreement_of_right(one.d, two.d)
            back = filled(two.d, good & (two.r > TRUSTED) & two.inside)
    return one, agree


def agreement(there: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Whether the way there and back ends where it began."""
    other = warped(back, there, 0, cv2.INTER_LINEAR)
    return np.abs(there - other) < AGREE


def agreement_of_right(there, back):
    """The same for the pixels of the right image."""
    flipped = agreement(*(_flip([a])[0] for a in (back, there)))
    return flipped[:, ::-1]


def _flip(images):
    return tuple(np.ascontiguousarray(a[:, ::-1]) for a in images)


def _mirrored(peaks: Peaks) -> Peaks:
    return Peaks(*_flip(peaks))
