"""Figures of a bundle adjustment: its lens, and its residuals on the photos.

Each takes the `Bundle` that `bundle.adjust` returns and draws in micrometres.
"""

import re
from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from pgm_lab._rounding import round_number, two_digits
from pgm_lab.bundle.lens import profile
from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look

UM = 1e3  # micrometres in a millimetre
MAX_PHOTOS = 16
LONG_NAME = 4  # of a file, which needs no "photo" before it
LONGEST_NAME = 15  # characters above a panel, so that the unit is seen
SYMBOL = {"w": "w", "tau": "τ"}


def lens_curve(result: Bundle, camera: int = 0) -> Figure:
    """Draw the radial distortion of the lens against the radius, with its 95 % band.

    The upper panel has the curve with its band, the lower one half the band's width.
    The radii at which points were measured are shaded: beyond them the curve is
    extrapolated.

    Parameters
    ----------
    result : bundle.Bundle
    camera : int
        Index of the camera.
    """
    network, lens = result.network, result.cameras[camera]
    own = network.camera[network.photo] == camera
    measured = np.hypot(*(network.xy[own] - (lens.x0, lens.y0)).T)
    rho = np.linspace(0, 1.1 * measured.max(), 301)
    quantile = scipy.special.stdtrit(result.redundancy or np.inf, 0.975)

    fig, axes = plt.subplots(
        2, 1, figsize=(10, 6.2), sharex=True, height_ratios=(1.7, 1)
    )
    distortion, sd = profile(result, rho, camera=camera)
    value, half = UM * distortion, UM * quantile * sd
    axes[0].plot(rho, value, color=basic.BLUE)
    band = {"color": basic.BLUE, "alpha": 0.25}
    axes[0].fill_between(rho, value - half, value + half, **band)
    axes[1].plot(rho, half, color=basic.BLUE)
    for ax in axes:
        ax.axvspan(measured.min(), measured.max(), color=basic.YELLOW, alpha=0.22)
        ax.axhline(0, color=basic.BLACK, linewidth=1)
    what = "correction" if lens.lens == "backward" else "distortion"
    axes[0].set(ylabel=f"{what} (µm)", xlim=(0, rho[-1]))
    axes[0].set_title(f"Lens {what} with its 95 % band")
    axes[1].set(
        xlabel="distance from the principal point (mm)", ylabel="half band (µm)"
    )
    at = {"x": measured.max(), "y": 0.93, "transform": axes[1].get_xaxis_transform()}
    axes[1].text(s="points measured up to here ", ha="right", va="top", **at)
    axes[1].set_ylim(bottom=0)
    return fig


