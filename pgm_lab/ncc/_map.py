"""The correlation of a template with every position of a search window.

Products come from the Fourier transform, sums from running sums, in double precision;
for windows too faint for that, r is computed from its definition.
"""

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.lib.stride_tricks import as_strided, sliding_window_view
from numpy.typing import ArrayLike

from pgm_lab import _validate

# A window with so much less energy than everything summed with it has lost 8 of the 16
# digits of its variance
FAINT = 1e-8
CHUNK = 2**17  # grey values transformed at a time: what a cache holds
MAX_WHOLE = 2**15  # grey values: a larger search window is searched tile by tile
TILE = 160  # px: rows and columns of a tile, or four templates


def correlation_map(template: ArrayLike, search: ArrayLike) -> np.ndarray:
    """Correlation of a template with each window of its size in a search window.

    Agrees to 1e-6 with (B 2.6f) in exact arithmetic everywhere, also for a faint window
    beside a bright pixel, where ``cv2.matchTemplate`` can be off by 1. Many small maps
    are computed faster in one call.

    Parameters
    ----------
    template : array_like (..., h, w)
        Grey values to look for; 8 or 16 bit or float.
    search : array_like (..., H, W)
        Grey values to look in, at least as large; leading axes broadcast.

    Returns
    -------
    ndarray (..., H - h + 1, W - w + 1)
        r between -1 and 1; element [i, j] belongs to the window whose top left pixel is
        search[i, j]. A flat window (all its grey values equal) has no correlation; it
        gets r = 0, "nothing in common".

    Raises
    ------
    ValueError
        If a template is flat or larger than the search window, an array is not an
        image, or a grey value is not finite.

    References
    ----------
    Bani 2010, (B 2.6f); Lewis 1995, Fast normalized cross-correlation.

    Examples
    --------
    >>> search = np.random.default_rng(1).integers(0, 256, (51, 51))
    >>> r = correlation_map(search[10:31, 12:33], search)
    >>> row, column = np.unravel_index(r.argmax(), r.shape)
    >>> print(r.shape, row, column)
    (31, 31) 10 12
    """
    template = _grey_values(template, "template")
    search = _grey_values(search, "search")
    (h, w), (H, W) = template.shape[-2:], search.shape[-2:]
    if h > H or w > W:
        raise ValueError(
            f"template {(h, w)} is larger than search {(H, W)}, both (rows, columns)."
            " Take a smaller template, or swap the two arguments"
        )
    if template.ndim == search.ndim == 2 and template.dtype == search.dtype == np.uint8:
        r = _from_whole_sums(template, search)
        if r is not None:
            return r
    if np.any(flat(template)):
        raise ValueError(
            "template is flat: all its grey values are equal, and no correlation is"
            " defined. Take a larger template, or one with texture"
        )
    try:
        leading = np.broadcast_shapes(template.shape[:-2], search.shape[:-2])
    except ValueError:
        raise ValueError(
            "the leading axes of template and search do not broadcast; got shapes"
            f" {template.shape} and {search.shape}"
        ) from None
    template = np.broadcast_to(template, (*leading, h, w)).reshape(-1, h, w)
    search = np.broadcast_to(search, (*leading, H, W)).reshape(-1, H, W)
    return exact_maps(template, search).reshape(*leading, H - h + 1, W - w + 1)


def _grey_values(values: ArrayLike, name: str) -> np.ndarray:
    """An array (..., rows, columns) of finite grey values."""
    array = _validate.numeric(values, name)
    if array.ndim < 2 or not array.size:
        raise ValueError(
            f"{name} must be an array (rows, columns) of grey values, real numbers; got"
            f" shape {array.shape}, {array.dtype}. For a colour image, take one channel"
            " or the mean of all"
        )
    if array.dtype.itemsize > 8:  # long double: too large for double becomes infinite
        with np.errstate(over="ignore"):
            array = array.astype(float)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise ValueError(
            f"{name} has grey values that are NaN or infinite. Crop or fill them before"
            " the call"
        )
    return array


def _from_whole_sums(template: np.ndarray, search: np.ndarray) -> np.ndarray | None:
    """Map of 8 bit grey values from exact sums of integers; None if in doubt."""
    # No number in OpenCV's computation exceeds the product of the two norms: up to 2^22
    # no rounding error exceeds 1/8, and since the sums are integers, all rounding
    # errors together show in their fractions.
    n, (h, w) = template.size, template.shape
    t, s = template.astype(np.float32), search.astype(np.float32)
    t -= round(cv2.mean(template)[0])
    s -= round(cv2.mean(search)[0])
    t_total, t_squares = cv2.sumElems(t)[0], cv2.norm(t, cv2.NORM_L2SQR)
    t_ssd = n * t_squares - t_total**2
    if t_ssd == 0 or t_squares * cv2.norm(s, cv2.NORM_L2SQR) > 2.0**44:
        return None
    products = cv2.matchTemplate(s, t, cv2.TM_CCORR)
    whole = np.rint(products)
    if cv2.norm(products, whole, cv2.NORM_INF) > 1 / 4:
        return None
    sums = cv2.integral2(s, sdepth=cv2.CV_64F, sqdepth=cv2.CV_64F)
    total, squares = (_differences(running, 1, h, w)[0] for running in sums)
    ssd = np.maximum(n * squares - total * total, 1.0)  # 1 for flat windows: r is 0
    ssd *= t_ssd * (1 + 1e-15)  # so that no rounding takes r beyond 1
    return (n * whole.astype(float) - t_total * total) / np.sqrt(ssd)


