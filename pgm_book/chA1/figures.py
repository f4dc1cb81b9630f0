"""Figures of an adjustment: what is made least, where it lies, and how good it is."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pgm_book.program import adjustment as textbook
from pgm_lab import plot
from pgm_lab.adjustment import critical_w
from pgm_lab.plot.basic import Look, interact

KNOWN = "A"  # the bench mark whose height is known, drawn as a triangle
SPOTS = {
    "A": (0.0, 0.0), "B": (0.75, 0.62), "C": (2.1, 0.5), "D": (1.5, -0.5),
    "E": (2.6, -0.6),
}  # fmt: skip
ROUND = "AE"  # the line that runs a long way round
LABELS = {"AC": 14, "BD": 25}  # of 41 places along the line; elsewhere 19


# --- Four routes to one height ---


def levelling_net(lines: Sequence[str], labels: Sequence[str]) -> Figure:
    """Draw bench marks A to E and the levelled lines between them, with labels."""
    texts = [text.replace("-", "−") for text in labels]
    fig, ax = plt.subplots(figsize=(10, 4.0))
    _draw_net(ax, lines, texts, len(lines) * [plot.SKY])
    return fig


def _draw_net(ax: Axes, lines: Sequence[str], labels: list[str], colours: list) -> None:
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
        ax.text(x, y, label, ha="center", va="center", fontsize=15, bbox=box)
    for name, (x, y) in SPOTS.items():
        known = name == KNOWN
        ax.plot(x, y, "^" if known else "o", color=plot.BLACK, markersize=15)
        ax.text(x, y + 0.13, name, fontsize=20, weight="bold", ha="center")
    ax.text(-0.12, -0.03, "known", fontsize=15, ha="right")
    ax.set(xlim=(-0.5, 2.8), ylim=(-1.1, 0.95))
    ax.axis("off")


# --- How do many measurements give one answer? ---


def parabolas(observed: np.ndarray, p: np.ndarray, names: Sequence[str]) -> None:
    """Show p v^2 of observations of one unknown, and their sum, over the unknown."""
    best = float(np.sum(p * observed) / np.sum(p))
    reach = 1.6 * float(np.max(np.abs(observed - best)))
    H = best + np.linspace(-reach, reach, 201)
    terms = 1e6 * p[:, None] * (H - observed[:, None]) ** 2
    fig, ax = plt.subplots(figsize=(7, 3.2))
    styles = ("--", ":", "-.")
    for k, (term, label) in enumerate(zip(terms, names)):
        ax.plot(H, term, linestyle=styles[k % 3], label=f"p v² of {label}")
    ax.plot(H, terms.sum(axis=0), color=plot.BLACK, linewidth=3, label="their sum")
    least = 1e6 * np.sum(p * (best - observed) ** 2)
    ax.plot(best, least, "v", color=plot.RED, markersize=15, label="minimum")
    ax.ticklabel_format(useOffset=False)
    ax.set(xlabel="height of D (m)", ylabel="p v² (mm² / km)", ylim=(0, None))
    ax.locator_params(axis="x", nbins=5)
    ax.legend(loc="upper center")
    plot.show(
        fig,
        f"Parabolas of p v² over the height, of {len(names)} observations, narrow"
        f" where the weight is large, and their sum, smallest at {best:.4f} m.",
    )


def observation_space() -> Figure:
    """Draw three observations as one point, and the plane that the model allows."""
    fig, ax = plt.subplots(figsize=(10, 3.5))
    plane = np.array([(0.0, 0.0), (5.2, -0.35), (7.4, 1.35), (2.2, 1.7)])
    ax.fill(*plane.T, color=plot.SKY, alpha=0.35, linewidth=0)
    zero, best, other = np.zeros(2), np.array([3.7, 0.55]), np.array([5.9, 1.0])
    observed = best + (0.0, 2.2)
    axes = {1: (2.9, -1.0), 2: (2.0, 2.5), 3: (0.0, 2.6)}
    arrows = [(zero, np.array(tip), plot.GREY, 1.6) for tip in axes.values()]
    arrows += [
        (zero, observed, plot.BLACK, 3.0),
        (zero, best, plot.BLUE, 3.0),
        (observed, best, plot.RED, 3.0),
    ]
    for start, end, colour, width in arrows:
        look: Look = {"arrowstyle": "-|>", "color": colour, "linewidth": width}
        look |= {"shrinkA": 0, "shrinkB": 0, "mutation_scale": 22}
        ax.annotate("", (end[0], end[1]), (start[0], start[1]), arrowprops=look)
    ax.plot(*np.transpose([observed, other]), "--", color=plot.ORANGE)
    ax.plot(*other, "o", color=plot.ORANGE, markersize=10)
    back = best - 0.28 * best / np.linalg.norm(best)
    corner = [back, back + (0, 0.25), best + (0, 0.25)]
    ax.plot(*np.transpose(corner), color=plot.BLACK, linewidth=1.6)
    words = [
        (observed + (0.12, 0.05), "$l$: what was measured", plot.BLACK),
        (best + (0.12, -0.3), r"$A\hat{x} = l + v$: adjusted", plot.BLUE),
        ((observed + best) / 2 + (0.1, 0), "$v$", plot.RED),
        (other + (0.2, 0.0), "another $Ax$: farther from $l$", plot.BLACK),
        ((6.2, 1.6), "plane of all $Ax$", plot.BLUE),
    ]
    for k, tip in axes.items():
        beside = np.array([-0.75 if k == 3 else 0.1, -0.05])
        words.append((tip + beside, f"$l_{k} / \\sigma_{k}$", plot.GREY))
    for place, word, colour in words:
        x, y = place
        ax.text(x, y, word, fontsize=16, color=colour)
    ax.set(xlim=(-0.9, 8.8), ylim=(-1.25, 3.1))
    ax.axis("off")
    return fig


# --- How good is the result? ---


def scatter(repeated: np.ndarray, ours: float, stated: float, redundancy: int) -> None:
    """Show sigma0 (mm) of repeated surveys, with the limits of a global test."""
    sigma0s = np.asarray(repeated)
    r = redundancy
    low, high = stated * np.sqrt(scipy.special.chdtri(r, (0.975, 0.025)) / r)
    fig, ax = plt.subplots(figsize=(7, 3.1))
    label = f"{len(sigma0s)} surveys"
    bins = np.linspace(0, max(2.4 * stated, ours), 33)
    ax.hist(sigma0s, bins.tolist(), color=plot.SKY, label=label)
    for limit in (low, high):
        ax.axvline(limit, color=plot.BLACK, linestyle="--")
        place: Look = {"transform": ax.get_xaxis_transform(), "ha": "center"}
        ax.text(limit, 1.02, f"{limit:.1f} mm", **place)
    look: Look = {"color": plot.RED, "markersize": 16, "label": f"ours: {ours:.2f} mm"}
    ax.plot(ours, 0.04, "v", transform=ax.get_xaxis_transform(), **look)
    ax.set(xlabel="σ₀ from the residuals (mm)", ylabel="surveys")
    ax.set_xlim(0, float(max(bins[-1], 2 * high)))
    ax.legend(loc="upper right")
    within = np.mean((sigma0s > low) & (sigma0s < high))
    plot.show(
        fig,
        f"Histogram of sigma0 of {len(sigma0s)} repeated surveys. {100 * within:.0f}"
        f" per cent lie between the dashed limits {low:.1f} and {high:.1f} mm; ours is"
        f" {ours:.2f} mm.",
    )


# --- How well is each line controlled? ---


def levelling_control(lines: Sequence[str], share: np.ndarray) -> None:
    """Show the net with the redundancy number of each line."""
    fig, ax = plt.subplots(figsize=(7, 3))
    colours = [plt.get_cmap("cividis")(float(one)) for one in share]
    _draw_net(ax, lines, [f"{one:.2f}" for one in share], colours)
    each = ", ".join(f"{line} {one:.2f}" for line, one in zip(lines, share))
    plot.show(fig, f"The net with the redundancy number of each line: {each}.")


# --- Which line is wrong? ---


def tested(
    A: np.ndarray,
    p: np.ndarray,
    surveys: Mapping[str, np.ndarray],
    sigma0: float,
    names: Sequence[str],
) -> None:
    """Show Baarda's w of each line as bars, for one or more surveys.

    sigma0 is that of an observation of weight 1, as stated before.
    """
    fig, ax = plt.subplots(figsize=(7, 2.8))
    width = 0.8 / len(surveys)
    told = []
    for k, (name, observed) in enumerate(surveys.items()):
        w = _results(A, p, observed, sigma0)[1]
        look: Look = {"color": [plot.SKY, plot.RED][k % 2], "label": name}
        look |= {"hatch": "//" if k % 2 else None, "edgecolor": "white"}
        ax.bar(np.arange(len(names)) + width * (k + 0.5) - 0.4, w, width, **look)
        each = ", ".join(f"{line} {one:.1f}" for line, one in zip(names, w))
        told.append(f"{name}: {each}")
    _limit(ax, names)
    ax.legend()
    plot.show(fig, f"Bars of |w| for each line. {'; '.join(told)}. The limit is 3.29.")


def _results(
    A: np.ndarray, p: np.ndarray, observed: np.ndarray, sigma0: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unknowns, absolute values of Baarda's w, and redundancy numbers."""
    x, v, _, _ = textbook.adjust(A, p, observed)
    r = textbook.redundancy_numbers(A, p)
    controlled = np.where(r > 1e-9, r, np.inf)  # w is 0 where nothing controls
    return x, np.abs(v) * np.sqrt(p / controlled) / sigma0, r


