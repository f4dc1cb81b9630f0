"""Drawings of two images that were registered."""

from collections.abc import Callable, Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import ArrayLike

from pgm_lab import matching
from pgm_lab._rounding import plain
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look, composite
from pgm_lab.plot.matches import arrows, series
from pgm_lab.registration import Registration

SHARE = 0.9  # of the shifts within the circle and the ellipses
SHORTEST = 1e-4  # px; shorter ones are drawn with this length


def fringes(
    reference: ArrayLike,
    images: Mapping[str, ArrayLike],
    corner: ArrayLike = (0.0, 0.0),
) -> Figure:
    """Draw a part of the reference image, overlaid with others in two colours.

    Grey where both are equally bright; green where the reference image is brighter,
    magenta where the other one is; white where one has no data. A fringe along the
    edges is a shift.

    Parameters
    ----------
    reference : array_like (rows, columns)
        A part of the reference image; masked or NaN where it has no data.
    images : mapping {title: array_like (rows, columns)}
        The same part of other images, in the pixels of the reference image, such as the
        sensed one before and after resampling.
    corner : array_like (2,)
        (column, row) of the first pixel of the part, for the axes.
    """
    first = _grey(reference, "reference")
    left, top = np.asarray(corner) - 0.5
    rows, columns = first.shape
    extent = (left, left + columns, top + rows, top)
    wide = 6.0 * len(images)
    fig, axes = plt.subplots(1, len(images), figsize=(wide, 6.6), squeeze=False)
    for ax, (title, image) in zip(axes.flat, images.items()):
        other = _grey(image, f"images: {title}")
        ax.imshow(composite(first, other), extent=extent, interpolation="nearest")
        ax.set(xlabel="columns (px)", ylabel="rows (px)")
        ax.set_title(title)
        ax.grid(False)
    return fig


def _grey(image: ArrayLike, name: str) -> np.ma.MaskedArray:
    """Grey values of a part of an image, masked where there are none."""
    return np.ma.asarray(matching.read(image, name, colour="grey").astype(float))


def shifts(
    reference: ArrayLike,
    found: Registration,
    vectors: ArrayLike | None = None,
    title: str = "Shifts, sensed minus reference",
    *,
    say: Callable[[str], str] = str,
) -> Figure:
    """Draw the reference image with an arrow at each accepted point: its shift.

    Points that were not accepted have a mark by their status.

    Parameters
    ----------
    reference : array_like (rows, columns)
        The reference image.
    found : Registration
        What `registration.register` returned; at least one point must be accepted.
    vectors : array_like (n, 2), optional
        What to draw in place of the shifts, such as their residuals from a model, in
        pixels; only those of accepted points are drawn.
    title : str
        What the arrows are.
    say : function
        Function that rephrases a status.
    """
    good = found.accepted
    grey = matching.read(reference, "reference", colour="grey")  # large: no copy
    drawn = np.asarray(found.shifts if vectors is None else vectors)
    fig = arrows(grey, found.points[good], drawn[good], title)
    marks: Look = {"linestyle": "none", "markeredgecolor": "white", "markersize": 8}
    handles = []
    for status, which, (colour, mark) in series(found.status)[1:]:
        look = marks | {"color": colour, "marker": mark}
        label = f"{say(status)}: {np.sum(which)}"
        handles += fig.axes[0].plot(*found.points[which].T, label=label, **look)
    if handles:
        fig.legend(handles=handles, loc="outside lower center", ncols=2)
    return fig


