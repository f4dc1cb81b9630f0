"""Sketches of turned frames: one turn in the plane, three in space, the quadrants."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.plot import basic, space
from pgm_lab.plot.basic import Look

WORDS: Look = {"fontsize": 18}
KAPPA = np.radians(30.0)  # of the sketch in the plane
TURNS = (  # Greek letter, axis, from which axis to which, colour
    ("ω", "x", "Y", "Z", basic.RED),
    ("φ", "y", "Z", "X", basic.GREEN),
    ("κ", "z", "X", "Y", basic.BLUE),
)


def plane() -> None:
    """Show a frame turned in the plane, one point in both, and the first new axis."""
    fig, (left, right) = plt.subplots(1, 2, figsize=(10, 4.7), layout="constrained")
    ex = np.array([np.cos(KAPPA), np.sin(KAPPA)])
    ey = np.array([-ex[1], ex[0]])
    P = np.array([1.25, 1.3])
    for ax, size in ((left, 1.75), (right, 1.2)):
        _arrow(ax, (size, 0), "$X$", "0.35", "--")
        _arrow(ax, (0, size), "$Y$", "0.35", "--")
        _arc(ax, 0.0, 30.0, 0.85 if ax is left else 0.45, "κ")
    _arrow(left, 1.75 * ex, "$x$", basic.RED)
    _arrow(left, 1.75 * ey, "$y$", basic.BLUE)
    for foot, color, line in (
        ((P[0], 0), "0.35", "--"),
        ((0, P[1]), "0.35", "--"),
        ((P @ ex) * ex, basic.RED, "-"),
        ((P @ ey) * ey, basic.BLUE, "-"),
    ):
        left.plot(*np.transpose([P, foot]), color=color, ls=line, lw=1.8)
        left.plot(*foot, "o", color=color, ms=7)
    left.plot(*P, "o", color=basic.BLACK, ms=11)
    left.annotate("$P$", P, (8, 4), textcoords="offset points", **WORDS)
    left.set_title("one point, two frames")
    _arrow(right, ex, "$e_x$", basic.RED)
    _arrow(right, ey, "$e_y$", basic.BLUE)
    right.add_patch(Arc((0, 0), 2, 2, theta1=-5, theta2=140, color="0.6", ls=":"))
    right.plot((ex[0], ex[0]), (0, ex[1]), color=basic.RED, lw=2, ls="-.")
    right.plot((0, ex[0]), (-0.05, -0.05), color=basic.RED, lw=2, ls="-.")
    right.text(ex[0] / 2 + 0.05, -0.19, "cos κ", ha="center", **WORDS)
    free: Look = {"facecolor": "white", "edgecolor": "none", "pad": 1}
    right.text(ex[0] + 0.04, 0.2, "sin κ", va="center", bbox=free, **WORDS)
    right.set_title("new axes of length 1, in the old frame")
    left.set(xlim=(-1.15, 2.05), ylim=(-0.25, 2.05))
    right.set(xlim=(-0.75, 1.45), ylim=(-0.25, 1.5))
    for ax in (left, right):
        ax.set_aspect("equal")
        ax.axis("off")
    basic.show(
        fig,
        "Left, a frame X, Y and a frame x, y of the same origin that is turned by kappa"
        " counter-clockwise; from the point P perpendiculars fall on all four axes."
        " Right, the new axes as arrows e_x and e_y of length 1; e_x reaches cos kappa"
        " along X and sin kappa along Y, e_y stands at a right angle to it.",
    )


def three(degrees: float = 25.0) -> None:
    """Show one turn at a time in space: about x, about y, about z.

    Parameters
    ----------
    degrees : float
        The angle of each turn.
    """
    angle = np.radians(_validate.number(degrees, "degrees"))
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
        ax.plot(*arc.T, color=basic.BLACK, lw=2.5, clip_on=False)
        tip = {"arrow_length_ratio": 1.0, "lw": 2.5, "color": basic.BLACK}
        ax.quiver(*arc[-8], *(arc[-1] - arc[-8]), clip_on=False, **tip)
        at = 0.5 * (np.cos(angle / 2) * first + np.sin(angle / 2) * second)
        ax.text(*at, letter, fontsize=19, ha="center", va="center")
        space.fit(ax, [(-0.35, -0.35, -0.25), (1.15, 1.15, 1.2)], zoom=1.08)
        name = f"{letter} about {axis}:\nfrom {start} towards {end}"
        ax.set_title(name, loc="center", y=1.07, color=color)
    basic.show(
        fig,
        f"Three frames, each turned by {degrees:g} degrees about one of its axes. Omega"
        " turns about x, from Y towards Z; phi about y, from Z towards X; kappa about"
        " z, from X towards Y. All axes have length 1.",
    )


def quadrant(degrees: float) -> None:
    """Show two directions of one tangent on the circle, and what arctan answers.

    Parameters
    ----------
    degrees : float
        An angle between 90 and 180.
    """
    degrees = _validate.number(degrees, "degrees")
    answer = float(np.degrees(np.arctan(np.tan(np.radians(degrees)))))
    fig, ax = plt.subplots(figsize=(7, 4.6), layout="constrained")
    ax.add_patch(Arc((0, 0), 2, 2, color="0.6"))
    ax.fill_between((0, 1.15), -1.15, 1.15, color="0.92", linewidth=0, zorder=0)
    middle: Look = {"fontsize": 16, "ha": "center", "va": "center"}
    ax.text(0.47, 0.4, "all that\narctan\nanswers", **middle)
    for value, color, line in ((degrees, basic.BLUE, "-"), (answer, basic.RED, "--")):
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
    basic.show(
        fig,
        f"A circle of radius 1 with a direction of {degrees:.0f} degrees and the"
        f" opposite one of {answer:.0f} degrees, which have the same tangent; arctan"
        " answers in the right half of the circle only.",
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
    ax.plot(x, y, color=basic.BLACK, lw=2)
    look: Look = {"arrowstyle": "-|>", "color": basic.BLACK, "lw": 2}
    ax.annotate("", (x[-1], y[-1]), (x[-4], y[-4]), arrowprops=look)
    middle = np.radians((start + end) / 2)
    at = (radius + 0.1) * np.array([np.cos(middle), np.sin(middle)])
    ax.text(at[0], at[1], name, ha="center", va="center", **WORDS)


def _old_axes(ax: Axes3D, kept: int) -> None:
    """Draw X, Y, Z as dashed lines; the one about which the frame turns stays."""
    for k, name in enumerate("XYZ"):
        tip = 1.05 * np.eye(3)[k]
        if k != kept:
            line: Look = {"color": "0.45", "ls": "--", "lw": 2, "clip_on": False}
            ax.plot(*np.transpose([np.zeros(3), tip]), **line)
            ax.text(*(1.12 * tip), name, fontsize=16, color="0.35", ha="center")
