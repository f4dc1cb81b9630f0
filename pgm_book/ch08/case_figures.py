"""Figures of the case of the three locations: six numbers, and what they share."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator

from pgm_book.common import ledger
from pgm_lab import plot
from pgm_lab.plot.basic import Look, grey_levels
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import NormalPair, Surface, Terrain

TILE, HIGH = 31, 19  # px across and down, of what is shown around a mark
REACH = 24  # px to each side, of the row it is looked for in
METHODS = (("interactive", plot.BLUE, "o"), ("automatic", plot.ORANGE, "s"))
HALF_DIGIT = 0.005  # m, of a printed number
Pair = Sequence[float]  # of the interactive and of the automatic method


def six(n: np.ndarray, hand: np.ndarray, machine: np.ndarray) -> None:
    """Show means of both methods (m) at locations of n points, and the differences."""
    at = np.arange(len(n))
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(7, 2.8))
    for (name, colour, mark), values, off in zip(
        METHODS, (hand, machine), (-0.12, 0.12)
    ):
        ax.plot(at + off, values, mark, color=colour, ms=11, label=name)
    ax.set(title="Table 1", ylabel="mean (m)", ylim=(0, 2))
    ax.legend(loc="lower left")
    look: Look = {"fmt": "D", "color": plot.BLACK, "capsize": 7, "ms": 7}
    difference = machine - hand
    beside.errorbar(at, 100 * difference, yerr=200 * HALF_DIGIT, **look)
    share = 2 * hand  # cm: 2 % of the interactive mean
    dash: Look = {"color": plot.RED, "ms": 44, "mew": 3, "label": "2 %"}
    beside.plot(at, share, "_", **dash)
    beside.legend(loc="upper right", markerscale=0.5)
    beside.set(title="automatic − interactive", ylabel="cm", ylim=(0, 6.5))
    for panel in (ax, beside):
        panel.set_xticks(at, [f"{k + 1}\n{int(m)} points" for k, m in enumerate(n)])
        panel.set_xlim(-0.5, len(n) - 0.5)
        panel.tick_params(axis="x", labelsize=13)
    said = (
        f"location {k + 1}: {a:.2f} and {b:.2f} m, difference"
        f" {100 * (b - a):.0f} ± 1 cm"
        for k, (a, b) in enumerate(zip(hand, machine))
    )
    plot.show(
        fig,
        "Left the means of Table 1, right their differences with bars as long as the"
        " rounding of the digits; a stroke at 2 % of each interactive mean meets each"
        f" bar. {'; '.join(said)}.",
        colours=64,
    )


def marks(pair: NormalPair, places: np.ndarray, starts: Sequence[int]) -> None:
    """Show places (column, row) of the left photo, and rows of the right one for them.

    The starts are the disparities (px) at the centre of what is shown of those rows.
    """
    half, high = TILE // 2, HIGH // 2
    parts = []
    for (column, row), start in zip(places, starts):
        rows = slice(row - high, row + high + 1)
        middle = column - start
        columns, rest = slice(column - half, column + half + 1), middle - REACH
        strip = pair.right[rows, rest : middle + REACH + 1]
        parts.append((pair.left[rows, columns], strip, column - rest))
    shape: Look = {"gridspec_kw": {"width_ratios": (TILE, 2 * REACH + 1)}}
    shape |= {"figsize": (7, 0.5 + 1.3 * len(places)), "squeeze": False}
    shape["layout"] = "compressed"
    fig, axes = plt.subplots(len(places), 2, **shape)
    for (left, right), (tile, strip, d), name in zip(axes, parts, "ABCD"):
        left.imshow(grey_levels(tile, "left"), vmin=0, vmax=1)
        left.plot(half, high, "+", color="black", ms=22, mew=5)
        left.plot(half, high, "+", color=plot.YELLOW, ms=20, mew=2)
        left.set(xticks=[], yticks=[], ylabel=name)
        # A column further to the right is a disparity less
        extent = (d + 0.5, d - 2 * REACH - 0.5, HIGH - 0.5, -0.5)
        right.imshow(grey_levels(strip, "right"), vmin=0, vmax=1, extent=extent)
        right.axhline(high, color=plot.YELLOW, lw=1, ls=(0, (2, 6)))
        right.xaxis.set_major_locator(MultipleLocator(10))
        right.xaxis.set_minor_locator(MultipleLocator(2))
        right.set(yticks=[])
        for ax in (left, right):
            ax.grid(False)
    axes[0, 0].set_title("left: the mark")
    axes[0, 1].set_title("right: where is it?")
    axes[-1, 1].set_xlabel("disparity (px)")
    plot.show(
        fig,
        f"{len(places)} points, a row for each: a cross in a part of the left photo,"
        " beside it the same rows of the right photo over a scale of disparities.",
        colours=128,
    )


def gaps(
    land: Landscape, spots: np.ndarray, dsm: Surface, dtm: Terrain, row: int
) -> None:
    """Show an operator's spots (n, 3), and a profile of both methods and the truth."""
    X = dsm.corner[0] + dsm.cell * np.arange(dsm.z.shape[1])
    Y = dsm.corner[1] - dsm.cell * np.arange(dsm.z.shape[0])
    at = np.full_like(X, Y[row])
    fig, (ax, below) = plt.subplots(2, 1, figsize=(10, 4.3), sharex=True)
    seen = land.at(land.grey, *np.meshgrid(X, Y))
    box: Look = {"extent": (X[0], X[-1], Y[-1], Y[0]), "aspect": "auto"}
    ax.imshow(grey_levels(seen, "grey"), **box)
    ax.plot(*spots[:, :2].T, ".", color=plot.YELLOW, ms=7, mec="black", mew=0.6)
    ax.axhline(Y[row], color=plot.RED, lw=1.5)
    ax.grid(False)
    ax.set_ylabel("Y (m)")
    for border, name in zip((X[0], *land.borders), ("open", "mixed", "wood")):
        box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none"}
        ax.text(border + 3, Y[0] - 3, name, va="top", fontsize=15, bbox=box)
    top, ground = land.at(land.dsm, X, at), land.at(land.dtm, X, at)
    below.plot(X, top, color=plot.GREY, lw=1.2, label="true surface")
    below.plot(X, ground, color=plot.BLACK, label="true ground")
    below.plot(X, dsm.z[row], color=plot.RED, lw=1.2, label="automatic, unedited")
    below.plot(X, dtm.z[row], color=plot.ORANGE, lw=1.8, label="automatic, filtered")
    near = np.abs(spots[:, 1] - Y[row]) < 3
    below.plot(*spots[near][:, [0, 2]].T, "o", color=plot.BLUE, ms=6, label="operator")
    below.set(xlabel="X (m)", ylabel="Z (m)", xlim=(X[0], X[-1]))
    below.legend(loc="upper left", ncols=2)
    plot.show(
        fig,
        f"Above the land from above with {len(spots)} points that an operator measured:"
        " evenly in open and mixed ground, in gaps between crowns in the wood. Below a"
        " profile: true surface, true ground, automatic heights, which run over the"
        " crowns before filtering and along the ground after it, and the operator's"
        " points within 3 m.",
        colours=128,
    )


