"""Figures of a round target and its centroid: what pulls it, and how good it is."""

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from pgm_lab import _validate, image, simulate
from pgm_lab.plot import basic
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import Look

NOISE = 3.0  # grey values, of `precision`
PLACE = (20.3, 19.6)  # of the target of `by_hand`, px
SIDE = 41  # px, its photo


def pull(window: ArrayLike, truth: ArrayLike, centroids: dict[str, ArrayLike]) -> None:
    """Show a target in its window, and centroids of it with the truth.

    Parameters
    ----------
    window : array_like (rows, columns)
        Grey values.
    truth : array_like (2,)
        (column, row) of the true centre, px.
    centroids : dict of str to array_like (2,)
        (column, row) by name, at most three.
    """
    window = _validate.image(window, "window")
    truth = _validate.one_point(truth, 2, "truth")
    found = {
        name: _validate.one_point(at, 2, f"centroids: {name}")
        for name, at in _validate.mapping(centroids, "centroids").items()
    }
    fig, ax = plt.subplots(figsize=(6.0, 4.6))
    ax.imshow(window, vmin=0, vmax=255)
    middle = (np.array(window.shape[::-1]) - 1) / 2
    ax.plot(*middle, "x", color=basic.ORANGE, markersize=13, markeredgewidth=3)
    ax.plot([], [], "x", color=basic.ORANGE, mew=3, label="middle of the window")
    ax.plot(*truth, "+k", markersize=26, markeredgewidth=3, label="truth")
    for (name, at), marker, colour in zip(found.items(), "os^", _colours()):
        ax.plot(*at, marker, color=colour, markersize=11, label=name)
    ax.grid(False)
    ax.set(xlabel="column X (px)", ylabel="row Y (px)")
    ax.set(yticks=range(0, len(window), 4))
    fig.legend(loc="outside lower center", ncols=2)
    told = [f"{name} at {_at(at)}" for name, at in found.items()]
    words = f"A bright disc in its window, its true centre at {_at(truth)}"
    basic.show(fig, f"{words}; {', '.join(told)} px.", colours=64)


def by_hand() -> None:
    """Show a target with sliders for the window, and for the background taken off."""
    clean = simulate.target(PLACE, 8.0, (SIDE, SIDE), background=40.0)
    photo = simulate.photograph(clean, noise=4.0, seed=2, bits=8)

    def draw(size: int, shift: int, background: int) -> None:
        low = SIDE // 2 - size // 2
        part = photo[low : low + size, low + shift : low + shift + size].astype(float)
        weight = part - background
        i, j = np.indices(part.shape)
        moments = (j * weight).sum(), (i * weight).sum()
        at = np.array(moments) / weight.sum() + (low + shift, low)
        off = at - PLACE
        fig, axes = plt.subplots(1, 2, figsize=(10, 4.6))
        frame: Look = {"fill": False, "edgecolor": basic.ORANGE, "linewidth": 3}
        corner = (low + shift - 0.5, low - 0.5)
        for ax in axes:
            _target(ax, photo, at)
        axes[0].add_patch(plt.Rectangle(corner, size, size, **frame))
        axes[0].set(title="photo and window", xlabel="column X (px)")
        axes[0].set_ylabel("row Y (px)")
        near = (PLACE[0] - 6, PLACE[0] + 6), (PLACE[1] + 6, PLACE[1] - 6)
        axes[1].set(xlim=near[0], ylim=near[1], xlabel="column X (px)")
        axes[1].set_title(f"off by {_sign(off[0])}, {_sign(off[1])} px")
        fig.legend(*axes[0].get_legend_handles_labels(), loc="outside right upper")
        basic.show(
            fig,
            f"A target, its window of {size} px moved by {shift} px, background"
            f" {background} taken off: the centroid is off by {_sign(off[0])},"
            f" {_sign(off[1])} px.",
            colours=64,
        )

    look: Look = {"continuous_update": False}
    interact(
        draw,
        size=IntSlider(21, 15, 27, 2, description="window", **look),
        shift=IntSlider(4, -6, 6, description="moved", **look),
        background=IntSlider(0, 0, 40, 5, description="taken off", **look),
    )


