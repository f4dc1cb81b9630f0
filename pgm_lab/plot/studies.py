"""Figures of experiments with bundles: solutions, simulations, sizes of networks."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot._style import SERIES, UM, plain, symbol
from pgm_lab.plot.basic import Look


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
