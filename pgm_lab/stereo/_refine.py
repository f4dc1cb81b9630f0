"""Least squares matching of all cells at once, in windows shaped by the terrain."""

from typing import NamedTuple

import cv2
import numpy as np

from pgm_lab.stereo._boxes import WHOLE, box, in_bands, warped
from pgm_lab.stereo._planes import on_planes

STEPS = 3
FLAT = 1e-3  # grey values squared; less variance is rounding
FARTHEST = 1.0  # px from the start
STILL = 0.3  # px: a last step beyond it has not come to rest


class Refined(NamedTuple):
    """d, sd in px; rested: whether the steps came to rest near the start; whole: ..."""

    d: np.ndarray
    sd: np.ndarray
    rested: np.ndarray
    whole: np.ndarray


def refine(left, right, d, good, window: int) -> Refined:
    """Disparities by least squares: shift, gain and offset of each window.

    The right image is warped by the disparities on their local planes, so that a window
    on a slope has the shape it has in the left image. Good cells make the planes.
    """
    # gradients and cubic interpolation reach two pixels to each side
    solid = cv2.erode(right[1], np.ones((5, 5)), borderValue=0)
    here = cv2.erode(left[1], np.ones((3, 3)), borderValue=0)

    def work(rows):
        start = d[rows]
        at = start
        for _ in range(STEPS):
            shape, rough = on_planes(at, good[rows], window)
            W = warped(right[0], shape, rows.start, cv2.INTER_CUBIC)
            step, variance = normal_equations(left[0][rows], W, window)
            at = shape + step
        known = here[rows] * (
            warped(solid, shape, rows.start, cv2.INTER_LINEAR) > WHOLE
        )
        rested = (np.abs(at - start) < FARTHEST) & (np.abs(step) < STILL)
        return at, np.sqrt(variance), rested, box(known, window) > WHOLE

    return Refined(*in_bands(work, len(d), STEPS * (window + 2)))


def normal_equations(L, W, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Step and its variance of L = offset + h W + k dW/dx in all windows; step = -k/h.

    The sums of the normal equations are those of box filters; the offset is eliminated
    by moments about the means.
    """
    g = cv2.Sobel(W, cv2.CV_32F, 1, 0, ksize=1) + cv2.Sobel(
        L, cv2.CV_32F, 1, 0, ksize=1
    )
    g /= 4

    mL, mW, mg = (box(a, window) for a in (L, W, g))

    def moment(a, b, ma, mb):
        return box(a * b, window) - ma * mb

    ww, gg, wg = moment(W, W, mW, mW), moment(g, g, mg, mg), moment(W, g, mW, mg)
    lw, lg, ll = moment(L, W, mL, mW), moment(L, g, mL, mg), moment(L, L, mL, mL)
    ww, gg = np.maximum(ww, FLAT), np.maximum(gg, FLAT)
    det = np.maximum(ww * gg - wg * wg, FLAT**2)
    h, k = (lw * gg - lg * wg) / det, (lg * ww - lw * wg) / det
    n = window * window
    sigma2 = np.maximum(ll - h * lw - k * lg, 0) * n / (n - 3)
    h = np.maximum(h, 0.2)
    return np.clip(-k / h, -1, 1), sigma2 * ww / det / n / h**2
