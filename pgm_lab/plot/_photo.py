"""Photos as figures show them: coarse, with marks by status and with arrows."""

from collections import Counter

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pgm_lab._rounding import round_number
from pgm_lab.plot import _style, basic
from pgm_lab.plot.basic import Look

SHARPEST = 1200  # pixels across a drawn photo; a figure shows no more of them
BLANK = "#D9E4EC"  # where a photo has no data
OTHERS = "other reasons"
ACCEPTED = "accepted"


def show(ax: Axes, grey: np.ndarray) -> None:
    """Show a photo, as coarse as a figure is, with axes in its own pixels."""
    rows, columns = grey.shape
    n = -(-max(rows, columns) // SHARPEST)
    high, wide = rows // n * n, columns // n * n
    blocks = grey[:high, :wide].reshape(high // n, n, wide // n, n)
    small = np.ma.masked_invalid(blocks.mean(axis=(1, 3)))
    low, top = np.percentile(small.compressed(), [0.5, 99.5])
    ax.set_facecolor(BLANK)
    extent = (-0.5, wide - 0.5, high - 0.5, -0.5)
    ax.imshow(small, cmap="gray", vmin=low, vmax=top, extent=extent)
    ax.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5))
    ax.set(xlabel="columns (px)", ylabel="rows (px)")
    ax.grid(False)


def series(status: np.ndarray) -> list[tuple[str, np.ndarray, tuple[str, str]]]:
    """Each status, which points have it, and its colour and mark; accepted ones first.

    The rarest are put together where there are more than marks.
    """
    first, *looks = _style.SERIES
    found = [(ACCEPTED, status == ACCEPTED, first)]
    others = Counter(status[status != ACCEPTED].tolist()).most_common()
    words = [word for word, _ in others]
    if len(words) > len(looks):
        words = words[: len(looks) - 1]
    found += [(word, status == word, look) for word, look in zip(words, looks)]
    if len(words) < len(others):
        found.append((OTHERS, ~np.isin(status, [ACCEPTED, *words]), looks[-1]))
    return found


def arrows(grey: np.ndarray, at: np.ndarray, vectors: np.ndarray, title: str) -> Figure:
    """Draw a photo with a vector (n, 2) at each place (n, 2), magnified, and a key."""
    length = np.hypot(*vectors.T)
    rows, columns = grey.shape
    usual = max(float(np.quantile(length, 0.9)), 1e-3)
    unit = round_number(usual)
    magnify = 0.05 * max(rows, columns) / usual
    # What is far longer would hide the others: it is drawn shorter, in red
    far = length > 3 * usual
    vectors = vectors * np.where(far, 3 * usual / np.maximum(length, usual), 1)[:, None]
    height = float(np.clip(10 * rows / columns, 3, 9))
    fig, ax = plt.subplots(figsize=(10, height + 1.0))
    show(ax, grey)
    look: Look = {"angles": "xy", "scale_units": "xy", "scale": 1 / magnify}
    look |= {"edgecolor": basic.BLACK, "linewidth": 0.6, "width": 0.0035}
    for which, colour in ((far, basic.RED), (~far, basic.SKY)):
        if np.any(which):
            drawn = ax.quiver(*at[which].T, *vectors[which].T, color=colour, **look)
    ends = np.concatenate([at, at + magnify * vectors])
    low, high = np.minimum(ends.min(axis=0), -0.5), ends.max(axis=0)
    ax.set(xlim=(low[0], max(high[0], columns - 0.5)))
    ax.set(ylim=(max(high[1], rows - 0.5), low[1]))
    look = {"labelpos": "E", "coordinates": "axes", "labelcolor": basic.BLACK}
    ax.quiverkey(drawn, 0.85, 1 + 0.16 / height, unit, f"{unit:g} px", **look)
    ax.set_title(f"{title}; red ones are longer" if np.any(far) else title)
    return fig
