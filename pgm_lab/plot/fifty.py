"""Figures of the case of the fifty shifts: what one printed number leaves open."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MultipleLocator, PercentFormatter
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot._overlay import composite, grey_levels
from pgm_lab.plot.matching import outline
from pgm_lab.registration import accuracy

SQUARE = 21  # px, the chip of the paper
AROUND = 51  # px of ground that is drawn with it


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
    size = (4.1 * max(2, len(found)), 5.2)
    fig, axes = plt.subplots(1, len(found), figsize=size, squeeze=False)
    said = []
    for ax, (name, shifts) in zip(axes[0], found.items()):
        places, counts = np.unique(shifts, axis=0, return_counts=True)
        share = counts / counts.max()
        ax.scatter(*places.T, s=520 * share + 40, color=basic.SKY, edgecolor=basic.BLUE)
        if len(places) <= 12:
            for place, count in zip(places, counts):
                where = {"xytext": (8, 8), "textcoords": "offset points"}
                ax.annotate(str(count), place, fontsize=15, **where)
        outline(ax, (0, 0), 2 * radius + 0.9, basic.GREY, linestyle="--")
        mean = shifts.mean(axis=0)
        ax.plot(*mean, "X", color=basic.RED, markersize=13, markeredgecolor="white")
        rmse = accuracy(*shifts.T).rmse_t
        reach = max(radius, np.abs(shifts).max()) + 0.75
        ax.set(xlim=(-reach, reach), ylim=(reach, -reach), aspect="equal")
        ax.set(xlabel="dx (px)", title=f"{name}\nRMSE$_T$ {rmse:.4f} px")
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MultipleLocator(max(1, round(reach / 4))))
        far = float(np.hypot(*mean))
        said.append(f"{name}: RMSE_T {rmse:.4f} px, mean shift {far:.2f} px long")
    axes[0, 0].set_ylabel("dy (px)")
    basic.show(
        fig,
        f"Shifts as discs on the grid of whole pixels, the larger the more chips, with"
        f" the mean as a cross and the search as a dashed square. {'; '.join(said)}.",
        dpi=100,
        colours=64,
    )


def sums(drawn: ArrayLike, printed: float) -> None:
    """Show sums of squares that were drawn at random, and the one that is printed.

    Parameters
    ----------
    drawn : array_like (n,)
        Sums of the squared shifts of a set of chips, in square pixels.
    printed : float
        The published one.
    """
    drawn = _validate.finite(drawn, "drawn")
    if drawn.ndim != 1 or not len(drawn):
        raise ValueError(f"drawn must be a list of sums; got shape {drawn.shape}")
    printed = _validate.number(printed, "printed")
    fig, ax = plt.subplots(figsize=(10, 4.4))
    ax.hist(drawn, bins=60, color=basic.SKY, edgecolor="white", linewidth=0.5)
    ax.axvline(printed, color=basic.RED, linewidth=3.5)
    top = ax.get_ylim()[1]
    look: basic.Look = {"va": "top", "fontsize": 17, "color": basic.RED}
    ax.text(printed, 0.97 * top, f" the paper: {printed:.0f}", **look)
    ax.set(xlabel="sum of the squared shifts (px²)", yticks=[])
    ax.set(ylabel="how often")
    less = float(np.mean(drawn <= printed))
    basic.show(
        fig,
        f"A histogram of sums drawn at random: mean {drawn.mean():.0f}, standard"
        f" deviation {drawn.std():.0f}. The printed sum {printed:.0f} is marked; a"
        f" share of {less:.5f} is not larger.",
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
    true, reported, reached = (
        _validate.of_shape(values, (None,), name)
        for values, name in (
            (true, "true"),
            (reported, "reported"),
            (reached, "reached"),
        )
    )
    if not len(true) == len(reported) == len(reached) or not len(true):
        raise ValueError("true, reported and reached must be lists of one length")
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(11, 4.6))
    ax.plot(true, true, "--", color=basic.GREY, label="truth")
    ax.plot(true, reported, "o-", color=basic.BLUE, label="reported")
    zone: basic.Look = {"color": basic.ORANGE, "alpha": 0.18}
    ax.axvspan(3.5, max(true.max(), 3.6), label="beyond the radius", **zone)
    ax.set(xlabel="true shift (px)", ylabel="RMSE$_T$ (px)", title="What is reported")
    ax.legend(loc="upper left")
    beside.plot(true, reached, "s-", color=basic.RED)
    beside.axvspan(3.5, max(true.max(), 3.6), **zone)
    beside.set(xlabel="true shift (px)", ylim=(-0.04, 1.08))
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
    r, shift, error = (
        _validate.of_shape(values, (None,), name)
        for values, name in ((r, "r"), (shift, "shift"), (error, "error"))
    )
    if not len(r) == len(shift) == len(error) or not len(r):
        raise ValueError("r, shift and error must be lists of one length")
    wrong = error >= 1
    fig, axes = plt.subplots(1, 2, figsize=(11, 4.8), sharex=True)
    names = ("length of the shift (px)", "error of the match (px)")
    for ax, values, name in zip(axes, (shift, error), names):
        look = {"linestyle": "none", "markersize": 8}
        kinds = ((~wrong, "o", basic.BLUE, "right"), (wrong, "X", basic.RED, "wrong"))
        for which, mark, colour, label in kinds:
            look |= {"marker": mark, "color": colour, "alpha": 0.6}
            ax.plot(r[which], values[which], label=label, **look)
        ax.set(xlabel="r", ylabel=name, ylim=(-0.2, None))
    axes[0].set_title("As in figure 3.1")
    axes[1].set_title("With the truth")
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
    marks = (("o", basic.BLUE, "row 077 to 078"), ("^", basic.RED, "exchanged"))
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
    for row, at, shift, letter in zip(axes, points, shifts, "ABCD"):
        here, there = (
            _around(one, at, "reference"),
            _around(other, at + shift, "sensed"),
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
        dpi=90,
        colours=160,
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


def _around(image: np.ndarray, at: np.ndarray, name: str) -> np.ndarray:
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


def _median(values: np.ndarray) -> str:
    return f"{np.median(values):.2f}" if values.size else "none"
