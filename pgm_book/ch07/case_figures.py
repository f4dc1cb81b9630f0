"""Figures of the case of the fifty shifts: what one printed number leaves open."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator, PercentFormatter
from numpy.typing import ArrayLike

from pgm_book.common.figures import outline
from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot.basic import composite, grey_levels
from pgm_lab.registration import accuracy

SQUARE = 21  # px, the chip of the paper

_TURNS = np.resize([(1, 1), (-1, -1), (1, -1), (-1, 1)], (50, 2))
_ALIKE = np.array([(2, 1)] * 38 + [(2, 2)] * 12)
_FEW = np.array([(3, 3)] * 15 + [(2, 2)] * 2 + [(0, 0)] * 33)
# Three sets of fifty whole shifts (dx, dy) with one sum of squares, 286
SUSPECTS = {"A": _ALIKE, "B": _TURNS * _ALIKE, "C": _TURNS * _FEW}


def on_the_grid(sets: Mapping[str, ArrayLike], radius: int = 3) -> None:
    """Show how often each whole shift occurs, one panel for each set of shifts.

    Parameters
    ----------
    sets : mapping of str to array_like (n, 2)
        Whole (dx, dy) in pixels, by the name of the set.
    radius : int
        Farthest shift to each side that was searched.
    """
    radius = _validate.whole(radius, "radius", 1, 50)
    found = _sets(sets)
    across = (7 if len(found) < 4 else 2.4 * len(found), 3.3)
    fig, axes = plt.subplots(1, len(found), figsize=across, squeeze=False, sharey=True)
    said = [
        grid_of_discs(ax, name, shifts, radius)
        for ax, (name, shifts) in zip(axes[0], found.items())
    ]
    axes[0, 0].set_ylabel("dy (px)")
    axes[0, 0].invert_yaxis()  # rows count downwards
    basic.show(fig, f"{DISCS} {'; '.join(said)}.", colours=64)


def sums(blind: ArrayLike, drawn: Mapping[str, ArrayLike], printed: float) -> None:
    """Show shifts of blind chips, sums of squares drawn at random, and the printed one.

    Parameters
    ----------
    blind : array_like (n, 2)
        Whole (dx, dy) in pixels of chips whose ground the search does not hold.
    drawn : mapping of str to array_like (n,)
        Whole sums of the squared shifts of a set of chips, in square pixels, by the
        name of the draw; one or two.
    printed : float
        The published one.
    """
    (shifts,) = _sets({"blind": blind}).values()
    draws = {
        name: _validate.of_shape(values, (None,), f"drawn, {name}")
        for name, values in _validate.mapping(drawn, "drawn").items()
    }
    if not 1 <= len(draws) <= 2 or not all(len(values) for values in draws.values()):
        raise ValueError("drawn must hold one or two lists of sums, none of them empty")
    printed = _validate.number(printed, "printed")
    shape: basic.Look = {"width_ratios": (0.62, 1)}
    fig, (grid, ax) = plt.subplots(1, 2, figsize=(10, 3.7), gridspec_kw=shape)
    said = [grid_of_discs(grid, f"{len(shifts)} blind chips", shifts, 3)]
    grid.set_ylabel("dy (px)")
    grid.invert_yaxis()
    low = min(values.min() for values in draws.values())
    high = max(values.max() for values in draws.values())
    bins = np.arange(np.floor(low) - 0.5, high + 10, 10)  # ten whole sums in each
    looks = ((basic.SKY, ""), (basic.ORANGE, "//"))
    for (name, values), (colour, hatch) in zip(draws.items(), looks):
        look: basic.Look = {"color": colour, "hatch": hatch, "label": name}
        look |= {"edgecolor": basic.BLACK, "linewidth": 0.6}
        weights = np.full(len(values), 100 / len(values))
        ax.hist(values, bins.tolist(), weights=weights, **look)
        less = float(np.mean(values <= printed))
        said.append(
            f"{name}: mean {values.mean():.0f}, standard deviation {values.std():.0f},"
            f" a share of {less:.5f} is not larger"
        )
    ax.axvline(printed, color=basic.RED, linewidth=3.5)
    ax.set_ylim(0, 1.45 * ax.get_ylim()[1])
    top: basic.Look = {"va": "top", "fontsize": 15, "color": basic.RED}
    ax.text(printed, 0.98 * ax.get_ylim()[1], f" the paper: {printed:.0f}", **top)
    ax.set(xlabel="sum of the squared shifts (px²)", ylabel="sets of fifty (%)")
    ax.legend(loc="upper right")
    basic.show(
        fig,
        f"Left {DISCS[0].lower()}{DISCS[1:]} Right histograms of sums drawn at random;"
        f" the printed sum {printed:.0f} is marked. {'; '.join(said)}.",
        colours=64,
    )


def beyond(true: ArrayLike, reported: ArrayLike, reached: ArrayLike) -> None:
    """Show what a search of radius 3 reports of shifts that are known.

    Parameters
    ----------
    true : array_like (n,)
        True shifts in pixels.
    reported : array_like (n,)
        RMSE_T that was reported for each, in pixels.
    reached : array_like (n,)
        Share of the chips, from 0 to 1, whose r reaches the lowest of the paper.
    """
    true, reported, reached = _lists(true=true, reported=reported, reached=reached)
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(7, 3.3))
    ax.plot(true, true, "--", color=basic.GREY, label="truth")
    ax.plot(true, reported, "o-", color=basic.BLUE, label="reported")
    zone: basic.Look = {"color": basic.ORANGE, "alpha": 0.18}
    ax.axvspan(3.5, max(true.max(), 3.6), label="beyond radius 3", **zone)
    ax.set(xlabel="true shift (px)", ylabel="RMSE$_T$ (px)", ylim=(-0.4, 11.5))
    ax.set_title("What is reported")
    ax.legend(loc="upper left", handlelength=1.4, borderaxespad=0)
    beside.plot(true, reached, "s-", color=basic.RED)
    beside.axvspan(3.5, max(true.max(), 3.6), **zone)
    beside.set(xlabel="true shift (px)", ylim=(-0.04, 1.08), ylabel="share of chips")
    beside.set_title("Chips with r ≥ 0.585")
    beside.yaxis.set_major_formatter(PercentFormatter(1))
    ax.xaxis.set_major_locator(MultipleLocator(2))
    beside.xaxis.set_major_locator(MultipleLocator(2))
    said = (
        f"{t:g} px: {r:.2f} px, {s:.0%}" for t, r, s in zip(true, reported, reached)
    )
    basic.show(
        fig,
        "Left the reported RMSE_T against the true shift: equal up to 3 px, then it"
        " stays between 3 and 3.5. Right the share of chips whose r reaches 0.585."
        f" True shift, reported, share: {'; '.join(said)}.",
        colours=64,
    )


def r_and_shift(r: ArrayLike, shift: ArrayLike, error: ArrayLike) -> None:
    """Show r against the length of the shift, and against the error of the match.

    Parameters
    ----------
    r : array_like (n,)
        Correlation coefficients.
    shift : array_like (n,)
        Lengths of the shifts that were found, in pixels.
    error : array_like (n,)
        Distances from the true shift in pixels.
    """
    r, shift, error = _lists(r=r, shift=shift, error=error)
    wrong = error >= 1
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.3), sharex=True)
    look: basic.Look = {"linestyle": "none", "markersize": 6, "alpha": 0.5}
    # The paper does not know which are wrong, so the left picture does not show it
    axes[0].plot(r, shift, "o", color=basic.GREY, **look)
    kinds = ((~wrong, "o", basic.BLUE, "right"), (wrong, "X", basic.RED, "wrong"))
    for which, mark, colour, label in kinds:
        axes[1].plot(r[which], error[which], mark, color=colour, label=label, **look)
    axes[0].set(title="As in figure 3.1", ylabel="length of shift (px)")
    axes[1].set(title="With the truth", ylabel="error of match (px)")
    for ax in axes:
        ax.set(xlabel="r", ylim=(-0.2, None))
    handles = axes[1].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2)
    basic.show(
        fig,
        "Two scatter plots over r. Left the length of the shift, right the distance"
        f" from the true shift. {wrong.sum()} of {len(r)} matches are wrong by a pixel"
        f" or more; their median r is {_median(r[wrong])}, of the right ones"
        f" {_median(r[~wrong])}.",
        colours=96,
    )


def chips(
    reference: ArrayLike, sensed: ArrayLike, points: ArrayLike, shifts: ArrayLike
) -> None:
    """Show chips with the ground around them, the sensed image moved back.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values.
    points : array_like (n, 2)
        (column, row) of the chips, 28 pixels or more from the edge; up to four.
    shifts : array_like (n, 2)
        Whole (dx, dy) that were found, in pixels.
    """
    one = _validate.image(reference, "reference", AROUND)
    other = _validate.image(sensed, "sensed", AROUND)
    points = _validate.point_list(points, "points")
    shifts = _validate.of_shape(shifts, points.shape, "shifts")
    if not 1 <= len(points) <= 4:
        raise ValueError(f"points must be one to four; got {len(points)}")
    pairs = [
        (around(one, at, "reference"), around(other, at + shift, "sensed"))
        for at, shift in zip(points, shifts)
    ]
    fig = plt.figure(figsize=(5 * len(points), 3.35))
    parts = fig.subfigures(1, len(points), squeeze=False)[0]
    for part, (here, there), letter in zip(parts, pairs, "PQRS"):
        axes = part.subplot_mosaic("ac;bc", width_ratios=(1, 2.1))
        first, second, both = (axes[place] for place in "abc")
        first.imshow(grey_levels(here, "reference"), vmin=0, vmax=1)
        second.imshow(grey_levels(there, "sensed"), vmin=0, vmax=1)
        both.imshow(composite(here, there), interpolation="nearest")
        names = ("reference", "sensed, back", f"{letter}: both")
        for ax, name in zip((first, second, both), names):
            ax.set(xticks=[], yticks=[])
            ax.set_title(name, fontsize=13 if ax is not both else 18)
            ax.grid(False)
            outline(ax, (AROUND // 2, AROUND // 2), SQUARE, basic.ORANGE, linewidth=2.5)
    basic.show(
        fig,
        f"{len(points)} chips of 21 by 21 pixels in an orange frame, with 15 pixels of"
        " ground around them: in the reference image, in the sensed image at the place"
        " that was found, and both in green and magenta, where what is alike is grey.",
    )  # all colours: a palette would tint the grey


def _sets(sets: Mapping[str, ArrayLike]) -> dict[str, np.ndarray]:
    """Shifts (n, 2) by their names, of one set or more."""
    found = {
        name: _validate.of_shape(shifts, (None, 2), f"sets, {name}")
        for name, shifts in _validate.mapping(sets, "sets").items()
    }
    if not found or not all(len(shifts) for shifts in found.values()):
        raise ValueError("sets must hold one set of shifts or more, none of them empty")
    return found


def _lists(**lists: ArrayLike) -> list[np.ndarray]:
    """Lists of one length, by the names of the arguments."""
    found = [_validate.of_shape(one, (None,), name) for name, one in lists.items()]
    if len({len(one) for one in found}) != 1 or not len(found[0]):
        *names, last = lists
        raise ValueError(f"{', '.join(names)} and {last} must be lists of one length")
    return found


def _median(values: np.ndarray) -> str:
    return f"{np.median(values):.2f}" if values.size else "none"


# --- A piece of ground around a place, as the figure of two chips draws it ---

AROUND = 51  # px


def around(image: np.ndarray, at: np.ndarray, name: str) -> np.ndarray:
    """The ground around a place, or what is wrong with it."""
    x, y = np.floor(np.clip(at, -AROUND, max(image.shape) + AROUND) + 0.5).astype(int)
    half = AROUND // 2
    left, top = x - half, y - half
    if min(left, top) < 0 or x + half >= image.shape[1] or y + half >= image.shape[0]:
        raise ValueError(
            f"points: what lies around ({x}, {y}) leaves the {name} image of"
            f" {image.shape[1]} columns and {image.shape[0]} rows"
        )
    return image[top : top + AROUND, left : left + AROUND]


# --- Whole shifts as discs on the grid of the pixels, with the number that has each ---

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
