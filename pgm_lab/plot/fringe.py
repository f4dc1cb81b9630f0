"""Figures of two images that do not lie on each other: changes, and their fringe."""

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot._overlay import grey_levels, overlay
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import Look

REACH = 4  # px that the sliders go to each side


def changes(reference: ArrayLike, sensed: ArrayLike, limit: float = 300.0) -> Figure:
    """Draw two images side by side, and where their grey values differ.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    limit : float
        Pixels that differ by more grey values than this count as changed.

    Returns
    -------
    matplotlib.figure.Figure
    """
    one, other = _alike(reference, sensed)
    limit = _validate.not_negative(limit, "limit", "grey values")
    tall = one.shape[0] > 0.8 * one.shape[1]
    fig = plt.figure(figsize=(10, 4.1), layout="compressed")
    names = ("reference", "sensed")
    # Side by side, or two small ones beside a large one
    axes = fig.subplot_mosaic("rsc" if tall else "rcc;scc")
    for name, image in zip(names, (one, other)):
        axes[name[0]].imshow(grey_levels(image, name), vmin=0, vmax=1)
        axes[name[0]].set_title(f"{name} image")
    changed = np.abs(other - one) > limit
    share, gap = 100 * changed.mean(), "\n" if tall else " "
    axes["c"].imshow(changed, cmap="binary", interpolation="nearest")
    axes["c"].set_title(
        f"black: differ by more{gap}than {limit:g} grey values, {share:.0f} %"
    )
    for ax in axes.values():
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    for side in ("top", "right"):
        axes["c"].spines[side].set_visible(True)
    return fig


def two_colours(
    reference: ArrayLike, sensed: ArrayLike, centre: ArrayLike, size: int = 61
) -> None:
    """Show a part of both images laid on each other in two colours, and as difference.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    centre : array_like (2,)
        (column, row) of the part.
    size : int
        Pixels across the part, odd.
    """
    one, other = _alike(reference, sensed)
    window, extent = _part(one.shape, centre, size)
    fig, axes = plt.subplots(1, 2, figsize=(7, 4.1), layout="compressed")
    overlay(one[window], other[window], ax=axes[0])
    axes[0].images[0].set_extent(extent)
    axes[0].set_title("green: reference,\nmagenta: sensed")
    change = (other - one)[window]
    far = _far(change)
    axes[1].imshow(change, extent=extent, cmap="gray", vmin=-far, vmax=far)
    axes[1].set(title="sensed − reference,\nin grey", xlabel="column (px)", yticks=[])
    axes[1].grid(False)
    basic.show(
        fig,
        "A part of both images, one on the other, the reference in green and the sensed"
        " one in magenta. The fields are grey, so both show the same. Along every edge"
        " of a field runs a narrow fringe, green on one side and magenta on the other."
        " Beside it the difference: level grey in the fields, a white or a black line"
        " along their edges.",
    )


def before_and_after(
    reference: ArrayLike, sensed: ArrayLike, again: ArrayLike, limit: float = 300.0
) -> None:
    """Show what counts as changed, before and after the sensed image was resampled.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    again : array_like (rows, columns)
        Those of the sensed image in the pixels of the reference; masked or NaN where
        there are none.
    limit : float
        As for `changes`.
    """
    limit = _validate.not_negative(limit, "limit", "grey values")
    pairs = _alike(reference, sensed), _alike(reference, again, "again")
    fig, axes = plt.subplots(1, 2, figsize=(7, 4), layout="compressed")
    shares = []
    for ax, (one, other), name in zip(axes, pairs, ("before", "after")):
        changed = np.abs(other - one) > limit
        shares.append(100 * changed.sum() / max(1, np.isfinite(other - one).sum()))
        ax.imshow(changed, cmap="binary", interpolation="nearest")
        ax.set(xticks=[], yticks=[], title=f"{name}: {shares[-1]:.0f} % changed")
        ax.grid(False)
        ax.spines[["top", "right"]].set_visible(True)
    basic.show(
        fig,
        f"Two maps of change, black on white. Before, {shares[0]:.0f} % of the land is"
        f" black, every street and every edge of a field. After, {shares[1]:.0f} %:"
        " what is left are tilted squares, whole fields, on an almost empty ground.",
        colours=8,
    )