def exact_maps(templates: np.ndarray, searches: np.ndarray) -> np.ndarray:
    """Correlation maps of templates (k, h, w), none flat, in searches (k, H, W)."""
    (k, h, w), (H, W) = templates.shape, searches.shape[1:]
    rows, columns = H - h + 1, W - w + 1
    high, wide = rows, columns
    if H * W > MAX_WHOLE:
        high, wide = (
            math.ceil(n / max(1, round(n / (max(TILE, 4 * size) - size))))
            for n, size in ((rows, h), (columns, w))
        )
    t = unit(templates)
    r = np.empty((k, rows, columns))
    for part in chunks(k, H * W):
        for i in range(0, rows, high):
            for j in range(0, columns, wide):
                tile = searches[part, i : i + high + h - 1, j : j + wide + w - 1]
                r[part, i : i + high, j : j + wide] = _maps(t[part], tile)
    return r


def _maps(t: np.ndarray, searches: np.ndarray) -> np.ndarray:
    """Maps of unit templates in search windows, in double precision."""
    (k, h, w), (H, W) = t.shape, searches.shape[1:]
    s = centred(searches, whole=True)
    r = products(t, s) if k > 1 else _product(t[0], s[0])[None]
    sums = cv2.integral2(s.reshape(k * H, W), sdepth=cv2.CV_64F, sqdepth=cv2.CV_64F)
    energy = sums[1][-1, -1]  # the running sums reach it, and it sets their rounding
    total, ssd = (_differences(running, k, h, w) for running in sums)
    total *= total
    total /= h * w
    ssd -= total
    faint = ssd <= FAINT * energy
    ssd[faint] = np.inf
    r = r / np.sqrt(ssd, out=ssd)
    if faint.any():
        _by_definition(r, faint, t, searches)
    return np.clip(r, -1, 1, out=r)  # rounding can exceed 1 in the last digit


