"""What stands in a drawn photo besides the polygons: the ground and the axes."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.patheffects import withStroke

from pgm_lab.plot import _horizon
from pgm_lab.plot.basic import BLACK


def draw_ground(
    ax: Axes,
    exterior: np.ndarray,
    M: np.ndarray,
    c: float,
    half: np.ndarray,
    color: str,
) -> None:
    """Fill the photo below the horizon, and write the directions on it."""
    if exterior[2] <= 0:
        raise ValueError(
            "with ground, the camera must stand above it, exterior[2] > 0; got"
            f" {exterior[2]}"
        )
    corners = half * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    land = _horizon.ground(M, c, corners)
    ax.add_collection(PolyCollection([land], facecolors=color), autolim=False)
    for name, (x, y) in _horizon.directions(M, c):
        if abs(x) < 0.92 * half[0] and abs(y) < 0.92 * half[1]:
            ax.text(x, y, name, fontsize=13, ha="center", va="center", zorder=3)


def draw_photo_axes(ax: Axes, c: float, colors: tuple[str, ...]) -> None:
    """Draw the principal point, and x to the right, y up from there."""
    ax.plot(0, 0, "+", color=BLACK, markersize=14, markeredgewidth=2)
    for name, tip, color in zip("xy", 0.16 * c * np.eye(2), colors):
        arrow = {"arrowstyle": "-|>", "color": color, "linewidth": 2}
        ax.annotate("", tip, (0, 0), arrowprops=arrow | {"shrinkA": 0, "shrinkB": 0})
        x, y = 1.25 * tip
        text = ax.text(x, y, name, color=color, fontsize=13, ha="center", va="center")
        # Legible before trees and houses too
        text.set_path_effects([withStroke(linewidth=3, foreground="white")])
