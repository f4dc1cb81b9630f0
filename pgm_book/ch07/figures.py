"""Figures of registration by chips: the search, its map, what the shifts show."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from pgm_book.common.figures import outline
from pgm_book.program.registration import best_shift
from pgm_lab import plot
from pgm_lab.plot.basic import Look, grey_levels, interact, overlay

CHIP = 21  # px across, as in the paper
LABEL: Look = {
    "fontsize": 14,
    "bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.88, "pad": 2},
}
ARROW: Look = {"arrowstyle": "-|>", "linewidth": 2.4}
BAR = "|-|, widthA=0.4, widthB=0.4"
EXACT: Look = {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 12, "linewidth": 2.2}
REACH, PART = 4, 25  # px that the sliders go to each side, and across what they show
WRONG = 1.0  # px: a shift that is farther off than this is a wrong match
SHOWN = 0.5  # px to each side of the truth


# --- What has changed here? ---


def changes(reference: np.ndarray, sensed: np.ndarray, limit: float) -> Figure:
    """Draw two images side by side, and where their grey values differ."""
    fig = plt.figure(figsize=(10, 4.1), layout="compressed")
    names = ("reference", "sensed")
    axes = fig.subplot_mosaic("rcc;scc")
    for name, image in zip(names, (reference, sensed)):
        axes[name[0]].imshow(grey_levels(image, name), vmin=0, vmax=1)
        axes[name[0]].set_title(f"{name} image")
    changed = np.abs(sensed.astype(float) - reference) > limit
    share = 100 * changed.mean()
    axes["c"].imshow(changed, cmap="binary", interpolation="nearest")
    axes["c"].set_title(
        f"black: differ by more than {limit:g} grey values, {share:.0f} %"
    )
    for ax in axes.values():
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    axes["c"].spines[["top", "right"]].set_visible(True)
    return fig


def two_colours(
    reference: np.ndarray, sensed: np.ndarray, centre: tuple[int, int], size: int
) -> None:
    """Show a square part of both images in two colours, and as difference."""
    window, extent = _part(centre, size)
    one, other = reference[window].astype(float), sensed[window].astype(float)
    fig, axes = plt.subplots(1, 2, figsize=(7, 4.1), layout="compressed")
    overlay(one, other, ax=axes[0])
    axes[0].images[0].set_extent(extent)
    axes[0].set_title("green: reference,\nmagenta: sensed")
    change = other - one
    far = _far(change)
    axes[1].imshow(change, extent=extent, cmap="gray", vmin=-far, vmax=far)
    axes[1].set(title="sensed − reference,\nin grey", xlabel="column (px)", yticks=[])
    axes[1].grid(False)
    plot.show(
        fig,
        "A part of both images, one on the other, the reference in green and the sensed"
        " one in magenta. The fields are grey, so both show the same. Along every edge"
        " of a field runs a narrow fringe, green on one side and magenta on the other."
        " Beside it the difference: even grey in the fields, a white or a black line"
        " along their edges.",
    )


def _part(
    centre: tuple[int, int], size: int
) -> tuple[tuple[slice, slice], tuple[float, float, float, float]]:
    """Rows and columns of a square part, and its (left, right, bottom, top) edges."""
    left, top = (at - size // 2 for at in centre)
    edges = (left - 0.5, left + size - 0.5, top + size - 0.5, top - 0.5)
    return (slice(top, top + size), slice(left, left + size)), edges


def _far(change: np.ndarray) -> float:
    """Difference that is drawn white, and black with a minus; few are larger."""
    return max(float(np.quantile(np.abs(change), 0.99)), 1e-9)


def fringe_by_hand(
    reference: np.ndarray, sensed: np.ndarray, centre: tuple[int, int]
) -> None:
    """Show a part of both images pixel by pixel, and sliders that draw one back."""
    import ipywidgets

    window, extent = _part(centre, PART)
    one = reference[window].astype(float)
    panels: Look = {"sharey": True, "layout": "compressed"}
    far = _far(sensed[window] - one)

    def draw(dx: int, dy: int) -> None:
        there, _ = _part((centre[0] + dx, centre[1] + dy), PART)
        moved = sensed[there].astype(float)
        fig, (left, right) = plt.subplots(1, 2, figsize=(10, 5.2), **panels)
        overlay(one, moved, ax=left)
        left.images[0].set_extent(extent)
        change = moved - one
        look: Look = {"cmap": "gray", "vmin": -far, "vmax": far}
        right.imshow(change, extent=extent, interpolation="nearest", **look)
        right.grid(False)
        for ax in (left, right):
            _line_a_pixel(ax, extent)
            ax.set(xlabel="column (px)")
        left.set_title("green: reference, magenta: sensed")
        right.set_title("sensed − reference, in grey")
        drawn = f"sensed image drawn back by {dx} columns and {dy} rows"
        fig.suptitle(drawn)
        plot.show(
            fig,
            f"A part of both images of {PART} by {PART} pixels, in two colours and as"
            f" difference, with a thin line between any two pixels; {drawn}.",
        )

    look: Look = {"min": -REACH, "max": REACH, "continuous_update": False}
    dx = ipywidgets.IntSlider(0, description="columns", **look)
    interact(draw, dx=dx, dy=ipywidgets.IntSlider(0, description="rows", **look))


def _line_a_pixel(ax: Axes, extent: tuple[float, float, float, float]) -> None:
    """Draw a thin line between pixels, and name every fifth."""
    left, right, bottom, top = extent
    look: Look = {"color": "0.7", "linewidth": 0.6, "alpha": 0.7}
    for x in np.arange(left, right + 0.1):
        ax.axvline(x, **look)
    for y in np.arange(top, bottom + 0.1):
        ax.axhline(y, **look)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MultipleLocator(5))


# --- How far has one corner moved? ---


def chip_search(
    reference: np.ndarray,
    sensed: np.ndarray,
    point: np.ndarray,
    chip: int,
    radius: int,
) -> None:
    """Show the search for one chip on the images themselves, its parts named."""
    dx, dy, r = best_shift(reference, sensed, point, chip, radius)
    x, y = np.floor(np.asarray(point) + 0.5)
    half, room = chip / 2, chip / 2 + radius
    panels: Look = {"width_ratios": (0.85, 0.85, 1), "wspace": 0.08}
    fig, axes = plt.subplots(
        1, 3, figsize=(10, 4.1), layout="compressed", gridspec_kw=panels
    )
    left, right, numbers = axes
    for ax, image, name in zip(axes, (reference, sensed), ("reference", "sensed")):
        _photo(ax, image, name, (x, y), room + 4)
        ax.set_title(f"{name} image")
    outline(left, (x, y), chip, plot.ORANGE, linewidth=3)
    left.plot(x, y, "+", color=plot.ORANGE, markersize=18, markeredgewidth=3)
    left.annotate("point", (x, y), (x + 2, y + 6), arrowprops=ARROW, **LABEL)
    left.set_xlabel(f"solid: chip, {chip} × {chip} px", loc="left")
    outline(right, (x, y), 2 * room, plot.SKY, linewidth=3, linestyle="--")
    outline(right, (x, y), chip, plot.ORANGE, linewidth=2.5, linestyle=":")
    outline(right, (x + dx, y + dy), chip, plot.ORANGE, linewidth=3)
    look = EXACT | {"arrowstyle": BAR, "color": plot.BLUE}
    right.annotate("", (x - room, y - 4), (x - half, y - 4), arrowprops=look)
    right.text(x - half + 1, y - 4, f"radius {radius}", va="center", **LABEL)
    look = EXACT | {"arrowstyle": "-|>", "color": plot.BLACK}
    right.annotate("", (x + dx, y + 6 + dy), (x, y + 6), arrowprops=look)
    right.text(x + max(dx, 0) + 1, y + 6, "shift", va="center", **LABEL)
    words = "dashed: search window\ndotted: same position\nsolid: best position"
    right.set_xlabel(words, loc="left")
    _table_of_r(numbers, r)
    numbers.set_title("r for every shift")
    plot.show(
        fig,
        f"Left, the reference image with a chip of {chip} by {chip} pixels around a"
        f" point. Middle, the sensed image with a search window that reaches {radius}"
        " pixels farther to each side; in it the chip at its best position; an arrow is"
        f" the shift ({dx}, {dy}). Right, r for every shift as a map of"
        f" {len(r)} by {len(r)} squares with their numbers, {_words(r)}",
    )


def _photo(
    ax: Axes, image: np.ndarray, name: str, centre: tuple[float, float], far: float
) -> None:
    """Draw an image as far as this from a point, without numbers at its edges."""
    x, y = centre
    ax.imshow(grey_levels(image, name), vmin=0, vmax=1)
    ax.set(xlim=(x - far, x + far), ylim=(y + far, y - far), xticks=[], yticks=[])
    ax.grid(False)


def _words(r: np.ndarray) -> str:
    """What a map of r shows: its summit, what comes near to it, and the lowest."""
    radius = len(r) // 2
    row, column = np.unravel_index(r.argmax(), r.shape)
    close = [
        f"({j - radius}, {i - radius})" for i, j in np.argwhere(r >= r.max() - 0.1)
    ]
    return (
        f"the highest, {r.max():.2f}, framed, at dx = {column - radius} and"
        f" dy = {row - radius}. Within 0.1 of it are the shifts {', '.join(close)}; the"
        f" lowest r is {r.min():.2f}."
    )


def _table_of_r(ax: Axes, r: np.ndarray) -> None:
    """Draw the correlations of a search by colour and number, over the shift."""
    half = len(r) / 2
    low = float(min(r.min(), 0.0))
    ax.imshow(r, extent=(-half, half, half, -half), cmap="cividis", vmin=low, vmax=1)
    ax.grid(False)
    ax.set(xlabel="dx, columns (px)", ylabel="dy, rows (px)")
    step = [k - len(r) // 2 for k in range(len(r))]
    ax.set(xticks=step, yticks=step)
    row, column = np.unravel_index(r.argmax(), r.shape)
    outline(ax, (step[int(column)], step[int(row)]), 1, plot.RED, linewidth=4)
    for (i, j), value in np.ndenumerate(r):
        ink = "black" if value > 0.45 * (1 + low) else "white"
        middle: Look = {"ha": "center", "va": "center", "fontsize": 13}
        ax.text(step[j], step[i], _short(value), color=ink, **middle)


def _short(r: float) -> str:
    """Two decimals behind the point alone, as many books print r; 1.0 has one."""
    text = f"{r:.2f}".replace("-", "−")
    return text.replace("0.", ".", 1) if "0." in text else text[:-1]


def chip_and_map(reference: np.ndarray, point: np.ndarray, r: np.ndarray) -> None:
    """Show a chip, and beside it what its search found: r for every shift."""
    x, y = np.floor(np.asarray(point) + 0.5)
    panels: Look = {"width_ratios": (0.72, 1), "wspace": 0.12}
    fig, (left, right) = plt.subplots(
        1, 2, figsize=(7, 4), layout="compressed", gridspec_kw=panels
    )
    _photo(left, reference, "reference", (x, y), CHIP / 2)
    left.set_title("chip")
    _table_of_r(right, r)
    right.set_title("r for every shift")
    plot.show(
        fig,
        f"Left, a chip of {CHIP} by {CHIP} pixels. Right, r for every shift as a map of"
        f" {len(r)} by {len(r)} squares with their numbers, {_words(r)}",
    )


# --- What lies between the pixels? ---


def darts(clouds: Mapping[str, np.ndarray], truth: np.ndarray) -> None:
    """Show shifts (n, 2) that several methods found around the truth, like darts."""
    x, y = truth
    look: Look = {"sharey": True, "layout": "compressed"}
    fig, axes = plt.subplots(1, len(clouds), figsize=(2.33 * len(clouds), 3.8), **look)
    said = []
    for ax, (name, cloud) in zip(axes, clouds.items()):
        middle = np.median(cloud, axis=0)
        ax.axhline(y, color=plot.GREEN, linewidth=2.5)
        ax.axvline(x, color=plot.GREEN, linewidth=2.5, label="truth")
        whole: Look = {
            "mfc": "none",
            "markersize": 18,
            "mew": 2.2,
            "label": "whole pixel",
        }
        ax.plot(*np.round((x, y)), "s", color=plot.BLACK, **whole)
        ax.plot(*cloud.T, "o", color=plot.SKY, alpha=0.45, ms=7, label="one chip")
        cross: Look = {"mec": "white", "markersize": 14, "label": "median"}
        ax.plot(*middle, "X", color=plot.BLACK, **cross)
        ax.set(xlim=(x - SHOWN, x + SHOWN), ylim=(y + SHOWN, y - SHOWN), aspect="equal")
        off = float(np.hypot(*(middle - (x, y))))
        ax.set_title(f"{name}:\noff by {off:.3f} px", fontsize=14)
        ax.set(xlabel="dx (px)")
        ax.yaxis.set_major_locator(MultipleLocator(0.5))
        ax.xaxis.set_major_locator(MultipleLocator(0.5))
        said.append(f"{name} {off:.3f} px")
    axes[0].set_ylabel("dy (px), downwards")
    handles = axes[0].get_legend_handles_labels()
    spacing: Look = {"handlelength": 1.4, "columnspacing": 1.2}
    fig.legend(*handles, loc="outside lower center", ncols=4, **spacing)
    plot.show(
        fig,
        "The shifts of all chips around the true shift, one panel for each method. The"
        f" median misses the truth by: {', '.join(said)}.",
        colours=128,
    )


# --- Which shifts deserve trust? ---


def beyond(true: np.ndarray, found: np.ndarray, r: np.ndarray) -> None:
    """Show what a search of radius 3 reports of true shifts beyond it, with what r."""
    radius = 3
    wrong = np.abs(found - true) > WRONG
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9), gridspec_kw={"wspace": 0.08})
    end = float(true.max())
    axes[0].plot((0, end), (0, end), color=plot.GREEN, label="as it should be")
    axes[0].axhline(radius, color=plot.BLACK, linestyle=":", label="end of the search")
    axes[0].set(
        xlabel="true dx (px)", ylabel="reported dx (px)", ylim=(-radius - 1, end)
    )
    axes[1].axhline(0.8, color=plot.BLACK, linestyle=":", label="threshold 0.8")
    axes[1].set(xlabel="true dx (px)", ylabel="r at the peak", ylim=(-0.1, 1.03))
    for chosen, mark, colour, name in (
        (~wrong, "o", plot.SKY, "right within 1 px"),
        (wrong, "X", plot.RED, "wrong"),
    ):
        look: Look = {"color": colour, "ls": "none", "markersize": 6, "alpha": 0.55}
        axes[0].plot(true[chosen], found[chosen], mark, **look)
        axes[1].plot(true[chosen], r[chosen], mark, label=name, **look)
    axes[0].set_title("what is reported")
    axes[0].legend(loc="lower left")
    axes[1].legend(loc="lower left", markerscale=1.6)
    passed = int(np.sum(wrong & (r >= 0.8)))
    axes[1].set_title(f"{passed} of {wrong.sum()} wrong ones\nhave r ≥ 0.8")
    plot.show(
        fig,
        "Left, reported against true shift: on the diagonal up to the radius, and from"
        " there on horizontal, the largest possible value. Right, r against the true"
        " shift:"
        f" it falls slowly; {passed} of {wrong.sum()} wrong chips stay above 0.8.",
        colours=128,
    )


# --- Does your program make the images fit? ---


def before_and_after(
    reference: np.ndarray, sensed: np.ndarray, again: np.ndarray
) -> None:
    """Show what counts as changed, before and after the sensed image was resampled.

    Where it has no data `again` is masked or NaN.
    """
    resampled: np.ndarray = np.ma.filled(np.ma.asarray(again, float), np.nan)
    fig, axes = plt.subplots(1, 2, figsize=(7, 4), layout="compressed")
    shares = []
    pairs = ("before", sensed.astype(float)), ("after", resampled)
    for ax, (name, other) in zip(axes, pairs):
        change = np.abs(other - reference)
        changed = change > 300
        shares.append(100 * changed.sum() / np.isfinite(change).sum())
        ax.imshow(changed, cmap="binary", interpolation="nearest")
        ax.set(xticks=[], yticks=[], title=f"{name}: {shares[-1]:.0f} % changed")
        ax.grid(False)
        ax.spines[["top", "right"]].set_visible(True)
    plot.show(
        fig,
        f"Two maps of change, black on white. Before, {shares[0]:.0f} % of the land is"
        f" black, every street and every edge of a field. After, {shares[1]:.0f} %:"
        " what is left is tilted squares, whole fields, on almost empty ground.",
        colours=8,
    )