def _limit(ax: Axes, names: Sequence[str]) -> None:
    """Name the lines, and draw the limit of Baarda's w."""
    limit = critical_w()
    ax.axhline(limit, color=plot.BLACK, linestyle="--")
    ax.text(len(names) - 0.4, limit + 0.1, f"{limit:.2f}", ha="right", va="bottom")
    ax.set(xticks=range(len(names)), xticklabels=names, ylabel="|w| (Baarda)")


def blunder(
    A: np.ndarray,
    p: np.ndarray,
    observed: np.ndarray,
    sigma0: float,
    lines: list[str],
    line: str,
    size: float,
) -> None:
    """Show what a blunder of so many mm in one line does to all w and heights."""
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.0), width_ratios=(5, 2))
    plot.show(fig, _draw_blunder(fig, axes, A, p, observed, sigma0, lines, line, size))


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
    x, w, r = _results(A, p, observed + 1e-3 * size * hit, sigma0)
    shift = 1000 * (x - _results(A, p, observed, sigma0)[0])
    colours = np.where(hit, plot.RED, plot.SKY)
    bars = axes[0].bar(range(len(lines)), w, 0.6, color=colours)
    bars[lines.index(line)].set(hatch="//", edgecolor="white")
    _limit(axes[0], [f"{name}\n{one:.2f}" for name, one in zip(lines, r)])
    axes[0].set(
        xlabel="line, and its redundancy number r", ylim=(0, max(5, 1.05 * w.max()))
    )
    marks = [name for name in sorted(set("".join(lines))) if name != KNOWN]
    axes[1].barh(range(len(shift)), shift, 0.5, color=plot.GREY)
    far = max(26.0, 2.2 * float(np.abs(shift).max()))
    for k, one in enumerate(shift):
        at = one + (0.04 if one >= 0 else -0.04) * far
        ha = "left" if one >= 0 else "right"
        axes[1].text(at, k, _signed(one), ha=ha, va="center", weight="bold")
    axes[1].axvline(0, color=plot.BLACK, linewidth=1)
    axes[1].set(yticks=range(len(shift)), yticklabels=marks, xlim=(-far, far))
    axes[1].set(xlabel="shift (mm)", ylim=(len(shift) - 0.5, -0.5))
    own = f"{_signed(size, 0)} mm in {line}: its |w| = {w[hit][0]:.1f}"
    fig.suptitle(own)
    each = ", ".join(f"{name} {one:.1f}" for name, one in zip(lines, w))
    moved = ", ".join(f"{name} {_signed(one)}" for name, one in zip(marks, shift))
    return (
        f"{own}, its r = {r[hit][0]:.2f}. Bars of |w| of all lines, limit 3.29: {each}."
        f" Bars of the shifts of the heights: {moved} mm."
    )


