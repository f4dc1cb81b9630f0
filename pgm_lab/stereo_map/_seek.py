"""Where to look for a left point: predicted, then narrowed from coarse to fine."""

from dataclasses import dataclass

import numpy as np

from pgm_lab import ncc
from pgm_lab.stereo_map import _rays

AT_FIRST = 100  # px to each side at the level where a wide search begins
STEP = 4  # px to each side at the levels below it
LAST = 20  # px to each side in the photo itself
MOST = 400_000  # pixels of a search window
SMALLEST = 11  # pixels across a template at a coarse level
LEAST = 0.5  # correlation that leads on to the next level
TURN = 6  # points from which on they tell more than a shift
FEW, SOME = 0.15, 0.08  # of the photo's width: how far they may mislead, before, then


@dataclass(frozen=True, eq=False)
class Area:
    """Part of the right photo where a point is sought.

    Attributes
    ----------
    centre, half : ndarray (2,)
        Middle, and pixels to each side, (columns, rows).
    curve : ndarray (k, 2) or None
        The epipolar curve; only what is near it is searched.
    distance : float
        Largest distance from the curve, in pixels.
    reason : str
        Where the prediction comes from, in words.
    """

    centre: np.ndarray
    half: np.ndarray
    curve: np.ndarray | None
    distance: float
    reason: str


def around(
    chosen: np.ndarray, found: np.ndarray, pixel: np.ndarray, size: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Predict a place and its reach from points (n, 2) chosen left and found right.

    The affine transformation that fits them best; their mean shift with fewer than six.
    """
    n, width = len(chosen), max(size)
    if n == 0:
        return (np.array(size) - 1) / 2, np.array(size) / 2
    middle = chosen.mean(axis=0)
    A = np.column_stack([np.ones(n), chosen - middle])[:, : 3 if n >= TURN else 1]
    x, *_ = np.linalg.lstsq(A, found - chosen, rcond=1e-6)
    rest = np.hypot(*(found - chosen - A @ x).T)
    place = np.concatenate([[1.0], pixel - middle])[: A.shape[1]]
    share = SOME if n >= TURN else FEW
    return pixel + place @ x, np.full(2, max(share * width, 3 * rest.max()))


def narrow(
    left: list[np.ndarray],
    right: list[np.ndarray],
    pixel: np.ndarray,
    area: Area,
    template: int,
) -> np.ndarray:
    """Place (2,) in the right photo, to a few pixels, by correlation level by level."""
    wide = float(np.max(area.half))
    if wide <= LAST:
        return area.centre
    coarsest = min(len(left), len(right)) - 1
    first = max(int(np.ceil(np.log2(wide / AT_FIRST))), 1)
    place, half = area.centre, area.half
    for k in range(min(first, coarsest), 0, -1):
        step = 2.0**k
        size = _fitting(left[k], pixel / step, template)
        if size < SMALLEST:  # too near to the edge for this level
            continue
        columns, rows = (2 * np.ceil(half / step).astype(int) + size).tolist()
        along = {} if area.curve is None else _along(area, place, step)
        found = ncc.match(
            left[k], right[k], pixel[None] / step, place[None] / step, size,
            (rows, columns), LEAST, 1.0, **along,
        )  # fmt: skip
        if found.r[0] >= LEAST:
            place, half = found.points[0] * step, np.full(2, STEP * step / 2)
        elif 4 * columns * rows > MOST:  # else a finer level may tell
            break
    return place


def _fitting(image: np.ndarray, pixel: np.ndarray, template: int) -> int:
    """Largest odd template up to a size that lies in the image around a pixel."""
    nearest = np.floor(pixel + 0.5)
    room = np.min([nearest, np.array(image.shape[::-1]) - 1 - nearest])
    return min(template, 2 * int(room) + 1)


def _along(area: Area, place: np.ndarray, step: float) -> dict:
    """Arguments of `ncc.match` that keep it near the curve, at a level."""
    assert area.curve is not None
    a, b, d = _rays.line(area.curve, place)
    away = np.abs(area.curve @ (a, b) + d).max()  # the curve is not quite straight
    wide = min(away, area.half.max()) + area.distance
    return {"lines": np.array([[a, b, d / step]]), "distance": 1.0 + wide / step}
