"""Where to look for a left point: predicted, then narrowed from coarse to fine."""

from dataclasses import dataclass

import numpy as np

from pgm_lab import ncc
from pgm_lab.stereo_map import _rays

AT_FIRST = 100  # px to each side at the level where a wide search begins
STEP = 4  # px to each side at the levels below it
LAST = 20  # px to each side in the photo itself
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


def around(chosen: np.ndarray, found: np.ndarray, pixel: np.ndarray, size: tuple):
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
    coarsest = min(len(left), len(right)) - 1
    wide = np.max(area.half)
    if wide <= LAST:
        return area.centre
    first = int(np.clip(np.ceil(np.log2(wide / AT_FIRST)), 1, max(coarsest, 0)))
    place, half = area.centre, area.half
    for k in range(min(first, coarsest), 0, -1):
        step = 2.0**k
        columns, rows = (2 * np.ceil(half / step).astype(int) + template).tolist()
        along = {} if area.curve is None else _along(area, place, step)
        found = ncc.match(
            left[k],
            right[k],
            pixel[None] / step,
            place[None] / step,
            template,
            (rows, columns),
            LEAST,
            1.0,
            **along,
        )
        if not found.r[0] >= LEAST:  # NaN too
            break
        place, half = found.points[0] * step, np.full(2, STEP * step / 2)
    return place


def _along(area: Area, place: np.ndarray, step: float) -> dict:
    """Arguments of `ncc.match` that keep it near the curve, at a level."""
    assert area.curve is not None
    a, b, d = _rays.line(area.curve, place)
    away = np.abs(area.curve @ (a, b) + d).max()  # the curve is not quite straight
    wide = min(away, area.half.max()) + area.distance
    return {"lines": np.array([[a, b, d / step]]), "distance": 1.0 + wide / step}
