"""One figure of a measurement, for slides, paper, and wherever no kernel runs."""

import textwrap

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pgm_lab import _validate, plot
from pgm_lab.stereo_map import _panels, _words
from pgm_lab.stereo_map._measurement import Measurement
from pgm_lab.stereo_map.session import Session

WIDTH, LETTERS = 10.0, 100  # inches, and letters of 13 points in a line


def draw(session: Session, point: Measurement) -> Figure:
    """Draw a measurement: both photos, template, search, map of r, ellipse, numbers.

    Parameters
    ----------
    session : Session
    point : Measurement
        From `measure`, or of the list.

    Returns
    -------
    matplotlib.figure.Figure
    """
    _validate.instance(session, Session, "session")
    _validate.instance(point, Measurement, "point")
    rows, columns = session.left.grey.shape
    high = float(np.clip(4.5 * rows / columns, 2.0, 3.0))
    text = [textwrap.fill(line, LETTERS) for line in _words.lines(session, point)]
    written = "\n".join(text)
    heights = high + 0.4, 1.95, 0.25 * (1 + written.count("\n")) + 0.1
    fig = plt.figure(figsize=(WIDTH, sum(heights)), layout="constrained")
    above, middle, below = np.asarray(fig.subfigures(3, 1, height_ratios=heights))
    views = [
        _panels.View(ax, levels, title)
        for ax, levels, title in zip(
            above.subplots(1, 2), session.levels, ("left photo", "right photo")
        )
    ]
    mark(views, session, point)
    _panels.details(list(middle.subplots(1, 4)), point)
    below.text(0.01, 0.98, written, va="top", fontsize=13, linespacing=1.4)
    return fig


def show(session: Session, point: Measurement) -> None:
    """Show the figure of `draw` with a text for those who cannot see it.

    Parameters
    ----------
    session : Session
    point : Measurement
    """
    fig = draw(session, point)
    plot.show(fig, alt(session, point), colours=256)


def alt(session: Session, point: Measurement) -> str:
    """Return what the figure of a measurement shows, in words."""
    _validate.instance(session, Session, "session")
    _validate.instance(point, Measurement, "point")
    line = " with its epipolar line" if len(point.curve) else ""
    return (
        f"Two photos; the left one with the point that was clicked, the right one{line}"
        " and the match. Below: the template, the part of the right photo that was"
        " searched, the map of the correlation r, and the match with its 95 % ellipse. "
        + " ".join(_words.lines(session, point))
    )


def mark(
    views: list[_panels.View], session: Session, point: Measurement | None
) -> None:
    """Put the marks of all points, and of a new one, into both views."""
    kept = [p for p in session.points if point is None or p.name != point.name]
    names = [p.name for p in kept]
    nothing = _panels.NOTHING
    left = np.array([p.left for p in kept]).reshape(-1, 2)
    right = np.array([p.right for p in kept]).reshape(-1, 2)
    new = (nothing, nothing) if point is None else (point.left, point.right)
    curve = nothing if point is None else point.curve
    views[0].mark(left, names, new[0], nothing)
    views[1].mark(right, names, new[1], curve)
