"""Figures of a published bundle adjustment, and of networks to choose from."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes

from pgm_lab import plot, rotation
from pgm_lab.bundle.result import Bundle
from pgm_lab.plot.basic import SERIES, Look, plain
from pgm_lab.plot.bundle import UM, symbol

# Colour, marker and line of a defect's curve
LOOKS = {
    "sign": (plot.RED, "s", "-"),
    "rho": (plot.ORANGE, "^", "-"),
    "rows": (plot.BLACK, "X", "--"),
    "centre twice": (plot.PURPLE, "v", ":"),
    "x/c": (plot.GREEN, "D", "-"),
    "pinv": (plot.SKY, "P", "-"),
    "2 P1 xy": (plot.GREY, ">", "-"),
    "short": (plot.GREY, "<", "--"),
    "none": (plot.BLUE, "o", "-"),
}


def by_photo(rms: Mapping[str, np.ndarray]) -> None:
    """Show the RMS of the residuals (mm) in each photo, by the name of the solution."""
    fig, ax = plt.subplots(figsize=(7, 3.7))
    m, width = len(next(iter(rms.values()))), 0.8 / len(rms)
    everything = UM * np.concatenate(list(rms.values()))
    floor = 10.0 ** np.floor(np.log10(everything.min()) - 0.2)
    for i, (name, values) in enumerate(rms.items()):
        at = np.arange(m) + (i - (len(rms) - 1) / 2) * width
        hatch = ("", "//", "..")[i]
        look: Look = {"color": SERIES[i][0], "hatch": hatch, "edgecolor": "white"}
        height = UM * values - floor
        ax.bar(at, height, 0.94 * width, bottom=floor, label=name, **look)
    ax.set(yscale="log", ylim=(floor, 1.3 * everything.max()))
    plain(ax.yaxis, (1,))
    ax.set(xlabel="photo", ylabel="RMS of the residuals (µm)")
    ax.set_xticks(range(m), list(map(str, range(1, m + 1))))
    ax.grid(False, axis="x")
    ax.tick_params(axis="x", length=0)
    ax.legend(loc="upper center", ncols=len(rms), bbox_to_anchor=(0.5, 1.13))
    text = "; ".join(
        f"{name} {1000 * np.min(values):.2g} to {1000 * np.max(values):.2g} µm"
        for name, values in rms.items()
    )
    plot.show(fig, f"RMS of the residuals in each photo on a log scale: {text}.")


def steps(runs: Mapping[str, np.ndarray]) -> None:
    """Show the RMS of an image coordinate (mm) after each step, for each defect."""
    fig, ax = plt.subplots(figsize=(7, 4.1), layout="constrained")
    for name, rms in runs.items():
        colour, marker, line = LOOKS[name]
        look: Look = {"color": colour, "marker": marker, "ls": line, "ms": 9}
        ax.plot(1000 * rms[:11], label=name, **look)
    ax.set(yscale="log", ylim=(0.15, 3e5), xlim=(-0.2, 10.2), xticks=range(0, 11, 2))
    ax.set(xlabel="steps", ylabel="RMS of a coordinate (µm)")
    fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    plot.show(
        fig,
        "RMS after each step for each defect alone, log scale. None, short and 2 P1 xy"
        " reach 0.31 micrometres after one to three steps; pinv stays at 8.2, x/c at"
        " 86, centre twice jumps between 0.3 and 130; rows comes to 0.8 and slowly"
        " grows again, rho and sign diverge beyond a millimetre.",
    )


def kept(values: Mapping[str, np.ndarray], limit: float) -> None:
    """Show singular values of a normal matrix, and the limit of a pseudo-inverse.

    The limit belongs to the first; what lies below, drawn hollow, counts as zero.
    """
    fig, ax = plt.subplots(figsize=(7, 3.8))
    ax.set_yscale("log")
    tolerance = limit
    for (name, s), (color, mark) in zip(values.items(), SERIES):
        number, above = np.arange(1, len(s) + 1), s > tolerance
        look: Look = {"color": color, "marker": mark, "linestyle": "", "markersize": 6}
        label = f"{name}: {above.sum()} of {len(s)} kept" if tolerance else name
        ax.plot(number[above], s[above], label=label, **look)
        below = ~above & (s > 0)
        ax.plot(number[below], s[below], markerfacecolor="none", **look)
        if tolerance:
            ax.axhline(tolerance, color=color, linestyle="--", linewidth=1.8)
            text: Look = {"color": color, "ha": "right", "va": "bottom"}
            text |= {"fontsize": 13, "transform": ax.get_yaxis_transform()}
            ax.text(0.995, tolerance, "tolerance", **text)
        tolerance = 0.0  # of the others
    ax.set(xlabel="number of the singular value")
    ax.set(ylabel="singular value (mixed units)")
    ax.set_title("Singular values; those drawn hollow count as zero")
    ax.legend(loc="best")
    plot.show(
        fig,
        "Singular values of the normal matrix in descending order on a log scale. As"
        " the units have it they span 16 powers of ten, and only 34 of 221 lie above"
        " the tolerance; with each column scaled they span less than seven, and all lie"
        " far above it.",
    )


def networks(given: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> None:
    """Draw networks (exteriors, points) from the side, a photo as a square."""
    fig, axes = plt.subplots(2, 3, figsize=(10, 3.8))
    for ax, (name, (exteriors, points)) in zip(axes.flat, given.items()):
        ax.axis("off")
        _from_the_side(ax, exteriors, points)
        ax.set_title(name, fontsize=16, loc="left")
    exactly: Look = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.012}
    axes[0, 0].quiver([1000, 1000], [-1400] * 2, [500, 0], [0, 500], **exactly)
    for x, z, word in ((1580, -1400, "Y"), (1000, -750, "Z"), (1100, -1150, "500 mm")):
        ha = "left" if word.endswith("mm") else "center"
        axes[0, 0].text(x, z, word, fontsize=13, ha=ha, va="center")
    plot.show(
        fig,
        "Networks seen from the side, the object in grey, the axes of the photos in"
        " blue; a square stands for a photo, its thick side for the top of the sensor;"
        f" arrows of 500 mm along Y and Z: {'; '.join(given)}.",
    )


def _from_the_side(ax: Axes, exteriors: np.ndarray, points: np.ndarray) -> None:
    """Draw object, axes and rolls of the photos; Y to the right, Z upwards."""
    ax.plot(*points[:, 1:].T, ".", color=plot.GREY, ms=5)
    places: list[np.ndarray] = []
    for _, y, z, *angles in exteriors:
        view, kappa = -rotation.matrix(*angles)[2], angles[2]
        way = 0.9 * np.hypot(*(points.mean(axis=0)[1:] - (y, z)))
        ax.plot([y, y + way * view[1]], [z, z + way * view[2]], color=plot.SKY, lw=1.5)
        ax.plot(y, z, "o", color=plot.BLUE, ms=5)
        near = [a for a in places if np.hypot(*(a - (y, z))) < 150]
        places.append(near[0] if near else np.array([y, z]))
        edges = kappa + np.pi / 4 + np.pi / 2 * np.arange(5)
        square = 106 * np.column_stack([np.cos(edges), np.sin(edges)])
        square += places[-1] - (170 + 240 * len(near)) * view[1:]
        ax.plot(*square.T, color=plot.BLACK, lw=1)
        ax.plot(*square[:2].T, color=plot.RED, lw=4)
    ax.set(aspect="equal", xlim=(-850, 1900), ylim=(-1500, 750))


def precisions(sds: Mapping[str, np.ndarray]) -> None:
    """Show how well networks know c, x0, y0 (µm; NaN: c cannot be determined)."""
    values = np.array(list(sds.values()))
    fig, ax = plt.subplots(figsize=(7, 3.6), layout="constrained")
    colours = plot.RED, plot.BLUE, plot.GREEN
    for k, (name, colour) in enumerate(zip(("c", "$x_0$", "$y_0$"), colours)):
        at = np.arange(len(values)) + 0.16 * (k - 1)
        ax.plot(values[:, k], at, "osD"[k], color=colour, label=name, ms=11)
    for row in np.flatnonzero(np.isnan(values[:, 0])):
        ax.text(60, float(row), "c cannot be determined", va="center", fontsize=15)
    ax.set(xscale="log", xlim=(4, 2500), xlabel="standard deviation (µm)")
    ax.set_xticks((5, 20, 100, 500, 2000), ("5", "20", "100", "500", "2000"))
    ax.set_yticks(range(len(sds)), list(sds))
    ax.minorticks_off()
    ax.invert_yaxis()
    fig.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    said = "; ".join(
        f"{name.strip()}: {', '.join(f'{x:.0f}' for x in row)}"
        for name, row in zip(sds, values)
    )
    plot.show(
        fig,
        "Standard deviations of c, x0 and y0 in micrometres on a log scale, nan where c"
        f" cannot be determined. {said}.",
    )


def left_over(result: Bundle) -> None:
    """Show the residuals of four photos, those beyond the limit with their points."""
    fig = plot.bundle.residual_vectors(result, [1, 3, 5, 6])
    fig.set_size_inches(7, 4.3)
    fig.suptitle(fig.get_suptitle().replace("; red", "\nred"), fontsize=15)
    plot.show(
        fig,
        "Residual vectors in photos 2, 4, 6 and 7, drawn much too large. Most point in"
        " all directions, some like their neighbours; six are much longer and red: one"
        " in photo 2, 4 mm from the principal point, and five in photos 6 and 7,"
        " farther out.",
    )


def scatter(ratio: Mapping[str, float], networks: int) -> None:
    """Show the scatter of simulated networks over what the covariance predicts.

    The band holds 95 % of the standard deviations of so many, if the prediction is
    right.
    """
    values, r = np.array(list(ratio.values())), networks - 1
    low, high = np.sqrt(scipy.special.chdtri(r, (0.975, 0.025)) / r)
    fig, ax = plt.subplots(figsize=(7, 3.5))
    ax.axhspan(low, high, color=plot.GREY, alpha=0.25, label="95 %, if it holds")
    ax.axhline(1, color=plot.BLACK, linewidth=1.4)
    color, mark = SERIES[0]
    ax.plot(values, mark, color=color, markersize=11, label="sampled")
    # The whole band, and room above it
    reach = max(2.2 * (high - 1), 1.2 * np.abs(values - 1).max())
    ax.set_ylim(1 - reach, 1 + reach)
    ax.set_xticks(range(len(ratio)), list(map(symbol, ratio)))
    ax.set(xlim=(-0.6, len(ratio) - 0.4), ylabel="sampled / predicted sd")
    ax.grid(False, axis="x")
    for label in ax.get_xticklabels()[::2]:  # words beside words
        label.set_y(-0.06 if len(label.get_text()) > 5 else 0)
    ax.legend(loc="lower left", ncols=2)
    plot.show(
        fig,
        f"Scatter of {networks} simulated networks over the predicted standard"
        f" deviation, between {values.min():.2f} and {values.max():.2f}, with the band"
        " that holds 95 per cent of them.",
    )


def speed(
    rays: Sequence[float],
    seconds: Mapping[str, Sequence[float]],
    megabytes: Sequence[float],
    labels: Sequence[str],
) -> None:
    """Show time by program, and memory of the first, of ever larger networks.

    The labels stand at the networks, such as their number of photos.
    """
    fig, (left, right) = plt.subplots(1, 2, figsize=(9, 4.2))
    for (name, values), (color, mark) in zip(seconds.items(), SERIES):
        look: Look = {"color": color, "marker": mark, "markersize": 9}
        left.plot(rays, values, "-", label=name, **look)
    right.plot(rays, megabytes, "o-", color=SERIES[0][0], markersize=9)
    for x, y, label in zip(rays, megabytes, labels):
        place: Look = {"textcoords": "offset points", "ha": "right", "fontsize": 13}
        right.annotate(label, (x, y), (-9, 3), **place)
    for ax, quantity in ((left, "time (s)"), (right, "memory (MB)")):
        ax.set(xscale="log", yscale="log", xlabel="rays", ylabel=quantity)
        plain(ax.yaxis, (1,))
    right.set(xlim=(min(rays) / 12, 2 * max(rays)), ylim=(None, 3 * max(megabytes)))
    shown = left.get_legend_handles_labels()
    fig.legend(*shown, loc="outside lower center", ncols=len(seconds))
    last = ", ".join(f"{name} {t[-1]:.3g} s" for name, t in seconds.items())
    plot.show(
        fig,
        "Left, time against the number of rays, both on log scales: lines that rise"
        f" together; for the largest network {last}. Right, the memory, up to"
        f" {max(megabytes):.0f} megabytes.",
    )
