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

LABEL: Look = {
    "fontsize": 15,
    "bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.88, "pad": 3},
}
ARROW: Look = {"arrowstyle": "-|>", "linewidth": 2.4}
RANGE: Look = {
    "arrowstyle": "<->",
    "linewidth": 3.0,
    "shrinkA": 0,
    "shrinkB": 0,
}


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
    fig, axes = plt.subplots(1, 3, figsize=(14, 5.2), width_ratios=(0.86, 0.86, 1))
    for ax, image, name in zip(axes, (reference, sensed), ("reference", "sensed")):
        ax.imshow(grey_levels(image, name), vmin=0, vmax=1)
        far = room + 5
        ax.set(xlim=(x - far, x + far), ylim=(y + far, y - far), title=f"{name} image")
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    left, right = axes[0], axes[1]
    outline(left, (x, y), chip, basic.ORANGE, linewidth=4)
    left.plot(x, y, "+", color=basic.ORANGE, markersize=22, markeredgewidth=3.5)
    left.text(x - half, y - half - 1, f"chip, {chip} × {chip}", va="bottom", **LABEL)
    left.annotate("point", (x, y), (x + 4, y + 6), arrowprops=ARROW, **LABEL)
    outline(right, (x, y), 2 * room, basic.SKY, linewidth=4)
    outline(right, (x, y), chip, basic.ORANGE, linewidth=3, linestyle=":")
    outline(right, (x + dx, y + dy), chip, basic.ORANGE, linewidth=4)
    right.text(
        x, y - room - 1, "blue: search window", ha="center", va="bottom", **LABEL
    )
    right.annotate(
        "", (x - room, y), (x - half, y), arrowprops=RANGE | {"color": basic.BLUE}
    )
    right.text(x - half + 0.6, y, f"radius {radius}", va="center", **LABEL)
    look = ARROW | {"color": basic.ORANGE, "linewidth": 4, "shrinkA": 0, "shrinkB": 0}
    below = y + 0.55 * half
    right.annotate("", (x + dx, below + dy), (x, below), arrowprops=look)
    right.text(x + max(dx, 0) + 0.8, below, "shift", va="center", **LABEL)
    right.text(
        x,
        y + room + 0.4,
        "orange: chip at its best place\n(dotted: at the same place)",
        ha="center",
        va="top",
        **LABEL | {"fontsize": 13},
    )
    table_of_r(axes[2], r, numbers=True)
    close = [
        f"({j - radius}, {i - radius})" for i, j in np.argwhere(r >= r.max() - 0.1)
    ]
    axes[2].set_title("r for every shift")
    basic.show(
        fig,
        f"Left, the reference image with a chip of {chip} by {chip} pixels around a"
        f" point. Middle, the sensed image with a search window that reaches {radius}"
        " pixels farther to each side; in it the chip at its best place, and an arrow,"
        f" the shift ({dx}, {dy}). Right, r for every shift as a map of"
        f" {len(r)} by {len(r)} squares with their numbers, the highest, {r.max():.2f},"
        f" framed. Within 0.1 of it are the shifts {', '.join(close)}; the lowest r is"
        f" {r.min():.2f}.",
        dpi=100,
        colours=128,
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
        text = f"{value:.2f}".replace("-", "−")
        ax.text(
            step[j], step[i], text, ha="center", va="center", color=ink, fontsize=14
        )


def map_of_r(r: ArrayLike) -> Figure:
    """Draw the correlations of one search, with their numbers.

    Parameters
    ----------
    r : array_like (2 radius + 1, 2 radius + 1)
        From `registration.best_shift`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    fig, ax = plt.subplots(figsize=(7.4, 6.6))
    table_of_r(ax, r, numbers=True)
    ax.set_title("r for every shift of one chip")
    return fig


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
    fig, ax = plt.subplots(figsize=(8.6, 8.2))
    ax.imshow(grey_levels(image, "image"), vmin=0, vmax=1)
    ax.grid(False)
    for point in points:
        outline(ax, point, chip, basic.ORANGE, linewidth=2.2)
    ax.set_xlabel("column (px)", fontsize=20)
    ax.set_ylabel("row (px)", fontsize=20)
    ax.tick_params(labelsize=18)
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
    fig, ax = plt.subplots(figsize=(10, 5))
    ax.plot(t, r_middle + slope * t + half * t**2, color=basic.BLUE, label="parabola")
    ax.plot((-1, 0, 1), (r_left, r_middle, r_right), "o", color=basic.BLACK, ms=13)
    ax.vlines(top, 0, height, color=basic.RED, linestyle="--", label="peak, at t")
    ax.plot(top, height, "X", color=basic.RED, markersize=15)
    names = ("$r_{left}$", "$r_{middle}$", "$r_{right}$")
    for x, r, name in zip((-1, 0, 1), (r_left, r_middle, r_right), names):
        text: Look = {"textcoords": "offset points", "fontsize": 18, "ha": "right"}
        ax.annotate(name, (x, r), (-12, 6), **text)
    ax.set(ylim=(min(r_left, r_right) - 0.35 * span, height + 0.25 * span))
    ax.set(
        xlabel="t, shift from the highest whole pixel (px)",
        ylabel="r",
        xticks=(-1, 0, 1),
    )
    ax.legend(loc="upper right")
    return fig