def _signed(number: float, digits: int = 1) -> str:
    return f"{number:+.{digits}f}".replace("-", "−")


def blunder_by_hand(
    A: np.ndarray, p: np.ndarray, observed: np.ndarray, sigma0: float, lines: list[str]
) -> None:
    """Show the same with a list of the lines, and a slider for the size."""
    import ipywidgets

    data = A, p, observed, sigma0, lines

    def draw(line: str, size: int) -> None:
        fig, axes = plt.subplots(1, 2, figsize=(10, 3.7), width_ratios=(2, 1))
        plot.show(fig, _draw_blunder(fig, axes, *data, line, size))

    look: Look = {"min": -40, "max": 40, "step": 2, "continuous_update": False}
    slider = ipywidgets.IntSlider(20, description="mm", **look)
    names = ipywidgets.Dropdown(options=lines, value=lines[0], description="line")
    interact(draw, line=names, size=slider)


# --- What if the equations are not linear? ---


def tangent(base: float, depth: float, start: float) -> None:
    """Show where the tangent of an angle over the depth leads from a start value."""

    def angle(Y: np.ndarray | float) -> np.ndarray:
        return np.asarray(2000 * np.arctan2(base / 2, Y))

    slope = -1000 * base / (start**2 + base**2 / 4)
    end = start + float(angle(depth) - angle(start)) / slope
    fig, ax = plt.subplots(figsize=(7, 2.7))
    left, right = min(end, 0.0) - 0.15 * start, 1.2 * start
    Y = np.linspace(0.3 * depth, right, 300)
    ax.plot(Y, angle(Y), color=plot.BLUE, label="angle between the rays")
    line = np.array([end, right])
    ax.plot(line, angle(start) + slope * (line - start), "--", color=plot.ORANGE,
            label="Taylor's first term")  # fmt: skip
    ax.axhline(float(angle(depth)), color=plot.GREY, linestyle=":", label="measured")
    ax.plot(start, angle(start), "o", color=plot.BLACK, markersize=11)
    ax.plot(end, angle(depth), "X", color=plot.RED, markersize=14)
    ax.plot(depth, angle(depth), "*", color=plot.BLACK, markersize=18)
    marks = {"start": (start, angle(start)), "first step": (end, angle(depth))}
    marks |= {"point": (depth, angle(depth))}
    above: Look = {"textcoords": "offset points", "xytext": (9, 9)}
    for name, (Y0, seen) in marks.items():
        ax.annotate(name, (float(Y0), float(seen)), **above)
    ax.axvline(0, color=plot.BLACK, linewidth=1)
    ax.text(8, float(angle(0.32 * depth)), "stations", rotation=90, va="top")
    ax.set(xlim=(left, right), xlabel="Y (m)", ylabel="angle (mrad)")
    ax.set_ylim(0, 1.05 * float(angle(0.3 * depth)))
    ax.legend(loc="upper left")
    plot.show(
        fig,
        "The angle between two rays falls with the depth Y, steeply at first and then"
        f" ever less. The tangent at the start, Y = {start:.0f} m, is much flatter than"
        f" the curve at the point, Y = {depth:.0f} m: it meets the measured angle at"
        f" Y = {end:.0f} m.",
    )


