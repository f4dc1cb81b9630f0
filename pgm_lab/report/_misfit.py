"""Warnings of what does not fit: sigma0, control, suspected blunders."""

import numpy as np
from scipy.stats import chi2, poisson

from pgm_lab.bundle.datum import is_controlled
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle
from pgm_lab.report._suspects import (
    control_first,
    interchanged,
    ray,
    suspected,
    suspected_control,
)
from pgm_lab.report._words import Finding, count, listed, observations, plain

ALPHA = 0.05  # probability of calling a right model wrong
IN_UM = 0.01  # sigma0 below this share of what was stated: 1 µm given as 1 mm is 0.001


def sigma0(result: Bundle) -> Finding | None:
    redundancy = result.redundancy
    if not redundancy > 0:
        return Finding(
            "No redundancy",
            "No more was measured than was needed: no error can be seen, and only a"
            " sigma0_prior gives standard deviations.",
        )
    stated = result.sigma0_prior or 1.0
    ends = chi2.ppf([ALPHA / 2, 1 - ALPHA / 2], redundancy)
    low, high = stated * np.sqrt(ends / redundancy)
    if low <= result.sigma0 <= high:
        return None
    if result.sigma0 < IN_UM * stated:
        cause = (
            "So good is no measurement: are the standard deviations in µm? Those of"
            " image coordinates (sx, sy) are expected in mm."
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
    residual, exceed = "residual", "is"
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
        f" {listed(f'{name} (w = {w:.1f})' for name, w in suspects)} {exceed} above"
        f" {critical_value(result):.2f}. {advice}",
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
        if found > poisson.ppf(1 - ALPHA, chance)
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
        f" {critical:.2f}, where chance alone gives about {chance:.{chance < 10:d}f}:"
        f" {listed(ray(result, k) for k in rays)}. {advice}",
    )


def _interchanged(result: Bundle, one: int, other: int) -> str:
    network = result.network
    a, b = (network.point_names[network.point[k]] for k in (one, other))
    return f"points {a} and {b} in photo {network.photo_names[network.photo[one]]}"
