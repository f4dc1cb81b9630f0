"""Drawings of what `matching.match` found in two photos, and of photos in general."""

from collections import Counter

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch

from pgm_lab import matching
from pgm_lab._rounding import plain, round_number
from pgm_lab.io.photo import Photo
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look

ACCEPTED, OTHERS = "accepted", "other reasons"
MAX_PIXELS = 1200  # across a drawn photo; a figure shows no more of them
BLANK = "#D9E4EC"  # where a photo has no data
ITERATIONS = 30
SHORTEST = 1e-3  # px; shorter residuals all weigh the same


def side_by_side(
    left: Photo, right: Photo, found: matching.Match, lines: int = 12
) -> Figure:
    """Draw two photos with their matches, and in the left one the points not found.

    Each status has its own colour and marker. Lines join some matches, spread over
    the photo, so that one can compare them by eye.

    Parameters
    ----------
    left, right : as for `matching.read`
        The photos; colours are drawn in grey.
    found : matching.Match
        What `matching.match` returned for them.
    lines : int
        How many matches are joined by lines; 0 for none.

    Raises
    ------
    ValueError
        If a photo has another size than the one that was matched.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> shift = (3.25, 1, 0, -1.5, 0, 1)
    >>> grey = simulate.texture_pair(simulate.texture(seed=1), (90, 120), shift)
    >>> found = matching.match(*grey, number=5)
    >>> figure = side_by_side(*grey, found)
    >>> plt.close(figure)
    """
    pair = _same(left, "left", found, 0), _same(right, "right", found, 1)
    wide = [grey.shape[1] / grey.shape[0] for grey in pair]  # at the same height
    height = min(12 / sum(wide), 9.0)
    fig, axes = plt.subplots(1, 2, figsize=(12, height + 1.4), width_ratios=wide)
    for ax, grey, name in zip(axes, pair, ("left photo", "right photo")):
        show_photo(ax, grey)
        ax.set_title(name)
    axes[1].set_ylabel("")
    if found.left_size == found.right_size:  # lines would cross the numbers
        axes[1].tick_params(labelleft=False)
    marks = {"linestyle": "none", "markeredgecolor": "white", "markeredgewidth": 0.7}
    size = 7.0 if len(found.chosen) <= 300 else 4.0
    handles = []
    for status, which, (colour, mark) in series(found.status):
        look: Look = {"color": colour, "marker": mark, "markersize": size, **marks}
        label = f"{status}: {np.sum(which)}"
        handles += axes[0].plot(*found.chosen[which].T, label=label, **look)
        if status == ACCEPTED:
            axes[1].plot(*found.points[which].T, **look)
    for i in _spread(found.chosen, found.accepted, lines):
        for colour, thick in ((basic.BLACK, 2.2), (basic.YELLOW, 1.1)):
            look = {"color": colour, "linewidth": thick}
            ends: Look = {"axesA": axes[0], "axesB": axes[1], "coordsA": "data"}
            line = ConnectionPatch(found.chosen[i], found.points[i], **ends, **look)
            line.set_in_layout(False)
            fig.add_artist(line)
    if handles:
        fig.legend(handles=handles, loc="outside lower center", ncols=3)
    return fig


def parallaxes(left: Photo, found: matching.Match) -> Figure:
    """Draw the parallaxes minus a common shift, rotation, scale and shear.

    That is relief, and matches that do not fit their neighbours. The common part is the
    affine transformation from left to right that leaves the least sum of lengths.

    `left` is as for `matching.read`; at least one point of `found` must be accepted.
    """
    grey = _same(left, "left", found, 0)
    if not np.any(found.accepted):
        raise ValueError("found has no accepted match: there are no parallaxes to draw")
    at, vectors = found.chosen[found.accepted], affine_residuals(found)
    return arrows(grey, at, vectors, "Parallaxes minus their affine part")


def affine_residuals(found: matching.Match) -> np.ndarray:
    """Residuals of an affine transformation fitted to the accepted points.

    Right minus transformed left point (m, 2), in pixels. With fewer than three points,
    or on one line, what is not determined stays as in the left photo. The sum of the
    lengths is minimised by weights 1 / length (Weiszfeld 1937): a few wrong matches
    count little.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> shift = (3.25, 1, 0, -1.5, 0, 1)
    >>> grey = simulate.texture_pair(simulate.texture(seed=1), (90, 120), shift)
    >>> found = matching.match(*grey, [(40, 40), (70, 45), (60, 60), (50, 30)])
    >>> bool(np.all(np.abs(affine_residuals(found)) < 0.01))
    True
    """
    at = found.chosen[found.accepted]
    shift = found.points[found.accepted] - at
    if not len(at):
        return shift
    centred = (at - at.mean(axis=0)) / max(np.ptp(at), 1.0)
    A = np.column_stack([np.ones(len(at)), centred])
    w, v = np.ones(len(at)), shift
    for _ in range(ITERATIONS):
        x = np.linalg.lstsq(w[:, None] * A, w[:, None] * shift, rcond=1e-9)[0]
        v = shift - A @ x
        w = np.maximum(np.hypot(*v.T), SHORTEST) ** -0.5
    return v


