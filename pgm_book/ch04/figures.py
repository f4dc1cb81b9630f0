"""Cameras above a meadow and around a field of targets, and what they see."""

from collections.abc import Mapping
from typing import cast

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_lab import plot, rotation
from pgm_lab.plot import space
from pgm_lab.plot.basic import Look, interact

Face = tuple[np.ndarray, str]  # a polygon (k, 3) and its colour
PLACE = (0.0, 0.0, 8.0)  # of the cameras above the meadow, in metres
NORTH_EAST_DOWN = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])  # of E, N, up
SCALE = "X east, Y north, Z up: arrows of 3 m."
PLACES = {  # where numbers stand beside the nine cameras of 2013, mm
    "1, 2": (0, -60, 105),
    "3, 4, 5": (0, 0, 160),
    "6": (0, 0, 95),
    "7": (0, -20, 110),
    "8, 9": (0, 70, -105),
}


def one_camera() -> None:
    """Show a camera above a meadow with its parts named, and the photo it takes."""
    look = rotation.from_tilt_azimuth_swing(*np.radians([55, 28, 175]))
    exterior = np.array([-3.0, -8.0, 6.0, *rotation.angles(look)])
    fig = _beside(exterior, "camera and object space", (24, -62))
    ax = cast(Axes3D, fig.axes[0])
    text: Look = {"fontsize": 16, "ha": "center", "va": "center"}
    ax.text(*(exterior[:3] + (6.6, 3.4, 2.2)), "perspective\ncentre (black)", **text)
    ax.text(*(exterior[:3] + (6.4, 3.3, -0.1)), "photo (grey)", **text)
    plot.show(
        fig,
        "Left: a camera with its perspective centre, its photo and its axes x, y, z"
        " above a meadow with a house, two trees and, on the grass, an arrow to the"
        f" north with the letter N. {SCALE} Right: the photo that it takes, with its"
        " axes x to the right and y up from the principal point.",
        colours=128,
    )


def two_views(attitudes: np.ndarray, names: list[str]) -> None:
    """Show cameras 8 m above the meadow in a row, and below each what it sees."""
    fig = plt.figure(figsize=(7, 5.4), layout="none")
    look: Look = {"height_ratios": (1.2, 1), "hspace": 0.0, "wspace": 0.06}
    look |= {"left": 0.02, "right": 0.98, "bottom": 0.08, "top": 0.88}
    grid = fig.add_gridspec(2, len(names), **look)
    said = []
    for column, (attitude, name) in enumerate(zip(attitudes, names)):
        exterior = np.array([*PLACE, *np.radians(attitude)])
        ax = space.space(fig, grid[0, column], view=(25, -60))
        ax.set_title(name, loc="center", y=0.99)
        _meadow(ax, exterior, 2.4)
        space.fit(ax, [(-6, -6, 0), (6, 6, 10)], 1.35)
        below = fig.add_subplot(grid[1, column])
        _photo(below, exterior, _country())
        for text in below.texts:  # not under the cross and the axes
            if text.get_text() in {*"NESW"} and np.hypot(*text.get_position()) < 0.05:
                text.set_position((-0.12, -0.1))
        said.append(f"{name}: {_north(exterior)}".replace("\n", " "))
    fig.text(0.5, 0.015, SCALE, ha="center", fontsize=16)
    alt = "Cameras 8 m above the meadow, and below them what they see. "
    M = rotation.matrix(*np.radians(attitudes).T)
    if len(M) > 1 and np.allclose(M, M[0], rtol=0, atol=1e-12):
        said.append("all cameras and all photos are the same")
    plot.show(fig, alt + "; ".join(said) + ".", colours=128)


