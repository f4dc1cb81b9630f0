"""Dense matching along epipolar lines, from coarse to fine."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.stereo._boxes import WHOLE, Image, box
from pgm_lab.stereo._correlate import Peaks
from pgm_lab.stereo._levels import coarse_to_fine
from pgm_lab.stereo._pyramid import levels_of
from pgm_lab.stereo._refine import refine as least_squares
from pgm_lab.stereo.normal import NormalPair

# What a cell of `DenseMatch.status` means, by its number
STATUSES = (
    "matched",
    "no image",
    "no texture",
    "below the threshold",
    "at the end of the search",
    "left and right disagree",
    "not at rest",
    "isolated",
)
FLAT = 0.02  # of the image's scatter: a window with less has no texture
JOINED = 0.5  # px between neighbours of one patch
ALONE = 2  # windows: a smaller patch is isolated


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
    pair: NormalPair,
    *,
    window: int = 7,
    threshold: float = 0.8,
    levels: int = 6,
    search: int = 12,
    refine: bool = True,
) -> DenseMatch:
    """Match the two images of a normal pair in every pixel: see `match_rows`."""
    _validate.instance(pair, NormalPair, "pair")
    return match_rows(
        pair.left,
        pair.right,
        window=window,
        threshold=threshold,
        levels=levels,
        search=search,
        refine=refine,
    )


def match_rows(
    left: ArrayLike,
    right: ArrayLike,
    *,
    window: int = 7,
    threshold: float = 0.8,
    levels: int = 6,
    search: int = 12,
    refine: bool = True,
) -> DenseMatch:
    """Match two images whose equal rows show the same, in every pixel.

    On each level of the image pyramid, from coarse to fine, the correlation coefficient
    (H 4) is sought along the row, from left to right and from right to left; what both
    find, smoothed on local planes, is where the next level starts. Least squares
    matching refines the finest level, in windows shaped by the planes.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values of any scale; NaN, or a mask, where there is no image.
    window : int
        Side of the correlation window in px, odd; that of least squares matching is
        larger by 2.
    threshold : float
        Least correlation coefficient, from -1 to 1.
    levels : int
        Most levels of the pyramid; fewer, if the smaller side of the image would fall
        below 40 px.
    search : int
        Largest disparity sought on the coarsest level, px there, to both sides: a pixel
        of level 6 is 32 of the image.
    refine : bool
        Whether to go on with least squares matching.

    Returns
    -------
    DenseMatch
        The status says why a cell has no disparity; the first reason that holds:

        - "no image": the window, here or there, reaches beyond the image;
        - "no texture": its grey values hardly vary;
        - "below the threshold": no correlation coefficient is high enough;
        - "at the end of the search": it still rises there;
        - "left and right disagree": from right to left another place is found;
        - "not at rest": least squares matching moves on, or away by 1 px;
        - "isolated": part of a patch, smaller than two windows, that differs from what
          is around it.

        The standard deviation is that of least squares matching, and knows that the
        residuals of neighbours are correlated. Without `refine` it comes from the peak
        of the correlation alone, and is rough: on simulated aerial photos errors are
        half as large again.

    Raises
    ------
    ValueError
        If the images differ in size or are no grey images, or an argument is out of
        its range.

    References
    ----------
    Harintaka (2020), equation 4. Hirschmuller, H. (2008): Stereo processing by
    semiglobal matching and mutual information. IEEE PAMI 30 (the check from left to
    right and back, small patches). Gruen, A. (1985): Adaptive least squares
    correlation. S. Afr. J. of Photogrammetry 14.

    Examples
    --------
    >>> import numpy as np
    >>> from pgm_lab import simulate, stereo
    >>> pixels = np.stack(np.meshgrid(np.arange(80), np.arange(60)), -1)
    >>> texture = simulate.texture(seed=1)
    >>> left, right = (simulate.grey_values(texture, pixels + [x, 0]) for x in (0, 5.5))
    >>> match = stereo.match_rows(left, right)
    >>> bool(np.nanmax(np.abs(match.disparity - 5.5)) < 0.02)
    True
    """
    L, R = _image(left, "left"), _image(right, "right")
    if L.grey.shape != R.grey.shape:
        raise ValueError(
            "left and right must have the same size, with the same ground in equal"
            f" rows; got {L.grey.shape} and {R.grey.shape} (rows, columns)."
            " stereo.epipolar_pair makes such images"
        )
    window = _validate.window(window, "window")
    if not -1 <= _validate.number(threshold, "threshold") <= 1:
        raise ValueError(f"threshold must lie between -1 and 1; got {threshold}")
    levels = levels_of(L.grey.shape, _validate.whole(levels, "levels", 1, 30))
    search = _validate.whole(search, "search", 1, 1000)
    refine = _validate.flag(refine, "refine")

    peaks, agree = coarse_to_fine(L, R, levels, window, search)
    status = _first_reason(L, peaks, agree, window, threshold)
    d, sd = peaks.d, peaks.sd
    if refine:
        d, sd, rested, whole = least_squares(L, R, d, status == 0, window + 2)
        status[(status == 0) & ~rested] = STATUSES.index("not at rest")
        status[(status == 0) & ~whole] = STATUSES.index("no image")
    alone = _isolated(d, status == 0, ALONE * window**2)
    status[alone] = STATUSES.index("isolated")
    matched = status == 0
    return DenseMatch(
        np.where(matched, d, np.nan).astype(np.float32),
        np.where(peaks.r > -1, peaks.r, np.nan).astype(np.float32),
        np.where(matched, sd, np.nan).astype(np.float32),
        status,
    )


def _image(grey: ArrayLike, name: str) -> Image:
    """Grey values about their mean, in units of their scatter; where they are known."""
    array = _validate.grey_image(grey, name, least=3)
    array = np.ma.filled(np.ma.asarray(array).astype(np.float32), np.nan)
    known = np.isfinite(array)
    if not known.any():
        raise ValueError(f"{name} must show something; it is masked or NaN everywhere")
    mean, scatter = array[known].mean(dtype=float), array[known].std(dtype=float)
    about = np.where(known, (array - mean) / (scatter or 1), 0)
    return Image(about.astype(np.float32), known.astype(np.float32))


def _first_reason(
    left: Image, peaks: Peaks, agree: np.ndarray, window: int, threshold: float
) -> np.ndarray:
    """Statuses of the cells after correlation."""
    whole = box(left.mask, window) > WHOLE
    reasons = {
        "no image": (peaks.r == -1) | ~whole,
        "no texture": _flat(left, window),
        "below the threshold": peaks.r < threshold,
        "at the end of the search": ~peaks.inside,
        "left and right disagree": ~agree,
    }
    numbers = [STATUSES.index(name) for name in reasons]
    return np.select(list(reasons.values()), numbers, 0).astype(np.uint8)


def _flat(image: Image, window: int) -> np.ndarray:
    """Where the windows have hardly any texture."""
    variance = box(image.grey**2, window) - box(image.grey, window) ** 2
    return variance <= FLAT**2


def _isolated(d: np.ndarray, good: np.ndarray, least: int) -> np.ndarray:
    """Good cells in patches of fewer than `least`; a jump divides patches."""
    steps, none = 16, -(2**15)  # whole numbers of 16 bits are asked for
    whole = np.where(good, np.clip(d * steps, none + 1, 2**15 - 1), none)
    whole = np.rint(whole).astype(np.int16)
    cv2.filterSpeckles(whole, none, least - 1, JOINED * steps)
    return good & (whole == none)
