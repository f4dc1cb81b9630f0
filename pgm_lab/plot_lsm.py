"""Drawings of least squares matching: its iterations as a film."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import image, plot


def film_strip(
    left: ArrayLike,
    right: ArrayLike,
    point: tuple[int, int],
    window: int,
    parameters: ArrayLike,
    notes: Sequence[str],
) -> Figure:
    """Draw the iterations of least squares matching as a film, a column for each.

    Above the window in the photos, in the middle its grey values, those of the right
    photo brought to the left one by (2.7), and below the residuals.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Photos.
    point : (column, row)
        Pixel in the middle of the left window.
    window : int
        Pixels across the window, odd.
    parameters : array_like (k, 8)
        (a0, a1, a2, b0, b1, b2, h0, h1) of k iterations, x and y counted from `point`.
    notes : sequence of k str
        What to write above the columns.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the window leaves the left photo, or parameters and notes do not fit.
    """
    left, right = np.asarray(left, dtype=float), np.asarray(right, dtype=float)
    trail = np.asarray(parameters, dtype=float)
    if trail.shape != (len(notes), 8):
        raise ValueError(
            f"parameters must have shape ({len(notes)}, 8), as there are notes;"
            f" got {trail.shape}"
        )
    half = window // 2
    y, x = np.mgrid[-half : half + 1, -half : half + 1]
    here = np.stack([point[0] + x, point[1] + y], axis=-1)
    template = image.resample(left, here, "nearest")
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
    _photo(axes[0, 0], left, [identity], point, half, grey)
    axes[1, 0].imshow(template, **grey)
    axes[0, 0].set_title("left photo", fontsize=13, loc="center")
    for step, (p, note) in enumerate(zip(trail, notes, strict=True), start=1):
        above, middle, below = axes[:, step]
        _photo(above, right, trail[:step], trail[-1, [0, 3]], half, grey)
        above.set_title(note, fontsize=13, loc="center")
        found = p[6] + p[7] * image.resample(right, _at(p, x, y), "spline3", np.nan)
        middle.imshow(found, **grey)
        residuals = below.imshow(found - template, **signed)
    for ax in axes.flat:
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
        ax.spines[:].set_visible(False)
    axes[1, 0].set_xlabel("template A", fontsize=13)
    names = ("right photo", "$h_0 + h_1 B$", "residuals")
    for ax, name in zip(axes[:, 1], names, strict=True):
        ax.set_ylabel(name, fontsize=13)
    scale = axes[2, 0].inset_axes((0.0, 0.35, 0.9, 0.14))
    bar = fig.colorbar(residuals, cax=scale, orientation="horizontal")
    bar.set_label("grey values", fontsize=12)
    bar.ax.tick_params(labelsize=11)
    return fig


def _at(p: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where (2.8) and (2.9) take the pixels of the window, in the last axis."""
    return np.stack([p[0] + p[1] * x + p[2] * y, p[3] + p[4] * x + p[5] * y], axis=-1)


def _photo(ax, photo, trail, centre, half, grey) -> None:
    """Show a photo around `centre`, the last window of the trail, and its middles."""
    edge = half + 0.5
    x, y = edge * np.array([(-1, 1, 1, -1, -1), (-1, -1, 1, 1, -1)])
    ax.imshow(photo, **grey)
    ax.plot(*_at(trail[-1], x, y).T, color=plot.ORANGE, linewidth=2.4)
    look = {"color": plot.RED, "markersize": 6, "linewidth": 1.4}
    ax.plot(*np.array(trail)[:, [0, 3]].T, ".-", **look)
    view = 1.75 * edge
    ax.set(xlim=(centre[0] - view, centre[0] + view))
    ax.set(ylim=(centre[1] + view, centre[1] - view))
