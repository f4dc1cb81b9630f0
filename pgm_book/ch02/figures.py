"""Figures of the search by correlation: windows as arrows, maps, and their troubles."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_book.common.figures import outline
from pgm_lab import plot
from pgm_lab.datasets import StereoPair
from pgm_lab.image import cut, resample
from pgm_lab.ncc import correlation, correlation_map
from pgm_lab.plot.basic import Look, interact

REACH = 25  # px that the search of the sliders goes to each side
AWAY = 30  # px that it begins to the left of the point


def window_numbers(windows: Mapping[str, np.ndarray]) -> None:
    """Show small windows with their grey values written in, and r with the first."""
    first, *others = windows.values()
    figsize = (7, 2.6) if others else (3.6, 3.0)
    fig, axes = plt.subplots(1, len(windows), figsize=figsize, squeeze=False)
    said = []
    for ax, (name, window) in zip(axes[0], windows.items()):
        ax.imshow(window, vmin=0, vmax=255)
        if len(others) < 2:
            _write_numbers(ax, window, 13)
        ax.set(xticks=[], yticks=[])
        ax.set_title(name, fontsize=14, loc="center")
        ax.grid(False)
        if others:
            r = correlation(first, window)
            ax.set_xlabel(f"r = {r:.2f}".replace("-", "−"))
            said.append(f"{name}: r = {r:.2f}")
    words = "Windows of grey values. " if others else "A window of grey values"
    words += ", ".join(said) + ("; the first is" if others else ",")
    plot.show(fig, f"{words} bright above, dark at lower right.")


def _write_numbers(ax: Axes, grey: np.ndarray, fontsize: float) -> None:
    """Write its grey value into each pixel."""
    look: Look = {"ha": "center", "va": "center", "fontsize": fontsize}
    for (i, j), g in np.ndenumerate(grey):
        ax.text(j, i, f"{g:.0f}", color="black" if g > 110 else "white", **look)


def window_arrows() -> None:
    """Show windows of three pixels, their means subtracted, as arrows in a plane."""
    a, b = np.array([60.0, 110, 40]), np.array([50.0, 70, 120])
    named = {"a": a, "0.6 a + 80": 0.6 * a + 80, "255 − a": 255 - a, "b": b}
    # Centred windows of three pixels lie in the plane where the parts sum to zero
    across = np.array([1, 0, -1]) / np.sqrt(2), np.array([-1, 2, -1]) / np.sqrt(6)
    shapes: Look = {"width_ratios": (0.8, 1)}
    fig, (left, ax) = plt.subplots(1, 2, figsize=(10, 4.3), gridspec_kw=shapes)
    rows = np.array(list(named.values()))
    left.imshow(rows, vmin=0, vmax=255, aspect="auto")
    _write_numbers(left, rows, 14)
    left.set_yticks(range(4), list(named))
    left.set(xticks=[], title="four windows of three pixels")
    left.grid(False)
    colours = (plot.BLUE, plot.ORANGE, plot.RED, plot.GREEN)
    places = {"a": (8, 6), "0.6 a + 80": (-56, -8), "255 − a": (0, -18), "b": (-8, 6)}
    for (name, window), colour in zip(named.items(), colours):
        tip = np.array([axis @ (window - window.mean()) for axis in across])
        wide = 7 if name.startswith("0.6") else 2.6
        look: Look = {"arrowstyle": "-|>", "color": colour, "linewidth": wide}
        look |= {"shrinkA": 0, "shrinkB": 0, "alpha": 0.75, "mutation_scale": 22}
        ax.annotate("", tip, (0, 0), arrowprops=look)
        text: Look = {"textcoords": "offset points", "ha": "center", "fontsize": 14}
        ax.annotate(name, tip, places[name], **text)
    tips = [np.array([axis @ (w - w.mean()) for axis in across]) for w in (a, b)]
    low, high = sorted(np.arctan2(tip[1], tip[0]) for tip in tips)
    if high - low > np.pi:
        low, high = high, low + 2 * np.pi
    turn = np.linspace(low, high, 60)
    ax.plot(14 * np.cos(turn), 14 * np.sin(turn), color=plot.BLACK, linewidth=1.5)
    middle = (low + high) / 2
    ax.text(19 * np.cos(middle) - 3, 19 * np.sin(middle) - 3, r"$\theta$", fontsize=17)
    ax.plot(0, 0, "o", color=plot.BLACK)
    ax.set(xlim=(-75, 75), ylim=(-62, 68), aspect="equal")
    ax.set(xlabel="grey values", ylabel="grey values", title="without means: a plane")
    plot.show(
        fig,
        "Left, four windows of three grey values. Right, the same windows with their"
        " means subtracted, as arrows from one point: 0.6 a + 80 lies along a and is"
        " shorter, 255 − a points the other way, and b makes an angle theta with a.",
    )


def parts_of_r(
    left: np.ndarray,
    right: np.ndarray,
    point: np.ndarray,
    start: np.ndarray,
    template: int,
    search: int,
) -> None:
    """Show a search with its parts named: template, window, map and landscape."""
    r = correlation_map(cut(left, point, template), cut(right, start, search))
    fig = plt.figure(figsize=(9.6, 4.6))
    grid = fig.add_gridspec(2, 3, width_ratios=(1, 1, 2.3))
    places = ((0, 0), (0, 1), (1, 0), (1, 1))
    axes = [fig.add_subplot(grid[row, column]) for row, column in places]
    draw_window(axes[0], left, point, 61)
    outline(axes[0], point, template, plot.ORANGE)
    draw_window(axes[1], left, point, template)
    draw_window(axes[2], right, start, search)
    drawn = draw_map(axes[3], r)
    ax = fig.add_subplot(grid[:, 2], projection="3d", computed_zorder=False)
    ax.view_init(elev=32, azim=-62)
    shift = np.array(draw_surface(ax, r))
    ax.set_box_aspect((1, 1, 0.8), zoom=0.88)
    outline(axes[2], start + shift, template, plot.ORANGE)
    axes[3].plot(*shift, "o", color=plot.RED, mfc="none", markersize=14, mew=2.5)
    names = ("left photo", "template", "search window", "r by shift (px)")
    for one, name in zip(axes, names):
        one.set_title(name, fontsize=14)
        if one is not axes[3]:
            one.set(xticks=[], yticks=[])
    fig.colorbar(drawn, ax=axes[3], shrink=0.8)
    plot.show(
        fig,
        "The template framed in the left photo, the template alone, the search window"
        " of the right photo with the place found, r for every shift as a coloured map,"
        f" and the same as a landscape: one sharp summit, r = {r.max():.2f}, at the"
        f" shift ({shift[0]}, {shift[1]}) px, over low hills.",
        colours=128,
    )


def templates(
    left: np.ndarray, right: np.ndarray, point: np.ndarray, start: np.ndarray
) -> None:
    """Show the landscapes of one point for templates of several widths."""
    fig = plt.figure(figsize=(6.2, 4.6), layout="none")
    said = []
    for k, size in enumerate((5, 11, 21, 51)):
        r = correlation_map(cut(left, point, size), cut(right, start, size + 60))
        middle, around = r[1:-1, 1:-1], np.lib.stride_tricks.sliding_window_view
        summits = middle >= around(r, (3, 3)).max(axis=(2, 3))
        said.append(f"{size} px: {np.sum(summits & (middle > 0.6))}")
        where = (0.5 * (k % 2) - 0.02, 0.5 - 0.5 * (k // 2), 0.54, 0.51)
        space: Look = {
            "projection": "3d",
            "computed_zorder": False,
            "facecolor": "none",
        }
        ax: Any = fig.add_axes(where, **space)
        ax.view_init(elev=34, azim=-62)
        draw_surface(ax, r, label=False)
        ax.set(xticklabels=[], yticklabels=[], zticklabels=[])
        for axis, name in zip((ax.xaxis, ax.yaxis, ax.zaxis), ("columns", "rows", "r")):
            axis.labelpad = -14
            axis.set_label_text(name, fontsize=13)
        ax.set_box_aspect((1, 1, 0.8), zoom=0.98)
        fig.text(where[0] + 0.05, where[1] + 0.44, f"{size} × {size} px", fontsize=15)
    plot.show(
        fig,
        "Landscapes of r over the shift, 30 px to each side, for four widths of the"
        f" template. Summits with r above 0.6: {'; '.join(said)}.",
        colours=128,
    )


def search_by_hand(left: np.ndarray, right: np.ndarray, disparity: np.ndarray) -> None:
    """Show the search of a point that sliders place, with the size of its template."""
    import ipywidgets

    (rows, columns), edge = left.shape, 60

    def draw(x: int, y: int, size: int) -> None:
        start = np.array([x - AWAY, y])
        around = cut(right, start, size + 2 * REACH)
        r = correlation_map(cut(left, (x, y), size), around)
        i, j = np.unravel_index(r.argmax(), r.shape)
        shift = np.array([j, i]) - REACH
        fig, axes = plt.subplots(1, 3, figsize=(10, 3.7))
        draw_window(axes[0], left, (x, y), size)
        draw_window(axes[1], right, start, size + 2 * REACH)
        outline(axes[1], start + shift, size, plot.ORANGE)
        fig.colorbar(draw_map(axes[2], r), ax=axes[2], shrink=0.8)
        axes[2].plot(*shift, "x", color=plot.RED, markersize=14, mew=3)
        true = AWAY - disparity[y, x]
        if np.isfinite(true):
            axes[2].plot(true, 0, "wo", mfc="none", markersize=17, mew=2.5)
        for ax, name in zip(axes, ("template", "search window", "r by shift (px)")):
            ax.set_title(name)
        axes[2].set_xlabel("× highest r, ○ truth")
        drawn = f"template of {size} px at ({x}, {y}), highest r = {r.max():.2f}"
        fig.suptitle(drawn)
        plot.show(fig, f"Template, search window and map of r; {drawn}.", colours=128)

    look: Look = {"continuous_update": False}
    x = ipywidgets.IntSlider(318, 130, columns - edge, 2, description="column", **look)
    y = ipywidgets.IntSlider(318, edge, rows - edge, 2, description="row", **look)
    interact(
        draw,
        x=x,
        y=y,
        size=ipywidgets.IntSlider(21, 3, 61, 2, description="width", **look),
    )


# --- Parts of these figures: a window, a map of r, and r as a landscape ---


def draw_window(ax: Axes, image: np.ndarray, centre: ArrayLike, size: int) -> None:
    """Show the window around a pixel, with axes in pixels of the whole image."""
    column, row = np.floor(np.asarray(centre) + 0.5)
    half = size / 2
    extent = (column - half, column + half, row + half, row - half)
    ax.imshow(cut(image, centre, size), extent=extent, cmap="gray")
    ax.grid(False)


def draw_map(ax: Axes, r: np.ndarray) -> AxesImage:
    """Show a square correlation map by colour, over the shift from its middle."""
    half = len(r) / 2
    extent = (-half, half, half, -half)
    ax.grid(False)
    return ax.imshow(r, extent=extent, cmap="cividis", vmin=-0.5, vmax=1)


def draw_surface(ax: Axes3D, r: np.ndarray, label: bool = True) -> tuple[int, int]:
    """Draw a square correlation map as a landscape, its map below, and mark the summit.

    It returns the shift (columns, rows) of the summit from the middle.
    """
    lowest = -0.6  # where the map lies
    d = np.arange(len(r)) - len(r) // 2
    x, y = np.meshgrid(d, d)
    look: Look = {"cmap": "cividis", "vmin": -0.5, "vmax": 1}
    ax.contourf(x, y, r, levels=20, zdir="z", offset=lowest, zorder=1, **look)
    mesh: Look = {"rstride": 1, "cstride": 1, "linewidth": 0.15}
    ax.plot_surface(x, y, r, zorder=2, edgecolor="#00000055", **mesh, **look)
    i, j = np.unravel_index(r.argmax(), r.shape)
    top = (d[j], d[i], r[i, j])
    ax.plot(*[[v] for v in top], "o", color=plot.RED, markersize=9, zorder=4)
    ax.plot(top[0], top[1], lowest, "o", color=plot.RED, markersize=6, zorder=3)
    if label:
        ax.text(*(np.array(top) + (0, 0, 0.12)), f"r = {r[i, j]:.2f}", color=plot.RED)
    ax.set(zlim=(lowest, 1.15), zticks=(0, 0.5, 1))
    ax.invert_yaxis()  # rows count downwards
    ax.set_xlabel("columns (px)", labelpad=6)
    ax.set_ylabel("rows (px)", labelpad=6)
    ax.set_zlabel("r", labelpad=2)
    ax.xaxis.set_major_locator(plt.MaxNLocator(4))
    ax.yaxis.set_major_locator(plt.MaxNLocator(4))
    return int(d[j]), int(d[i])


# --- Between the pixels ---


def summit(r: np.ndarray) -> None:
    """Show r beside its highest value in a map, and ask where the hill is highest."""
    row, column = np.unravel_index(r.argmax(), r.shape)
    r = r[row, column - 1 : column + 2]
    slope, bend = (r[2] - r[0]) / 2, 2 * r[1] - r[0] - r[2]
    t = np.linspace(-1.15, 1.15, 200)
    fig, ax = plt.subplots(figsize=(10, 3.6))
    ax.plot(t, r[1] + slope * t - bend * t**2 / 2, "--", label="parabola")
    ax.plot((-1, 0, 1), r, "o", color=plot.BLACK, ms=12, label="r, computed")
    beside: Look = {"textcoords": "offset points", "fontsize": 16, "ha": "right"}
    for at, name, value in zip((-1, 0, 1), ("-1", "0", "+1"), r):
        ax.annotate(f"$r_{{{name}}}$", (at, value), (-12, -20 * (at == 0)), **beside)
    ax.axvline(slope / bend, color=plot.RED, linestyle=":", label="top, $t$ = ?")
    ax.set(xlabel="shift (px)", ylabel="r", xticks=(-1, 0, 1), xlim=(-1.3, 2.1))
    ax.legend(loc="upper right")
    plot.show(
        fig,
        "r at the shifts −1, 0 and 1 px as dots, a parabola through them, and a dotted"
        " line at its top, between 0 and the higher neighbour.",
    )


# --- Searches that go wrong: six landscapes, and where the wrong points lie ---

LOG = (640, 190)  # (column, row) of a fallen log in the orthophoto


def six_troubles(pair: StereoPair, ground: np.ndarray) -> list[tuple]:
    """Six searches: a good one, and five kinds of trouble.

    Each is (left, point, right, start, width of the template, true place); in the last
    two a log on the orthophoto `ground` is seen rotated and foreshortened.
    """
    column, row = np.meshgrid(np.arange(-40, 41), np.arange(-40, 41))
    a, b = np.cos(np.radians(30)), np.sin(np.radians(30))
    turned = np.stack([a * column - b * row, b * column + a * row], axis=-1)
    squeezed = np.stack([2.0 * column, row], axis=-1)
    searches: list[tuple] = []
    places = (((415, 320), 375, 21), ((510, 375), 463, 21), ((154, 138), 132, 11),
              ((480, 288), 450, 21))  # fmt: skip
    for (x, y), start, size in places:
        true = np.array([x - pair.disparity[y, x], y])
        searches.append((pair.left, (x, y), pair.right, (start, y), size, true))
    for seen in (turned, squeezed):
        again = resample(ground, np.array(LOG) + seen)
        searches.append((ground, LOG, again, (40, 40), 21, np.array([40.0, 40])))
    return searches


def gallery(searches: Sequence[tuple], found: np.ndarray) -> None:
    """Show searches in columns: template, search window, r by shift, found and true."""
    fig, axes = plt.subplots(3, len(searches), figsize=(8.8, 4.75), squeeze=False)
    for column, name, search, place in zip(axes.T, "ABCDEF", searches, found):
        left, point, right, start, size, true = search
        around = cut(right, start, size + 60)
        draw_window(column[0], left, point, size)
        draw_window(column[1], right, start, size + 60)
        outline(column[1], place, size, plot.RED)
        drawn = draw_map(column[2], correlation_map(cut(left, point, size), around))
        middle = np.asarray(start)
        column[2].plot(*(place - middle), "x", color=plot.RED, ms=13, mew=3)
        column[2].plot(*(true - middle), "wo", mfc="none", ms=15, mew=2.5)
        column[0].set_title(name, fontsize=13, loc="center")
    plt.setp(axes, xticks=[], yticks=[])
    for ax, text in zip(axes[:, 0], ("template", "search window", "r, ± 30 px")):
        ax.set_ylabel(text, fontsize=14)
    fig.colorbar(drawn, ax=axes[2], label="r")
    plot.show(
        fig,
        "Six searches in columns, each with template, search window and map of r; an"
        " orange cross marks the highest r, a white ring the truth. A: one summit at"
        " the truth. B, a floor in shadow: broad ridges without a summit. C, the slats"
        " of a bench: a row of equal ridges, the cross two slats beside the ring. D, a"
        " floor beside the engine: one high summit, far from the ring. E, a log"
        " rotated, and F, a log seen at half its width: no clear summit.",
        colours=128,
    )


def right_and_wrong(photo: np.ndarray, points: np.ndarray, right: np.ndarray) -> None:
    """Show accepted points on their photo, those that agree with the truth apart."""
    points, good = np.asarray(points), np.asarray(right)
    fig, ax = plt.subplots(figsize=(6, 4.4))
    ax.imshow(photo, alpha=0.7)
    looks = ((good, "o", plot.SKY, "right", 4), (~good, "X", plot.RED, "wrong", 9))
    for chosen, mark, colour, name, size in looks:
        label = f"{name}, {100 * np.mean(chosen):.0f} %"
        look: Look = {"color": colour, "linestyle": "none", "label": label}
        ax.plot(*points[chosen].T, mark, ms=size, mec="black", mew=0.7, **look)
    ax.set_axis_off()
    fig.legend(loc="outside lower center", ncols=2, fontsize=14)
    plot.show(
        fig,
        f"The left photo with {len(points)} accepted points. {np.sum(~good)} are wrong,"
        " and most lie along the edges of objects, where the depth changes.",
        colours=128,
    )
