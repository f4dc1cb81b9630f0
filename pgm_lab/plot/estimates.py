"""Figures of an adjustment: what is made least, where it lies, and how good it is."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look


def parabolas(observed: ArrayLike, p: ArrayLike, names: Sequence[str]) -> None:
    """Show p v^2 of observations of one unknown, and their sum, over the unknown.

    Parameters
    ----------
    observed : array_like (n,)
        Observations of the same height, in metres.
    p : array_like (n,)
        Their weights, in 1 / km.
    names : sequence of str
        What the observations are called.
    """
    observed = _validate.of_shape(observed, (None,), "observed")
    p = _validate.of_shape(_validate.positive(p, "p", "1 / km"), observed.shape, "p")
    labels = _validate.texts(names, "names", len(observed))
    if len(observed) == 0:
        raise ValueError("observed must hold at least one observation")
    best = float(np.sum(p * observed) / np.sum(p))
    reach = max(1.6 * float(np.max(np.abs(observed - best))), 1e-3)
    H = best + np.linspace(-reach, reach, 201)
    terms = 1e6 * p[:, None] * (H - observed[:, None]) ** 2
    fig, ax = plt.subplots(figsize=(7, 3.6))
    styles = ("--", ":", "-.")
    for k, (term, label) in enumerate(zip(terms, labels)):
        ax.plot(H, term, linestyle=styles[k % 3], label=f"p v² of {label}")
    ax.plot(H, terms.sum(axis=0), color=basic.BLACK, linewidth=3, label="their sum")
    least = 1e6 * np.sum(p * (best - observed) ** 2)
    ax.plot(best, least, "v", color=basic.RED, markersize=15, label="least")
    ax.ticklabel_format(useOffset=False)
    ax.set(xlabel="height of D (m)", ylabel="p v² (mm² / km)", ylim=(0, None))
    ax.locator_params(axis="x", nbins=5)
    ax.legend(loc="upper center")
    basic.show(
        fig,
        f"Parabolas of p v² over the height, of {len(labels)} observations, narrow"
        f" where the weight is large, and their sum, which is least at {best:.4f} m.",
    )


def observation_space() -> Figure:
    """Draw three observations as one point, and the plane of all that the model allows.

    Returns
    -------
    matplotlib.figure.Figure
        With the observations l, the column space of A, the adjusted observations in
        it, the residuals v at right angles to it, and another point for comparison.
    """
    fig, ax = plt.subplots(figsize=(10, 3.9))
    plane = np.array([(0.0, 0.0), (5.2, -0.35), (7.4, 1.35), (2.2, 1.7)])
    ax.fill(*plane.T, color=basic.SKY, alpha=0.35, linewidth=0)
    zero, best, other = np.zeros(2), np.array([3.7, 0.55]), np.array([5.9, 1.0])
    observed = best + (0.0, 2.2)
    axes = {1: (2.9, -1.0), 2: (2.0, 2.5), 3: (0.0, 2.6)}
    arrows = [(zero, np.array(tip), basic.GREY, 1.6) for tip in axes.values()]
    arrows += [
        (zero, observed, basic.BLACK, 3.0),
        (zero, best, basic.BLUE, 3.0),
        (observed, best, basic.RED, 3.0),
    ]
    for start, end, colour, width in arrows:
        look: Look = {"arrowstyle": "-|>", "color": colour, "linewidth": width}
        look |= {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 22}
        ax.annotate("", (end[0], end[1]), (start[0], start[1]), arrowprops=look)
    ax.plot(*np.transpose([observed, other]), "--", color=basic.ORANGE)
    ax.plot(*other, "o", color=basic.ORANGE, markersize=10)
    back = best - 0.28 * best / np.linalg.norm(best)
    corner = [back, back + (0, 0.25), best + (0, 0.25)]
    ax.plot(*np.transpose(corner), color=basic.BLACK, linewidth=1.6)
    words = [
        (observed + (0.12, 0.05), "$l$: what was measured", basic.BLACK),
        (best + (0.12, -0.3), r"$A\hat{x} = l + v$: adjusted", basic.BLUE),
        ((observed + best) / 2 + (0.1, 0), "$v$", basic.RED),
        (other + (0.2, 0.0), "another $Ax$: farther from $l$", basic.BLACK),
        ((6.2, 1.6), "plane of all $Ax$", basic.BLUE),
    ]
    for k, tip in axes.items():
        beside = np.array([-0.75 if k == 3 else 0.1, -0.05])
        words.append((tip + beside, f"$l_{k} / \\sigma_{k}$", basic.GREY))
    for place, word, colour in words:
        x, y = place
        ax.text(x, y, word, fontsize=16, color=colour)
    ax.set(xlim=(-0.9, 8.8), ylim=(-1.25, 3.1))
    ax.axis("off")
    return fig


def scatter(sigma0s: ArrayLike, ours: float, stated: float, redundancy: int) -> None:
    """Show how sigma0 scatters over repeated surveys, with the limits of a global test.

    Parameters
    ----------
    sigma0s : array_like (m,)
        Estimates of the repeated surveys, in millimetres.
    ours, stated : float
        The estimate of one survey, and what was stated before.
    redundancy : int
        Observations less unknowns.
    """
    sigma0s = _validate.of_shape(sigma0s, (None,), "sigma0s")
    ours = _validate.positive_number(ours, "ours", "mm")
    stated = _validate.positive_number(stated, "stated", "mm")
    r = _validate.whole(redundancy, "redundancy", 1)
    low, high = stated * np.sqrt(scipy.stats.chi2.ppf((0.025, 0.975), r) / r)
    fig, ax = plt.subplots(figsize=(7, 3.1))
    label = f"{len(sigma0s)} honest surveys"
    bins = np.linspace(0, max(2.4 * stated, ours), 33)
    ax.hist(sigma0s, bins.tolist(), color=basic.SKY, label=label)
    for limit in (low, high):
        ax.axvline(limit, color=basic.BLACK, linestyle="--")
        place: Look = {"transform": ax.get_xaxis_transform(), "ha": "center"}
        ax.text(limit, 1.02, f"{limit:.1f} mm", **place)
    look: Look = {"color": basic.RED, "markersize": 16, "label": f"ours: {ours:.2f} mm"}
    ax.plot(ours, 0.04, "v", transform=ax.get_xaxis_transform(), **look)
    ax.set(xlabel="σ₀ from the residuals (mm)", ylabel="surveys")
    ax.set_xlim(0, float(max(bins[-1], 2 * high)))
    ax.legend(loc="upper right")
    within = np.mean((sigma0s > low) & (sigma0s < high)) if len(sigma0s) else np.nan
    basic.show(
        fig,
        f"Histogram of sigma0 of {len(sigma0s)} repeated surveys. {100 * within:.0f}"
        f" per cent lie between the dashed limits {low:.1f} and {high:.1f} mm; ours is"
        f" {ours:.2f} mm.",
    )


def tangent(base: float, depth: float, start: float) -> None:
    """Show where the tangent of an angle over the depth leads from a start value.

    Parameters
    ----------
    base : float
        Distance of the two stations, in metres.
    depth, start : float
        How far the point is away, and what is taken to begin with.
    """
    base = _validate.positive_number(base, "base", "metres")
    depth = _validate.positive_number(depth, "depth", "metres")
    start = _validate.positive_number(start, "start", "metres")

    def angle(Y: np.ndarray | float) -> np.ndarray:
        return np.asarray(2000 * np.arctan2(base / 2, Y))

    slope = -1000 * base / (start**2 + base**2 / 4)
    end = start + float(angle(depth) - angle(start)) / slope
    fig, ax = plt.subplots(figsize=(7, 3.2))
    left, right = min(end, 0.0) - 0.15 * start, 1.2 * start
    Y = np.linspace(0.3 * depth, right, 300)
    ax.plot(Y, angle(Y), color=basic.BLUE, label="angle between the rays")
    line = np.array([end, right])
    ax.plot(line, angle(start) + slope * (line - start), "--", color=basic.ORANGE,
            label="Taylor's first term")  # fmt: skip
    ax.axhline(float(angle(depth)), color=basic.GREY, linestyle=":", label="measured")
    ax.plot(start, angle(start), "o", color=basic.BLACK, markersize=11)
    ax.plot(end, angle(depth), "X", color=basic.RED, markersize=14)
    ax.plot(depth, angle(depth), "*", color=basic.BLACK, markersize=18)
    marks = {"start": (start, angle(start)), "first step": (end, angle(depth))}
    marks |= {"point": (depth, angle(depth))}
    above: Look = {"textcoords": "offset points", "xytext": (9, 9)}
    for name, (Y0, seen) in marks.items():
        ax.annotate(name, (float(Y0), float(seen)), **above)
    ax.axvline(0, color=basic.BLACK, linewidth=1)
    ax.text(8, float(angle(0.32 * depth)), "stations", rotation=90, va="top")
    ax.set(xlim=(left, right), xlabel="Y (m)", ylabel="angle (mrad)")
    ax.set_ylim(0, 1.05 * float(angle(0.3 * depth)))
    ax.legend(loc="upper left")
    basic.show(
        fig,
        "The angle between two rays falls with the depth Y, steeply at first and then"
        f" ever less. The tangent at the start, Y = {start:.0f} m, is much flatter than"
        f" the curve at the point, Y = {depth:.0f} m: it meets the measured angle at"
        f" Y = {end:.0f} m.",
    )


def point(
    stations: ArrayLike,
    position: ArrayLike,
    covariance: ArrayLike,
    errors: ArrayLike,
    magnify: float = 400.0,
) -> None:
    """Show rays to a point with its error ellipse, and the errors of repetitions in it.

    Parameters
    ----------
    stations : array_like (k, 2)
        Where the rays begin, in metres.
    position : array_like (2,)
        The point.
    covariance : array_like (2, 2)
        Its covariance, in square metres.
    errors : array_like (m, 2)
        Errors of repeated measurements, in metres.
    magnify : float
        Factor by which the ellipse at the point is drawn too large.
    """
    stations = _validate.point_list(stations, "stations")
    if len(stations) == 0:
        raise ValueError("stations must hold at least one station")
    position = _validate.one_point(position, 2, "position")
    errors = _validate.point_list(errors, "errors")
    magnify = _validate.positive_number(magnify, "magnify", "a factor")
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.3))
    for station in stations:
        way = np.transpose([station, position])
        axes[0].plot(*way, color=basic.GREY, linewidth=1.4)
    axes[0].plot(*stations.T, "^", color=basic.BLACK, markersize=12)
    basic.error_ellipse(axes[0], position, covariance, magnify=magnify)
    axes[0].set(xlabel="X (m)", ylabel="Y (m)")
    axes[0].set_title(f"rays, and 95 %\nellipse × {magnify:g}", fontsize=14)
    first = stations[np.argmin(stations[:, 0])]
    axes[0].annotate(
        "stations", first, xytext=(-12, 0), textcoords="offset points",
        ha="right", va="center",
    )  # fmt: skip
    axes[0].margins(0.12)
    C = _validate.of_shape(covariance, (2, 2), "covariance")
    look: Look = {"markersize": 3, "alpha": 0.6, "color": basic.BLUE}
    axes[1].plot(*(1000 * errors.T), ".", **look)
    basic.error_ellipse(axes[1], (0, 0), 1e6 * C, linewidth=3)
    axes[1].set(xlabel="error in X (mm)", ylabel="error in Y (mm)")
    axes[1].set_title(f"{len(errors)} repetitions\nand 95 % ellipse", fontsize=14)
    for ax in axes:  # as wide as there is room: both are tall and narrow
        ax.set_aspect("equal", adjustable="datalim")
    sd = 1000 * np.sqrt(np.diag(C))
    basic.show(
        fig,
        f"Left, {len(stations)} stations, their rays to a point and its error ellipse,"
        f" enlarged {magnify:g} times. The standard deviations are {sd[0]:.0f} mm in X"
        f" and {sd[1]:.0f} mm in Y. Right, the errors of {len(errors)} repetitions, and"
        " the predicted ellipse around nearly all of them.",
    )