def two_orders(omega: float, phi: float, kappa: float) -> None:
    """Show two cameras rotated by the same three angles in opposite order."""
    degrees = np.diag([omega, phi, kappa])
    one, two, three = (rotation.matrix(*row) for row in np.radians(degrees))
    pair = [three @ two @ one, one @ two @ three]
    names = [
        f"ω = {omega:g}°, then\nφ = {phi:g}°, then κ = {kappa:g}°",
        f"κ = {kappa:g}°, then\nφ = {phi:g}°, then ω = {omega:g}°",
    ]
    two_views(np.degrees(rotation.angles(pair)), names)
    apart = np.degrees(rotation.angle_between(*pair))
    look = np.degrees(np.arccos(min(pair[0][2] @ pair[1][2], 1.0)))
    print(f"A rotation by {apart:.1f}° leads from one camera to the other;")
    print(f"their lines of sight are {look:.1f}° apart.")


def mirror() -> None:
    """Show what a camera would see whose x axis is reversed, beside a real one."""
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.5), layout="constrained")
    exterior = np.array([*PLACE, 0, 0, 0])
    for ax, sign, name in zip(axes, (1, -1), ("diag(1, 1, 1)", "diag(−1, 1, 1)")):
        faces = [(polygon * (sign, 1, 1), color) for polygon, color in _country()]
        _photo(ax, exterior, faces)
        ax.set_title(f"M = {name}", loc="center")
    plot.show(
        fig,
        "Two photos of the meadow from above. In the first the letter N reads as it"
        " should; in the second everything is exchanged left for right, and the N is"
        " written backwards.",
        colours=128,
    )


def attitude_by_hand() -> None:
    """Show a camera above the meadow, and sliders that rotate it."""
    import ipywidgets

    def draw(omega: int, phi: int, kappa: int) -> None:
        exterior = np.array([*PLACE, *np.radians([omega, phi, kappa])])
        name = f"ω = {omega}°, φ = {phi}°, κ = {kappa}°".replace("-", "−")
        fig = _beside(exterior, name)
        plot.show(
            fig,
            f"A camera 8 m above the meadow, {name}, and its photo, in which"
            f" {_north(exterior)}.",
            dpi=80,
            colours=128,
        )

    def slider(name: str, most: int) -> ipywidgets.IntSlider:
        look: Look = {"description": f"{name} (°)", "continuous_update": False}
        return ipywidgets.IntSlider(0, -most, most, 5, **look)

    interact(draw, omega=slider("ω", 90), phi=slider("φ", 90), kappa=slider("κ", 180))


def around_camera(points: np.ndarray, cameras: Mapping[str, np.ndarray]) -> None:
    """Show nine cameras around targets; red ones look elsewhere than the first set."""
    first = rotation.matrix(*next(iter(cameras.values()))[:, 3:].T)
    fig = plt.figure(figsize=(7, 4.6), layout="none")
    said = []
    for column, (name, exteriors) in enumerate(cameras.items()):
        ax = space.space(fig, fig.add_gridspec(1, len(cameras))[column], view=(20, 20))
        ax.set_position((column / len(cameras), 0.12, 1 / len(cameras), 0.8))
        ax.set_title(name, loc="center", y=1.0)
        ax.plot(*points.T, "o", color=plot.BLACK, markersize=3.5)
        ax.text(-20, 1560, 330, "targets", fontsize=15, ha="center")
        space.draw_axes(ax, (0, 1000, -1000), None, 350, ("X", "Y", "Z"), 15)
        other = rotation.matrix(*exteriors[:, 3:].T)
        off = np.degrees(rotation.angle_between(other, first)) > 1
        for camera, wrong in zip(exteriors, off):
            color = plot.RED if wrong else plot.BLUE
            space.draw_camera(ax, camera, 200, color=color, axes=False)
        for tag, beside in PLACES.items():
            at = exteriors[int(tag[0]) - 1, :3] + beside
            ax.text(*at, tag, fontsize=14, ha="center", va="center")
        space.fit(ax, [(0, -150, -1000), (300, 1900, 620)], zoom=1.2)
        wrong_ones = ", ".join(str(k + 1) for k in np.flatnonzero(off)) or "none"
        others = f": rotated against the first set: {wrong_ones}"
        said.append(name + (others if len(cameras) > 1 else ""))
    scale = "The axes X, Y, Z are 350 mm long."
    key = "\nBlue: as in the first picture; red: rotated." if len(cameras) > 1 else ""
    fig.text(0.5, 0.01, scale + key, ha="center", fontsize=15)
    plot.show(
        fig,
        "Muliawan's nine cameras around a field of fifty targets. "
        + ". ".join(said)
        + ". The axes X, Y, Z are 350 mm long.",
    )