def residual_vectors(
    result: Bundle,
    photo: int | Sequence[int] | None = None,
    magnify: float | None = None,
) -> Figure:
    """Draw the residuals on each photo, outliers in another colour.

    A dot is a measured point, the line from it its residual; a cross marks the
    principal point. The title of each photo gives the RMS of its residuals. An outlier,
    whose standardised residual is beyond `bundle.critical_value` of its test (Baarda's
    w or Pope's tau) in x or y, gets its name.

    Parameters
    ----------
    result : bundle.Bundle
    photo : int or sequence of int, optional
        Indices of photos. Default: all; of more than sixteen, those with the largest
        RMS.
    magnify : float, optional
        Factor by which the residuals are enlarged; default: a suitable round number.
    """
    network = result.network
    v = UM * result.residuals  # computed - observed
    critical = critical_value(result)
    outlier = np.any(np.abs(result.standardized) > critical, axis=1)
    m = len(result.exteriors)
    count = np.bincount(network.photo, minlength=m)
    square = np.bincount(network.photo, np.sum(v**2, axis=1), minlength=m)
    rms = np.sqrt(square / (2 * np.maximum(count, 1)))
    if photo is None:
        shown = np.sort(np.argsort(-rms, kind="stable")[:MAX_PHOTOS])
    else:
        shown = np.atleast_1d(photo)
    width = np.ptp(network.xy, axis=0).max()
    if magnify is None:
        usual = np.quantile(np.hypot(*v.T), 0.9) or 1.0  # µm
        magnify = round_number(0.16 * width / (usual / UM))
    # All photos have one frame, which contains their points and their residuals
    drawn = np.concatenate([network.xy, network.xy + magnify * v / UM])
    low, high = drawn.min(axis=0), drawn.max(axis=0)
    bar = round_number(0.25 * width / magnify * UM)

    columns = int(np.ceil(np.sqrt(len(shown))))
    rows = -(-len(shown) // columns)
    figsize = (10, 8) if len(shown) == 1 else (11, 0.6 + 2.75 * rows * 3 / columns)
    fig, axes = plt.subplots(rows, columns, figsize=figsize, squeeze=False)
    for ax in axes.flat[len(shown) :]:
        ax.set_axis_off()
    for i, ax in zip(shown, axes.flat):
        here = network.photo == i
        lens = result.cameras[network.camera[i]]
        ax.plot(lens.x0, lens.y0, "+", color=basic.GREY, markersize=16, zorder=1)
        for which, color, thick in (
            (~outlier, basic.BLUE, 1.0),
            (outlier, basic.RED, 1.8),
        ):
            xy, vectors = network.xy[here & which], v[here & which] / UM
            _pins(ax, xy, magnify * vectors, color, thick)
        named = np.flatnonzero(here & outlier)
        names = [str(network.point_names[j]) for j in network.point[named]]
        _name_outliers(ax, network.xy[named], names, high[0], 0.12 * width)
        name = str(network.photo_names[i])
        if len(name) > LONGEST_NAME:
            name = f"{name[:4]}…{name[5 - LONGEST_NAME :]}"
        size = f"{rms[i]:.2f}" if rms[i] >= 0.1 else two_digits(rms[i])
        name = name if len(name) > LONG_NAME else f"photo {name}"
        title = f"{name}: {size} µm"
        ax.set_title(title, fontsize=15, parse_math=False)
        margin = 0.06 * width
        right = high[0] + (0.32 * width if np.any(outlier) else margin)  # for names
        ax.set(xlim=(low[0] - margin, right))
        ax.set(ylim=(low[1] - 2.6 * margin, high[1] + margin))
        ax.set(aspect="equal", xticks=(), yticks=())
        ax.spines[:].set(visible=True, color=basic.GREY)
        start, level = low[0], low[1] - 1.7 * margin
        end = start + bar / UM * magnify
        ax.plot([start, end], [level, level], "|-", color=basic.BLACK, linewidth=3)
        ax.text(end + 0.5 * margin, level, f"{bar:g} µm", va="center", fontsize=13)
    title = f"Residuals, computed − observed, enlarged {magnify:,g} times"
    if photo is None and len(shown) < m:
        title += f", the {len(shown)} of {m} photos with the largest"
    if np.any(outlier):
        title += f"; red: |{SYMBOL[result.residual_test]}| > {critical:.2f}"
    fig.suptitle(title, fontsize=16)
    return fig


def _name_outliers(
    ax: Axes, xy: np.ndarray, names: list[str], edge: float, gap: float
) -> None:
    """Write names below each other beyond the edge, each with a line to its point."""
    level = np.inf
    for k in np.argsort(-xy[:, 1]):
        level = min(xy[k, 1], level - gap)
        look: Look = {"color": basic.RED, "weight": "bold", "parse_math": False}
        look |= {"va": "center", "annotation_clip": False}
        look["path_effects"] = [withStroke(linewidth=3, foreground="white")]
        look["arrowprops"] = {"arrowstyle": "-", "color": basic.RED, "linewidth": 1}
        ax.annotate(names[k], xy[k], (edge + 0.6 * gap, level), **look)


def _pins(
    ax: Axes, xy: np.ndarray, vectors: np.ndarray, color: str, thick: float
) -> None:
    """Draw vectors as lines that start in a dot: heads would hide the short ones."""
    look: Look = {"angles": "xy", "scale_units": "xy", "scale": 1, "units": "dots"}
    look |= {"headwidth": 0, "headlength": 0, "headaxislength": 0, "minlength": 0}
    ax.quiver(*xy.T, *vectors.T, color=color, width=3 * thick, **look)
    ax.plot(*xy.T, "o", color=color, markersize=4.2 * thick**0.5)


def symbol(name: str) -> str:
    """Parameters as formulas: "x0, P1" becomes "$x_0$, $P_1$"."""
    return re.sub(r"\b(omega|phi|kappa|(c|x|y|K|P|b|[XYZ])(\d?))\b", _formula, name)


def _formula(found: re.Match) -> str:
    word, letter, digit = found.groups()
    if letter:
        return f"${letter}_{digit}$" if digit else f"${letter}$"
    return r"$\varphi$" if word == "phi" else rf"$\{word}$"
