"""Figures of stereo plotting: two photos, the normal case, the search along a row."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from pgm_book.program.stereo import along_row
from pgm_lab import plot
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.plot.basic import Look, composite, grey_levels, interact
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import NormalPair, Surface, Terrain, quality

NAMES = ("left photo", "right photo")
BAND = 60  # px shown to each side of a row
CONTOURS = 2.5  # m, as in Harintaka 2020
GLASSES = "red and cyan (with glasses)"
COLOURS = "green and magenta"
SIZE = 41  # px across what is shown
EXTENT = (-SIZE / 2, SIZE / 2, SIZE / 2, -SIZE / 2)
WORDS: Look = {"fontsize": 18}
BOX: Look = {"bbox": {"facecolor": "white", "edgecolor": "none", "pad": 1.5}}
BOTH_ENDS: Look = {"arrowstyle": "<|-|>", "shrinkA": 0, "shrinkB": 0, "linewidth": 1.6}
LOOK_AT = np.radians((25.0, -68.0))  # elevation and azimuth of the reader's eye


# --- How do two photos give a height? ---


def photo_pair(left: Photo, right: Photo) -> Figure:
    """Draw two photos side by side."""
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.2), layout="compressed")
    for ax, photo, name in zip(axes, (left, right), NAMES):
        _bare(ax, photo.grey, name)
    return fig


def _bare(ax: Axes, image: np.ndarray, title: str) -> None:
    """Draw an image without numbers at its edges."""
    ax.imshow(np.nan_to_num(grey_levels(image, "image"), nan=1.0), vmin=0, vmax=1)
    ax.set(xticks=[], yticks=[])
    ax.set_title(title, fontsize=18)
    ax.grid(False)


def parallax_sketch() -> None:
    """Show two photos of a mast from the side, and the parallaxes of its two ends."""
    H, B, c, X = 10.0, 5.0, 2.2, 2.9
    kinds = (("foot", 0.0, plot.BLUE, "--"), ("top", 4.2, plot.RED, "-"))
    panels: Look = {"width_ratios": (1.75, 1), "wspace": 0.06}
    fig, (side, bars) = plt.subplots(
        1, 2, figsize=(10, 4.6), layout="constrained", gridspec_kw=panels
    )
    side.fill_between((-1.6, 7.6), -0.5, 0, color="0.85", linewidth=0)
    side.plot((X, X), (0, 4.2), color="0.45", lw=7, solid_capstyle="butt")
    side.annotate("", (0, H), (B, H), arrowprops=BOTH_ENDS)
    side.text(B / 2, H + 0.25, "base $B$", ha="center", **WORDS)
    side.annotate("", (-1.2, 0), (-1.2, H), arrowprops=BOTH_ENDS)
    side.text(-1.2, 4.6, "$H$", ha="center", **WORDS, **BOX)
    side.annotate("", (-0.45, H - c), (-0.45, H), arrowprops=BOTH_ENDS)
    side.text(-0.45, H - c / 2, "$c$", ha="center", va="center", **WORDS, **BOX)
    for k, (at, name) in enumerate(((0.0, "$O'$"), (B, "$O''$"))):
        side.plot(at, H, "o", color=plot.BLACK, markersize=9)
        side.text(at, H + 0.3, name, ha="right" if k == 0 else "left", **WORDS)
        side.plot((at - 1.5, at + 1.5), (H - c, H - c), color=plot.BLACK, lw=4)
        side.plot((at, at), (H, H - c), color=plot.BLACK, lw=1.2, ls=":")
        side.plot(at, H - c, "|", color=plot.BLACK, markersize=16)
        for _, Z, colour, line in kinds:
            side.plot((at, X), (H, Z), color=colour, ls=line, lw=1.8)
            x = c * (X - at) / (H - Z)
            side.plot(at + x, H - c, "o", color=colour, markersize=9, zorder=4)
    side.text(-1.1, H - c - 0.95, "left photo", **WORDS, **BOX)
    side.text(B - 0.1, H - c - 0.95, "right photo", **WORDS)
    side.text(X + 0.45, 3.9, "top", color=plot.RED, **WORDS, **BOX)
    side.text(X + 0.35, 0.15, "foot", color=plot.BLUE, **WORDS)
    side.set(xlim=(-1.7, 7.7), ylim=(-0.5, H + 1.1), aspect="equal")
    side.axis("off")
    for k, (name, Z, colour, _) in enumerate(kinds):
        one, other = c * X / (H - Z), c * (X - B) / (H - Z)
        bars.barh(k, one, 0.42, color=colour)
        bars.barh(k, other, 0.42, facecolor="white", edgecolor=colour, lw=3)
        bars.text(one / 2, k, "$x'$", ha="center", va="center", color="white", **WORDS)
        bars.text(other / 2, k, "$x''$", ha="center", va="center", **WORDS)
        level = k + 0.36
        bars.annotate("", (other, level), (one, level), arrowprops=BOTH_ENDS)
        text = f"$p_x$ of the {name}"
        bars.text((one + other) / 2, level + 0.07, text, ha="center", **WORDS, **BOX)
    bars.axvline(0, color=plot.BLACK, lw=1.2)
    bars.set(ylim=(-0.45, 1.75), xlim=(-1.05, 1.25))
    bars.set_title("one photo laid on the other", loc="center")
    bars.axis("off")
    plot.show(
        fig,
        "Left, seen from the side: two perspective centres O' and O'' at height H above"
        " the ground, the base B between them, a photo at the distance c below each."
        " Rays run from a mast's foot and top to both. Right, the two photos laid on"
        " each other: the distance from x'' to x' is greater for the top than for the"
        " foot.",
    )


def laid(pair: NormalPair, disparity: int) -> None:
    """Show the right photo laid on the left one, moved by a disparity."""
    right = np.roll(pair.right, disparity, axis=1)
    right[:, disparity:] = np.nan  # it is negative
    fig, ax = plt.subplots(figsize=(7, 4.5), layout="compressed")
    ax.imshow(composite(pair.left, right), interpolation="nearest")
    ax.set(xticks=[], yticks=[], xlabel="green: left photo, magenta: right photo")
    ax.grid(False)
    plot.show(
        fig,
        "Both photos in two colours, laid on each other. What is as high as the road"
        " crossing is grey and fits, one roof among it. Tree tops and another roof have"
        " rims in both colours on the left and right, as has lower and higher ground.",
        colours=96,
    )


# --- When does the mark touch the ground? ---


def mark_positions(
    pair: NormalPair, place: tuple[int, int], disparities: Sequence[float]
) -> None:
    """Show the mark at several disparities, one panel each."""
    column, row = place
    fig, axes = plt.subplots(1, len(disparities), figsize=(7, 3.1), layout="compressed")
    for ax, d in zip(axes, disparities):
        _two_colours(ax, pair, column, row, d, COLOURS)
        Z = float(pair.object_points(column, row, d)[2])
        ax.set_title(f"{_minus(d)} px: {Z:.1f} m")
    words = "disparity, height of the mark; green: left, magenta: right photo"
    fig.supxlabel(words, fontsize=14)
    plot.show(
        fig,
        "The surroundings of one point from both photos in two colours, laid on each"
        " other so that the two marks coincide, for disparities of "
        + ", ".join(map(_minus, disparities))
        + " px. Where a panel is grey around the mark, the mark is on the ground.",
        colours=128,
    )


def _two_colours(
    ax: Axes, pair: NormalPair, column: int, row: int, d: float, colours: str
) -> None:
    """Lay the surroundings of both marks on each other."""
    left, right = _part(pair.left, column, row), _part(pair.right, column - d, row)
    red = colours == GLASSES
    stack = [left, right, right] if red else [right, left, right]
    ax.imshow(np.nan_to_num(np.stack(stack, axis=-1), nan=1.0), extent=EXTENT)
    _mark(ax, plot.BLACK)


def _part(image: np.ndarray, column: float, row: float) -> np.ndarray:
    """Grey levels from 0 to 1 around a place, between the pixels by a line."""
    step = np.arange(SIZE) - SIZE // 2
    places = np.meshgrid(row + step, column + step, indexing="ij")
    part = scipy.ndimage.map_coordinates(image, places, order=1, mode="nearest")
    return grey_levels(part, "image")


def _mark(ax: Axes, colour: str) -> None:
    """Draw the mark at the centre, and nothing at the edges."""
    for width, ink in (
        (5.0, "white" if colour == plot.BLACK else "black"),
        (2, colour),
    ):
        ax.plot(0, 0, "+", color=ink, ms=22 + width, mew=width)
    ax.set(xticks=[], yticks=[])
    ax.grid(False)


def _minus(d: float) -> str:
    return f"{d:.1f}".replace("-", "−")


def mark_by_hand(
    pair: NormalPair, place: tuple[int, int], start: float, reach: float
) -> None:
    """Show the two marks side by side, laid on each other and subtracted; a slider.

    The left mark stays on its point, the slider moves the right one along the row.
    """
    import ipywidgets

    column, row = place

    def draw(disparity: float, colours: str) -> None:
        d = disparity
        fig, axes = plt.subplots(1, 4, figsize=(10, 3.4), layout="compressed")
        parts = _part(pair.left, column, row), _part(pair.right, column - d, row)
        for ax, part, name in zip(axes, parts, NAMES):
            ax.imshow(part, extent=EXTENT, vmin=0, vmax=1)
            _mark(ax, plot.YELLOW)
            ax.set_title(name)
        _two_colours(axes[2], pair, column, row, d, colours)
        axes[2].set_title("both")
        axes[3].imshow(parts[0] - parts[1], extent=EXTENT, vmin=-0.5, vmax=0.5)
        _mark(axes[3], plot.YELLOW)
        axes[3].set_title("left − right")
        for ax in axes:
            ax.set_xticks((-20, 0, 20))
        fig.supxlabel("columns from the mark (px)", fontsize=14)
        Z = float(pair.object_points(column, row, d)[2])
        fig.suptitle(f"disparity {_minus(d)} px: the mark stands at Z = {Z:.1f} m")
        plot.show(
            fig,
            f"{SIZE} by {SIZE} pixels of the left and of the right photo, a mark in the"
            f" middle of each, and both laid on each other in {colours}: the marks"
            " coincide, the ground around them may not. Beside it the difference of"
            f" their grey values. Disparity {_minus(d)} px.",
            colours=128,
        )

    look: Look = {"step": 0.5, "continuous_update": False, "description": "disparity"}
    slider = ipywidgets.FloatSlider(start, min=start - reach, max=start + reach, **look)
    names = ipywidgets.Dropdown(options=[COLOURS, GLASSES], description="colours")
    interact(draw, disparity=slider, colours=names)


# --- Where must the match lie? ---


def parallax_plane() -> None:
    """Show two rays, the base and the plane that they span, with all parts named."""
    O1, O2 = np.array([0.0, 0.0, 5.0]), np.array([5.6, 0.5, 5.2])
    P, c = np.array([3.3, 1.0, 0.0]), 1.9
    fig, ax = plt.subplots(figsize=(10, 4.7), layout="constrained")
    triangle = _flat(np.array([O1, O2, P]))
    ax.add_patch(Polygon(triangle, facecolor=plot.YELLOW, alpha=0.35, zorder=0))
    normal = np.cross(O2 - O1, P - O1)
    turns = (np.radians((4.0, -6.0, 5.0)), np.radians((-5.0, 5.0, -8.0)))
    for k, (centre, turn) in enumerate(zip((O1, O2), turns)):
        M = attitude(np.array([*centre, *turn]))
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (1.25, 0.95)
        quad = centre + np.column_stack([corners, np.full(4, -c)]) @ M
        ax.add_patch(
            Polygon(_flat(quad), facecolor="white", alpha=0.75, ec="0.25", lw=2)
        )
        a, b, w = M @ normal  # a x + b y - c w = 0 is the epipolar line
        x = np.array([-1.25, 1.25])
        ends = centre + np.column_stack([x, (c * w - a * x) / b, [-c, -c]]) @ M
        ax.plot(*_flat(ends).T, color=plot.GREEN, lw=3.5)
        points = [P] if k == 0 else [P, P + 0.17 * (O1 - P), P - 0.2 * (O1 - P)]
        for i, point in enumerate(points):
            u = M @ (point - centre)
            image = centre + (-c * u / u[2]) @ M
            main = i == 0
            style: Look = {"color": plot.BLACK if main else "0.45", "zorder": 3}
            line = _flat(np.array([centre, point])).T
            ax.plot(*line, ls="-" if main else ":", lw=2.2 if main else 1.8, **style)
            ax.plot(*_flat(image[None])[0], "o", ms=10 if main else 7, **style)
            if main:
                name = ("$p'$", "$p''$")[k]
                _name(ax, name, image, (-30, 6) if k == 0 else (-32, -22))
            else:
                ax.plot(*_flat(point[None])[0], "o", ms=7, **style)
    farther = np.array([P, P - 0.2 * (O1 - P)])
    ax.plot(*_flat(farther).T, ls="-", lw=2.2, color=plot.BLACK)
    ax.plot(*_flat(np.array([O1, O2])).T, color=plot.RED, lw=3)
    for point, name, at in (
        (O1, "$O'$", (-28, 8)), (O2, "$O''$", (8, 8)), (P, "$P$", (-24, -14))
    ):  # fmt: skip
        ax.plot(*_flat(point[None])[0], "o", color=plot.BLACK, ms=10, zorder=4)
        _name(ax, name, point, at)
    _name(ax, "base", (O1 + O2) / 2, (-20, 10), plot.RED)
    _name(ax, "epipolar plane", 0.31 * (O1 + O2) + 0.38 * P, (-58, 6), "0.25")
    right = attitude(np.array([*O2, *turns[1]]))
    a, b, w = right @ normal
    end = O2 + np.array([1.25, (c * w - a * 1.25) / b, -c]) @ right
    _name(ax, "epipolar line of $p'$", end, (14, -6), plot.GREEN)
    _name(ax, "higher?", P + 0.17 * (O1 - P), (-88, -4), "0.35")
    _name(ax, "lower?", P - 0.2 * (O1 - P), (12, -6), "0.35")
    ax.margins(0.06)
    ax.set_aspect("equal")
    ax.axis("off")
    plot.show(
        fig,
        "Two perspective centres O' and O'', joined by the base, with a tilted photo"
        " below each. Rays from both meet in the point P; base and rays span the"
        " epipolar plane, shaded, which cuts each photo in a line. A higher and a lower"
        " point on the left ray have the same p'; in the right photo all lie on the"
        " epipolar line of p'.",
    )


def _flat(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) as the reader's eye sees them, (n, 2)."""
    elevation, azimuth = LOOK_AT
    s, co = np.sin(azimuth), np.cos(azimuth)
    se, ce = np.sin(elevation), np.cos(elevation)
    axes = np.array([(-s, co, 0.0), (-se * co, -se * s, ce)])
    return points @ axes.T


