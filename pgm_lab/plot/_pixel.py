"""A pixel on the ground: the first figure of the workbook."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from pgm_lab import _validate
from pgm_lab.datasets import Orthophoto
from pgm_lab.plot.basic import BLACK, RED, Look


def pixel_on_ground(ortho: Orthophoto, height: float = 110.0) -> Figure:
    """Draw a camera above a real orthophoto, and the rays of one pixel.

    The camera is drawn far too large, and its pixels are, or they could not be seen.

    Parameters
    ----------
    ortho : datasets.Orthophoto
        What lies on the ground.
    height : float
        Flying height in m.

    Returns
    -------
    matplotlib.figure.Figure
    """
    _validate.instance(ortho, Orthophoto, "ortho")
    height = _validate.positive_number(height, "height", "m")
    side = ortho.grey.shape[0] * ortho.gsd / 2
    scale = 0.3  # of the image, large enough to be seen and to hold the whole ground
    image_height = height * (1 - scale)
    centre = np.array([0.0, 0.0, height])
    lines = np.linspace(-side, side, 9) * scale
    pixel = np.array([[5, 1], [6, 1], [6, 2], [5, 2]])
    image = np.column_stack([lines[pixel], np.full(4, image_height)])
    ground = centre + (image - centre) / scale

    fig = plt.figure(figsize=(10, 6.6), layout="none")
    where = (-0.25, -0.2, 1.5, 1.5)
    ax: Any = fig.add_axes(where, projection="3d", computed_zorder=False)
    ax.set_proj_type("ortho")
    azimuth = -62
    ax.view_init(elev=20, azim=azimuth)
    _lay_out(ax, ortho, side, 0.0, pixels=192, zorder=1)
    _lay_out(ax, ortho, side * scale, image_height, pixels=48, zorder=4)
    for at in lines:
        for x, y in ((lines[[0, -1]], [at, at]), ([at, at], lines[[0, -1]])):
            ax.plot(x, y, image_height, color="white", linewidth=0.8, zorder=5)
    ax.add_collection3d(Poly3DCollection([image], color=RED, zorder=6))
    ax.add_collection3d(Poly3DCollection([ground], color=RED, alpha=0.75, zorder=2))
    for top, bottom in zip(image, ground, strict=True):
        ax.plot(*zip(top, bottom, strict=True), color=RED, linewidth=1.6, zorder=3)
        ax.plot(*zip(centre, top, strict=True), color=RED, linewidth=1.6, zorder=7)
    ax.plot(*centre, "o", color=BLACK, markersize=10, zorder=8)
    # Straight to the left as the reader sees it, so that heights compare
    left = np.array([np.sin(np.radians(azimuth)), -np.cos(np.radians(azimuth))])
    bars = ("H", 0.0, 1.33 * side), ("c", image_height, 0.46 * side)
    for name, low, distance in bars:
        x, y = distance * left
        ax.plot([x, x], [y, y], [low, height], "-_", color=BLACK, markersize=13)
        x, y = (distance + 5) * left
        ax.text(x, y, (low + height) / 2, name, fontsize=21, ha="right", va="center")
    ax.text(*(centre + (6, 0, 3)), "perspective centre", fontsize=17)
    ax.text(side * scale + 9, 6, image_height, "image", fontsize=17)
    label = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 3}
    at = ground[1] + (5, -2, 0)
    ax.text(*at, "GSD", fontsize=21, color=RED, weight="bold", bbox=label, zorder=9)
    ax.set(xlim=(-side, side), ylim=(-side, side), zlim=(0, height))
    ax.set_box_aspect((2 * side, 2 * side, height), zoom=0.93)
    ax.set_axis_off()
    return fig


def _lay_out(
    ax: Axes3D, ortho: Orthophoto, side: float, height: float, pixels: int, zorder: int
) -> None:
    """Lay the orthophoto, averaged to pixels x pixels, on a plane at a height."""
    n = ortho.grey.shape[0] // pixels
    blocks = ortho.grey[: n * pixels, : n * pixels].reshape(pixels, n, pixels, n)
    colour = plt.get_cmap("gray")(blocks.mean(axis=(1, 3)) / 255)
    x, y = np.meshgrid(*2 * [np.linspace(-side, side, pixels + 1)])
    z = np.full_like(x, height)
    options: Look = {
        "rstride": 1,
        "cstride": 1,
        "shade": False,
        "antialiased": False,
    }
    ax.plot_surface(x, -y, z, facecolors=colour, zorder=zorder, **options)
