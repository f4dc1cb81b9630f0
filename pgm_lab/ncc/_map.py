"""The correlation of a template with every position of a search window.

Two ways to the same numbers. The quick one correlates in single precision, and knows
from the contrasts how wrong a value can be; where that is too much, the careful one
correlates in double precision, and doubtful positions once more, each by itself.
"""

import math

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike
from scipy import ndimage

# Largest error of a covariance by OpenCV's Fourier transform in single precision, over
# the norms of the template and of the strongest window. The largest of 10^7 seen, most
# of them made to be bad (a sine, an edge, a single bright pixel), was 6.0e-7.
SINGLE = 8e-7
# A window with this much less energy than the whole is doubtful even in double
# precision: of its 16 digits the variance has lost 8
FAINT = 1e-8
TOLERANCE = 1e-6  # of r
CHUNK = 2**18  # grey values that are worked on at a time
NATIVE = (
    "BHhfd"  # uint8, uint16, int16, float32, float64: OpenCV reads them without loss
)


def correlation_map(template: ArrayLike, search: ArrayLike) -> np.ndarray:
    """Correlation of a template with each window of its size in a search window.

    Agrees with `correlation` to 1e-6 everywhere, also for 16 bit grey values with a
    large offset and little contrast, and for a faint window beside a bright edge.
    (``cv2.matchTemplate`` with TM_CCOEFF_NORMED can be off by 1 there.)

    Parameters
    ----------
    template : array_like (h, w)
        Grey values to look for; 8 or 16 bit or float.
    search : array_like (H, W)
        Grey values to look in, at least as large.

    Returns
    -------
    ndarray (H - h + 1, W - w + 1)
        r between -1 and 1; element [i, j] belongs to the window whose top left pixel is
        search[i, j]. A flat window (all its grey values equal) has no correlation; it
        gets r = 0, "nothing in common", and so never wins.

    Raises
    ------
    ValueError
        If the template is flat or larger than the search window, an array is not an
        image, or a grey value is not finite.

    References
    ----------
    Bani 2010, (2.6f); Lewis 1995, Fast normalized cross-correlation, for the
    numerator by the Fourier transform and the denominator by running sums.

    Examples
    --------
    >>> search = np.random.default_rng(1).integers(0, 256, (51, 51))
    >>> r = correlation_map(search[10:31, 12:33], search)
    >>> row, column = np.unravel_index(r.argmax(), r.shape)
    >>> print(r.shape, row, column)
    (31, 31) 10 12
    """
    template, search = image(template, "template"), image(search, "search")
    (h, w), (H, W) = template.shape, search.shape
    if h > H or w > W:
        raise ValueError(
            f"template {template.shape} is larger than search {search.shape}, both"
            " (rows, columns). Take a smaller template, or exchange the two"
        )
    if cv2.minMaxLoc(template)[0] == cv2.minMaxLoc(template)[1]:
        raise ValueError(
            f"template is flat: all its grey values are {template.flat[0]:g}, and no"
            " correlation is defined. Take a larger template, or one with texture"
        )
    t, s = _centred(template, "template"), _centred(search, "search")
    (energy,), (ssd,) = _sums(s[None], t.shape)
    faintest = cv2.minMaxLoc(ssd)[0]
    if SINGLE**2 * cv2.minMaxLoc(energy)[1] < TOLERANCE**2 * faintest:
        s32, t32 = s.astype(np.float32), t.astype(np.float32)
        covariance = cv2.matchTemplate(s32, t32, cv2.TM_CCORR)
    else:
        covariance = _covariance(t, s)
    if faintest <= FAINT * cv2.norm(s) ** 2:
        return normalized(covariance[None], t[None], s[None], ssd[None])[0]
    r = np.sqrt(ssd, out=ssd)
    r *= cv2.norm(t)
    np.divide(covariance, r, out=r)
    np.minimum(r, 1.0, out=r)
    return np.maximum(r, -1.0, out=r)


def image(values: ArrayLike, name: str) -> np.ndarray:
    """Return `values` as an image that OpenCV reads without loss."""
    array = np.asarray(values)
    if array.ndim != 2 or not array.size or array.dtype.kind not in "buif":
        raise ValueError(
            f"{name} must be a grey-value image, an array (rows, columns) of real"
            f" numbers; got shape {array.shape}, {array.dtype}. Of a colour image take"
            " one channel, or their mean"
        )
    return array if array.dtype.char in NATIVE else array.astype(float)


def _centred(image: np.ndarray, name: str) -> np.ndarray:
    """The image without its mean, scaled by a power of two, which costs no digit."""
    mean = cv2.mean(image)[0]
    if not math.isfinite(mean):
        raise ValueError(
            f"{name} has grey values that are NaN or infinite, or too large to add up."
            " Cut them off, or fill them, before the call"
        )
    g = image - mean
    if g.dtype != float:  # of single precision
        g = image.astype(float) - mean
    if image.dtype.kind == "f":
        g *= 2.0 ** -math.frexp(cv2.norm(g, cv2.NORM_INF))[1]
    return g


