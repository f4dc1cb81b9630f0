"""Figures of the case of a log of 2010: its numbers, its defects, a real pair."""

import matplotlib.pyplot as plt
import numpy as np

from pgm_book.common import results
from pgm_lab import plot
from pgm_lab.plot.basic import Look

DEFECTS = {
    "none": "none",
    "uncentred": "origin at the corner",
    "integer gradients": "whole slopes",
    "bilinear": "bilinear",
    "rounded": "bilinear, rounded",
    "diagonal grid": "diagonal only",
    "or": 'limits joined by "or"',
    "six parameters": "no $h_0$, $h_1$",
    "all of the program": "all together",
}
SCENES = {
    "good contrast": (plot.BLUE, "o"),
    "shear as in the log": (plot.ORANGE, "s"),
    "all as in the log": (plot.RED, "D"),
}
PRINTED_S0 = 0.384176144168957  # Bani 2010, IV.1.3
PIXELS = 17  # across the window of the log


def origin(
    distance: np.ndarray, condition: np.ndarray, determinant: np.ndarray, sd: np.ndarray
) -> None:
    """Show what becomes of a normal matrix when the origin moves out of the window."""
    fig, ax = plt.subplots(figsize=(7, 3.9), layout="constrained")
    for values, style, colour, name in (
        (condition, "o-", plot.RED, "condition number"),
        (determinant, "s--", plot.BLUE, "determinant, relative"),
        (sd, "^:", plot.ORANGE, "SD of $a_0$, relative"),
    ):
        ax.plot(distance, values, style, color=colour, label=name, lw=3)
    ax.set(yscale="log", xlabel="distance of the origin (px)", xlim=(-0.15, 1700))
    ax.set_xscale("symlog", linthresh=1)
    ax.set_ylim(top=1e15)
    ax.set_xticks((0, 1, 10, 100, 1083), map(str, (0, 1, 10, 100, 1083)))
    ax.legend(loc="upper left")
    plot.show(
        fig,
        "Against the distance of the origin from the window, up to the 1083 pixels of"
        f" 2010: the condition number grows from {condition[0]:.0f} to"
        f" {condition[-1]:.0e}, the determinant stays, the standard deviation of a0"
        f" grows {sd[-1]:.0f} times.",
    )


def s0(sizes: np.ndarray, right: np.ndarray) -> None:
    """Show S0 by the text and by the listing of 2010 against the size of the window."""
    listing = right / np.sqrt(sizes**2 - 6)
    fig, ax = plt.subplots(figsize=(7, 4.0), layout="constrained")
    text = "$\\sqrt{v^Tv / r}$, the text"
    ax.plot(sizes, right, "o-", color=plot.BLUE, lw=3, label=text)
    text = "$\\sqrt{v^Tv}\\,/\\,r$, the listing"
    ax.plot(sizes, listing, "D--", color=plot.RED, lw=3, label=text)
    star: Look = {"marker": "*", "color": plot.BLACK, "ms": 24, "ls": "none"}
    ax.plot(PIXELS, PRINTED_S0, **star, label="printed: 0.384")
    times = PRINTED_S0 * np.sqrt(PIXELS**2 - 6)
    label = f"printed × √{PIXELS**2 - 6} = {times:.2f}"
    ax.plot(PIXELS, times, **star, fillstyle="none", label=label)
    ax.set(yscale="log", xlabel="window (px)", ylabel="S0 (grey values)")
    ax.tick_params(labelsize=15)
    ax.set(xticks=sizes, ylim=(0.1, 2000))
    ax.set_yticks((0.1, 1, 10), ("0.1", "1", "10"))
    ax.legend(loc="upper right")
    plot.show(
        fig,
        "S0 against the size of the window, simulated with noise 4.6 in both photos. By"
        f" the text it stays near {right.mean():.1f}; by the listing it falls from"
        f" {listing[0]:.1f} to {listing[-1]:.2f}. The printed 0.384 lies on the lower"
        f" curve at 17 pixels, {times:.2f} on the upper.",
    )


