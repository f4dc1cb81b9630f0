"""Figures of the case of the twenty-five numbers: formulas and searches checked."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np

from pgm_book.ch02.figures import draw_map
from pgm_book.common.figures import outline
from pgm_lab import plot
from pgm_lab.plot.basic import Look

SCENES = {  # colour, mark and line, name
    "stereo pair": (plot.RED, "s-", "motorcycle"),
    "orthophoto": (plot.GREEN, "o--", "orthophoto"),
    "texture": (plot.BLUE, "^:", "texture on a slope"),
}


def two_maps(scene: np.ndarray, quick: np.ndarray, exact: np.ndarray) -> None:
    """Show a faint scene, and its maps of r computed in two ways."""
    fig, axes = plt.subplots(1, 3, figsize=(7, 2.6))
    axes[0].imshow(scene)
    outline(axes[0], np.array(scene.shape[::-1]) // 2, 21, plot.ORANGE)
    for ax, r in zip(axes[1:], (quick, exact)):
        drawn = draw_map(ax, r)
    for ax, title in zip(axes, ("scene", "32 bit", "mean first")):
        ax.set_title(title)
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    fig.colorbar(drawn, ax=axes, label="r", orientation="horizontal", aspect=40)
    plot.show(
        fig,
        "A hazy satellite scene with a template in its middle; the map of r in 32 bit,"
        " a random speckle; and the map with the mean subtracted first, one summit.",
        colours=128,
    )


def before_and_after(r: Mapping[str, np.ndarray]) -> None:
    """Show how often each r occurs, before and after a change of the photos."""
    fig, ax = plt.subplots(figsize=(7, 2.9))
    looks = ((plot.BLUE, "-"), (plot.RED, "--"))
    said = []
    for (name, values), (colour, line) in zip(r.items(), looks):
        style: Look = {"bins": np.linspace(-0.2, 1, 49), "histtype": "step"}
        ax.hist(values, color=colour, linestyle=line, lw=3, label=name, **style)
        said.append(f"{name}: median {np.median(values):.2f}")
    ax.set(xlabel="r at the true place", ylabel="points")
    ax.legend(loc="upper left")
    plot.show(
        fig,
        "Histograms of r at the true place, a peak near 1 and a long tail to the left;"
        f" the two nearly coincide. {'; '.join(said)}.",
    )


def study(
    widths: np.ndarray,
    shares: Mapping[str, np.ndarray],
    rms: Mapping[str, np.ndarray],
) -> None:
    """Show the share of right matches and their precision against the template."""
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9))
    said = []
    for scene, values in shares.items():
        colour, mark, name = SCENES[scene]
        share = 100 * np.asarray(values)
        axes[0].plot(widths, share, mark, color=colour, label=name)
        axes[1].plot(widths, rms[scene], mark, color=colour)
        said.append(f"{name} {share.max():.0f} % at most, {share[-1]:.0f} % at last")
    axes[0].set(title="right within 1 px (%)", ylim=(0, 104))
    axes[1].set(title="RMS error (px)", ylim=(0, 0.36))
    plt.setp(axes, xlabel="template (px)", xticks=(5, 15, 21, 31, 41))
    handles = axes[0].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=3)
    plot.show(
        fig,
        "Share of right matches and their RMS error against the width of the template,"
        f" 5 to 41 px. Right: {'; '.join(said)}. The error of the motorcycle grows from"
        f" {min(rms['stereo pair']):.2f} to {max(rms['stereo pair']):.2f} px, that of"
        f" the orthophoto falls to {rms['orthophoto'][-1]:.2f}.",
    )


def reach(start: np.ndarray, match: np.ndarray, windows: Mapping[str, int]) -> None:
    """Show search windows around a start to scale, and the match that was printed."""
    fig, ax = plt.subplots(figsize=(7, 3.4))
    looks = ((plot.RED, "-"), (plot.ORANGE, "--"), (plot.BLUE, ":"))
    for (name, width), (colour, line) in zip(windows.items(), looks):
        label = f"{name}:\n{width} px"
        outline(ax, start, width, colour, label=label, linestyle=line, linewidth=3)
    outline(ax, match, 19, plot.GREEN, label="the match:\n19 px", linewidth=2)
    ax.plot(*start, "+", color=plot.BLACK, markersize=14, label="start")
    arrow: Look = {"arrowstyle": "->", "linewidth": 1.8}
    ax.annotate("", tuple(match), tuple(start), arrowprops=arrow)
    far = max(windows.values()) / 2 + 8
    ax.set(xlim=(start[0] - far, start[0] + far), aspect="equal")
    ax.set(ylim=(start[1] + far, start[1] - far))
    ax.set(xlabel="column (px)", ylabel="row (px)")
    fig.legend(loc="outside right center")
    dx, dy = match - start
    plot.show(
        fig,
        f"To scale: search windows of {', '.join(map(str, windows.values()))} px around"
        f" the start, and the match at ({dx:.0f}, {dy:.0f}) px from it; only the last"
        " window holds it.",
    )


def locking(shifts: np.ndarray, errors: Mapping[str, np.ndarray]) -> None:
    """Show the mean error of matches against the true fraction of a pixel."""
    fig, ax = plt.subplots(figsize=(7, 2.5))
    looks = (("o-", plot.BLUE), ("s--", plot.RED), ("D:", plot.GREEN))
    said = []
    for (name, values), (mark, colour) in zip(errors.items(), looks):
        ax.plot(shifts, values, mark, color=colour, label=name)
        said.append(f"{name} at most {np.abs(values).max():.3f} px")
    ax.axhline(0, color=plot.BLACK, linewidth=1)
    ax.set(xlabel="true shift (px)", ylabel="mean error (px)")
    ax.legend()
    plot.show(
        fig,
        "Mean error against the true shift: an S-shaped curve, zero at 0 and at half a"
        f" pixel, negative between 0 and a half, positive below: {', '.join(said)}.",
    )
