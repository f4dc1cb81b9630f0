"""What does not fit: sigma0, control, suspected blunders, and warnings of them."""

import numpy as np
import scipy

from pgm_lab._rounding import plain
from pgm_lab.adjustment.outliers import NAMES
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.datum import is_controlled
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle
from pgm_lab.report._layout import Finding, count, listed
from pgm_lab.report._words import observations

ALPHA = 0.05  # probability of calling a right model wrong
IN_UM = 0.01  # sigma0 below this share of what was stated: 1 µm given as 1 mm is 0.001
GROSS = 1.5  # times the limit of |w|, or |tau|
SPOILT = 2.0  # times the stated standard deviation: what is judged by sigma0 is not
MOST = 50  # suspects that are compared with each other
ALIKE = 0.5  # largest part of a distance by which an error may miss it


def ray(result: Bundle, k: int) -> str:
    """Name a ray by the ids of its point and photo."""
    network = result.network
    point = network.point_names[network.point[k]]
    return f"point {point} in photo {network.photo_names[network.photo[k]]}"


def limit(result: Bundle) -> str:
    """Say what a standardised residual is compared with, and whence it comes.

    3.29 bounds Baarda's w, a standard normal number, once in a thousand times. Pope's
    tau has a limit of its own for each redundancy: 3.28 for 693, that of 2013.
    """
    value, name = critical_value(result), NAMES[result.residual_test]
    stated = "with the stated sigma0"
    if result.residual_test == "tau":
        stated = f"with the estimated sigma0, redundancy {result.redundancy}"
    return f"{value:.2f} ({name}, {stated}; one false alarm in 1000)"


def suspected(result: Bundle) -> np.ndarray:
    """Rays with a standardised residual above its limit, the largest first."""
    largest = np.max(np.abs(result.standardized), axis=1, initial=0)
    suspects = np.flatnonzero(largest > critical_value(result))
    return suspects[np.argsort(-largest[suspects], kind="stable")]


def suspected_control(result: Bundle) -> list[tuple[str, float]]:
    """Control coordinates and scale bars above the limit, with w, the largest first."""
    network, critical = result.network, critical_value(result)
    names = network.point_names
    found: list[tuple[str, float]] = []
    if network.control is not None:
        index, w = network.control[0], result.control_standardized
        for row, axis in np.argwhere(np.abs(w) > critical):
            name = f"{'XYZ'[axis]} of control point {names[index[row]]}"
            found.append((name, float(w[row, axis])))
    w = result.scale_bar_standardized
    for bar in np.flatnonzero(np.abs(w) > critical):
        a, b = network.scale_bars[bar, :2].astype(int)
        found.append((f"the scale bar {names[a]} to {names[b]}", float(w[bar])))
    return sorted(found, key=lambda one: -abs(one[1]))


def control_first(result: Bundle) -> bool:
    """Whether a control coordinate or a scale bar has the largest residual of all."""
    suspects = suspected_control(result)
    rays = np.max(np.abs(result.standardized), initial=0)
    return bool(suspects) and abs(suspects[0][1]) > rays


def gross(result: Bundle) -> bool:
    """Whether a blunder makes sigma0 so large that nothing can be judged by it."""
    stated = result.sigma0_prior or 1.0
    if not result.sigma0 > SPOILT * stated:
        return False
    w = result.standardized, result.control_standardized, result.scale_bar_standardized
    largest = max(np.max(np.abs(one), initial=0) for one in w)
    if result.sigma0_prior is not None:  # w counts in stated sd: count in sigma0
        largest *= stated / result.sigma0
    return bool(largest > GROSS * critical_value(result))


def interchanged(result: Bundle) -> list[tuple[int, int]]:
    """Pairs of suspected rays of one photo, each measured where the other should be.

    The estimated error -v / r of one is then the difference of the coordinates, that
    of the other its opposite.
    """
    network, rays = result.network, suspected(result)[:MOST]
    r = result.redundancy_numbers[rays]
    error = -result.residuals[rays] / np.where(r > UNCONTROLLED, r, np.inf)
    a, b = np.triu_indices(len(rays), 1)
    difference = network.xy[rays[a]] - network.xy[rays[b]]
    miss = np.hypot(*(np.array([error[a], -error[b]]) - difference).transpose(2, 0, 1))
    pair = np.all(miss < ALIKE * np.hypot(*difference.T), axis=0)
    pair &= network.photo[rays[a]] == network.photo[rays[b]]
    return [(int(i), int(j)) for i, j in zip(rays[a[pair]], rays[b[pair]])]


