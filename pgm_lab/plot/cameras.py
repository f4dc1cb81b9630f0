"""Cameras above a meadow and around a field of targets, and what they see."""

from collections.abc import Mapping
from typing import cast

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import IntSlider
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.plot import basic, space, village
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import Look

PLACE = (0.0, 0.0, 8.0)  # of the cameras above the meadow, in metres
SCALE = "X east, Y north, Z up: arrows of 3 m."
PLACES = {  # where numbers stand beside the nine cameras of 2013, mm
    "1, 2": (0, -60, 105),
    "3, 4, 5": (0, 0, 160),
    "6": (0, 0, 95),
    "7": (0, -20, 110),
    "8, 9": (0, 70, -105),
}


def one() -> None:
    """Show a camera above a meadow with its parts named, and the photo it takes."""
    look = rotation.from_tilt_azimuth_swing(*np.radians([55, 28, 175]))
    exterior = np.array([-3.0, -8.0, 6.0, *rotation.angles(look)])
    fig = _beside(exterior, "camera and object space", (24, -62))
    ax = cast(Axes3D, fig.axes[0])
    text: Look = {"fontsize": 16, "ha": "center", "va": "center"}
    ax.text(*(exterior[:3] + (6.6, 3.4, 2.2)), "perspective\ncentre (black)", **text)
    ax.text(*(exterior[:3] + (6.4, 3.3, -0.1)), "photo (grey)", **text)
    basic.show(
        fig,
        "Left: a camera with its perspective centre, its photo and its axes x, y, z"
        " above a meadow with a house, two trees and, on the grass, an arrow to the"
        f" north with the letter N. {SCALE} Right: the photo that it takes, with its"
        " axes x to the right and y up from the principal point.",
        colours=128,
    )


def views(attitudes: ArrayLike, names: list[str], width: float = 7.0) -> None:
    """Show cameras 8 m above the meadow in a row, and below each what it sees.

    Parameters
    ----------
    attitudes : array_like (n, 3)
        (omega, phi, kappa) of each, in degrees.
    names : list of str
        What to write above each.
    width : float
        Inches across the figure.
    """
    _several(attitudes, names, width)


def two_orders(omega: float, phi: float, kappa: float) -> None:
    """Show two cameras turned by the same three angles in opposite order.

    Parameters
    ----------
    omega, phi, kappa : float
        Degrees.
    """
    degrees = (("omega", omega), ("phi", phi), ("kappa", kappa))
    angles = np.radians([_validate.number(value, name) for name, value in degrees])
    one, two, three = (rotation.matrix(*row) for row in np.diag(angles))
    pair = [three @ two @ one, one @ two @ three]
    names = [
        f"ω = {omega:g}°, then\nφ = {phi:g}°, then κ = {kappa:g}°",
        f"κ = {kappa:g}°, then\nφ = {phi:g}°, then ω = {omega:g}°",
    ]
    _several(np.degrees(rotation.angles(pair)), names, 7.0)
    apart = np.degrees(rotation.angle_between(*pair))
    look = np.degrees(np.arccos(min(pair[0][2] @ pair[1][2], 1.0)))
    print(f"One turn of {apart:.1f}° leads from one camera to the other;")
    print(f"their lines of sight are {look:.1f}° apart.")


def mirror() -> None:
    """Show what a camera would see whose x axis is reversed, beside a real one."""
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.5), layout="constrained")
    exterior = np.array([*PLACE, 0, 0, 0])
    for ax, sign, name in zip(axes, (1, -1), ("diag(1, 1, 1)", "diag(−1, 1, 1)")):
        faces = [(polygon * (sign, 1, 1), color) for polygon, color in _country()]
        _photo(ax, exterior, faces)
        ax.set_title(f"M = {name}", loc="center")
    basic.show(
        fig,
        "Two photos of the meadow from above. In the first the letter N reads as it"
        " should; in the second everything is exchanged left for right, and the N is"
        " written backwards.",
        colours=128,
    )


def by_hand() -> None:
    """Show a camera above the meadow, and sliders that turn it."""

    def draw(omega: int, phi: int, kappa: int) -> None:
        exterior = np.array([*PLACE, *np.radians([omega, phi, kappa])])
        name = f"ω = {omega}°, φ = {phi}°, κ = {kappa}°".replace("-", "−")
        fig = _beside(exterior, name)
        basic.show(
            fig,
            f"A camera 8 m above the meadow, {name}, and its photo, in which"
            f" {_north(exterior)}.",
            dpi=80,
            colours=128,
        )

    def slider(name: str, most: int) -> IntSlider:
        look: Look = {"description": f"{name} (°)", "continuous_update": False}
        return IntSlider(0, -most, most, 5, **look)

    interact(draw, omega=slider("ω", 90), phi=slider("φ", 90), kappa=slider("κ", 180))


