"""Figures of heights from stereo plotting: what they are worth, and how they look."""

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look
from pgm_lab.simulate import Landscape
from pgm_lab.stereo import Surface, Terrain, quality

FAR = 1e9  # m: no coordinate is so large
CONTOURS = 2.5  # m, as in Harintaka 2020


def threshold(error: ArrayLike, r: ArrayLike, limit: float = 0.8) -> None:
    """Show what a threshold of r keeps of right and of wrong heights.

    Parameters
    ----------
    error : array_like (n,)
        Errors of the heights, m; more than a metre counts as wrong.
    r : array_like (n,)
        Correlation of each.
    limit : float
        Threshold to be marked.
    """
    error, r = _validate.finite(error, "error"), _validate.finite(r, "r")
    limit = _validate.number(limit, "limit")
    wrong = np.abs(error) > 1
    if error.ndim != 1 or error.shape != r.shape or wrong.all() or not wrong.any():
        raise ValueError(
            "error and r must be lists of the same length, with an error below a metre"
            " and one above"
        )
    at = np.linspace(-0.2, 1, 121)
    fig, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
    said = []
    for kind, name, colour, line in (
        (~wrong, "right within 1 m", basic.BLUE, "-"),
        (wrong, "wrong", basic.RED, "--"),
    ):
        share = 100 * np.mean(r[kind][:, None] >= at, axis=0)
        kept = 100 * float(np.mean(r[kind] >= limit))
        ax.plot(at, share, color=colour, ls=line, label=name)
        ax.plot(limit, kept, "o", color=colour, ms=11)
        said.append(f"{kept:.0f} % of the {name.split()[0]} ones")
        text: Look = {"textcoords": "offset points", "color": colour, "fontsize": 15}
        ax.annotate(f"{kept:.0f} %", (limit, kept), (10, 2), **text)
    ax.axvline(limit, color=basic.BLACK, ls=":", lw=1.5)
    ax.set(xlabel="threshold of r", ylabel="kept (%)", xlim=(0, 1), ylim=(0, 104))
    ax.legend(loc="lower left")
    basic.show(
        fig,
        "Share of the right (within 1 m) and of the wrong heights that a threshold of r"
        f" keeps. At {limit:g} it keeps {' and '.join(said)}.",
        colours=64,
    )


def errors(error: ArrayLike, sigma: float) -> None:
    """Show measured errors of heights beside the predicted normal curve.

    Parameters
    ----------
    error : array_like (n,)
        Errors in m.
    sigma : float
        Predicted standard deviation in m.
    """
    error = _validate.finite(error, "error").ravel()
    sigma = _validate.positive_number(sigma, "sigma", "m")
    if not error.size:
        raise ValueError("error must have at least one number")
    far = 6 * sigma
    nmad = 1.4826 * float(np.median(np.abs(error - np.median(error))))
    outside = 100 * float(np.mean(np.abs(error) > far))
    fig, ax = plt.subplots(figsize=(7, 3.4), layout="constrained")
    n, edges, _ = ax.hist(
        error, np.linspace(-far, far, 61).tolist(), color=basic.SKY, label="measured"
    )
    x = np.linspace(-far, far, 300)
    width = edges[1] - edges[0]
    bell = np.exp(-((x / sigma) ** 2) / 2) / sigma / np.sqrt(2 * np.pi)
    ax.plot(x, bell * width * len(error), color=basic.BLACK, label="predicted")
    ax.set(xlabel="error of the height (m)", ylabel="points", yticks=[])
    ax.legend(loc="upper left")
    basic.show(
        fig,
        f"Histogram of the errors of {len(error)} heights, NMAD {nmad:.2f} m, with the"
        f" predicted normal curve of standard deviation {sigma:.2f} m. {outside:.1f} %"
        " lie outside the axes.",
        colours=64,
    )


