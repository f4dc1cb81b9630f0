"""Figures of the case of a validation of 2010: readings of one table, and their fit."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np

from pgm_lab import plot
from pgm_lab.plot.basic import Look

PIXEL = 12.19  # um
FORMAT = (23.6, 15.8)  # mm
MARKED = {0: ("o", plot.BLUE), 1: ("s", plot.RED), 4: ("D", plot.PURPLE)}
MARKED |= {9: ("^", plot.ORANGE)}
LARGER = 40  # times, residuals
PUBLISHED = 3  # the step after which the values were published


def heights(z: np.ndarray) -> None:
    """Show the heights (steps + 1, 10) of ten points before and after each step."""
    fig, ax = plt.subplots(figsize=(7, 3.9))
    for i in range(10):
        if i not in MARKED:
            label = "six others" if i == 2 else None
            ax.plot(z[:, i], "-", color=plot.GREY, linewidth=1.4, label=label)
    for i, (mark, colour) in MARKED.items():
        ax.plot(z[:, i], f"{mark}-", color=colour, label=f"point {i + 1}")
    ax.set(yscale="symlog", ylim=(-1e5, 1e3), xticks=range(len(z)), xlabel="steps made")
    ax.set(ylabel="Z (unit not printed,\nlog scale)")
    ax.axvline(PUBLISHED, color=plot.BLACK, linewidth=1.2, linestyle="--")
    ax.text(PUBLISHED - 0.05, -2.5e4, "published", fontsize=14, ha="right")
    fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    plot.show(
        fig,
        "Height Z of the ten points after each step. Seven converge, point 1 near -4.5."
        " Three diverge: point 2 over -3, -7, -18 and -62 to -408, point 5 far beyond"
        " the frame, point 10 upwards to 214. The published values are those after"
        f" {PUBLISHED} steps.",
    )


def residuals(photos: np.ndarray, v: np.ndarray) -> None:
    """Show residuals (2, n, 2) of both photos in mm as arrows, enlarged."""
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.4), sharey=True)
    look: Look = {"angles": "xy", "scale_units": "xy", "scale": 1 / LARGER}
    look |= {"width": 0.012, "color": plot.RED, "zorder": 3}
    width, height = FORMAT
    for ax, name, xy, r in zip(axes, ("left photo", "right photo"), photos, v):
        frame = plt.Rectangle((-width / 2, -height / 2), width, height, fc="#EEF3F7")
        ax.add_patch(frame)
        ax.plot(*xy.T, "o", color=plot.BLACK, markersize=4)
        ax.quiver(*xy.T, *r.T, **look)
        ax.set(title=name, xlabel="x (mm)", aspect="equal")
        ax.set(xlim=(-12.2, 12.2), ylim=(-8.3, 8.3))
    axes[0].set_ylabel("y (mm)")
    axes[0].quiver(-10.5, -6.8, 0.1, 0, **look)
    axes[0].text(-11, -6, f"100 µm = {100 / PIXEL:.1f} px", fontsize=13)
    plot.show(
        fig,
        f"Both photos with {photos.shape[1]} points and their residuals, drawn"
        f" {LARGER} times too large beside a bar of 100 micrometres. In each photo all"
        " arrows lie nearly parallel, across the base. Their length and sign change"
        " smoothly over the photo: in the right one to the right on the upper left, to"
        f" the left on the lower right, up to {1000 * np.abs(v).max():.0f} micrometres"
        " in a coordinate.",
    )


def ladder(sigma0: Mapping[str, float]) -> None:
    """Show sigma0 (mm) of each reading of the same data, the published one first."""
    names, sizes = list(sigma0), 1000 * np.array(list(sigma0.values()))
    fig, ax = plt.subplots(figsize=(10, 0.9 + 0.36 * len(names)))
    colours = [plot.RED] + [
        plot.GREY if s > 500 else plot.BLUE if s > 10 else plot.GREEN for s in sizes[1:]
    ]
    rows = np.arange(len(names))[::-1]
    hatches = ["//"] + ["" if s > 10 else ".." for s in sizes[1:]]
    ax.barh(rows, sizes, color=colours, hatch=hatches, edgecolor="white")
    ax.set_yticks(rows, names, fontsize=15)
    ax.tick_params(axis="x", labelsize=15)
    for row, size in zip(rows, sizes):
        text = f"{size:.0f} µm" if size > 20 else f"{size:.3g} µm"
        ax.text(1.15 * size, row, text, va="center", fontsize=15)
    ax.axvline(PIXEL, color=plot.BLACK, linestyle="--", linewidth=1.5)
    ax.text(1.1 * PIXEL, -0.75, "one pixel", fontsize=15)
    ax.set(xscale="log", xlim=(0.2, 5e4), ylim=(-1, len(names) - 0.4))
    ax.set_xlabel("sigma0 (µm)")
    ax.grid(axis="y", visible=False)
    said = ", ".join(f"{name}: {size:.3g}" for name, size in zip(names, sizes))
    plot.show(
        fig,
        f"Sigma0 in micrometres of {len(names)} readings of the same data, on a log"
        f" scale. {said}. One pixel is 12.19.",
    )


def misprints(deviation: np.ndarray, names: Sequence[str]) -> None:
    """Show relative deviations of printed coefficients from differences, log scale."""
    size = np.maximum(np.abs(deviation), 1e-12)
    fig, ax = plt.subplots(figsize=(7, 3.6))
    wrong = size > 1e-6
    labels = [f"$b_{{{name[1:]}}}$" for name in names]
    for those, colour, hatch, word in (
        (~wrong, plot.BLUE, "", "agree"),
        (wrong, plot.RED, "//", "do not"),
    ):
        look: Look = {"color": colour, "hatch": hatch, "edgecolor": "white"}
        at = np.flatnonzero(those)
        ax.bar(at, size[at], bottom=1e-13, label=word, **look)
    ax.set_xticks(range(len(names)), labels, fontsize=14)
    ax.set(yscale="log", ylim=(1e-12, 1e3))
    ax.set_ylabel("relative deviation")
    ax.legend(loc="upper left", ncols=2)
    ax.grid(axis="x", visible=False)
    worst = [name for name, bad in zip(names, wrong) if bad]
    plot.show(
        fig,
        f"Relative deviation of {len(names)} printed coefficients from central"
        f" differences, on a log scale: {len(names) - len(worst)} agree to some nine"
        f" digits, {', '.join(worst) or 'none'} deviate by more than a half.",
    )
