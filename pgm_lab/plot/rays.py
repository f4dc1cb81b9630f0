"""Sketches of rays in space: one, two in a plane, a model that goes to the ground."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import FancyArrowPatch
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.plot import basic, space
from pgm_lab.plot._style import fill
from pgm_lab.plot.basic import Look

CAMERA = np.array([0.0, 0, 3.4, 0.12, -0.1, 0.0])  # of the sketch of one ray
PAIR = np.array([(-1.3, 0, 3.0, 0.1, -0.3, 0), (1.3, 0, 3.2, 0.05, 0.25, 0)])
TEXT = 15
FRONT: Look = {"zorder": 7} | space.FREE
THICK: Look = {"linewidth": 3, "zorder": 5} | space.FREE
HOUSE = np.array(
    [(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 3, 0), (0, 0, 2.5), (4, 0, 2.5)]
    + [(4, 3, 2.5), (0, 3, 2.5), (0, 1.5, 3.8), (4, 1.5, 3.8)]
)
EDGES = (
    *((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (3, 7)),
    *((4, 5), (6, 7), (4, 8), (8, 7), (5, 9), (9, 6), (8, 9)),
)
CONTROL = (0, 1, 2, 8)  # corners whose ground coordinates are known


def one_ray() -> None:
    """Show one collinear ray with all its parts named."""
    fig = plt.figure(figsize=(10, 5.0), layout="none")
    ax = space.space(fig, view=(12, -68))
    M, centre, size = rotation.matrix(*CAMERA[3:]), CAMERA[:3], 1.35
    drawn = [*space.draw_camera(ax, CAMERA, size, axes=False, color=basic.GREY)]
    U, V, W = 1.15, 0.75, -3.1
    steps = centre + np.cumsum([(0, 0, 0), (0, 0, W), (U, 0, 0), (0, V, 0)], 0) @ M
    scale = -size / W
    small = (
        centre
        + np.cumsum([(0, 0, 0), (0, 0, -size), (scale * U, 0, 0), (0, scale * V, 0)], 0)
        @ M
    )
    ax.plot(*np.array([centre, steps[-1]]).T, color=basic.RED, **THICK)
    for corners, colour in ((steps, basic.BLUE), (small, basic.BLACK)):
        ax.plot(*corners.T, color=colour, linewidth=2, linestyle="--", zorder=4)
    ax.plot(*small[-1], "o", color=basic.RED, markersize=9, zorder=6)
    ax.plot(*steps[-1], "s", color=basic.BLUE, markersize=9, zorder=6)
    ax.plot(*small[1], "+", color=basic.BLACK, markersize=14, mew=2.5, zorder=6)
    for at, words, colour, where in (
        (centre, "perspective centre   \n$(X_0, Y_0, Z_0)$  ", basic.BLACK, "right"),
        (
            small[1] + 0.2 * (steps[1] - small[1]),
            "principal point  ",
            basic.BLACK,
            "right",
        ),
        (small[-1], "    image point $(x, y)$", basic.RED, "left"),
        (steps[-1], "  object point $(X, Y, Z)$", basic.BLUE, "left"),
        (centre + 0.74 * (small[1] - centre), " $c$", basic.BLACK, "left"),
        ((small[1] + small[2]) / 2 - (0, 0, 0.3), "$x$", basic.BLACK, "center"),
        ((small[2] + small[3]) / 2 - (0, 0, 0.34), "$y$", basic.BLACK, "center"),
        ((small[1] + steps[1]) / 2, "$W$  ", basic.BLUE, "right"),
        ((steps[1] + steps[2]) / 2 - (0, 0, 0.14), "$U$", basic.BLUE, "center"),
        ((steps[2] + steps[3]) / 2 - (0, 0, 0.08), "  $V$", basic.BLUE, "left"),
    ):
        _write(ax, at, f"{words} " if where == "right" else words, colour, where)
    drawn += [*space.draw_axes(ax, centre, M, 0.9)]
    corner = np.array([-2.0, -0.6, 0.0])
    drawn += [*space.draw_axes(ax, corner, length=0.8, names=("X", "Y", "Z"))]
    fill(ax, np.array([*drawn, *steps]), (0.12, 0.05, 0.6, 0.9))
    basic.show(
        fig,
        "A camera in space and one ray. From the perspective centre the principal"
        " distance c leads along the negative z axis to the principal point of the"
        " image plane; from there x and y lead to the image point. Along the same axis"
        " W, then U and V lead to the object point. Image point and object point lie"
        " on one straight line through the perspective centre.",
    )


def epipolar_plane() -> None:
    """Show two rays, the base between their stations, and the plane of all three."""
    fig = plt.figure(figsize=(10, 4.6), layout="none")
    ax = space.space(fig, view=(18, -72))
    point, drawn = np.array([0.25, 0.5, 0.0]), [np.array([(0.25, 0.5, -0.3)])]
    triangle = np.array([*PAIR[:, :3], point])
    pale: Look = {"facecolors": basic.YELLOW, "alpha": 0.45, "zorder": 0}
    plane = Poly3DCollection([triangle], **pale, **space.FREE)
    ax.add_collection3d(plane)
    for exterior, colour, mark, sign in zip(
        PAIR, (basic.BLUE, basic.RED), ("o", "s"), (-1, 1)
    ):
        look: Look = {"color": colour, "axes": False}
        drawn.append(space.draw_camera(ax, exterior, 1.0, **look))
        ray = np.array([exterior[:3], point])
        ax.plot(*ray.T, color=colour, **THICK)
        M = rotation.matrix(*exterior[3:])
        normal = np.cross(*(triangle[:2] - point)) @ M.T  # of the plane, in the camera
        seen = (point - exterior[:3]) @ M.T
        x = np.array([-0.5, 0.5])
        line = np.column_stack([x, (normal[2] - normal[0] * x) / normal[1], [-1, -1]])
        ax.plot(*(exterior[:3] + line @ M).T, color=colour, ls="--", lw=2.5, **FRONT)
        outside, words, where = (
            (0, "epipolar line    ", "right")
            if sign < 0
            else (1, "  epipolar line", "left")
        )
        _write(ax, (exterior[:3] + line @ M)[outside], words, colour, where)
        image = exterior[:3] + seen / -seen[2] @ M
        ax.plot(*image, mark, color=colour, markersize=9, **FRONT)
        name = "left station" if sign < 0 else "right station"
        _write(ax, exterior[:3] + (0, 0, 0.25), name, colour, "center")
        drawn.append(exterior[None, :3] + (0, 0, 0.4))
    ax.plot(*PAIR[:, :3].T, color=basic.BLACK, **THICK)
    ax.plot(*point, "D", color=basic.BLACK, markersize=9, **FRONT)
    for at, words in (
        (PAIR[:, :3].mean(axis=0) + (0, 0, 0.18), "base"),
        (point - (0, 0, 0.2), "object point"),
        (triangle.mean(axis=0) + (0.05, 0, -0.5), "epipolar\nplane"),
    ):
        _write(ax, at, words, basic.BLACK, "center")
    corner = np.array([-1.9, 0.5, 0.0])
    drawn.append(space.draw_axes(ax, corner, length=0.6, names=("X", "Y", "Z")))
    fill(ax, np.concatenate(drawn), (0.03, 0.03, 0.94, 0.94))
    basic.show(
        fig,
        "Two cameras, the base between their perspective centres, and the two rays of"
        " one object point. Base and rays span a triangle, the epipolar plane. It cuts"
        " each photo in a dashed line, the epipolar line, on which the image of the"
        " point lies.",
    )


def to_the_ground() -> None:
    """Show a model in its own frame, and carried to the ground by a similarity."""
    fig = plt.figure(figsize=(10, 4.2), layout="none")
    turn = rotation.matrix(0.25, 0.3, 0.15)
    places = ((0.0, 0.12, 0.36, 0.66), (0.56, 0.08, 0.42, 0.78))
    both = ((0.45 * HOUSE @ turn, ("x", "y", "z")), (HOUSE, ("X", "Y", "Z")))
    for (house, names), where in zip(both, places):
        ax = space.space(fig, view=(20, -60))
        for edge in EDGES:
            ax.plot(
                *house[list(edge)].T, color=basic.BLUE, linewidth=2.2, clip_on=False
            )
        look: Look = {"color": basic.RED, "markersize": 10} | FRONT
        ax.plot(*house[list(CONTROL)].T, "^", **look)
        origin = np.array([-1.6, -1.2, 0.0])
        tips = space.draw_axes(ax, origin, length=1.5, names=names)
        ground = np.array([(-1.6, -1.2, 0), (5, -1.2, 0), (5, 4, 0), (-1.6, 4, 0)])
        if names[0] == "X":
            pale: Look = {"facecolors": basic.GREEN, "alpha": 0.15, "zorder": 0}
            flat = Poly3DCollection([ground], **pale, **space.FREE)
            ax.add_collection3d(flat)
            house = np.concatenate([house, ground])
        fill(ax, np.array([*house, origin, *tips, *(1.15 * tips)]), where)
    arrow: Look = {"arrowstyle": "-|>", "lw": 3, "color": basic.BLACK}
    fig.text(0.18, 0.9, "model, in a frame of its own", fontsize=TEXT, ha="center")
    fig.text(0.77, 0.9, "ground", fontsize=TEXT, ha="center")
    plt.figtext(
        0.46, 0.58, "scale $s$, turn $R$,\nshift $T$", fontsize=TEXT, ha="center"
    )
    fig.add_artist(
        FancyArrowPatch((0.38, 0.5), (0.55, 0.5), mutation_scale=25, **arrow)
    )
    fig.text(0.5, 0.02, "▲ control points", color=basic.RED, fontsize=TEXT, ha="center")
    basic.show(
        fig,
        "Left a small house, turned, in a frame x, y, z of its own: the model. Right"
        " the same house, larger and upright on the ground in the frame X, Y, Z. An"
        " arrow between them says scale, turn and shift. Red triangles mark corners"
        " that are known in both frames.",
    )


def meeting(exteriors: ArrayLike, points: ArrayLike, names: Sequence[str]) -> None:
    """Show photos and points in space, with a ray from each photo to each point.

    Parameters
    ----------
    exteriors : array_like (2, 6)
        X0, Y0, Z0, omega, phi, kappa of the photos; angles in radians.
    points : array_like (n, 3)
        Object points.
    names : sequence of str
        One for each photo.
    """
    photos = _validate.of_shape(exteriors, (2, 6), "exteriors")
    points = _validate.points(points, 3, "points").reshape(-1, 3)
    names = _validate.texts(names, "names", 2)
    fig = plt.figure(figsize=(10, 4.2), layout="none")
    ax = space.space(fig, view=(14, 38))
    drawn = [points]
    styles = ((basic.BLUE, "-"), (basic.RED, "--"))
    for exterior, (colour, style), name in zip(photos, styles, names):
        for point in points:
            ray = np.array([exterior[:3], point])
            ax.plot(*ray.T, color=colour, lw=1.1, ls=style, **FRONT)
        look: Look = {"form": (1.27, 0.85), "color": colour, "axes": False}
        drawn.append(space.draw_camera(ax, exterior, 0.55, name=name, **look))
        up = rotation.matrix(*exterior[3:])[2]
        drawn.append(exterior[None, :3] + 0.3 * up)  # room for the name
    ax.plot(*points.T, "o", color=basic.BLACK, markersize=7, **FRONT)
    # To the lower left of the points, as this view has it
    corner = points.mean(axis=0) + np.ptp(points, axis=0).max() * np.array([0.6, -1, 0])
    tips = space.draw_axes(ax, corner, length=0.5, names=("X", "Y", "Z"))
    drawn += [corner + 1.5 * (tips - corner), corner - (0, 0, 0.15) + 0 * tips]
    fill(ax, np.concatenate(drawn), (0.03, 0.07, 0.94, 0.88))
    basic.show(
        fig,
        f"Two cameras in space look down at {len(points)} points; a ray runs from each"
        " camera to each point. A thick bar marks the upper edge of each photo.",
    )


def _write(ax: Axes3D, at: ArrayLike, words: str, colour: str, where: str) -> None:
    look: Look = {"fontsize": TEXT, "color": colour, "zorder": 9}
    ax.text(*np.asarray(at), words, ha=where, va="center", **look)