def _name(
    ax: Axes,
    name: str,
    point: np.ndarray,
    at: tuple[float, float],
    colour: str = plot.BLACK,
) -> None:
    """Write a name beside a point in space, so many points to the right and up."""
    text: Look = {"textcoords": "offset points", "fontsize": 19, "color": colour}
    ax.annotate(name, tuple(_flat(point[None])[0]), at, zorder=5, **text)


def epipolar_line(
    left: Photo,
    right: Photo,
    pixel: tuple[float, float],
    line: np.ndarray,
    places: np.ndarray,
    heights: Sequence[float],
) -> None:
    """Show the epipolar line of a left pixel in the right photo.

    Its pixels (k, 2) are given, and the places (n, 2) of some heights (m) on it.
    """
    column, row = pixel
    fig, axes = plt.subplots(1, 2, figsize=(10, 2.3), layout="compressed")
    for ax, photo, name in zip(axes, (left, right), NAMES):
        _bare(ax, photo.grey, name)
        last = photo.grey.shape[0] - 0.5
        ax.set_ylim(min(row + 1.4 * BAND, last), max(row - 1.4 * BAND, -0.5))
    look: Look = {"ms": 20, "mew": 3, "color": plot.ORANGE}
    axes[0].plot(column, row, "+", **look)
    axes[1].autoscale(False)
    axes[1].plot(*line.T, color=plot.GREEN, lw=2)
    axes[1].plot(*places.T, "|", ms=18, mew=3, color=plot.ORANGE)
    text: Look = {"textcoords": "offset points", "ha": "center", "fontsize": 14}
    box = {"fc": "white", "ec": "none", "pad": 1}
    for place, height in zip(places, heights):
        axes[1].annotate(f"{height:g}", place, (0, 16), bbox=box, **text)
    axes[1].set_title("right photo, heights in m", fontsize=18)
    plot.show(
        fig,
        "Left photo with a cross at one point; right photo with a straight line across"
        f" it, hardly tilted, and {len(places)} strokes on it where the point would lie"
        f" at {', '.join(f'{h:g}' for h in heights)} m: the higher, the farther left.",
        dpi=110,
        colours=48,
    )


