"""From points to their matches: cut, correlate, take the highest peak, judge it."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pgm_lab.ncc import _search
from pgm_lab.ncc._cut import inside, touching, windows
from pgm_lab.ncc._map import chunks, flat, surfaces
from pgm_lab.ncc._peak import paraboloid, peaks, systematic_errors

NOWHERE = -2.0  # below every correlation: not searched


@dataclass(frozen=True)
class Settings:
    """What `match` was told, the same for all points."""

    template: int
    search: tuple[int, int]
    threshold: float
    ratio: float
    refine: str | None
    distance: float
    noise: tuple[float, float]


@dataclass(frozen=True)
class Pairs:
    """n templates with their search windows; None for what needs no attention."""

    template: np.ndarray  # (n, t, t)
    absent: np.ndarray | None  # its pixels without data
    whole: np.ndarray  # (n, 2) the middle of the template
    window: np.ndarray  # (n, rows, columns)
    centre: np.ndarray  # (n, 2) the middle of the search window
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
        # Of the template's middle, which lies beside the point by the rest
        lines = lines + [0, 0, 1] * np.sum(lines[:, :2] * rest, axis=1)[:, None]
        start = _search.foot(start, lines)
    centre = np.floor(start + 0.5)
    status = np.full(len(points), "accepted", dtype="<U40")
    status[~_search.overlaps(centre, s.search, right.shape, s.template)] = (
        "window leaves the image"
    )
    status[~inside(whole, s.template, left.shape)] = "template leaves the image"
    r, second = np.full((2, len(points)), np.nan)
    found = np.full((len(points), 2), np.nan)
    covariance = np.full((len(points), 2, 2), np.nan)

    todo = np.flatnonzero(status == "accepted")
    for part in (todo[some] for some in chunks(len(todo), math.prod(s.search))):
        of_part = None if lines is None else lines[part]
        pairs = _pairs(left, right, whole[part], centre[part], of_part, s)
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
) -> Pairs:
    """Cut out the windows, and say which positions are searched.

    Those in the image, near the line, where all pixels hold data.
    """
    size, unknown, past = s.search, None, None
    if lines is not None:  # one pixel more, since the search may end beside the line
        size = size[0] + 2, size[1] + 2
    template, absent = windows(left, whole, (s.template, s.template))
    window, missing = windows(right, centre, size)
    column, row = _search.positions(centre, size, s.template)
    searched = _search.within(column, row, s.template, right.shape)
    if lines is not None:
        near = _search.near(column, row, lines, s.distance)
        rim = _search.rim(near.shape)
        searched &= near & ~rim
        past = near & rim
    if missing is not None:
        unknown = touching(missing, s.template)
    return Pairs(
        template, absent, whole, window, centre, searched, unknown, past, lines
    )


def _status_of_windows(pairs: Pairs) -> np.ndarray:
    """Why a map cannot be made, or "accepted"."""
    status = np.full(len(pairs.whole), "accepted", dtype="<U40")
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
    maps = surfaces(pairs.template, pairs.window)
    searched = pairs.searched
    if pairs.unknown is not None:
        searched = searched & ~pairs.unknown
    row, column, r, second = peaks(
        maps if searched.all() else np.where(searched, maps, NOWHERE)
    )
    middle = np.array(maps.shape[:0:-1]) // 2
    place = pairs.centre + np.stack([column, row], axis=1) - middle
    edge = ~inside(place, s.template + 2, right.shape)
    if pairs.unknown is not None:
        edge |= _search.beside(pairs.unknown, row, column)
    if pairs.past is None:
        border = _search.rim(maps.shape)[row, column]
    else:
        border = _search.beside(pairs.past, row, column)

    every = sliding_window_view(pairs.window, (s.template, s.template), axis=(1, 2))
    matched = every[np.arange(len(r)), row, column]
    even = flat(matched)
    matched[even] = pairs.template[even]  # it has no contrast that noise has a share of
    line = None
    if pairs.lines is not None:
        line = pairs.lines[:, :2], _search.distance(place, pairs.lines), s.distance
    step, Q, ridge, along = paraboloid(
        maps, row, column, pairs.template, matched, s.noise, line
    )
    step[border | edge | ridge | (s.refine is None)] = 0.0
    if s.refine is None:
        Q += np.eye(2) / 12
    else:
        wider = _surroundings(left, pairs)
        for error in systematic_errors(pairs.template, wider, step, along):
            Q += error[:, :, None] * error[:, None, :]

    status = np.full(len(r), "accepted", dtype="<U40")
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
    wider, missing = windows(left, pairs.whole, (size, size))
    if missing is None:
        return wider
    edge = np.pad(pairs.template, ((0, 0), (1, 1), (1, 1)), mode="edge")
    return np.where(missing, edge, wider)
