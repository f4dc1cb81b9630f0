"""Dense matching along epipolar lines, from coarse to fine.

Each level of the pyramid is searched along the rows, in both directions: by semiglobal
matching, or for the highest correlation, with local planes to smooth the disparities.
Least squares matching refines the finest level and says how sure it is.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._robust import SD_OF_MAD
from pgm_lab.image.grey import eight_bit
from pgm_lab.stereo.normal import NormalPair

# What a cell of `DenseMatch.status` means, by its number
STATUSES = (
    "accepted",
    "no data in the window",
    "flat template",
    "below threshold",
    "peak on the border of the search",
    "left-right check failed",
    "not converged",
    "isolated",
)
METHODS = {"sgm": 0.5, "ncc": 0.8}  # and the least correlation that each accepts
# What `fill` takes as it was found
UNMEASURED = ("no data in the window", "flat template", "not converged")
LEVELS, SEARCH = 6, 12  # of the pyramid; px on the coarsest, to both sides
MIN_TEXTURE = 0.02  # of the image's standard deviation: with less, a window is flat
MAX_JUMP = 0.5  # px between neighbours of one patch
MIN_PATCH = 2  # windows: a smaller patch is isolated
BAND = 512  # rows at a time, so that the work fits a laptop and its cache
WHOLE = 0.999  # of a pixel, interpolated from a mask
ROUNDING = 1e-6  # of the image's variance; less is rounding
Done = Callable[[int], Any]  # told of pixels that are done


@dataclass(frozen=True, eq=False)
class DenseMatch:
    """Disparities of a normal pair.

    Attributes
    ----------
    disparity : ndarray (rows, columns) of float32
        Left column minus right column, px; NaN unless accepted.
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
        """Number of cells with each status."""
        return {s: int(np.sum(self.status == i)) for i, s in enumerate(STATUSES)}


def match_dense(pair: NormalPair, **options: Any) -> DenseMatch:
    """Match the two images of a normal pair in every pixel; options as `match_rows`.

    The search reaches as far as the limits of the pair do, if not as `match_rows`.
    """
    _validate.instance(pair, NormalPair, "pair")
    if "search" not in options:
        levels = _validate.whole(options.get("levels", LEVELS), "levels", 1, 30)
        coarsest = 2 ** (_levels(pair.left.shape, levels) - 1)
        reach = min(pair.reach, pair.left.shape[1]) / coarsest
        options["search"] = max(SEARCH, math.ceil(reach))
    return match_rows(pair.left, pair.right, **options)


