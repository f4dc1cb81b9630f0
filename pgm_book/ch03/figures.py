"""Figures of least squares matching: its film, its pull-in range, its precision."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pgm_book.common import results
from pgm_book.program.lsm import match
from pgm_lab import lsm, plot, simulate
from pgm_lab.image import resample
from pgm_lab.plot.basic import Look, interact

METHODS = {
    "bilinear": ("bilinear", plot.ORANGE, "-"),
    "cubic": ("cubic, a = −0.5", plot.SKY, "-."),
    "OpenCV cubic": ("cubic, a = −0.75", plot.RED, "--"),
    "spline3": ("cubic spline", plot.BLUE, "-"),
    "lsm": ("spline, doubled grid", plot.BLACK, ":"),
}


def iteration_film(
    left: np.ndarray,
    right: np.ndarray,
    point: np.ndarray,
    size: int,
    trail: np.ndarray,
    truth: np.ndarray,
) -> None:
    """Show at most six iterations of a match as a film, with their error in pixels."""
    trail = np.asarray(trail)
    chosen = sorted({*range(min(5, len(trail))), len(trail) - 1})
    _film(left, right, point, size, trail, truth, chosen)


def _film(
    left: np.ndarray,
    right: np.ndarray,
    point: np.ndarray,
    size: int,
    trail: np.ndarray,
    truth: np.ndarray,
    chosen: list[int],
) -> None:
    """Show the chosen steps of a trail."""
    off = np.hypot(*(trail[chosen][:, [0, 3]] - truth).T)
    notes = [
        f"{f'step {k}' if k else 'start'}\n{e:.{1 if e > 0.3 else 3}f} px off"
        for k, e in zip(chosen, off)
    ]
    fig = film_strip(left, right, point, size, trail[chosen], notes)
    plot.show(
        fig,
        "Iterations as a film: the window in the right photo moves and rotates, its"
        " grey values become those of the template, and the residuals become noise."
        f" Pixels from the truth: {', '.join(f'{e:.3f}' for e in off)}.",
        dpi=142,
    )


def film_strip(
    left: np.ndarray,
    right: np.ndarray,
    point: np.ndarray,
    window: int,
    trail: np.ndarray,
    notes: Sequence[str],
) -> Figure:
    """Draw the iterations of least squares matching as a film, a column for each.

    Above the window in the photos, in the middle its grey values, those of the right
    photo brought to the left one by (B 2.7), and below the residuals. `trail` (k, 8)
    has the parameters of k iterations, `notes` stand above the columns.
    """
    half = window // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1]
    here = np.stack([point[0] + x, point[1] + y], axis=-1)
    template = resample(left, here, "nearest")
    grey = {
        "cmap": "gray",
        "interpolation": "nearest",
        "vmin": template.min(),
        "vmax": template.max(),
    }
    reach = np.abs(template - template.mean()).max() / 2
    signed = {"cmap": "PuOr", "interpolation": "nearest", "vmin": -reach, "vmax": reach}

    fig, axes = plt.subplots(3, len(trail) + 1, figsize=(12, 5.7))
    identity = np.array([point[0], 1, 0, point[1], 0, 1, 0, 1.0])
    _film_photo(axes[0, 0], left, identity[None], identity[[0, 3]], half, grey)
    axes[1, 0].imshow(template, **grey)
    axes[0, 0].set_title("left photo", fontsize=18, loc="center")
    for step, (p, note) in enumerate(zip(trail, notes, strict=True), start=1):
        above, middle, below = axes[:, step]
        _film_photo(above, right, trail[:step], trail[-1, [0, 3]], half, grey)
        above.set_title(note, fontsize=18, loc="center")
        found = p[6] + p[7] * resample(right, _at(p, x, y), "spline3", np.nan)
        middle.imshow(found, **grey)
        residuals = below.imshow(found - template, **signed)
    for ax in axes.flat:
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
        ax.spines[:].set_visible(False)
    axes[1, 0].set_xlabel("template A", fontsize=18)
    names = ("right photo", "$h_0 + h_1 B$", "residuals")
    for ax, name in zip(axes[:, 1], names, strict=True):
        ax.set_ylabel(name, fontsize=18)
    scale = axes[2, 0].inset_axes((0.0, 0.35, 0.9, 0.14))
    bar = fig.colorbar(residuals, cax=scale, orientation="horizontal")
    bar.set_label("grey values", fontsize=18)
    bar.ax.tick_params(labelsize=18)
    return fig


def _at(p: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where (B 2.8) and (B 2.9) take the pixels of the window, in the last axis."""
    return np.stack([p[0] + p[1] * x + p[2] * y, p[3] + p[4] * x + p[5] * y], axis=-1)


