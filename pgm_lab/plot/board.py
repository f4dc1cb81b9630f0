"""Figures of a calibration: the shape of its board."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from pgm_lab._rounding import round_number
from pgm_lab.plot import basic


def shape(ax: Axes, points: np.ndarray, shift: np.ndarray, **limits: Any) -> dict:
    """Draw how far points of a board (n, 3) lie from where they were printed.

    Heights of `shift` (n, 3) as colours, what lies in the plane as arrows. `limits` may
    hold `height` and `magnify`, so that two boards are drawn alike; what was taken is
    returned with the `low` and `high` end of the heights.
    """
    size = np.ptp(points[:, :2], axis=0).max()
    height = limits.get("height", np.abs(shift[:, 2]).max())
    longest = np.hypot(*shift[:, :2].T).max()
    magnify = limits.get("magnify", round_number(0.08 * size / longest))
    x, y = points[:, :2].T
    marks = ax.scatter(x, y, 130, shift[:, 2], cmap="RdBu_r", vmin=-height, vmax=height)
    marks.set_edgecolor(basic.BLACK)
    arrows = magnify * shift[:, :2]
    ax.quiver(x, y, *arrows.T, angles="xy", scale_units="xy", scale=1, width=0.004)
    ax.set(aspect="equal", xlabel="X (mm)", ylabel="Y (mm)")
    ax.margins(0.1)
    figure = ax.get_figure()
    assert figure is not None
    figure.colorbar(marks, ax=ax, label="height off the plane (mm)", shrink=0.7)
    ends = {"low": float(shift[:, 2].min()), "high": float(shift[:, 2].max())}
    return {"height": float(height), "magnify": float(magnify), **ends}