def match_rows(
    left: ArrayLike,
    right: ArrayLike,
    *,
    method: str = "sgm",
    fill: bool = False,
    window: int = 7,
    threshold: float | None = None,
    levels: int = LEVELS,
    search: int = SEARCH,
    refine: bool = True,
    progress: bool = False,
) -> DenseMatch:
    """Match two images whose equal rows show the same ground, in every pixel.

    On each level of the image pyramid the row is searched in both directions, around
    the disparities of the level above that agree: by "sgm" for those which match best
    and are smooth along lines in three directions (`cv2.StereoSGBM`), by "ncc" for the
    highest correlation coefficient (H 1) of each cell alone. Least squares matching
    refines the finest level, in windows shaped by local planes.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values of any scale; NaN, or masked, where there is no image.
    method : {"sgm", "ncc"}
        Semiglobal matching, much denser, or correlation.
    fill : bool
        With "sgm": whether to accept, too, what was found but not measured by least
        squares: at edges, in flat windows, on the border. Its `sd` is larger.
    window : int
        Side of the correlation window in px, odd; that of least squares matching is
        larger by 2, and with "sgm" smaller by 2, at least 5, where the larger one
        fails.
    threshold : float, optional
        Smallest correlation coefficient that is accepted, from -1 to 1; default: 0.5
        with "sgm", which chance hardly reaches in 7 x 7 px, and 0.8 with "ncc".
    levels : int
        Largest number of pyramid levels; fewer if the smaller side of the image would
        fall below 40 px.
    search : int
        Largest disparity searched on the coarsest level, px there, to both sides: a
        pixel of level 6 is 32 of the image.
    refine : bool
        Whether to go on with least squares matching; False with "ncc" alone.
    progress : bool
        Show a bar with the time left, if it takes more than a second.

    Returns
    -------
    DenseMatch
        The status gives the reason why a cell has no disparity; the first that applies:

        - "no data in the window": it reaches beyond one of the images;
        - "flat template": its grey values hardly vary;
        - "below threshold": no correlation coefficient is high enough;
        - "peak on the border of the search": the correlation still rises there;
        - "left-right check failed": from right to left another pixel is found;
        - "not converged": least squares still makes steps, or moved by over 1 px
          ("ncc") or 0.75 px ("sgm"), or gives no standard deviation;
        - "isolated": part of a patch under two windows that differs from all around.

        The standard deviation is that of least squares matching, with the correlation
        of neighbouring residuals. Without `refine` it comes from the peak of the
        correlation alone, and is too small by a third or so. With "sgm" the disparity
        is the mean of both ways, left to right and back, and the standard deviation
        contains what they, and windows of half and twice the area, say differently; for
        filled cells it is how far least squares moves those nearby. An error that all
        windows share, of the orientation or in y, is not in it.

    Raises
    ------
    ValueError
        If the images differ in size or are not grey images, or an argument is out of
        its range.

    References
    ----------
    Harintaka (2020), equation 4. Hirschmuller (2008), Stereo processing by semiglobal
    matching and mutual information, IEEE PAMI 30. Gruen (1985), Adaptive least squares
    correlation, S. Afr. J. of Photogrammetry 14.

    Examples
    --------
    >>> import numpy as np
    >>> from pgm_lab import simulate, stereo
    >>> pixels = np.stack(np.meshgrid(np.arange(80), np.arange(60)), -1)
    >>> texture = simulate.texture(seed=1)
    >>> left, right = (simulate.grey_values(texture, pixels + [x, 0]) for x in (0, 5.5))
    >>> match = stereo.match_rows(left, right)
    >>> bool(np.nanquantile(np.abs(match.disparity - 5.5), 0.99) < 0.05)
    True
    """
    from tqdm.auto import tqdm

    L, R = _image(left, "left"), _image(right, "right")
    if L.grey.shape != R.grey.shape:
        raise ValueError(
            "left and right must have the same size, with the same ground in equal"
            f" rows; got {L.grey.shape} and {R.grey.shape} (rows, columns)."
            " stereo.epipolar_pair makes such images"
        )
    least = METHODS[_validate.choice(method, "method", tuple(METHODS))]
    fill, refine = _validate.flag(fill, "fill"), _validate.flag(refine, "refine")
    if (fill and method == "ncc") or (not refine and method == "sgm"):
        raise ValueError(f"fill={fill}, refine={refine} does not go with {method!r}")
    window = _validate.window(window, "window")
    threshold = least if threshold is None else threshold
    threshold = _validate.between(threshold, "threshold", -1, 1)
    levels = _levels(L.grey.shape, _validate.whole(levels, "levels", 1, 30))
    search = _validate.whole(search, "search", 1, 1000)

    bar = tqdm(
        total=_pixels(L.grey.shape, levels, method),
        disable=not _validate.flag(progress, "progress"),
        **{"desc": "dense matching", "unit": "px", "unit_scale": True},
        **{"leave": False, "delay": 1.0},
    )
    with bar:
        way = _Way(L, R, window, method, bar.update)
        peaks, back = _coarse_to_fine(way, levels, search)
        agree = _agreement(peaks.d, back.d)
        status = _first_reason(way, peaks, agree, threshold)
        d, sd, good = peaks.d, peaks.sd, status == 0
        if refine:
            refined = _least_squares(way, d, good)
            if method == "sgm":
                refined = _both_ways(way, peaks, back, good, refined)
            d, sd, converged, whole = refined
    if refine:
        status[(status == 0) & ~converged] = STATUSES.index("not converged")
        status[(status == 0) & ~whole] = STATUSES.index("no data in the window")
    if fill:
        seen = agree & (L.mask > 0) & (_warped(R.mask, peaks.d) > WHOLE)
        found = seen & np.isin(status, [STATUSES.index(name) for name in UNMEASURED])
        moves = np.clip(d - peaks.d, -MAX_CORRECTION, MAX_CORRECTION)
        nearby = np.sqrt(_mean_around(moves**2, agree, window))
        d, sd = np.where(found, peaks.d, d), np.where(found, nearby, sd)
        status[found] = 0
    status[(status == 0) & ~np.isfinite(sd)] = STATUSES.index("not converged")
    jump = MAX_DIFFERENCE if fill else MAX_JUMP
    isolated = _isolated(d, status == 0, MIN_PATCH * window**2, jump)
    status[isolated] = STATUSES.index("isolated")
    accepted = status == 0
    return DenseMatch(
        np.where(accepted, d, np.nan).astype(np.float32),
        np.where(peaks.r > -1, peaks.r, np.nan).astype(np.float32),
        np.where(accepted, sd, np.nan).astype(np.float32),
        status,
    )


