"""Figures of the case of the twenty-five numbers: formulas and searches on trial."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from pgm_book.common.figures import draw_map, outline
from pgm_lab import _validate
from pgm_lab.plot import _doors, basic
from pgm_lab.plot.basic import Look

SCENES = {  # colour, mark and line, name
    "stereo pair": (basic.RED, "s-", "motorcycle"),
    "orthophoto": (basic.GREEN, "o--", "orthophoto"),
    "texture": (basic.BLUE, "^:", "texture on a slope"),
}


def two_maps(scene: ArrayLike, quick: ArrayLike, exact: ArrayLike) -> None:
    """Show a faint scene, and its maps of r computed in two ways.

    Parameters
    ----------
    scene : array_like (rows, columns)
        Grey values; a template of 21 pixels was cut out of its middle.
    quick, exact : array_like (n, n)
        r for every shift, from single and from double precision.
    """
    grey = _validate.image(scene, "scene")
    maps = [_validate.image(quick, "quick"), _validate.image(exact, "exact")]
    if any(r.shape[0] != r.shape[1] for r in maps):
        raise ValueError("quick and exact must be square maps of r")
    fig, axes = plt.subplots(1, 3, figsize=(7, 3.4))
    axes[0].imshow(grey)
    outline(axes[0], np.array(grey.shape[::-1]) // 2, 21, basic.ORANGE)
    for ax, r in zip(axes[1:], maps):
        drawn = draw_map(ax, r)
    for ax, title in zip(axes, ("scene", "32 bit", "mean first")):
        ax.set_title(title)
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    fig.colorbar(drawn, ax=axes, label="r", orientation="horizontal", aspect=40)
    basic.show(
        fig,
        "A hazy satellite scene with a template in its middle; the map of r in 32 bit,"
        " a random speckle; and the map with the mean taken off first, one summit.",
        colours=128,
    )


def before_and_after(r: Mapping[str, ArrayLike]) -> None:
    """Show how often each r occurs, before and after something was done to the photos.

    Parameters
    ----------
    r : mapping of str to array_like (n,)
        Two sets of correlations by name.
    """
    fig, ax = plt.subplots(figsize=(7, 3.8))
    looks = ((basic.BLUE, "-"), (basic.RED, "--"))
    said = []
    for (name, values), (colour, line) in zip(_doors.lists(r, "r").items(), looks):
        style: Look = {"bins": np.linspace(-0.2, 1, 49), "histtype": "step"}
        ax.hist(values, color=colour, linestyle=line, lw=3, label=name, **style)
        said.append(f"{name}: median {np.median(values):.2f}")
    ax.set(xlabel="r at the true place", ylabel="points")
    ax.legend(loc="upper left")
    basic.show(
        fig,
        "Histograms of r at the true place, a peak near 1 and a long tail to the left;"
        f" the two nearly coincide. {'; '.join(said)}.",
    )


def study(
    widths: ArrayLike,
    shares: Mapping[str, ArrayLike],
    rms: Mapping[str, ArrayLike],
) -> None:
    """Show the share of right matches and their precision against the template.

    Parameters
    ----------
    widths : array_like (n,)
        Of the template in pixels.
    shares, rms : mapping of str to array_like (n,)
        Share of right matches, and RMS error in pixels, by the name of the scene:
        "stereo pair", "orthophoto" and "texture".
    """
    across = _validate.finite(widths, "widths")
    right, errors = _doors.lists(shares, "shares"), _doors.lists(rms, "rms")
    if right.keys() != errors.keys() or not right.keys() <= SCENES.keys():
        raise ValueError(f"shares and rms must have names of {', '.join(SCENES)}")
    for series, name in ((right, "shares"), (errors, "rms")):
        if next(iter(series.values())).shape != across.shape:
            raise ValueError(f"widths and the lists of {name} must have one length")
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9))
    said = []
    for scene, values in right.items():
        colour, mark, name = SCENES[scene]
        share = 100 * np.asarray(values)
        axes[0].plot(across, share, mark, color=colour, label=name)
        axes[1].plot(across, errors[scene], mark, color=colour)
        said.append(f"{name} {share.max():.0f} % at most, {share[-1]:.0f} % at last")
    axes[0].set(title="right within 1 px (%)", ylim=(0, 104))
    axes[1].set(title="RMS error (px)", ylim=(0, 0.36))
    plt.setp(axes, xlabel="template (px)", xticks=(5, 15, 21, 31, 41))
    handles = axes[0].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=3)
    basic.show(
        fig,
        "Share of right matches and their RMS error against the width of the template,"
        f" 5 to 41 px. Right: {'; '.join(said)}. The error of the motorcycle grows from"
        " 0.20 to 0.34 px, that of the orthophoto falls to 0.07.",
    )


def reach(
    start: ArrayLike, match: ArrayLike, windows: Mapping[str, int], size: int = 19
) -> None:
    """Show search windows around a start to scale, and the match that was printed.

    Parameters
    ----------
    start, match : array_like (2,)
        (column, row) in pixels.
    windows : mapping of str to int
        Widths of the search windows in pixels, by name; up to three.
    size : int
        Width of the template in pixels.
    """
    begin = _validate.one_point(start, 2, "start")
    end = _validate.one_point(match, 2, "match")
    size = _validate.window(size, "size")
    windows = {
        name: _validate.whole(width, f"windows, {name}", 1)
        for name, width in _validate.mapping(windows, "windows").items()
    }
    if not windows:
        raise ValueError("windows must hold one width or more")
    fig, ax = plt.subplots(figsize=(7, 4.4))
    looks = ((basic.RED, "-"), (basic.ORANGE, "--"), (basic.BLUE, ":"))
    for (name, width), (colour, line) in zip(windows.items(), looks):
        label = f"{name}:\n{width} px"
        outline(ax, begin, width, colour, label=label, linestyle=line, linewidth=3)
    outline(ax, end, size, basic.GREEN, label=f"the match:\n{size} px", linewidth=2)
    ax.plot(*begin, "+", color=basic.BLACK, markersize=14, label="start")
    arrow: Look = {"arrowstyle": "->", "linewidth": 1.8}
    ax.annotate("", tuple(end), tuple(begin), arrowprops=arrow)
    far = max(windows.values()) / 2 + 8
    ax.set(xlim=(begin[0] - far, begin[0] + far), aspect="equal")
    ax.set(ylim=(begin[1] + far, begin[1] - far))
    ax.set(xlabel="column (px)", ylabel="row (px)")
    fig.legend(loc="outside right center")
    dx, dy = end - begin
    basic.show(
        fig,
        f"To scale: search windows of {', '.join(map(str, windows.values()))} px around"
        f" the start, and the match at ({dx:.0f}, {dy:.0f}) px from it; only the last"
        " window holds it.",
    )