def profile(own: ArrayLike, book: ArrayLike, land: Landscape) -> None:
    """Show heights along a row by the reader's program, by pgm_lab, and the truth.

    Parameters
    ----------
    own, book : array_like (n, 3)
        X, Y, Z in m of pixels in a row; NaN where there is none.
    land : Landscape
        The truth.
    """
    dots, line = _known(own, "own"), _known(book, "book")
    _validate.instance(land, Landscape, "land")
    both = np.concatenate([line, dots])
    X = np.linspace(both[:, 0].min(), both[:, 0].max(), 600)
    Y = np.polyval(np.polyfit(both[:, 0], both[:, 1], 1), X)
    ground, top = land.at(land.dtm, X, Y).ravel(), land.at(land.dsm, X, Y).ravel()
    fig, ax = plt.subplots(figsize=(10, 3.3), layout="constrained")
    ax.fill_between(X, ground, top, color="0.78", label="house and trees, true")
    ax.fill_between(X, ground.min() - 8, ground, color="0.5", label="ground, true")
    gaps = np.asarray(book, float)
    look: Look = {"color": basic.SKY, "lw": 6, "label": "pgm_lab"}
    ax.plot(gaps[:, 0], gaps[:, 2], **look)
    ax.plot(dots[:, 0], dots[:, 2], ".", color=basic.RED, ms=9, label="your program")
    ax.set(xlabel="X (m)", ylabel="Z (m)")
    ax.set_ylim(ground.min() - 8, top.max() + 10)  # room for what hangs in the air
    fig.legend(loc="outside lower center", ncols=4, handlelength=1.4)
    off = np.abs(dots[:, 2] - land.at(land.dsm, dots[:, 0], dots[:, 1]).ravel())
    basic.show(
        fig,
        f"Profile of true ground with a house and trees on it, and heights by two"
        f" programs. {np.mean(off < 1) * 100:.0f} % of the {len(dots)} heights of the"
        " first follow the surface within a metre, over roofs and crowns.",
        colours=96,
    )


def terrain(dsm: Surface, dtm: Terrain, land: Landscape) -> None:
    """Show a measured surface and its terrain with contours, and how good they are.

    Parameters
    ----------
    dsm : Surface
    dtm : Terrain
        On the grid of the surface.
    land : Landscape
        The truth.
    """
    _validate.instance(dsm, Surface, "dsm")
    _validate.instance(dtm, Terrain, "dtm")
    _validate.instance(land, Landscape, "land")
    rows, columns = dsm.z.shape
    X, Y = np.meshgrid(
        dsm.corner[0] + dsm.cell * np.arange(columns),
        dsm.corner[1] - dsm.cell * np.arange(rows),
    )
    truth, kind = land.at(land.dtm, X, Y), land.at(land.kind, X, Y, 0)
    error = dtm.z - truth
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9), layout="compressed")
    axes[0].imshow(_shaded(dsm.z, dsm.cell), vmin=-0.4, vmax=1)
    axes[0].set_title("surface (DSM)")
    axes[0].set_xlabel(f"contours every {CONTOURS} m", fontsize=14)
    drawn = axes[1].imshow(error, cmap="PuOr", vmin=-0.5, vmax=0.5)
    axes[1].set_title("terrain (DTM), errors")
    for ax, z in zip(axes, (dsm.z, dtm.z)):
        steps = np.arange(0, 100, CONTOURS)
        ax.contour(z, steps, colors=basic.BLACK, linewidths=1.2)
        ax.set(xticks=[], yticks=[])
        ax.grid(False)
    names = ("open", "houses", "trees")
    said = [
        f"{quality(dtm.z, truth, kind == k).rmse:.2f} m {name}"
        for k, name in enumerate(names)
        if np.any(np.isfinite(error[kind == k]))
    ]
    bar = fig.colorbar(drawn, ax=axes.tolist(), location="bottom", aspect=40, pad=0.03)
    words = f"terrain − truth (m): RMSE {', '.join(said)}"
    bar.set_label(words, fontsize=14)
    basic.show(
        fig,
        f"Two maps with contours every {CONTOURS} m. Those of the surface pile up at"
        " houses and crowns; those of the terrain run smoothly. Its errors, in colours,"
        f" are small in the fields and larger in the wood: RMSE {', '.join(said)}.",
        colours=96,
    )


def _known(points: ArrayLike, name: str) -> np.ndarray:
    """Points (n, 3) without those that are NaN; at least two."""
    array = _validate.real(points, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} must have shape (n, 3); got {array.shape}")
    known = array[np.abs(array).max(axis=1, initial=0) < FAR]
    if len(np.unique(known[:, 0])) < 2:
        raise ValueError(f"{name} must have two points of different X that are not NaN")
    return np.asarray(known)


def _shaded(z: np.ndarray, cell: float) -> np.ndarray:
    """Light from the upper left on a surface, from 0 to 1; white outside."""
    south, east = np.gradient(z, cell)
    light = (1 + 0.7 * east + 0.7 * south) / np.sqrt(2 * (1 + east**2 + south**2))
    return np.where(np.isfinite(light), np.clip(light, 0, 0.97), 1.0)
