"""Figures of the matrices of an adjustment: normal equations, correlations, spectra."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.bundle.lens import places
from pgm_lab.bundle.result import Bundle
from pgm_lab.plot import _doors, basic
from pgm_lab.plot._style import SERIES, symbol
from pgm_lab.plot.basic import Look

MOST = 1000  # photos or points: more blocks nobody could see
EXTERIOR = ("$X_0$", "$Y_0$", "$Z_0$", r"$\omega$", r"$\varphi$", r"$\kappa$")
COLORS = {
    "interior": basic.BLUE,
    "exteriors, 6 × 6": basic.RED,
    "points, 3 × 3": basic.GREEN,
    "rays": basic.SKY,
    "datum G": basic.PURPLE,
    "filled in": basic.ORANGE,
}


def normal_blocks(
    photo: ArrayLike,
    point: ArrayLike,
    interior: int = 10,
    border: int = 7,
    eliminated: bool = False,
) -> list[tuple[int, int, int, int, str]]:
    """Blocks of the normal matrix that are not zero.

    Parameters
    ----------
    photo, point : array_like (k,) of int
        Photo and point of each ray.
    interior : int
        Unknowns of the interior orientation.
    border : int
        Inner constraints G on the points, which border the matrix; 0 for none.
    eliminated : bool
        After the points were eliminated: the Schur complement.

    Returns
    -------
    list of (row, column, rows, columns, kind)
        First row and column and size of each block, in unknowns: interior
        orientation, exteriors (6 a photo), points (3 each), border. Kinds are the
        keys of `COLORS`.
    """
    interior = _validate.whole(interior, "interior", 0, 10**4)
    border = _validate.whole(border, "border", 0, 10**4)
    eliminated = _validate.flag(eliminated, "eliminated")
    photo, point, m, n = _rays(photo, point)
    seen = np.zeros((m, n), dtype=bool)
    seen[photo, point] = True
    first = interior + 6 * m  # of the points
    blocks: list = [(0, 0, interior, interior, "interior")] if interior else []
    exteriors = interior + 6 * np.arange(m)
    mirrored: list = [(0, at, interior, 6, "interior") for at in exteriors if interior]
    if eliminated:
        common = seen.astype(int) @ seen.T > 0
        for i, j in np.argwhere(common):
            kind = "exteriors, 6 × 6" if i == j else "filled in"
            blocks.append((exteriors[i], exteriors[j], 6, 6, kind))
        if border:
            # The points were all that G touched: now it meets everything
            mirrored.append((0, first, first, border, "datum G"))
            blocks.append((first, first, border, border, "datum G"))
    else:
        points = first + 3 * np.arange(n)
        blocks += [(at, at, 6, 6, "exteriors, 6 × 6") for at in exteriors]
        blocks += [(at, at, 3, 3, "points, 3 × 3") for at in points]
        mirrored += [(0, at, interior, 3, "interior") for at in points if interior]
        rays = np.argwhere(seen)
        mirrored += [(exteriors[i], points[j], 6, 3, "rays") for i, j in rays]
        if border:
            mirrored.append((first, first + 3 * n, 3 * n, border, "datum G"))
    blocks += mirrored
    blocks += [(j, i, columns, rows, kind) for i, j, rows, columns, kind in mirrored]
    return [(int(i), int(j), int(r), int(c), kind) for i, j, r, c, kind in blocks]


def normal_matrix(
    photo: ArrayLike, point: ArrayLike, interior: int = 10, border: int = 7
) -> Figure:
    """Draw which blocks of the normal matrix are filled, with and without the points.

    Left the normal matrix, bordered by the inner constraints; right, to the same scale,
    what remains to be solved when the points are eliminated.

    Parameters
    ----------
    photo, point, interior, border
        As for `normal_blocks`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    interior = _validate.whole(interior, "interior", 0, 10**4)
    border = _validate.whole(border, "border", 0, 10**4)
    photo, point, m, n = _rays(photo, point)
    groups = [(f"interior {interior}", interior), (f"{m} × 6 photos", 6 * m)]
    groups += [(f"{n} × 3 points", 3 * n), (f"G {border}", border)]
    groups = [group for group in groups if group[1]]
    size = sum(count for _, count in groups)
    fig, ax = plt.subplots(figsize=(13, 6.6))
    _blocks(ax, 0, normal_blocks(photo, point, interior, border), groups, -1)
    start = 1.28 * size
    blocks = normal_blocks(photo, point, interior, border, eliminated=True)
    groups = [group for group in groups if not group[0].endswith("points")]
    reduced = _blocks(ax, start, blocks, groups, 1)
    middle = reduced / 2
    arrow: Look = {"arrowstyle": "-|>", "linewidth": 3, "mutation_scale": 22}
    ends = (start - 0.03 * size, middle), (1.03 * size, middle)
    ax.annotate("", *ends, arrowprops=arrow | {"color": basic.BLACK})
    text: Look = {"ha": "center", "va": "bottom", "fontsize": 15}
    ax.text((start + size) / 2, middle - 0.02 * size, "eliminate\nthe points", **text)
    used = {kind for *_, kind in normal_blocks(photo, point, interior, border) + blocks}
    handles = [Patch(color=color) for kind, color in COLORS.items() if kind in used]
    labels = [kind for kind in COLORS if kind in used]
    at: Look = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.0), "fontsize": 15}
    ax.legend(handles, labels, title="not zero", title_fontsize=15, **at)
    ax.set(xlim=(-0.3 * size, start + reduced + 0.3 * size), aspect="equal")
    ax.set_ylim(1.01 * size, -0.09 * size)
    ax.set_axis_off()
    return fig


