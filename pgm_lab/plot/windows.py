"""Figures of windows that are matched by least squares: one slope, eight unknowns."""

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look

GREY: Look = {"cmap": "gray", "vmin": 0, "vmax": 230, "interpolation": "nearest"}
# What is added to each of a0, a1, a2, h0, b0, b1, b2, h1 in the sketch
STEPS = {0: 9.0, 1: 0.35, 2: 0.35, 6: 45.0, 3: 9.0, 4: 0.35, 5: 0.35, 7: -0.5}
NAMES = ("$a_0$", "$a_1$", "$a_2$", "$b_0$", "$b_1$", "$b_2$", "$h_0$", "$h_1$")


def pair(
    left: ArrayLike, right: ArrayLike, point: ArrayLike, affine: ArrayLike, window: int
) -> None:
    """Show a window in the left photo, and where it lies in the right one.

    Parameters
    ----------
    left, right : array_like (rows, columns)
        Photos.
    point : array_like (2,)
        (column, row) of the middle of the window.
    affine : array_like (2, 3)
        Takes (column, row, 1) of the left photo to the right one.
    window : int
        Pixels across the window, odd.
    """
    photos = [_validate.image(g, n) for g, n in ((left, "left"), (right, "right"))]
    column, row = _validate.one_point(point, 2, "point")
    affine = _validate.finite(affine, "affine")
    if affine.shape != (2, 3):
        raise ValueError(f"affine must have shape (2, 3); got {affine.shape}")
    reach = _validate.window(window, "window") / 2
    x, y = reach * _SQUARE + [[column], [row]]
    outlines = [(x, y), affine @ (x, y, np.ones(5))]
    panels: Look = {"sharex": True, "sharey": True, "layout": "constrained"}
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.3), **panels)
    for ax, photo, (u, v), name in zip(axes, photos, outlines, ("left", "right")):
        ax.imshow(photo, **GREY)
        ax.plot(u, v, color=basic.ORANGE, linewidth=3)
        middle = u[:4].mean(), v[:4].mean()
        ax.plot(*middle, "+", color=basic.RED, ms=18, mew=3)
        ax.set(title=f"{name} photo", xlabel="column (px)", xlim=(40, 220))
        ax.set_ylim(200, 20)
        ax.tick_params(labelsize=17)
        ax.grid(False)
    axes[0].set_ylabel("row (px)")
    basic.show(
        fig,
        "Two aerial photos of a meadow with trees. A square window around a point of"
        " the left photo appears in the right one turned by some degrees, a little"
        " larger, and with less contrast.",
    )


_SQUARE = np.array([(-1, 1, 1, -1, -1), (-1, -1, 1, 1, -1)])


def slope(A: ArrayLike, B: ArrayLike, place: int) -> None:
    """Draw two rows of grey values, and one pixel's triangle of slope and difference.

    Parameters
    ----------
    A, B : array_like (n,)
        Grey values of a row of the left and of the right window.
    place : int
        Pixel whose triangle is drawn; with a neighbour on each side.
    """
    A, B = (_validate.finite(g, n) for g, n in ((A, "A"), (B, "B")))
    place = _validate.whole(place, "place", 0)
    if A.ndim != 1 or A.shape != B.shape or not 0 < place < len(A) - 1:
        raise ValueError(
            "A and B must be rows of the same length, and place one of their pixels,"
            f" not the first or last; got {A.shape}, {B.shape} and {place}"
        )
    at = np.arange(len(A)) - len(A) // 2
    gradient = (B[place + 1] - B[place - 1]) / 2
    step = (A[place] - B[place]) / gradient if gradient else 0.0
    fig, (ax, near) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    for panel in (ax, near):
        panel.plot(at, A, "o-", color=basic.BLUE, label="A, left window")
        panel.plot(at, B, "s--", color=basic.ORANGE, label="B, right window")
        panel.set(xlabel="x (px from the middle)")
    ax.set_ylabel("grey value")
    ax.set_ylim(top=ax.get_ylim()[1] + 25)
    ax.legend(loc="upper right")
    x0, low, high = at[place], B[place], A[place]
    ends = np.array([-0.6, max(step, 0) + 0.6])
    near.plot(x0 + ends, low + gradient * ends, color=basic.BLACK, lw=2)
    near.plot([x0, x0], [low, high], color=basic.RED, lw=4)
    near.plot([x0, x0 + step], [high, high], color=basic.GREEN, lw=4)
    look: Look = {"fontsize": 15, "textcoords": "offset points"}
    middle, mid = (low + high) / 2, x0 + step / 2
    near.annotate("A − B", (x0, middle), (-118, 12), color=basic.RED, **look)
    near.annotate("(A − B) / slope", (mid, high), (24, -30), color=basic.GREEN, **look)
    foot = (x0 - 0.45, low - 0.45 * gradient)
    near.annotate("tangent of B", foot, (14, -12), color=basic.BLACK, **look)
    reach = 1.3 * abs(high - low) + 8
    near.set(xlim=(x0 - 1.3, x0 + 1.9), ylim=(middle - reach, middle + reach))
    near.set_xticks([x0 - 1, x0, x0 + 1])
    near.set_title("one pixel, enlarged")
    basic.show(
        fig,
        "Left, two rows of grey values, the second one like the first but displaced"
        " by less than a pixel. Right, one pixel of them enlarged: the difference A"
        " minus B stands upright, the tangent of B rises beside it, and the level way"
        " from the pixel to the tangent is the difference over the slope.",
    )


def eight(photo: ArrayLike, point: ArrayLike, window: int = 41) -> None:
    """Draw what each of the eight parameters does to a window.

    Parameters
    ----------
    photo : array_like (rows, columns)
        Grey values from 0 to 255.
    point : array_like (2,)
        (column, row) of the middle of the window, in whole pixels.
    window : int
        Pixels across the window, odd.
    """
    photo = _validate.image(photo, "photo").astype(float)
    column, row = map(int, _validate.one_point(point, 2, "point"))
    half = _validate.window(window, "window") // 2
    x, y = (half + 0.5) * _SQUARE
    fig, axes = plt.subplots(2, 4, figsize=(10, 4.8), layout="constrained")
    for ax, (k, step) in zip(axes.flat, STEPS.items()):
        p = np.array([0, 1, 0, 0, 0, 1, 0, 1.0])
        p[k] += step
        shown = photo.copy()
        inside = np.s_[row - half : row + half + 1, column - half : column + half + 1]
        shown[inside] = p[6] + p[7] * shown[inside] + (60 if k == 7 else 0)
        ax.imshow(shown, **GREY)
        ax.plot(column + x, row + y, "--", color="white", lw=2)
        moved = p[0] + p[1] * x + p[2] * y, p[3] + p[4] * x + p[5] * y
        ax.plot(column + moved[0], row + moved[1], color=basic.ORANGE, lw=3)
        reach = 1.75 * half
        ax.set(xlim=(column - reach, column + reach), xticks=[], yticks=[])
        ax.set_ylim(row + reach, row - reach)
        sign = "−" if step < 0 else "+"
        unit = " px" if k in (0, 3) else ""
        title = f"{NAMES[k]} {sign} {abs(step):g}{unit}"
        ax.set_title(title + (", $h_0$ + 60" if k == 7 else ""), fontsize=15)
        ax.grid(False)
    basic.show(
        fig,
        "Eight small photos. a0 and b0 shift the window, a1 and b2 stretch it along"
        " columns and rows, a2 and b1 shear it, h0 makes it brighter and h1, here with"
        " 60 added, changes its contrast.",
    )