def histograms(found: matching.Match, threshold: float | None = None) -> Figure:
    """Draw how similar the windows are, and how precise the accepted matches.

    `threshold` is the least r that was accepted, drawn as a limit.
    """
    fig, (above, below) = plt.subplots(1, 2, figsize=(12, 4.4))
    r = found.r[np.isfinite(found.r)]
    lowest = min(float(r.min(initial=0.9)), 1.0 if threshold is None else threshold)
    edges = np.linspace(np.floor(20 * lowest - 0.5) / 20, 1.0, 41)
    good = found.accepted & np.isfinite(found.r)
    bars: Look = {"edgecolor": "white", "linewidth": 0.6}
    above.hist(r, list(edges), color=basic.ORANGE, label="not accepted", **bars)
    above.hist(found.r[good], list(edges), color=basic.BLUE, label=ACCEPTED, **bars)
    if threshold is not None:
        limit = f"limit {plain(threshold)}"
        above.axvline(threshold, color=basic.BLACK, linestyle="--", label=limit)
    above.legend(loc="upper left")
    above.set(xlabel="correlation coefficient r", ylabel="points")
    sd = found.sd[np.isfinite(found.sd) & (found.sd > 0)]
    if len(sd):
        middle = float(np.median(sd))
        low, high = min(sd.min(), middle / 2), max(sd.max(), 2 * middle)
        edges = np.geomspace(0.99 * low, 1.01 * high, 31)
        below.hist(sd, list(edges), color=basic.BLUE, **bars)
        median = f"median {plain(middle)} px"
        below.axvline(middle, color=basic.BLACK, linestyle="--", label=median)
        below.set_xscale("log")
        basic.plain(below.xaxis)
        below.legend(loc="upper right")
    below.set(xlabel="predicted standard deviation (px)", ylabel="accepted points")
    return fig


def _same(
    photo: Photo, name: str, found: matching.Match, side: int
) -> np.ndarray | np.ma.MaskedArray:
    """Return the grey values of a photo, which must be the one that was matched."""
    grey = matching.read(photo, name, colour="grey")
    size = (found.left_size, found.right_size)[side]
    if grey.shape[::-1] != tuple(size):
        raise ValueError(
            f"{name} has {grey.shape[1]} x {grey.shape[0]} pixels, and the photo that"
            f" was matched {size[0]} x {size[1]}: pass the same photo"
        )
    return grey


def _spread(points: np.ndarray, usable: np.ndarray, most: int) -> list[int]:
    """Indices of points that lie far apart, each the farthest from those before it."""
    rest = np.flatnonzero(usable)
    away = np.full(len(rest), np.inf)
    chosen: list[int] = []
    while len(chosen) < min(most, len(rest)) and away.max() > 0:
        # the first: the nearest to the upper left corner
        k = np.argmax(away) if chosen else np.argmin(points[rest].sum(axis=1))
        chosen.append(int(rest[k]))
        step = np.linalg.norm(points[rest] - points[rest[k]], axis=1)
        away = np.minimum(away, step)
    return chosen


# --- Photos: coarse, with marks by status and with arrows ---


def show_photo(ax: Axes, grey: np.ndarray) -> None:
    """Show a photo, reduced to what a figure shows, with axes in its own pixels."""
    rows, columns = grey.shape
    n = -(-max(rows, columns) // MAX_PIXELS)
    high, wide = rows // n * n, columns // n * n
    blocks = grey[:high, :wide].reshape(high // n, n, wide // n, n)
    means = [block.mean(axis=(0, 2)) for block in blocks]  # of large ones no copy
    small = np.ma.masked_invalid(np.ma.stack(means).astype(np.float32), copy=False)
    low, top = np.percentile(small.compressed(), [0.5, 99.5])
    ax.set_facecolor(BLANK)
    extent = (-0.5, wide - 0.5, high - 0.5, -0.5)
    shades = plt.get_cmap("gray")(plt.Normalize(low, top)(small), bytes=True)
    ax.imshow(shades, extent=extent)
    ax.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5))
    ax.set(xlabel="columns (px)", ylabel="rows (px)")
    ax.grid(False)


def series(status: np.ndarray) -> list[tuple[str, np.ndarray, tuple[str, str]]]:
    """Each status, which points have it, and its colour and mark; accepted ones first.

    The rarest are grouped where there are more statuses than markers.
    """
    first, *looks = basic.SERIES
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
    """Draw a photo with a vector (n, 2) at each point (n, 2), magnified, and a key."""
    length = np.hypot(*vectors.T)
    rows, columns = grey.shape
    usual = max(float(np.quantile(length, 0.9)), 1e-3)
    unit = round_number(usual)
    magnify = 0.05 * max(rows, columns) / usual
    # Far longer ones would hide the others: they are drawn shorter, in red
    far = length > 3 * usual
    vectors = vectors * np.where(far, 3 * usual / np.maximum(length, usual), 1)[:, None]
    height = float(np.clip(10 * rows / columns, 3, 9))
    fig, ax = plt.subplots(figsize=(10, height + 1.0))
    show_photo(ax, grey)
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