def sigma0(result: Bundle) -> Finding | None:
    redundancy = result.redundancy
    if not redundancy > 0:
        return Finding(
            "No redundancy",
            "No more was measured than was needed: no error can be seen, and only a"
            " sigma0_prior gives standard deviations.",
        )
    stated = result.sigma0_prior or 1.0
    ends = scipy.stats.chi2.ppf([ALPHA / 2, 1 - ALPHA / 2], redundancy)
    low, high = stated * np.sqrt(ends / redundancy)
    if low <= result.sigma0 <= high:
        return None
    if result.sigma0 < IN_UM * stated:
        cause = (
            "No measurement is that precise: are the standard deviations in µm? Those"
            " of image coordinates (sx, sy) are expected in mm."
        )
    elif result.sigma0 < stated:
        cause = (
            f"{observations(result.network).capitalize()} are better than stated; the"
            " standard deviations below take this into account, since they are"
            " multiplied by sigma0."
        )
    else:
        cause = (
            f"{observations(result.network).capitalize()} are worse than stated, or"
            " blunders are among them, or the camera needs a parameter that was not"
            f" estimated{_or_control(result.network)}."
        )
    return Finding(
        "Stated standard deviations",
        f"sigma0 = {_three(result.sigma0)} is not {stated:g}: by chance it would stay"
        f" between {_three(low)} and {_three(high)} in {100 * (1 - ALPHA):.0f} of 100"
        f" cases. {cause}",
    )


def _or_control(network: Network) -> str:
    what = ["a control point"] if is_controlled(network) else []
    what += ["a scale bar"] if len(network.scale_bars) else []
    return f", or {' or '.join(what)} is wrong" if what else ""


def _three(value: float) -> str:
    """Write a number with three decimals, or more if they are zeros."""
    return f"{value:.3f}" if value >= 0.1 else plain(value, 3)


def control(result: Bundle) -> Finding | None:
    suspects = suspected_control(result)
    if not suspects:
        return None
    test, residual, exceed = result.residual_test, "residual", "is"
    if len(suspects) > 1:
        residual, exceed = "residuals", "are"
    advice = (
        "Look at control first: a wrong control point or scale bar spoils the residuals"
        " of good rays. Check values, ids and units, the largest first."
        if control_first(result)
        else "But a ray has a larger one: look at that first, since a blunder spoils"
        " the residuals of good control too."
    )
    return Finding(
        "Control that does not fit",
        f"The standardised {residual} of"
        f" {listed(f'{name} ({test} = {w:.1f})' for name, w in suspects)} {exceed}"
        f" above {limit(result)}. {advice}",
    )


def blunders(result: Bundle) -> Finding | None:
    rays = suspected(result)
    if not len(rays):
        return None
    critical = critical_value(result)
    found = np.sum(np.abs(result.standardized) > critical)
    chance = result.standardized.size / 1000  # as critical_value has it
    advice = (
        "Look at the largest first: one blunder makes its neighbours suspect too."
        if found > scipy.stats.poisson.ppf(1 - ALPHA, chance)
        else "This is no more than chance, so perhaps none is a blunder."
    )
    if control_first(result):
        advice = "Control comes first: once it is right, good rays among these fit."
    if pairs := interchanged(result):
        # Only the first: it makes other photos suspect the same points
        advice += f" Interchanged, it seems: {_interchanged(result, *pairs[0])}."
    have = "has" if len(rays) == 1 else "have"
    return Finding(
        "Suspected blunders",
        f"{count(len(rays), 'ray').capitalize()} {have} a standardised residual above"
        f" {limit(result)}, where chance alone gives about"
        f" {chance:.{chance < 10:d}f}:"
        f" {listed(ray(result, k) for k in rays)}. {advice}",
    )


def _interchanged(result: Bundle, one: int, other: int) -> str:
    network = result.network
    a, b = (network.point_names[network.point[k]] for k in (one, other))
    return f"points {a} and {b} in photo {network.photo_names[network.photo[one]]}"
