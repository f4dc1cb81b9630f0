"""A network of photos in space: its cameras, points and precision, its free motions."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import ArrayLike

from pgm_lab import _validate, bundle
from pgm_lab._rounding import round_number
from pgm_lab.plot import _doors, basic, space
from pgm_lab.plot._style import best_view, fill, screen, together
from pgm_lab.plot.basic import Look

MOTIONS = (
    *(f"shift in {axis}" for axis in "XYZ"),
    *(f"rotation about {axis}" for axis in "XYZ"),
    "scale",
)


def seven_motions(
    exteriors: ArrayLike,
    points: ArrayLike,
    view: tuple[float, float] | None = None,
    size: float | None = None,
) -> Figure:
    """Draw the seven ways to move a whole network that no photo notices.

    Grey is the network as it stands, arrows lead cameras and points along each of the
    seven columns of G; their lengths compare within a panel only.

    Parameters
    ----------
    exteriors : array_like (m, 6)
        (X0, Y0, Z0, omega, phi, kappa).
    points : array_like (n, 3)
        Object points.
    view : (float, float), optional
        Elevation and azimuth of the reader's eye, in degrees; if missing, from
        where the object is seen most openly, with the cameras at its side.
    size : float, optional
        Length of the cameras drawn, in object units.

    Returns
    -------
    matplotlib.figure.Figure
    """
    exteriors, points = _network(exteriors, points)
    view = _doors.view(view)
    if not len(exteriors) or not len(points):
        raise ValueError("exteriors and points must be one or more")
    if size is not None:
        size = _validate.positive_number(size, "size", "object units")
    if len(points) < 2:
        raise ValueError("points must be two or more, to be seen in space")
    positions = np.concatenate([exteriors[:, :3], points])
    reach = np.ptp(positions, axis=0).max()
    size = 0.13 * reach if size is None else size
    fig = plt.figure(figsize=(13, 6.8), layout="none")
    m = len(exteriors)
    # About the middle between cameras and object, or one of them would hardly move
    centre = (positions[:m].mean(axis=0) + points.mean(axis=0)) / 2
    everything = bundle.motions(positions, centre)
    lengths = np.linalg.norm(everything, axis=2).max(axis=1)
    steps = 0.24 * reach * everything / lengths[:, None, None]
    room = np.concatenate([positions, *(positions + steps)])
    view = best_view(exteriors[:, :3], points) if view is None else view
    for number, (name, step) in enumerate(zip(MOTIONS, steps)):
        # Shifts above, rotations below, the scale at their right in the middle
        row, column = divmod(number, 3) if number < 6 else (0.5, 3)
        where = (0.245 * column, 0.5 - 0.5 * row, 0.26, 0.44)
        ax = space.space(fig, view=view)
        look: Look = {"axes": False, "color": basic.GREY}
        for exterior in exteriors:
            space.draw_camera(ax, exterior, size, **look)
        ax.plot(*points.T, "o", color=basic.GREY, markersize=3.5, **space.FREE)
        some = slice(m, None, -(-len(points) // 12))  # a dozen of the points is enough
        for at, color, wide in ((some, basic.BLUE, 2.0), (slice(m), basic.RED, 3.2)):
            arrows: Look = {"linewidth": wide, "arrow_length_ratio": 0.3, "zorder": 5}
            arrows |= space.FREE | {"color": color}
            ax.quiver(*positions[at].T, *step[at].T, **arrows)
        fill(ax, room, where)
        fig.text(where[0] + 0.13, where[1] + 0.45, name, fontsize=20, ha="center")
    ax = space.space(fig, view=view)
    tips = space.draw_axes(ax, (0, 0, 0), names=("X", "Y", "Z"), fontsize=18)
    for drawn in (*ax.collections, *ax.texts):
        drawn.set_color(basic.BLACK)  # orange and blue are cameras and points here
    fill(ax, 1.3 * np.vstack([np.zeros(3), tips]), (0.81, 0.78, 0.11, 0.18))
    for y, word, color in ((0.16, "cameras", basic.RED), (0.1, "points", basic.BLUE)):
        fig.text(0.865, y, word, fontsize=19, color=color, ha="center")
    return fig


def network_3d(
    exteriors: ArrayLike,
    points: ArrayLike,
    covariance_points: ArrayLike | None = None,
    factor: float | None = None,
    *,
    names: bool = True,
    view: tuple[float, float] | None = None,
    size: float | None = None,
    unit: str = "mm",
) -> Figure:
    """Draw cameras and points, and how precisely the points are known.

    Parameters
    ----------
    exteriors : array_like (m, 6)
        (X0, Y0, Z0, omega, phi, kappa); without any, shape (0, 6), the points fill the
        picture.
    points : array_like (n, 3)
        Object points.
    covariance_points : array_like (n, 3, 3), optional
        Covariance of each point; then standard ellipsoids are drawn, whose half axes
        are one standard deviation.
    factor : float, optional
        How many times too large the ellipsoids are; a round number if missing.
    names : bool
        Number the cameras; those at one place share a label.
    view : (float, float), optional
        Elevation and azimuth of the reader's eye, in degrees; if missing, from
        where the object is seen most openly, with the cameras at its side.
    size : float, optional
        Length of the cameras drawn, in object units.
    unit : str
        Unit of the object frame.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the shapes do not fit.
    """
    names = _validate.flag(names, "names")
    view = _doors.view(view)
    _validate.text(unit, "unit")
    if size is not None:
        size = _validate.positive_number(size, "size", "object units")
    if factor is not None:
        factor = _validate.positive_number(factor, "factor", "of the ellipsoids")
    exteriors, points = _network(exteriors, points)
    if covariance_points is not None:
        shape = len(points), 3, 3
        C = _validate.of_shape(covariance_points, shape, "covariance_points")
        _refuse_no_covariance(C, "covariance_points")
    positions = np.concatenate([exteriors[:, :3], points])
    reach = np.ptp(positions, axis=0).max()
    size = 0.1 * reach if size is None else size
    fig = plt.figure(figsize=(11, 7.4), layout="none")
    view = best_view(exteriors[:, :3], points) if view is None else view
    ax = space.space(fig, view=view)
    drawn = [points]
    for exterior, name in zip(exteriors, together(exteriors[:, :3], 0.4 * size)):
        look: Look = {"axes": False, "color": basic.BLUE}
        drawn.append(space.draw_camera(ax, exterior, size, **look))
        to_the_right = drawn[-1].mean(axis=0) - exterior[:3]
        if names and name:
            side = "right" if screen(view)[0] @ to_the_right > 0 else "left"
            text: Look = {"color": basic.BLUE, "fontsize": 20, "zorder": 9}
            text |= {"ha": side, "va": "center"}
            text["path_effects"] = [withStroke(linewidth=4, foreground="white")]
            ax.text(*exterior[:3], f"  {name}  ", **text)
    ax.plot(*points.T, "o", color=basic.BLACK, markersize=3.5, **space.FREE)
    title = (
        f"{len(exteriors)} photos, " * bool(len(exteriors)) + f"{len(points)} points"
    )
    if covariance_points is not None:
        longest = np.sqrt(np.linalg.eigvalsh(C)[:, -1])
        if factor is None:
            factor = round_number(0.06 * reach / longest.max())
        drawn.append(_ellipsoids(ax, points, C, factor))
        title += f"; standard ellipsoids {factor:,g} times too large"
    drawn.append(_scale_bar(ax, np.concatenate(drawn), unit))
    fill(ax, np.concatenate(drawn), (0.08, 0.04, 0.87, 0.86))
    fig.suptitle(title, fontsize=18)
    return fig


def ellipsoids(
    positions: np.ndarray, covariances: np.ndarray, factor: float = 1.0, n: int = 13
) -> np.ndarray:
    """Surfaces of standard ellipsoids as meshes.

    Parameters
    ----------
    positions : ndarray (k, 3)
    covariances : ndarray (k, 3, 3)
    factor : float
        By which they are enlarged.
    n : int
        Circles of latitude; twice as many of longitude.

    Returns
    -------
    ndarray (k, n, 2 n, 3)
    """
    positions = _validate.of_shape(positions, (None, 3), "positions")
    shape = len(positions), 3, 3
    covariances = _validate.of_shape(covariances, shape, "covariances")
    _refuse_no_covariance(covariances, "covariances")
    factor = _validate.positive_number(factor, "factor", "of the ellipsoids")
    n = _validate.whole(n, "n", 2, 1000)
    _validate.size("n", len(positions), n, 2 * n, 3)
    latitude = np.linspace(-np.pi / 2, np.pi / 2, n)[:, None]
    longitude = np.linspace(0, 2 * np.pi, 2 * n)[None]
    sphere = np.stack(
        np.broadcast_arrays(
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ),
        axis=-1,
    )
    variance, axes = np.linalg.eigh(covariances)
    root = axes * np.sqrt(np.maximum(variance, 0))[:, None, :]  # root root' = C
    offset = np.einsum("kij,abj->kabi", root, sphere)
    return positions[:, None, None] + factor * offset


def _ellipsoids(
    ax: Axes3D, positions: np.ndarray, covariances: np.ndarray, factor: float
) -> np.ndarray:
    mesh = ellipsoids(positions, covariances, factor)
    corners = [mesh[:, :-1, :-1], mesh[:, :-1, 1:], mesh[:, 1:, 1:], mesh[:, 1:, :-1]]
    faces = np.stack(corners, axis=3).reshape(-1, 4, 3)
    normal = np.cross(faces[:, 2] - faces[:, 0], faces[:, 3] - faces[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # Light comes from the reader, a little from above
    right, up = screen((ax.elev, ax.azim))
    light = np.abs(normal @ (np.cross(right, up) + 0.5 * up)) / np.hypot(1, 0.5)
    colors = (0.35 + 0.65 * light[:, None]) * to_rgb(basic.ORANGE)
    look = {"facecolors": colors, "edgecolors": colors, "linewidths": 0.2}
    ax.add_collection3d(Poly3DCollection(faces, zorder=4, **look, **space.FREE))
    return mesh.reshape(-1, 3)


def _scale_bar(ax: Axes3D, drawn: np.ndarray, unit: str) -> np.ndarray:
    """Draw the three axes of a round length at the lower left of what was drawn."""
    right, up = screen((ax.elev, ax.azim))
    middle = drawn.mean(axis=0)
    across, height = (drawn - middle) @ right, (drawn - middle) @ up
    length = round_number(0.3 * np.ptp(drawn, axis=0).max())
    origin = middle + (across.min() - 0.4 * length) * right + height.min() * up
    lines = np.stack([np.tile(origin, (3, 1)), origin + length * np.eye(3)], axis=1)
    look = {"linewidths": 3, "colors": space.AXES, "zorder": 2}
    ax.add_collection3d(Line3DCollection(lines, **look, **space.FREE))
    for axis, name, color in zip(np.eye(3), "XYZ", space.AXES):
        text = {"color": color, "fontsize": 18, "ha": "center", "va": "center"}
        ax.text(*(origin + 1.13 * length * axis), name, **text)
    above = origin + 0.5 * length * np.eye(3)[2]
    ax.text(*above, f"{length:g} {unit}  ", fontsize=16, ha="right", va="center")
    return lines.reshape(-1, 3)


def _network(exteriors: ArrayLike, points: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    exteriors = _validate.points(exteriors, 6, "exteriors").reshape(-1, 6)
    return exteriors, _validate.points(points, 3, "points").reshape(-1, 3)


def _refuse_no_covariance(C: np.ndarray, name: str) -> None:
    """Refuse matrices that are not symmetric or have no positive variance."""
    _validate.refuse(
        np.any(np.abs(C - C.swapaxes(1, 2)) > 1e-9 * np.abs(C).max(initial=0), (1, 2)),
        name + "{} is not symmetric, as each covariance is",
    )
    _validate.refuse(
        np.linalg.eigvalsh(C)[:, -1] <= 0,
        name + "{} is no covariance: it has no positive variance",
    )
