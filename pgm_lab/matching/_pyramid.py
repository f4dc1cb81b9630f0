"""Start values from coarse to fine, for photos that differ by a shift."""

import cv2
import numpy as np

from pgm_lab import image, ncc
from pgm_lab.matching._correlate import correlate
from pgm_lab.matching._features import (
    FEWEST,
    fitting,
    of_full_size,
    reduced,
    reduction,
    smooth,
)
from pgm_lab.matching._field import Field
from pgm_lab.matching.interest import pick

COARSEST = 160  # pixels at most along the longer side of the smallest level
TEMPLATE = 15  # pixels at each level
SEARCH = 31
NUMBER = 300  # points at each level


def field(left: np.ndarray, right: np.ndarray) -> Field:
    """Find points level by level, the smallest one in all of the right photo."""
    factor = max(reduction(left), reduction(right))  # a shift stays a shift
    small = reduced(left, factor), reduced(right, factor)
    longest = max(*small[0].shape, *small[1].shape)
    levels = 1 + max(0, int(np.ceil(np.log2(longest / COARSEST))))
    lefts, rights = (image.pyramid(one, levels) for one in small)
    p, q = _anywhere(lefts[-1], rights[-1])
    for one, other in list(zip(lefts, rights))[-2::-1]:
        p, q = _finer(one, other, Field(2 * p, 2 * q))
    p, q = of_full_size(p, small[0], left), of_full_size(q, small[1], right)
    fit, F = fitting(p, q, 1.5 * factor)
    _refuse_few(int(fit.sum()), len(fit))
    return Field(p[fit], q[fit], 1.5 * factor, F)


def _anywhere(left: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of the smallest level, sought in all of the other photo."""
    template = min(TEMPLATE, *(min(one.shape) // 2 * 2 - 3 for one in (left, right)))
    points = pick(left, NUMBER, template)
    middle = np.tile((np.array(right.shape[::-1]) - 1) / 2, (len(points), 1))
    rows, columns = (n + (n + 1) % 2 + 2 for n in right.shape)
    found = ncc.match(
        left, right, points, middle, template, (rows, columns), 0.5, 1.0, back=1.5
    )
    good = found.accepted
    p, q = points[good], found.points[good]
    _refuse_few(len(p), len(points))
    settings = cv2.UsacParams()
    settings.threshold = 3.0
    settings.confidence = 0.9999
    _, fit = cv2.estimateAffine2D(p, q, settings)
    fit = fit.ravel() > 0
    _refuse_few(fit.sum(), len(points))
    return p[fit], q[fit]


def _finer(
    left: np.ndarray, right: np.ndarray, field: Field
) -> tuple[np.ndarray, np.ndarray]:
    """Points of a level, sought where the level before has them."""
    points = pick(left, NUMBER, TEMPLATE)
    found = correlate(
        left,
        right,
        points,
        *field.at(points),
        TEMPLATE,
        SEARCH,
        threshold=0.6,
        ratio=0.95,
        back=1.5,
    )
    good = found.accepted
    p, q = points[good], found.points[good]
    good = smooth(p, q)
    _refuse_few(good.sum(), len(points))
    return p[good], q[good]


def _refuse_few(found: int, of: int) -> None:
    if found < max(FEWEST, 0.1 * of):
        raise ValueError(
            f"only {found} of {of} points of the pyramid fit together: do both photos"
            ' show the same, without much turn and change of scale? start="features"'
            " stands those; or give points and start"
        )