def epipolar_rows(
    left: Photo, right: Photo, pair: NormalPair, row: int, columns: tuple[int, int]
) -> Figure:
    """Draw a pair before and after it was resampled to the normal case."""
    fig, axes = plt.subplots(2, 2, figsize=(10, 3.4), layout="compressed")
    images = left.grey, right.grey, pair.left, pair.right
    titles = [*NAMES, "left, normal case", "right, normal case"]
    for ax, image, title in zip(axes.ravel(), images, titles):
        _bare(ax, image, title)
        ax.axhline(row, color=plot.ORANGE, lw=2)
        ax.set(
            xlim=columns, ylim=(row + 20, row - 20)
        )  # enlarged: rows can be told apart
    return fig


def y_parallaxes(cases: Mapping[str, np.ndarray]) -> None:
    """Show y parallaxes (px) of several orientations, a column of points for each."""
    fig, ax = plt.subplots(figsize=(7, 3.1), layout="constrained")
    colours = (plot.GREEN, plot.RED, plot.BLUE, plot.PURPLE)
    said = []
    for k, ((name, values), colour) in enumerate(zip(cases.items(), colours)):
        spread = np.linspace(-0.18, 0.18, len(values))
        ax.plot(k + spread, values, "o", color=colour, alpha=0.5, ms=6)
        ax.plot((k - 0.3, k + 0.3), [np.median(values)] * 2, color=plot.BLACK, lw=3)
        said.append(f"{name.replace(chr(10), ' ')}: {np.median(values):.2f} px")
    ax.axhline(0, color="0.5", lw=1)
    ax.set_xticks(range(len(cases)), list(cases))
    ax.set(ylabel="y parallax (px)", xlim=(-0.5, len(cases) - 0.5))
    ax.grid(axis="x")
    plot.show(
        fig,
        "y parallaxes of matched points, a column of dots for each orientation, with"
        f" the median as a bar. Medians: {'; '.join(said)}.",
        colours=64,
    )


