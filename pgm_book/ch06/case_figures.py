"""Figures of a published bundle adjustment on trial, and of networks to choose from."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab import bundle as room
from pgm_lab.bundle.lens import places
from pgm_lab.bundle.result import Bundle
from pgm_lab.plot import _doors, basic, bundle
from pgm_lab.plot.basic import SERIES, Look, plain
from pgm_lab.plot.bundle import UM, symbol

# Colour, marker and line of a defect's curve
LOOKS = {
    "sign": (basic.RED, "s", "-"),
    "rho": (basic.ORANGE, "^", "-"),
    "rows": (basic.BLACK, "X", "--"),
    "centre twice": (basic.PURPLE, "v", ":"),
    "x/c": (basic.GREEN, "D", "-"),
    "pinv": (basic.SKY, "P", "-"),
    "2 P1 xy": (basic.GREY, ">", "-"),
    "short": (basic.GREY, "<", "--"),
    "none": (basic.BLUE, "o", "-"),
}


def by_photo(rms: Mapping[str, ArrayLike]) -> None:
    """Show the RMS of the residuals of several solutions in each photo.

    Parameters
    ----------
    rms : mapping of str to array_like (m,)
        RMS in mm, by the name of the solution.
    """
    fig = residuals_by_photo(rms)
    fig.set_size_inches(7, 3.7)
    text = "; ".join(
        f"{name} {1000 * np.min(values):.2g} to {1000 * np.max(values):.2g} µm"
        for name, values in rms.items()
    )
    basic.show(fig, f"RMS of the residuals in each photo on a log scale: {text}.")


def steps(runs: Mapping[str, ArrayLike]) -> None:
    """Show what becomes of the residuals with each defect alone.

    Parameters
    ----------
    runs : mapping of str to array_like (k,)
        RMS of an image coordinate after each step, mm, by the name of the defect.
    """
    given = _validate.mapping(runs, "runs")
    fig, ax = plt.subplots(figsize=(7, 4.1), layout="constrained")
    for name, rms in given.items():
        values = 1000 * _validate.positive(rms, f"runs, {name}", "mm")
        if values.ndim != 1:
            raise ValueError(f"runs, {name}, must be a list of numbers")
        colour, marker, line = LOOKS.get(name, (basic.GREY, "o", "-"))
        look: Look = {"color": colour, "marker": marker, "ls": line, "ms": 9}
        ax.plot(values[:11], label=name, **look)
    ax.set(yscale="log", ylim=(0.15, 3e5), xlim=(-0.2, 10.2), xticks=range(0, 11, 2))
    ax.set(xlabel="steps", ylabel="RMS of a coordinate (µm)")
    fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    basic.show(
        fig,
        "RMS after each step for each defect alone, log scale. None, short and 2 P1 xy"
        " reach 0.31 micrometres after one to three steps; pinv stays at 8.2, x/c at"
        " 86, centre twice jumps between 0.3 and 130; rows comes to 0.8 and slowly"
        " grows again, rho and sign run away to a millimetre and more.",
    )


def kept(values: Mapping[str, ArrayLike], limit: float) -> None:
    """Show singular values of a normal matrix, and the limit of a pseudo-inverse.

    Parameters
    ----------
    values : mapping of str to array_like (n,)
        Singular values in descending order; the limit belongs to the first.
    limit : float
        What lies below counts as zero.
    """
    series = {
        name: _validate.positive(one, f"values, {name}", "singular values")
        for name, one in _validate.mapping(values, "values").items()
    }
    if not series or any(one.ndim != 1 for one in series.values()):
        raise ValueError("values must hold one list of singular values or more")
    limit = _validate.positive_number(limit, "limit", "a singular value")
    first = next(iter(series))
    fig = spectrum(series, {first: limit})
    fig.set_size_inches(7, 3.8)
    basic.show(
        fig,
        "Singular values of the normal matrix in descending order on a log scale. As"
        " the units have it they span 16 powers of ten, and only 34 of 221 lie above"
        " the tolerance; with each column scaled they span less than seven, and all lie"
        " far above it.",
    )


def left_over(result: room.Bundle) -> None:
    """Show the residuals of four photos, those beyond the limit with their points.

    Parameters
    ----------
    result : Bundle
        The adjusted network of 2013.
    """
    _validate.instance(result, room.Bundle, "result")
    photos = [k for k in (1, 3, 5, 6) if k < len(result.exteriors)]
    fig = bundle.residual_vectors(result, photos)
    fig.set_size_inches(7, 4.3)
    fig.suptitle(fig.get_suptitle().replace("; red", "\nred"), fontsize=15)
    basic.show(
        fig,
        "Residual vectors in four photos, drawn much too large. Most point in all"
        " directions, some neighbours alike; a few are much longer and drawn in red,"
        " near the edges of photos 2, 6 and 7.",
    )


def networks(given: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> None:
    """Draw networks seen from the side, the photos as squares with their upper edge.

    Parameters
    ----------
    given : mapping of str to (exteriors (m, 6), points (n, 3))
        By the names of the networks.
    """
    several = _validate.mapping(given, "given")
    if not several:
        raise ValueError("given must hold one network or more")
    columns = min(3, len(several))
    rows = -(-len(several) // columns)
    fig, axes = plt.subplots(rows, columns, figsize=(10, 1.9 * rows), squeeze=False)
    for ax in axes.flat:
        ax.axis("off")
    for ax, (name, one) in zip(axes.flat, several.items()):
        parts = _validate.several(one, f"given, {name}")
        if len(parts) != 2:
            raise ValueError(f"given, {name}, must be exteriors and points")
        exteriors = _validate.of_shape(parts[0], (None, 6), f"given, {name}")
        points = _validate.points(parts[1], 3, f"given, {name}")
        _from_the_side(ax, exteriors, points)
        ax.set_title(name, fontsize=16, loc="left")
    exactly: Look = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.012}
    axes[0, 0].quiver([1000, 1000], [-1400] * 2, [500, 0], [0, 500], **exactly)
    for x, z, word in ((1580, -1400, "Y"), (1000, -750, "Z"), (1100, -1150, "500 mm")):
        ha = "left" if word.endswith("mm") else "center"
        axes[0, 0].text(x, z, word, fontsize=13, ha=ha, va="center")
    basic.show(
        fig,
        "Networks seen from the side, the object in grey, the axes of the photos in"
        " blue; a square stands for a photo, its thick side for the top of the sensor;"
        f" arrows of 500 mm along Y and Z: {'; '.join(several)}.",
    )


def _from_the_side(ax: Axes, exteriors: np.ndarray, points: np.ndarray) -> None:
    """Draw object, axes and rolls of the photos; Y to the right, Z upwards."""
    ax.plot(*points[:, 1:].T, ".", color=basic.GREY, ms=5)
    places: list[np.ndarray] = []
    for _, y, z, *angles in exteriors:
        view, kappa = -rotation.matrix(*angles)[2], angles[2]
        way = 0.9 * np.hypot(*(points.mean(axis=0)[1:] - (y, z)))
        ax.plot([y, y + way * view[1]], [z, z + way * view[2]], color=basic.SKY, lw=1.5)
        ax.plot(y, z, "o", color=basic.BLUE, ms=5)
        near = [a for a in places if np.hypot(*(a - (y, z))) < 150]
        places.append(near[0] if near else np.array([y, z]))
        edges = kappa + np.pi / 4 + np.pi / 2 * np.arange(5)
        square = 106 * np.column_stack([np.cos(edges), np.sin(edges)])
        square += places[-1] - (170 + 240 * len(near)) * view[1:]
        ax.plot(*square.T, color=basic.BLACK, lw=1)
        ax.plot(*square[:2].T, color=basic.RED, lw=4)
    ax.set(aspect="equal", xlim=(-850, 1900), ylim=(-1500, 750))


def precisions(sds: Mapping[str, ArrayLike]) -> None:
    """Show how well some networks know c, x0 and y0.

    Parameters
    ----------
    sds : mapping of str to array_like (3,)
        Standard deviations in µm by the name of the network; NaN where c cannot be
        determined.
    """
    several = _validate.mapping(sds, "sds")
    rows = [_validate.real(v, f"sds, {name}") for name, v in several.items()]
    values = np.array(rows) if {row.shape for row in rows} == {(3,)} else np.zeros(1)
    if values.ndim != 2 or np.any(values <= 0) or np.any(np.isinf(values)):
        raise ValueError("sds must hold three positive numbers (or NaN) a network")
    fig, ax = plt.subplots(figsize=(7, 3.6), layout="constrained")
    for k, (name, colour, marker) in enumerate(
        (
            ("c", basic.RED, "o"),
            ("$x_0$", basic.BLUE, "s"),
            ("$y_0$", basic.GREEN, "D"),
        )
    ):
        at = np.arange(len(values)) + 0.16 * (k - 1)
        ax.plot(values[:, k], at, marker, color=colour, label=name, ms=11)
    for row in np.flatnonzero(np.isnan(values[:, 0])):
        ax.text(60, float(row), "c cannot be determined", va="center", fontsize=15)
    ax.set(xscale="log", xlim=(4, 2500), xlabel="standard deviation (µm)")
    ax.set_xticks((5, 20, 100, 500, 2000), ("5", "20", "100", "500", "2000"))
    ax.set_yticks(range(len(several)), list(several))
    ax.minorticks_off()
    ax.invert_yaxis()
    fig.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    said = "; ".join(
        f"{name.strip()}: {', '.join(f'{x:.0f}' for x in row)}"
        for name, row in zip(several, values)
    )
    basic.show(
        fig,
        "Standard deviations of c, x0 and y0 in micrometres on a log scale, nan where c"
        f" cannot be determined. {said}.",
    )


def scatter(ratio: Mapping[str, float], networks: int) -> None:
    """Show how far simulated networks scatter, over what the covariance predicts.

    Parameters
    ----------
    ratio : mapping of str to float
        Scatter over predicted standard deviation, by the name of the quantity.
    networks : int
        Number of simulated networks.
    """
    given = _validate.mapping(ratio, "ratio")
    networks = _validate.whole(networks, "networks", 2)
    values = np.array(
        [
            _validate.positive_number(one, f"ratio, {key}", "1")
            for key, one in given.items()
        ]
    )
    fig = predicted_against_sampled(np.ones(len(given)), values, list(given), networks)
    fig.set_size_inches(7, 3.5)
    (ax,) = fig.axes
    for label in ax.get_xticklabels()[::2]:  # words beside words
        label.set_y(-0.06 if len(label.get_text()) > 5 else 0)
    ax.set_title("")
    ax.legend(loc="lower left", ncols=2)
    basic.show(
        fig,
        f"Scatter of {networks} simulated networks over the predicted standard"
        f" deviation, between {values.min():.2f} and {values.max():.2f}, with the band"
        " that holds 95 per cent of them.",
    )


def speed(
    rays: ArrayLike,
    seconds: Mapping[str, ArrayLike],
    megabytes: ArrayLike,
    labels: Sequence[str],
) -> None:
    """Show time and memory of adjustments of growing networks.

    Parameters
    ----------
    rays : array_like (k,)
        Number of rays of each network, ascending.
    seconds : mapping of str to array_like (k,)
        Seconds by program; the first is the one that the memory belongs to.
    megabytes : array_like (k,)
        Most memory held at once.
    labels : sequence of k str
        What stands at the networks, such as their number of photos.
    """
    fig = size_study(rays, seconds, megabytes, labels)
    fig.set_size_inches(9, 4.2)
    fig.axes[0].legend().remove()  # its lines would pass below it
    shown = fig.axes[0].get_legend_handles_labels()
    fig.legend(*shown, loc="outside lower center", ncols=len(seconds))
    last = ", ".join(f"{name} {np.asarray(t)[-1]:.3g} s" for name, t in seconds.items())
    basic.show(
        fig,
        "Left, time against the number of rays, both on log scales: lines that rise"
        f" together; for the largest network {last}. Right, the memory, up to"
        f" {np.max(megabytes):.0f} megabytes.",
    )


# --- Figures of experiments with bundles: solutions, simulations, sizes of networks ---


def residuals_by_photo(
    rms: Mapping[str, ArrayLike], photo_names: Sequence[str] | None = None
) -> Figure:
    """Draw the RMS of the residuals in each photo, for several solutions.

    Parameters
    ----------
    rms : mapping of str to array_like (m,)
        RMS of the residuals of m photos in mm, by the name of the solution.
    photo_names : sequence of str, optional
        Names of the photos; 1, 2, ... if missing.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the solutions have not the same number of photos.
    """
    series = _same_length(_validate.mapping(rms, "rms"), "rms")
    for name, values in series.items():
        _validate.positive(values, f"rms, {name}", "mm")
    m = len(next(iter(series.values())))
    given = range(1, m + 1) if photo_names is None else photo_names
    given = _validate.several(given, "photo_names")
    if len(given) != m or not all(isinstance(one, str | int) for one in given):
        raise ValueError(f"photo_names must be {m} texts or numbers; got {len(given)}")
    names = list(map(str, given))
    fig, ax = plt.subplots(figsize=(11, 5.4))
    width = 0.8 / len(series)
    hatches = ("", "//", "..", "xx", "\\\\", "++", "--")
    everything = UM * np.concatenate(list(series.values()))
    floor = 10.0 ** np.floor(np.log10(everything.min()) - 0.2)
    for i, (name, values) in enumerate(series.items()):
        at = np.arange(m) + (i - (len(series) - 1) / 2) * width
        look: Look = {"color": SERIES[i][0], "hatch": hatches[i], "edgecolor": "white"}
        height = UM * values - floor
        ax.bar(at, height, 0.94 * width, bottom=floor, label=name, **look)
    ax.set(yscale="log", ylim=(floor, 1.3 * everything.max()))
    plain(ax.yaxis, (1,))
    ax.set(xlabel="photo", ylabel="RMS of the residuals (µm)")
    ax.set_xticks(range(m), names)
    ax.grid(False, axis="x")
    ax.tick_params(axis="x", length=0)
    ax.legend(loc="upper center", ncols=len(series), bbox_to_anchor=(0.5, 1.13))
    return fig


def predicted_against_sampled(
    predicted: ArrayLike,
    sampled: ArrayLike | Mapping[str, ArrayLike],
    names: Sequence[str],
    samples: int,
) -> Figure:
    """Draw the scatter found in simulated networks over the predicted one.

    Parameters
    ----------
    predicted : array_like (k,)
        Standard deviations from the covariance.
    sampled : array_like (k,), or mapping of str to array_like (k,)
        Standard deviations (or RMS errors) over the networks; several by name.
    names : sequence of k str
        Names of the parameters.
    samples : int
        Number of simulated networks. The band holds 95 % of the standard deviations
        that so many give if the prediction is right.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the numbers of parameters differ.
    """
    names = _validate.texts(names, "names")
    samples = _validate.whole(samples, "samples", 2)
    if not isinstance(sampled, Mapping):
        sampled = {"sampled": sampled}
    series = _same_length({"predicted": predicted} | dict(sampled), "sampled", names)
    predicted = _validate.positive(series.pop("predicted"), "predicted", "its unit")
    low, high = np.sqrt(
        scipy.stats.chi2.ppf((0.025, 0.975), samples - 1) / (samples - 1)
    )
    fig, ax = plt.subplots(figsize=(11, 5.4))
    ax.axhspan(low, high, color=basic.GREY, alpha=0.25, label="95 %, if it holds")
    ax.axhline(1, color=basic.BLACK, linewidth=1.4)
    smallest = largest = 1.0
    for (name, values), (color, mark) in zip(series.items(), SERIES):
        ratio = values / predicted
        ax.plot(ratio, mark, color=color, markersize=11, label=name)
        smallest, largest = min(smallest, ratio.min()), max(largest, ratio.max())
    if largest > 4:
        ax.set_yscale("log")
        plain(ax.yaxis)
    else:  # the whole band, and room above it
        reach = max(2.2 * (high - 1), 1.2 * max(largest - 1, 1 - smallest))
        ax.set_ylim(1 - reach, 1 + reach)
    ax.set_xticks(range(len(names)), list(map(symbol, names)))
    ax.set(xlim=(-0.6, len(names) - 0.4), ylabel="sampled / predicted sd")
    ax.grid(False, axis="x")
    ax.set_title(f"Scatter in {samples} simulated networks over its prediction")
    ax.legend(loc="best")
    return fig


def size_study(
    rays: ArrayLike,
    seconds: Mapping[str, ArrayLike],
    megabytes: ArrayLike,
    labels: Sequence[str],
) -> Figure:
    """Draw time and memory of an adjustment against the size of the network.

    Parameters
    ----------
    rays : array_like (k,)
        Number of rays of each network, ascending.
    seconds : mapping of str to array_like (k,)
        Seconds by program; the first is the one that the memory belongs to.
    megabytes : array_like (k,)
        Most memory held at once.
    labels : sequence of k str
        What stands at the networks, such as their number of photos.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    ValueError
        If the lists have not the same length.
    """
    labels = _validate.texts(labels, "labels")
    seconds = _validate.mapping(seconds, "seconds")
    columns = {"rays": rays} | dict(seconds) | {"megabytes": megabytes}
    series = _same_length(columns, "rays, seconds and megabytes", labels)
    for name, values in series.items():
        _validate.positive(values, name, "to be drawn by its logarithm")
    rays, megabytes = series.pop("rays"), series.pop("megabytes")
    fig, (left, right) = plt.subplots(1, 2, figsize=(12, 4.8))
    for (name, values), (color, mark) in zip(series.items(), SERIES):
        look: Look = {"color": color, "marker": mark, "markersize": 9}
        left.plot(rays, values, "-", label=name, **look)
    right.plot(rays, megabytes, "o-", color=SERIES[0][0], markersize=9)
    for x, y, label in zip(rays, megabytes, labels):
        place: Look = {"textcoords": "offset points", "ha": "right", "fontsize": 13}
        right.annotate(label, (x, y), (-9, 3), **place)
    for ax, quantity in ((left, "time (s)"), (right, "memory (MB)")):
        ax.set(xscale="log", yscale="log", xlabel="rays", ylabel=quantity)
        plain(ax.yaxis, (1,))
    right.set(xlim=(rays.min() / 12, 2 * rays.max()), ylim=(None, 3 * megabytes.max()))
    left.legend(loc="upper left")
    return fig


def _same_length(
    series: Mapping[str, ArrayLike], name: str, names: Sequence[str] | None = None
) -> dict[str, np.ndarray]:
    arrays = {}
    for key, values in series.items():
        where = key if key in ("predicted", "rays", "megabytes") else f"{name}, {key}"
        arrays[key] = _validate.finite(values, where)
    if not 0 < len(arrays) <= len(SERIES) + 2:
        raise ValueError(f"{name} must hold 1 to {len(SERIES)} lists")
    shapes = {key: values.shape for key, values in arrays.items()}
    lengths = set(shapes.values()) | ({(len(names),)} if names is not None else set())
    if len(lengths) != 1 or any(len(shape) != 1 for shape in lengths):
        raise ValueError(f"{name} must hold lists of the same length; got {shapes}")
    return arrays


# --- Figures of the matrices of an adjustment: normal equations, correlations, spectra ---

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
