"""Figures of stereo plotting: from two photos to a surface, and what it is worth."""

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
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import DenseMatch, NormalPair, Surface, Terrain, quality
from pgm_lab.stereo.textbook import along_row

NAMES = ("left photo", "right photo")
BAND = 60  # px shown to each side of a row
FAR = 1e9  # m: no coordinate is so large
CONTOURS = 2.5  # m, as in Harintaka 2020


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
        "Both photos in two colours, laid on each other. Around the middle the"
        " ground is grey and fits. Roofs and tree tops have rims in both colours to"
        " their left and right, and so has the ground where it is higher or lower.",
        colours=96,
    )


def epipolar_line(
    left: Photo, right: Photo, pixel: ArrayLike, line: ArrayLike, places: ArrayLike
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
        Pixels of the right photo, where the point lies at heights 20 m apart.
    """
    column, row = _validate.one_point(pixel, 2, "pixel")
    line = _validate.point_list(line, "line")
    places = _validate.point_list(places, "places")
    fig, axes = plt.subplots(1, 2, figsize=(10, 3.0), layout="compressed")
    for ax, photo, name in zip(axes, _both(left, right), NAMES):
        _bare(ax, photo.grey, name)
        last = photo.grey.shape[0] - 0.5
        ax.set_ylim(min(row + 1.4 * BAND, last), max(row - 1.4 * BAND, -0.5))
    look: Look = {"ms": 20, "mew": 3, "color": basic.ORANGE}
    axes[0].plot(column, row, "+", **look)
    axes[1].autoscale(False)
    axes[1].plot(*line.T, color=basic.GREEN, lw=2)
    axes[1].plot(*places.T, "|", ms=18, mew=3, color=basic.ORANGE)
    basic.show(
        fig,
        "Left photo with a cross at one point; right photo with a straight line across"
        f" it, hardly tilted, and {len(places)} strokes on it where the point would lie"
        " if it were at heights 20 m apart.",
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
    fig, axes = plt.subplots(2, 2, figsize=(10, 3.9), layout="compressed")
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
    fig = plt.figure(figsize=(10, 3.8), layout="constrained")
    one, strip, curve = fig.subplot_mosaic(
        "lr;cc", width_ratios=(1, 3.4), height_ratios=(1, 1.3)
    ).values()
    half, reach = 16, (tried[-1] - tried[0]) // 2 + 14
    middle = column - (tried[0] + tried[-1]) // 2
    for ax, image, at, far, name in (
        (one, pair.left, column, half, "left: one window"),
        (strip, pair.right, middle, reach, "right: the same row"),
    ):
        _bare(ax, image, name)
        ax.set(xlim=(at - far, at + far), ylim=(row + half, row - half))
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
    curve.text(tried[0], 0.83, "0.8", fontsize=13)
    curve.set(xlabel="disparity (px)", ylabel="r", ylim=(min(-0.4, r.min()), 1.05))
    curve.invert_xaxis()
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


def threshold(error: ArrayLike, r: ArrayLike, limit: float = 0.8) -> None:
    """Show what a threshold of r keeps of right and of wrong heights.

    Parameters
    ----------
    error : array_like (n,)
        Errors of the heights, m; more than a metre counts as wrong.
    r : array_like (n,)
        Correlation of each.
    limit : float
        Threshold to be marked.
    """
    error, r = _validate.finite(error, "error"), _validate.finite(r, "r")
    limit = _validate.number(limit, "limit")
    wrong = np.abs(error) > 1
    if error.ndim != 1 or error.shape != r.shape or wrong.all() or not wrong.any():
        raise ValueError(
            "error and r must be lists of the same length, with an error below a metre"
            " and one above"
        )
    at = np.linspace(-0.2, 1, 121)
    fig, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
    said = []
    for kind, name, colour, line in (
        (~wrong, "right within 1 m", basic.BLUE, "-"),
        (wrong, "wrong", basic.RED, "--"),
    ):
        share = 100 * np.mean(r[kind][:, None] >= at, axis=0)
        kept = 100 * float(np.mean(r[kind] >= limit))
        ax.plot(at, share, color=colour, ls=line, label=name)
        ax.plot(limit, kept, "o", color=colour, ms=11)
        said.append(f"{kept:.0f} % of the {name} ones")
        text: Look = {"textcoords": "offset points", "color": colour, "fontsize": 15}
        ax.annotate(f"{kept:.0f} %", (limit, kept), (10, 2), **text)
    ax.axvline(limit, color=basic.BLACK, ls=":", lw=1.5)
    ax.set(xlabel="threshold of r", ylabel="kept (%)", xlim=(0, 1), ylim=(0, 104))
    ax.legend(loc="lower left")
    basic.show(
        fig,
        "Share of the right and of the wrong heights that a threshold of r keeps. At"
        f" {limit:g} it keeps {' and '.join(said)}.",
        colours=64,
    )


def errors(error: ArrayLike, sigma: float) -> None:
    """Show measured errors of heights beside the predicted normal curve.

    Parameters
    ----------
    error : array_like (n,)
        Errors in m.
    sigma : float
        Predicted standard deviation in m.
    """
    error = _validate.finite(error, "error").ravel()
    sigma = _validate.positive_number(sigma, "sigma", "m")
    if not error.size:
        raise ValueError("error must have at least one number")
    far = 6 * sigma
    nmad = 1.4826 * float(np.median(np.abs(error - np.median(error))))
    fig, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
    n, edges, _ = ax.hist(
        error, np.linspace(-far, far, 61).tolist(), color=basic.SKY, label="measured"
    )
    x = np.linspace(-far, far, 300)
    width = edges[1] - edges[0]
    bell = np.exp(-((x / sigma) ** 2) / 2) / sigma / np.sqrt(2 * np.pi)
    ax.plot(x, bell * width * len(error), color=basic.BLACK, label="predicted")
    ax.set(xlabel="error of the height (m)", ylabel="points", yticks=[])
    ax.legend(loc="upper left")
    basic.show(
        fig,
        f"Histogram of the errors of {len(error)} heights, NMAD {nmad:.2f} m, with the"
        f" predicted normal curve of standard deviation {sigma:.2f} m.",
        colours=64,
    )


def profile(own: ArrayLike, book: ArrayLike, land: Landscape) -> None:
    """Show heights along a row by the reader's program, by pgm_lab, and the truth.

    Parameters
    ----------
    own, book : array_like (n, 3)
        X, Y, Z in m of pixels in a row; NaN where there is none.
    land : Landscape
        The truth.
    """
    dots, line = _known(own, "own"), _known(book, "book")
    _validate.instance(land, Landscape, "land")
    both = np.concatenate([line, dots])
    X = np.linspace(both[:, 0].min(), both[:, 0].max(), 600)
    Y = np.polyval(np.polyfit(both[:, 0], both[:, 1], 1), X)
    ground, top = land.at(land.dtm, X, Y).ravel(), land.at(land.dsm, X, Y).ravel()
    fig, ax = plt.subplots(figsize=(10, 3.7), layout="constrained")
    ax.fill_between(X, ground, top, color="0.78", label="house and trees, true")
    ax.fill_between(X, ground.min() - 2, ground, color="0.5", label="ground, true")
    gaps = np.asarray(book, float)
    look: Look = {"color": basic.SKY, "lw": 6, "label": "pgm_lab"}
    ax.plot(gaps[:, 0], gaps[:, 2], **look)
    ax.plot(dots[:, 0], dots[:, 2], ".", color=basic.RED, ms=9, label="your program")
    ax.set(xlabel="X (m)", ylabel="Z (m)")
    ax.set_ylim(ground.min() - 2, top.max() + 3)
    fig.legend(loc="outside lower center", ncols=4, handlelength=1.4)
    off = np.abs(dots[:, 2] - land.at(land.dsm, dots[:, 0], dots[:, 1]).ravel())
    basic.show(
        fig,
        f"Profile of true ground with a house and trees on it, and heights by two"
        f" programs. {np.mean(off < 1) * 100:.0f} % of the {len(dots)} heights of the"
        " first follow the surface within a metre, over roofs and crowns.",
        colours=96,
    )


def terrain(dsm: Surface, dtm: Terrain, land: Landscape) -> None:
    """Show a measured surface and its terrain with contours, and how good they are.

    Parameters
    ----------
    dsm : Surface
    dtm : Terrain
        On the grid of the surface.
    land : Landscape
        The truth.
    """
    _validate.instance(dsm, Surface, "dsm")
    _validate.instance(dtm, Terrain, "dtm")
    _validate.instance(land, Landscape, "land")
    rows, columns = dsm.z.shape
    X, Y = np.meshgrid(
        dsm.corner[0] + dsm.cell * np.arange(columns),
        dsm.corner[1] - dsm.cell * np.arange(rows),
    )
    truth, kind = land.at(land.dtm, X, Y), land.at(land.kind, X, Y, 0)
    error = dtm.z - truth
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9), layout="compressed")
    axes[0].imshow(_shaded(dsm.z, dsm.cell), vmin=-0.4, vmax=1)
    axes[0].set_title("surface (DSM), contours")
    drawn = axes[1].imshow(error, cmap="PuOr", vmin=-0.5, vmax=0.5)
    axes[1].set_title("terrain (DTM), errors")
    for ax, z in zip(axes, (dsm.z, dtm.z)):
        steps = np.arange(0, 100, CONTOURS)
        ax.contour(z, steps, colors=basic.BLACK, linewidths=1.2)
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    names = ("open", "houses", "trees")
    said = [
        f"{quality(dtm.z, truth, kind == k).rmse:.2f} m {name}"
        for k, name in enumerate(names)
        if np.any(np.isfinite(error[kind == k]))
    ]
    bar = fig.colorbar(drawn, ax=axes.tolist(), location="bottom", aspect=40, pad=0.03)
    words = f"terrain − truth (m): RMSE {', '.join(said)}"
    bar.set_label(words, fontsize=14)
    basic.show(
        fig,
        f"Two maps with contours every {CONTOURS} m. Those of the surface pile up at"
        " houses and crowns; those of the terrain run smoothly. Its errors, in colours,"
        f" are small in the fields and larger in the wood: RMSE {', '.join(said)}.",
        colours=96,
    )


def _known(points: ArrayLike, name: str) -> np.ndarray:
    """Points (n, 3) without those that are NaN; at least two."""
    array = _validate.real(points, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must have shape (n, 3); got {array.shape}")
    known = array[np.abs(array).max(axis=1, initial=0) < FAR]
    if len(np.unique(known[:, 0])) < 2:
        raise ValueError(f"{name} must have two points of different X that are not NaN")
    return np.asarray(known)


def _shaded(z: np.ndarray, cell: float) -> np.ndarray:
    """Light from the upper left on a surface, from 0 to 1; white outside."""
    south, east = np.gradient(z, cell)
    light = (1 + 0.7 * east + 0.7 * south) / np.sqrt(2 * (1 + east**2 + south**2))
    return np.where(np.isfinite(light), np.clip(light, 0, 0.97), 1.0)


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
