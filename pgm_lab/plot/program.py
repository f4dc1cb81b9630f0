"""Figures of a published bundle adjustment on trial, and of networks to choose from."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab import bundle as room
from pgm_lab.plot import basic, bundle, matrices, studies
from pgm_lab.plot.basic import Look

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
    fig = studies.residuals_by_photo(rms)
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
    fig = matrices.spectrum(series, {first: limit})
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
    fig = studies.predicted_against_sampled(
        np.ones(len(given)), values, list(given), networks
    )
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
    fig = studies.size_study(rays, seconds, megabytes, labels)
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
