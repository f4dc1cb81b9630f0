"""The correlation of a template with every position of a search window.

The covariances by the Fourier transform, the variances by running sums, all in double
precision; the few positions where even that is not enough by the definition.
"""

import math
import threading

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pgm_lab import _validate

# A window with this much less energy than all that is summed up with it is doubtful
# even in double precision: of its 16 digits the variance has lost 8
FAINT = 1e-8
CHUNK = 2**16  # grey values that are worked on at a time: what a cache holds
LARGE = 2**15  # grey values of a search window, above which blocks are quicker
BLOCK = 160  # rows and columns of a block

# Work memory of each thread: to fetch it anew in each call would take longer than the
# transforms. Nothing is remembered in it from one call to the next.
_memory = threading.local()


def correlation_map(template: ArrayLike, search: ArrayLike) -> np.ndarray:
    """Correlation of a template with each window of its size in a search window.

    Agrees with (B 2.6f) in exact arithmetic to 1e-6 everywhere, also for 16 bit grey
    values with a large offset and little contrast, for a faint window beside a bright
    pixel, and at the limits of the number types.
    (``cv2.matchTemplate`` with TM_CCOEFF_NORMED can be off by 1 there.) Fifty search
    windows of 51 pixels in one call take 1.0 to 1.3 times as long as with OpenCV, a
    single one about three times (some 65 microseconds more): collect them.

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
    template, search = image(template, "template"), image(search, "search")
    (h, w), (H, W) = size, _ = template.shape[-2:], search.shape[-2:]
    if h > H or w > W:
        raise ValueError(
            f"template {size} is larger than search {(H, W)}, both (rows, columns)."
            " Take a smaller template, or swap the two arguments"
        )
    both = template.ndim == search.ndim == 2
    if both and template.dtype == search.dtype == np.uint8 and search.size <= 2**14:
        r = _from_whole_sums(template, search)
        if r is not None:
            return r
    if np.any(flat(template)):
        raise ValueError(
            "template is flat: all its grey values are equal, and no correlation is"
            " defined. Take a larger template, or one with texture"
        )
    if both:
        return surfaces(template[None], search[None])[0]
    try:
        leading = np.broadcast_shapes(template.shape[:-2], search.shape[:-2])
    except ValueError:
        raise ValueError(
            "the leading axes of template and search do not broadcast; got shapes"
            f" {template.shape} and {search.shape}"
        ) from None
    template = np.broadcast_to(template, (*leading, h, w)).reshape(-1, h, w)
    search = np.broadcast_to(search, (*leading, H, W)).reshape(-1, H, W)
    r = np.empty((len(search), H - h + 1, W - w + 1))
    for part in chunks(len(search), H * W):
        r[part] = surfaces(template[part], search[part])
    return r.reshape(*leading, *r.shape[1:])


def image(values: ArrayLike, name: str) -> np.ndarray:
    """Return `values` as an array (..., rows, columns) of finite grey values."""
    array = _validate.numeric(values, name)
    if array.ndim < 2 or not array.size:
        raise ValueError(
            f"{name} must be an array (rows, columns) of grey values, real numbers; got"
            f" shape {array.shape}, {array.dtype}. For a colour image, take one channel"
            " or the mean of all"
        )
    if array.dtype.itemsize > 8:  # long double: what double cannot hold gets infinite
        with np.errstate(over="ignore"):
            array = array.astype(float)
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise ValueError(
            f"{name} has grey values that are NaN or infinite. Crop or fill them before"
            " the call"
        )
    return array


def flat(windows: np.ndarray) -> np.ndarray:
    """Whether all grey values of a window are equal."""
    grey = windows.reshape(*windows.shape[:-2], -1)
    return grey.max(axis=-1) == grey.min(axis=-1)


def chunks(n: int, size: int) -> list[slice]:
    """Slices of n windows of `size` grey values, to be worked on one after another."""
    at_once = max(1, CHUNK // size)
    return [slice(i, i + at_once) for i in range(0, n, at_once)]


def _from_whole_sums(template: np.ndarray, search: np.ndarray) -> np.ndarray | None:
    """The map of 8 bit grey values from sums in whole numbers; None if in doubt.

    OpenCV transforms in single or in double precision, as the machine has it. No number
    it comes upon is above the product of the two norms, so that up to 2^22 no rounding
    is above 1/8; and as the sums are whole numbers, all roundings together show in
    their fractions. If none is above 1/4, the nearest whole numbers are the sums.
    """
    n, (h, w) = template.size, template.shape
    t, s = (
        np.subtract(g, round(cv2.mean(g)[0]), dtype="f4") for g in (template, search)
    )
    t_squares, t_total = cv2.norm(t, cv2.NORM_L2SQR), cv2.sumElems(t)[0]
    ssd_t = n * t_squares - t_total**2
    if not 0 < ssd_t or t_squares * cv2.norm(s, cv2.NORM_L2SQR) > 2.0**44:
        return None
    products = cv2.matchTemplate(s, t, cv2.TM_CCORR)
    whole = np.rint(products)
    if cv2.norm(products, whole, cv2.NORM_INF) > 1 / 4:
        return None
    running = np.array(cv2.integral2(s, sdepth=cv2.CV_64F, sqdepth=cv2.CV_64F))
    rows = running[:, h:] - running[:, :-h]
    total, squares = rows[:, :, w:] - rows[:, :, :-w]
    r = np.multiply(whole, n, dtype=float)
    r -= t_total * total
    squares *= n
    squares -= total * total
    np.maximum(squares, 1.0, out=squares)  # of flat windows, whose r is 0
    squares *= ssd_t
    r /= np.sqrt(squares, out=squares)
    np.minimum(r, 1.0, out=r)  # where rounding would go beyond by the last digit
    return np.maximum(r, -1.0, out=r)


def surfaces(templates: np.ndarray, searches: np.ndarray) -> np.ndarray:
    """Correlation maps of templates (k, h, w), none flat, in searches (k, H, W)."""
    t = centred(templates)
    t -= _means(t)  # again, since the first mean was rounded
    t /= np.sqrt(np.einsum("kij,kij->k", t, t))[:, None, None]
    if len(t) == 1 or searches[0].size > LARGE:
        r = np.empty((len(t), *np.subtract(searches.shape, templates.shape)[1:] + 1))
        for one in zip(t, searches, r, strict=True):
            _in_blocks(*one)
        return r
    s = centred(searches, _work("grey", searches.shape))
    return _normalized(_covariances(t, s), t, s, searches)


def _in_blocks(t: np.ndarray, search: np.ndarray, r: np.ndarray) -> None:
    """Fill the map r of one template, in blocks so small that a cache holds them.

    The blocks overlap by the template, so that each position lies in one of them.
    """
    h, w = t.shape
    rows, columns = _length(r.shape[0], h), _length(r.shape[1], w)
    spectrum = _spectrum("template", t, (rows + h - 1, columns + w - 1))
    for i in range(0, r.shape[0], rows):
        for j in range(0, r.shape[1], columns):
            block = search[None, i : i + rows + h - 1, j : j + columns + w - 1]
            s = centred(block, _work("grey", block.shape))
            c = _covariance(spectrum, s[0], t.shape)
            part = r[None, i : i + rows, j : j + columns]
            _normalized(c, t[None], s, block, out=part)


def _length(n: int, size: int) -> int:
    """How many of n positions a block takes along one axis, for a template of `size`.

    The transforms of a block cost least per position where it is four templates long
    or, if these are small, 160 grey values.
    """
    return math.ceil(n / math.ceil(n / (max(BLOCK, 4 * size) - size)))


def _normalized(
    r: np.ndarray,
    t: np.ndarray,
    s: np.ndarray,
    searches: np.ndarray,
    out: np.ndarray | None = None,
) -> np.ndarray:
    """Correlations from the covariances r of the centred windows s; r is used up."""
    ssd, energy = _sums_of_squares(s, t.shape[1:])
    # The running sums, and their rounding errors, have grown to the energy of the stack
    faint = ssd <= FAINT * energy
    if faint.any():
        ssd[faint] = np.inf
        r /= np.sqrt(ssd, out=ssd)
        _by_definition(r, faint, t, searches)
    else:
        r /= np.sqrt(ssd, out=ssd)
    np.minimum(r, 1.0, out=r)  # where rounding would go beyond by the last digit
    return np.maximum(r, -1.0, out=out)  # r lies in work memory, the result does not


def _work(name: str, shape: tuple[int, ...]) -> np.ndarray:
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
        mean = _means(g)
        return np.subtract(g, np.rint(mean, out=mean), out=g)
    g[...] = windows
    _scaled(g)
    return np.subtract(g, _means(g), out=g)


def _means(g: np.ndarray) -> np.ndarray:
    return np.add.reduce(g.reshape(len(g), -1), axis=1)[:, None, None] / g[0].size


def _scaled(g: np.ndarray) -> np.ndarray:
    """Scale g in place, by a power of two, to a largest between 1/2 and 1."""
    flattened = g.reshape(len(g), -1)
    largest = np.maximum(flattened.max(axis=1), -flattened.min(axis=1))
    return np.ldexp(g, -np.frexp(largest)[1][:, None, None], out=g)


def _covariances(t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Sums of products of each template with the windows of its search window.

    A window is written as one long row, the template with gaps: the correlation of the
    two rows holds the map, and OpenCV transforms all rows of a stack in one call.
    """
    (k, h, w), (H, W) = t.shape, s.shape[1:]
    rows = _work("rows", (2 * k, cv2.getOptimalDFTSize(H * W)))
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


