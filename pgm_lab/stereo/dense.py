"""Dense matching along epipolar lines, from coarse to fine."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from pgm_lab.stereo.normal import NormalPair

# What a cell of `DenseMatch.status` means, by its number
STATUSES = (
    "matched",
    "no image",
    "no texture",
    "below the threshold",
    "at the end of the search",
    "left and right disagree",
)


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
    bad = np.isnan(pair.left) | np.isnan(pair.right)
    L, R = (np.nan_to_num(a, nan=float(np.nanmean(a))) for a in (pair.left, pair.right))
    levels = min(levels, int(np.log2(min(L.shape) / 40)) + 1)
    d, r, agree, inside = _coarse_to_fine(L, R, levels, window, search)
    if refine:
        d, sd = _refine(L, R, d, window + 2)
    else:
        sd = np.full_like(d, 0.3)
    status = np.zeros(L.shape, np.uint8)
    for number, where in (
        (5, ~agree),
        (4, ~inside),
        (3, r < threshold),
        (1, bad),
    ):
        status[where] = number
    d = np.where(status == 0, d, np.nan).astype(np.float32)
    return DenseMatch(d, r.astype(np.float32), sd.astype(np.float32), status)


def _box(a, n):
    return cv2.boxFilter(a, cv2.CV_32F, (n, n), borderType=cv2.BORDER_REFLECT)


def _correlate(L, R, d, n, reach):
    rows, cols = L.shape
    X, Y = np.meshgrid(
        np.arange(cols, dtype=np.float32), np.arange(rows, dtype=np.float32)
    )
    mL = _box(L, n)
    vL = np.maximum(_box(L * L, n) - mL**2, 1e-3)
    out = []
    for o in range(-reach, reach + 1):
        W = cv2.remap(R, X - d - o, Y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        mW = _box(W, n)
        vW = np.maximum(_box(W * W, n) - mW**2, 1e-3)
        out.append((_box(L * W, n) - mL * mW) / np.sqrt(vL * vW))
    return np.stack(out)


def _level(L, R, d, n, reach):
    r = _correlate(L, R, d, n, reach)
    k = r.argmax(0)
    kk = np.clip(k, 1, 2 * reach - 1)
    m, t, p = (np.take_along_axis(r, (kk + i)[None], 0)[0] for i in (-1, 0, 1))
    s = 0.5 * (m - p) / np.minimum(m - 2 * t + p, -1e-6)
    s = (kk - reach + np.clip(s, -1, 1)).astype(np.float32)
    top = np.take_along_axis(r, k[None], 0)[0]
    return d + s, top, (k > 0) & (k < 2 * reach)


def _fill(d, good, n=9):
    w = good.astype(np.float32)
    s = cv2.boxFilter(d * w, cv2.CV_32F, (n, n), normalize=False)
    c = cv2.boxFilter(w, cv2.CV_32F, (n, n), normalize=False)
    near = np.where(c > 0, s / np.maximum(c, 1), cv2.medianBlur(d, 5))
    return np.where(good, d, near).astype(np.float32)


def _coarse_to_fine(L, R, levels, n, search, reach=3):
    pL, pR = [L], [R]
    for _ in range(levels - 1):
        pL.append(cv2.pyrDown(pL[-1]))
        pR.append(cv2.pyrDown(pR[-1]))
    dl, dr = np.zeros_like(pL[-1]), np.zeros_like(pL[-1])

    def flip(a):
        return np.ascontiguousarray(a[:, ::-1])

    def up(d, shape):
        d = cv2.medianBlur(d.astype(np.float32), 5)
        return 2 * cv2.resize(d, shape[::-1], interpolation=cv2.INTER_LINEAR)

    for k in range(levels - 1, -1, -1):
        if k < levels - 1:
            dl, dr = up(dl, pL[k].shape), up(dr, pL[k].shape)
        q = search if k == levels - 1 else reach
        dl, rl, il = _level(pL[k], pR[k], dl, n, q)
        dr, rr, ir = _level(flip(pR[k]), flip(pL[k]), flip(dr), n, q)
        dl, dr = dl.astype(np.float32), flip(dr).astype(np.float32)
        if k:
            dl = _fill(dl, (rl > 0.6) & il)
            dr = _fill(dr, (flip(rr) > 0.6) & flip(ir))
    rows, cols = L.shape
    X, Y = np.meshgrid(
        np.arange(cols, dtype=np.float32), np.arange(rows, dtype=np.float32)
    )
    back = cv2.remap(
        dr, X - dl, Y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=1e6
    )
    return dl, rl, np.abs(dl - back) < 1, il


def _refine(L, R, d, n, steps=3):
    """Least squares matching in x with gain and offset, windows warped by d."""
    X, Y = np.meshgrid(
        np.arange(L.shape[1], dtype=np.float32), np.arange(L.shape[0], dtype=np.float32)
    )
    D = cv2.GaussianBlur(cv2.medianBlur(d, 5), (0, 0), 2.0)

    def b(a):
        return _box(a, n)

    for _ in range(steps):
        W = cv2.remap(R, X - D, Y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
        g = cv2.Sobel(W, cv2.CV_32F, 1, 0, ksize=1) / 2
        mL, mW, mg = b(L), b(W), b(g)
        cww, cgg, cwg = b(W * W) - mW**2, b(g * g) - mg**2, b(W * g) - mW * mg
        clw, clg, cll = b(L * W) - mL * mW, b(L * g) - mL * mg, b(L * L) - mL**2
        det = np.maximum(cww * cgg - cwg**2, 1e-6)
        h = (clw * cgg - clg * cwg) / det
        k = (clg * cww - clw * cwg) / det
        D = D + np.clip(-k / np.maximum(h, 0.2), -1, 1)
    rss = np.maximum(cll - h * clw - k * clg, 0) * n * n
    sd = np.sqrt(rss / (n * n - 3) * cww / det / (n * n)) / np.maximum(h, 0.2)
    return D, sd
