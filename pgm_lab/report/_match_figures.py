"""The figures of a matching, each with what it shows in words."""

from collections.abc import Callable, Iterator
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_lab import plot
from pgm_lab._rounding import plain
from pgm_lab.matching import Match
from pgm_lab.report._figures import png
from pgm_lab.report._layout import count
from pgm_lab.report._statuses import lost

LINES = 12


def pictures(
    name: str, found: Match, left: Any, right: Any, threshold: float | None
) -> list[tuple[str, str]]:
    """Return the figures of one kind: PNGs in base64, and what they show."""
    kinds: dict[str, Callable[[], Iterator[tuple[Figure, str]]]] = {
        "photos": lambda: _photos(found, left, right),
        "histograms": lambda: _histograms(found, threshold),
        "parallaxes": lambda: _parallaxes(found, left),
    }
    with plt.rc_context(plot.STYLE):
        return [(png(figure), words) for figure, words in kinds[name]()]


def _photos(found: Match, left: Any, right: Any) -> Iterator[tuple[Figure, str]]:
    m = int(np.sum(found.accepted))
    words = (
        f"The two photos side by side, with {count(m, 'point')} marked in both, some of"
        " them joined by lines."
    )
    if reasons := lost(found):
        others = ", ".join(f"{status} ({number})" for status, number in reasons)
        words += f" In the left photo are the others too, by reason: {others}."
    yield plot.matches.side_by_side(left, right, found, LINES), words


def _histograms(found: Match, threshold: float | None) -> Iterator[tuple[Figure, str]]:
    good = found.accepted
    words = "Two histograms: the correlation coefficient r of all points"
    if threshold is not None:
        words += f" with the limit {plain(threshold)}"
    words += ", and the predicted standard deviation of the accepted ones."
    if np.any(good):
        r, sd = np.median(found.r[good]), np.median(found.sd[good])
        words += f" Half of the accepted ones have r above {r:.3f}"
        words += f" and a standard deviation below {plain(sd)} px."
    yield plot.matches.histograms(found, threshold), words


def _parallaxes(found: Match, left: Any) -> Iterator[tuple[Figure, str]]:
    if not np.any(found.accepted):
        return
    length = np.hypot(*plot.matches.remainders(found).T)
    words = (
        "The left photo with an arrow at each match: what is left of its parallax when"
        " a common shift, turn, scale and shear are taken off. Half of the arrows are"
        f" shorter than {plain(float(np.median(length)))} px, the longest is"
        f" {plain(float(length.max()))} px."
    )
    yield plot.matches.parallaxes(left, found), words
