"""Figures of the shifts of many chips: around the truth, and on trial."""

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.plot import basic
from pgm_lab.plot.basic import Look

WRONG = 1.0  # px: a shift that is farther off than this is a wrong match
SHOWN = 0.5  # px to each side of the truth


def darts(methods: Mapping[str, ArrayLike], truth: ArrayLike) -> None:
    """Show the shifts that several methods found, like darts around the bull's eye.

    Parameters
    ----------
    methods : mapping of str to array_like (n, 2)
        (dx, dy) in pixels, by the name of the method.
    truth : array_like (2,)
        The true shift in pixels.
    """
    clouds = _clouds(methods)
    x, y = _validate.one_point(truth, 2, "truth")
    size = (max(5.0, 2.33 * len(clouds)), 3.8)
    look: Look = {"squeeze": False, "sharey": True, "layout": "compressed"}
    fig, axes = plt.subplots(1, len(clouds), figsize=size, **look)
    said = []
    for ax, (name, cloud) in zip(axes[0], clouds.items()):
        middle = np.median(cloud, axis=0)
        ax.axhline(y, color=basic.GREEN, linewidth=2.5)
        ax.axvline(x, color=basic.GREEN, linewidth=2.5, label="truth")
        whole: Look = {
            "mfc": "none",
            "markersize": 18,
            "mew": 2.2,
            "label": "whole pixel",
        }
        ax.plot(*np.round((x, y)), "s", color=basic.BLACK, **whole)
        ax.plot(*cloud.T, "o", color=basic.SKY, alpha=0.45, ms=7, label="one chip")
        cross: Look = {"mec": "white", "markersize": 14, "label": "median"}
        ax.plot(*middle, "X", color=basic.BLACK, **cross)
        ax.set(xlim=(x - SHOWN, x + SHOWN), ylim=(y + SHOWN, y - SHOWN), aspect="equal")
        off = float(np.hypot(*(middle - (x, y))))
        ax.set_title(f"{name}:\noff by {off:.3f} px", fontsize=14)
        ax.set(xlabel="dx (px)")
        ax.yaxis.set_major_locator(MultipleLocator(0.5))
        ax.xaxis.set_major_locator(MultipleLocator(0.5))
        said.append(f"{name} {off:.3f} px")
    axes[0, 0].set_ylabel("dy (px), downwards")
    handles = axes[0, 0].get_legend_handles_labels()
    spacing: Look = {"handlelength": 1.4, "columnspacing": 1.2}
    fig.legend(*handles, loc="outside lower center", ncols=4, **spacing)
    basic.show(
        fig,
        "The shifts of all chips around the true shift, one panel for each method. The"
        f" median misses the truth by: {', '.join(said)}.",
        colours=128,
    )


def beyond(true: ArrayLike, found: ArrayLike, r: ArrayLike, radius: int = 3) -> None:
    """Show what a search reports of shifts beyond its radius, and with what r.

    Parameters
    ----------
    true, found : array_like (n,)
        Shifts of n chips along one axis, in pixels.
    r : array_like (n,)
        Correlation at the peak of each.
    radius : int
        Of the search, in pixels.
    """
    true, found, r = _lists(true=true, found=found, r=r)
    radius = _validate.whole(radius, "radius", 1)
    wrong = np.abs(found - true) > WRONG
    fig, axes = plt.subplots(1, 2, figsize=(7, 3.9), gridspec_kw={"wspace": 0.08})
    end = max(float(true.max()), radius + 1.0)
    axes[0].plot((0, end), (0, end), color=basic.GREEN, label="as it should be")
    axes[0].axhline(radius, color=basic.BLACK, linestyle=":", label="end of the search")
    axes[0].set(
        xlabel="true dx (px)", ylabel="reported dx (px)", ylim=(-radius - 1, end)
    )
    axes[1].axhline(0.8, color=basic.BLACK, linestyle=":", label="threshold 0.8")
    axes[1].set(xlabel="true dx (px)", ylabel="r at the peak", ylim=(-0.1, 1.03))
    for chosen, mark, colour, name in _kinds(wrong):
        look: Look = {
            "color": colour,
            "linestyle": "none",
            "markersize": 6,
            "alpha": 0.55,
        }
        axes[0].plot(true[chosen], found[chosen], mark, **look)
        axes[1].plot(true[chosen], r[chosen], mark, label=name, **look)
    axes[0].set_title("what is reported")
    axes[0].legend(loc="lower left")
    axes[1].legend(loc="lower left", markerscale=1.6)
    passed = int(np.sum(wrong & (r >= 0.8)))
    axes[1].set_title(f"{passed} of {wrong.sum()} wrong ones\nhave r ≥ 0.8")
    basic.show(
        fig,
        "Left, reported against true shift: on the diagonal up to the radius, and from"
        " there on level, for no larger answer exists. Right, r against the true shift:"
        f" it falls slowly; {passed} of {wrong.sum()} wrong chips stay above 0.8.",
        colours=128,
    )


