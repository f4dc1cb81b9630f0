"""Match two of your own photos with one call."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, lsm, ncc
from pgm_lab._statuses import Table
from pgm_lab.io import text
from pgm_lab.io.photo import Photo, read
from pgm_lab.matching import _starts, _wide
from pgm_lab.matching._correlate import correlate
from pgm_lab.matching._quality import RECOMMENDED, quality
from pgm_lab.matching.interest import pick, spread

STARTS = "features", "wide"
COLUMNS = (
    *("point", "left column", "left row", "right column", "right row"),
    *("variance column", "covariance", "variance row", "r", "quality", "status"),
)
MIN_TEMPLATE = 5  # px across
MAX_SCALE = 10.0  # from left to right
COARSE_THRESHOLD = 0.5  # of the correlation of windows whose shapes are about known
MAX_MOVE = 3.0  # px: farther from the best correlation it is another point
LATTICE = 64  # points along a photo that are tested for being in the other one


@dataclass(frozen=True, eq=False)
class Match(Table):
    """Result of `match` for n points.

    Attributes
    ----------
    chosen : ndarray (n, 2)
        Points in the left photo, (column, row) in pixels: as given, or as picked.
    points : ndarray (n, 2)
        Points in the right photo; NaN unless accepted.
    covariance : ndarray (n, 2, 2)
        Their covariance in square pixels; NaN unless accepted.
    shape : ndarray (n, 2, 2)
        ((a1, a2), (b1, b2)): how the window is rotated, scaled and sheared from left to
        right; NaN unless accepted.
    r : ndarray (n,)
        Correlation coefficient of the two windows; NaN where nothing was compared.
    quality : ndarray (n,)
        From 0 to 1, see `matching.quality`; NaN unless accepted or "parts disagree".
    status : ndarray (n,) of str
        "accepted", or what went wrong first: one of `STATUSES`.
    left_size, right_size : (int, int)
        Columns and rows of the photos in pixels.
    """

    chosen: np.ndarray
    points: np.ndarray
    covariance: np.ndarray
    shape: np.ndarray
    r: np.ndarray
    quality: np.ndarray
    status: np.ndarray
    left_size: tuple[int, int]
    right_size: tuple[int, int]

    def csv(self) -> str:
        """Return the table that `save` writes."""
        C = self.covariance
        numbers = np.column_stack(
            [self.chosen, self.points, C[:, 0, 0], C[:, 0, 1], C[:, 1, 1], self.r,
             self.quality]
        )  # fmt: skip
        return text.written(COLUMNS, numbers, self.status)


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
    least_quality: float = RECOMMENDED,
) -> Match:
    """Find points of the left photo in the right one, to a small part of a pixel.

    Features that look the same predict where each point lies and how its window is
    rotated and scaled; correlation finds it there to a pixel, least squares matching to
    a small part of one.

    Parameters
    ----------
    left, right : str, path, PIL.Image.Image or array_like
        Photos, see `read`.
    points : array_like (n, 2), optional
        (column, row) in the left photo, in pixels; default: `number` points that `pick`
        chooses in the overlap. With "wide" they are features, those that moved like
        their neighbours first, and none can be given.
    number : int
        How many points to pick. There may be fewer if there is too little texture.
    template : int
        Pixels across the window of the left photo, odd, at least 5; 7 for "wide".
    start : {"features", "wide"} or array_like (n, 2)
        Where to search in the right photo. "features": as SIFT features around the
        point predict, under any rotation and change of scale. "wide": features are
        themselves the points; for photos from places far apart, with much depth or
        other viewing directions, where the first finds few. Or the positions.
    shape : array_like (2, 2) or (n, 2, 2), optional
        With positions: ((a1, a2), (b1, b2)), how the windows are rotated and scaled
        from left to right; default: the identity.
    search : int
        Pixels across the search window, odd, at least template + 2, counted in the left
        photo. Only along the epipolar line where the features determine one.
    colour : {"refuse", "grey"}
        What to do with colours, see `read`.
    threshold : float
        Smallest correlation r of the two windows, from 0 to 1.
    ratio : float
        A match is ambiguous if a second peak reaches this fraction of its correlation;
        1 switches this test off.
    back : float or None
        Left-right check: a match is searched for again in the left photo and has to end
        within this distance of its point, in pixels; None leaves the check out.
    least_quality : float
        Between 0 and 1: small windows inside the template, matched alone, have to end
        where the template did. At a depth edge they do not, while r is high. A lower
        limit keeps more matches, and more wrong ones: 0 keeps all.

    Returns
    -------
    Match

    Raises
    ------
    FileNotFoundError, OSError
        If a file cannot be read.
    ValueError
        If a photo or an argument is not as described here, or too few features fit
        together to give start values.

    Notes
    -----
    A fundamental matrix, or a plane where that explains as much, selects the features
    that fit together (MAGSAC). The position and shape at a point come from an affine
    transformation of the features near to it, and a right window of that shape is
    resampled before correlation.

    With "wide" least squares begin where the feature was found (`search` and `ratio`
    are not used), in the template and in windows of 0.7, 0.5, 0.4 and 0.3 of its width.
    Each feature gets the window that most others confirm, the widest of several such,
    if four witnesses agree: another window to 0.25 px, the match back to `back`,
    descriptor and epipolar line to 1.5 px of a photo reduced to a million pixels. The
    quality is 1 / (1 + d^2), d being the largest of the four by these limits. Surfaces
    that are no planes move windows of two widths differently: the variance that this
    shows is part of the covariance. What no witness sees: features on the edge of a
    near surface, whose centre lies on a far one (5 to 8 in a hundred in a scene full of
    such edges; fewer with a higher `least_quality`), and a repeated pattern mistaken
    along the line.

    References
    ----------
    Lowe 2004; Barath et al. 2020, MAGSAC++; Gruen 1985.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=1)
    >>> rotated = (40, 0.95, 0.2, -15, -0.2, 0.95)
    >>> pair = simulate.texture_pair(texture, (200, 240), rotated, sigma=1.0)
    >>> found = match(*pair, [(120, 100), (60, 130)])
    >>> found.points.round(1)
    array([[174. ,  56. ],
           [123. ,  96.5]])
    """
    left = read(left, "left", colour=colour)
    right = read(right, "right", colour=colour)
    template = _validate.window(template, "template", MIN_TEMPLATE)
    _validate.grey_image(left, "left", template)
    _validate.grey_image(right, "right", template)
    number = _validate.whole(number, "number", 1)
    threshold = _validate.between(threshold, "threshold", 0, 1)
    least_quality = _validate.between(least_quality, "least_quality", 0, 1)
    search = _validate.window(search, "search", template + 2)
    if points is not None:
        points = _validate.point_list(points, "points")
    sizes = left.shape[::-1], right.shape[::-1]
    lines, near = None, {}
    if isinstance(start, str):
        if shape is not None:
            raise ValueError(
                "shape belongs to start values of your own: give positions as start, or"
                f" leave shape out; start={start!r} finds it"
            )
        wide = _validate.choice(start, "start", STARTS) == "wide"
        if wide and points is not None:
            raise ValueError('start="wide" matches features: leave points out')
        if wide:
            _validate.window(template, "template", _wide.MIN_TEMPLATE)
        field = _starts.from_features(left, right, precise=not wide)
        if np.linalg.det(field.at(field.left.mean(axis=0)[None])[1][0]) < 0:
            raise ValueError(
                "one of the photos is a mirror image of the other, as from a scanned"
                " slide that lay upside down: mirror it before you measure in it"
            )
        if wide:
            p, q = field.left, field.right
            k = np.argsort(np.hypot(*(field.at(p)[0] - q).T), kind="stable")
            k = k[spread(p[k], number, np.sqrt(left.size / number), 1.0)]
            (x, C, A, r, status, _), good = _wide.match(
                left, right, field, k, template, threshold, back, least_quality
            )
            return Match(field.left[k], x, C, A, r, good, status, *sizes)
        if points is None:
            points = _picked(left, right, field, number, template)
        where, shapes = field.at(points)
        lines, near = field.lines(points), {"distance": field.width(shapes)}
    elif points is None:
        raise ValueError("points must be given if start contains their positions")
    else:
        where = _validate.point_list(start, "start", len(points))
        shapes = _validate.window_shapes(shape, len(points))
        area = np.abs(np.linalg.det(shapes))
        if np.any(np.abs(shapes) > MAX_SCALE) or np.any(area < 1e-2):
            raise ValueError(
                f"shape must scale by 0.1 to {MAX_SCALE:g}, and not to a line; got"
                f" {shapes[0].tolist()}"
            )
    coarse = correlate(
        left, right, points, where, shapes, template, search, lines,
        threshold=min(threshold, COARSE_THRESHOLD), ratio=ratio, back=back, **near,
    )  # fmt: skip
    k = np.flatnonzero(coarse.accepted)
    fine = lsm.match(
        left, right, points[k], coarse.points[k], template,
        shape=shapes[k], threshold=threshold,
    )  # fmt: skip
    good = quality(left, right, points[k], fine, template)
    return _put_together(points, coarse, k, fine, good, least_quality, sizes)


def _picked(
    left: np.ndarray,
    right: np.ndarray,
    field: _starts.Field,
    number: int,
    template: int,
) -> np.ndarray:
    """Points with texture in the overlap of both photos."""
    rows, columns = left.shape
    x, y = (np.linspace(0, n - 1, LATTICE) for n in (columns, rows))
    lattice = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    there, shape = field.at(lattice)
    reach = template / 2 * np.abs(shape).sum(axis=2)
    last = np.array(right.shape[::-1]) - 1
    seen = np.all((there >= reach) & (there + reach <= last), axis=1)
    column, row = (
        np.rint(np.linspace(0, LATTICE - 1, n)).astype(int) for n in (columns, rows)
    )
    unseen = ~seen.reshape(LATTICE, LATTICE)[row[:, None], column]
    mask = np.ma.getmask(left) | unseen
    points = pick(np.ma.array(np.ma.getdata(left), mask=mask), number, template)
    if not len(points):
        raise ValueError(
            "there is no texture in the overlap of the photos: give points, or a"
            " smaller template"
        )
    return points


def _put_together(
    points: np.ndarray,
    coarse: ncc.Match,
    k: np.ndarray,
    fine: lsm.Match,
    good: np.ndarray,
    least_quality: float,
    sizes: tuple[tuple[int, int], tuple[int, int]],
) -> Match:
    """Combine correlation and, for the points k, least squares into one result."""
    n = len(points)
    status, r = coarse.status.copy(), coarse.r.copy()
    found, covariance = np.full((n, 2), np.nan), np.full((n, 2, 2), np.nan)
    shape, q = np.full((n, 2, 2), np.nan), np.full(n, np.nan)
    status[k], found[k], covariance[k] = fine.status, fine.points, fine.covariance
    shape[k], q[k] = fine.parameters[:, [[1, 2], [4, 5]]], good
    r[k] = np.where(np.isnan(fine.r), r[k], fine.r)
    moved = np.hypot(*(found - coarse.points).T)
    scale = np.sqrt(
        np.abs(shape[:, 0, 0] * shape[:, 1, 1] - shape[:, 0, 1] * shape[:, 1, 0])
    )
    status[moved > MAX_MOVE * np.maximum(scale, 1)] = "diverged"
    q[status != "accepted"] = np.nan
    status[q < least_quality] = "parts disagree"
    for values in (found, covariance, shape):
        values[status != "accepted"] = np.nan
    return Match(points, found, covariance, shape, r, q, status, *sizes)
