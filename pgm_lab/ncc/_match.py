"""Many points of the left image found in the right one by normalized correlation."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._statuses import Matched
from pgm_lab.ncc import search_area
from pgm_lab.ncc._map import flat
from pgm_lab.ncc._peak import paraboloid, systematic_errors
from pgm_lab.ncc._search import deviations, peaks

AT_ONCE = 2**20  # grey values of the search windows that are searched at a time
STATUS = "<U40"


@dataclass(frozen=True)
class Match(Matched):
    """Points of the left image found in the right one.

    Attributes
    ----------
    points : ndarray (n, 2)
        (column, row) in the right image, in pixels: the highest peak of each
        correlation map, even if it was not accepted; NaN where there is no map.
    r : ndarray (n,)
        Correlation at the highest whole pixel; NaN where there is no map.
    second : ndarray (n,)
        Correlation at the second peak, the highest that does not touch the first; -1 if
        there is none.
    covariance : ndarray (n, 2, 2)
        Of the position, in square pixels; NaN unless the status is "accepted".
    status : ndarray (n,) of str
        "accepted", or what went wrong first: one of `matching.STATUSES`, which
        explains it.
    """

    points: np.ndarray
    r: np.ndarray
    second: np.ndarray
    covariance: np.ndarray
    status: np.ndarray


def match(
    left: ArrayLike,
    right: ArrayLike,
    points: ArrayLike,
    start: ArrayLike | None = None,
    template: int = 21,
    search: int | tuple[int, int] = 51,
    threshold: float = 0.7,
    ratio: float = 0.9,
    refine: str | None = None,
    *,
    lines: ArrayLike | None = None,
    distance: float = 1.5,
    back: float | None = None,
) -> Match:
    """Find points of the left image in the right one, all in one call.

    The template is cut out around each left point, the search window around its start;
    the match is where `correlation_map` is highest.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values, 8 or 16 bit or float. Pixels without data may be masked, NaN or
        infinite: templates that touch them get a status, and in the right image only
        positions that do not touch them are searched.
    points : array_like (n, 2)
        (column, row) in the left image. The template lies around the nearest whole
        pixel; the fraction that was rounded off is added to the result.
    start : array_like (n, 2), optional
        Where to search in the right image, rounded likewise; default: at `points`.
    template : int
        Width of the square template in pixels, odd.
    search : int or (int, int)
        Width of the square search window in pixels, odd, or its (rows, columns).
    threshold : float
        Smallest r that counts as matched.
    ratio : float
        A match is ambiguous if the second peak is higher than this fraction of the
        first; 1 switches this test off.
    refine : None or "parabola"
        Whole pixels, or the top of the paraboloid through the peak and its eight
        neighbours, biased towards whole and half pixels by a few hundredths of one.
    lines : array_like (n, 3), optional
        An epipolar line a column + b row + c = 0 in the right image for each point:
        only positions near it are searched, around the one nearest to the start. Where
        an edge crosses the line, the match is their intersection, and its covariance
        allows for an error of the line up to `distance`.
    distance : float
        Largest distance from its line, in pixels, at least 0.5.
    back : float, optional
        If given, each match is searched for again in the left image (left-right check,
        along a parallel to its line) and has to end within this distance of its point,
        in pixels; 1 is usual. Most points that only one photo sees fail.

    Returns
    -------
    Match

    Raises
    ------
    ValueError
        If an image, a point or a parameter is not as described here.

    Notes
    -----
    Where the rows of both photos are epipolar lines (the normal case of stereo), many
    points are best found with small templates, each along its row, and with the
    left-right check; `start` is at the middle of the range of parallaxes, `columns`
    wide enough for all::

        row = points[:, 1]
        match(left, right, points, start, 9, (11, columns), 0.7, 0.95, "parabola",
              lines=np.column_stack([0 * row, 0 * row + 1, -row]), distance=0.5,
              back=0.75)

    The covariance is K^-1 S K^-1 with the curvature K of the map at its peak and the
    covariance S of its slope, from white noise, equal in both images. Of n pixels,
    n S = (p (1 - q) + q (1 - p)) G + p q I, with the shares p and q of noise in the
    variances of the two windows, from (1 - p)(1 - q) = r^2, and G = sum(g gᵀ) /
    sum((t - mean)^2) of the gradients g of the window that has less noise. For whole
    pixels rounding adds 1/12 px^2; for the parabola the squares of its two systematic
    errors are added, which remain in the position: the offset that it finds for the
    template in its own image, and pixel locking. Mismatches are not accounted for, nor
    windows that differ in more than noise and shift.

    References
    ----------
    Bani 2010, II.1.2.1.1 and (B 2.6f); Foerstner 1982 for the precision.

    Examples
    --------
    >>> left = np.random.default_rng(1).integers(0, 256, (100, 100), dtype=np.uint8)
    >>> right = np.roll(left, (3, -5), axis=(0, 1))
    >>> found = match(left, right, [(50, 50), (60.25, 48), (3, 50)])
    >>> found.points
    array([[45.  , 53.  ],
           [55.25, 51.  ],
           [  nan,   nan]])
    >>> found.status[[0, 2]]
    array(['accepted', 'template leaves the image'], dtype='<U40')
    """
    left = _validate.grey_image(left, "left")
    right = _validate.grey_image(right, "right")
    points = _validate.point_list(points, "points")
    if start is None:
        start = points
    start = _validate.point_list(start, "start", len(points))
    template = _validate.window(template, "template")
    search = _size(search, template)
    threshold = _validate.between(threshold, "threshold", -1, 1)
    if not 0 < _validate.number(ratio, "ratio") <= 1:
        raise ValueError(f"ratio must be above 0 and at most 1; got {ratio}")
    if refine is not None:
        _validate.choice(refine, "refine", ("parabola",))
    if lines is not None:
        lines = _normal_form(lines, len(points))
    settings = Settings(template, search, threshold, ratio, refine, _width(distance))
    found, r, second, covariance, status = find(
        left, right, points, start, lines, settings
    )
    if back is not None:
        back = _validate.positive_number(back, "back", "px")
        k = np.flatnonzero(status == "accepted")
        if lines is not None:
            lines = search_area.through(points, lines)[k]
        home, *_ = find(right, left, found[k], points[k], lines, settings)
        returned = np.hypot(*(home - points[k]).T) <= back
        status[k[~returned]] = "left-right check failed"
    covariance[status != "accepted"] = np.nan
    return Match(found, r, second, covariance, status)


# --- Argument validation ---


def _width(distance: float) -> float:
    """Half the width of the band that is searched along a line."""
    if _validate.number(distance, "distance") < 0.5:
        raise ValueError(
            "distance must be at least 0.5 px, or a line could run between two rows of"
            f" pixels; got {distance:g}"
        )
    return float(distance)


def _size(search: int | tuple[int, int], template: int) -> tuple[int, int]:
    """Rows and columns of the search window."""
    given = search if isinstance(search, tuple | list) else (search, search)
    if len(given) != 2:
        raise ValueError(
            "search must be one number or (rows, columns); got"
            f" {_validate.shown(search)}"
        )
    rows, columns = (_validate.window(one, "search") for one in given)
    if min(rows, columns) < template + 2:
        raise ValueError(
            f"search must be at least template + 2 = {template + 2}, or there is"
            f" nothing to search; got {search}"
        )
    return rows, columns


def _normal_form(lines: ArrayLike, n: int) -> np.ndarray:
    """Lines (n, 3) with normals (a, b) of length one."""
    array = _validate.of_shape(lines, (n, 3), "lines")
    length = np.hypot(array[:, 0], array[:, 1])
    _validate.refuse(length == 0, "lines{} have a = b = 0: they are not lines")
    return array / length[:, None]


# --- From points to their matches ---


@dataclass(frozen=True)
class Settings:
    """Arguments of `match` that are the same for all points."""

    template: int
    search: tuple[int, int]
    threshold: float
    ratio: float
    refine: str | None
    distance: float


@dataclass(frozen=True)
class Pairs:
    """n templates with their search windows; None where there is none."""

    template: np.ndarray  # (n, t, t)
    absent: np.ndarray | None  # its pixels without data
    whole: np.ndarray  # (n, 2) the centre of the template
    window: np.ndarray  # (n, rows, columns)
    ssd: np.ndarray | None  # of the windows at the positions of a correlation map
    centre: np.ndarray  # (n, 2) the centre of the search window
    searched: np.ndarray  # the positions to look at, of a correlation map
    unknown: np.ndarray | None  # those that touch pixels without data
    past: np.ndarray | None  # those on the line, but beyond the search window
    lines: np.ndarray | None  # (n, 3)

    def part(self, some: np.ndarray) -> Self:
        """Some of the pairs."""
        if some.all():
            return self
        arrays = {k: v[some] for k, v in vars(self).items() if v is not None}
        return replace(self, **arrays)


def find(
    left: np.ndarray,
    right: np.ndarray,
    points: np.ndarray,
    start: np.ndarray,
    lines: np.ndarray | None,
    s: Settings,
) -> tuple[np.ndarray, ...]:
    """Points, r, second, covariance and status, as in `Match`."""
    whole = np.floor(points + 0.5)
    rest = points - whole
    if lines is not None:
        # For the template's centre, which is offset from the point by the rest
        lines = lines + [0, 0, 1] * np.sum(lines[:, :2] * rest, axis=1)[:, None]
        start = search_area.foot(start, lines)
    centre = np.floor(start + 0.5)
    status = np.full(len(points), "accepted", dtype=STATUS)
    status[~search_area.overlaps(centre, s.search, right.shape, s.template)] = (
        "window leaves the image"
    )
    inside = search_area.inside(whole, s.template, left.shape)
    status[~inside] = "template leaves the image"
    r, second = np.full((2, len(points)), np.nan)
    found = np.full((len(points), 2), np.nan)
    covariance = np.full((len(points), 2, 2), np.nan)

    todo = np.flatnonzero(status == "accepted")
    ssd = deviations(right, s.template, len(todo) * math.prod(s.search))
    step = max(1, AT_ONCE // math.prod(s.search))
    for part in (todo[i : i + step] for i in range(0, len(todo), step)):
        of_part = None if lines is None else lines[part]
        pairs = _pairs(left, right, whole[part], centre[part], of_part, s, ssd)
        status[part] = _status_of_windows(pairs)
        good = status[part] == "accepted"
        if good.any():
            part = part[good]
            place, r[part], second[part], covariance[part], status[part] = _matched(
                left, right, pairs.part(good), s
            )
            found[part] = place + rest[part]
    return found, r, second, covariance, status


def _pairs(
    left: np.ndarray,
    right: np.ndarray,
    whole: np.ndarray,
    centre: np.ndarray,
    lines: np.ndarray | None,
    s: Settings,
    ssd: np.ndarray | None,
) -> Pairs:
    """Cut out the windows; `searched`: in the image, near the line, with data."""
    size, unknown, past = s.search, None, None
    if lines is not None:  # one pixel more, since the search may end beside the line
        size = size[0] + 2, size[1] + 2
    template, absent = search_area.windows(left, whole, (s.template, s.template))
    window, missing = search_area.windows(right, centre, size)
    if ssd is not None:
        positions = size[0] - s.template + 1, size[1] - s.template + 1
        ssd = search_area.cut_out(ssd, centre - s.template // 2, positions)
    column, row = search_area.positions(centre, size, s.template)
    searched = search_area.within(column, row, s.template, right.shape)
    if lines is not None:
        near = search_area.near(column, row, lines, s.distance)
        rim = search_area.rim(near.shape)
        searched &= near & ~rim
        past = near & rim
    if missing is not None:
        unknown = search_area.touching(missing, s.template)
    return Pairs(
        *(template, absent, whole, window, ssd, centre),
        *(searched, unknown, past, lines),
    )


def _status_of_windows(pairs: Pairs) -> np.ndarray:
    """Why a map cannot be made, or "accepted"."""
    status = np.full(len(pairs.whole), "accepted", dtype=STATUS)
    status[flat(pairs.window)] = "flat window"
    status[flat(pairs.template)] = "flat template"
    if pairs.unknown is not None:
        known = np.any(pairs.searched & ~pairs.unknown, axis=(1, 2))
        status[~known] = "no data in the window"
    if pairs.absent is not None:
        status[pairs.absent.any(axis=(1, 2))] = "no data in the template"
    status[~pairs.searched.any(axis=(1, 2))] = "window leaves the image"
    return status


def _matched(
    left: np.ndarray, right: np.ndarray, pairs: Pairs, s: Settings
) -> tuple[np.ndarray, ...]:
    """Position, r, second, covariance and status of pairs that have maps."""
    searched = pairs.searched
    if pairs.unknown is not None:
        searched = searched & ~pairs.unknown
    peak = peaks(pairs.template, pairs.window, searched, pairs.ssd)
    row, column, r, second = peak.row, peak.column, peak.r, peak.second
    middle = np.array(searched.shape[:0:-1]) // 2
    place = pairs.centre + np.stack([column, row], axis=1) - middle
    edge = ~search_area.inside(place, s.template + 2, right.shape)
    if pairs.unknown is not None:
        edge |= search_area.beside(pairs.unknown, row, column)
    if pairs.past is None:
        border = search_area.rim(searched.shape)[row, column]
    else:
        border = search_area.beside(pairs.past, row, column)

    even = flat(peak.right)
    peak.right[even] = peak.left[even]  # no contrast, so no share of noise in it
    line = None
    if pairs.lines is not None:
        line = pairs.lines[:, :2], search_area.distance(place, pairs.lines), s.distance
    step, Q, ridge, along = paraboloid(peak, line)
    step[border | edge | ridge | (s.refine is None)] = 0.0
    if s.refine is None:
        Q += np.eye(2) / 12
    else:
        wider = _surroundings(left, pairs)
        for error in systematic_errors(pairs.template, wider, step, along):
            Q += error[:, :, None] * error[:, None, :]

    status = np.full(len(r), "accepted", dtype=STATUS)
    status[ridge] = "position not determined"
    status[second > s.ratio * r] = "ambiguous"
    status[r < s.threshold] = "below threshold"
    status[border] = "peak on the border of the search"
    status[edge] = "peak on the edge of the image"
    status[even] = "flat window"
    return place + step, r, second, Q, status


def _surroundings(left: np.ndarray, pairs: Pairs) -> np.ndarray:
    """The templates with one pixel more on each side, repeated where there is none."""
    size = pairs.template.shape[1] + 2
    wider, missing = search_area.windows(left, pairs.whole, (size, size))
    if missing is None:
        return wider
    edge = np.pad(pairs.template, ((0, 0), (1, 1), (1, 1)), mode="edge")
    return np.where(missing, edge, wider)
