"""Cameras in space: where they stand, and what they see.

Everything is drawn in the units of the object frame. Cameras look along their negative
z axis; `rotation.matrix` turns the object frame into theirs.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.plot import _doors, _ground, _horizon, basic

AXES = (basic.RED, basic.GREEN, basic.BLUE)  # x, y, z
# Drawings may reach beyond their axes, which makes room for large ones
FREE = {"clip_on": False, "in_layout": False}
FORMAT = (1.0, 0.75)  # width and height of a photo over its principal distance
SKY_COLOR = "#DCEBF5"
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
        Place in the figure, as for `Figure.add_subplot`.
    view : (float, float)
        Elevation and azimuth of the reader's eye, in degrees.
    zoom : float
        Factor by which the drawing is enlarged.

    Returns
    -------
    Axes3D
    """
    _validate.instance(fig, Figure, "fig")
    elevation, azimuth = _validate.one_point(view, 2, "view").tolist()
    zoom = _validate.positive_number(zoom, "zoom", "a factor")
    # What is drawn later lies on top: matplotlib's own guess hides cameras
    try:
        ax = fig.add_subplot(where, projection="3d", computed_zorder=False)
    except Exception:  # whatever matplotlib makes of a stranger's object
        raise ValueError(
            f"where must be a place as for add_subplot; got {_validate.shown(where)}"
        ) from None
    ax.set_proj_type("ortho")
    ax.view_init(elev=elevation, azim=azimuth)
    ax.set_box_aspect((1, 1, 1), zoom=zoom)
    ax.set_axis_off()
    ax.patch.set_visible(False)  # it would hide what reaches over from its neighbour
    return ax


def fit(ax: Axes3D, points: ArrayLike, zoom: float = 1.0) -> None:
    """Show all points (..., 3), with one scale on all three axes."""
    _doors.axes_in_space(ax)
    zoom = _validate.positive_number(zoom, "zoom", "a factor")
    points = _validate.points(points, 3, "points").reshape(-1, 3)
    if not len(points):
        raise ValueError("points must be one or more")
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
        Width and height of the photo over its principal distance.

    Returns
    -------
    ndarray (4, 3)
        Lower left, lower right, upper right, upper left corner.
    """
    exterior = _validate.one_point(exterior, 6, "exterior")
    size = _validate.positive_number(size, "size", "object units")
    width, height = _doors.form(form) / 2
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
    color: str = basic.BLACK,
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
        Width and height of the photo over its principal distance.
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
    _doors.axes_in_space(ax)
    exterior = _validate.one_point(exterior, 6, "exterior")
    _doors.colour(color, "color")
    size = _validate.positive_number(size, "size", "object units")
    if not isinstance(name, str):
        raise ValueError(f"name must be a text; got {_validate.shown(name)}")
    axes = _validate.flag(axes, "axes")
    fontsize = _validate.positive_number(fontsize, "fontsize", "points")
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

    Returns
    -------
    ndarray (3, 3)
        The tips.
    """
    _doors.axes_in_space(ax)
    length = _validate.positive_number(length, "length", "object units")
    fontsize = _validate.positive_number(fontsize, "fontsize", "points")
    names = _validate.texts(names, "names", 3)
    M = np.eye(3) if M is None else _validate.of_shape(M, (3, 3), "M")
    origin = _validate.one_point(origin, 3, "origin")
    for row, color, name in zip(M, AXES, names):
        arrow = {"color": color, "linewidth": 2.4, "arrow_length_ratio": 0.22}
        ax.quiver(*origin, *(length * row), zorder=4, **FREE, **arrow)
        tip = origin + 1.18 * length * row
        ax.text(*tip, name, color=color, fontsize=fontsize, ha="center", va="center")
    return origin + length * M


def draw_faces(ax: Axes3D, faces: Faces, alpha: float = 1.0) -> np.ndarray:
    """Draw polygons in space; returns all their corners, for `fit`.

    What lies on the ground, at Z = 0, is drawn first: seen from above it hides nothing.
    """
    _doors.axes_in_space(ax)
    alpha = _validate.number(alpha, "alpha")
    if not 0 <= alpha <= 1:
        raise ValueError(f"alpha must lie between 0 and 1; got {alpha:g}")
    if not (faces := _doors.faces(faces)):
        raise ValueError("faces must be one polygon or more")
    look = {"edgecolors": "white", "linewidths": 0.4, "alpha": alpha, "zorder": 1}
    on_ground = [face for face in faces if not face[0][:, 2].any()]
    for part in (on_ground, [face for face in faces if face[0][:, 2].any()]):
        polygons, colors = zip(*part) if part else ((), ())
        drawn = Poly3DCollection(polygons, facecolors=colors, **look, **FREE)
        ax.add_collection3d(drawn)
    return np.concatenate([polygon for polygon, _ in faces])


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
        Width and height of the photo over its principal distance.
    ground : str, optional
        Colour of level ground at Z = 0, below the camera, which reaches to the horizon;
        there the directions are named, if Y points to the north. What lies on it is
        drawn first. Without it, all that shows no polygon is sky.

    Raises
    ------
    ValueError
        If there is ground, but the camera does not stand above it.
    """
    _doors.axes(ax)
    exterior = _validate.one_point(exterior, 6, "exterior")
    faces = _doors.faces(faces)
    c = _validate.positive_number(c, "c", "units of the axes")
    M = rotation.matrix(*exterior[3:])
    half = c * _doors.form(form) / 2
    ax.set_facecolor(SKY_COLOR)
    if ground is not None:
        _doors.colour(ground, "ground")
        _ground.draw_ground(ax, exterior, M, c, half, ground)
    seen = []
    for polygon, color in faces:
        distance = float(np.linalg.norm(polygon.mean(axis=0) - exterior[:3]))
        if ground is not None and not polygon[:, 2].any():
            distance = np.inf
        in_camera = (polygon - exterior[:3]) @ M.T
        front = _horizon.cut(in_camera, -NEAREST - in_camera[:, 2])
        if len(front):
            seen.append((distance, -c * front[:, :2] / front[:, 2:], color))
    seen.sort(key=lambda entry: -entry[0])
    _, polygons, colors = zip(*seen) if seen else ((), (), ())
    look: basic.Look = {"facecolors": colors, "edgecolors": "white"}
    ax.add_collection(PolyCollection(polygons, linewidths=0.4, **look), autolim=False)
    ax.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]))
    ax.set(aspect="equal", xticks=(), yticks=())
    _ground.draw_photo_axes(ax, c, AXES)
    for spine in ax.spines.values():
        spine.set(visible=True, linewidth=1.5)
    ax.spines["top"].set_linewidth(4.5)  # the bar of `draw_camera`
    ax.grid(False)
