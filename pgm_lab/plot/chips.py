"""Figures of registration by chips: the search, its map, where the chips lie."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import _doors, basic
from pgm_lab.plot._overlay import grey_levels
from pgm_lab.plot.basic import Look
from pgm_lab.plot.matching import outline
from pgm_lab.registration import best_shift, peak_of_parabola

CHIP = 21  # px across, as in the paper
LABEL: Look = {
    "fontsize": 14,
    "bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.88, "pad": 2},
}
ARROW: Look = {"arrowstyle": "-|>", "linewidth": 2.4}
BAR = "|-|, widthA=0.4, widthB=0.4"
EXACT: Look = {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 12, "linewidth": 2.2}


def search(
    reference: ArrayLike,
    sensed: ArrayLike,
    point: ArrayLike,
    chip: int = 21,
    radius: int = 3,
) -> None:
    """Show the search for one chip on the images themselves, its parts named.

    Parameters
    ----------
    reference, sensed, point, chip, radius
        As for `registration.best_shift`.
    """
    dx, dy, r = best_shift(reference, sensed, point, chip, radius)
    x, y = np.floor(_validate.one_point(point, 2, "point") + 0.5)
    half, room = chip / 2, chip / 2 + radius
    panels: Look = {"width_ratios": (0.85, 0.85, 1), "wspace": 0.08}
    fig, axes = plt.subplots(
        1, 3, figsize=(10, 4.1), layout="compressed", gridspec_kw=panels
    )
    left, right, numbers = axes
    for ax, image, name in zip(axes, (reference, sensed), ("reference", "sensed")):
        _photo(ax, image, name, (x, y), room + 4)
        ax.set_title(f"{name} image")
    outline(left, (x, y), chip, basic.ORANGE, linewidth=3)
    left.plot(x, y, "+", color=basic.ORANGE, markersize=18, markeredgewidth=3)
    left.annotate("point", (x, y), (x + 2, y + 6), arrowprops=ARROW, **LABEL)
    left.set_xlabel(f"solid: chip, {chip} × {chip} px", loc="left")
    outline(right, (x, y), 2 * room, basic.SKY, linewidth=3, linestyle="--")
    outline(right, (x, y), chip, basic.ORANGE, linewidth=2.5, linestyle=":")
    outline(right, (x + dx, y + dy), chip, basic.ORANGE, linewidth=3)
    look = EXACT | {"arrowstyle": BAR, "color": basic.BLUE}
    right.annotate("", (x - room, y - 4), (x - half, y - 4), arrowprops=look)
    right.text(x - half + 1, y - 4, f"radius {radius}", va="center", **LABEL)
    look = EXACT | {"arrowstyle": "-|>", "color": basic.BLACK}
    right.annotate("", (x + dx, y + 6 + dy), (x, y + 6), arrowprops=look)
    right.text(x + max(dx, 0) + 1, y + 6, "shift", va="center", **LABEL)
    words = "dashed: search window\ndotted: same place\nsolid: best place"
    right.set_xlabel(words, loc="left")
    table_of_r(numbers, r, numbers=True)
    numbers.set_title("r for every shift")
    basic.show(
        fig,
        f"Left, the reference image with a chip of {chip} by {chip} pixels around a"
        f" point. Middle, the sensed image with a search window that reaches {radius}"
        " pixels farther to each side; in it the chip at its best place, and an arrow,"
        f" the shift ({dx}, {dy}). Right, r for every shift as a map of"
        f" {len(r)} by {len(r)} squares with their numbers, {_words(r)}",
    )


def chip_and_map(reference: ArrayLike, point: ArrayLike, r: ArrayLike) -> None:
    """Show a chip, and beside it what its search found: r for every shift.

    Parameters
    ----------
    reference : array_like (rows, columns)
        Grey values.
    point : array_like (2,)
        (column, row) of the chip's middle.
    r : array_like (2 radius + 1, 2 radius + 1)
        From `registration.best_shift`, of a chip of 21 pixels.
    """
    reference, r = _validate.image(reference, "reference"), _doors.square_map(r)
    x, y = np.floor(_validate.one_point(point, 2, "point") + 0.5)
    panels: Look = {"width_ratios": (0.72, 1), "wspace": 0.12}
    fig, (left, right) = plt.subplots(
        1, 2, figsize=(7, 4), layout="compressed", gridspec_kw=panels
    )
    _photo(left, reference, "reference", (x, y), CHIP / 2)
    left.set_title("chip")
    table_of_r(right, r, numbers=True)
    right.set_title("r for every shift")
    basic.show(
        fig,
        f"Left, a chip of {CHIP} by {CHIP} pixels. Right, r for every shift as a map of"
        f" {len(r)} by {len(r)} squares with their numbers, {_words(r)}",
    )


def _photo(
    ax: Axes, image: ArrayLike, name: str, centre: tuple[float, float], far: float
) -> None:
    """Draw an image as far as this from a point, without numbers at its edges."""
    x, y = centre
    ax.imshow(grey_levels(image, name), vmin=0, vmax=1)
    ax.set(xlim=(x - far, x + far), ylim=(y + far, y - far), xticks=[], yticks=[])
    ax.grid(False)


def _words(r: np.ndarray) -> str:
    """What a map of r shows: its summit, what comes near to it, and the lowest."""
    radius = len(r) // 2
    row, column = np.unravel_index(r.argmax(), r.shape)
    close = [
        f"({j - radius}, {i - radius})" for i, j in np.argwhere(r >= r.max() - 0.1)
    ]
    return (
        f"the highest, {r.max():.2f}, framed, at dx = {column - radius} and"
        f" dy = {row - radius}. Within 0.1 of it are the shifts {', '.join(close)}; the"
        f" lowest r is {r.min():.2f}."
    )


def table_of_r(ax: Axes, r: ArrayLike, numbers: bool = False) -> None:
    """Draw the correlations of a search by colour, over the shift.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    r : array_like (2 radius + 1, 2 radius + 1)
        From `registration.best_shift`.
    numbers : bool
        Write r into every field.
    """
    _doors.axes(ax)
    r = _doors.square_map(r)
    numbers = _validate.flag(numbers, "numbers")
    half = len(r) / 2
    low = float(min(r.min(), 0.0))
    ax.imshow(r, extent=(-half, half, half, -half), cmap="cividis", vmin=low, vmax=1)
    ax.grid(False)
    ax.set(xlabel="dx, columns (px)", ylabel="dy, rows (px)")
    step = [k - len(r) // 2 for k in range(len(r))]
    ax.set(xticks=step, yticks=step)
    row, column = np.unravel_index(r.argmax(), r.shape)
    outline(ax, (step[int(column)], step[int(row)]), 1, basic.RED, linewidth=4)
    for (i, j), value in np.ndenumerate(r if numbers else r[:0]):
        ink = "black" if value > 0.45 * (1 + low) else "white"
        middle: Look = {"ha": "center", "va": "center", "fontsize": 13}
        ax.text(step[j], step[i], _short(value), color=ink, **middle)


def _short(r: float) -> str:
    """Two decimals behind the point alone, as many books print r; 1.0 has one."""
    text = f"{r:.2f}".replace("-", "−")
    return text.replace("0.", ".", 1) if "0." in text else text[:-1]


def places(image: ArrayLike, points: ArrayLike, chip: int = 21) -> Figure:
    """Draw the chips on their image, with their numbers.

    Parameters
    ----------
    image : array_like (rows, columns)
        Grey values of the reference image.
    points : array_like (n, 2)
        (column, row) of their middles.
    chip : int
        Pixels across a chip.

    Returns
    -------
    matplotlib.figure.Figure
    """
    image = _validate.image(image)
    points = _validate.point_list(points, "points")
    chip = _validate.window(chip, "chip", 1)
    fig, ax = plt.subplots(figsize=(5.6, 5.2), layout="compressed")
    ax.imshow(grey_levels(image, "image"), vmin=0, vmax=1)
    ax.grid(False)
    for point in points:
        outline(ax, point, chip, basic.ORANGE, linewidth=1.6)
    ax.set(xlabel="column (px)", ylabel="row (px)")
    return fig


def parabola(r_left: float, r_middle: float, r_right: float) -> Figure:
    """Draw the parabola through three correlations, its parts named.

    Parameters
    ----------
    r_left, r_middle, r_right : float
        r at the shifts -1, 0 and 1 from the highest; the middle one is the highest.

    Returns
    -------
    matplotlib.figure.Figure
    """
    top = peak_of_parabola(r_left, r_middle, r_right)
    slope, half = (r_right - r_left) / 2, (r_left + r_right) / 2 - r_middle
    t = np.linspace(-1.35, 1.35, 200)
    height = r_middle + slope * top + half * top**2
    span = height - min(r_left, r_right)
    fig, ax = plt.subplots(figsize=(10, 3.4))
    ax.tick_params(labelsize=15)
    ax.plot(t, r_middle + slope * t + half * t**2, color=basic.BLUE, label="parabola")
    ax.plot((-1, 0, 1), (r_left, r_middle, r_right), "o", color=basic.BLACK, ms=13)
    ax.vlines(top, 0, height, color=basic.RED, linestyle="--", label="peak, at t")
    ax.plot(top, height, "X", color=basic.RED, markersize=15)
    names = ("$r_{left}$", "$r_{middle}$", "$r_{right}$")
    for x, r, name in zip((-1, 0, 1), (r_left, r_middle, r_right), names):
        text: Look = {"textcoords": "offset points", "fontsize": 19, "ha": "right"}
        ax.annotate(name, (x, r), (-12, 6), **text)
    ax.set(ylim=(min(r_left, r_right) - 0.35 * span, height + 0.25 * span))
    ax.set(
        xlabel="t, shift from the highest whole pixel (px)",
        ylabel="r",
        xticks=(-1, 0, 1),
    )
    ax.legend(loc="upper right", fontsize=15)
    return fig