def costs() -> None:
    """Show what each defect alone costs in three simulated scenes."""
    rows = results.rows("ch03", "defects")
    ratios = {(r["scene"], r["defect"]): float(r["ratio"] or "nan") for r in rows}
    fig, ax = plt.subplots(figsize=(7, 4.6), layout="constrained")
    for shift, (scene, (colour, marker)) in zip((-0.2, 0, 0.2), SCENES.items()):
        at = np.arange(len(DEFECTS)) + shift
        ratio = [ratios[scene, defect] for defect in DEFECTS]
        ax.plot(ratio, at, marker, color=colour, label=scene, ms=10)
    ax.set(xscale="log", xlim=(0.9, 14), xlabel="error / best possible error")
    ax.set_xticks((1, 2, 5, 10), ("1", "2", "5", "10"))
    ax.set_yticks(range(len(DEFECTS)), DEFECTS.values())
    ax.invert_yaxis()
    ax.minorticks_off()
    ax.legend(loc="upper right", fontsize=14)
    plot.show(
        fig,
        "Error over the Cramér-Rao bound for each defect alone, in three simulated"
        " scenes. The origin at the corner and slopes cut to whole numbers cost"
        " nothing. Bilinear costs a factor of 2.8 with good contrast, the diagonal and"
        " the word or a factor of 9 where there is a shear, missing h0 and h1 up to a"
        " factor of 10.",
    )


def radiometric(gains: np.ndarray, eight: np.ndarray, six: np.ndarray) -> None:
    """Show the error of the position with and without h0 and h1, against the gain."""
    fig, ax = plt.subplots(figsize=(7, 3.5), layout="constrained")
    ax.plot(gains, 1000 * six, "D--", color=plot.RED, lw=3, label="six parameters")
    ax.plot(gains, 1000 * eight, "o-", color=plot.BLUE, lw=3, label="eight parameters")
    ax.set(xlabel="gain of the right photo", ylabel="RMS error (0.001 px)")
    ax.set_ylim(0, None)
    ax.legend(loc="upper center")
    plot.show(
        fig,
        "RMS error of the position against the gain. With eight parameters it stays at"
        f" {1000 * eight.mean():.0f} thousandths of a pixel; with six it is the same at"
        f" gain 1 and {six[-1] / eight[-1]:.0f} times as large at the end.",
    )


def bound() -> None:
    """Show how far `lsm.match` stays above the bound, with eight parameters."""
    wanted = {"contrast": "40.0", "sigma": "1.0", "gain_offset": "1.08 and 4"}
    rows = [
        row
        for row in results.rows("ch03", "precision")
        if wanted.items() <= row.items() and row["h0_h1"] == "estimated"
    ]
    names = [f"{row['texture']}, {row['grey']}" for row in rows]
    ratios = [float(row["rms_over_bound"]) for row in rows]
    fig, ax = plt.subplots(figsize=(7, 2.4), layout="constrained")
    ax.axvline(1, color=plot.BLACK)
    ax.plot(ratios, names, "o", color=plot.BLUE, ms=10)
    for name, ratio in zip(names, ratios):
        ax.annotate(f"{ratio:.2f}", (ratio + 0.06, name), va="center", fontsize=14)
    ax.set(xlim=(0.9, 3.1), xlabel="error / best possible error")
    ax.margins(y=0.2)
    ax.invert_yaxis()
    said = ", ".join(f"{name} {ratio:.2f}" for name, ratio in zip(names, ratios))
    plot.show(fig, f"Error of a match over the Cramér-Rao bound: {said}.")


def on_photo(photo: np.ndarray, points: np.ndarray, errors: np.ndarray) -> None:
    """Show matches on a photo, coloured by their distance from the truth."""
    classes = {
        "< 0.1 px": (errors < 0.1, plot.BLUE, "s"),
        "0.1 to 1 px": ((errors >= 0.1) & (errors < 1), plot.SKY, "o"),
        "> 1 px": (errors >= 1, plot.RED, "^"),
    }
    fig, ax = plt.subplots(figsize=(6.3, 4.1), layout="constrained")
    rows, columns = photo.shape
    extent = (-0.5, columns - 0.5, rows - 0.5, -0.5)
    ax.imshow(photo[::2, ::2], extent=extent, cmap="gray", alpha=0.6)
    for name, (k, colour, marker) in classes.items():
        ax.plot(
            *points[k].T, marker, color=colour, ms=5, ls="", label=f"{name}: {k.sum()}"
        )
    ax.set(xlabel="column (px)", ylabel="row (px)")
    ax.grid(False)
    handles = ax.get_legend_handles_labels()
    fig.legend(
        *handles,
        loc="outside lower center",
        ncols=3,
        fontsize=14,
        markerscale=2,
        handletextpad=0.1,
    )
    plot.show(
        fig,
        "Matches on the photo, coloured by their distance from the truth:"
        f" {', '.join(f'{k.sum()} {name}' for name, (k, _, _) in classes.items())}. The"
        " largest errors stand along outlines, where something near covers what lies"
        " behind it.",
    )