def scatter(
    found: Registration, radius: int = 3, errors: ArrayLike | None = None
) -> Figure:
    """Draw the accepted shifts: in the search window, and about their mean or a model.

    The circle about zero contains nine tenths of them (CE90). Of the two ellipses one
    has the covariance predicted for the chips, the other that of the shifts; if they
    are normal, each contains nine tenths of them.

    Parameters
    ----------
    found : Registration
        What `registration.register` returned; at least one point must be accepted.
    radius : int
        How far was searched, in pixels.
    errors : array_like (n, 2), optional
        Errors of the shifts, in pixels, such as the residuals of a model; default: the
        deviations from the mean shift. Only those of accepted points are drawn.
    """
    good = found.accepted
    d = found.shifts[good]
    mean, C = d.mean(axis=0), np.mean(found.covariance[good], axis=0)
    fig, (whole, near) = plt.subplots(1, 2, figsize=(12, 7))
    reach = max(radius + 0.5, 1.05 * float(np.abs(d).max()))
    dots: Look = {"color": basic.BLUE, "marker": "o", "linestyle": "none"}
    dots |= {"alpha": 0.6, "markersize": 6, "markeredgewidth": 0}
    whole.plot(*d.T, **dots)
    edge: Look = {"fill": False, "linewidth": 2.4}
    label = f"CE90 = {plain(found.ce90)} px"
    whole.add_patch(Circle((0, 0), found.ce90, color=basic.RED, label=label, **edge))
    whole.plot(*mean, "P", color=basic.BLACK, markersize=11, label="mean")
    whole.plot(0, 0, "+", color=basic.BLACK, markersize=15, label="no shift")
    whole.set(xlim=(-reach, reach), ylim=(reach, -reach))
    whole.set_title("In the search window")
    v = d - mean if errors is None else np.asarray(errors)[good]
    near.plot(*v.T, **dots)
    ellipses = [("as predicted", C, basic.ORANGE, "--")]
    if len(d) > 2:
        ellipses.append(("as observed", np.cov(v.T), basic.PURPLE, "-"))
    for name, covariance, colour, line in ellipses:
        look: Look = {
            "color": colour,
            "linestyle": line,
            "label": f"90 % of them, {name}",
        }
        basic.error_ellipse(near, (0, 0), covariance, SHARE, **look)
    reach = 1.15 * max(float(np.abs(v).max()), 2.2 * float(np.sqrt(np.trace(C) / 2)))
    reach = max(reach, 1e-3)
    near.set(xlim=(-reach, reach), ylim=(reach, -reach))
    near.set_title(f"Deviations from the {'mean' if errors is None else 'model'}")
    for ax in (whole, near):
        ax.set(xlabel="dx (px)", ylabel="dy (px)", aspect="equal")
        ax.xaxis.set_major_locator(plt.MaxNLocator(5))
        ax.yaxis.set_major_locator(plt.MaxNLocator(5))
    fig.legend(loc="outside lower center", ncols=3)
    return fig


def similarity(found: Registration, errors: ArrayLike) -> Figure:
    """Draw whether r, and the predicted standard deviation, indicate the errors.

    `errors` (n, 2) are those of the shifts, in pixels, such as the residuals of a
    model; only those of accepted points are drawn.
    """
    good = found.accepted
    off = np.maximum(np.hypot(*np.asarray(errors)[good].T), SHORTEST)
    fig, (by_r, by_sd) = plt.subplots(1, 2, figsize=(12, 5), sharey=True)
    dots: Look = {"color": basic.BLUE, "marker": "o", "linestyle": "none"}
    dots |= {"alpha": 0.6, "markersize": 7, "markeredgewidth": 0}
    by_r.semilogy(found.r[good], off, **dots)
    by_r.set(xlabel="correlation coefficient r", ylabel="deviation (px)")
    sd = np.maximum(found.sd[good], SHORTEST)
    by_sd.loglog(sd, off, **dots)
    ends = np.array([sd.min() / 1.5, sd.max() * 1.5])
    # Nine tenths of normal errors are not longer than 2.146 times their sd
    limit = np.sqrt(2 * np.log(10)) * ends
    line: Look = {"color": basic.RED, "linestyle": "--"}
    by_sd.plot(ends, limit, label="90 % below, as predicted", **line)
    by_sd.set(xlabel="predicted standard deviation (px)")
    by_sd.legend(loc="upper left")
    basic.plain(by_sd.xaxis)
    basic.plain(by_r.yaxis, (1,))
    return fig
