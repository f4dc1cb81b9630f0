"""Correlation of windows that are turned and scaled against each other."""

from dataclasses import replace
from typing import Any

import numpy as np

from pgm_lab import ncc
from pgm_lab.matching._canvas import canvas

AT_ONCE = 4_000_000  # pixels of a canvas: its memory does not grow with the points


def correlate(
    left: np.ndarray,
    right: np.ndarray,
    points: np.ndarray,
    start: np.ndarray,
    shape: np.ndarray,
    template: int,
    search: int,
    lines: np.ndarray | None = None,
    **limits: Any,
) -> ncc.Match:
    """Find points by `ncc.match` in a right photo that is turned as the left one is.

    `start` (n, 2), `shape` (n, 2, 2) and `lines` (n, 3) belong to the right photo,
    search and what the limits count in pixels to the left one. The positions found are
    in the right photo.
    """
    chunk = max(1, AT_ONCE // search**2)
    parts = []
    for first in range(0, len(points), chunk):
        k = slice(first, first + chunk)
        of_part = None if lines is None else lines[k]
        parts.append(
            _one_canvas(
                left,
                right,
                points[k],
                start[k],
                shape[k],
                template,
                search,
                of_part,
                limits,
            )
        )
    if not parts:
        parts = [
            _one_canvas(
                left, right, points, start, shape, template, search, lines, limits
            )
        ]
    return ncc.Match(
        *(np.concatenate(v) for v in zip(*(vars(p).values() for p in parts)))
    )


def _one_canvas(
    left: np.ndarray,
    right: np.ndarray,
    points: np.ndarray,
    start: np.ndarray,
    shape: np.ndarray,
    template: int,
    search: int,
    lines: np.ndarray | None,
    limits: dict[str, Any],
) -> ncc.Match:
    n = len(points)
    grey = canvas(right, start, shape, search)
    nan = np.isnan(grey).reshape(n, -1)
    grey = grey.reshape(n, -1)
    fill = np.where(
        nan.all(axis=1),
        0,
        np.nan_to_num(grey).sum(axis=1) / np.maximum(1, (~nan).sum(axis=1)),
    )
    grey = np.where(nan, fill[:, None], grey).reshape(-1, search)
    middle = np.full((n, 2), search // 2)
    middle[:, 1] += np.arange(n) * search
    offset = points - np.floor(points + 0.5)
    found = ncc.match(
        left,
        grey,
        points,
        middle,
        template,
        search,
        refine="parabola",
        lines=None if lines is None else _of_canvas(lines, start, shape, middle),
        **limits,
    )
    away = found.points - middle - offset
    # TODO: without data
    status = found.status.copy()
    t = template // 2
    ok = np.flatnonzero(np.isfinite(away[:, 0]))
    bad = nan.reshape(n, search, search)
    for i in ok:
        c, r = np.rint(away[i]).astype(int) + search // 2
        if (
            status[i] == "accepted"
            and bad[i, max(0, r - t) : r + t + 1, max(0, c - t) : c + t + 1].any()
        ):
            status[i] = "peak on the edge of the image"
    status[nan.all(axis=1)] = "window leaves the image"
    position = start + np.einsum("nij,nj->ni", shape, found.points - middle)
    covariance = shape @ found.covariance @ np.swapaxes(shape, 1, 2)
    covariance[status != "accepted"] = np.nan
    return replace(found, points=position, covariance=covariance, status=status)


def _of_canvas(
    lines: np.ndarray, start: np.ndarray, shape: np.ndarray, middle: np.ndarray
) -> np.ndarray:
    """Lines of the right photo in the canvas."""
    normal = np.einsum("ni,nij->nj", lines[:, :2], shape)
    c = lines[:, 2] + np.sum(lines[:, :2] * start, axis=1)
    return np.c_[normal, c - np.sum(normal * middle, axis=1)]
