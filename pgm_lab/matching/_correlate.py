"""Correlation of windows that are rotated and scaled against each other.

The right photo is resampled around each start to the geometry of the left one: parts of
a canvas, one below the other, in which `ncc.match` finds the points.
"""

from typing import Any

import cv2
import numpy as np

from pgm_lab import ncc
from pgm_lab.ncc.search_area import foot

MAX_CANVAS = 4_000_000  # pixels: its memory does not grow with the points
RIM = 2  # pixels of a part beyond the search, which refinement needs
# Pixels of the right photo per pixel of the left: from this number they are smoothed,
# and up to this one
MIN_SMOOTHED, MAX_SMOOTHED = 1.2, 10.0


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
    """Find points by `ncc.match` in the right photo, resampled like the left one."""
    # `start` (n, 2), `shape` (n, 2, 2) and `lines` (n, 3) belong to the right photo,
    # and so do the positions that are found; `search`, and limits in pixels, to the
    # left one.
    if not len(points):
        return ncc.match(left, right, points, start, template, search, **limits)
    if lines is not None:
        lines = lines / np.hypot(lines[:, 0], lines[:, 1])[:, None]
        start = foot(start, lines)
    size = search + 2 * RIM

    def of_canvas(k: slice) -> ncc.Match:
        """Points that all fit in one canvas."""
        p, x, A, along = points[k], start[k], shape[k], None
        middle = np.full((len(p), 2), size // 2)
        middle[:, 1] += np.arange(len(p)) * size
        if lines is not None:
            normal = np.einsum("ni,nij->nj", lines[k, :2], A)
            # The line runs through the centre
            along = np.column_stack([normal, -np.sum(normal * middle, axis=1)])
        found = ncc.match(
            left, canvas(right, x, A, size), p, middle, template, search,
            refine="parabola", lines=along, **limits,
        )  # fmt: skip
        # Beyond the photo the canvas has no data
        reach = template // 2 * np.abs(A).sum(axis=2)
        last = np.array(right.shape[::-1]) - 1
        leaves = np.any((x < reach) | (x + reach > last), axis=1)
        leaves &= found.status == "no data in the window"
        return ncc.Match(
            points=x + np.einsum("nij,nj->ni", A, found.points - middle),
            r=found.r,
            second=found.second,
            covariance=A @ found.covariance @ np.swapaxes(A, 1, 2),
            status=np.where(leaves, "window leaves the image", found.status),
        )

    chunk = max(1, MAX_CANVAS // search**2)
    parts = [of_canvas(slice(i, i + chunk)) for i in range(0, len(points), chunk)]
    return ncc.Match(*map(np.concatenate, zip(*(vars(one).values() for one in parts))))


# --- The canvas ---


def canvas(
    image: np.ndarray, start: np.ndarray, shape: np.ndarray, size: int
) -> np.ndarray:
    """Square parts (n size, size) of an image, rotated and scaled, in a column."""
    # `start` (n, 2) are their centres, `shape` (n, 2, 2) maps an offset in the canvas
    # to one in the image, `size` is odd. NaN where the image has no grey values.
    half = size // 2
    offset = np.arange(-half, half + 1)
    v, u = np.meshgrid(offset, offset, indexing="ij")
    parts = np.full((len(start), size, size), np.nan, np.float32)
    reach = half * np.abs(shape).sum(axis=2) + 2  # of the corners, (n, 2)
    first = np.floor(np.clip(start - reach, 0, image.shape[::-1])).astype(int)
    end = np.ceil(np.clip(start + reach + 1, 0, image.shape[::-1])).astype(int)
    for i, (a, b) in enumerate(shape):
        (left, top), (right, bottom) = first[i], end[i]
        if min(right - left, bottom - top) < 2:
            continue
        part = np.ma.asarray(image[top:bottom, left:right]).astype(np.float32)
        part = _smoothed(np.ma.filled(part, np.nan), shape[i])
        x = start[i, 0] - left + a[0] * u + a[1] * v
        y = start[i, 1] - top + b[0] * u + b[1] * v
        parts[i] = cv2.remap(
            part,
            x.astype(np.float32),
            y.astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float("nan"),
        )
    return parts.reshape(-1, size)


def _smoothed(part: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """The part without detail too fine for the left photo."""
    scale = min(np.sqrt(abs(np.linalg.det(shape))), MAX_SMOOTHED)
    if scale < MIN_SMOOTHED:
        return part
    return cv2.GaussianBlur(part, (0, 0), 0.5 * np.sqrt(scale**2 - 1))
