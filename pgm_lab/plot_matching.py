"""Drawings of image matching: windows in a photo, correlation surfaces."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_lab import plot


def cut(image: np.ndarray, centre: ArrayLike, size: int) -> np.ndarray:
    """Square window around a pixel.

    Parameters
    ----------
    image : ndarray (rows, columns)
    centre : array_like (2,)
        (column, row); the window lies around the nearest whole pixel.
    size : int
        Odd width of the window.

    Returns
    -------
    ndarray (size, size)
        A view of the image.

    Raises
    ------
    ValueError
        If the size is even or the window leaves the image.

    Examples
    --------
    >>> cut(np.arange(20).reshape(4, 5), (2, 1), 3)
    array([[ 1,  2,  3],
           [ 6,  7,  8],
           [11, 12, 13]])
    """
    if size < 1 or size % 2 == 0:
        raise ValueError(f"size must be odd, so that a pixel is the middle; got {size}")
    column, row = np.floor(np.asarray(centre, dtype=float) + 0.5).astype(int)
    top, left = row - size // 2, column - size // 2
    window = image[max(top, 0) : top + size, max(left, 0) : left + size]
    if window.shape != (size, size):
        raise ValueError(
            f"a window of {size} x {size} around (column, row) ({column}, {row}) leaves"
            f" the image of {image.shape} (rows, columns); take a smaller one"
        )
    return window


def draw_window(
    ax: Axes, image: np.ndarray, centre: ArrayLike, size: int, **style: object
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
    column, row = np.floor(np.asarray(centre, dtype=float) + 0.5)
    half = size / 2
    extent = (column - half, column + half, row + half, row - half)
    style = {"cmap": "gray"} | style
    ax.imshow(cut(image, centre, size), extent=extent, **style)
    ax.grid(False)


def outline(
    ax: Axes, centre: ArrayLike, size: float, color: str = plot.RED, **style: object
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
    corner = np.asarray(centre, dtype=float) - size / 2
    style = {"fill": False, "linewidth": 2.5} | style
    return ax.add_patch(Rectangle(corner, size, size, edgecolor=color, **style))


def shifts(r: np.ndarray) -> np.ndarray:
    """Shifts of a square correlation map from its middle, in pixels.

    Examples
    --------
    >>> shifts(np.zeros((3, 3)))
    array([-1,  0,  1])
    """
    return np.arange(len(r)) - len(r) // 2


def draw_map(ax: Axes, r: np.ndarray, lowest: float = -0.5):
    """Show a square correlation map by colour, over the shift from its middle.

    Returns
    -------
    matplotlib.image.AxesImage
        For a colour bar.
    """
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
        Write r beside the summit.

    Returns
    -------
    (int, int)
        Shift (columns, rows) of the summit from the middle.
    """
    d = shifts(r)
    x, y = np.meshgrid(d, d)
    look = {"cmap": "cividis", "vmin": -0.5, "vmax": 1}
    ax.contourf(x, y, r, levels=20, zdir="z", offset=lowest, zorder=1, **look)
    mesh = {"rstride": 1, "cstride": 1, "linewidth": 0.15, "edgecolor": "#00000055"}
    ax.plot_surface(x, y, r, zorder=2, **mesh, **look)
    i, j = np.unravel_index(r.argmax(), r.shape)
    top = (d[j], d[i], r[i, j])
    ax.plot(*[[v] for v in top], "o", color=plot.RED, markersize=9, zorder=4)
    ax.plot(top[0], top[1], lowest, "o", color=plot.RED, markersize=6, zorder=3)
    if label:
        ax.text(*(np.array(top) + (0, 0, 0.12)), f"r = {r[i, j]:.2f}", color=plot.RED)
    ax.set(zlim=(lowest, 1.15), zticks=(0, 0.5, 1))
    ax.invert_yaxis()  # rows count downwards
    ax.set_xlabel("columns (px)", labelpad=6)
    ax.set_ylabel("rows (px)", labelpad=6)
    ax.set_zlabel("r", labelpad=2)
    ax.xaxis.set_major_locator(plt.MaxNLocator(4))
    ax.yaxis.set_major_locator(plt.MaxNLocator(4))
    return int(d[j]), int(d[i])
