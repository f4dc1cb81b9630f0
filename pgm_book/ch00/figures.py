"""The figures of the first chapter: one point in a photo, and the two frames."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from pgm_lab import frames, plot
from pgm_lab.plot.basic import Look

SMALL = 12, 8  # pixels of the image of the sketch


def computed_and_printed(
    computed: np.ndarray, printed: np.ndarray, sensor_size: np.ndarray
) -> None:
    """Show a point on the sensor as it was computed and as it was printed."""
    width, height = sensor_size
    fig, ax = plt.subplots(figsize=(10, 6.2), layout="constrained")
    ax.add_patch(
        plt.Rectangle(
            (-width / 2, -height / 2), width, height, facecolor="none",
            edgecolor=plot.GREY, linewidth=2, label="edge of the sensor",
        )
    )  # fmt: skip
    axis = 0.42 * height
    plot.frame(ax, (0, 0), (axis, 0), (0, axis), color=plot.BLACK)
    look: Look = {"linestyle": "none", "markersize": 14, "markeredgewidth": 3}
    ax.plot(*computed, "o", color=plot.BLUE, label="computed", **look)
    ax.plot(*printed, "x", color=plot.ORANGE, label="printed", **look)
    ax.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    ax.set(xlim=(-0.54 * width, 0.54 * width), ylim=(-0.56 * height, 0.56 * height))
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    plot.show(
        fig,
        f"The sensor with its centre as origin, x to the right and y up. The point is"
        f" computed at x = {computed[0]:.2f}, y = {computed[1]:.2f} mm, and printed at"
        f" x = {printed[0]:.2f}, y = {printed[1]:.2f} mm.",
    )


def two_frames() -> None:
    """Show the same image with pixel coordinates and with photo coordinates."""
    columns, rows = SMALL
    fig, (left, right) = plt.subplots(1, 2, figsize=(7, 2.9), layout="constrained")
    for ax in (left, right):
        _pixels(ax)
    plot.frame(left, (0, 0), (4, 0), (0, 3), ("X", "Y"), color=plot.BLUE)
    column, row = frames.image_centre(SMALL)
    tips = (column + 4, row), (column, row - 3)
    plot.frame(right, (column, row), *tips, color=plot.RED)
    point = 9, 1
    for ax, name in ((left, "(9, 1) px"), (right, "x > 0, y > 0")):
        ax.plot(*point, "o", color=plot.BLACK, markersize=10)
        ax.annotate(
            name, point, xytext=(0, -22), textcoords="offset points", fontsize=13,
            ha="center", va="center", bbox={"facecolor": "white", "linewidth": 0},
        )  # fmt: skip
    left.set_title("pixels X, Y (px)")
    right.set_title("photo x, y (mm)")
    plot.show(
        fig,
        f"The same image of {columns} by {rows} pixels twice, with a point in its upper"
        " right quarter. Pixel coordinates start at the centre of the first pixel, at"
        " the upper left, with Y down: the point is at (9, 1). Photo coordinates start"
        " at the centre of the image with y up: x and y of the point are positive.",
    )


def _pixels(ax: Axes) -> None:
    """Draw the borders of all pixels."""
    columns, rows = SMALL
    for k in range(columns + 1):
        ax.plot([k - 0.5, k - 0.5], [-0.5, rows - 0.5], color=plot.GREY, linewidth=0.7)
    for k in range(rows + 1):
        line = [-0.5, columns - 0.5], [k - 0.5, k - 0.5]
        ax.plot(*line, color=plot.GREY, linewidth=0.7)
    ax.set(xlim=(-1, columns), ylim=(rows, -1), aspect="equal")
    ax.axis("off")
