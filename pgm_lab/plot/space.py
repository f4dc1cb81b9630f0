"""Cameras in space: their positions, and what they see.

Everything is drawn in the units of the object frame. Cameras look along their negative
z axis; `rotation.matrix` rotates the object frame into theirs.
"""

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from mpl_toolkits.mplot3d import Axes3D, proj3d
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import ArrayLike

from pgm_lab import rotation
from pgm_lab.datasets import Orthophoto
from pgm_lab.plot.basic import BLACK, BLUE, GREEN, RED, Look

AXES = (RED, GREEN, BLUE)  # x, y, z
# Drawings may reach beyond their axes, which makes room for large ones
FREE = {"clip_on": False, "in_layout": False}
FORMAT = (1.0, 0.75)  # width and height of a photo per principal distance
SKY_COLOR = "#DCEBF5"
ELEVATION = 16.0  # of the reader's eye in `best_view`, in degrees
DIRECTIONS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")  # north is (0, 1, 0)
NEAREST = 1e-3  # how far in front of the camera a point must lie, in object units

Faces = Sequence[tuple[np.ndarray, str]]  # polygons (k, 3), each with its colour


def space(
    fig: Figure,
    where: object = 111,
    view: tuple[float, float] = (25.0, -60.0),
    zoom: float = 1.0,
) -> Axes3D:
    """Add axes for a drawing in space, without perspective and without a box.

    Parameters
    ----------
    fig : matplotlib.figure.Figure
        Where to add them.
    where : object
        Position in the figure, as for `Figure.add_subplot`.
    view : (float, float)
        Elevation and azimuth of the reader's eye, in degrees.
    zoom : float
        Factor by which the drawing is enlarged.
    """
    # What is drawn later lies on top: matplotlib's own guess hides cameras
    ax = fig.add_subplot(where, projection="3d", computed_zorder=False)
    ax.set_proj_type("ortho")
    ax.view_init(*view)
    ax.set_box_aspect((1, 1, 1), zoom=zoom)
    ax.set_axis_off()
    ax.patch.set_visible(False)  # it would hide what extends over from its neighbour
    return ax


def fit(ax: Axes3D, points: ArrayLike, zoom: float = 1.0) -> None:
    """Show all points (..., 3), with one scale on all three axes."""
    points = np.reshape(points, (-1, 3))
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.maximum(high - low, 1e-9 * np.ptp(points) + 1e-12)
    for name, a, b in zip("xyz", low, low + size):
        getattr(ax, f"set_{name}lim")(a, b, view_margin=0)
    ax.set_box_aspect(size, zoom=zoom)


def frustum(
    exterior: ArrayLike, size: float = 1.0, form: tuple[float, float] = FORMAT
) -> np.ndarray:
    """Corners of the photo in front of a camera, in object space.

    Parameters
    ----------
    exterior : array_like (6,)
        (X0, Y0, Z0, omega, phi, kappa).
    size : float
        Distance of the photo plane from the perspective centre, in object units.
    form : (float, float)
        Width and height of the photo, divided by its principal distance.

    Returns
    -------
    ndarray (4, 3)
        Lower left, lower right, upper right, upper left corner.
    """
    exterior = np.asarray(exterior, float)
    width, height = np.asarray(form) / 2
    corners = np.array(
        [(-width, -height), (width, -height), (width, height), (-width, height)]
    )
    rays = np.column_stack([corners, -np.ones(4)])
    # Row vectors: (M' ray)' = ray' M
    return exterior[:3] + size * rays @ rotation.matrix(*exterior[3:])


def draw_camera(
    ax: Axes3D,
    exterior: ArrayLike,
    size: float = 1.0,
    *,
    form: tuple[float, float] = FORMAT,
    color: str = BLACK,
    name: str = "",
    axes: bool = True,
    fontsize: float = 15,
) -> np.ndarray:
    """Draw a camera: perspective centre, photo plane, rays to its corners, axes.

    The photo lies in front of the perspective centre, upright, as the viewer of a print
    sees it; a bar marks its upper edge.

    Parameters
    ----------
    ax : Axes3D
        Where to draw, see `space`.
    exterior : array_like (6,)
        (X0, Y0, Z0, omega, phi, kappa).
    size : float
        Distance of the photo plane from the perspective centre, in object units.
    form : (float, float)
        Width and height of the photo, divided by its principal distance.
    color : str
        Colour of the camera.
    name : str
        What to write at the perspective centre.
    axes : bool
        Draw the camera's x, y and z axis.
    fontsize : float
        Size of the names.

    Returns
    -------
    ndarray (k, 3)
        All points drawn, for `fit`.
    """
    exterior = np.asarray(exterior, float)
    centre, corners = exterior[:3], frustum(exterior, size, form)
    rays = np.stack(np.broadcast_arrays(centre, corners), axis=1)
    thin = {"linewidths": 1.5, "zorder": 3} | FREE
    ax.add_collection3d(Line3DCollection(rays, colors=color, **thin))
    plane = thin | {"facecolors": color, "edgecolors": color, "alpha": 0.22}
    ax.add_collection3d(Poly3DCollection([corners], **plane))
    line = {"color": color, "zorder": 3} | FREE
    ax.plot(*corners[2:].T, linewidth=4.5, solid_capstyle="butt", **line)
    ax.plot(*centre, "o", markersize=6, **line)
    drawn = [centre, *corners]
    if axes:
        drawn += [*draw_axes(ax, centre, rotation.matrix(*exterior[3:]), 0.8 * size)]
    if name:
        # Above the camera, away from its view
        above = centre + 0.35 * size * rotation.matrix(*exterior[3:])[2]
        ax.text(*above, name, color=color, fontsize=fontsize, ha="center", va="center")
    return np.array(drawn)