# --- How does a computer find the match? ---


def row_search(
    pair: NormalPair, place: tuple[int, int], window: int, low: int, high: int
) -> None:
    """Show the search of one window along its row."""
    column, row = place
    tried, r = along_row(pair.left, pair.right, column, row, window, low, high)
    best = int(r.argmax())
    fig = plt.figure(figsize=(10, 3.5), layout="constrained")
    one, strip, curve = fig.subplot_mosaic(
        "lr;lc", width_ratios=(1, 3), height_ratios=(1, 1.7)
    ).values()
    reach = (tried[-1] - tried[0]) // 2 + 14
    middle = column - (tried[0] + tried[-1]) // 2
    for ax, image, at, far, half, name in (
        (one, pair.left, column, 10, 10, "left: one window"),
        (strip, pair.right, middle, reach, 12, "right: the same row"),
    ):
        _bare(ax, image, name)
        ax.set(xlim=(at - far, at + far), ylim=(row + half, row - half))
    strip.set_aspect("auto")  # exactly above the curve
    frame: Look = {"fill": False, "lw": 2.5}
    for ax, at, colour in (
        (one, column, plot.ORANGE), (strip, column - tried[best], plot.ORANGE)
    ):  # fmt: skip
        ax.add_patch(
            plt.Rectangle(
                (at - window / 2, row - window / 2), window, window, ec=colour, **frame
            )
        )
    strip.axhline(row, color=plot.GREEN, lw=1.5)
    curve.plot(tried, r, "o-", color=plot.BLUE)
    curve.plot(tried[best], r[best], "o", color=plot.ORANGE, ms=14)
    curve.axhline(0.8, color=plot.BLACK, ls=":")
    curve.text(tried[0] - 3, 0.83, "0.8", fontsize=14, ha="right")
    label = "disparity (px), falling as the right window moves to the right"
    curve.set(xlabel=label, ylabel="r", ylim=(r.min() - 0.1, 1.1))
    curve.set_xlim(column - middle + reach, column - middle - reach)
    plot.show(
        fig,
        "Above, a window in the left photo and the same row of the right one with the"
        f" window where it fits best. Below, r over the disparity: {len(r)} values, the"
        f" highest {r[best]:.2f} at {tried[best]} px.",
        colours=96,
    )