def _beside(
    exterior: np.ndarray, name: str, view: tuple[float, float] = (25, -60)
) -> Figure:
    """A camera above the meadow, and beside it what it sees."""
    fig = plt.figure(figsize=(10, 4.6), layout="none")
    look: Look = {"width_ratios": (1.25, 1), "left": 0.01, "right": 0.98}
    grid = fig.add_gridspec(1, 2, **look, bottom=0.06, top=0.88)
    ax = space.space(fig, grid[0, 0], view=view)
    _meadow(ax, exterior, 3.0)
    space.fit(ax, [(-6, -7, -1), (6, 6, 10)], zoom=1.3)
    right = fig.add_subplot(grid[0, 1])
    _photo(right, exterior, _country())
    right.set_title("what it sees")
    ax.set_title(name, loc="center", y=1.0)
    fig.text(0.02, 0.02, SCALE, fontsize=16)
    return fig


def _meadow(ax: Axes3D, exterior: np.ndarray, size: float) -> None:
    """The meadow and a camera, and at a corner the axes of object space."""
    space.draw_faces(ax, village())
    space.draw_axes(ax, (-6, -6, 0), None, 3, ("X", "Y", "Z"), 16)
    space.draw_camera(ax, exterior, size)
    for text in ax.texts:
        text.set_fontsize(16)


def _photo(ax: Axes, exterior: np.ndarray, faces: list[Face]) -> None:
    """What the camera sees, with names that are read from the back row."""
    space.draw_photo(ax, exterior, faces, ground=GROUND)
    for text in ax.texts:
        text.set_fontsize(16)


def _country() -> list[Face]:
    """All that a photo can show, to the horizon."""
    return surroundings() + village()


def _north(exterior: np.ndarray) -> str:
    """Where the arrow on the grass points in the photo, in words."""
    arrow = np.array([(-1.9, 1.2, 0.0), (-1.9, 2.6, 0.0)])
    in_camera = (arrow - exterior[:3]) @ rotation.matrix(*exterior[3:]).T
    if np.any(in_camera[:, 2] > -1e-3):
        return "the arrow to the north is out of sight"
    x, y = (-in_camera[:, :2] / in_camera[:, 2:]).T
    if abs(x[0]) > 0.5 or abs(y[0]) > 0.375:  # its foot
        return "the arrow to the north is out of sight"
    turn = np.degrees(np.arctan2(x[1] - x[0], y[1] - y[0]))
    if abs(turn) < 0.5:
        return "the arrow to the north points up"
    side = "to the right" if turn > 0 else "to the left"
    return f"the arrow to the north points {abs(turn):.0f} degrees {side} of up"


# --- A meadow with a house and two trees, for a rotated camera to photograph ---

GROUND = "#D3E3C2"  # of the fields around the meadow, to the horizon


def village() -> list[Face]:
    """Polygons of a meadow 12 m x 12 m with a house and two trees, Y to the north.

    No symmetry hides a wrong rotation: the house stands in the south-west, a tall tree
    in the north-east, a small one in the south-east; a road runs west to east, and in
    the north-west an arrow and the letter N are painted on the grass.
    """
    faces = []
    for column in range(-6, 6):
        for row in range(-6, 6):
            tile = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
            green = "#C9DDB5" if (row + column) % 2 else "#DCE9CE"
            color = "#CFCFCF" if row == 0 else green
            faces.append((tile + (column, row, 0), color))
    faces += _north_arrow((-2.2, 1.2))
    faces += _house(np.array([-2.6, -2.4, 0.0]), np.array([1.8, 1.3, 1.0]))
    faces += _tree((2.0, 2.4), 0.8, 2.4)
    faces += _tree((2.4, -2.2), 0.5, 1.2)
    return faces