def _film_photo(
    ax: Axes,
    photo: np.ndarray,
    trail: np.ndarray,
    centre: np.ndarray,
    half: int,
    grey: Look,
) -> None:
    """Show a photo around `centre`, the last window of the trail, and its middles."""
    edge = half + 0.5
    x, y = edge * np.array([(-1, 1, 1, -1, -1), (-1, -1, 1, 1, -1)])
    ax.imshow(photo, **grey)
    ax.plot(*_at(trail[-1], x, y).T, color=plot.ORANGE, linewidth=2.4)
    look: Look = {"color": plot.RED, "markersize": 6, "linewidth": 1.4}
    ax.plot(*trail[:, [0, 3]].T, ".-", **look)
    view = 1.75 * edge
    ax.set(xlim=(centre[0] - view, centre[0] + view))
    ax.set(ylim=(centre[1] + view, centre[1] - view))


def shift_by_hand(
    left: np.ndarray, right: np.ndarray, point: np.ndarray, size: int, truth: np.ndarray
) -> None:
    """Show the film of a match, with sliders for its start."""
    import ipywidgets

    def draw(columns: int, rows: int, turn: int) -> None:
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        x, y = np.round(truth) + (columns, rows)
        start = [x, c, -s, y, s, c, 0, 1]
        try:
            trail = match(left, right, point, start, size)[0]
        except ValueError as reason:
            print(f"lost: {reason}")
        else:
            last = len(trail) - 1
            chosen = sorted({0, (last + 1) // 2, last})
            _film(left, right, point, size, trail, truth, chosen)

    look: Look = {"continuous_update": False}
    interact(
        draw,
        columns=ipywidgets.IntSlider(
            -4, min=-9, max=9, description="columns (px)", **look
        ),
        rows=ipywidgets.IntSlider(-4, min=-9, max=9, description="rows (px)", **look),
        turn=ipywidgets.IntSlider(
            0, min=-30, max=30, description="rotation (°)", **look
        ),
    )


def interpolation() -> None:
    """Show how far each interpolation moves a texture, by the position between pixels.

    A match is off by about as much, in the opposite direction.
    """
    rows = results.rows("ch03", "interpolation_bias")
    panels: Look = {"sharey": True, "layout": "constrained"}
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.5), **panels)
    for ax, kind, finest in zip(axes, ("soft", "sharp"), (5, 2.5)):
        for method, (label, colour, line) in METHODS.items():
            some = [r for r in rows if (r["texture"], r["method"]) == (kind, method)]
            at, bias = np.array(
                [(float(r["position"]), 1000 * float(r["bias_px"])) for r in some]
            ).T
            ax.plot(at, bias, line, color=colour, label=label, lw=3)
        ax.set(xlabel="position between two\npixels (px)", xticks=(0, 0.5, 1))
        ax.set_title(f"{kind}: waves\nfrom {finest:g} px", fontsize=15)
    axes[0].set_ylabel("shifted too far by\n(0.001 px)")
    handles = axes[0].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2, fontsize=15)
    plot.show(
        fig,
        "Shift of a texture by interpolation against the place between two pixels. On"
        " soft texture OpenCV's cubic reaches 32 thousandths of a pixel, cubic"
        " convolution and bilinear 12 to 13, the splines less than 1. On sharp"
        " texture bilinear and cubic convolution reach 44 to 54, OpenCV's cubic 22,"
        " the cubic spline 17; on a doubled grid the cubic spline stays below 1.",
    )