def compared(
    alone: Mapping[str, Pair], common: Mapping[str, Pair], longer: float
) -> None:
    """Show RMSE (m) of both methods by the kind of ground, without and with one error.

    Both ways share it: their base is too long.
    """
    error = f"base {longer:.2f} m too long"
    found = alone, common
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.4), sharey=True)
    for ax, values, title in zip(axes, found, ("orientation right", error)):
        _bars(ax, values)
        ax.set_title(title)
    axes[0].set_ylabel("RMSE (m)")
    axes[0].set_ylim(0, 1.6 * max(max(v) for one in found for v in one.values()))
    axes[0].legend(loc="upper left")
    said = (
        f"{title}: "
        + ", ".join(f"{k} {v[0]:.2f} and {v[1]:.2f} m" for k, v in values.items())
        for title, values in zip(("right", error), found)
    )
    plot.show(
        fig,
        "RMSE of the interactive and the automatic method by kind of ground, left with"
        " the right orientation, right with an error that both share."
        f" {'; '.join(said)}.",
        colours=64,
    )


def _bars(ax: Axes, values: Mapping[str, Pair]) -> None:
    """Two bars for each kind of ground."""
    at = np.arange(len(values))
    for k, ((name, colour, _), off) in enumerate(zip(METHODS, (-0.2, 0.2))):
        heights = [one[k] for one in values.values()]
        look: Look = {"hatch": "//" if k else "", "edgecolor": plot.BLACK}
        bars = ax.bar(at + off, heights, 0.38, color=colour, label=name, **look)
        ax.bar_label(bars, fmt="%.2f", fontsize=14, padding=3, rotation=90)
    ax.set_xticks(at, list(values))
    ax.grid(False, axis="x")


