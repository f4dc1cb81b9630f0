"""The highest peaks of many correlation maps: searched quickly, computed exactly.

The search is in single precision, whose error is bounded; where that could decide
which position is the highest, the exact map is made instead. The values at the peaks
are always computed in double precision.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from pgm_lab.ncc._map import (
    box_sums,
    centred,
    chunks,
    exact_maps,
    exponents,
    few,
    inner,
    products,
)

NOWHERE = -2.0  # below every correlation: not searched
# Error of a map in single precision, per energy of the search window relative to that
# of its faintest window
ERROR = 4 * 2.0**-23
FAINT = 1e-6  # of the search window's energy; below it no error bound is known
TINY = np.float32(1e-15)  # energy that single precision cannot represent well
LARGEST = 2**24  # pixels of an image whose windows are summed up all at once


@dataclass(frozen=True)
class Peaks:
    """The highest values of k correlation maps, and what is known of them."""

    row: np.ndarray
    column: np.ndarray
    r: np.ndarray
    second: np.ndarray  # the next highest peak, -1 if there is none
    near: np.ndarray  # (k, 3, 3) r around the peak, or its neighbour off the map's rim
    left: np.ndarray  # both windows, centred, to one scale
    right: np.ndarray


def peaks(
    templates: np.ndarray,
    searches: np.ndarray,
    searched: np.ndarray,
    ssd: np.ndarray | None,
) -> Peaks:
    """Highest correlations of templates (k, h, w), none flat, where `searched`."""
    # Search in single precision
    found, error = _rough_maps(templates, searches, ssd)
    if not searched.all():
        found[:, :-1][~searched] = NOWHERE
    first, other, second = _highest(found)

    # Search again in exact maps where rounding could decide
    unsure = np.flatnonzero(_lead(found, first) <= 2 * error)
    for k in (unsure[part] for part in chunks(len(unsure), searches[0].size)):
        exact = np.full((len(k), *found.shape[1:]), -1.0)
        exact[:, :-1] = np.where(
            searched[k], exact_maps(templates[k], searches[k]), NOWHERE
        )
        first[k], other[k], second[k] = _highest(exact)

    # Compute exactly what was found
    k, h, w = templates.shape
    (row, column), (last_row, last_column) = first.T, np.array(found.shape[1:]) - (2, 1)
    above = np.clip(row - 1, 0, last_row - 2)
    beside = np.clip(column - 1, 0, last_column - 2)
    patches = _cut(searches, above, beside, (h + 2, w + 2))
    scale = None
    if searches.dtype.kind == "f" or templates.dtype.kind == "f":
        scale = np.maximum(exponents(templates), exponents(patches))
    left, right = centred(templates, scale), centred(patches, scale)
    near = few(left, right, patches)
    i, j = row - above, column - beside
    right = _cut(right, i, j, (h, w))
    right -= (np.add.reduce(right.reshape(k, -1), axis=1) / (h * w))[:, None, None]
    some = second > -1
    windows = _cut(searches, other[:, 0], other[:, 1], (h, w))
    second = np.where(some, _coefficients(left, windows), -1)
    r = near[np.arange(k), i, j]
    return Peaks(row, column, r, second, near, left, right)


def deviations(image: np.ndarray, size: int, most: int) -> np.ndarray | None:
    """Sums of squares of all windows of an image, each minus its mean, or None."""
    # Sums of 8 and 16 bit are whole numbers, so that none is rounded. Worth it where
    # the image has fewer pixels than its search windows together.
    small = image.dtype.kind in "uib" and image.dtype.itemsize <= 2
    if not small or image.size > min(most, LARGEST):
        return None
    g = np.ma.getdata(image).astype(np.float32)
    g -= float(np.rint(g.mean()))
    total, squares = (
        sums(g, cv2.CV_64F, (size, size), normalize=False)
        for sums in (cv2.boxFilter, cv2.sqrBoxFilter)
    )
    half = size // 2
    ssd = squares - total * (total / size**2)
    return ssd[half:-half, half:-half].astype(np.float32)


def _rough_maps(
    templates: np.ndarray, searches: np.ndarray, squares: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Maps (k, rows + 1, columns) in single precision, bounds (k,) of their errors."""
    # A row of -1 below each map keeps it apart from the next one
    (k, H, W), (h, w) = searches.shape, templates.shape[1:]
    found = np.full((k, H - h + 2, W - w + 1), -1, np.float32)
    error = np.empty(k)
    for part in chunks(k, H * W):
        t, s = _single(templates[part]), _single(searches[part])
        if squares is not None:
            ssd = squares[part]
        else:
            ssd = box_sums(s, h, w)
            ssd *= ssd
            ssd *= -1 / (h * w)
            ssd += box_sums(s * s, h, w)
        t_energy, energy = inner(t, t), inner(s, s)
        faintest = ssd.min(axis=(1, 2))
        known = (faintest > FAINT * energy) & (np.minimum(t_energy, energy) > TINY)
        ratio = energy / np.where(known, faintest, 1)
        error[part] = np.where(known, ERROR * ratio, np.inf)
        ssd = np.maximum(ssd, (FAINT * energy)[:, None, None])
        ssd *= t_energy[:, None, None]
        np.maximum(ssd, TINY**2, out=ssd)
        np.divide(products(t, s), np.sqrt(ssd, out=ssd), out=found[part, :-1])
    return found, error