def by_hand(
    reference: ArrayLike, sensed: ArrayLike, centre: ArrayLike, size: int = 25
) -> None:
    """Show a part of both images with a line a pixel, and sliders that draw one back.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    centre : array_like (2,)
        (column, row) of the part, at least `size` / 2 + 4 pixels from the edge.
    size : int
        Pixels across the part, odd.
    """
    one, other = _alike(reference, sensed)
    window, extent = _part(one.shape, centre, size)
    _part(one.shape, centre, size + 2 * REACH)  # room for the sliders
    rows, columns = window
    panels: Look = {"sharey": True, "layout": "compressed"}
    far = _far(other[window] - one[window])

    def draw(dx: int, dy: int) -> None:
        moved = other[_moved(rows, dy), _moved(columns, dx)]
        fig, (left, right) = plt.subplots(1, 2, figsize=(10, 5.2), **panels)
        overlay(one[window], moved, ax=left)
        left.images[0].set_extent(extent)
        change = moved - one[window]
        look: Look = {"cmap": "gray", "vmin": -far, "vmax": far}
        right.imshow(change, extent=extent, interpolation="nearest", **look)
        right.grid(False)
        for ax in (left, right):
            _line_a_pixel(ax, extent)
            ax.set(xlabel="column (px)")
        left.set_title("green: reference, magenta: sensed")
        right.set_title("sensed − reference, in grey")
        drawn = f"sensed image drawn back by {dx} columns and {dy} rows"
        fig.suptitle(drawn)
        basic.show(
            fig,
            f"A part of both images of {size} by {size} pixels, in two colours and as"
            f" difference, with a thin line between any two pixels; {drawn}.",
        )

    look: Look = {"min": -REACH, "max": REACH, "continuous_update": False}
    dx = IntSlider(0, description="columns", **look)
    interact(draw, dx=dx, dy=IntSlider(0, description="rows", **look))


def _alike(
    reference: ArrayLike, sensed: ArrayLike, name: str = "sensed"
) -> tuple[np.ndarray, np.ndarray]:
    """Both images, of the same shape; float, with NaN where `again` has no data."""
    one = _validate.image(reference, "reference").astype(float)
    if name == "again":
        grey = _validate.grey_image(sensed, name)
        mask = np.ma.getmaskarray(grey)
        other = np.where(mask, np.nan, np.ma.getdata(grey).astype(float))
    else:
        other = _validate.image(sensed, name).astype(float)
    if one.shape != other.shape:
        raise ValueError(
            f"reference has shape {one.shape} and {name} {other.shape}; cut or"
            " resample one of them, so that both have the same pixels"
        )
    return one, other


def _part(
    shape: tuple[int, ...], centre: ArrayLike, size: int
) -> tuple[tuple[slice, slice], tuple[float, float, float, float]]:
    """Rows and columns of a square part, and its (left, right, bottom, top) edges."""
    size = _validate.window(size, "size", 1)
    far = max(shape) + size
    x, y = np.clip(np.floor(_validate.one_point(centre, 2, "centre") + 0.5), -far, far)
    left, top = int(x) - size // 2, int(y) - size // 2
    if min(left, top) < 0 or left + size > shape[1] or top + size > shape[0]:
        raise ValueError(
            f"the part of {size} x {size} pixels around the centre ({x:.0f}, {y:.0f})"
            f" leaves the image of {shape[0]} rows and {shape[1]} columns"
        )
    edges = (left - 0.5, left + size - 0.5, top + size - 0.5, top - 0.5)
    return (slice(top, top + size), slice(left, left + size)), edges


def _far(change: np.ndarray) -> float:
    """Difference that is drawn white, and black with a minus; few are larger."""
    return max(float(np.quantile(np.abs(change), 0.99)), 1e-9)


def _moved(part: slice, step: int) -> slice:
    return slice(part.start + step, part.stop + step)


def _line_a_pixel(ax: Axes, extent: tuple[float, float, float, float]) -> None:
    """Draw a thin line between pixels, and name every fifth."""
    left, right, bottom, top = extent
    look: Look = {"color": "0.7", "linewidth": 0.6, "alpha": 0.7}
    for x in np.arange(left, right + 0.1):
        ax.axvline(x, **look)
    for y in np.arange(top, bottom + 0.1):
        ax.axhline(y, **look)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MultipleLocator(5))