def height_threshold(error: np.ndarray, r: np.ndarray, limit: float) -> None:
    """Show what a threshold of r keeps of right heights (within 1 m) and of wrong."""
    wrong = np.abs(error) > 1
    at = np.linspace(-0.2, 1, 121)
    fig, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
    said = []
    for kind, name, colour, line in (
        (~wrong, "right within 1 m", plot.BLUE, "-"),
        (wrong, "wrong", plot.RED, "--"),
    ):
        share = 100 * np.mean(r[kind][:, None] >= at, axis=0)
        kept = 100 * float(np.mean(r[kind] >= limit))
        ax.plot(at, share, color=colour, ls=line, label=name)
        ax.plot(limit, kept, "o", color=colour, ms=11)
        said.append(f"{kept:.0f} % of the {name.split()[0]} ones")
        text: Look = {"textcoords": "offset points", "color": colour, "fontsize": 15}
        ax.annotate(f"{kept:.0f} %", (limit, kept), (10, 2), **text)
    ax.axvline(limit, color=plot.BLACK, ls=":", lw=1.5)
    ax.set(xlabel="threshold of r", ylabel="kept (%)", xlim=(0, 1), ylim=(0, 104))
    ax.legend(loc="lower left")
    plot.show(
        fig,
        "Share of the right (within 1 m) and of the wrong heights that a threshold of r"
        f" keeps. At {limit:g} it keeps {' and '.join(said)}.",
        colours=64,
    )


