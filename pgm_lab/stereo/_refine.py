"""Least squares matching of all cells at once, in windows shaped by the terrain."""

from typing import NamedTuple

import cv2
import numpy as np

from pgm_lab.stereo._boxes import WHOLE, Image, box, in_bands, rounded, warped
from pgm_lab.stereo._planes import on_planes
from pgm_lab.stereo._pyramid import filled

STEPS = 3
WIDER = 4  # px: planes reach further than windows, and so are quieter
FARTHEST = 1.0  # px from the start
STILL = 0.3  # px: after a longer last step a window has not come to rest
FLAT = 1e-6  # of the image's variance; less is rounding
LAGS = ((0, 1), (0, 2), (1, 0), (1, 1), (1, -1))  # rows and columns
AROUND = 4  # windows: the neighbourhood in which correlation of residuals is measured


class Refined(NamedTuple):
    """Result of `refine`.

    d, sd: disparities and their standard deviations in px; rested: whether the steps
    came to rest, and near the start; whole: whether the window is image everywhere.
    """

    d: np.ndarray
    sd: np.ndarray
    rested: np.ndarray
    whole: np.ndarray


class Sums(NamedTuple):
    """Solution of the normal equations of all windows.

    step: in px; variance: of the step, if residuals were independent; slope, residual:
    of each pixel, the slope without what offset and gain explain.
    """

    step: np.ndarray
    variance: np.ndarray
    slope: np.ndarray
    residual: np.ndarray


def refine(
    left: Image, right: Image, d: np.ndarray, good: np.ndarray, window: int
) -> Refined:
    """Disparities by least squares: shift, gain and offset of each window.

    The right image is warped by the disparities on their local planes, so that a window
    on a slope has the shape it has in the left image. Good cells make the planes; the
    others take the disparities of their neighbours.
    """
    # gradients reach one pixel to each side, the interpolation four
    solid = cv2.erode(right.mask, np.ones((1, 9)), borderValue=0)
    here = cv2.erode(left.mask, np.ones((1, 3)), borderValue=0)

    start = filled(d, good)

    def work(rows: slice) -> Refined:
        at = start[rows]
        for _ in range(STEPS):
            shape = rounded(on_planes(at, good[rows], window + WIDER))
            W = warped(right.grey, shape, rows.start, cv2.INTER_LANCZOS4)
            sums = normal_equations(left.grey[rows], W, window)
            at = shape + sums.step
        both = here[rows] * (warped(solid, shape, rows.start) > WHOLE)
        more = inflation(sums, good[rows], window)
        rested = (np.abs(at - start[rows]) < FARTHEST) & (np.abs(sums.step) < STILL)
        return Refined(
            at, np.sqrt(sums.variance * more), rested, box(both, window) > WHOLE
        )

    margin = STEPS * (window + 2) + AROUND * window // 2 + 1
    return Refined(*in_bands(work, len(d), margin))


def normal_equations(L: np.ndarray, W: np.ndarray, window: int) -> Sums:
    """Solve L = offset + h W + k dW/dx in all windows; the step is -k / h.

    The sums of the normal equations are box filters, and moments about the means have
    eliminated the offset. The gradient is the mean of both images': that of one alone
    is too large by its noise.
    """
    g = cv2.Sobel(L + W, cv2.CV_32F, 1, 0, ksize=1, scale=0.25)
    mL, mW, mg = (box(a, window) for a in (L, W, g))
    ww, gg = box(W * W, window) - mW * mW, box(g * g, window) - mg * mg
    wg, ll = box(W * g, window) - mW * mg, box(L * L, window) - mL * mL
    lw, lg = box(L * W, window) - mL * mW, box(L * g, window) - mL * mg
    ww, gg = np.maximum(ww, FLAT), np.maximum(gg, FLAT)
    det = np.maximum(ww * gg - wg * wg, FLAT**2)
    h, k = (lw * gg - lg * wg) / det, (lg * ww - lw * wg) / det
    n = window * window
    variance = np.maximum(ll - h * lw - k * lg, 0) / (n - 3) * ww / det
    alone = g - mg - wg / ww * (W - mW)
    residual = L - mL - h * (W - mW) - k * (g - mg)
    h = np.maximum(h, 0.2)
    return Sums(np.clip(-k / h, -1, 1), variance / h**2, alone, residual)


def inflation(sums: Sums, good: np.ndarray, window: int) -> np.ndarray:
    """Factor of the variance for residuals that are correlated with their neighbours.

    Interpolation makes them so. The variance of sum g e is the sum of all covariances,
    sigma^2 sum rho_e rho_g: for near neighbours both correlations are measured in the
    neighbourhood. A fit of three unknowns to n residuals takes about 3/n from each.
    """
    g, e = (np.where(good, a, 0).astype(np.float32) for a in sums[2:])
    around = AROUND * window + 1
    gg, ee = (np.maximum(box(a * a, around), FLAT) for a in (g, e))
    factor = np.ones_like(gg)
    for lag in LAGS:
        rho_g, rho_e = (
            box(a * _neighbour(a, lag), around) / aa for a, aa in ((g, gg), (e, ee))
        )
        factor += 2 * rho_g * (rho_e + (2 + rho_g) / window**2)
    return np.maximum(factor, 0.5)


def _neighbour(a: np.ndarray, lag: tuple[int, int]) -> np.ndarray:
    """Value some rows and columns further; zero outside."""
    rows, columns = a.shape
    row, column = 2 + lag[0], 2 + lag[1]
    return np.pad(a, 2)[row : row + rows, column : column + columns]
