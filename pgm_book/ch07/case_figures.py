"""Figures of the case of the fifty shifts: what one printed number leaves open."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator, PercentFormatter

from pgm_book.common.figures import outline
from pgm_lab import plot
from pgm_lab.image import cut
from pgm_lab.plot.basic import Look, composite, grey_levels
from pgm_lab.registration import accuracy

SQUARE = 21  # px, the chip of the paper
AROUND = 51  # px, the ground around it


def on_the_grid(sets: Mapping[str, np.ndarray]) -> None:
    """Show how often each whole shift (n, 2) occurs, one panel for each set of them."""
    fig, axes = plt.subplots(1, len(sets), figsize=(7, 3.3), squeeze=False, sharey=True)
    said = [
        _grid_of_discs(ax, name, np.asarray(shifts))
        for ax, (name, shifts) in zip(axes[0], sets.items())
    ]
    axes[0, 0].set_ylabel("dy (px)")
    axes[0, 0].invert_yaxis()  # rows count downwards
    plot.show(fig, f"{DISCS} {'; '.join(said)}.", colours=64)


def sums(shifts: np.ndarray, draws: Mapping[str, np.ndarray], printed: float) -> None:
    """Show shifts (n, 2) of blind chips, sums of squares drawn, and the printed one."""
    shape: Look = {"width_ratios": (0.62, 1)}
    fig, (grid, ax) = plt.subplots(1, 2, figsize=(10, 3.7), gridspec_kw=shape)
    said = [_grid_of_discs(grid, f"{len(shifts)} blind chips", shifts)]
    grid.set_ylabel("dy (px)")
    grid.invert_yaxis()
    low = min(values.min() for values in draws.values())
    high = max(values.max() for values in draws.values())
    bins = np.arange(np.floor(low) - 0.5, high + 10, 10)  # ten whole sums in each
    looks = ((plot.SKY, ""), (plot.ORANGE, "//"))
    for (name, values), (colour, hatch) in zip(draws.items(), looks):
        look: Look = {"color": colour, "hatch": hatch, "label": name}
        look |= {"edgecolor": plot.BLACK, "linewidth": 0.6}
        weights = np.full(len(values), 100 / len(values))
        ax.hist(values, bins.tolist(), weights=weights, **look)
        less = float(np.mean(values <= printed))
        said.append(
            f"{name}: mean {values.mean():.0f}, standard deviation {values.std():.0f},"
            f" a share of {less:.5f} is not larger"
        )
    ax.axvline(printed, color=plot.RED, linewidth=3.5)
    ax.set_ylim(0, 1.45 * ax.get_ylim()[1])
    top: Look = {"va": "top", "fontsize": 15, "color": plot.RED}
    ax.text(printed, 0.98 * ax.get_ylim()[1], f" the paper: {printed:.0f}", **top)
    ax.set(xlabel="sum of the squared shifts (px²)", ylabel="sets of fifty (%)")
    ax.legend(loc="upper right")
    plot.show(
        fig,
        f"Left {DISCS[0].lower()}{DISCS[1:]} Right histograms of sums drawn at random;"
        f" the printed sum {printed:.0f} is marked. {'; '.join(said)}.",
        colours=64,
    )


def beyond(true: np.ndarray, reported: np.ndarray, reached: np.ndarray) -> None:
    """Show what a search of radius 3 reports of shifts that are known.

    RMSE_T of each, and the share of the chips whose r reaches the lowest of the paper.
    """
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(7, 3.3))
    ax.plot(true, true, "--", color=plot.GREY, label="truth")
    ax.plot(true, reported, "o-", color=plot.BLUE, label="reported")
    zone: Look = {"color": plot.ORANGE, "alpha": 0.18}
    ax.axvspan(3.5, true.max(), label="beyond radius 3", **zone)
    ax.set(xlabel="true shift (px)", ylabel="RMSE$_T$ (px)", ylim=(-0.4, 11.5))
    ax.set_title("What is reported")
    ax.legend(loc="upper left", handlelength=1.4, borderaxespad=0)
    beside.plot(true, reached, "s-", color=plot.RED)
    beside.axvspan(3.5, true.max(), **zone)
    beside.set(xlabel="true shift (px)", ylim=(-0.04, 1.08), ylabel="share of chips")
    beside.set_title("Chips with r ≥ 0.585")
    beside.yaxis.set_major_formatter(PercentFormatter(1))
    ax.xaxis.set_major_locator(MultipleLocator(2))
    beside.xaxis.set_major_locator(MultipleLocator(2))
    said = (
        f"{t:g} px: {r:.2f} px, {s:.0%}" for t, r, s in zip(true, reported, reached)
    )
    plot.show(
        fig,
        "Left the reported RMSE_T against the true shift: equal up to 3 px, then it"
        " stays between 3 and 3.5. Right the share of chips whose r reaches 0.585."
        f" True shift, reported, share: {'; '.join(said)}.",
        colours=64,
    )


def r_and_shift(r: np.ndarray, shift: np.ndarray, error: np.ndarray) -> None:
    """Show r against the length of the shift, and against the error of the match."""
    wrong = error >= 1
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.3), sharex=True)
    look: Look = {"linestyle": "none", "markersize": 6, "alpha": 0.5}
    # The paper does not know which are wrong, so the left picture does not show it
    axes[0].plot(r, shift, "o", color=plot.GREY, **look)
    kinds = ((~wrong, "o", plot.BLUE, "right"), (wrong, "X", plot.RED, "wrong"))
    for which, mark, colour, label in kinds:
        axes[1].plot(r[which], error[which], mark, color=colour, label=label, **look)
    axes[0].set(title="As in figure 3.1", ylabel="length of shift (px)")
    axes[1].set(title="With the truth", ylabel="error of match (px)")
    for ax in axes:
        ax.set(xlabel="r", ylim=(-0.2, None))
    handles = axes[1].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2)
    plot.show(
        fig,
        "Two scatter plots over r. Left the length of the shift, right the distance"
        f" from the true shift. {wrong.sum()} of {len(r)} matches are wrong by a pixel"
        f" or more; their median r is {np.median(r[wrong]):.2f}, of the right ones"
        f" {np.median(r[~wrong]):.2f}.",
        colours=96,
    )


def chips(
    reference: np.ndarray, sensed: np.ndarray, points: np.ndarray, shifts: np.ndarray
) -> None:
    """Show chips with the ground around them, the sensed image moved back."""
    pairs = [
        (cut(reference, at, AROUND), cut(sensed, at + shift, AROUND))
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
            outline(ax, (AROUND // 2, AROUND // 2), SQUARE, plot.ORANGE, linewidth=2.5)
    plot.show(
        fig,
        f"{len(points)} chips of 21 by 21 pixels in an orange frame, with 15 pixels of"
        " ground around them: in the reference image, in the sensed image at the best"
        " position, and both in green and magenta, where what agrees is grey.",
    )  # all colours: a palette would tint the grey


# --- Whole shifts as discs on the grid of the pixels, with the number that has each ---

DISCS = (
    "Shifts as discs on the grid of whole pixels, with the number of chips in them, the"
    " mean as a ring and the search as a dashed square."
)


def _grid_of_discs(ax: Axes, name: str, shifts: np.ndarray) -> str:
    """Draw shifts as discs on the grid, and say how long their mean is."""
    places, counts = np.unique(shifts, axis=0, return_counts=True)
    radius = 3  # of the search
    size = 230 * counts / counts.max() + 190
    ax.scatter(places[:, 0], places[:, 1], s=size, color="#C6E4F7", edgecolor=plot.BLUE)
    for place, count in zip(places, counts):
        ax.annotate(str(count), place, fontsize=13, ha="center", va="center")
    outline(ax, (0, 0), 2 * radius + 1.4, plot.GREY, linestyle="--")
    mean = shifts.mean(axis=0)
    ring: Look = {"markersize": 42, "markerfacecolor": "none"}
    ax.plot(*mean, "o", markeredgecolor=plot.RED, markeredgewidth=3, **ring)
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