# --- How good is a height? ---


def parallax_worth() -> None:
    """Show how far a height moves when a ray moves by a pixel, for two bases."""
    H, wide = 6.0, 0.44
    fig, axes = plt.subplots(1, 2, figsize=(7, 2.8), layout="constrained")
    tall = []
    for ax, B, name in zip(axes, (5.0, 2.5), ("base $B$", "base $B/2$")):
        X, e = B / 2, wide / 2
        for at in (0.0, B):
            ax.plot(at, H, "o", color=plot.BLACK)
            for shift in (-e, e):
                end = at + 1.18 * (X + shift - at)
                ax.plot((at, end), (H, H - 1.18 * H), color=plot.BLUE, lw=1.3)
        rise = np.array([H - H * B / (B + wide), H - H * B / (B - wide)])
        diamond = [(X, rise[0]), (X + e, 0), (X, rise[1]), (X - e, 0)]
        ax.add_patch(Polygon(diamond, facecolor=plot.ORANGE, ec=plot.BLACK, zorder=3))
        ax.plot((0, B), (H, H), color=plot.RED, lw=3)
        ax.set(title=name, xlim=(-0.6, 5.6), ylim=(-1.6, H + 0.3), aspect="equal")
        ax.axis("off")
        tall.append(rise[0] - rise[1])
        beside = X + 0.95
        ends: Look = {**BOTH_ENDS, "arrowstyle": "|-|,widthA=0.25,widthB=0.25"}
        ax.annotate("", (beside, rise[0]), (beside, 0), arrowprops=ends)
        words = "a pixel of\nparallax"
        ax.text(beside + 0.2, rise[0] / 2, words, fontsize=15, va="center")
        ax.annotate("", (X - e, 0), (X + e, 0), arrowprops=ends, zorder=4)
        ax.text(X - 0.95, 0, "GSD", fontsize=15, ha="right", va="center")
    plot.show(
        fig,
        "Two rays, each as wide as a pixel on the ground (the GSD), meet in a diamond;"
        " from its middle to its tip is what a pixel of parallax is worth. With half"
        f" the base the diamond is {tall[1] / tall[0]:.1f} times as high.",
    )