def around(points: ArrayLike, cameras: Mapping[str, ArrayLike]) -> None:
    """Show nine cameras around targets; red ones look elsewhere than in the first set.

    Parameters
    ----------
    points : array_like (n, 3)
        The targets, in mm.
    cameras : mapping of str to array_like (9, 6)
        Exterior orientations by a name, those of 2013.
    """
    points = _validate.points(points, 3, "points")
    sets = {
        name: _validate.of_shape(exteriors, (9, 6), f"cameras, {name}")
        for name, exteriors in _validate.mapping(cameras, "cameras").items()
    }
    if not sets or not len(points):
        raise ValueError("points and cameras must hold one set or more")
    first = rotation.matrix(*next(iter(sets.values()))[:, 3:].T)
    fig = plt.figure(figsize=(7, 4.6), layout="none")
    said = []
    for column, (name, exteriors) in enumerate(sets.items()):
        ax = space.space(fig, fig.add_gridspec(1, len(sets))[column], view=(20, 20))
        ax.set_position((column / len(sets), 0.12, 1 / len(sets), 0.8))
        ax.set_title(name, loc="center", y=1.0)
        ax.plot(*points.T, "o", color=basic.BLACK, markersize=3.5)
        ax.text(-20, 1560, 330, "targets", fontsize=15, ha="center")
        space.draw_axes(ax, (0, 1000, -1000), None, 350, ("X", "Y", "Z"), 15)
        other = rotation.matrix(*exteriors[:, 3:].T)
        off = np.degrees(rotation.angle_between(other, first)) > 1
        for camera, wrong in zip(exteriors, off):
            color = basic.RED if wrong else basic.BLUE
            space.draw_camera(ax, camera, 200, color=color, axes=False)
        for tag, beside in PLACES.items():
            at = exteriors[int(tag[0]) - 1, :3] + beside
            ax.text(*at, tag, fontsize=14, ha="center", va="center")
        space.fit(ax, [(0, -150, -1000), (300, 1900, 620)], zoom=1.2)
        wrong_ones = ", ".join(str(k + 1) for k in np.flatnonzero(off)) or "none"
        others = f": turned away from the first set are {wrong_ones}"
        said.append(name + (others if len(sets) > 1 else ""))
    scale = "The axes X, Y, Z are 350 mm long."
    key = "\nBlue: as in the first picture; red: turned away." if len(sets) > 1 else ""
    fig.text(0.5, 0.01, scale + key, ha="center", fontsize=15)
    basic.show(
        fig,
        "Muliawan's nine cameras around a field of fifty targets. "
        + ". ".join(said)
        + ". The axes X, Y, Z are 350 mm long.",
    )


def _several(attitudes: ArrayLike, names: list[str], width: float) -> None:
    attitudes = _validate.points(attitudes, 3, "attitudes").reshape(-1, 3)
    names = list(_validate.texts(names, "names", len(attitudes)))
    width = _validate.positive_number(width, "width", "inches")
    fig = plt.figure(figsize=(width, 5.4), layout="none")
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
        said.append(f"{name}: {_north(exterior)}".replace("\n", " "))
    fig.text(0.5, 0.015, SCALE, ha="center", fontsize=16)
    alt = "Cameras 8 m above the meadow, and below them what they see. "
    M = rotation.matrix(*np.radians(attitudes).T)
    if len(M) > 1 and np.allclose(M, M[0], rtol=0, atol=1e-12):
        said.append("all cameras and all photos are the same")
    basic.show(fig, alt + "; ".join(said) + ".", colours=128)


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
    space.draw_faces(ax, village.village())
    space.draw_axes(ax, (-6, -6, 0), None, 3, ("X", "Y", "Z"), 16)
    space.draw_camera(ax, exterior, size)
    for text in ax.texts:
        text.set_fontsize(16)


def _photo(ax: Axes, exterior: np.ndarray, faces: list[village.Face]) -> None:
    """What the camera sees, with names that are read from the back row."""
    space.draw_photo(ax, exterior, faces, ground=village.GROUND)
    for text in ax.texts:
        text.set_fontsize(16)


def _country() -> list[village.Face]:
    """All that a photo can show, to the horizon."""
    return village.surroundings() + village.village()


def _north(exterior: np.ndarray) -> str:
    """Where the arrow on the grass points in the photo, in words."""
    arrow = np.array([(-1.9, 1.2, 0.0), (-1.9, 2.6, 0.0)])
    in_camera = (arrow - exterior[:3]) @ rotation.matrix(*exterior[3:]).T
    if np.any(in_camera[:, 2] > -1e-3):
        return "the arrow to the north is not to be seen"
    x, y = (-in_camera[:, :2] / in_camera[:, 2:]).T
    if abs(x[0]) > 0.5 or abs(y[0]) > 0.375:  # its foot
        return "the arrow to the north is not to be seen"
    turn = np.degrees(np.arctan2(x[1] - x[0], y[1] - y[0]))
    if abs(turn) < 0.5:
        return "the arrow to the north points up"
    side = "to the right" if turn > 0 else "to the left"
    return f"the arrow to the north points {abs(turn):.0f} degrees {side} of up"