def _first_reason(
    way: "_Way", peaks: "_Peaks", agree: np.ndarray, threshold: float
) -> np.ndarray:
    """Statuses of the cells after correlation."""
    left, window = way.left, way.window
    variance = _box(left.grey**2, window) - _box(left.grey, window) ** 2
    reasons = {
        "no data in the window": (peaks.r == -1) | (_box(left.mask, window) <= WHOLE),
        "flat template": variance <= MIN_TEXTURE**2,
        "below threshold": peaks.r < threshold,
        "peak on the border of the search": ~peaks.inside,
        "left-right check failed": ~agree,
    }
    numbers = [STATUSES.index(name) for name in reasons]
    return np.select(list(reasons.values()), numbers, 0).astype(np.uint8)


def _isolated(d: np.ndarray, good: np.ndarray, least: int, jump: float) -> np.ndarray:
    """Good cells in patches of fewer than `least`; a jump divides patches."""
    steps, none = 16, -(2**15)  # filterSpeckles needs 16 bit integers
    whole = np.where(good, np.clip(d * steps, none + 1, 2**15 - 1), none)
    whole = np.rint(whole).astype(np.int16)
    cv2.filterSpeckles(whole, none, least - 1, jump * steps)
    return good & (whole == none)


def _pixels(shape: tuple[int, ...], levels: int, method: str) -> int:
    """Pixels to do: those of all levels, and of what follows on the finest."""
    n = sum(math.prod(-(-side // 2**k) for side in shape) for k in range(levels))
    return (2 if method == "sgm" else 1) * (2 * n + math.prod(shape))


# --- Images, windows, warps, bands ---


class _Image(NamedTuple):
    """Grey values, standardised; the mask is 1 where there is image."""

    grey: np.ndarray
    mask: np.ndarray
    eight: np.ndarray = np.zeros((0, 0), np.uint8)  # with 8 bits, for "sgm" alone


class _Way(NamedTuple):
    """What is matched, and how: from left to right."""

    left: _Image
    right: _Image
    window: int
    method: str
    done: Done

    def back(self) -> "_Way":
        """From right to left: both mirrored, so that a disparity keeps its sign."""
        left, right = (
            _Image(*map(_mirrored, image)) for image in (self.right, self.left)
        )
        return self._replace(left=left, right=right)


def _image(grey: ArrayLike, name: str) -> _Image:
    """Grey values minus their mean, by their standard deviation; and a mask."""
    array = _validate.grey_image(grey, name, least=3)
    array = np.ma.filled(np.ma.asarray(array).astype(np.float32), np.nan)
    known = np.isfinite(array)
    if not known.any():
        raise ValueError(f"{name} has no data: it is masked or NaN everywhere")
    mean, scatter = array[known].mean(dtype=float), array[known].std(dtype=float)
    about = np.where(known, (array - mean) / (scatter or 1), 0)
    return _Image(about.astype(np.float32), known.astype(np.float32))


def _mirrored(a: np.ndarray) -> np.ndarray:
    """Left and right exchanged."""
    return np.ascontiguousarray(a[:, ::-1])


def _box(a: np.ndarray, n: int) -> np.ndarray:
    """Mean over n x n windows; outside is zero."""
    return cv2.boxFilter(a, cv2.CV_32F, (n, n), borderType=cv2.BORDER_CONSTANT)


def _rounded(d: np.ndarray) -> np.ndarray:
    """Disparities in 1/32 px: at these every version of OpenCV gives the same image."""
    return np.rint(d * 32) / np.float32(32)


def _warped(
    image: np.ndarray, d: np.ndarray, row: int = 0, how: int = cv2.INTER_LINEAR
) -> np.ndarray:
    """Right image where the left pixels (from `row` on) lie; zero outside."""
    rows, columns = d.shape
    x = np.arange(columns, dtype=np.float32) - d
    y = np.arange(row, row + rows, dtype=np.float32)
    y = np.broadcast_to(y[:, None], d.shape).copy()
    return cv2.remap(image, x, y, how, borderMode=cv2.BORDER_CONSTANT, borderValue=0)


def _in_tiles(
    way: _Way,
    work: Callable[[slice, slice], tuple[np.ndarray, ...]],
    margin: int,
    tile: tuple[int, int] | None = None,
) -> tuple[np.ndarray, ...]:
    """Results of all pixels from work on tiles, or bands of rows, with a margin."""
    shape = way.left.grey.shape
    high, wide = tile or (BAND, shape[1])
    out: tuple[np.ndarray, ...] = ()
    for row in range(0, shape[0], high):
        for column in range(0, shape[1], wide):
            rows = slice(max(row - margin, 0), row + high + margin)
            columns = slice(max(column - margin, 0), column + wide + margin)
            found = work(rows, columns)
            out = out or tuple(np.empty(shape, a.dtype) for a in found)
            # The corner that is kept
            top, side = row - rows.start, column - columns.start
            for whole, part in zip(out, found, strict=True):
                part = part[top : top + high, side : side + wide]
                whole[row : row + high, column : column + wide] = part
            way.done(part.size)
    return out


# --- From coarse to fine ---

MIN_SIDE = 40  # px of a level, on which windows still distinguish positions
NEAR = {"sgm": 4, "ncc": 3}  # px, search on all levels but the coarsest
MIN_R = 0.6  # on coarse levels; below it, filled from the neighbours
MAX_DIFFERENCE = 1.0  # px between the two directions


def _levels(shape: tuple[int, ...], most: int) -> int:
    """Number of levels for an image, at most `most`."""
    return max(1, min(most, int(np.log2(max(min(shape), 1) / MIN_SIDE)) + 1))


def _coarse_to_fine(way: _Way, levels: int, reach: int) -> tuple["_Peaks", "_Peaks"]:
    """Peaks of the finest level, from left to right and back."""
    pyramids = (_pyramid(image, levels, way.method) for image in way[:2])
    ways = [way._replace(left=L, right=R) for L, R in zip(*pyramids, strict=True)]
    search = {"sgm": _semiglobal, "ncc": _search}[way.method]
    there = back = np.zeros(ways[-1].left.grey.shape, np.float32)
    for k in reversed(range(levels)):
        way = ways[k]
        if k < levels - 1:
            there, back = (_finer(a, way.left.grey.shape) for a in (there, back))
            reach = NEAR[way.method]
        least = 1.0 if way.method == "ncc" and k == 0 else 0.5
        one = search(way, there, reach, least)
        two = search(way.back(), back, reach, least)
        if k:
            there = _smooth(one, _agreement(one.d, two.d), way.window)
            back = _smooth(two, _agreement(two.d, one.d), way.window)
    return one, two


def _pyramid(image: _Image, levels: int, method: str) -> list[_Image]:
    """Levels from fine to coarse; masked pixels do not enter the means."""
    out = [image]
    for _ in range(levels - 1):
        grey, mask, _ = out[-1]
        share = cv2.pyrDown(mask)
        mask = (share > 0.5).astype(np.float32)
        out.append(_Image(cv2.pyrDown(grey) / np.maximum(share, 0.5) * mask, mask))
    if method == "ncc":
        return out
    greys = (np.ma.array(one.grey, mask=one.mask == 0) for one in out)
    return [one._replace(eight=eight_bit(a)) for one, a in zip(out, greys)]


def _finer(d: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Disparities of a level as start values of the level below."""
    d = cv2.medianBlur(d, 5)
    return 2 * cv2.resize(d, shape[::-1], interpolation=cv2.INTER_LINEAR)


def _agreement(there: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Whether the search, and the one back in the mirror, ends where it began."""
    return np.abs(there - _returned(back, there)) < MAX_DIFFERENCE


def _returned(back: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Disparities of the way back where the way there ends."""
    return _warped(_mirrored(back), _rounded(there))


def _smooth(peaks: "_Peaks", agree: np.ndarray, window: int) -> np.ndarray:
    """Disparities on their local planes; unreliable ones from their neighbours."""
    good = agree & peaks.inside & (peaks.r > MIN_R)
    return _filled(_on_planes(peaks.d, good, window), good)


def _filled(d: np.ndarray, good: np.ndarray) -> np.ndarray:
    """Disparities with bad ones replaced by the mean of the nearest good ones."""
    w = good.astype(np.float32)
    if good.all() or min(d.shape) < 3:
        all_of_them = float((d * w).sum() / max(w.sum(), 1))
        return np.where(good, d, np.float32(all_of_them)).astype(np.float32)
    share = cv2.pyrDown(w)
    mean = cv2.pyrDown(d * w) / np.maximum(share, 1e-3)
    coarse = _filled(mean, share > 1e-3)
    near = cv2.resize(coarse, d.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.where(good, d, near).astype(np.float32)


# --- Semiglobal matching ---

TILE, OVERLAP = 512, 64  # px: the costs of all disparities of a tile fit the memory
BLOCK = 3  # px, side of the blocks that are compared, and of sums of residuals


def _semiglobal(way: _Way, start: np.ndarray, reach: int, least: float) -> "_Peaks":
    """Disparities that match best and are smooth, within `reach` of those of a tile."""

    def matched(rows: slice, columns: slice) -> tuple[np.ndarray, np.ndarray]:
        low, high = np.percentile(start[rows, columns], (0.5, 99.5))
        low = int(np.floor(low)) - reach
        n = 16 * int(np.ceil((high + reach + 1 - low) / 16))
        # To the left lies what n disparities need; the edges of the image go on there
        last = start.shape[1] - 1
        at = np.arange(columns.start - n, min(columns.stop, last + 1))
        L = way.left.eight[rows][:, np.clip(at, 0, last)]
        R = way.right.eight[rows][:, np.clip(at - low, 0, last)]
        matcher = cv2.StereoSGBM.create(
            numDisparities=n,
            blockSize=BLOCK,
            P1=8 * BLOCK**2,
            P2=64 * BLOCK**2,
            disp12MaxDiff=16 * n,  # checked here, in both directions
            preFilterCap=63,
            mode=cv2.StereoSGBM_MODE_SGBM_3WAY,  # three directions, in half of the time
        )
        d = matcher.compute(L, R)[:, n:].astype(np.float32) / 16
        return d + low, (d > 0) & (d < n - 1)

    def correlated(rows: slice, _columns: slice) -> tuple[np.ndarray]:
        return (_correlation(way, _rounded(d[rows]), rows, least),)

    d, inside = _in_tiles(way, matched, OVERLAP, (TILE, TILE))
    (r,) = _in_tiles(way, correlated, way.window // 2)
    return _Peaks(d, r, np.zeros_like(d), inside)


# --- Local planes of disparity: the shape of the ground under a window ---

MAX_ROUGHNESS = 0.3  # px about its plane: more than noise, so an edge or a crest
MIN_SHARE = 0.3  # of a window that must be good


def _on_planes(d: np.ndarray, good: np.ndarray, window: int) -> np.ndarray:
    """Disparities on the planes through the good cells of their windows."""
    # Where cells scatter about their plane by more than `MAX_ROUGHNESS`, or few are
    # good, the median of 5 x 5 stays instead.
    level = float(d[good].mean()) if good.any() else 0.0
    w = good.astype(np.float32)
    v = np.where(good, d - np.float32(level), 0).astype(np.float32)
    # Central moments of the good cells and of their disparities
    n = np.maximum(_moment(w, window, 0, 0), 1)
    x, y, xx, yy, xy = (
        _moment(w, window, *p) / n for p in ((1, 0), (0, 1), (2, 0), (0, 2), (1, 1))
    )
    m, xv, yv = (_moment(v, window, *p) / n for p in ((0, 0), (1, 0), (0, 1)))
    vv = _moment(v * v, window, 0, 0) / n - m * m
    xx, yy, xy, xv, yv = xx - x * x, yy - y * y, xy - x * y, xv - x * m, yv - y * m
    # The plane a x + b y + m, and the variance about it
    det = np.maximum(xx * yy - xy * xy, 1e-3)
    a, b = (xv * yy - yv * xy) / det, (yv * xx - xv * xy) / det
    rough = np.maximum(vv - a * xv - b * yv, 0)
    own = np.clip(rough / MAX_ROUGHNESS**2 - 1, 0, 1)
    own[n < MIN_SHARE * window**2] = 1
    plane = m - a * x - b * y + level
    return own * cv2.medianBlur(d, 5) + (1 - own) * plane


def _moment(a: np.ndarray, window: int, p: int, q: int) -> np.ndarray:
    """Sum of a x^p y^q over windows, x and y from the centre of each."""
    k = np.arange(window, dtype=np.float32) - window // 2
    return cv2.sepFilter2D(a, cv2.CV_32F, k**p, k**q, borderType=cv2.BORDER_CONSTANT)


# --- Correlation along the rows ---


class _Peaks(NamedTuple):
    """Where the correlation is highest."""

    d: np.ndarray  # disparity, px
    r: np.ndarray  # correlation coefficient; -1 where no window has enough image
    sd: np.ndarray  # of the disparity, from the peak, px
    inside: np.ndarray  # not at an end of the search


def _search(way: _Way, start: np.ndarray, reach: int, least: float) -> _Peaks:
    """Highest correlation within `reach`; `least` is the share that must be image."""

    def work(rows: slice, _columns: slice) -> _Peaks:
        middle = _rounded(start[rows])
        # The highest correlation so far, and those one pixel before and after it
        best, before, after, last = np.full((4, *middle.shape), -1, np.float32)
        at = np.zeros_like(best)
        for offset in range(-reach, reach + 1):
            r = _correlation(way, middle + offset, rows, least)
            np.copyto(after, r, where=at == offset - 1)
            higher = r > best
            np.copyto(before, last, where=higher)
            np.copyto(best, r, where=higher)
            np.copyto(after, -1, where=higher)
            at[higher] = offset
            last = r
        # The top of the parabola through the three
        inside = (np.abs(at) < reach) & (before > -1) & (after > -1)
        bend = np.maximum(2 * best - before - after, 1e-6)
        part = np.where(inside, (after - before) / (2 * bend), 0)
        # sd^2 = sigma^2 / sum g^2, with 1 - r^2 = sigma^2 / var, bend = mean g^2 / var
        sd = np.sqrt(np.maximum(1 - best**2, 0) / bend) / way.window
        return _Peaks(middle + at + np.clip(part, -0.5, 0.5), best, sd, inside)

    return _Peaks(*_in_tiles(way, work, way.window // 2))


def _correlation(way: _Way, d: np.ndarray, rows: slice, least: float) -> np.ndarray:
    """Coefficients of the left windows of some rows and the right image warped by d."""
    left, right, window = way[:3]
    known = _warped(right.mask, d, rows.start) > WHOLE
    W = _warped(right.grey, d, rows.start)
    w = left.mask[rows] * known
    share = _box(w, window)
    # Where windows must be whole, masked sums and plain ones are the same
    n: np.ndarray | float = 1.0
    L = left.grey[rows]
    if least < 1:
        n = np.maximum(share, 1e-3)
        L, W = L * w, W * w
    mL, mW = _box(L, window) / n, _box(W, window) / n
    vL = _box(L * L, window) / n - mL * mL
    vW = _box(W * W, window) / n - mW * mW
    r = (_box(L * W, window) / n - mL * mW) / np.sqrt(np.maximum(vL * vW, ROUNDING**2))
    return np.where(share > least - 1e-4, np.clip(r, -1, 1), np.float32(-1))


# --- Least squares matching of all cells at once, in windows shaped by the ground ---

MAX_CORRECTION = 1.0  # px from the start
MAX_LAST_STEP = 0.3  # px: after a longer one a window has not converged
# Iterations; px by which planes are larger than windows; px from the start that are too
# far before the last iteration, and at the end. What "sgm" finds is smooth and near
REFINING = {"sgm": (2, 0, 0.75, 0.75), "ncc": (3, 4, np.inf, MAX_CORRECTION)}
LAGS = ((0, 1), (0, 2), (1, 0), (1, 1), (1, -1))  # rows and columns
AROUND = 4  # windows: the neighbourhood in which correlation of residuals is measured


class _Refined(NamedTuple):
    """Disparities by least squares."""

    d: np.ndarray  # px
    sd: np.ndarray  # px
    converged: np.ndarray  # near the start
    whole: np.ndarray  # the window is image everywhere


class _Solution(NamedTuple):
    """Solution of the normal equations of all windows."""

    step: np.ndarray  # px
    variance: np.ndarray  # of the step, if residuals were independent
    slope: np.ndarray  # of each pixel, corrected for offset and gain
    residual: np.ndarray  # of each pixel


def _least_squares(
    way: _Way, d: np.ndarray, good: np.ndarray, compare: bool = True
) -> _Refined:
    """Disparities by least squares: shift, gain and offset of each window."""
    # The right image is warped by the disparities on their local planes, so that a
    # window on a slope has the shape it has in the left image. Good cells make the
    # planes; the others take the disparities of their neighbours.
    left, right, window, method = way[:4]
    # Gradients reach one pixel to each side, the interpolation four
    solid = cv2.erode(right.mask, np.ones((1, 9)), borderValue=0)
    here = cv2.erode(left.mask, np.ones((1, 3)), borderValue=0)
    start = _filled(d, good)
    iterations, planes, astray, most = REFINING[method]
    n, small = window + 2, max(window - 2, 5)
    large = 2 * int(n / np.sqrt(2)) + 1  # px: twice the area

    def work(rows: slice, _columns: slice) -> _Refined:
        at = first = start[rows]
        L = left.grey[rows]
        for _ in range(iterations):
            at = np.where(np.abs(at - first) < astray, at, first)
            plane = _on_planes(at, good[rows], n + planes)
            shape = _rounded(plane)
            W = _warped(right.grey, shape, rows.start, cv2.INTER_LANCZOS4)
            found = _normal_equations(L, W, n)
            at = shape + found.step
        both = here[rows] * (_warped(solid, shape, rows.start) > WHOLE)

        def refined(found: _Solution, window: int) -> _Refined:
            middle = shape
            if method == "sgm":  # the step is from the mean of what was rounded
                middle = plane + _box(shape - plane, window)
            at = middle + found.step
            factor = _inflation(found, good[rows], window, method)
            near = np.abs(at - first) < most
            converged = near & (np.abs(found.step) < MAX_LAST_STEP)
            sd = np.sqrt(found.variance * factor)
            return _Refined(at, sd, converged, _box(both, window) > WHOLE)

        if method == "ncc" or not compare:
            return refined(found, n)
        one, two = (refined(_normal_equations(L, W, k), k) for k in (small, large))
        return _combined(refined(found, n), one, two, window)

    margin = iterations * (n + 2) + AROUND * max(n, large) // 2 + window + 1
    return _Refined(*_in_tiles(way, work, margin))


def _combined(
    fine: _Refined, small: _Refined, large: _Refined, window: int
) -> _Refined:
    """Disparities by small windows where fine ones fail, and what all three say."""
    ok = fine.converged & fine.whole
    at, sd, converged, whole = (
        np.where(ok, a, b) for a, b in zip(fine, small, strict=True)
    )
    # A window of twice the area differs by half of the variance of noise (Hausman
    # 1978), on curved ground, where errors grow as the area, by the error itself; the
    # other half of noise is known. At edges a small one differs by more than noise.
    # Here and nearby count alike; a square alone by its median
    curved = (fine.d - large.d) ** 2
    edge = (small.d - fine.d) ** 2 - (small.sd**2 - fine.sd**2)
    here = np.where(ok, SD_OF_MAD**2 * curved, sd**2)
    nearby = _mean_around(curved, ok, window) + _mean_around(edge, ok, window)
    return _Refined(at, np.sqrt((sd**2 + here + nearby) / 2), converged, whole)


def _mean_around(a: np.ndarray, good: np.ndarray, window: int) -> np.ndarray:
    """Mean of the good cells around each, in windows of twice the size."""
    around = 2 * window + 1
    share = _box(good.astype(np.float32), around)
    mean = _box(np.where(good, a, 0).astype(np.float32), around)
    return np.maximum(mean, 0) / np.maximum(share, ROUNDING)


def _both_ways(
    way: _Way, peaks: _Peaks, back: _Peaks, good: np.ndarray, there: _Refined
) -> _Refined:
    """Means of disparities by least squares from left to right and back."""
    # Both ways share the noise, not what interpolation and the shapes of windows do: a
    # quarter of the squared difference
    agree = _agreement(back.d, peaks.d)
    found = _least_squares(way.back(), back.d, agree, compare=False)
    d = np.where(agree & found.converged & found.whole, found.d, np.float32(np.nan))
    both = there.d - _returned(d, peaks.d)
    near = good & there.converged & there.whole & (there.sd > 0)
    near &= np.abs(both) < MAX_DIFFERENCE
    relative = (both / np.where(near, there.sd, 1)) ** 2
    sd = there.sd * np.sqrt(1 + _mean_around(relative, near, way.window) / 4)
    return there._replace(d=np.where(near, there.d - both / 2, there.d), sd=sd)


def _normal_equations(L: np.ndarray, W: np.ndarray, window: int) -> _Solution:
    """Solve L = offset + h W + k dW/dx in all windows; the step is -k / h."""
    # Box filters sum the normal equations, and moments about the means have eliminated
    # the offset. The gradient is the mean of both images': that of one alone is too
    # large by its noise.
    g = cv2.Sobel(L + W, cv2.CV_32F, 1, 0, ksize=1, scale=0.25)
    mL, mW, mg = (_box(a, window) for a in (L, W, g))
    ww, gg = _box(W * W, window) - mW * mW, _box(g * g, window) - mg * mg
    wg, ll = _box(W * g, window) - mW * mg, _box(L * L, window) - mL * mL
    lw, lg = _box(L * W, window) - mL * mW, _box(L * g, window) - mL * mg
    ww, gg = np.maximum(ww, ROUNDING), np.maximum(gg, ROUNDING)
    det = np.maximum(ww * gg - wg * wg, ROUNDING**2)
    h, k = (lw * gg - lg * wg) / det, (lg * ww - lw * wg) / det
    n = window * window
    variance = np.maximum(ll - h * lw - k * lg, 0) / (n - 3) * ww / det
    slope = g - mg - wg / ww * (W - mW)
    residual = L - mL - h * (W - mW) - k * (g - mg)
    h = np.maximum(h, 0.2)
    return _Solution(np.clip(-k / h, -1, 1), variance / h**2, slope, residual)


def _inflation(
    found: _Solution, good: np.ndarray, window: int, method: str
) -> np.ndarray:
    """Factor of the variance for residuals that are not independent."""
    # The variance of sum g e is the sum of all covariances. A fit of three unknowns to
    # n residuals takes about 3/n from each
    slope, residual = (
        np.where(good, a, 0).astype(np.float32) for a in (found.slope, found.residual)
    )
    around = AROUND * window + 1
    gg, ee = (np.maximum(_box(a * a, around), ROUNDING) for a in (slope, residual))
    if method == "sgm":
        # Edges, curved ground and blur make residuals large where slopes are: blocks
        # nearby hold this, whatever it is (Newey and West 1987). The fit takes about
        # the share of a block in the window from it
        blocks = BLOCK**2 * _box(_box(slope * residual, BLOCK) ** 2, around)
        share = _box(good.astype(np.float32), around)
        return np.maximum(blocks * share / (gg * ee * (1 - (BLOCK / window) ** 2)), 0.5)
    # Interpolation correlates near neighbours: sigma^2 sum rho_e rho_g
    factor = np.ones_like(gg)
    for lag in LAGS:
        rho_g, rho_e = (
            _box(a * _neighbour(a, lag), around) / aa
            for a, aa in ((slope, gg), (residual, ee))
        )
        factor += 2 * rho_g * (rho_e + (2 + rho_g) / window**2)
    return np.maximum(factor, 0.5)


def _neighbour(a: np.ndarray, lag: tuple[int, int]) -> np.ndarray:
    """Value some rows and columns further; zero outside."""
    rows, columns = a.shape
    row, column = 2 + lag[0], 2 + lag[1]
    return np.pad(a, 2)[row : row + rows, column : column + columns]