def _single(windows: np.ndarray) -> np.ndarray:
    """Centred windows in single precision, centred before digits can be lost."""
    if windows.dtype.kind in "uib" and windows.dtype.itemsize <= 2:
        g = windows.astype(np.float32).reshape(len(windows), -1)
        g -= (np.add.reduce(g, axis=1) / np.float32(g.shape[1]))[:, None]
        return g.reshape(windows.shape)
    return centred(windows).astype(np.float32)


def _highest(maps: np.ndarray) -> tuple[np.ndarray, ...]:
    """Positions (k, 2) of the highest peak and of the second; its value, -1 if none."""
    # A peak is no lower than its eight neighbours; the second is none of the first's
    k, rows, columns = maps.shape
    at = np.arange(k)
    highest = maps.reshape(k, -1).argmax(axis=1)
    row, column = np.divmod(highest, columns)
    around = cv2.dilate(maps.reshape(-1, columns), np.ones((3, 3), np.uint8))
    others = np.where(maps >= around.reshape(maps.shape), maps, -1)
    beside = np.arange(-1, 2)
    others[
        at[:, None, None],
        np.clip(row[:, None, None] + beside[:, None], 0, rows - 1),
        np.clip(column[:, None, None] + beside, 0, columns - 1),
    ] = -1
    other = others.reshape(k, -1).argmax(axis=1)
    second = np.maximum(others.reshape(k, -1)[at, other], -1).astype(float)
    first = np.column_stack([row, column])
    return first, np.column_stack(np.divmod(other, columns)), second


def _lead(maps: np.ndarray, first: np.ndarray) -> np.ndarray:
    """By how much the highest value of each map is above all others."""
    at = np.arange(len(maps)), first[:, 0], first[:, 1]
    highest = maps[at]
    maps[at] = NOWHERE
    lead = highest - maps.max(axis=(1, 2))
    maps[at] = highest
    return lead


def _cut(
    images: np.ndarray, row: np.ndarray, column: np.ndarray, size: tuple[int, int]
) -> np.ndarray:
    """The window of each image whose first pixel is given."""
    every = sliding_window_view(images, size, axis=(1, 2))
    return every[np.arange(len(images)), row, column]


def _coefficients(left: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Correlations (k,) of centred left windows with others; 0 where one is flat."""
    b = centred(windows)
    b -= b.mean(axis=(1, 2), keepdims=True)  # again, since the first mean was rounded
    norm = np.sqrt(inner(left, left) * inner(b, b))
    return np.divide(inner(left, b), norm, out=np.zeros(len(b)), where=norm > 0)