def products(t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Sums of products of each template with the windows of its search window."""
    # A search window is written as one long row, its template with gaps: the
    # correlation of both rows contains the map, and OpenCV transforms all in one call
    (k, h, w), (H, W) = t.shape, s.shape[1:]
    rows = np.zeros((2 * k, cv2.getOptimalDFTSize(H * W)), s.dtype)
    rows[:k, : H * W] = s.reshape(k, -1)
    rows[k:, : h * W].reshape(k, h, W)[:, :, :w] = t
    cv2.dft(rows, rows, flags=cv2.DFT_ROWS)
    cv2.mulSpectrums(rows[:k], rows[k:], cv2.DFT_ROWS, rows[:k], conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_ROWS
    cv2.dft(rows[:k], rows[:k], flags=inverse)
    found = rows[:k, : (H - h + 1) * W].reshape(k, H - h + 1, W)
    return found[:, :, : W - w + 1]


def _product(t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """The same for one search window, transformed along both axes."""
    (h, w), (H, W) = t.shape, s.shape
    # At least two columns: OpenCV 5 cannot transform a single one
    size = cv2.getOptimalDFTSize(H), cv2.getOptimalDFTSize(max(W, 2))
    a, b = np.zeros((2, *size), s.dtype)
    a[:H, :W], b[:h, :w] = s, t
    cv2.dft(a, a, nonzeroRows=H)
    cv2.dft(b, b, nonzeroRows=h)
    cv2.mulSpectrums(a, b, 0, a, conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT
    cv2.dft(a, a, flags=inverse, nonzeroRows=H - h + 1)
    return a[: H - h + 1, : W - w + 1]


def _differences(running: np.ndarray, k: int, h: int, w: int) -> np.ndarray:
    """Sums over all windows of h x w from the running sums of k images, stacked."""
    W = running.shape[1]
    below, above = (part.reshape(k, -1, W) for part in (running[1:], running[:-1]))
    rows = below[:, h - 1 :] - above[:, : below.shape[1] - h + 1]
    return rows[..., w:] - rows[..., :-w]


def _by_definition(
    r: np.ndarray, faint: np.ndarray, t: np.ndarray, searches: np.ndarray
) -> None:
    """Put into r, where faint, the correlation by definition; 0 for flat windows."""
    # From the original grey values: faint windows lose their digits when centred
    r[faint] = 0
    h, w = t.shape[1:]
    every = sliding_window_view(searches, (h, w), axis=(1, 2))
    k, i, j = np.nonzero(faint)
    for part in chunks(len(k), h * w):
        at = k[part], i[part], j[part]
        windows = every[at]
        uneven = ~flat(windows)
        at = tuple(index[uneven] for index in at)
        r[at] = np.sum(t[at[0]] * unit(windows[uneven]), axis=(1, 2))


def few(t: np.ndarray, p: np.ndarray, patches: np.ndarray) -> np.ndarray:
    """Exact correlations of centred templates t with the few windows of patches."""
    # `p` are the centred patches. A window is a piece of its patch written as one row,
    # the template a row with gaps.
    (k, h, w), (H, W) = t.shape, p.shape[1:]
    rows = np.zeros((k, h, W))
    rows[:, :, :w] = t
    length = h * W - (W - w)
    strides = *p.strides, p.strides[2]
    pieces = as_strided(p, (k, H - h + 1, W - w + 1, length), strides)
    r = np.vecdot(pieces, rows.reshape(k, 1, 1, h * W)[..., :length])
    total, squares = box_sums(p, h, w), box_sums(p * p, h, w)
    total /= np.sqrt(h * w)
    ssd = squares - total * total
    faint = ssd <= 1e-3 * squares.max(axis=(1, 2), keepdims=True)
    ssd[faint] = np.inf
    # The subtracted means were rounded: the remaining mean of t matters
    left = np.add.reduce(t.reshape(k, h * w), axis=1)[:, None, None] / np.sqrt(h * w)
    r -= left * total
    t_ssd = inner(t, t)[:, None, None] - left**2
    r /= np.sqrt(ssd * t_ssd)
    if faint.any():
        some = np.flatnonzero(faint.any(axis=(1, 2)))
        exact = r[some]
        _by_definition(exact, faint[some], unit(t[some]), patches[some])
        r[some] = exact
    return np.clip(r, -1, 1, out=r)


def box_sums(g: np.ndarray, h: int, w: int) -> np.ndarray:
    """Sums over all windows of h x w of images (k, H, W)."""
    k, H, W = g.shape
    rows = g.reshape(k * H, W) @ _band(W, w, g.dtype).T
    return _band(H, h, g.dtype) @ rows.reshape(k, H, W - w + 1)


@lru_cache(maxsize=32)
def _band(n: int, size: int, dtype: np.dtype) -> np.ndarray:
    """Which of n pixels are in each run of `size`: ones and zeros (runs, n)."""
    runs = n - size + 1
    return np.tri(runs, n, size - 1, dtype) - np.tri(runs, n, -1, dtype)


# --- Windows ---


def chunks(n: int, size: int) -> list[slice]:
    """Slices of n windows of `size` grey values, to be processed one after another."""
    at_once = max(1, CHUNK // size)
    return [slice(i, i + at_once) for i in range(0, n, at_once)]


def flat(windows: np.ndarray) -> np.ndarray:
    """Whether all grey values of a window are equal."""
    grey = windows.reshape(*windows.shape[:-2], -1)
    return grey.max(axis=-1) == grey.min(axis=-1)


def centred(
    windows: np.ndarray, exponent: np.ndarray | None = None, *, whole: bool = False
) -> np.ndarray:
    """Windows (k, h, w) minus their means; minus integers if sums are to be exact."""
    # Real numbers are divided by a power of two, so that no square over- or underflows
    k, h, w = windows.shape
    if windows.dtype.kind in "ui" and windows.dtype.itemsize == 8:
        # More digits than double precision has: the difference modulo 2^64 keeps all
        lowest = windows.min(axis=(1, 2), keepdims=True)
        windows = windows.astype(np.uint64) - lowest.astype(np.uint64)
    rows = windows.reshape(k, h * w).astype(float)
    if windows.dtype.kind == "f":
        exponent = exponents(windows) if exponent is None else exponent
        np.ldexp(rows, -exponent[:, None], out=rows)
    mean = np.add.reduce(rows, axis=1) / (h * w)
    if whole and windows.dtype.kind != "f":
        mean = np.rint(mean)
    rows -= mean[:, None]
    return rows.reshape(k, h, w)


def exponents(windows: np.ndarray) -> np.ndarray:
    """Powers of two above all grey values of each window."""
    return np.frexp(np.abs(windows).max(axis=(1, 2)))[1]


def inner(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Sums (k,) of the products of two stacks of windows (k, h, w)."""
    k, h, w = a.shape
    return np.vecdot(a.reshape(k, h * w), b.reshape(k, h * w))


def unit(windows: np.ndarray) -> np.ndarray:
    """Windows (k, h, w), none flat, minus their means and divided by their norms."""
    g = centred(windows)
    g -= g.mean(axis=(1, 2), keepdims=True)  # again, since the first mean was rounded
    g /= np.sqrt(inner(g, g))[:, None, None]
    return g