def surroundings() -> list[Face]:
    """Fields of 12 m x 12 m around the meadow, and the road that goes on, for a photo.

    They give the ground a scale and a direction as far as the eye can tell. In a
    drawing in space they would leave no room.
    """
    reach = 12  # fields to each side
    field = 12.0 * np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]) - (6, 6, 0)
    places = range(-reach, reach + 1)
    dark = [(i, j) for i in places for j in places if (i + j) % 2]
    faces = [(field + (12 * i, 12 * j, 0), "#C6D8B2") for i, j in dark]
    far = 12.0 * reach + 6
    for west, east in ((-far, -6), (6, far)):
        road = [(west, 0, 0), (east, 0, 0), (east, 1, 0), (west, 1, 0)]
        faces.append((np.array(road), "#CFCFCF"))
    return faces


def _north_arrow(corner: tuple[float, float]) -> list[Face]:
    """An arrow to the north, 1.4 m long, and an N beside it, just above the grass."""
    arrow = [(0.2, 0), (0.35, 0), (0.35, 0.8), (0.55, 0.8), (0.275, 1.4)]
    arrow += [(0, 0.8), (0.2, 0.8)]
    stem = np.array([(0, 0), (0.15, 0), (0.15, 0.8), (0, 0.8)])
    diagonal = [(0, 0.8), (0.45, 0), (0.6, 0), (0.15, 0.8)]
    parts = [arrow, *(stem + (x, 0) for x in (0.75, 1.2)), np.add(diagonal, (0.75, 0))]
    flat = [np.column_stack([np.add(p, corner), np.full(len(p), 0.01)]) for p in parts]
    return [(polygon, plot.BLACK) for polygon in flat]


def _house(corner: np.ndarray, size: np.ndarray) -> list[Face]:
    base = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    low = corner + np.column_stack([base, np.zeros(4)]) * size
    high = corner + np.column_stack([base, np.ones(4)]) * size
    # The ridge runs along x, half the width of the house above the eaves
    ridge = corner + np.array([(0, 0.5, 1), (1, 0.5, 1)]) * size + (0, 0, size[1] / 2)
    walls = [(low[[i, j]], high[[j, i]]) for i, j in ((0, 1), (1, 2), (2, 3), (3, 0))]
    shades = ("#F0DFC0", "#DCC79F", "#F0DFC0", "#DCC79F")
    faces = [(np.concatenate(w), shade) for w, shade in zip(walls, shades)]
    faces += [(np.array([high[1], high[2], ridge[1]]), "#DCC79F")]
    faces += [(np.array([high[3], high[0], ridge[0]]), "#DCC79F")]
    faces += [(np.array([high[0], high[1], ridge[1], ridge[0]]), plot.RED)]
    faces += [(np.array([high[2], high[3], ridge[0], ridge[1]]), "#A84A00")]
    return faces