def _covariance(t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Sums of products of a template and each window, in double precision."""
    (h, w), (H, W) = t.shape, s.shape
    size = cv2.getOptimalDFTSize(H), cv2.getOptimalDFTSize(W)
    spectra = []
    for values in (s, t):
        padded = np.zeros(size)
        padded[: values.shape[0], : values.shape[1]] = values
        spectra.append(cv2.dft(padded, nonzeroRows=values.shape[0]))
    spectrum = cv2.mulSpectrums(*spectra, 0, conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT
    product = cv2.dft(spectrum, flags=inverse, nonzeroRows=H - h + 1)
    return product[: H - h + 1, : W - w + 1]


def _sums(s: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, ...]:
    """Sum of squares of each window, and sum of squares about its mean.

    s: (k, H, W), summed up as one tall image.
    """
    (k, H, W), (h, w) = s.shape, size
    stack = s.reshape(k * H, W)
    sums = []
    for running in cv2.integral2(stack, sdepth=cv2.CV_64F, sqdepth=cv2.CV_64F):
        below = running[1:].reshape(k, H, W + 1)[:, h - 1 :]
        above = running[:-1].reshape(k, H, W + 1)[:, : H - h + 1]
        rows = below - above
        sums.append(rows[:, :, w:] - rows[:, :, :-w])
    total, energy = sums
    total *= total
    total *= -1 / (h * w)
    total += energy
    return energy, total


def normalized(r, t, s, ssd) -> np.ndarray:
    """Divide covariances r by the norms; correct what is faint.

    r, ssd: (k, rows, columns); t: templates and s: search windows, both centred.
    """
    # The running sums, and their rounding errors, have grown to the energy of the stack
    faint = ssd <= FAINT * np.vdot(s, s)
    norm = np.sqrt(np.sum(t * t, axis=(1, 2), keepdims=True))
    if not faint.any():
        r = r / (norm * np.sqrt(ssd))
    else:
        r = r / (norm * np.sqrt(np.where(faint, np.inf, ssd)))
        _by_definition(r, faint, t / norm, s)
    return np.clip(r, -1.0, 1.0, out=r)


def surfaces(templates: np.ndarray, searches: np.ndarray) -> np.ndarray:
    """Correlation maps of a stack, in double precision; 0 for flat windows.

    Parameters
    ----------
    templates : ndarray (k, h, w)
        None of them flat.
    searches : ndarray (k, H, W)
    """
    t, s = _stack_centred(templates.astype(float)), _stack_centred(searches)
    (h, w), (H, W) = t.shape[1:], s.shape[1:]
    k, rows, columns = len(s), H - h + 1, W - w + 1
    # A window written as one long row, the template with gaps: the correlation of the
    # two rows holds the map, and OpenCV transforms all rows of a stack in one call
    row = cv2.getOptimalDFTSize(H * W)
    spread = np.zeros((2, k, row))
    spread[0, :, : H * W] = s.reshape(k, -1)
    spread[1, :, : h * W].reshape(k, h, W)[:, :, :w] = t
    spectrum, other = (cv2.dft(values, flags=cv2.DFT_ROWS) for values in spread)
    spectrum = cv2.mulSpectrums(spectrum, other, cv2.DFT_ROWS, conjB=True)
    inverse = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_ROWS
    r = cv2.dft(spectrum, flags=inverse)[:, : rows * W]
    r = r.reshape(k, rows, W)[:, :, :columns]

    energy, ssd = _sums(s, (h, w))
    return normalized(r, t, s, ssd)


def _stack_centred(windows: np.ndarray) -> np.ndarray:
    """Windows without their means; real numbers scaled by powers of two.

    From whole numbers a whole number is taken, so that the sums remain exact.
    """
    g = windows.astype(float)
    mean = g.mean(axis=(1, 2), keepdims=True)
    if windows.dtype.kind in "ui":
        g -= np.rint(mean)
        return g
    g -= mean
    largest = np.abs(g).max(axis=(1, 2), keepdims=True)
    return np.ldexp(g, -np.frexp(largest)[1])


def _by_definition(
    r: np.ndarray, faint: np.ndarray, t: np.ndarray, s: np.ndarray
) -> None:
    """Put into r, where faint, the correlation by definition; 0 for flat windows."""
    h, w = size = t.shape[1:]
    rows, columns = r.shape[1:]
    t = np.broadcast_to(t, (len(r), h, w))
    touched = np.flatnonzero(faint.any(axis=(1, 2)))
    highest, lowest = (
        extreme(s[touched], (1, h, w))[:, h // 2 :, w // 2 :][:, :rows, :columns]
        for extreme in (ndimage.maximum_filter, ndimage.minimum_filter)
    )
    which, row, column = np.nonzero(faint[touched] & (highest > lowest))
    which = touched[which]
    every = sliding_window_view(s, size, axis=(1, 2))
    at_once = max(1, CHUNK // (h * w))
    for i in range(0, len(which), at_once):
        k, y, x = (index[i : i + at_once] for index in (which, row, column))
        window = every[k, y, x]
        window = window - window.mean(axis=(1, 2), keepdims=True)
        window /= np.abs(window).max(axis=(1, 2), keepdims=True)
        window -= window.mean(axis=(1, 2), keepdims=True)
        norm = np.sqrt(np.sum(window * window, axis=(1, 2)))
        r[k, y, x] = np.sum(t[k] * window, axis=(1, 2)) / norm