def height_errors(error: np.ndarray, sigma: float) -> None:
    """Show measured errors of heights (m) beside the predicted normal curve."""
    sigma = float(sigma)  # it may come in single precision
    far = 6 * sigma
    nmad = 1.4826 * float(np.median(np.abs(error - np.median(error))))
    outside = 100 * float(np.mean(np.abs(error) > far))
    fig, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
    n, edges, _ = ax.hist(
        error, np.linspace(-far, far, 61).tolist(), color=plot.SKY, label="measured"
    )
    x = np.linspace(-far, far, 300)
    width = edges[1] - edges[0]
    bell = np.exp(-((x / sigma) ** 2) / 2) / sigma / np.sqrt(2 * np.pi)
    ax.plot(x, bell * width * len(error), color=plot.BLACK, label="predicted")
    ax.set(xlabel="error of the height (m)", ylabel="points", yticks=[])
    ax.legend(loc="upper left")
    plot.show(
        fig,
        f"Histogram of the errors of {len(error)} heights, NMAD {nmad:.2f} m, with the"
        f" predicted normal curve of standard deviation {sigma:.2f} m. {outside:.1f} %"
        " lie outside the axes.",
        colours=64,
    )


# --- Where is the ground? ---


def terrain(dsm: Surface, dtm: Terrain, land: Landscape) -> None:
    """Show a measured surface and its terrain with contours, and how good they are."""
    rows, columns = dsm.z.shape
    X, Y = np.meshgrid(
        dsm.corner[0] + dsm.cell * np.arange(columns),
        dsm.corner[1] - dsm.cell * np.arange(rows),
    )
    truth, kind = land.at(land.dtm, X, Y), land.at(land.kind, X, Y, 0)
    error = dtm.z - truth
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9), layout="compressed")
    axes[0].imshow(_shaded(dsm.z, dsm.cell), vmin=-0.4, vmax=1)
    axes[0].set_title("surface (DSM)")
    axes[0].set_xlabel(f"contours every {CONTOURS} m", fontsize=14)
    drawn = axes[1].imshow(error, cmap="PuOr", vmin=-0.5, vmax=0.5)
    axes[1].set_title("terrain (DTM), errors")
    crowns = {"colors": plot.BLACK, "linewidths": 0.8, "linestyles": "dotted"}
    axes[1].contour(kind == 2, [0.5], **crowns)
    axes[1].set_xlabel("dotted: crowns of trees", fontsize=14)
    for ax, z in zip(axes, (dsm.z, dtm.z)):
        steps = np.arange(0, 100, CONTOURS)
        ax.contour(z, steps, colors=plot.BLACK, linewidths=1.2)
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    names = ("open", "houses", "trees")
    said = [
        f"{quality(dtm.z, truth, kind == k).rmse:.2f} m {name}"
        for k, name in enumerate(names)
        if np.any(np.isfinite(error[kind == k]))
    ]
    bar = fig.colorbar(drawn, ax=axes.tolist(), location="bottom", aspect=40, pad=0.03)
    words = f"terrain − truth (m): RMSE {', '.join(said)}"
    bar.set_label(words, fontsize=14)
    plot.show(
        fig,
        f"Two maps with contours every {CONTOURS} m. Those of the surface pile up at"
        " houses and at the wood; those of the terrain run smoothly. Its errors, in"
        " colours, are small in the fields and larger among the crowns of trees, whose"
        " outlines are drawn: RMSE"
        f" {', '.join(said)}.",
        colours=96,
    )


def _shaded(z: np.ndarray, cell: float) -> np.ndarray:
    """Light from the upper left on a surface, from 0 to 1; white outside."""
    south, east = np.gradient(z, cell)
    light = (1 + 0.7 * east + 0.7 * south) / np.sqrt(2 * (1 + east**2 + south**2))
    return np.where(np.isfinite(light), np.clip(light, 0, 0.97), 1.0)