def draw_axes(
    ax: Axes3D,
    origin: ArrayLike,
    M: ArrayLike | None = None,
    length: float = 1.0,
    names: Sequence[str] = ("x", "y", "z"),
    fontsize: float = 14,
) -> np.ndarray:
    """Draw three axes as arrows: the rows of M, or those of the object frame.

    It returns the tips (3, 3).
    """
    M, origin = np.eye(3) if M is None else np.asarray(M), np.asarray(origin)
    for row, color, name in zip(M, AXES, names):
        arrow = {"color": color, "linewidth": 2.4, "arrow_length_ratio": 0.22}
        ax.quiver(*origin, *(length * row), zorder=4, **FREE, **arrow)
        tip = origin + 1.18 * length * row
        ax.text(*tip, name, color=color, fontsize=fontsize, ha="center", va="center")
    return origin + length * M


def draw_faces(ax: Axes3D, faces: Faces) -> np.ndarray:
    """Draw polygons in space; returns all their corners, for `fit`.

    What lies on the ground, at Z = 0, is drawn first: seen from above it hides nothing.
    """
    look = {"edgecolors": "white", "linewidths": 0.4, "alpha": 1.0, "zorder": 1}
    on_ground = [face for face in faces if not face[0][:, 2].any()]
    for part in (on_ground, [face for face in faces if face[0][:, 2].any()]):
        polygons, colors = zip(*part) if part else ((), ())
        drawn = Poly3DCollection(polygons, facecolors=colors, **look, **FREE)
        ax.add_collection3d(drawn)
    return np.concatenate([polygon for polygon, _ in faces])


# --- What a camera sees ---


def draw_photo(
    ax: Axes,
    exterior: ArrayLike,
    faces: Faces,
    c: float = 1.0,
    form: tuple[float, float] = FORMAT,
    ground: str | None = None,
) -> None:
    """Draw what a camera sees of polygons in space, far ones first.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw, x to the right and y up, in units of c.
    exterior : array_like (6,)
        (X0, Y0, Z0, omega, phi, kappa).
    faces : sequence of (polygon (k, 3), colour)
        What there is to be seen. Of a polygon that reaches behind the camera, the part
        in front is shown.
    c : float
        Principal distance.
    form : (float, float)
        Width and height of the photo, divided by its principal distance.
    ground : str, optional
        Colour of level ground at Z = 0, below the camera, which reaches to the horizon;
        there the directions are named, if Y points north. What lies on it is drawn
        first. Without it, everything outside the polygons is sky.

    Raises
    ------
    ValueError
        If there is ground, but the camera is not above it.
    """
    exterior = np.asarray(exterior, float)
    M = rotation.matrix(*exterior[3:])
    half = c * np.asarray(form) / 2
    ax.set_facecolor(SKY_COLOR)
    if ground is not None:
        _draw_ground(ax, exterior, M, c, half, ground)
    seen = []
    for polygon, color in faces:
        distance = float(np.linalg.norm(polygon.mean(axis=0) - exterior[:3]))
        if ground is not None and not polygon[:, 2].any():
            distance = np.inf
        in_camera = (polygon - exterior[:3]) @ M.T
        front = cut_polygon(in_camera, -NEAREST - in_camera[:, 2])
        if len(front):
            seen.append((distance, -c * front[:, :2] / front[:, 2:], color))
    seen.sort(key=lambda entry: -entry[0])
    _, polygons, colors = zip(*seen) if seen else ((), (), ())
    look: Look = {"facecolors": colors, "edgecolors": "white"}
    ax.add_collection(PolyCollection(polygons, linewidths=0.4, **look), autolim=False)
    ax.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]))
    ax.set(aspect="equal", xticks=(), yticks=())
    _draw_photo_axes(ax, c)
    for spine in ax.spines.values():
        spine.set(visible=True, linewidth=1.5)
    ax.spines["top"].set_linewidth(4.5)  # the bar of `draw_camera`
    ax.grid(False)


def _draw_ground(
    ax: Axes,
    exterior: np.ndarray,
    M: np.ndarray,
    c: float,
    half: np.ndarray,
    color: str,
) -> None:
    """Fill the photo below the horizon, and write the directions on it."""
    if exterior[2] <= 0:
        raise ValueError(
            "with ground, the camera must be above it, exterior[2] > 0; got"
            f" {exterior[2]}"
        )
    corners = half * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
    land = _below_horizon(M, c, corners)
    ax.add_collection(PolyCollection([land], facecolors=color), autolim=False)
    for name, (x, y) in directions(M, c):
        if abs(x) < 0.92 * half[0] and abs(y) < 0.92 * half[1]:
            ax.text(x, y, name, fontsize=13, ha="center", va="center", zorder=3)


