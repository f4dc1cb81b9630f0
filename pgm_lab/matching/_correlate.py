"""Correlation of windows that are turned and scaled against each other."""

from typing import Any

import numpy as np

from pgm_lab import ncc
from pgm_lab.matching._canvas import canvas

AT_ONCE = 4_000_000  # pixels of a canvas: its memory does not grow with the points
RIM = 2  # pixels of a part beyond what is searched, which refinement looks at


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

    `start` (n, 2), `shape` (n, 2, 2) and `lines` (n, 3) belong to the right photo, and
    so do the positions that are found; `search`, and what the limits count in pixels,
    to the left one.
    """
    if not len(points):
        return ncc.match(left, right, points, start, template, search, **limits)
    if lines is not None:
        lines, start = _on_lines(lines, start)
    chunk = max(1, AT_ONCE // search**2)
    parts = [
        _of_canvas(
            *(left, right, points[k], start[k], shape[k], template, search),
            None if lines is None else lines[k],
            limits,
        )
        for k in (slice(i, i + chunk) for i in range(0, len(points), chunk))
    ]
    return ncc.Match(*map(np.concatenate, zip(*(vars(one).values() for one in parts))))


def _on_lines(lines: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lines with normals of length one, and the nearest points on them."""
    lines = lines / np.hypot(lines[:, 0], lines[:, 1])[:, None]
    away = np.sum(lines[:, :2] * start, axis=1) + lines[:, 2]
    return lines, start - away[:, None] * lines[:, :2]


def _of_canvas(
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
    """Find points that all have room in one canvas."""
    size = search + 2 * RIM
    middle = np.full((len(points), 2), size // 2)
    middle[:, 1] += np.arange(len(points)) * size
    if lines is not None:
        normal = np.einsum("ni,nij->nj", lines[:, :2], shape)
        # The line runs through the middle
        lines = np.column_stack([normal, -np.sum(normal * middle, axis=1)])
    grey = canvas(right, start, shape, size)
    found = ncc.match(
        left, grey, points, middle, template, search,
        refine="parabola", lines=lines, **limits,
    )  # fmt: skip
    # Beyond the photo the canvas has no data
    reach = template // 2 * np.abs(shape).sum(axis=2)
    last = np.array(right.shape[::-1]) - 1
    leaves = np.any((start < reach) | (start + reach > last), axis=1)
    status = np.where(
        leaves & (found.status == "no data in the window"),
        "window leaves the image",
        found.status,
    )
    return ncc.Match(
        points=start + np.einsum("nij,nj->ni", shape, found.points - middle),
        r=found.r,
        second=found.second,
        covariance=shape @ found.covariance @ np.swapaxes(shape, 1, 2),
        status=status,
    )
