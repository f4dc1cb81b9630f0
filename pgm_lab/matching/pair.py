"""Two photos in, conjugate points out: starts, correlation, least squares."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, lsm
from pgm_lab.matching import _features, _pyramid
from pgm_lab.matching._correlate import correlate
from pgm_lab.matching._field import Field
from pgm_lab.matching._quality import quality
from pgm_lab.matching.interest import pick
from pgm_lab.matching.photo import Photo, read
from pgm_lab.matching.result import Match

STARTS = {"features": _features.field, "pyramid": _pyramid.field}
MOVED = 3.0  # px: farther from the best correlation least squares went to another place
LATTICE = 64  # places along a photo where it is asked whether the other one shows them


def match(
    left: Photo,
    right: Photo,
    points: ArrayLike | None = None,
    *,
    number: int = 200,
    template: int = 21,
    start: str | ArrayLike = "features",
    shape: ArrayLike | None = None,
    search: int = 51,
    colour: str = "refuse",
    threshold: float = 0.7,
    ratio: float = 0.9,
    back: float | None = 1.0,
    least_quality: float = 0.0,
) -> Match:
    """Find points of the left photo in the right one, to a small part of a pixel.

    Features that look the same tell where each point lies and how its window is turned
    and scaled; correlation finds it there to a pixel, least squares matching exactly.

    Parameters
    ----------
    left, right : str, path, PIL.Image.Image or array_like
        Photos, see `read`.
    points : array_like (n, 2), optional
        (column, row) in the left photo, in pixels; default: `number` points that `pick`
        chooses in what both photos show.
    number : int
        How many points to pick.
    template : int
        Pixels across the window of the left photo, odd, at least 5.
    start : {"features", "pyramid"} or array_like (n, 2)
        Where to search in the right photo. "features": as features of SIFT tell, under
        any turn and change of scale. "pyramid": by correlation from coarse to fine, for
        photos that differ by a shift and little else. Or the positions themselves.
    shape : array_like (2, 2) or (n, 2, 2), optional
        With positions: ((a1, a2), (b1, b2)), how the windows are turned and scaled from
        left to right; default: not at all.
    search : int
        Pixels across the search window, odd, counted in the left photo; along the
        epipolar line where the features tell one.
    colour : {"refuse", "grey"}
        What to do with colours, see `read`.
    threshold : float
        Smallest correlation r of the two windows.
    ratio : float
        A match is ambiguous if a second place has a higher share of its r than this.
    back : float or None
        How many pixels from its point a match may end that is sought again in the left
        photo, from the right; None does not ask.
    least_quality : float
        Matches of less quality are "below threshold".

    Returns
    -------
    Match

    Raises
    ------
    FileNotFoundError, OSError
        If a file cannot be read.
    ValueError
        If a photo or an argument is not what is described here, or too few features fit
        together.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=1)
    >>> turned = (40, 0.95, 0.2, -15, -0.2, 0.95)
    >>> pair = simulate.texture_pair(texture, (200, 240), turned, sigma=1.0)
    >>> found = match(*pair, [(120, 100), (60, 130)])
    >>> found.points.round(1)
    array([[174. ,  56. ],
           [123. ,  96.5]])
    """
    left = read(left, "left", colour=colour)
    right = read(right, "right", colour=colour)
    template = _validate.window(template, "template", 5)
    number = _validate.whole(number, "number", 1)
    if points is not None:
        points = _validate.point_list(points, "points")
    field = None
    if isinstance(start, str):
        _validate.choice(start, "start", tuple(STARTS))
        field = STARTS[start](left, right)
    if points is None:
        if field is None:
            raise ValueError("start holds positions, but there are no points to them")
        points = pick(_common(left, right, field, template), number, template)
    lines = None
    if field is not None:
        start, shape = field.at(points)
        lines = field.lines(points)
    start = _validate.point_list(start, "start", len(points))
    shape = _shapes(shape, len(points))
    limits: dict[str, Any] = dict(threshold=min(threshold, 0.5), ratio=ratio, back=back)
    if field is not None and lines is not None:
        limits["distance"] = 2 * field.noise
    coarse = correlate(
        left, right, points, start, shape, template, search, lines, **limits
    )
    status, r = coarse.status.copy(), coarse.r.copy()
    k = np.flatnonzero(coarse.accepted)
    fine = lsm.match(
        left, right, points[k], coarse.points[k], template, shape=shape[k],
        threshold=threshold,
    )  # fmt: skip
    status[k] = fine.status
    r[k] = fine.r
    moved = np.linalg.norm(fine.points - coarse.points[k], axis=1)
    scale = np.sqrt(np.abs(np.linalg.det(shape[k])))
    status[k[moved > MOVED * np.maximum(scale, 1)]] = "diverged"
    found, covariance = (
        np.full((len(points), 2), np.nan),
        np.full((len(points), 2, 2), np.nan),
    )
    found[k], covariance[k] = fine.points, fine.covariance
    shapes = np.full((len(points), 2, 2), np.nan)
    shapes[k] = fine.parameters[:, [1, 2, 4, 5]].reshape(-1, 2, 2)
    q = np.full(len(points), np.nan)
    q[k] = quality(left, right, points[k], fine, template)
    status[(status == "accepted") & (q < least_quality)] = "below threshold"
    for values in (found, covariance, shapes, q):
        values[status != "accepted"] = np.nan
    return Match(
        points, found, covariance, shapes, r, q, status,
        left.shape[::-1], right.shape[::-1],
    )  # fmt: skip


def _shapes(shape: ArrayLike | None, n: int) -> np.ndarray:
    """Shapes (n, 2, 2), the same for all if one is given."""
    shape = np.eye(2) if shape is None else _validate.finite(shape, "shape")
    if shape.shape not in ((2, 2), (n, 2, 2)):
        raise ValueError(
            "shape must be ((a1, a2), (b1, b2)), one for all points or one for each,"
            f" (2, 2) or ({n}, 2, 2); got {shape.shape}"
        )
    return np.broadcast_to(shape, (n, 2, 2))


def _common(
    left: np.ndarray, right: np.ndarray, field: Field, template: int
) -> np.ma.MaskedArray:
    """The left photo, masked where the right one does not show it."""
    rows, columns = left.shape
    x, y = (np.linspace(0, n - 1, LATTICE) for n in (columns, rows))
    lattice = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    there, shape = field.at(lattice)
    margin = template * np.abs(shape).sum(axis=2) / 2
    size = np.array(right.shape[::-1])
    seen = np.all((there >= margin) & (there <= size - 1 - margin), axis=1)
    column = np.rint(np.arange(columns) * (LATTICE - 1) / max(1, columns - 1)).astype(
        int
    )
    row = np.rint(np.arange(rows) * (LATTICE - 1) / max(1, rows - 1)).astype(int)
    unseen = ~seen.reshape(LATTICE, LATTICE)[row[:, None], column]
    return np.ma.array(left, mask=np.ma.getmask(left) | unseen)
