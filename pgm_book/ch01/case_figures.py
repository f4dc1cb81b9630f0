"""Figures of forty coordinates of 2010: their mirror, misfits, and decimals."""

import matplotlib.pyplot as plt
import numpy as np

from pgm_lab import plot
from pgm_lab.plot.basic import Look


def misfits(point: np.ndarray, misfit: np.ndarray) -> None:
    """Show computed minus printed coordinates of two photos, in nanometres."""
    misfit = 1e6 * misfit
    fig, axes = plt.subplots(1, 2, figsize=(5.6, 3.5), sharey=True)
    sides = ("left photo", plot.BLUE, "o"), ("right photo", plot.RED, "s")
    for ax, name, k in zip(axes, "xy", (0, 1)):
        ax.axhspan(-5, 5, color=plot.SKY, alpha=0.3)
        for part, (side, colour, marker) in zip(misfit, sides):
            look: Look = {"color": colour, "mfc": "none" if marker == "s" else colour}
            ax.plot(point, part[:, k], marker, label=side, **look)
        ax.set(title=name, xlabel="point", xticks=point[::3])
        ax.set_yticks(range(-8, 9))
    axes[0].set(ylabel="computed − printed (nm)", ylim=(-8.5, 8.5))
    handles = axes[0].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2)
    largest = np.abs(misfit).max()
    plot.show(
        fig,
        f"Computed minus printed coordinates in nanometres: {misfit.size} numbers, the"
        f" largest {largest:.1f}; a band marks 5, half of the last printed digit.",
    )


def left_over(listing: np.ndarray, sensor: np.ndarray) -> None:
    """Show how far numbers lie from the nearest whole number."""
    both = (
        ("pixel size of the listing", np.ravel(listing)),
        ("pixel size of the sensor", np.ravel(sensor)),
    )
    fig, ax = plt.subplots(figsize=(7, 4.2))
    told = []
    looks = (plot.RED, "D", "none"), (plot.BLUE, "o", plot.BLUE)
    for (name, nanometres), (colour, marker, fill) in zip(both, looks):
        rest = nanometres - np.round(nanometres)
        at = np.arange(1, rest.size + 1)
        ax.plot(at, rest, marker, color=colour, mfc=fill, label=name)
        told.append(f"{name}: up to {np.abs(rest).max():.4f} nm")
    ax.set(ylim=(-0.55, 0.55), xlabel="number in Table 4.1")
    ax.set_ylabel("distance from a\nwhole nanometre (nm)")
    fig.legend(loc="outside lower center")
    words = "Distance of photo coordinates from the nearest whole nanometre. "
    plot.show(fig, words + "; ".join(told) + ".")


def shrunk_image(offsets: np.ndarray, rms: np.ndarray) -> None:
    """Show how well a small photo fits the large one, for each assumed offset."""
    best = offsets[np.argmin(rms)]
    fig, ax = plt.subplots(figsize=(5.4, 2.9))
    ax.plot(offsets, rms, "o-", color=plot.BLUE)
    ax.axvline(best, color=plot.BLACK, linestyle="--")
    ax.text(best + 0.1, 0.9 * max(rms), f"{best:.1f} px", fontsize=15)
    ax.set(xlabel="assumed offset (px of the large photo)", ylim=(0, None))
    ax.set_ylabel("difference (grey\nvalues, RMS)")
    words = "Difference of a small and a large photo against the assumed offset"
    plot.show(fig, f"{words}: lowest at {best:.1f} px.")