def half_wave() -> None:
    """Draw a wave matched from too near and from too far, and the sum of squares."""
    x, period = np.linspace(-8, 8, 401), 8.0

    def wave(shift: float) -> np.ndarray:
        return np.sin(2 * np.pi * (x - np.asarray(shift)) / period)

    shifts = np.linspace(-9, 9, 181)
    squares = np.array([np.mean((wave(s) - wave(0)) ** 2) for s in shifts])
    fig, axes = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
    axes[0].plot(x, wave(0), color=plot.BLUE, label="A, the template")
    axes[0].plot(x, wave(2.5), "--", color=plot.GREEN, label="B, 2.5 px off")
    axes[0].plot(x, wave(6), ":", color=plot.RED, lw=3, label="B, 6 px off")
    axes[0].set(xlabel="x (px)", ylabel="grey value", yticks=[], ylim=(-1.2, 2.6))
    axes[0].legend(loc="upper center", fontsize=16)
    axes[1].plot(shifts, squares, color=plot.BLACK)
    for begin, end, colour in ((2.5, 0.4, plot.GREEN), (6.0, 7.7, plot.RED)):
        level = float(np.interp(begin, shifts, squares))
        axes[1].plot(begin, level, "o", color=colour, ms=13)
        after = float(np.interp(end, shifts, squares))
        arrow = {"arrowstyle": "-|>", "color": colour, "lw": 3}
        axes[1].annotate(
            "", (end, after + 0.06), (begin, level + 0.06), arrowprops=arrow
        )
    for crest in (-4, 4):
        axes[1].axvline(crest, color=plot.GREY, ls="--", lw=2)
    axes[1].text(4.15, 2.12, "half a wave", color=plot.BLACK, fontsize=16)
    for ax in axes:
        ax.tick_params(labelsize=17)
    axes[1].set(xlabel="shift of B (px)", ylabel="mean square of A − B", ylim=(0, 2.3))
    plot.show(
        fig,
        "Left, a wave of 8 pixels and the same wave 2.5 and 6 pixels off. Right, the"
        " mean square of their difference against the shift: valleys at 0 and 8"
        " pixels, a crest between them at 4. From 2.5 pixels the curve falls towards 0,"
        " from 6 pixels towards 8, the wrong valley.",
    )


def pull_in() -> None:
    """Show the share of matches that converge, against the distance of their start."""
    rows = results.rows("ch03", "pull_in")
    fig, ax = plt.subplots(figsize=(7, 3.3), layout="constrained")
    for kind, colour in (("soft", plot.BLUE), ("sharp", plot.RED)):
        for size, line in (("11", ":"), ("21", "-")):
            some = [r for r in rows if (r["texture"], r["window"]) == (kind, size)]
            off, share = np.array(
                [(float(r["start_error_px"]), float(r["arrived"])) for r in some]
            ).T
            label = f"{kind} texture, window {size}"
            ax.plot(off, 100 * share, line, color=colour, lw=3, label=label)
    ax.set(xlabel="distance of the start from the truth (px)", ylabel="converged (%)")
    ax.set_title("Matches of lsm.match")
    ax.set_ylim(bottom=0)
    ax.legend(loc="lower left", fontsize=14)
    plot.show(
        fig,
        "Share of points that converge to the truth against the distance of the start."
        " With a window of 21 pixels nearly all do from 4 pixels, on soft and on sharp"
        " texture;"
        " with 11 nearly all from 2, and a third from 4.",
    )


def real_error() -> None:
    """Show the error of matches on a real photo, and what they predicted."""
    wanted = {"factor": "4", "shift_x": "0.25", "shift_y": "0.25", "window": "21"}
    (row,) = [
        row
        for row in results.rows("ch03", "real")
        if wanted.items() <= row.items() and row["tolerance"] == "0.02"
    ]
    error, predicted = float(row["rms"]), float(row["median_predicted_sd"])
    fig, ax = plt.subplots(figsize=(7, 1.7), layout="constrained")
    bars = ax.barh(
        ("predicted", "error"), (predicted, error), color=(plot.BLUE, plot.RED)
    )
    ax.bar_label(bars, fmt=" %.3f px", fontsize=14)
    ax.set(xlabel="RMS in a column or a row (px)", xlim=(0, 0.062))
    plot.show(
        fig,
        f"Error of matches on a real photo, {error:.3f} px, and below it the standard"
        f" deviation that they predicted, {predicted:.3f} px.",
    )


