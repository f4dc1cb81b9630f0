"""Dense matching along epipolar lines, from coarse to fine."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab.stereo._boxes import WHOLE, Image, box
from pgm_lab.stereo._levels import coarse_to_fine
from pgm_lab.stereo._pyramid import levels_of
from pgm_lab.stereo._refine import refine as least_squares
from pgm_lab.stereo.normal import NormalPair

# What a cell of `DenseMatch.status` means, by its number
STATUSES = (
    "matched",
    "no image",
    "no texture",
    "below the threshold",
    "at the end of the search",
    "left and right disagree",
    "not at rest",
    "isolated",
)
FLAT = 0.02  # of the grey values' standard deviation: a window with less has no texture
JOINED = 0.5  # px between neighbours of one patch


@dataclass(frozen=True, eq=False)
class DenseMatch:
    """Disparities of a normal pair.

    Attributes
    ----------
    disparity : ndarray (rows, columns) of float32
        Left column minus right column, px; NaN where the status is not "matched".
    r : ndarray (rows, columns) of float32
        Correlation coefficient; NaN where there is none.
    sd : ndarray (rows, columns) of float32
        Predicted standard deviation of the disparity, px.
    status : ndarray (rows, columns) of uint8
        Index into `STATUSES`.
    """

    disparity: np.ndarray = field(repr=False)
    r: np.ndarray = field(repr=False)
    sd: np.ndarray = field(repr=False)
    status: np.ndarray = field(repr=False)

    def counts(self) -> dict[str, int]:
        """How many cells have which status."""
        return {s: int(np.sum(self.status == i)) for i, s in enumerate(STATUSES)}


def match_dense(
    pair: NormalPair, *, window=7, threshold=0.8, levels=6, search=12, refine=True
) -> DenseMatch:
    """Match the two images of a normal pair in every pixel."""
    return match_rows(
        pair.left,
        pair.right,
        window=window,
        threshold=threshold,
        levels=levels,
        search=search,
        refine=refine,
    )


def match_rows(
    left: ArrayLike,
    right: ArrayLike,
    *,
    window: int = 7,
    threshold: float = 0.8,
    levels: int = 6,
    search: int = 12,
    refine: bool = True,
) -> DenseMatch:
    """Match two images whose equal rows show the same, in every pixel."""
    L, R = _image(left), _image(right)
    peaks, agree = coarse_to_fine(L, R, levels_of(L.grey.shape, levels), window, search)
    status = np.zeros(L.grey.shape, np.uint8)
    for number, where in (
        (5, ~agree),
        (4, ~peaks.inside),
        (3, peaks.r < threshold),
        (2, _flat(L, window)),
        (1, (peaks.r == -1) | (box(L.mask, window) < WHOLE)),
    ):
        status[where] = number
    d, sd = peaks.d, peaks.sd
    if refine:
        d, sd, rested, whole = least_squares(L, R, d, status == 0, window + 2)
        status[~rested & (status == 0)] = 6
        status[~whole & (status == 0)] = 1
    status[_isolated(d, status == 0, 2 * window**2)] = 7
    d = np.where(status == 0, d, np.nan).astype(np.float32)
    r = np.where(peaks.r > -1, peaks.r, np.nan).astype(np.float32)
    return DenseMatch(d, r, sd.astype(np.float32), status)


def _image(grey):
    """Grey values about their mean, and a mask: 1 where there is image, else 0."""
    grey = np.asarray(grey, np.float32)
    known = np.isfinite(grey)
    mean = grey[known].mean() if known.any() else 0
    about = np.where(known, grey - mean, 0).astype(np.float32)
    return Image(about, known.astype(np.float32))


def _flat(image, window):
    """Where the windows have hardly any texture."""
    grey, mask = image
    variance = box(grey * grey, window) - box(grey, window) ** 2
    return variance < FLAT**2 * (grey**2).sum() / max(mask.sum(), 1)


def _isolated(d, good, least):
    """Good cells in patches of fewer than `least`; a jump divides patches."""
    steps = 16  # of a pixel, as whole numbers are asked for
    none = -(2**15)
    whole = np.where(good, np.clip(d * steps, none + 1, 2**15 - 1), none)
    whole = np.rint(whole).astype(np.int16)
    cv2.filterSpeckles(whole, none, least - 1, JOINED * steps)
    return good & (whole == none)