def _tree(place: tuple[float, float], radius: float, height: float) -> list[Face]:
    turn = np.linspace(0, 2 * np.pi, 9)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(9)])
    rim = np.array([*place, 0.2 * height]) + radius * circle
    top = np.array([*place, height])
    shades = ("#00805F", "#009E73", "#2CB48C", "#009E73")
    return [(np.array([rim[i], rim[i + 1], top]), shades[i // 2]) for i in range(8)]


# --- Sketches of rotated frames: one turn in the plane, three in space, quadrants ---

WORDS: Look = {"fontsize": 18}
KAPPA = np.radians(30.0)  # of the sketch in the plane
TURNS = (  # Greek letter, axis, from which axis to which, colour
    ("ω", "x", "Y", "Z", plot.RED),
    ("φ", "y", "Z", "X", plot.GREEN),
    ("κ", "z", "X", "Y", plot.BLUE),
)


def plane_rotation() -> None:
    """Show a frame rotated in the plane, one point in both, and the first new axis."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.7), layout="constrained")
    ex = np.array([np.cos(KAPPA), np.sin(KAPPA)])
    ey = np.array([-ex[1], ex[0]])
    P = np.array([1.25, 1.3])
    for ax, size in ((left, 1.75), (right, 1.2)):
        _arrow(ax, (size, 0), "$X$", "0.35", "--")
        _arrow(ax, (0, size), "$Y$", "0.35", "--")
        _arc(ax, 0.0, 30.0, 0.85 if ax is left else 0.45, "κ")
    _arrow(left, 1.75 * ex, "$x$", plot.RED)
    _arrow(left, 1.75 * ey, "$y$", plot.BLUE)
    for foot, color, line in (
        ((P[0], 0), "0.35", "--"),
        ((0, P[1]), "0.35", "--"),
        ((P @ ex) * ex, plot.RED, "-"),
        ((P @ ey) * ey, plot.BLUE, "-"),
    ):
        left.plot(*np.transpose([P, foot]), color=color, ls=line, lw=1.8)
        left.plot(*foot, "o", color=color, ms=7)
    left.plot(*P, "o", color=plot.BLACK, ms=11)
    left.annotate("$P$", P, (8, 4), textcoords="offset points", **WORDS)
    left.set_title("one point, two frames")
    _arrow(right, ex, "$e_x$", plot.RED)
    _arrow(right, ey, "$e_y$", plot.BLUE)
    right.add_patch(Arc((0, 0), 2, 2, theta1=-5, theta2=140, color="0.6", ls=":"))
    right.plot((ex[0], ex[0]), (0, ex[1]), color=plot.RED, lw=2, ls="-.")
    right.plot((0, ex[0]), (-0.05, -0.05), color=plot.RED, lw=2, ls="-.")
    right.text(ex[0] / 2 + 0.05, -0.19, "cos κ", ha="center", **WORDS)
    free: Look = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    right.text(ex[0] + 0.04, 0.2, "sin κ", va="center", bbox=free, **WORDS)
    right.set_title("new axes of length 1, in the old frame")
    left.set(xlim=(-1.15, 2.05), ylim=(-0.25, 2.05))
    right.set(xlim=(-0.75, 1.45), ylim=(-0.25, 1.5))
    for ax in (left, right):
        ax.set_aspect("equal")
        ax.axis("off")
    plot.show(
        fig,
        "Left, a frame X, Y and a frame x, y of the same origin, rotated by kappa"
        " counter-clockwise; from the point P perpendiculars fall on all four axes."
        " Right, the new axes as arrows e_x and e_y of length 1; e_x reaches cos kappa"
        " along X and sin kappa along Y, e_y stands at a right angle to it.",
    )


def three_rotations() -> None:
    """Show one turn at a time in space: about x, about y, about z."""
    angle = np.radians(25)
    fig = plt.figure(figsize=(10, 3.9), layout="none")
    for column, (letter, axis, start, end, color) in enumerate(TURNS):
        ax = space.space(fig, fig.add_gridspec(1, 3)[column], view=(32, 40))
        ax.set_position((column / 3, 0.0, 1 / 3, 0.8))
        turned = rotation.matrix(*(angle * np.eye(3)[column]))
        _old_axes(ax, column)
        space.draw_axes(ax, (0, 0, 0), turned, 1.0, ("x", "y", "z"), 17)
        t = np.linspace(0, angle, 30)
        first, second = np.eye(3)[(column + 1) % 3], np.eye(3)[(column + 2) % 3]
        arc = 0.72 * (np.outer(np.cos(t), first) + np.outer(np.sin(t), second))
        ax.plot(*arc.T, color=plot.BLACK, lw=2.5, clip_on=False)
        tip = {"arrow_length_ratio": 1.0, "lw": 2.5, "color": plot.BLACK}
        ax.quiver(*arc[-8], *(arc[-1] - arc[-8]), clip_on=False, **tip)
        at = 0.5 * (np.cos(angle / 2) * first + np.sin(angle / 2) * second)
        ax.text(*at, letter, fontsize=19, ha="center", va="center")
        space.fit(ax, [(-0.35, -0.35, -0.25), (1.15, 1.15, 1.2)], zoom=1.08)
        name = f"{letter} about {axis}:\nfrom {start} towards {end}"
        ax.set_title(name, loc="center", y=1.07, color=color)
    plot.show(
        fig,
        "Three frames, each rotated by 25 degrees about one of its axes. Omega"
        " rotates about x, from Y towards Z; phi about y, from Z towards X; kappa about"
        " z, from X towards Y. All axes have length 1.",
    )


def quadrant(degrees: float) -> None:
    """Show two directions of one tangent on the circle, and what arctan returns."""
    answer = float(np.degrees(np.arctan(np.tan(np.radians(degrees)))))
    fig, ax = plt.subplots(figsize=(7, 4.6), layout="constrained")
    ax.add_patch(Arc((0, 0), 2, 2, color="0.6"))
    ax.fill_between((0, 1.15), -1.15, 1.15, color="0.92", linewidth=0, zorder=0)
    middle: Look = {"fontsize": 16, "ha": "center", "va": "center"}
    ax.text(0.47, 0.4, "all that\narctan\nreturns", **middle)
    for value, color, line in ((degrees, plot.BLUE, "-"), (answer, plot.RED, "--")):
        x, y = np.cos(np.radians(value)), np.sin(np.radians(value))
        ax.plot((0, x), (0, y), color=color, ls=line, lw=4)
        ax.plot(x, y, "o", color=color, ms=11)
        text = f"{value:.0f}°".replace("-", "−")
        centred: Look = {"ha": "center", "va": "center", "color": color}
        ax.text(1.32 * x, 1.13 * y, text, **centred, **WORDS)
    ax.axhline(0, color="0.4", lw=1)
    ax.plot((0, 0), (-1.2, 1.2), color="0.4", lw=1)
    ax.text(0, -1.4, "solid: the camera's ω, dashed: arctan(tan ω)", **middle)
    ax.text(1.2, -0.1, "cos ω", fontsize=16, va="center")
    ax.text(0.05, 1.22, "sin ω", fontsize=16, va="center")
    ax.set(xlim=(-1.8, 1.6), ylim=(-1.5, 1.32), aspect="equal")
    ax.axis("off")
    plot.show(
        fig,
        f"A circle of radius 1 with a direction of {degrees:.0f} degrees and the"
        f" opposite one of {answer:.0f} degrees, which have the same tangent; arctan"
        " returns directions in the right half of the circle only.",
    )


def _arrow(ax: Axes, tip: ArrayLike, name: str, color: str, line: str = "-") -> None:
    """Draw an axis from the origin, with its name beyond the tip."""
    x, y = np.asarray(tip, dtype=float)
    look: Look = {"arrowstyle": "-|>", "lw": 2.6, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", (x, y), (0, 0), arrowprops=look | {"color": color, "ls": line})
    far = 1 + 0.12 / float(np.hypot(x, y))
    ax.text(far * x, far * y, name, color=color, ha="center", va="center", **WORDS)


def _arc(ax: Axes, start: float, end: float, radius: float, name: str) -> None:
    """Draw the angle between two directions in degrees, as an arrow."""
    t = np.radians(np.linspace(start, end, 40))
    x, y = radius * np.cos(t), radius * np.sin(t)
    ax.plot(x, y, color=plot.BLACK, lw=2)
    look: Look = {"arrowstyle": "-|>", "color": plot.BLACK, "lw": 2}
    ax.annotate("", (x[-1], y[-1]), (x[-4], y[-4]), arrowprops=look)
    middle = np.radians((start + end) / 2)
    at = (radius + 0.1) * np.array([np.cos(middle), np.sin(middle)])
    ax.text(at[0], at[1], name, ha="center", va="center", **WORDS)


def _old_axes(ax: Axes3D, kept: int) -> None:
    """Draw X, Y, Z as dashed lines; the one about which the frame rotates stays."""
    for k, name in enumerate("XYZ"):
        tip = 1.05 * np.eye(3)[k]
        if k != kept:
            line: Look = {"color": "0.45", "ls": "--", "lw": 2, "clip_on": False}
            ax.plot(*np.transpose([np.zeros(3), tip]), **line)
            ax.text(*(1.12 * tip), name, fontsize=16, color="0.35", ha="center")
