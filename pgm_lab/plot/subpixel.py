"""Figures of what lies between the pixels: a parabola's bias, and depths measured."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import _doors, basic
from pgm_lab.plot.basic import Look


def summit(r: ArrayLike) -> None:
    """Show three values of r along an axis, and ask where the hill is highest.

    Parameters
    ----------
    r : array_like (3,)
        r at the shifts -1, 0 and 1 px.
    """
    values = _validate.of_shape(r, (3,), "r")
    if not values[1] > max(values[0], values[2]):
        raise ValueError("r must be highest in the middle, or it has no top there")
    slope = (values[2] - values[0]) / 2
    bend = 2 * values[1] - values[0] - values[2]
    t = np.linspace(-1.15, 1.15, 200)
    fig, ax = plt.subplots(figsize=(10, 3.6))
    ax.plot(t, values[1] + slope * t - bend * t**2 / 2, "--", label="parabola")
    ax.plot((-1, 0, 1), values, "o", color=basic.BLACK, ms=12, label="r, computed")
    beside: Look = {"textcoords": "offset points", "fontsize": 16, "ha": "right"}
    for at, name, value in zip((-1, 0, 1), ("-1", "0", "+1"), values):
        ax.annotate(f"$r_{{{name}}}$", (at, value), (-12, -20 * (at == 0)), **beside)
    ax.axvline(slope / bend, color=basic.RED, linestyle=":", label="top, $t$ = ?")
    ax.set(xlabel="shift (px)", ylabel="r", xticks=(-1, 0, 1), xlim=(-1.3, 2.1))
    ax.legend(loc="upper right")
    basic.show(
        fig,
        "r at the shifts −1, 0 and 1 px as dots, a parabola through them, and a dotted"
        " line at its top, between 0 and the higher neighbour.",
    )


def locking(shifts: ArrayLike, errors: Mapping[str, ArrayLike]) -> None:
    """Show the mean error of matches against the true fraction of a pixel.

    Parameters
    ----------
    shifts : array_like (n,)
        True shifts in pixels.
    errors : mapping of str to array_like (n,)
        Mean error in pixels at each, by the name of the texture; up to three.
    """
    true = _validate.finite(shifts, "shifts")
    series = _doors.lists(errors, "errors")
    if next(iter(series.values())).shape != true.shape:
        raise ValueError("shifts and the lists of errors must have the same length")
    fig, ax = plt.subplots(figsize=(7, 4.2))
    looks = (("o-", basic.BLUE), ("s--", basic.RED), ("D:", basic.GREEN))
    said = []
    for (name, values), (mark, colour) in zip(series.items(), looks):
        ax.plot(true, values, mark, color=colour, label=name)
        said.append(f"{name} at most {np.abs(values).max():.3f} px")
    ax.axhline(0, color=basic.BLACK, linewidth=1)
    ax.set(xlabel="true shift (px)", ylabel="mean error (px)")
    ax.legend()
    basic.show(
        fig,
        "Mean error against the true shift: an S-shaped curve, zero at 0 and at half a"
        f" pixel, negative between 0 and a half, positive below: {', '.join(said)}.",
    )


def depths(
    photo: ArrayLike, points: ArrayLike, measured: ArrayLike, true: ArrayLike
) -> None:
    """Show disparities that were measured in a photo beside the true ones.

    Parameters
    ----------
    photo : array_like (rows, columns)
        The left photo.
    points : array_like (n, 2)
        (column, row) in it.
    measured, true : array_like (n,)
        Disparities in pixels; NaN where there is none.
    """
    photo, places = (
        _validate.image(photo, "photo"),
        _validate.points(points, 2, "points"),
    )
    measured = _validate.real(measured, "measured")
    true = _validate.real(true, "true")
    for values, name in ((measured, "measured"), (true, "true")):
        if values.shape != (len(places),) or not np.isfinite(values).any():
            raise ValueError(f"{name} must have a number for each point, not all NaN")
    fig, axes = plt.subplots(1, 2, figsize=(10, 4.2))
    known = true[np.isfinite(true)]
    low, high = known.min(), known.max()
    names = ("measured by your program", "true, by structured light")
    for ax, values, name in zip(axes, (measured, true), names):
        ax.imshow(photo, alpha=0.35)
        look: Look = {"cmap": "viridis", "vmin": low, "vmax": high, "s": 34}
        drawn = ax.scatter(*places.T, c=np.asarray(values, float), **look)
        ax.set_title(name)
        ax.set_axis_off()
    bar = fig.colorbar(drawn, ax=axes, shrink=0.8)
    bar.set_label("disparity (px)")
    basic.show(
        fig,
        "The left photo with points coloured by disparity, measured and true: in both"
        " the front wheel and the engine are near, the shelves behind them far. As"
        " measured, the gap between engine and fork, blue in truth, is partly closed.",
        colours=256,
    )