# --- How good is a point? ---


def point(
    stations: np.ndarray, position: np.ndarray, covariance: np.ndarray, off: np.ndarray
) -> None:
    """Show rays to a point with its error ellipse, and the errors of repetitions in it.

    Stations (k, 2), position, covariance and errors (m, 2) are in metres.
    """
    errors, magnify = np.asarray(off), 400
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.3))
    for station in stations:
        way = np.transpose([station, position])
        axes[0].plot(*way, color=plot.GREY, linewidth=1.4)
    axes[0].plot(*stations.T, "^", color=plot.BLACK, markersize=12)
    plot.error_ellipse(axes[0], position, covariance, magnify=magnify)
    axes[0].set(xlabel="X (m)", ylabel="Y (m)")
    axes[0].set_title(f"rays, and 95 %\nellipse × {magnify:g}", fontsize=14)
    last = stations[np.argmax(stations[:, 0])]
    axes[0].annotate(
        "stations", last, xytext=(11, 0), textcoords="offset points",
        va="center", fontsize=14,
    )  # fmt: skip
    axes[0].margins(0.12)
    C = covariance
    look: Look = {"markersize": 3, "alpha": 0.6, "color": plot.BLUE}
    axes[1].plot(*(1000 * errors.T), ".", **look)
    plot.error_ellipse(axes[1], (0, 0), 1e6 * C, linewidth=3)
    axes[1].set(xlabel="error in X (mm)", ylabel="error in Y (mm)")
    axes[1].set_title(f"{len(errors)} repetitions\nand 95 % ellipse", fontsize=14)
    for ax in axes:  # as wide as there is room: both are tall and narrow
        ax.set_aspect("equal", adjustable="datalim")
    sd = 1000 * np.sqrt(np.diag(C))
    plot.show(
        fig,
        f"Left, {len(stations)} stations, their rays to a point and its error ellipse,"
        f" enlarged {magnify:g} times. The standard deviations are {sd[0]:.0f} mm in X"
        f" and {sd[1]:.0f} mm in Y. Right, the errors of {len(errors)} repetitions, and"
        " the predicted ellipse around nearly all of them.",
    )
