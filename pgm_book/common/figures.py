"""Drawings of image matching: windows, correlation surfaces, the film of LSM."""

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.image import cut, resample
from pgm_lab.plot import _doors, basic
from pgm_lab.plot.basic import Look


def draw_window(
    ax: Axes, image: np.ndarray, centre: ArrayLike, size: int, **style: Any
) -> None:
    """Show the window around a pixel, with axes in pixels of the whole image.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    image, centre, size
        As for `cut`.
    **style
        Handed to `imshow`.
    """
    _doors.axes(ax)
    window = cut(_validate.image(image), centre, size)
    column, row = np.floor(_validate.one_point(centre, 2, "centre") + 0.5)
    half = int(size) / 2
    extent = (column - half, column + half, row + half, row - half)
    style = {"cmap": "gray"} | style
    ax.imshow(window, extent=extent, **style)
    ax.grid(False)


def outline(
    ax: Axes, centre: ArrayLike, size: float, color: str = basic.RED, **style: Any
) -> Rectangle:
    """Draw the outline of a square window, along the outer edges of its pixels.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Axes in pixels.
    centre : array_like (2,)
        (column, row).
    size : float
        Width in pixels.
    color : str
        Colour of the line.
    **style
        Handed to `matplotlib.patches.Rectangle`.
    """
    _doors.axes(ax)
    _doors.colour(color, "color")
    size = _validate.positive_number(size, "size", "px")
    x, y = _validate.one_point(centre, 2, "centre") - size / 2
    style = {"fill": False, "linewidth": 2.5} | style
    square = Rectangle((x, y), size, size, edgecolor=color, **style)
    ax.add_patch(square)
    return square


def shifts(r: np.ndarray) -> np.ndarray:
    """Shifts of a square correlation map from its middle, in pixels.

    Examples
    --------
    >>> shifts(np.zeros((3, 3)))
    array([-1,  0,  1])
    """
    r = _doors.square_map(r)
    return np.arange(len(r)) - len(r) // 2


def draw_map(ax: Axes, r: np.ndarray, lowest: float = -0.5) -> AxesImage:
    """Show a square correlation map by colour, over the shift from its middle.

    Returns
    -------
    matplotlib.image.AxesImage
        For a colour bar.
    """
    _doors.axes(ax)
    r = _doors.square_map(r)
    lowest = _lowest(lowest)
    half = len(r) / 2
    extent = (-half, half, half, -half)
    ax.grid(False)
    return ax.imshow(r, extent=extent, cmap="cividis", vmin=lowest, vmax=1)


def draw_surface(
    ax: Axes3D, r: np.ndarray, lowest: float = -0.6, label: bool = True
) -> tuple[int, int]:
    """Draw a square correlation map as a landscape, its map below, and mark the summit.

    Parameters
    ----------
    ax : Axes3D
        Where to draw.
    r : ndarray (n, n)
        Correlation for each shift from the middle.
    lowest : float
        Where the map lies, below the landscape.
    label : bool
        Write r at the summit.

    Returns
    -------
    (int, int)
        Shift (columns, rows) of the summit from the middle.
    """
    _doors.axes_in_space(ax)
    r = _doors.square_map(r)
    if len(r) < 2:
        raise ValueError("r must have two rows or more, to be a landscape")
    lowest = _lowest(lowest)
    label = _validate.flag(label, "label")
    d = shifts(r)
    x, y = np.meshgrid(d, d)
    look = {"cmap": "cividis", "vmin": -0.5, "vmax": 1}
    ax.contourf(x, y, r, levels=20, zdir="z", offset=lowest, zorder=1, **look)
    mesh = {"rstride": 1, "cstride": 1, "linewidth": 0.15, "edgecolor": "#00000055"}
    ax.plot_surface(x, y, r, zorder=2, **mesh, **look)
    i, j = np.unravel_index(r.argmax(), r.shape)
    top = (d[j], d[i], r[i, j])
    ax.plot(*[[v] for v in top], "o", color=basic.RED, markersize=9, zorder=4)
    ax.plot(top[0], top[1], lowest, "o", color=basic.RED, markersize=6, zorder=3)
    if label:
        ax.text(*(np.array(top) + (0, 0, 0.12)), f"r = {r[i, j]:.2f}", color=basic.RED)
    ax.set(zlim=(lowest, 1.15), zticks=(0, 0.5, 1))
    ax.invert_yaxis()  # rows count downwards
    ax.set_xlabel("columns (px)", labelpad=6)
    ax.set_ylabel("rows (px)", labelpad=6)
    ax.set_zlabel("r", labelpad=2)
    ax.xaxis.set_major_locator(plt.MaxNLocator(4))
    ax.yaxis.set_major_locator(plt.MaxNLocator(4))
    return int(d[j]), int(d[i])


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
    photo brought to the left one by (B 2.7), and below the residuals.

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
    left, right = _validate.image(left, "left", 2), _validate.image(right, "right", 2)
    point = tuple(_validate.one_point(point, 2, "point"))
    window = _validate.window(window, "window")
    notes = _validate.texts(notes, "notes")
    trail = _validate.finite(parameters, "parameters")
    if trail.shape != (len(notes), 8) or not notes:
        raise ValueError(
            f"parameters must have shape ({len(notes)}, 8), as there are notes;"
            f" got {trail.shape}"
        )
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
    _photo(axes[0, 0], left, identity[None], identity[[0, 3]], half, grey)
    axes[1, 0].imshow(template, **grey)
    axes[0, 0].set_title("left photo", fontsize=18, loc="center")
    for step, (p, note) in enumerate(zip(trail, notes, strict=True), start=1):
        above, middle, below = axes[:, step]
        _photo(above, right, trail[:step], trail[-1, [0, 3]], half, grey)
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


def _photo(
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
    ax.plot(*_at(trail[-1], x, y).T, color=basic.ORANGE, linewidth=2.4)
    look: Look = {"color": basic.RED, "markersize": 6, "linewidth": 1.4}
    ax.plot(*trail[:, [0, 3]].T, ".-", **look)
    view = 1.75 * edge
    ax.set(xlim=(centre[0] - view, centre[0] + view))
    ax.set(ylim=(centre[1] + view, centre[1] - view))


def _lowest(value: float) -> float:
    if (lowest := _validate.number(value, "lowest")) < 1:
        return lowest
    raise ValueError(f"lowest must lie below 1, the best correlation; got {lowest:g}")
