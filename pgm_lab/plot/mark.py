"""The floating mark: one mark in each photo, seen as one above or on the ground."""

import matplotlib.pyplot as plt
import numpy as np
import scipy
from ipywidgets import Dropdown, FloatSlider
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot._overlay import grey_levels
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import Look
from pgm_lab.stereo import NormalPair

GLASSES = "red and cyan (with glasses)"
COLOURS = "green and magenta"
SIZE = 41  # px across what is shown
EXTENT = (-SIZE / 2, SIZE / 2, SIZE / 2, -SIZE / 2)


def positions(pair: NormalPair, place: ArrayLike, disparities: ArrayLike) -> None:
    """Show the mark at several disparities, one panel each.

    Parameters
    ----------
    pair : NormalPair
        Two photos in the normal case.
    place : array_like (2,)
        (column, row) of the left mark, whole pixels.
    disparities : array_like (n,)
        Left column minus right column of the two marks, px.
    """
    column, row = _place(pair, place)
    several = _validate.finite(disparities, "disparities").ravel()
    fig, axes = plt.subplots(
        1, len(several), figsize=(7, 3.1), layout="compressed", squeeze=False
    )
    for ax, d in zip(axes[0], several):
        _two_colours(ax, pair, column, row, float(d), COLOURS)
        Z = float(pair.object_points(column, row, d)[2])
        ax.set_title(f"{_minus(d)} px: {Z:.1f} m")
    words = "disparity, height of the mark; green: left, magenta: right photo"
    fig.supxlabel(words, fontsize=14)
    basic.show(
        fig,
        "The surroundings of one point from both photos in two colours, laid on each"
        " other so that the two marks coincide, for disparities of "
        + ", ".join(map(_minus, several))
        + " px. Where a panel is grey around the mark, the mark is on the ground.",
        colours=128,
    )


def by_hand(
    pair: NormalPair, place: ArrayLike, start: float = 0.0, reach: float = 12.0
) -> None:
    """Show the two marks side by side and laid on each other, with a slider.

    The left mark stays on its point, the slider moves the right one along the row.

    Parameters
    ----------
    pair : NormalPair
        Two photos in the normal case.
    place : array_like (2,)
        (column, row) of the left mark, whole pixels.
    start : float
        Disparity of the slider before it is moved, px.
    reach : float
        How far the slider goes to each side, px.
    """
    column, row = _place(pair, place)
    start = _validate.number(start, "start")
    reach = _validate.positive_number(reach, "reach", "pixels")

    def draw(disparity: float, colours: str) -> None:
        d = float(disparity)
        fig, axes = plt.subplots(1, 3, figsize=(10, 4.1), layout="compressed")
        shown = pair.left, pair.right
        for ax, image, at, name in zip(axes, shown, (0.0, d), ("left", "right")):
            ax.imshow(_part(image, column - at, row), extent=EXTENT, vmin=0, vmax=1)
            _mark(ax, basic.YELLOW)
            ax.set_xticks(range(-20, 21, 10))
            ax.set_title(f"{name} photo")
        _two_colours(axes[2], pair, column, row, d, colours)
        axes[2].set(title="both", xticks=range(-20, 21, 10))
        fig.supxlabel("columns from the mark (px)", fontsize=14)
        Z = float(pair.object_points(column, row, d)[2])
        fig.suptitle(f"disparity {_minus(d)} px: the mark stands at Z = {Z:.1f} m")
        basic.show(
            fig,
            f"{SIZE} by {SIZE} pixels of the left and of the right photo, a mark in the"
            f" middle of each, and both laid on each other in {colours}: the marks"
            f" coincide, the ground around them may not. Disparity {_minus(d)} px.",
            colours=128,
        )

    look: Look = {"step": 0.5, "continuous_update": False, "description": "disparity"}
    slider = FloatSlider(start, min=start - reach, max=start + reach, **look)
    names = Dropdown(options=[COLOURS, GLASSES], description="colours")
    interact(draw, disparity=slider, colours=names)


def _place(pair: NormalPair, place: ArrayLike) -> tuple[int, int]:
    _validate.instance(pair, NormalPair, "pair")
    column, row = np.round(_validate.one_point(place, 2, "place")).astype(int)
    half = SIZE // 2
    rows, columns = pair.left.shape
    if not (half <= column < columns - half and half <= row < rows - half):
        raise ValueError(
            f"the part of {SIZE} x {SIZE} pixels around the place ({column}, {row})"
            f" leaves the image of {rows} rows and {columns} columns"
        )
    return int(column), int(row)


def _part(image: np.ndarray, column: float, row: float) -> np.ndarray:
    """Grey levels from 0 to 1 around a place, between the pixels by a line."""
    step = np.arange(SIZE) - SIZE // 2
    places = np.meshgrid(row + step, column + step, indexing="ij")
    part = scipy.ndimage.map_coordinates(image, places, order=1, mode="nearest")
    return grey_levels(part, "image")


def _two_colours(
    ax: Axes, pair: NormalPair, column: int, row: int, d: float, colours: str
) -> None:
    """Lay the surroundings of both marks on each other."""
    left, right = _part(pair.left, column, row), _part(pair.right, column - d, row)
    red = colours == GLASSES
    stack = [left, right, right] if red else [right, left, right]
    ax.imshow(np.nan_to_num(np.stack(stack, axis=-1), nan=1.0), extent=EXTENT)
    _mark(ax, basic.BLACK)


def _minus(d: float) -> str:
    return f"{d:.1f}".replace("-", "−")


def _mark(ax: Axes, colour: str) -> None:
    """Draw the mark in the middle, and nothing at the edges."""
    for width, ink in (
        (5.0, "white" if colour == basic.BLACK else "black"),
        (2, colour),
    ):
        ax.plot(0, 0, "+", color=ink, ms=22 + width, mew=width)
    ax.set(xticks=[], yticks=[])
    ax.grid(False)