def _rays(
    photo: ArrayLike, point: ArrayLike
) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Photo and point of each ray, and how many there are of both."""
    photo = _validate.indices(photo, MOST, "photo")
    point = _validate.indices(point, MOST, "point", len(photo))
    if not len(photo):
        raise ValueError("photo and point must hold one ray or more")
    return photo, point, int(photo.max()) + 1, int(point.max()) + 1


def _blocks(
    ax: Axes,
    start: float,
    blocks: Sequence[tuple[int, int, int, int, str]],
    groups: Sequence[tuple[str, int]],
    side: int,
) -> int:
    """Draw blocks from x = start on, and name the groups of rows left or right."""
    size = sum(count for _, count in groups)
    for kind, color in COLORS.items():
        tiles = [
            Rectangle((start + j, i), columns, rows)
            for i, j, rows, columns, this in blocks
            if this == kind
        ]
        look: Look = {"facecolor": color, "edgecolor": "white", "linewidth": 0.4}
        ax.add_collection(PatchCollection(tiles, **look), autolim=False)
    ax.add_patch(Rectangle((start, 0), size, size, fill=False, linewidth=1.5))
    edge, border = 0, start + (size if side > 0 else 0)
    for name, count in groups:
        x = border + 5 * side
        ax.plot(
            [x, x], [edge + 0.8, edge + count - 0.8], color=basic.BLACK, linewidth=2
        )
        text: Look = {"ha": "left" if side > 0 else "right", "va": "center"}
        ax.text(x + 4 * side, edge + count / 2, name, fontsize=15, **text)
        edge += count
    filled = sum(rows * columns for _, _, rows, columns, _ in blocks) / size**2
    head = f"{size} × {size}, {100 * filled:.0f} % filled"
    ax.text(start, -6, head, ha="left", va="bottom", fontsize=17)
    return size


def correlation_matrix(result: Bundle, camera: int = 0) -> Figure:
    """Draw the correlations of the interior orientation, with the numbers.

    Left among its parameters; right with the exterior orientation, as the mean of the
    absolute values over the photos: rolled photos would cancel their signs.

    Parameters
    ----------
    result : bundle.Bundle
    camera : int
        Index of the camera.

    Returns
    -------
    matplotlib.figure.Figure
    """
    camera = _doors.bundle(result, camera)
    place = places(result, camera)
    names, rows = [symbol(name) for name in place], list(place.values())
    u = len(result.interior_names)
    among = result.correlation[np.ix_(rows, rows)].copy()
    among[np.triu_indices(len(rows), 1)] = np.nan  # once is enough
    own = result.network.camera == camera
    outer = result.correlation[rows, u:].reshape(len(rows), -1, 6)[:, own]
    n = len(names)
    fig, axes = plt.subplots(
        1, 2, figsize=(13, 1.6 + 0.56 * n), width_ratios=(n, 6), squeeze=True
    )
    _numbers(axes[0], among, names, names)
    _numbers(axes[1], np.abs(outer).mean(axis=1), names, EXTERIOR)
    axes[0].set_title("Correlation of the interior orientation")
    axes[1].set_title("with the exterior, mean |r|")
    return fig


def _numbers(
    ax: Axes, values: np.ndarray, rows: Sequence[str], columns: Sequence[str]
) -> None:
    """Show a matrix by colour, with its numbers in the cells."""
    ax.imshow(values, cmap="PuOr", vmin=-1, vmax=1, aspect="auto")
    for (i, j), value in np.ndenumerate(values):
        if np.isfinite(value) and not (rows is columns and i == j):
            color = "white" if abs(value) > 0.6 else basic.BLACK
            weight = "bold" if abs(value) > 0.9 else "normal"
            text = f"{round(value, 2) + 0.0:.2f}".replace("-", "−")
            look: Look = {"ha": "center", "va": "center", "weight": weight}
            ax.text(j, i, text, fontsize=13, color=color, **look)
    ax.set_xticks(range(len(columns)), columns)
    ax.set_yticks(range(len(rows)), rows)
    ax.grid(False)
    ax.tick_params(length=0, labelsize=15)
    ax.spines[:].set_visible(False)


def spectrum(
    values: Mapping[str, ArrayLike], tolerances: Mapping[str, float] | None = None
) -> Figure:
    """Draw singular values, and what a pseudo-inverse at a tolerance throws away.

    Parameters
    ----------
    values : mapping of str to array_like (n,)
        Singular values of matrices, by name.
    tolerances : mapping of str to float
        Tolerance of the matrices that have one: what lies below, drawn hollow, counts
        as zero.

    Returns
    -------
    matplotlib.figure.Figure
    """
    values = _validate.mapping(values, "values")
    limits = {} if tolerances is None else _validate.mapping(tolerances, "tolerances")
    if not 0 < len(values) <= len(SERIES):
        raise ValueError(f"values must be 1 to {len(SERIES)} matrices")
    fig, ax = plt.subplots(figsize=(11, 5.8))
    ax.set_yscale("log")
    for (name, s), (color, mark) in zip(values.items(), SERIES):
        s = -np.sort(-_validate.of_shape(s, (None,), f"values, {name}"))
        tolerance = limits.get(name, 0.0)
        tolerance = _validate.not_negative(
            tolerance, f"tolerances, {name}", "as values"
        )
        if not np.any(s > 0):
            raise ValueError(f"values, {name}: no singular value is above zero")
        number, kept = np.arange(1, len(s) + 1), s > tolerance
        look: Look = {"color": color, "marker": mark, "linestyle": "", "markersize": 6}
        label = f"{name}: {kept.sum()} of {len(s)} kept" if tolerance else name
        ax.plot(number[kept], s[kept], label=label, **look)
        seen = ~kept & (s > 0)
        ax.plot(number[seen], s[seen], markerfacecolor="none", **look)
        if tolerance:
            ax.axhline(tolerance, color=color, linestyle="--", linewidth=1.8)
            text: Look = {"color": color, "ha": "right", "va": "bottom"}
            text |= {"fontsize": 13, "transform": ax.get_yaxis_transform()}
            ax.text(0.995, tolerance, "tolerance", **text)
    ax.set(xlabel="number of the singular value")
    ax.set(ylabel="singular value (mixed units)")
    ax.set_title("Singular values; those drawn hollow count as zero")
    ax.legend(loc="best")
    return fig
