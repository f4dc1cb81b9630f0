"""Parts of figures that lessons share."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, Rectangle
from numpy.typing import ArrayLike

from pgm_lab import plot


def outline(
    ax: Axes, centre: ArrayLike, size: float, color: str = plot.RED, **style: Any
) -> Patch:
    """Draw the outline of a square window, along the outer edges of its pixels."""
    x, y = np.asarray(centre) - size / 2
    style = {"fill": False, "linewidth": 2.5} | style
    return ax.add_patch(Rectangle((x, y), size, size, edgecolor=color, **style))
