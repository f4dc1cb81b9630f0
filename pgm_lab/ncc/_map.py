"""The correlation of a template with every position of a search window.

The covariances by the Fourier transform, the variances by running sums, in double
precision; the few positions where even that is not enough by the definition. Small maps
of 8 bit grey values from sums in whole numbers, which are exact.
"""

import math

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.ncc._sums import (
    CHUNK,
    centred,
    covariance,
    covariances,
    flat_at,
    means,
    spectrum,
    window_sums,
    work,
)

# A window with this much less energy than all that is summed up with it is doubtful
# even in double precision: of its 16 digits the variance has lost 8
FAINT = 1e-8
LARGE = 2**15  # grey values of a search window, above which blocks are quicker
SMALL = 2**14  # up to which whole sums are
BLOCK = 160  # rows and columns of a block
TINY = 2**10  # grey values of a search window, up to which calls cost more than work
AT_ONCE = 256  # such windows at a time


def correlation_map(template: ArrayLike, search: ArrayLike) -> np.ndarray:
    """Correlation of a template with each window of its size in a search window.

    Agrees with (B 2.6f) in exact arithmetic to 1e-6 everywhere, also for 16 bit grey
    values with a large offset and little contrast, for a faint window beside a bright
    pixel, and at the limits of the number types.
    (``cv2.matchTemplate`` with TM_CCOEFF_NORMED can be off by 1 there.) Fifty search
    windows of 51 pixels in one call take 1.0 to 1.3 times as long as with OpenCV. One
    map of 8 bit takes 0.9 to 2.5 times as long, a very small one three times, since the
    calls alone take 40 microseconds: collect small ones.

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
    if both and template.dtype == search.dtype == np.uint8 and search.size <= SMALL:
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
    at_once = max(1, CHUNK // size, AT_ONCE if size <= TINY else 0)
    return [slice(i, i + at_once) for i in range(0, n, at_once)]


def _from_whole_sums(template: np.ndarray, search: np.ndarray) -> np.ndarray | None:
    """The map of 8 bit grey values from sums in whole numbers; None if in doubt.

    OpenCV transforms in single or in double precision, as the machine has it. No number
    it comes upon is above the product of the two norms, so that up to 2^22 no rounding
    is above 1/8; and as the sums are whole numbers, all roundings together show in
    their fractions. If none is above 1/4, the nearest whole numbers are the sums.
    """
    n, (h, w) = template.size, template.shape
    t, s = template.astype(np.float32), search.astype(np.float32)
    t -= round(cv2.mean(template)[0])
    s -= round(cv2.mean(search)[0])
    t_total, t_squares = cv2.sumElems(t)[0], cv2.norm(t, cv2.NORM_L2SQR)
    total, squares, s_squares = window_sums(s[None], h, w)
    ssd_t = n * t_squares - t_total**2
    if ssd_t == 0 or t_squares * s_squares > 2.0**44:
        return None
    products = cv2.matchTemplate(s, t, cv2.TM_CCORR)
    whole = np.rint(products)
    if cv2.norm(products, whole, cv2.NORM_INF) > 1 / 4:
        return None
    ssd = np.multiply(squares[0], n, out=squares[0])
    ssd -= total[0] * total[0]
    np.maximum(ssd, 1.0, out=ssd)  # of flat windows, whose r is 0
    ssd *= ssd_t * (1 + 1e-15)  # so that no rounding takes r beyond 1
    total *= t_total
    r = np.multiply(whole, n, dtype=float)
    r -= total[0]
    r /= np.sqrt(ssd, out=ssd)
    return r


def surfaces(templates: np.ndarray, searches: np.ndarray) -> np.ndarray:
    """Correlation maps of templates (k, h, w), none flat, in searches (k, H, W)."""
    t = centred(templates)
    t -= means(t)  # again, since the first mean was rounded
    t /= np.sqrt(np.einsum("kij,kij->k", t, t))[:, None, None]
    if len(t) == 1 or searches[0].size > LARGE:
        r = np.empty((len(t), *np.subtract(searches.shape, templates.shape)[1:] + 1))
        for one in zip(t, searches, r, strict=True):
            _in_blocks(*one)
        return r
    s = centred(searches, work("grey", searches.shape))
    return _normalized(covariances(t, s), t, s, searches)


def _in_blocks(t: np.ndarray, search: np.ndarray, r: np.ndarray) -> None:
    """Fill the map r of one template, in blocks so small that a cache holds them.

    The blocks overlap by the template, so that each position lies in one of them.
    """
    h, w = t.shape
    rows, columns = _length(r.shape[0], h), _length(r.shape[1], w)
    transformed = spectrum("template", t, (rows + h - 1, columns + w - 1))
    for i in range(0, r.shape[0], rows):
        for j in range(0, r.shape[1], columns):
            block = search[None, i : i + rows + h - 1, j : j + columns + w - 1]
            s = centred(block, work("grey", block.shape))
            c = covariance(transformed, s[0], t.shape)
            part = r[None, i : i + rows, j : j + columns]
            _normalized(c, t[None], s, block, out=part)


def _length(n: int, size: int) -> int:
    """How many of n positions a block takes along one axis, for a template of `size`.

    The transforms of a block cost least per position where it is four templates long
    or, if these are small, 160 grey values. Up to half as much more goes into one.
    """
    return math.ceil(n / max(1, round(n / (max(BLOCK, 4 * size) - size))))


def _normalized(
    r: np.ndarray,
    t: np.ndarray,
    s: np.ndarray,
    searches: np.ndarray,
    out: np.ndarray | None = None,
) -> np.ndarray:
    """Correlations from the covariances r of the centred windows s; r is used up."""
    total, squares, energy = window_sums(s, *t.shape[1:])
    total *= total
    total /= t[0].size
    ssd = np.subtract(squares, total, out=squares)
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


def _by_definition(
    r: np.ndarray, faint: np.ndarray, t: np.ndarray, searches: np.ndarray
) -> None:
    """Put into r, where faint, the correlation by definition; 0 for flat windows.

    Uses the original grey values: faint windows lose their digits when centred.
    """
    h, w = t.shape[1:]
    touched = np.flatnonzero(faint.any(axis=(1, 2)))
    uneven = ~flat_at(searches[touched], h, w)
    which, row, column = np.nonzero(faint[touched] & uneven)
    which = touched[which]
    every = sliding_window_view(searches, (h, w), axis=(1, 2))
    for part in chunks(len(which), h * w):
        k, i, j = which[part], row[part], column[part]
        window = centred(every[k, i, j])
        window -= means(window)
        norm = np.sqrt(np.sum(window * window, axis=(1, 2)))
        r[k, i, j] = np.sum(t[k] * window, axis=(1, 2)) / norm
