"""The report of a matching: what was found, how well, and what to look at first."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from pgm_lab import _validate, matching
from pgm_lab._rounding import fixed, rounded
from pgm_lab.matching import RECOMMENDED_QUALITY, STATUSES, Match
from pgm_lab.report import _points
from pgm_lab.report._page import Table, as_html, as_text

__all__ = ["html", "text"]

TITLE = "Image matching"

# What the settings of `matching.match` mean, for the command line and the report
SETTINGS = {
    "points": "where the points are in the left photo",
    "number": "how many points to pick, where the texture is good and spread",
    "template": "pixels across the template, the window of the left photo; odd",
    "start": "what is matched: points that the features around them predict, or (wide,"
    " for photos from places far apart) the features themselves",
    "search": "pixels across the search window of the right photo; odd",
    "colour": "what becomes of colours: refuse them, or convert them to grey",
    "threshold": "least correlation r of the two windows",
    "ratio": "a second place above this share of r makes a match ambiguous",
    "back": "pixels by which a point may be missed when it is matched back",
    "least_quality": "least quality of a match, from 0 to 1; a higher one keeps fewer",
}
WORDS = {status: (status, *words) for status, words in STATUSES.items()}

# Limits of the findings
FEW = 12  # matches
OFTEN = 0.2  # of the points
ROTATED, SCALED = 15.0, 1.25  # degrees, times
ODD = 1.5  # times longer or shorter than in the other windows
WEAK, COARSE = 0.2, 1.0  # px, for a typical and for a single point
STILL = 0.02  # px
ASIDE = 0.1  # of the width of the left photo
AMBIGUOUS = "ambiguous", "left-right check failed"


def html(
    found: Match,
    left: Any,
    right: Any,
    *,
    settings: Mapping[str, object] | None = None,
    about: str = "",
) -> str:
    """Report a matching as an HTML page that needs no other file.

    Parameters
    ----------
    found : matching.Match
        What `matching.match` returned.
    left, right : as for `matching.read`
        The photos that were matched; colours are drawn in grey.
    settings : mapping {name: value}, optional
        Arguments that `matching.match` was given; the report shows the defaults of the
        others.
    about : str
        A sentence for the head of the report: the object, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.

    Raises
    ------
    ValueError
        If a photo has another size than the one that was matched.
    """
    from pgm_lab.report import _figures  # matplotlib only when it is needed

    case = _case(found, settings, about)
    draw = _figures.of_matching(found, left, right, case.asked.get("threshold"))
    return as_html(TITLE, case.sections(about, False, draw), {about} - {""})


def text(
    found: Match,
    *,
    settings: Mapping[str, object] | None = None,
    about: str = "",
    short: bool = False,
) -> str:
    """Report a matching in plain text.

    Parameters
    ----------
    found, settings, about
        As for `html`.
    short : bool
        Leave out the points and how they were computed.

    Returns
    -------
    str
        Lines of at most 88 characters, but for wide tables.

    Examples
    --------
    >>> from pgm_lab import matching, simulate
    >>> shift = (3.25, 1, 0, -1.5, 0, 1)
    >>> grey = simulate.texture_pair(simulate.texture(seed=1), (90, 120), shift)
    >>> report = text(matching.match(*grey, number=5), short=True)
    >>> report.splitlines()[3][:25]
    '5 of 5 points were found;'
    """
    case = _case(found, settings, about)
    return as_text(TITLE, case.sections(about, short))


def reason(found: Match) -> str:
    """Say why nothing was found, for a command that reports nothing then."""
    why = _points.lost(found, WORDS)[0]
    return (
        f"none of {len(found.chosen)} points was found; most often ({why.number}) the"
        f' reason is "{why.name}": {why.advice} Do both photos show the same?'
    )


def _case(found: Match, settings: Mapping[str, object] | None, about: str) -> "Case":
    _validate.instance(found, Match, "found")
    asked = _points.asked(matching.match, settings, SETTINGS)
    # Points are given, or picked: so many
    asked.pop("points" if asked["points"] is None else "number")
    return Case(found, asked)


class Case(_points.Points):
    """What the sentences of the report need to know of a matching."""

    NAME, FEW, WORDS, SETTINGS = "matching", FEW, WORDS, SETTINGS
    found: Match

    def median(self, values: np.ndarray) -> float:
        """Return the median of the accepted points."""
        return float(np.median(values[self.found.accepted]))

    @cached_property
    def parallax(self) -> np.ndarray:
        """Median difference (2,) of the accepted points, right less left, in pixels."""
        found = self.found
        return np.median((found.points - found.chosen)[found.accepted], axis=0)

    @cached_property
    def shape(self) -> np.ndarray:
        """Median shape (2, 2) of the accepted windows: how the right photo lies."""
        return np.median(self.found.shape[self.found.accepted], axis=0)

    @property
    def angle(self) -> float:
        """Rotation from left to right in degrees, clockwise as one sees it."""
        A = self.shape
        angle = np.arctan2(A[1, 0] - A[0, 1], A[0, 0] + A[1, 1])
        return float(np.degrees(angle))

    @property
    def scale(self) -> float:
        """Scale from left to right."""
        return float(np.sqrt(np.abs(np.linalg.det(self.shape))))

    @cached_property
    def doubtful(self) -> np.ndarray:
        """Indices of accepted points of less than the recommended quality."""
        found = self.found
        return np.flatnonzero(found.accepted & (found.quality < RECOMMENDED_QUALITY))

    @cached_property
    def crowded(self) -> tuple[float, str] | None:
        """Which part of the left photo the matches span, and where, if it is small."""
        found = self.found
        return _points.crowded(found.chosen[found.accepted], found.left_size)

    @cached_property
    def odd(self) -> np.ndarray:
        """Indices of accepted points whose shape is far from that of the others."""
        good = np.flatnonzero(self.found.accepted)
        if not len(good) or np.linalg.det(self.shape) == 0:
            return good[:0]
        relative = self.found.shape[good] @ np.linalg.inv(self.shape)
        s = np.linalg.svd(relative, compute_uv=False)
        return good[(s[:, 0] > ODD) | (s[:, 1] < 1 / ODD)]

    @property
    def exchanged(self) -> bool:
        """Whether the right photo seems to have been taken from the left."""
        dx, dy = self.parallax
        aside = dx > ASIDE * self.found.left_size[0] and dx > 2 * abs(dy)
        return abs(self.angle) <= ROTATED and bool(aside)

    def points_table(self) -> Table:
        """Return the first points, left and right, with their precision."""
        found = self.found
        n = min(_points.MAX_ROWS, len(found.chosen))
        sd = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))
        columns = [
            [str(i) for i in range(n)],
            *(fixed(one, 2) for one in found.chosen[:n].T),
            *(rounded(one, found.sd)[:n] for one in found.points.T),
            *(rounded(one, found.sd)[:n] for one in sd.T),
            fixed(found.r[:n], 3),
            fixed(found.quality[:n], 2),
            list(map(str, found.status[:n])),
        ]
        header = ["point", "left column", "left row", "right column", "right row"]
        header += ["sd column", "sd row", "r", "quality", "status"]
        caption = "Points in pixels, columns to the right and rows down, from 0"
        caption = _points.first_rows(caption, len(found.chosen))
        return Table(caption, header, list(zip(*columns)))