def _draw_photo_axes(ax: Axes, c: float) -> None:
    """Draw the principal point, and x to the right, y up from there."""
    ax.plot(0, 0, "+", color=BLACK, markersize=14, markeredgewidth=2)
    for name, tip, color in zip("xy", 0.16 * c * np.eye(2), AXES):
        arrow = {"arrowstyle": "-|>", "color": color, "linewidth": 2}
        ax.annotate("", tip, (0, 0), arrowprops=arrow | {"shrinkA": 0, "shrinkB": 0})
        x, y = 1.25 * tip
        text = ax.text(x, y, name, color=color, fontsize=13, ha="center", va="center")
        # Legible before trees and houses too
        text.set_path_effects([withStroke(linewidth=3, foreground="white")])


def cut_polygon(polygon: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """The part of a polygon (k, d) on which `inside` (k,), linear on it, is >= 0."""
    kept = []
    for k in range(len(polygon)):
        a, b, at_a, at_b = polygon[k - 1], polygon[k], inside[k - 1], inside[k]
        if (at_a >= 0) != (at_b >= 0):
            kept.append(a + (b - a) * at_a / (at_a - at_b))
        if at_b >= 0:
            kept.append(b)
    return np.array(kept).reshape(-1, polygon.shape[1])


def _below_horizon(M: np.ndarray, c: float, corners: np.ndarray) -> np.ndarray:
    """The part (k, 2) of a photo with corners (4, 2) whose rays point downwards.

    A ray M^T (x, y, -c) below the horizontal meets level ground somewhere, however far;
    one above it never does. The border is a straight line.
    """
    rays = np.column_stack([corners, np.full(len(corners), -c)]) @ M  # row by row
    return cut_polygon(corners, -rays[:, 2])


def directions(M: np.ndarray, c: float) -> list[tuple[str, np.ndarray]]:
    """Names of the directions in front of the camera, and where the photo has them."""
    azimuth = np.radians(45 * np.arange(len(DIRECTIONS)))
    level = np.column_stack([np.sin(azimuth), np.cos(azimuth), np.zeros(len(azimuth))])
    U, V, W = M @ level.T
    found = zip(DIRECTIONS, U, V, W, strict=True)
    return [(name, -c * np.array([u, v]) / w) for name, u, v, w in found if w < -1e-9]


# --- The position of the reader's eye, and the size of a drawing ---


def best_view(centres: np.ndarray, points: np.ndarray) -> tuple[float, float]:
    """Elevation and azimuth that show the object most openly, cameras at its side."""
    horizontal = np.concatenate([centres, points])[:, :2]
    x, y = np.linalg.svd(horizontal - horizontal.mean(axis=0))[2][0]
    side = np.degrees(np.arctan2(-x, y))  # lays the longest extent across the picture
    views = [(ELEVATION, side + turn) for turn in (-35.0, 35.0, 145.0, 215.0)]
    area = []
    for elevation, azimuth in np.radians(views):
        s, c = np.sin(azimuth), np.cos(azimuth)
        up = (-np.sin(elevation) * c, -np.sin(elevation) * s, np.cos(elevation))
        on_paper = np.array([(-s, c, 0.0), up])  # to the right and upwards
        area.append(np.linalg.det(np.cov(on_paper @ points.T)))
    return views[int(np.argmax(area))]


def fill(
    ax: Axes3D, drawn: np.ndarray, where: tuple[float, float, float, float]
) -> None:
    """Fit what was drawn (n, 3) into a rectangle of the figure, as large as possible.

    The rectangle is (left, bottom, width, height) as fractions of the figure.
    """
    ax.set_position(where)
    fit(ax, drawn)
    low, high = _corners(ax, drawn)
    zoom = np.min(where[2:] / (high - low))
    fit(ax, drawn, zoom=zoom)
    low, high = _corners(ax, drawn)
    left, bottom = where[:2] + np.array(where[2:]) / 2 - (low + high) / 2
    ax.set_position((where[0] + left, where[1] + bottom, *where[2:]))


def _corners(ax: Axes3D, drawn: np.ndarray) -> np.ndarray:
    """Lower left and upper right corner of the drawing, as fractions of the figure."""
    ax.apply_aspect()
    x, y, _ = proj3d.proj_transform(*drawn.T, ax.get_proj())
    seen = ax.transData.transform(np.column_stack([x, y]))
    seen = ax.figure.transFigure.inverted().transform(seen)
    return np.array([seen.min(axis=0), seen.max(axis=0)])


# --- A pixel on the ground: the first figure of the workbook ---


def pixel_on_ground(ortho: Orthophoto, height: float = 110.0) -> Figure:
    """Draw a camera at a height (m) above a real orthophoto, and the rays of one pixel.

    The camera and its pixels are drawn far too large, or they could not be seen.
    """
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
