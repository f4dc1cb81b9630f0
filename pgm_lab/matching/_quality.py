"""How far a match can be trusted: small windows inside the template, matched alone."""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, lsm

RECOMMENDED = 0.5  # quality below which a match is better left out
HALF_QUALITY = 0.85  # px between the matches where the quality is 1/2
WINDOW_RATIO = 3 / 7  # small window by template: here most wrong matches show
MIN_TEMPLATE = 5  # px across
MIN_WINDOW = 7  # px across: narrower windows disagree by their noise alone


def quality(
    left: ArrayLike,
    right: ArrayLike,
    points: ArrayLike,
    found: lsm.Match,
    template: int = 21,
) -> np.ndarray:
    """Distinguish matches on which the whole template agrees from those at depth edges.

    The template may see two surfaces, one behind the other. Its match then belongs to
    the one with more contrast, with a high r and a small predicted standard deviation.
    But its parts disagree: five small windows in it, around the point and to its left,
    right, top and bottom, are matched alone. Each ends at some distance from where the
    template's transformation predicts it; d is the largest but one of the five, since
    one of them may have no texture.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Grey values, as given to `lsm.match`.
    points : array_like (n, 2)
        Points in the left image, as given to `lsm.match`.
    found : lsm.Match
        The result of `lsm.match` for them.
    template : int
        Pixels across the template used for it, odd, at least 5.

    Returns
    -------
    ndarray (n,)
        1 / (1 + (d / 0.85 px)^2): 1 where four small windows agree with the template,
        1/2 where they miss it by 0.85 px, 0 where two or more were not found; NaN
        unless the match is accepted.

    Raises
    ------
    ValueError
        If the points are not those of `found`, the template is even or below 5, or
        `lsm.match` refuses an image.

    Notes
    -----
    Keep what reaches `RECOMMENDED_QUALITY`. It says nothing about precision, and cannot
    detect errors on which all parts agree: a repeated pattern, or something that moved.
    The left-right check and a model of all points, as in relative orientation, can.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> texture = simulate.texture(seed=1)
    >>> left, right = simulate.texture_pair(texture, (60, 60), (3, 1, 0, 2, 0, 1))
    >>> found = lsm.match(left, right, [(30, 30)], [(33, 32)])
    >>> print(quality(left, right, [(30, 30)], found).round(2))
    [1.]
    """
    template = _validate.window(template, "template", MIN_TEMPLATE)
    _validate.instance(found, lsm.Match, "found")
    points = _validate.point_list(points, "points", len(found.points))
    answer = np.full(len(points), np.nan)
    k = np.flatnonzero(found.accepted)
    if not len(k):
        return answer
    small, places = _small_windows(template)
    shape = found.parameters[k][:, [1, 2, 4, 5]].reshape(-1, 2, 2)
    here = points[k, None] + places
    there = found.points[k, None] + places @ np.swapaxes(shape, 1, 2)
    alone = lsm.match(
        left,
        right,
        here.reshape(-1, 2),
        there.reshape(-1, 2),
        small,
        shape=np.repeat(shape, len(places), axis=0),
        threshold=0.0,
    )
    missed = np.linalg.norm(alone.points.reshape(there.shape) - there, axis=2)
    missed[np.isnan(missed)] = np.inf
    d = np.sort(missed, axis=1)[:, -2]
    answer[k] = 1 / (1 + (d / HALF_QUALITY) ** 2)
    return answer


def _small_windows(template: int) -> tuple[int, np.ndarray]:
    """Width of the small windows, and where they lie in the template (5, 2)."""
    width = 2 * int(WINDOW_RATIO * template / 2) + 1
    small = max(width, min(MIN_WINDOW, template - 2), MIN_TEMPLATE)
    aside = max(1, (template - small) // 2 - 1)
    return small, aside * np.array([(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)])
