"""Figures of stereo plotting: two photos, the normal case, the search along a row."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera.photo import Photo
from pgm_lab.plot import basic
from pgm_lab.plot._overlay import composite, grey_levels
from pgm_lab.plot.basic import Look
from pgm_lab.stereo import DenseMatch, NormalPair
from pgm_lab.stereo.textbook import along_row

NAMES = ("left photo", "right photo")
BAND = 60  # px shown to each side of a row


def photos(left: Photo, right: Photo) -> Figure:
    """Draw two photos side by side.

    Parameters
    ----------
    left, right : Photo

    Returns
    -------
    matplotlib.figure.Figure
    """
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="compressed")
    for ax, photo, name in zip(axes, _both(left, right), NAMES):
        _bare(ax, photo.grey, name)
    return fig


def laid(pair: NormalPair, disparity: float) -> None:
    """Show the right photo laid on the left one, moved by a disparity.

    Parameters
    ----------
    pair : NormalPair
        Two photos in the normal case.
    disparity : float
        Left column minus right column of what is to fit, px.
    """
    _validate.instance(pair, NormalPair, "pair")
    d = round(_validate.number(disparity, "disparity"))
    right = np.roll(pair.right, d, axis=1)
    right[:, slice(0, d) if d > 0 else slice(pair.right.shape[1] + d, None)] = np.nan
    fig, ax = plt.subplots(figsize=(7, 4.5), layout="compressed")
    ax.imshow(composite(pair.left, right), interpolation="nearest")
    ax.set(xticks=[], yticks=[], xlabel="green: left photo, magenta: right photo")
    ax.grid(False)
    basic.show(
        fig,
        "Both photos in two colours, laid on each other. What is as high as the middle"
        " is grey and fits, one roof among it. Tree tops and another roof have rims in"
        " both colours to their left and right, and so has lower and higher ground.",
        colours=96,
    )


def epipolar_line(
    left: Photo,
    right: Photo,
    pixel: ArrayLike,
    line: ArrayLike,
    places: ArrayLike,
    heights: ArrayLike,
) -> None:
    """Show the epipolar line of a left point in the right photo.

    Parameters
    ----------
    left, right : Photo
    pixel : array_like (2,)
        (column, row) in the left photo.
    line : array_like (k, 2)
        Pixels of the right photo on the epipolar line.
    places : array_like (n, 2)
        Pixels of the right photo, where the point would lie at some heights.
    heights : array_like (n,)
        These heights in m.
    """
    column, row = _validate.one_point(pixel, 2, "pixel")
    line = _validate.point_list(line, "line")
    places = _validate.point_list(places, "places")
    heights = _validate.of_shape(heights, (len(places),), "heights")
    fig, axes = plt.subplots(1, 2, figsize=(10, 2.3), layout="compressed")
    for ax, photo, name in zip(axes, _both(left, right), NAMES):
        _bare(ax, photo.grey, name)
        last = photo.grey.shape[0] - 0.5
        ax.set_ylim(min(row + 1.4 * BAND, last), max(row - 1.4 * BAND, -0.5))
    look: Look = {"ms": 20, "mew": 3, "color": basic.ORANGE}
    axes[0].plot(column, row, "+", **look)
    axes[1].autoscale(False)
    axes[1].plot(*line.T, color=basic.GREEN, lw=2)
    axes[1].plot(*places.T, "|", ms=18, mew=3, color=basic.ORANGE)
    text: Look = {"textcoords": "offset points", "ha": "center", "fontsize": 14}
    box = {"fc": "white", "ec": "none", "pad": 1}
    for place, height in zip(places, heights):
        axes[1].annotate(f"{height:g}", place, (0, 16), bbox=box, **text)
    axes[1].set_title("right photo, heights in m", fontsize=18)
    basic.show(
        fig,
        "Left photo with a cross at one point; right photo with a straight line across"
        f" it, hardly tilted, and {len(places)} strokes on it where the point would lie"
        f" at {', '.join(f'{h:g}' for h in heights)} m: the higher, the farther left.",
        dpi=110,
        colours=48,
    )


def rows(left: Photo, right: Photo, pair: NormalPair, row: int) -> Figure:
    """Draw a pair before and after it was resampled to the normal case.

    Parameters
    ----------
    left, right : Photo
    pair : NormalPair
    row : int
        Row that is drawn through all images, in the middle of the part shown.

    Returns
    -------
    matplotlib.figure.Figure
    """
    _validate.instance(pair, NormalPair, "pair")
    row = _validate.whole(row, "row", 0)
    fig, axes = plt.subplots(2, 2, figsize=(10, 3.4), layout="compressed")
    one, other = _both(left, right)
    images = one.grey, other.grey, pair.left, pair.right
    titles = [*NAMES, "left, normal case", "right, normal case"]
    for ax, image, title in zip(axes.ravel(), images, titles):
        _bare(ax, image, title)
        ax.axhline(row, color=basic.ORANGE, lw=2)
        ax.set_ylim(row + BAND, row - BAND)
    return fig


def y_parallaxes(cases: Mapping[str, ArrayLike]) -> None:
    """Show y parallaxes of several orientations, a column of points for each.

    Parameters
    ----------
    cases : mapping of str to array_like (n,)
        y parallaxes in px, by the name of the orientation.
    """
    several = {
        name: _validate.of_shape(values, (None,), f"cases: {name}")
        for name, values in _validate.mapping(cases, "cases").items()
    }
    fig, ax = plt.subplots(figsize=(7, 3.1), layout="constrained")
    colours = (basic.GREEN, basic.RED, basic.BLUE, basic.PURPLE)
    said = []
    for k, ((name, values), colour) in enumerate(zip(several.items(), colours)):
        spread = np.linspace(-0.18, 0.18, len(values))
        ax.plot(k + spread, values, "o", color=colour, alpha=0.5, ms=6)
        ax.plot((k - 0.3, k + 0.3), [np.median(values)] * 2, color=basic.BLACK, lw=3)
        said.append(f"{name.replace(chr(10), ' ')}: {np.median(values):.2f} px")
    ax.axhline(0, color="0.5", lw=1)
    ax.set_xticks(range(len(several)), list(several))
    ax.set(ylabel="y parallax (px)", xlim=(-0.5, len(several) - 0.5))
    ax.grid(axis="x")
    basic.show(
        fig,
        "y parallaxes of matched points, a column of dots for each orientation, with"
        f" the median as a bar. Medians: {'; '.join(said)}.",
        colours=64,
    )


def search(
    pair: NormalPair, place: ArrayLike, window: int, low: int, high: int
) -> None:
    """Show the search of one window along its row.

    Parameters
    ----------
    pair : NormalPair
    place : array_like (2,)
        (column, row) of the left window.
    window : int
        Pixels across it, odd.
    low, high : int
        Least and greatest disparity, px.
    """
    _validate.instance(pair, NormalPair, "pair")
    column, row = np.round(_validate.one_point(place, 2, "place")).astype(int)
    tried, r = along_row(pair.left, pair.right, column, row, window, low, high)
    best = int(r.argmax())
    fig = plt.figure(figsize=(10, 4.2), layout="constrained")
    one, strip, curve = fig.subplot_mosaic(
        "lr;lc", width_ratios=(1, 3), height_ratios=(1, 1.7)
    ).values()
    reach = (tried[-1] - tried[0]) // 2 + 14
    middle = column - (tried[0] + tried[-1]) // 2
    for ax, image, at, far, half, name in (
        (one, pair.left, column, 10, 10, "left: one window"),
        (strip, pair.right, middle, reach, 12, "right: the same row"),
    ):
        _bare(ax, image, name)
        ax.set(xlim=(at - far, at + far), ylim=(row + half, row - half))
    strip.set_aspect("auto")  # exactly above the curve
    frame: Look = {"fill": False, "lw": 2.5}
    for ax, at, colour in (
        (one, column, basic.ORANGE), (strip, column - tried[best], basic.ORANGE)
    ):  # fmt: skip
        ax.add_patch(
            plt.Rectangle(
                (at - window / 2, row - window / 2), window, window, ec=colour, **frame
            )
        )
    strip.axhline(row, color=basic.GREEN, lw=1.5)
    curve.plot(tried, r, "o-", color=basic.BLUE)
    curve.plot(tried[best], r[best], "o", color=basic.ORANGE, ms=14)
    curve.axhline(0.8, color=basic.BLACK, ls=":")
    curve.text(tried[0] - 3, 0.83, "0.8", fontsize=14, ha="right")
    curve.set(xlabel="disparity (px)", ylabel="r", ylim=(r.min() - 0.1, 1.1))
    curve.set_xlim(column - middle + reach, column - middle - reach)
    basic.show(
        fig,
        "Above, a window in the left photo and the same row of the right one with the"
        f" window where it fits best. Below, r over the disparity: {len(r)} values, the"
        f" highest {r[best]:.2f} at {tried[best]} px.",
        colours=96,
    )


def levels(pyramid: Sequence[NormalPair], matches: Sequence[DenseMatch]) -> Figure:
    """Draw the levels of a pyramid, from coarse to fine, and what is found on each.

    Parameters
    ----------
    pyramid : sequence of NormalPair
        From the finest to the coarsest, each of half the size of the one before.
    matches : sequence of DenseMatch
        What was found on each.

    Returns
    -------
    matplotlib.figure.Figure
        Left image above, disparities in px of the finest level below.
    """
    pyramid = list(_validate.several(pyramid, "pyramid"))
    matches = list(_validate.several(matches, "matches"))
    for pair in pyramid:
        _validate.instance(pair, NormalPair, "pyramid: a level")
    for match in matches:
        _validate.instance(match, DenseMatch, "matches: a level")
    n = len(pyramid)
    if n != len(matches) or not n:
        raise ValueError("pyramid and matches must have the same levels, at least one")
    full = [match.disparity * 2.0**k for k, match in enumerate(matches)]
    low, high = np.nanquantile(full[0], (0.01, 0.99))
    fig, axes = plt.subplots(
        2, n, figsize=(10, 4.7), layout="compressed", squeeze=False
    )
    for ax, below, k in zip(axes[0], axes[1], range(n - 1, -1, -1)):
        rows, columns = pyramid[k].left.shape
        _bare(ax, pyramid[k].left, f"level {k + 1}: {columns} × {rows}")
        _bare(below, np.zeros((rows, columns)), "")
        below.images[0].set_alpha(0)
        drawn = below.imshow(full[k], cmap="viridis", vmin=low, vmax=high)
    bar = fig.colorbar(drawn, ax=axes[1].tolist(), aspect=14)
    bar.set_label("disparity\n(px of level 1)", fontsize=16)
    bar.ax.tick_params(labelsize=16)
    return fig


def _both(left: Photo, right: Photo) -> tuple[Photo, Photo]:
    _validate.instance(left, Photo, "left")
    _validate.instance(right, Photo, "right")
    return left, right


def _bare(ax: Axes, image: np.ndarray, title: str) -> None:
    """Draw an image without numbers at its edges."""
    ax.imshow(np.nan_to_num(grey_levels(image, "image"), nan=1.0), vmin=0, vmax=1)
    ax.set(xticks=[], yticks=[])
    ax.set_title(title, fontsize=18)
    ax.grid(False)
