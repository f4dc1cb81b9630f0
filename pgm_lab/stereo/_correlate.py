"""Normalised cross-correlation along the rows, around a disparity known before."""

from typing import NamedTuple

import numpy as np

from pgm_lab.stereo._boxes import WHOLE, Image, box, in_bands, rounded, warped

FLAT = 1e-6  # of the image's variance; less is rounding


class Peaks(NamedTuple):
    """Where the correlation is highest.

    d: disparity in px; r: correlation coefficient, -1 where no window has enough image;
    sd: of the disparity, from the peak; inside: not at an end of the search.
    """

    d: np.ndarray
    r: np.ndarray
    sd: np.ndarray
    inside: np.ndarray


def search(
    left: Image, right: Image, start: np.ndarray, window: int, reach: int, least: float
) -> Peaks:
    """Disparity of the highest correlation among start - reach ... start + reach.

    least: share of a window that must be image in both. Three values
    around the peak give its place to parts of a pixel.
    """

    def work(rows: slice) -> Peaks:
        some = Image(left.grey[rows], left.mask[rows])
        return _band(some, right, start[rows], rows.start, window, reach, least)

    return Peaks(*in_bands(work, len(start), window // 2))


def _band(left, right, start, row, window, reach, least):
    start = rounded(start)
    best, before, after, last = (np.full(start.shape, -1, np.float32) for _ in range(4))
    at = np.zeros(start.shape, np.float32)
    for offset in range(-reach, reach + 1):
        r = _correlation(left, right, start + offset, row, window, least)
        np.copyto(after, r, where=at == offset - 1)
        higher = r > best
        np.copyto(before, last, where=higher)
        np.copyto(best, r, where=higher)
        np.copyto(after, -1, where=higher)
        at[higher] = offset
        last = r
    inside = (np.abs(at) < reach) & (before > -1) & (after > -1)
    bend = np.maximum(2 * best - before - after, 1e-6)
    part = np.where(inside, (after - before) / (2 * bend), 0)
    # sd^2 = sigma^2 / sum g^2, with 1 - r^2 = sigma^2 / var and bend = mean g^2 / var
    sd = np.sqrt(np.maximum(1 - best**2, 0) / bend) / window
    return start + at + np.clip(part, -0.5, 0.5), best, sd, inside


def _correlation(
    left: Image, right: Image, d: np.ndarray, row: int, window: int, least: float
) -> np.ndarray:
    """Coefficient of each window of the left band with the right image warped by d."""
    known = warped(right.mask, d, row) > WHOLE
    W = warped(right.grey, d, row)
    w = left.mask * known
    share = box(w, window)
    # where windows must be whole, masked sums and plain ones are the same
    n: np.ndarray | float = 1.0
    L = left.grey
    if least < 1:
        n = np.maximum(share, 1e-3)
        L, W = L * w, W * w
    mL, mW = box(L, window) / n, box(W, window) / n
    vL = box(L * L, window) / n - mL * mL
    vW = box(W * W, window) / n - mW * mW
    r = (box(L * W, window) / n - mL * mW) / np.sqrt(np.maximum(vL * vW, FLAT**2))
    return np.where(share > least - 1e-4, np.clip(r, -1, 1), np.float32(-1))
