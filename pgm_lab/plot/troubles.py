"""Figures of searches that go wrong: six landscapes, and where the wrong points lie."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.datasets import StereoPair
from pgm_lab.image import cut, resample
from pgm_lab.ncc import correlation_map
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look
from pgm_lab.plot.matching import draw_map, draw_window, outline

LOG = (640, 190)  # (column, row) of a fallen log in the orthophoto


def six(pair: StereoPair, ground: ArrayLike) -> list[tuple]:
    """Six searches: a good one, and five kinds of trouble.

    Parameters
    ----------
    pair : StereoPair
        The motorcycle.
    ground : array_like (rows, columns)
        The orthophoto of Yellowstone, of which a log is seen turned and foreshortened.

    Returns
    -------
    list of (left, point, right, start, width of the template, true place)
    """
    _validate.instance(pair, StereoPair, "pair")
    ground = _validate.image(ground, "ground")
    if min(ground.shape) < max(LOG) + 90:
        raise ValueError(f"ground must be larger; got {ground.shape}: take Yellowstone")
    column, row = np.meshgrid(np.arange(-40, 41), np.arange(-40, 41))
    a, b = np.cos(np.radians(30)), np.sin(np.radians(30))
    turned = np.stack([a * column - b * row, b * column + a * row], axis=-1)
    squeezed = np.stack([2.0 * column, row], axis=-1)
    searches: list[tuple] = []
    places = (((415, 320), 375, 21), ((510, 375), 463, 21), ((154, 138), 132, 11),
              ((480, 288), 450, 21))  # fmt: skip
    for (x, y), start, size in places:
        true = np.array([x - pair.disparity[y, x], y])
        searches.append((pair.left, (x, y), pair.right, (start, y), size, true))
    for seen in (turned, squeezed):
        again = resample(ground, np.array(LOG) + seen)
        searches.append((ground, LOG, again, (40, 40), 21, np.array([40.0, 40])))
    return searches


def gallery(searches: Sequence[tuple], found: ArrayLike) -> None:
    """Show searches in columns: template, search window, r by shift, found and true.

    Parameters
    ----------
    searches : sequence of tuples
        From `six`; the search goes 30 px to each side.
    found : array_like (n, 2)
        (column, row) of the highest r of each.
    """
    searches = _validate.several(searches, "searches")
    highest = _validate.points(found, 2, "found")
    if not searches or any(
        not isinstance(one, tuple) or len(one) != 6 for one in searches
    ):
        raise ValueError("searches must hold tuples of six parts, those of `six`")
    if len(highest) != len(searches):
        raise ValueError(f"found must have {len(searches)} places; got {len(highest)}")
    fig, axes = plt.subplots(3, len(searches), figsize=(8.8, 4.75), squeeze=False)
    for column, name, search, place in zip(axes.T, "ABCDEF", searches, highest):
        left, point, right, start, size, true = search
        around = cut(right, start, size + 60)
        draw_window(column[0], np.asarray(left), point, size)
        draw_window(column[1], np.asarray(right), start, size + 60)
        outline(column[1], place, size, basic.RED)
        drawn = draw_map(column[2], correlation_map(cut(left, point, size), around))
        middle = np.asarray(start)
        column[2].plot(*(place - middle), "x", color=basic.RED, ms=13, mew=3)
        column[2].plot(*(true - middle), "wo", mfc="none", ms=15, mew=2.5)
        column[0].set_title(name, fontsize=13, loc="center")
    plt.setp(axes, xticks=[], yticks=[])
    for ax, text in zip(axes[:, 0], ("template", "search window", "r, ± 30 px")):
        ax.set_ylabel(text, fontsize=14)
    fig.colorbar(drawn, ax=axes[2], label="r")
    basic.show(
        fig,
        "Six searches in columns, each with template, search window and map of r; a red"
        " cross marks the highest r, a white ring the truth. A: one summit at the"
        " truth. B, a floor in shadow: broad ridges without a summit. C, the slats of a"
        " bench: a row of equal ridges, the cross two slats beside the ring. D, a floor"
        " beside the engine: one high summit, far from the ring. E, a log turned, and"
        " F, a log seen at half its width: no clear summit.",
        colours=128,
    )


def right_and_wrong(photo: ArrayLike, points: ArrayLike, right: ArrayLike) -> None:
    """Show accepted points on their photo, those that agree with the truth and others.

    Parameters
    ----------
    photo : array_like (rows, columns)
        Grey values.
    points : array_like (n, 2)
        (column, row) of the accepted points.
    right : array_like (n,) of bool
        Whether each agrees with the truth.
    """
    photo = _validate.image(photo, "photo")
    places = _validate.points(points, 2, "points")
    flags = _validate.finite(right, "right")
    if flags.shape != (len(places),) or not set(np.unique(flags)) <= {0.0, 1.0}:
        raise ValueError("right must hold True or False for each point")
    good = flags == 1
    fig, ax = plt.subplots(figsize=(6, 4.4))
    ax.imshow(photo, alpha=0.7)
    looks = ((good, "o", basic.SKY, "right", 4), (~good, "X", basic.RED, "wrong", 9))
    for chosen, mark, colour, name, size in looks:
        label = f"{name}, {100 * np.mean(chosen):.0f} %"
        look: Look = {"color": colour, "linestyle": "none", "label": label}
        ax.plot(*places[chosen].T, mark, ms=size, mec="black", mew=0.7, **look)
    ax.set_axis_off()
    fig.legend(loc="outside lower center", ncols=2, fontsize=14)
    basic.show(
        fig,
        f"The left photo with {len(places)} accepted points. {np.sum(~good)} are wrong,"
        " and most line the edges of things, where the depth changes.",
        colours=128,
    )
