"""Figures of a levelling net: its lines, who controls them, where a blunder goes."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from ipywidgets import Dropdown, IntSlider
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import critical_w, textbook
from pgm_lab.plot import basic
from pgm_lab.plot._sliders import interact
from pgm_lab.plot.basic import Look

KNOWN = "A"  # the bench mark whose height is known, drawn as a triangle
SPOTS = {
    "A": (0.0, 0.0), "B": (0.75, 0.62), "C": (2.1, 0.5), "D": (1.5, -0.5),
    "E": (2.6, -0.6),
}  # fmt: skip
ROUND = "AE"  # the line that runs a long way round
LABELS = {"AC": 26, "BD": 25}  # of 41 places along the line; elsewhere 19


def net(lines: Sequence[str], labels: Sequence[str]) -> Figure:
    """Draw bench marks A to E and the levelled lines between them, with a label each.

    Parameters
    ----------
    lines : sequence of str
        Each from its first bench mark to its second, for example "AB".
    labels : sequence of str
        What to write on the lines.

    Returns
    -------
    matplotlib.figure.Figure
    """
    names = _lines(lines)
    texts = _validate.texts(labels, "labels", len(names))
    texts = [text.replace("-", "−") for text in texts]
    fig, ax = plt.subplots(figsize=(10, 4.6))
    _draw_net(ax, names, texts, len(names) * [basic.SKY], 15)
    return fig


def control(lines: Sequence[str], share: ArrayLike) -> None:
    """Show the net with the redundancy number of each line.

    Parameters
    ----------
    lines : sequence of str
        As for `net`.
    share : array_like (n,)
        Redundancy numbers.
    """
    names = _lines(lines)
    share = _validate.of_shape(share, (len(names),), "share")
    fig, ax = plt.subplots(figsize=(7, 3))
    colours = [plt.get_cmap("cividis")(float(one)) for one in share]
    _draw_net(ax, names, [f"{one:.2f}" for one in share], colours, 15)
    each = ", ".join(f"{line} {one:.2f}" for line, one in zip(names, share))
    basic.show(fig, f"The net with the redundancy number of each line: {each}.")


def tested(
    A: ArrayLike,
    p: ArrayLike,
    surveys: Mapping[str, ArrayLike],
    sigma0: float,
    lines: Sequence[str],
) -> None:
    """Show Baarda's w of each line as bars, for one or more surveys.

    Parameters
    ----------
    A, p
        As for `adjustment.textbook.adjust`.
    surveys : mapping of str to array_like (n,)
        Observations, by the name of the survey.
    sigma0 : float
        Standard deviation of an observation of weight 1, as stated before.
    lines : sequence of str
        Names of the lines.
    """
    names = _lines(lines)
    sigma0 = _validate.positive_number(sigma0, "sigma0", "in the unit of observed")
    _validate.size("surveys", len(_validate.mapping(surveys, "surveys")))
    fig, ax = plt.subplots(figsize=(7, 2.8))
    width = 0.8 / max(len(surveys), 1)
    told = []
    for k, (name, observed) in enumerate(surveys.items()):
        w = _results(A, p, observed, sigma0, names, f"surveys: {name}")[1]
        look: Look = {"color": [basic.SKY, basic.RED][k % 2], "label": name}
        look |= {"hatch": "//" if k % 2 else None, "edgecolor": "white"}
        ax.bar(np.arange(len(names)) + width * (k + 0.5) - 0.4, w, width, **look)
        each = ", ".join(f"{line} {one:.1f}" for line, one in zip(names, w))
        told.append(f"{name}: {each}")
    _limit(ax, names)
    ax.legend()
    basic.show(fig, f"Bars of |w| for each line. {'; '.join(told)}. The limit is 3.29.")


def blunder(
    A: ArrayLike,
    p: ArrayLike,
    observed: ArrayLike,
    sigma0: float,
    lines: Sequence[str],
    line: str,
    size: float,
) -> None:
    """Show what a blunder in one line does to all w, and to the heights.

    Parameters
    ----------
    A, p, observed
        As for `adjustment.textbook.adjust`, in metres.
    sigma0 : float
        Standard deviation of an observation of weight 1, as stated before, in metres.
    lines : sequence of str
        Names of the lines.
    line : str
        The line with the blunder.
    size : float
        The blunder in millimetres.
    """
    data = _net_data(A, p, observed, sigma0, lines)
    line = _validate.choice(line, "line", tuple(data[-1]))
    size = _validate.number(size, "size")
    fig, axes = plt.subplots(2, 1, figsize=(7, 3.8), height_ratios=(4, 3))
    basic.show(fig, _draw_blunder(fig, axes, *data, line=line, size=size))


def blunder_by_hand(
    A: ArrayLike,
    p: ArrayLike,
    observed: ArrayLike,
    sigma0: float,
    lines: Sequence[str],
) -> None:
    """Show the same with a list of the lines, and a slider for the size of the blunder.

    Parameters
    ----------
    A, p, observed, sigma0, lines
        As for `blunder`.
    """
    data = _net_data(A, p, observed, sigma0, lines)

    def draw(line: str, size: int) -> None:
        fig, axes = plt.subplots(1, 2, figsize=(10, 3.7), width_ratios=(2, 1))
        basic.show(fig, _draw_blunder(fig, axes, *data, line=line, size=size))

    look: Look = {"min": -40, "max": 40, "step": 2, "continuous_update": False}
    slider = IntSlider(20, description="mm", **look)
    names = Dropdown(options=data[-1], value=data[-1][0], description="line")
    interact(draw, line=names, size=slider)


def _lines(lines: Sequence[str]) -> list[str]:
    names = _validate.texts(lines, "lines")
    wrong = [n for n in names if len(n) != 2 or not set(n) <= SPOTS.keys()]
    if wrong or not names:
        raise ValueError(f"lines must be names like 'AB', of A to E; got {wrong}")
    return names


def _net_data(
    A: ArrayLike, p: ArrayLike, observed: ArrayLike, sigma0: float, lines: Sequence[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, list[str]]:
    names = _lines(lines)
    sigma0 = _validate.positive_number(sigma0, "sigma0", "metres")
    _results(A, p, observed, sigma0, names, "observed")
    A, p = _validate.finite(A, "A"), _validate.finite(p, "p")
    return A, p, _validate.finite(observed, "observed"), sigma0, names


def _results(
    A: ArrayLike,
    p: ArrayLike,
    observed: ArrayLike,
    sigma0: float,
    names: list[str],
    name: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unknowns, absolute values of Baarda's w, and redundancy numbers."""
    observed = _validate.of_shape(observed, (len(names),), name)
    x, v, _, _ = textbook.adjust(A, p, observed)
    r = textbook.redundancy_numbers(A, p)
    controlled = np.where(r > 1e-9, r, np.inf)  # w is 0 where nothing controls
    w = np.abs(v) * np.sqrt(_validate.finite(p, "p") / controlled) / sigma0
    return x, w, r


