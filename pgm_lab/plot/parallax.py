"""Sketches of stereo: parallax, the epipolar plane, what a pixel is worth."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from pgm_lab.camera.imaging import attitude
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look

WORDS: Look = {"fontsize": 18}
BOX: Look = {"bbox": {"facecolor": "white", "edgecolor": "none", "pad": 1.5}}
BOTH_ENDS: Look = {"arrowstyle": "<|-|>", "shrinkA": 0, "shrinkB": 0, "linewidth": 1.6}
LOOK_AT = np.radians((25.0, -68.0))  # elevation and azimuth of the reader's eye


def sketch() -> None:
    """Show two photos of a mast from the side, and the parallaxes of its two ends."""
    H, B, c, X = 10.0, 5.0, 2.2, 2.9
    kinds = (("foot", 0.0, basic.BLUE, "--"), ("top", 4.2, basic.RED, "-"))
    panels: Look = {"width_ratios": (1.75, 1), "wspace": 0.06}
    fig, (side, bars) = plt.subplots(
        1, 2, figsize=(10, 4.6), layout="constrained", gridspec_kw=panels
    )
    side.fill_between((-1.6, 7.6), -0.5, 0, color="0.85", linewidth=0)
    side.plot((X, X), (0, 4.2), color="0.45", lw=7, solid_capstyle="butt")
    side.annotate("", (0, H), (B, H), arrowprops=BOTH_ENDS)
    side.text(B / 2, H + 0.25, "base $B$", ha="center", **WORDS)
    side.annotate("", (-1.2, 0), (-1.2, H), arrowprops=BOTH_ENDS)
    side.text(-1.2, 4.6, "$H$", ha="center", **WORDS, **BOX)
    side.annotate("", (-0.45, H - c), (-0.45, H), arrowprops=BOTH_ENDS)
    side.text(-0.45, H - c / 2, "$c$", ha="center", va="center", **WORDS, **BOX)
    for k, (at, name) in enumerate(((0.0, "$O'$"), (B, "$O''$"))):
        side.plot(at, H, "o", color=basic.BLACK, markersize=9)
        side.text(at, H + 0.3, name, ha="right" if k == 0 else "left", **WORDS)
        side.plot((at - 1.5, at + 1.5), (H - c, H - c), color=basic.BLACK, lw=4)
        side.plot((at, at), (H, H - c), color=basic.BLACK, lw=1.2, ls=":")
        side.plot(at, H - c, "|", color=basic.BLACK, markersize=16)
        for _, Z, colour, line in kinds:
            side.plot((at, X), (H, Z), color=colour, ls=line, lw=1.8)
            x = c * (X - at) / (H - Z)
            side.plot(at + x, H - c, "o", color=colour, markersize=9, zorder=4)
    side.text(-1.1, H - c - 0.95, "left photo", **WORDS, **BOX)
    side.text(B - 0.1, H - c - 0.95, "right photo", **WORDS)
    side.text(X + 0.45, 3.9, "top", color=basic.RED, **WORDS, **BOX)
    side.text(X + 0.35, 0.15, "foot", color=basic.BLUE, **WORDS)
    side.set(xlim=(-1.7, 7.7), ylim=(-0.5, H + 1.1), aspect="equal")
    side.axis("off")
    for k, (name, Z, colour, _) in enumerate(kinds):
        one, other = c * X / (H - Z), c * (X - B) / (H - Z)
        bars.barh(k, one, 0.42, color=colour)
        bars.barh(k, other, 0.42, facecolor="white", edgecolor=colour, lw=3)
        bars.text(one / 2, k, "$x'$", ha="center", va="center", color="white", **WORDS)
        bars.text(other / 2, k, "$x''$", ha="center", va="center", **WORDS)
        level = k + 0.36
        bars.annotate("", (other, level), (one, level), arrowprops=BOTH_ENDS)
        text = f"$p_x$ of the {name}"
        bars.text((one + other) / 2, level + 0.07, text, ha="center", **WORDS, **BOX)
    bars.axvline(0, color=basic.BLACK, lw=1.2)
    bars.set(ylim=(-0.45, 1.75), xlim=(-1.05, 1.25))
    bars.set_title("one photo laid on the other", loc="center")
    bars.axis("off")
    basic.show(
        fig,
        "Left, seen from the side: two perspective centres O' and O'' at height H above"
        " the ground, the base B between them, a photo at the distance c below each."
        " Rays run from a mast's foot and top to both. Right, the two photos laid on"
        " each other: the distance from x'' to x' is greater for the top than for the"
        " foot.",
    )


def plane() -> None:
    """Show two rays, the base and the plane that they span, with all parts named."""
    O1, O2 = np.array([0.0, 0.0, 5.0]), np.array([5.6, 0.5, 5.2])
    P, c = np.array([3.3, 1.0, 0.0]), 1.9
    fig, ax = plt.subplots(figsize=(10, 4.7), layout="constrained")
    triangle = _flat(np.array([O1, O2, P]))
    ax.add_patch(Polygon(triangle, facecolor=basic.YELLOW, alpha=0.35, zorder=0))
    normal = np.cross(O2 - O1, P - O1)
    turns = (np.radians((4.0, -6.0, 5.0)), np.radians((-5.0, 5.0, -8.0)))
    for k, (centre, turn) in enumerate(zip((O1, O2), turns)):
        M = attitude(np.array([*centre, *turn]))
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (1.25, 0.95)
        quad = centre + np.column_stack([corners, np.full(4, -c)]) @ M
        ax.add_patch(
            Polygon(_flat(quad), facecolor="white", alpha=0.75, ec="0.25", lw=2)
        )
        a, b, w = M @ normal  # a x + b y - c w = 0 is the epipolar line
        x = np.array([-1.25, 1.25])
        ends = centre + np.column_stack([x, (c * w - a * x) / b, [-c, -c]]) @ M
        ax.plot(*_flat(ends).T, color=basic.GREEN, lw=3.5)
        points = [P] if k == 0 else [P, P + 0.17 * (O1 - P), P - 0.2 * (O1 - P)]
        for i, point in enumerate(points):
            u = M @ (point - centre)
            image = centre + (-c * u / u[2]) @ M
            main = i == 0
            style: Look = {"color": basic.BLACK if main else "0.45", "zorder": 3}
            line = _flat(np.array([centre, point])).T
            ax.plot(*line, ls="-" if main else ":", lw=2.2 if main else 1.8, **style)
            ax.plot(*_flat(image[None])[0], "o", ms=10 if main else 7, **style)
            if main:
                name = ("$p'$", "$p''$")[k]
                _name(ax, name, image, (-30, 6) if k == 0 else (-32, -22))
            else:
                ax.plot(*_flat(point[None])[0], "o", ms=7, **style)
    farther = np.array([P, P - 0.2 * (O1 - P)])
    ax.plot(*_flat(farther).T, ls="-", lw=2.2, color=basic.BLACK)
    ax.plot(*_flat(np.array([O1, O2])).T, color=basic.RED, lw=3)
    for point, name, at in (
        (O1, "$O'$", (-28, 8)), (O2, "$O''$", (8, 8)), (P, "$P$", (-24, -14))
    ):  # fmt: skip
        ax.plot(*_flat(point[None])[0], "o", color=basic.BLACK, ms=10, zorder=4)
        _name(ax, name, point, at)
    _name(ax, "base", (O1 + O2) / 2, (-20, 10), basic.RED)
    _name(ax, "epipolar plane", 0.31 * (O1 + O2) + 0.38 * P, (-58, 6), "0.25")
    right = attitude(np.array([*O2, *turns[1]]))
    a, b, w = right @ normal
    end = O2 + np.array([1.25, (c * w - a * 1.25) / b, -c]) @ right
    _name(ax, "epipolar line of $p'$", end, (14, -6), basic.GREEN)
    _name(ax, "higher?", P + 0.17 * (O1 - P), (-88, -4), "0.35")
    _name(ax, "lower?", P - 0.2 * (O1 - P), (12, -6), "0.35")
    ax.margins(0.06)
    ax.set_aspect("equal")
    ax.axis("off")
    basic.show(
        fig,
        "Two perspective centres O' and O'', joined by the base, with a tilted photo"
        " below each. Rays from both meet in the point P; base and rays span the"
        " epipolar plane, shaded, which cuts each photo in a line. A higher and a lower"
        " point on the left ray have the same p'; in the right photo all lie on the"
        " epipolar line of p'.",
    )


def worth() -> None:
    """Show how far a height moves when a ray moves by a pixel, for two bases."""
    H, wide = 6.0, 0.44
    fig, axes = plt.subplots(1, 2, figsize=(7, 2.8), layout="constrained")
    tall = []
    for ax, B, name in zip(axes, (5.0, 2.5), ("base $B$", "base $B/2$")):
        X, e = B / 2, wide / 2
        for at in (0.0, B):
            ax.plot(at, H, "o", color=basic.BLACK)
            for shift in (-e, e):
                end = at + 1.18 * (X + shift - at)
                ax.plot((at, end), (H, H - 1.18 * H), color=basic.BLUE, lw=1.3)
        rise = np.array([H - H * B / (B + wide), H - H * B / (B - wide)])
        diamond = [(X, rise[0]), (X + e, 0), (X, rise[1]), (X - e, 0)]
        ax.add_patch(Polygon(diamond, facecolor=basic.ORANGE, ec=basic.BLACK, zorder=3))
        ax.plot((0, B), (H, H), color=basic.RED, lw=3)
        ax.set(title=name, xlim=(-0.6, 5.6), ylim=(-1.6, H + 0.3), aspect="equal")
        ax.axis("off")
        tall.append(rise[0] - rise[1])
        beside, across = X + 0.95, rise.mean()
        ends: Look = {**BOTH_ENDS, "arrowstyle": "|-|,widthA=0.25,widthB=0.25"}
        ax.annotate("", (beside, rise[0]), (beside, rise[1]), arrowprops=ends)
        ax.text(beside + 0.2, across, "height\nerror", fontsize=15, va="center")
        ax.annotate("", (X - e, 0), (X + e, 0), arrowprops=ends, zorder=4)
        ax.text(X - 0.95, 0, "GSD", fontsize=15, ha="right", va="center")
    basic.show(
        fig,
        "Two rays, each as wide as a pixel on the ground (the GSD), meet in a diamond;"
        " how high it is tells the error of the height. With half"
        f" the base it is {tall[1] / tall[0]:.1f} times as high.",
    )


def _flat(points: np.ndarray) -> np.ndarray:
    """Points (n, 3) as the reader's eye sees them, (n, 2)."""
    elevation, azimuth = LOOK_AT
    s, co = np.sin(azimuth), np.cos(azimuth)
    se, ce = np.sin(elevation), np.cos(elevation)
    axes = np.array([(-s, co, 0.0), (-se * co, -se * s, ce)])
    return points @ axes.T


def _name(
    ax: Axes,
    name: str,
    point: np.ndarray,
    at: tuple[float, float],
    colour: str = basic.BLACK,
) -> None:
    """Write a name beside a point in space, so many points to the right and up."""
    text: Look = {"textcoords": "offset points", "fontsize": 19, "color": colour}
    ax.annotate(name, tuple(_flat(point[None])[0]), at, zorder=5, **text)
