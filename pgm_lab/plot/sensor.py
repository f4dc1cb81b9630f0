"""Figures of the frames on a sensor, and of what a pixel is on the ground."""

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look

ARROW: Look = {"arrowstyle": "-|>", "mutation_scale": 24, "linewidth": 2.6}
LABEL: Look = {
    "fontsize": 15,
    "bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.88, "pad": 2},
}
WAYS = (
    ("centres, from 0", "NumPy, OpenCV, here", 0.0, basic.BLUE),
    ("corners, from 0", "GIS, some viewers", 0.5, basic.RED),
    ("centres, from 1", "MATLAB", 1.0, basic.GREEN),
)


def frames() -> None:
    """Show the pixel frame and the photo frame on one sensor, with 8 x 6 pixels."""
    fig, ax = plt.subplots(figsize=(10, 5.6))
    for edge in np.arange(-0.5, 8):
        ax.plot([edge, edge], [-0.5, 5.5], color=basic.SKY, linewidth=0.8)
    for edge in np.arange(-0.5, 6):
        ax.plot([-0.5, 7.5], [edge, edge], color=basic.SKY, linewidth=0.8)
    outline = plt.Rectangle((-0.5, -0.5), 8, 6, fill=False, linewidth=2)
    ax.add_patch(outline)
    _axis(ax, (0, 0), (2.4, 0), "X (column)", basic.BLUE, (2.5, -0.02))
    _axis(ax, (0, 0), (0, 2.4), "Y (row)", basic.BLUE, (0.1, 2.25))
    _axis(ax, (3.5, 2.5), (6.3, 2.5), "x (mm)", basic.RED, (6.4, 2.5))
    _axis(ax, (3.5, 2.5), (3.5, 0.1), "y (mm)", basic.RED, (3.6, 0.35))
    ax.plot(0, 0, "o", color=basic.BLUE, markersize=11)
    ax.plot(3.5, 2.5, "s", color=basic.RED, markersize=11)
    said = {"arrowprops": {"arrowstyle": "-"}, "va": "center", **LABEL}
    ax.annotate("centre of the\nfirst pixel: (0, 0)", (0, 0), (-2.9, 1.1), **said)
    ax.annotate("image centre\n$(X_c, Y_c)$", (3.5, 2.5), (1.35, 3.7), **said)
    point = (5.6, 1.3)
    ax.plot(*point, "*", color=basic.BLACK, markersize=18)
    ax.annotate("a point", point, (6.0, 0.75), **LABEL)
    size = {"arrowstyle": "<->", "linewidth": 2, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (6.5, 5.75), (7.5, 5.75), arrowprops=size)
    ax.text(7, 6.15, "$p_x$", ha="center", **LABEL)
    ax.annotate("", (7.75, 4.5), (7.75, 5.5), arrowprops=size)
    ax.text(7.9, 5, "$p_y$", va="center", **LABEL)
    ax.set(xlim=(-3.1, 8.6), ylim=(6.4, -0.8), aspect="equal")
    ax.axis("off")
    basic.show(
        fig,
        "A sensor of 8 by 6 pixels. The pixel frame begins at the centre of the first"
        " pixel at the upper left, its X axis points right and its Y axis down. The"
        " photo frame begins at the image centre, its x axis points right and its y"
        " axis up. A pixel is px wide and py high.",
    )


def interior() -> None:
    """Show the interior orientation, its parts named: a sketch, not to scale."""
    fig, ax = plt.subplots(figsize=(8.2, 5.1))
    centre = (0.0, 0.0, 13.0)
    principal = (2.4, -2.6, 0.0)
    point = (7.6, 3.6, 0.0)
    corners = 11.8 * np.array(
        [(-1, -0.67, 0), (1, -0.67, 0), (1, 0.67, 0), (-1, 0.67, 0)]
    )
    ax.fill(*_oblique(corners).T, color=basic.SKY, alpha=0.25)
    ax.plot(
        *_oblique(np.vstack([corners, corners[:1]])).T, color=basic.BLUE, linewidth=1.5
    )
    top = (principal[0], principal[1], centre[2])
    ax.plot(*_oblique([top, principal]).T, "--", color=basic.BLACK, linewidth=2.4)
    far = np.array(top) + 1.45 * (np.array(point) - top)
    ax.plot(*_oblique(np.array([top, far])).T, color=basic.GREEN, linewidth=2.6)
    origin = _oblique([(0, 0, 0)])[0]
    for end, name in (((8.0, 0.0, 0.0), "x"), ((0.0, 6.0, 0.0), "y")):
        _axis(ax, origin, _oblique([end])[0], name, basic.RED, _oblique([end])[0] + 0.2)
    first = _oblique([(-11.5, 7.6, 0)])[0]
    for end, name in (((-6.5, 7.6, 0.0), "X"), ((-11.5, 3.4, 0.0), "Y")):
        at = _oblique([end])[0]
        _axis(ax, first, at, name, basic.BLUE, at + (0.2, -0.9))
    marks = (
        (top, "o", basic.BLACK, "perspective centre", (0.8, 0.2)),
        (principal, "o", basic.BLACK, "principal point $(x_0, y_0)$", (-3.0, -4.8)),
        ((0, 0, 0), "s", basic.RED, "image centre", (-9.6, -1.7)),
        (point, "*", basic.GREEN, "photo point $(x, y)$", (0.9, 0.1)),
    )
    for at, marker, colour, name, (right, up) in marks:
        u, v = _oblique([at])[0]
        ax.plot(u, v, marker, color=colour, markersize=13)
        away = {"arrowprops": {"arrowstyle": "-"}} if right < 0 else {}
        ax.annotate(name, (u, v), (u + right, v + up), **(LABEL | away))
    u, v = _oblique([(principal[0], principal[1], 7.5)])[0]
    ax.text(u - 0.4, v, "c", ha="right", **(LABEL | {"fontsize": 21}))
    u, v = _oblique([far])[0]
    ax.text(u + 0.6, v, "ray, to the ground", color=basic.GREEN, va="center", **LABEL)
    u, v = _oblique([corners[0]])[0]
    ax.text(u + 0.5, v - 1.3, "image plane", color=basic.BLUE, **LABEL)
    ax.set(xlim=(-17, 22), ylim=(-7.5, 14), aspect="equal")
    ax.axis("off")
    basic.show(
        fig,
        "A camera from the side. A dashed line of length c leads from the perspective"
        " centre straight down to the principal point in the image plane. The image"
        " centre, where the axes x and y begin, lies a little beside it. A ray runs"
        " from the perspective centre through the photo point on to the ground.",
    )