def _draw_net(
    ax: Axes, lines: list[str], labels: list[str], colours: list, size: float
) -> None:
    """Draw the lines as arrows, in the direction in which they were levelled."""
    t = np.linspace(0, 1, 41)[:, None]
    box = {"facecolor": "white", "edgecolor": "none", "pad": 2}
    for line, label, colour in zip(lines, labels, colours):
        a, b = (np.array(SPOTS[name]) for name in line)
        way = a + t * (b - a) - 4 * t * (1 - t) * (0, 0.62 * (line == ROUND))
        ax.plot(*way.T, color=colour, linewidth=3, zorder=1)
        arrow = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 28}
        ax.annotate("", way[-3], way[-5], arrowprops=arrow)
        x, y = way[LABELS.get(line, 19)]
        ax.text(x, y, label, ha="center", va="center", fontsize=size, bbox=box)
    for name, (x, y) in SPOTS.items():
        known = name == KNOWN
        ax.plot(x, y, "^" if known else "o", color=basic.BLACK, markersize=15)
        ax.text(x, y + 0.13, name, fontsize=20, weight="bold", ha="center")
    ax.text(-0.12, -0.03, "known", fontsize=size, ha="right")
    ax.set(xlim=(-0.5, 2.8), ylim=(-1.1, 0.95))
    ax.axis("off")


def _draw_blunder(
    fig: Figure,
    axes: Sequence[Axes],
    A: np.ndarray,
    p: np.ndarray,
    observed: np.ndarray,
    sigma0: float,
    lines: list[str],
    line: str,
    size: float,
) -> str:
    """Draw w of all lines and the shifts of the heights; return it in words."""
    hit = np.array(lines) == line
    x, w, r = _results(A, p, observed + 1e-3 * size * hit, sigma0, lines, "observed")
    shift = 1000 * (x - _results(A, p, observed, sigma0, lines, "observed")[0])
    colours = np.where(hit, basic.RED, basic.SKY)
    bars = axes[0].bar(range(len(lines)), w, 0.6, color=colours)
    bars[lines.index(line)].set(hatch="//", edgecolor="white")
    _limit(axes[0], [f"{name}\n{one:.2f}" for name, one in zip(lines, r)])
    axes[0].set(
        xlabel="line, and its redundancy number r", ylim=(0, max(5, 1.05 * w.max()))
    )
    marks = [name for name in sorted(set("".join(lines))) if name != KNOWN]
    marks = marks if len(marks) == len(shift) else [str(k) for k in range(len(shift))]
    axes[1].bar(range(len(shift)), shift, 0.5, color=basic.GREY)
    far = max(15.0, 1.35 * float(np.abs(shift).max()))
    for k, one in enumerate(shift):
        at = one + (0.03 if one >= 0 else -0.03) * far
        va = "bottom" if one >= 0 else "top"
        axes[1].text(k, at, _signed(one), ha="center", va=va, weight="bold")
    axes[1].axhline(0, color=basic.BLACK, linewidth=1)
    axes[1].set(xticks=range(len(shift)), xticklabels=marks, ylim=(-far, far))
    axes[1].set(xlabel="height of bench mark", ylabel="shift (mm)")
    own = f"{_signed(size, 0)} mm in {line}: its |w| = {w[hit][0]:.1f}"
    fig.suptitle(own)
    each = ", ".join(f"{name} {one:.1f}" for name, one in zip(lines, w))
    moved = ", ".join(f"{name} {_signed(one)}" for name, one in zip(marks, shift))
    return (
        f"{own}, its r = {r[hit][0]:.2f}. Bars of |w| of all lines, limit 3.29: {each}."
        f" Bars of the shifts of the heights: {moved} mm."
    )


def _limit(ax: Axes, names: list[str]) -> None:
    """Name the lines, and draw the limit of Baarda's w."""
    limit = critical_w()
    ax.axhline(limit, color=basic.BLACK, linestyle="--")
    ax.text(len(names) - 0.4, limit + 0.1, f"{limit:.2f}", ha="right", va="bottom")
    ax.set(xticks=range(len(names)), xticklabels=names, ylabel="|w| (Baarda)")


def _signed(number: float, digits: int = 1) -> str:
    return f"{number:+.{digits}f}".replace("-", "−")
