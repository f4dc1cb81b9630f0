"""The numbers of a matching as tables of words, rounded by their precision."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from pgm_lab import matching
from pgm_lab._rounding import fixed, rounded
from pgm_lab.matching import Match
from pgm_lab.report import _settings
from pgm_lab.report._layout import Table
from pgm_lab.report._statuses import MOST, first_rows

# What the settings of `matching.match` mean, for the command line and the report
SETTINGS = {
    "points": "where the points are in the left photo",
    "number": "how many points to pick, where the texture is good and spread",
    "template": "pixels across the template, the window of the left photo; odd",
    "start": "how start values are found: by features, or from coarse to fine",
    "search": "pixels across the search window of the right photo; odd",
    "colour": "what becomes of colours: refuse them, or turn them into grey values",
    "threshold": "least correlation r of the two windows",
    "ratio": "a second place with a higher share of r makes a match ambiguous",
    "back": "pixels that a point may miss when it is sought back from the right",
    "least_quality": "least quality of a match, from 0 to 1; more keeps fewer, better",
}


def points(found: Match) -> Table:
    """Return the first points, left and right, with their precision."""
    n = min(MOST, len(found.chosen))
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
    header: tuple[str, ...] = (
        "point",
        "left column",
        "left row",
        "right column",
        "right row",
    )
    header += ("sd column", "sd row", "r", "quality", "status")
    caption = "Points in pixels, columns to the right and rows down, from 0"
    caption = first_rows(caption, len(found.chosen))
    return Table(caption, header, list(zip(*columns)))


def values(given: Mapping[str, object]) -> dict[str, Any]:
    """Return what was asked of `matching.match`, its defaults among it."""
    asked = _settings.values(matching.match, given, SETTINGS)
    # Points are given, or picked: so many
    asked.pop("points" if asked["points"] is None else "number")
    return asked