def conventions() -> None:
    """Show one point of the first pixels under three ways to count."""
    fig, axes = plt.subplots(1, 3, figsize=(10, 4.7), sharey=True)
    told = []
    for ax, (title, who, shift, colour) in zip(axes, WAYS):
        for edge in np.arange(-0.5, 3.0):
            ax.plot([-0.5, 2.5], [edge, edge], color=basic.GREY, linewidth=1)
            ax.plot([edge, edge], [-0.5, 2.5], color=basic.GREY, linewidth=1)
        ax.plot(1.3, 0.8, "*", color=basic.BLACK, markersize=18)
        origin = np.array([-shift, -shift])
        ends = origin + (1, 0), origin + (0, 1)
        basic.frame(ax, origin, *ends, ("X", "Y"), color=colour)
        text = f"({1.3 + shift:.1f}, {0.8 + shift:.1f})"
        ax.text(1.0, 3.1, text, ha="center", fontsize=20, color=colour, weight="bold")
        ax.set_title(f"{title}\n{who}", loc="center", color=colour)
        ax.set(xlim=(-1.3, 2.7), ylim=(3.3, -1.3), aspect="equal")
        ax.axis("off")
        told.append(f"{text} with {title}")
    basic.show(
        fig,
        "The same star in the first 3 by 3 pixels under three conventions: "
        + ", ".join(told)
        + ". Arrows start at each origin.",
    )


def shrunk(offsets: ArrayLike, rms: ArrayLike) -> None:
    """Show how well a small photo fits the large one, for each assumed offset.

    Parameters
    ----------
    offsets : array_like (n,)
        Assumed place of the first small pixel in the large photo, px.
    rms : array_like (n,)
        Difference of the two photos in grey values.
    """
    offsets = _validate.finite(offsets, "offsets").ravel()
    rms = _validate.of_shape(rms, offsets.shape, "rms")
    best = offsets[np.argmin(rms)]
    fig, ax = plt.subplots(figsize=(5.4, 2.9))
    ax.plot(offsets, rms, "o-", color=basic.BLUE)
    ax.axvline(best, color=basic.BLACK, linestyle="--")
    ax.text(best + 0.1, 0.9 * rms.max(), f"{best:.1f} px", **LABEL)
    ax.set(xlabel="assumed offset (px of the large photo)", ylim=(0, None))
    ax.set_ylabel("difference (grey\nvalues, RMS)")
    words = "Difference of a small and a large photo against the assumed offset"
    basic.show(fig, f"{words}: lowest at {best:.1f} px.")


def ground(grey: ArrayLike, gsd: float, sizes: ArrayLike) -> None:
    """Show a part of an orthophoto with larger and larger pixels.

    Parameters
    ----------
    grey : array_like (n, n)
        Grey values of a square part.
    gsd : float
        Size of its pixels in m.
    sizes : array_like (m,)
        Sizes to show in m.
    """
    grey = _validate.image(grey, "grey")
    gsd = _validate.positive_number(gsd, "gsd", "m")
    sizes = np.atleast_1d(_validate.positive(sizes, "sizes", "m"))
    side = min(grey.shape)
    fig, axes = plt.subplots(1, len(sizes), figsize=(6.6, 2.75), squeeze=False)
    for ax, wanted in zip(axes[0], sizes):
        edges = np.linspace(0, side, max(2, round(side * gsd / wanted) + 1))
        summed = np.pad(grey[:side, :side], ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        at = np.meshgrid(edges, edges, indexing="ij")
        corners = scipy.ndimage.map_coordinates(summed, at, order=1)
        area = np.outer(np.diff(edges), np.diff(edges))
        ax.imshow(np.diff(np.diff(corners, axis=0), axis=1) / area)
        ax.set_title(f"{100 * wanted:.0f} cm", loc="center")
        ax.axis("off")
    each = ", ".join(f"{100 * one:.0f}" for one in sizes)
    words = f"The same {side * gsd:.0f} metres of ground with pixels of {each} cm."
    basic.show(fig, words, colours=64)


def _axis(
    ax: Axes, start: ArrayLike, end: ArrayLike, name: str, colour: str, at: ArrayLike
) -> None:
    """Draw an axis as an arrow, and write its name at a place."""
    look = ARROW | {"color": colour, "shrinkA": 0}
    (u, v), (x, y), (right, up) = (_validate.finite(p, name) for p in (end, start, at))
    ax.annotate("", (u, v), (x, y), arrowprops=look)
    ax.text(right, up, name, color=colour, weight="bold", va="center", **LABEL)


def _oblique(points: ArrayLike) -> np.ndarray:
    """Draw points in space on paper: x to the right, y to the back, z up."""
    x, y, z = np.asarray(points, dtype=float).T
    return np.column_stack([x + 0.5 * y, z + 0.4 * y])
