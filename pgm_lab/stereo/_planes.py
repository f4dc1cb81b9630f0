"""Local planes of disparity: the shape of the ground under a window."""

import cv2
import numpy as np

ROUGH = 0.3  # px about its plane: more than noise, so an edge or a crest
ENOUGH = 0.3  # share of a window that must be good


def on_planes(d: np.ndarray, good: np.ndarray, window: int) -> np.ndarray:
    """Disparities on the planes through the good cells of their windows.

    Where cells scatter about their plane by more than `ROUGH`, or few are good, the
    median of 5 x 5 stays instead.
    """
    level = float(d[good].mean()) if good.any() else 0.0
    w = good.astype(np.float32)
    v = np.where(good, d - np.float32(level), 0).astype(np.float32)
    n = np.maximum(_moment(w, window, 0, 0), 1)
    x, y, xx, yy, xy = (
        _moment(w, window, *p) / n for p in ((1, 0), (0, 1), (2, 0), (0, 2), (1, 1))
    )
    m, xv, yv = (_moment(v, window, *p) / n for p in ((0, 0), (1, 0), (0, 1)))
    vv = _moment(v * v, window, 0, 0) / n - m * m
    xx, yy, xy, xv, yv = xx - x * x, yy - y * y, xy - x * y, xv - x * m, yv - y * m
    det = np.maximum(xx * yy - xy * xy, 1e-3)
    a, b = (xv * yy - yv * xy) / det, (yv * xx - xv * xy) / det
    rough = np.maximum(vv - a * xv - b * yv, 0)
    own = np.clip(rough / ROUGH**2 - 1, 0, 1)
    own[n < ENOUGH * window**2] = 1
    plane = m - a * x - b * y + level
    return own * cv2.medianBlur(d, 5) + (1 - own) * plane


def _moment(a, window, p, q):
    """Sum of a x^p y^q over windows, x and y from the middle of each."""
    k = np.arange(window, dtype=np.float32) - window // 2
    return cv2.sepFilter2D(a, cv2.CV_32F, k**p, k**q, borderType=cv2.BORDER_CONSTANT)