def _spectrum(name: str, values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Transform of values, padded with zeros to at least `size`."""
    rows, columns = values.shape
    padded = _work(name, tuple(map(cv2.getOptimalDFTSize, size)))
    padded[:rows, :columns] = values
    padded[:rows, columns:] = 0
    padded[rows:] = 0
    return cv2.dft(padded, padded, nonzeroRows=rows)


def _covariance(
    template: np.ndarray, s: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """The same for one block (1, rows, columns), from the spectrum of its template."""
    rows, columns = np.subtract(s.shape, size) + 1
    product = _spectrum("block", s, template.shape)
    cv2.mulSpectrums(product, template, 0, product, conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT
    cv2.dft(product, product, flags=inverse, nonzeroRows=rows)
    return product[None, :rows, :columns]


def _sums_of_squares(s: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, float]:
    """Sum of squares of each window about its mean, and that of all grey values.

    The stack is summed up as one tall image.
    """
    (k, H, W), (h, w) = s.shape, size
    running = _work("sums", (2, k * H + 1, W + 1))
    cv2.integral2(s.reshape(k * H, W), running[0], running[1], cv2.CV_64F, cv2.CV_64F)
    below = running[:, 1:].reshape(2, k, H, W + 1)[:, :, h - 1 :]
    above = running[:, :-1].reshape(2, k, H, W + 1)[:, :, : H - h + 1]
    rows = np.subtract(below, above, out=_work("strips", below.shape))
    windows = _work("windows", (2, k, H - h + 1, W - w + 1))
    total, squares = np.subtract(rows[..., w:], rows[..., :-w], out=windows)
    total *= total
    total /= h * w
    return np.subtract(squares, total, out=squares), running[1, -1, -1]


def _by_definition(
    r: np.ndarray, faint: np.ndarray, t: np.ndarray, searches: np.ndarray
) -> None:
    """Put into r, where faint, the correlation by definition; 0 for flat windows.

    Uses the original grey values: faint windows lose their digits when centred.
    """
    h, w = t.shape[1:]
    touched = np.flatnonzero(faint.any(axis=(1, 2)))
    uneven = ~_flat_at(searches[touched], h, w)
    which, row, column = np.nonzero(faint[touched] & uneven)
    which = touched[which]
    every = sliding_window_view(searches, (h, w), axis=(1, 2))
    for part in chunks(len(which), h * w):
        k, i, j = which[part], row[part], column[part]
        window = centred(every[k, i, j])
        window -= _means(window)
        norm = np.sqrt(np.sum(window * window, axis=(1, 2)))
        r[k, i, j] = np.sum(t[k] * window, axis=(1, 2)) / norm


def _flat_at(searches: np.ndarray, h: int, w: int) -> np.ndarray:
    """Whether the window at each position is flat: no grey value unlike the next."""
    across = searches[:, :, 1:] != searches[:, :, :-1]
    down = searches[:, 1:] != searches[:, :-1]
    return (_counts(across, h, w - 1) == 0) & (_counts(down, h - 1, w) == 0)


def _counts(mask: np.ndarray, h: int, w: int) -> np.ndarray:
    """How many are True in each window of h x w."""
    n = np.pad(mask.cumsum(axis=1).cumsum(axis=2), ((0, 0), (1, 0), (1, 0)))
    n = n[:, h:] - n[:, : n.shape[1] - h]
    return n[:, :, w:] - n[:, :, : n.shape[2] - w]