def cloud(
    place: tuple[int, int], exact: Sequence[np.ndarray], affine: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors of 400 matches of one window with new noise each, and their covariance."""
    tiles = 22.0 + 45 * np.stack(np.meshgrid(np.arange(20), np.arange(20)), -1)
    tiles = tiles.reshape(-1, 2)  # the centres of 400 windows, side by side
    there = affine @ np.array([*place, 1])
    photos = []
    for k, (grey, at) in enumerate(zip(exact, (np.array(place), there))):
        column, row = np.rint(at).astype(int) - 22
        part = grey[row : row + 45, column : column + 45]
        photos.append(simulate.photograph(np.tile(part, (20, 20)), 1.5, [8, k]))
    found = lsm.match(photos[0], photos[1], tiles, tiles)
    errors = found.points - tiles - (there - np.rint(there))
    return errors[found.accepted], np.median(found.covariance[found.accepted], axis=0)


def ellipses(
    left: np.ndarray,
    places: Mapping[str, np.ndarray],
    clouds: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> None:
    """Show windows, and below each the errors of its matches with their ellipse."""
    panels: Look = {"layout": "constrained", "height_ratios": (1, 1.5)}
    fig, axes = plt.subplots(2, len(places), figsize=(7, 4.2), squeeze=False, **panels)
    for (above, below), (name, place) in zip(axes.T, places.items()):
        column, row = place
        errors, C = clouds[name]
        below.plot(*(100 * errors).T, ".", color=plot.SKY, ms=4)
        plot.error_ellipse(below, (0, 0), 1e4 * C, zorder=3, linewidth=3)
        above.imshow(left, cmap="gray", vmin=0, vmax=230, interpolation="nearest")
        x, y = np.array([(-1, 1, 1, -1, -1), (-1, -1, 1, 1, -1)]) * 10.5
        above.plot(column + x, row + y, color=plot.ORANGE, lw=3)
        above.set(xlim=(column - 22, column + 22), xticks=[], yticks=[])
        above.set_ylim(row + 16, row - 16)
        above.set_title(name, fontsize=14)
        above.grid(False)
        look = {"aspect": "equal", "xlim": (-12, 12), "xticks": (-10, 0, 10)}
        below.set(ylim=(10, -10), xlabel="columns\n(0.01 px)", **look)
    axes[1, 0].set_ylabel("rows (0.01 px)")
    plot.show(
        fig,
        "Windows of the photo, and below each the errors of many matches with the 95"
        " % ellipse of the predicted covariance: small and round among crowns and"
        " shadows, long along the edge of a crown, large in the meadow.",
    )


# --- Windows that are matched by least squares: one slope, eight unknowns ---

GREY: Look = {"cmap": "gray", "vmin": 0, "vmax": 230, "interpolation": "nearest"}
# What is added to each of a0, a1, a2, h0, b0, b1, b2, h1 in the sketch
STEPS = {0: 9.0, 1: 0.35, 2: 0.35, 6: 45.0, 3: 9.0, 4: 0.35, 5: 0.35, 7: -0.5}
NAMES = ("$a_0$", "$a_1$", "$a_2$", "$b_0$", "$b_1$", "$b_2$", "$h_0$", "$h_1$")


def window_pair(
    left: np.ndarray,
    right: np.ndarray,
    point: np.ndarray,
    affine: np.ndarray,
    window: int,
) -> None:
    """Show a window in the left photo, and where it lies in the right one."""
    x, y = window / 2 * _SQUARE + np.reshape(point, (2, 1))
    outlines = [(x, y), affine @ (x, y, np.ones(5))]
    panels: Look = {"sharex": True, "sharey": True, "layout": "constrained"}
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.3), **panels)
    for ax, photo, (u, v), name in zip(
        axes, (left, right), outlines, ("left", "right")
    ):
        ax.imshow(photo, **GREY)
        ax.plot(u, v, color=plot.ORANGE, linewidth=3)
        middle = u[:4].mean(), v[:4].mean()
        ax.plot(*middle, "+", color=plot.RED, ms=18, mew=3)
        ax.set(title=f"{name} photo", xlabel="column (px)", xlim=(40, 220))
        ax.set_ylim(200, 20)
        ax.tick_params(labelsize=17)
        ax.grid(False)
    axes[0].set_ylabel("row (px)")
    plot.show(
        fig,
        "Two aerial photos of a meadow with trees. A square window around a point of"
        " the left photo appears in the right one rotated by some degrees, a little"
        " larger, and with less contrast.",
    )


_SQUARE = np.array([(-1, 1, 1, -1, -1), (-1, -1, 1, 1, -1)])


def window_slope(A: np.ndarray, B: np.ndarray, place: int) -> None:
    """Draw two rows of grey values, and the triangle of slope and step of one pixel."""
    at = np.arange(len(A)) - len(A) // 2
    gradient = (B[place + 1] - B[place - 1]) / 2
    step = (A[place] - B[place]) / gradient
    fig, (ax, near) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    for panel in (ax, near):
        panel.plot(at, A, "o-", color=plot.BLUE, label="A, left window")
        panel.plot(at, B, "s--", color=plot.ORANGE, label="B, right window")
        panel.set(xlabel="x (px from the centre)")
    ax.set_ylabel("grey value")
    ax.set_ylim(top=ax.get_ylim()[1] + 25)
    ax.legend(loc="upper right")
    x0, low, high = at[place], B[place], A[place]
    ends = np.array([-0.6, max(step, 0) + 0.6])
    near.plot(x0 + ends, low + gradient * ends, color=plot.BLACK, lw=2)
    near.plot([x0, x0], [low, high], color=plot.RED, lw=4)
    near.plot([x0, x0 + step], [high, high], color=plot.GREEN, lw=4)
    look: Look = {"fontsize": 15, "textcoords": "offset points"}
    middle, mid = (low + high) / 2, x0 + step / 2
    near.annotate("A − B", (x0, middle), (-118, 12), color=plot.RED, **look)
    near.annotate("(A − B) / slope", (mid, high), (24, -30), color=plot.GREEN, **look)
    foot = (x0 - 0.45, low - 0.45 * gradient)
    near.annotate("tangent of B", foot, (14, -12), color=plot.BLACK, **look)
    reach = 1.3 * abs(high - low) + 8
    near.set(xlim=(x0 - 1.3, x0 + 1.9), ylim=(middle - reach, middle + reach))
    near.set_xticks([x0 - 1, x0, x0 + 1])
    near.set_title("one pixel, enlarged")
    plot.show(
        fig,
        "Left, two rows of grey values, the second one like the first but displaced"
        " by less than a pixel. Right, one pixel of them enlarged: the difference A"
        " minus B is vertical, the tangent of B rises beside it, and the horizontal"
        " distance from the pixel to the tangent is the difference divided by the"
        " slope.",
    )


def eight_parameters(photo: np.ndarray, point: np.ndarray) -> None:
    """Draw what each of the eight parameters does to a window."""
    (column, row), half = point, 20
    x, y = (half + 0.5) * _SQUARE
    fig, axes = plt.subplots(2, 4, figsize=(10, 4.8), layout="constrained")
    for ax, (k, step) in zip(axes.flat, STEPS.items()):
        p = np.array([0, 1, 0, 0, 0, 1, 0, 1.0])
        p[k] += step
        shown = np.array(photo, float)
        inside = np.s_[row - half : row + half + 1, column - half : column + half + 1]
        shown[inside] = p[6] + p[7] * shown[inside] + (60 if k == 7 else 0)
        ax.imshow(shown, **GREY)
        ax.plot(column + x, row + y, "--", color="white", lw=2)
        moved = p[0] + p[1] * x + p[2] * y, p[3] + p[4] * x + p[5] * y
        ax.plot(column + moved[0], row + moved[1], color=plot.ORANGE, lw=3)
        reach = 1.75 * half
        ax.set(xlim=(column - reach, column + reach), xticks=[], yticks=[])
        ax.set_ylim(row + reach, row - reach)
        sign = "−" if step < 0 else "+"
        unit = " px" if k in (0, 3) else ""
        title = f"{NAMES[k]} {sign} {abs(step):g}{unit}"
        ax.set_title(title + (", $h_0$ + 60" if k == 7 else ""), fontsize=15)
        ax.grid(False)
    fig.supxlabel("dashed: unchanged, orange: one parameter changed", fontsize=16)
    plot.show(
        fig,
        "Eight small photos with a dashed window, and in orange what one changed"
        " parameter makes of it: a0 and b0 shift it, a1 and b2 stretch it along columns"
        " and rows, a2 and b1 shear it, h0 makes it brighter and h1, here with 60"
        " added, changes its contrast.",
    )
