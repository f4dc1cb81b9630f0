"""Figures of the case of the fifty shifts: what one printed number leaves open."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MultipleLocator, PercentFormatter
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot._around import AROUND, around
from pgm_lab.plot._overlay import composite, grey_levels
from pgm_lab.plot.matching import outline
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
    across = (4.1 * max(1.6, len(found)), 5.6)
    fig, axes = plt.subplots(1, len(found), figsize=across, squeeze=False)
    said = []
    for ax, (name, shifts) in zip(axes[0], found.items()):
        places, counts = np.unique(shifts, axis=0, return_counts=True)
        size = 620 * counts / counts.max() + 330
        ax.scatter(*places.T, s=size, color=basic.SKY, edgecolor=basic.BLUE)
        for place, count in zip(places, counts):
            ax.annotate(str(count), place, fontsize=14, ha="center", va="center")
        outline(ax, (0, 0), 2 * radius + 1.3, basic.GREY, linestyle="--")
        mean = shifts.mean(axis=0)
        ring: basic.Look = {"markersize": 38, "markerfacecolor": "none"}
        ax.plot(*mean, "o", markeredgecolor=basic.RED, markeredgewidth=3, **ring)
        rmse = accuracy(*shifts.T).rmse_t
        reach = max(radius, np.abs(shifts).max()) + 0.85
        ax.set(xlim=(-reach, reach), ylim=(reach, -reach), aspect="equal")
        ax.set_xlabel("dx (px)")
        at = ", ".join(f"{m:.2f}".replace("-", "−") for m in mean + 0.0)
        ax.set_title(f"{name}: RMSE$_T$ {rmse:.2f} px\nmean ({at}) px")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MultipleLocator(max(1, round(reach / 4))))
        far = float(np.hypot(*mean))
        said.append(f"{name}: RMSE_T {rmse:.2f} px, mean shift {far:.2f} px long")
    axes[0, 0].set_ylabel("dy (px)")
    basic.show(
        fig,
        f"Shifts as discs on the grid of whole pixels, with the number of chips in"
        " them, the mean as a ring and the search as a dashed square."
        f" {'; '.join(said)}.",
        dpi=100,
        colours=64,
    )


def sums(drawn: Mapping[str, ArrayLike], printed: float) -> None:
    """Show sums of squares that were drawn at random, and the one that is printed.

    Parameters
    ----------
    drawn : mapping of str to array_like (n,)
        Whole sums of the squared shifts of a set of chips, in square pixels, by the
        name of the draw; one or two.
    printed : float
        The published one.
    """
    draws = {
        name: _validate.of_shape(values, (None,), f"drawn, {name}")
        for name, values in _validate.mapping(drawn, "drawn").items()
    }
    if not 1 <= len(draws) <= 2 or not all(len(values) for values in draws.values()):
        raise ValueError("drawn must hold one or two lists of sums, none of them empty")
    printed = _validate.number(printed, "printed")
    fig, ax = plt.subplots(figsize=(10, 4.8))
    low = min(values.min() for values in draws.values())
    high = max(values.max() for values in draws.values())
    bins = np.arange(np.floor(low) - 0.5, high + 10, 10)  # ten whole sums in each
    looks = ((basic.SKY, ""), (basic.ORANGE, "//"))
    said = []
    for (name, values), (colour, hatch) in zip(draws.items(), looks):
        look: basic.Look = {"color": colour, "hatch": hatch, "label": name}
        weights = np.full(len(values), 100 / len(values))
        ax.hist(values, bins.tolist(), weights=weights, **look)
        less = float(np.mean(values <= printed))
        said.append(
            f"{name}: mean {values.mean():.0f}, standard deviation {values.std():.0f},"
            f" a share of {less:.5f} is not larger"
        )
    ax.axvline(printed, color=basic.RED, linewidth=3.5)
    ax.set_ylim(0, 1.25 * ax.get_ylim()[1])
    top: basic.Look = {"va": "top", "fontsize": 17, "color": basic.RED}
    ax.text(printed, 0.97 * ax.get_ylim()[1], f" the paper: {printed:.0f}", **top)
    ax.set(xlabel="sum of the squared shifts (px²)", ylabel="sets of fifty (%)")
    ax.legend(loc="upper right")
    basic.show(
        fig,
        f"Histograms of sums drawn at random; the printed sum {printed:.0f} is marked."
        f" {'; '.join(said)}.",
        dpi=100,
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
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(11, 4.6))
    ax.plot(true, true, "--", color=basic.GREY, label="truth")
    ax.plot(true, reported, "o-", color=basic.BLUE, label="reported")
    zone: basic.Look = {"color": basic.ORANGE, "alpha": 0.18}
    ax.axvspan(3.5, max(true.max(), 3.6), label="beyond the radius", **zone)
    ax.set(xlabel="true shift (px)", ylabel="RMSE$_T$ (px)", title="What is reported")
    ax.legend(loc="upper left")
    beside.plot(true, reached, "s-", color=basic.RED)
    beside.axvspan(3.5, max(true.max(), 3.6), **zone)
    beside.set(xlabel="true shift (px)", ylim=(-0.04, 1.08), ylabel="share of chips")
    beside.set_title("Chips with r ≥ 0.585")
    beside.yaxis.set_major_formatter(PercentFormatter(1))
    said = (
        f"{t:g} px: {r:.2f} px, {s:.0%}" for t, r, s in zip(true, reported, reached)
    )
    basic.show(
        fig,
        "Left the reported RMSE_T against the true shift: equal up to 3 px, then it"
        " stays near 3. Right the share of chips whose r reaches 0.585. True shift,"
        f" reported, share: {'; '.join(said)}.",
        dpi=100,
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
    fig, axes = plt.subplots(1, 2, figsize=(11, 4.8), sharex=True)
    look: basic.Look = {"linestyle": "none", "markersize": 8, "alpha": 0.45}
    # The paper does not know which are wrong, so the left picture does not show it
    axes[0].plot(r, shift, "o", color=basic.GREY, **look)
    kinds = ((~wrong, "o", basic.BLUE, "right"), (wrong, "X", basic.RED, "wrong"))
    for which, mark, colour, label in kinds:
        axes[1].plot(r[which], error[which], mark, color=colour, label=label, **look)
    axes[0].set(title="As in figure 3.1", ylabel="length of the shift (px)")
    axes[1].set(title="With the truth", ylabel="error of the match (px)")
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
        dpi=100,
        colours=96,
    )


def both_ways(there: ArrayLike, back: ArrayLike, sd: float) -> None:
    """Show shifts from one image to the other, and with the two exchanged.

    Parameters
    ----------
    there, back : array_like (n, 2), (m, 2)
        (dx, dy) in pixels.
    sd : float
        Predicted standard deviation of a coordinate in pixels.
    """
    found = _sets({"there": there, "back": back})
    sd = _validate.positive_number(sd, "sd", "px")
    fig, ax = plt.subplots(figsize=(8, 6.4))
    marks = (("o", basic.BLUE, "first to second"), ("^", basic.RED, "exchanged"))
    means = []
    for shifts, (mark, colour, label) in zip(found.values(), marks):
        ax.plot(*shifts.T, mark, color=colour, alpha=0.4, markersize=8, label=label)
        means.append(shifts.mean(axis=0))
    circle = plt.Circle((0, 0), 2.45 * sd, color=basic.BLACK, fill=False, linewidth=2.5)
    ax.add_patch(circle)
    ax.plot([], [], "o", mfc="none", color=basic.BLACK, label="predicted, 95 %")
    ax.axhline(0, color=basic.GREY, linewidth=1)
    ax.axvline(0, color=basic.GREY, linewidth=1)
    ax.set(xlabel="dx (px)", ylabel="dy (px)", aspect="equal")
    ax.invert_yaxis()
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    said = " and ".join(f"({x:+.4f}, {y:+.4f})" for x, y in means)
    basic.show(
        fig,
        "Two clouds of shifts on opposite sides of zero, each far outside the small"
        f" circle that is predicted around it; their means are {said} px.",
        dpi=100,
        colours=64,
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
    fig, axes = plt.subplots(
        *(len(points), 3), figsize=(10.5, 3.75 * len(points)), squeeze=False
    )
    for row, at, shift, letter in zip(axes, points, shifts, "PQRS"):
        here, there = (
            around(one, at, "reference"),
            around(other, at + shift, "sensed"),
        )
        row[0].imshow(grey_levels(here, "reference"), vmin=0, vmax=1)
        row[1].imshow(grey_levels(there, "sensed"), vmin=0, vmax=1)
        row[2].imshow(composite(here, there), interpolation="nearest")
        for ax in row:
            ax.set(xticks=[], yticks=[])
            ax.grid(False)
            outline(ax, (AROUND // 2, AROUND // 2), SQUARE, basic.ORANGE, linewidth=3)
        row[0].set_ylabel(letter, rotation=0, labelpad=18, fontsize=24, va="center")
    for ax, name in zip(axes[0], ("reference", "sensed, moved back", "both")):
        ax.set_title(name)
    basic.show(
        fig,
        f"{len(points)} chips of 21 by 21 pixels in an orange frame, with 15 pixels of"
        " ground around them: in the reference image, in the sensed image at the place"
        " that was found, and both in green and magenta, where what is alike is grey.",
        dpi=90,  # all colours: a palette would tint the grey
    )


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
