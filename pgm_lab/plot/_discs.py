"""Whole shifts as discs on the grid of the pixels, with the number that has each."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from pgm_lab.plot import basic
from pgm_lab.plot.matching import outline
from pgm_lab.registration import accuracy

DISCS = (
    "Shifts as discs on the grid of whole pixels, with the number of chips in them, the"
    " mean as a ring and the search as a dashed square."
)


def grid_of_discs(ax: Axes, name: str, shifts: np.ndarray, radius: int) -> str:
    """Draw shifts as discs on the grid, and say how long their mean is."""
    places, counts = np.unique(shifts, axis=0, return_counts=True)
    size = 230 * counts / counts.max() + 190
    ax.scatter(
        places[:, 0], places[:, 1], s=size, color="#C6E4F7", edgecolor=basic.BLUE
    )
    for place, count in zip(places, counts):
        ax.annotate(str(count), place, fontsize=13, ha="center", va="center")
    outline(ax, (0, 0), 2 * radius + 1.4, basic.GREY, linestyle="--")
    mean = shifts.mean(axis=0)
    ring: basic.Look = {"markersize": 42, "markerfacecolor": "none"}
    ax.plot(*mean, "o", markeredgecolor=basic.RED, markeredgewidth=3, **ring)
    rmse = accuracy(*shifts.T).rmse_t
    reach = max(radius, np.abs(shifts).max()) + 0.95
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    ax.set_xlabel("dx (px)")
    at = ", ".join(f"{m:.2f}".replace("-", "−") for m in mean + 0.0)
    ax.set_title(f"{name}: RMSE$_T$ {rmse:.2f} px\nmean ({at}) px", fontsize=13)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MultipleLocator(radius))
    far = float(np.hypot(*mean))
    return f"{name}: RMSE_T {rmse:.2f} px, mean shift {far:.2f} px long"