def precision() -> None:
    """Show how precise a centroid is, simulated and predicted, with noise 3."""
    fig, axes = plt.subplots(1, 2, figsize=(5.7, 3.8), sharey=True)
    studies = (
        ("diameter (px)", [(d, d, 21) for d in (4, 6, 8, 10, 12)]),
        ("window (px)", [(size, 8, size) for size in (15, 21, 31, 41)]),
    )
    told = []
    for ax, (label, cases) in zip(axes, studies):
        for sigmas, line, fill, name in ((0, "-", None, "no"), (3, ":", "white", "3σ")):
            runs = [(at, *sampled(d, size, sigmas)) for at, d, size in cases]
            places, simulated, predicted = np.transpose(runs)
            colour = basic.RED if sigmas else basic.BLUE
            ax.plot(places, predicted, line, color=colour)
            ax.plot(places, simulated, "o", color=colour, mfc=fill or colour)
            ax.plot(
                [], [], f"o{line}", color=colour, mfc=fill, label=f"{name} threshold"
            )
            each = ", ".join(f"{s:.3f} at {p:.0f}" for p, s in zip(places, simulated))
            told.append(f"{label}, {name} threshold: {each}")
        ax.axhline(0.03, color=basic.BLACK, linestyle="--")
        ax.set(xlabel=label, yscale="log")
        ax.set(yticks=(0.01, 0.03, 0.1), yticklabels=("0.01", "0.03", "0.10"))
        ax.minorticks_off()
    axes[0].set(ylabel="standard deviation (px)", title="window 21 px")
    axes[0].set_xticks(range(4, 13, 2))
    axes[1].set_title("diameter 8 px")
    handles = axes[0].get_legend_handles_labels()
    fig.legend(*handles, loc="outside lower center", ncols=2)
    words = "Standard deviation of a centroid in px, simulated and predicted. "
    basic.show(fig, words + "; ".join(told) + ". A dashed line marks 0.03 px.")


def sampled(
    diameter: float, size: int, sigmas: float = 0.0, noise: float = NOISE
) -> tuple[float, float]:
    """Precision of the centroid of 200 simulated targets of contrast 160.

    Parameters
    ----------
    diameter : float
        Of the targets, px.
    size : int
        Of the square windows, px.
    sigmas : float
        Threshold in standard deviations of the noise.
    noise : float
        Standard deviation of the noise, grey values.

    Returns
    -------
    tuple of float
        Standard deviation of a coordinate from the simulated errors, and the
        predicted one (px).
    """
    diameter = _validate.positive_number(diameter, "diameter", "px")
    size = _validate.window(size, "size")
    sigmas = _validate.not_negative(sigmas, "sigmas", "of the noise")
    noise = _validate.positive_number(noise, "noise", "grey values")
    shift = np.random.default_rng(2013).uniform(-0.5, 0.5, (200, 2))
    centres = (size - 1) / 2 + shift
    clean = simulate.target(centres, diameter, shape=(size, size))
    noisy = simulate.photograph(clean, noise, seed=15, bits=8)
    found = image.centroid(noisy, sigma=noise, threshold=sigmas * noise)
    predicted = np.sqrt(np.nanmean(found.covariance[:, 0, 0]))
    return float(np.nanstd(found.position - centres)), float(predicted)


def _target(ax: Axes, photo: np.ndarray, at: np.ndarray) -> None:
    ax.imshow(photo, vmin=0, vmax=255)
    ax.plot(*PLACE, "+k", markersize=24, markeredgewidth=3, label="truth")
    ax.plot(*at, "s", color=basic.RED, markersize=10, label="centroid")
    ax.grid(False)


def _colours() -> list[str]:
    return [basic.BLUE, basic.RED, basic.GREEN]


def _at(point: np.ndarray) -> str:
    return f"({point[0]:.2f}, {point[1]:.2f})"


def _sign(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")