def bowl(at: np.ndarray, dz: np.ndarray, py: np.ndarray) -> None:
    """Show errors of height (m) at places of a model, beside its y parallaxes (px)."""
    fig, (ax, beside) = plt.subplots(1, 2, figsize=(7, 3.5))
    most = np.abs(dz).max()
    look: Look = {"cmap": "PuOr", "vmin": -most, "vmax": most, "marker": "s"}
    shown = ax.scatter(*at.T, c=dz, s=70, **look)
    fig.colorbar(shown, ax=ax, label="error of height (m)", shrink=0.9)
    ax.set(xlabel="X (m)", ylabel="Y (m)", aspect="equal")
    ax.grid(False)
    beside.hist(py, bins=np.linspace(-1, 1, 41).tolist(), color=plot.BLUE)
    beside.set(xlabel="y parallax (px)", ylabel="points", xlim=(-1, 1))
    plot.show(
        fig,
        f"Left errors of height over the model, a bowl from {dz.min():.1f} to"
        f" {dz.max():.1f} m. Right a histogram of y parallaxes from -1 to 1 px: none is"
        f" larger than {np.abs(py).max():.2f} px.",
        colours=64,
    )


# --- What was computed from which of the printed figures of Harintaka 2020 ---

# x, y, what is printed, what we compute, and chapter and place of its verdict
BOXES: dict[str, tuple[float, float, str, str, tuple[str, str] | None]] = {
    "flight": (1.4, 4.7, "24 mm, 1000 m", "", None),
    "table": (1.4, 1.2, "Table 1\nsix means", "", None),
    "scale": (
        5.0, 5.3, "H/f about 40,000", "41,667", ("1", "Hasil dan Pembahasan, H/f")
    ),
    "gsd": (5.0, 4.2, "GSD 20 cm", "22.9 cm", ("1", "Metode, GSD")),
    "tie": (
        5.0, 3.0, "tie points 15 mm, 40 mm", "0.07 px, 0.05 or 0.07 px",
        ("8", "Metode, tie points"),
    ),
    "text": (
        5.0, 1.35, "vertical 1.7 m", "1.50 m, 1.53 m",
        ("8", "Hasil dan Pembahasan, vertical"),
    ),
    "where": (
        5.0, 0.3, "differ mainly at location 2", "within the rounding",
        ("8", "Hasil dan Pembahasan, difference by location"),
    ),
    "pixels": (
        8.7, 3.1, "1.34 to 1.75 m", "1.5 to 3.0 px", ("8", "Table 1, in pixels")
    ),
    "horizontal": (
        8.7, 1.5, "horizontal 1.5 m", "", ("8", "Hasil dan Pembahasan, horizontal")
    ),
    "points": (
        8.7, 0.3, "35 and 175 points", "", ("8", "Metode and Table 1, points")
    ),
    "map": (
        8.7, 5.0, "1:5,000, contours 2.5 m", "0.5 mm in the map",
        ("8", "Hasil dan Pembahasan, contour interval"),
    ),
}  # fmt: skip
ARROWS = (
    ("flight", "scale"),
    ("flight", "gsd"),
    ("gsd", "tie"),
    ("gsd", "pixels"),
    ("table", "pixels"),
    ("table", "text"),
    ("table", "where"),
)


def follows() -> None:
    """Draw printed figures with their verdicts, and what was computed from which."""
    fig, ax = plt.subplots(figsize=(10, 4.3))
    drawn, told = {}, {name: list[str]() for name in (*ledger.VERDICTS, "given")}
    for name, (x, y, printed, computed, row) in BOXES.items():
        fate = ledger.verdicts(row[0], [row[1]])[0]["verdict"] if row else "given"
        box: Look = {"boxstyle": "round,pad=0.35", "facecolor": "white"}
        box |= {"edgecolor": _colour(fate), "linewidth": 3}
        text = f"{printed}\n→ {computed}" if computed else printed
        centre: Look = {"ha": "center", "va": "center", "fontsize": 13.5}
        drawn[name] = ax.text(x, y, text, bbox=box, **centre).get_bbox_patch()
        told[fate].append(text.replace("\n", " "))
    for first, second in ARROWS:
        look: Look = {"arrowstyle": "-|>", "color": plot.GREY, "lw": 1.8}
        look |= {"patchA": drawn[first], "patchB": drawn[second], "mutation_scale": 18}
        ends = BOXES[second][:2], BOXES[first][:2]
        ax.annotate("", *ends, arrowprops=look, zorder=0)
    for fate in told:
        ax.plot([], [], color=_colour(fate), lw=3, label=fate)
    ax.plot([], [], color=plot.GREY, lw=1.8, marker=">", label="gives what is after →")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5, handlelength=1.6)
    ax.set(xlim=(0.1, 10.5), ylim=(-0.2, 5.8))
    ax.axis("off")
    plot.show(
        fig,
        "Printed figures in boxes with the colours of their verdicts, after → what we"
        " compute; arrows come from what it was computed from. "
        + " ".join(f"{fate}: {'; '.join(texts)}." for fate, texts in told.items()),
        colours=64,
    )


def _colour(fate: str) -> str:
    """Colour of a verdict, as in the ledger; black for what is given."""
    return ledger.VERDICTS[fate][0] if fate in ledger.VERDICTS else plot.BLACK