def trial(
    error: ArrayLike,
    r: ArrayLike,
    tests: Mapping[str, ArrayLike],
    accepted: ArrayLike,
    limit: float = 0.8,
) -> None:
    """Show what tests accept of right and of wrong chips, at every threshold.

    Parameters
    ----------
    error : array_like (n,)
        Length of each chip's error in pixels.
    r : array_like (n,)
        Its correlation.
    tests : mapping of str to array_like (n,)
        The larger, the more a test trusts a chip; NaN: not at all. By their names.
    accepted : array_like (n,) of bool
        What all tests of `register` together accept.
    limit : float
        Threshold of r to be marked.
    """
    error, r, kept_by_all = _lists(error=error, r=r, accepted=accepted)
    if np.asarray(accepted).dtype != bool:
        raise ValueError("accepted must have True or False for each chip")
    limit = _validate.number(limit, "limit")
    wrong = error > WRONG
    if wrong.all() or not wrong.any():
        raise ValueError("error must have chips within a pixel and chips beyond it")
    scores = _tests(tests, len(r))
    fig, ax = plt.subplots(figsize=(10, 3.7))
    ax.tick_params(labelsize=15)
    styles = [(basic.BLUE, "-"), (basic.ORANGE, "--"), (basic.PURPLE, "-.")]
    for (name, score), (colour, line) in zip(scores.items(), styles):
        order = np.unique(score)[::-1]
        steps = [[np.mean(score[k] >= t) for t in order] for k in (wrong, ~wrong)]
        curve = 100 * np.hstack([np.zeros((2, 1)), steps])
        ax.plot(*curve, color=colour, linestyle=line, linewidth=3.2, label=name)
    share = [100 * float(np.mean(r[k] >= limit)) for k in (wrong, ~wrong)]
    kept = [100 * float(np.mean(kept_by_all[k] > 0)) for k in (wrong, ~wrong)]
    for at, mark, colour, name, text_at in (
        (share, "o", basic.BLUE, f"r ≥ {limit:g}", (2.0, share[1] - 6)),
        (kept, "*", basic.BLACK, "all tests of register", (2.0, 101)),
    ):
        ax.plot(*at, mark, color=colour, markersize=18, clip_on=False, zorder=5)
        text = f"{name}: {at[1]:.0f} % of the right, {at[0]:.1f} % of the wrong"
        thread: Look = {"arrowstyle": "-", "color": colour}
        ax.annotate(
            text, (at[0], at[1]), text_at, color=colour, fontsize=15, arrowprops=thread
        )
    ax.set(xlabel="wrong chips accepted (%)", ylabel="right chips accepted (%)")
    ax.set(xlim=(0, 25), ylim=(min(50, share[1], kept[1]) - 8, 106))
    ax.legend(loc="lower right", fontsize=15)
    basic.show(
        fig,
        f"Receiver operating characteristic curves of {' and of '.join(tests)}: right"
        f" against wrong chips that a threshold accepts. At r ≥ {limit:g} pass"
        f" {share[1]:.0f} per cent of the right and {share[0]:.0f} of the wrong chips;"
        f" all tests of register together pass {kept[1]:.0f} and {kept[0]:.1f}.",
        colours=96,
    )


def _kinds(wrong: np.ndarray) -> tuple[tuple[np.ndarray, str, str, str], ...]:
    """Right and wrong chips, with mark, colour and name."""
    return (
        (~wrong, "o", basic.SKY, "right within 1 px"),
        (wrong, "X", basic.RED, "wrong"),
    )


def _clouds(methods: Mapping[str, ArrayLike]) -> dict[str, np.ndarray]:
    """Shifts (n, 2) by the name of the method."""
    methods = _validate.mapping(methods, "methods")
    found = {}
    for name, shifts in methods.items():
        _validate.text(name, "methods: a name")
        cloud = _validate.of_shape(shifts, (None, 2), f"methods: {name}")
        found[name] = cloud
    return found


def _lists(**lists: ArrayLike) -> list[np.ndarray]:
    """Lists of the same length."""
    arrays = [_validate.finite(values, name) for name, values in lists.items()]
    if any(a.ndim != 1 or a.shape != arrays[0].shape or not a.size for a in arrays):
        raise ValueError(f"{', '.join(lists)} must be lists of the same length")
    return arrays


def _tests(tests: Mapping[str, ArrayLike], n: int) -> dict[str, np.ndarray]:
    """Scores (n,) by the name of the test; what has none comes last."""
    found = {}
    for name, score in _validate.mapping(tests, "tests").items():
        _validate.text(name, "tests: a name")
        values = _validate.real(score, f"tests: {name}")
        if values.shape != (n,):
            raise ValueError(f"tests: {name} must have one number for each chip")
        found[name] = np.where(np.isfinite(values), values, -np.inf)
    return found
