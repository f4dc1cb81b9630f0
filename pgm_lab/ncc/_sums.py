"""Sums over all windows of a search window: of grey values, squares and products.

All in double precision, the products by the Fourier transform.
"""

import math
import threading

import cv2
import numpy as np

CHUNK = 2**16  # grey values that are worked on at a time: what a cache holds

# Work memory of each thread: to fetch it anew in each call would take longer than the
# transforms. Nothing is remembered in it from one call to the next.
_memory = threading.local()


def work(name: str, shape: tuple[int, ...]) -> np.ndarray:
    """Memory, one piece of each name in each thread, that the next call uses again.

    The C library gives large arrays back after each call, and to fetch them page by
    page again takes longer than all the work on them.
    """
    n = math.prod(shape)
    if n > 4 * CHUNK:
        return np.empty(shape)
    piece = getattr(_memory, name, None)
    if piece is None or piece.size < n:
        piece = np.empty(n)
        setattr(_memory, name, piece)
    return piece[:n].reshape(shape)


def centred(windows: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """Windows without their means, in double precision.

    From whole numbers a whole number is taken, so that the sums remain exact; real
    numbers are scaled by powers of two, so that no square over- or underflows.
    """
    g = np.empty(windows.shape) if out is None else out
    if windows.dtype.kind in "ui":
        if windows.dtype.itemsize == 8:  # more digits than double precision holds
            lowest = windows.min(axis=(1, 2), keepdims=True)
            windows = windows.astype(np.uint64) - lowest.astype(np.uint64)  # mod 2^64
        g[...] = windows
        mean = means(g)
        return np.subtract(g, np.rint(mean, out=mean), out=g)
    g[...] = windows
    _scaled(g)
    return np.subtract(g, means(g), out=g)


def means(g: np.ndarray) -> np.ndarray:
    return np.add.reduce(g.reshape(len(g), -1), axis=1)[:, None, None] / g[0].size


def _scaled(g: np.ndarray) -> np.ndarray:
    """Scale g in place, by a power of two, to a largest between 1/2 and 1."""
    flattened = g.reshape(len(g), -1)
    largest = np.maximum(flattened.max(axis=1), -flattened.min(axis=1))
    return np.ldexp(g, -np.frexp(largest)[1][:, None, None], out=g)


def covariances(t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Sums of products of each template with the windows of its search window.

    A window is written as one long row, the template with gaps: the correlation of the
    two rows holds the map, and OpenCV transforms all rows of a stack in one call.
    """
    (k, h, w), (H, W) = t.shape, s.shape[1:]
    rows = work("rows", (2 * k, cv2.getOptimalDFTSize(H * W)))
    rows[:k, : H * W] = s.reshape(k, -1)
    rows[:k, H * W :] = 0
    rows[k:] = 0
    rows[k:, : h * W].reshape(k, h, W)[:, :, :w] = t
    # In place throughout: fresh memory of this size costs more than the transforms
    cv2.dft(rows, rows, flags=cv2.DFT_ROWS)
    cv2.mulSpectrums(rows[:k], rows[k:], cv2.DFT_ROWS, rows[:k], conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_ROWS
    cv2.dft(rows[:k], rows[:k], flags=inverse)
    maps = rows[:k, : (H - h + 1) * W]
    return maps.reshape(k, H - h + 1, W)[:, :, : W - w + 1]


def spectrum(name: str, values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Transform of values, padded with zeros to at least `size`."""
    rows, columns = values.shape
    padded = work(name, tuple(map(cv2.getOptimalDFTSize, size)))
    padded[:rows, :columns] = values
    padded[:rows, columns:] = 0
    padded[rows:] = 0
    return cv2.dft(padded, padded, nonzeroRows=rows)


def covariance(
    template: np.ndarray, s: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """The same for one block (1, rows, columns), from the spectrum of its template."""
    rows, columns = np.subtract(s.shape, size) + 1
    product = spectrum("block", s, template.shape)
    cv2.mulSpectrums(product, template, 0, product, conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT
    cv2.dft(product, product, flags=inverse, nonzeroRows=rows)
    return product[None, :rows, :columns]


def window_sums(s: np.ndarray, h: int, w: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Sum and sum of squares of each window of h x w; sum of squares of all of s.

    The stack is summed up as one tall image.
    """
    k, H, W = s.shape
    running = work("sums", (2, k * H + 1, W + 1))
    cv2.integral2(s.reshape(k * H, W), running[0], running[1], cv2.CV_64F, cv2.CV_64F)
    below = running[:, 1:].reshape(2, k, H, W + 1)[:, :, h - 1 :]
    above = running[:, :-1].reshape(2, k, H, W + 1)[:, :, : H - h + 1]
    rows = np.subtract(below, above, out=work("strips", below.shape))
    windows = work("windows", (2, k, H - h + 1, W - w + 1))
    total, squares = np.subtract(rows[..., w:], rows[..., :-w], out=windows)
    return total, squares, running[1, -1, -1]


def flat_at(searches: np.ndarray, h: int, w: int) -> np.ndarray:
    """Whether the window at each position is flat: no grey value unlike the next."""
    across = searches[:, :, 1:] != searches[:, :, :-1]
    down = searches[:, 1:] != searches[:, :-1]
    return (_counts(across, h, w - 1) == 0) & (_counts(down, h - 1, w) == 0)


def _counts(mask: np.ndarray, h: int, w: int) -> np.ndarray:
    """How many are True in each window of h x w."""
    n = np.pad(mask.cumsum(axis=1).cumsum(axis=2), ((0, 0), (1, 0), (1, 0)))
    n = n[:, h:] - n[:, : n.shape[1] - h]
    return n[:, :, w:] - n[:, :, : n.shape[2] - w]
