"""Warnings: what the reader of a registration should look at first, in words."""

import numpy as np

from pgm_lab._rounding import plain
from pgm_lab.report import _statuses
from pgm_lab.report._layout import NUMBERS, Finding, count, listed
from pgm_lab.report._registration_case import COMMON, FEW, Case, say
from pgm_lab.report._statuses import SMALL

BORDER = 0.1  # of the points
CHANGED = 0.2  # of the points
FAR = 0.5  # of the radius
NOISE = 2.0  # sigma0
STILL = 1e-3  # px
TREND = 3.0  # times what the shift is known to
ON_BORDER = "peak on the border of the search"


def findings(case: Case) -> list[Finding]:
    """List all warnings of a registration; none when nothing is wrong."""
    checks = (
        _disagreement,
        _twice,
        _few,
        _border,
        _far,
        _changed,
        _crowded,
        _trend,
        _noise,
        _blunders,
        _whole,
    )
    said = (check(case) for check in checks)
    return [one for one in said if one is not None]


def _disagreement(case: Case) -> Finding | None:
    if not np.any(case.found.accepted) or case.agrees:
        return None
    return Finding(
        "Shifts that do not agree",
        "The accepted shifts are spread over the search window as chance would spread"
        f" them: whoever knows nothing and guesses reaches {plain(case.chance)} px in"
        " each coordinate. Do the images show the same place, and the same band? Is"
        " one turned or of another scale? Nothing below can be trusted.",
    )


def _twice(case: Case) -> Finding | None:
    found, good = case.found, case.found.accepted
    d = np.abs([found.dx[good], found.dy[good]])
    if not d.size or d.max() > STILL or found.r[good].min() < 0.9999:
        return None
    return Finding(
        "No difference",
        "All shifts are zero and all r are 1. Is it the same image twice? Two images"
        " of one place differ at least by their noise.",
    )


def _few(case: Case) -> Finding | None:
    words = _statuses.few(case.found, FEW, say)
    return Finding("Few points", words) if words else None


def _border(case: Case) -> Finding | None:
    n = int(np.sum(case.found.status == ON_BORDER))
    if n < BORDER * len(case.found.points):
        return None
    return Finding(
        "Peaks on the border of the search",
        f"{count(n, 'point').capitalize()} of {len(case.found.points)} fit best at the"
        f" border of what was searched, {case.radius} px to each side: their place may"
        f" lie beyond, and those that were found are then the shorter shifts. Search"
        f" farther, with --radius {2 * case.radius} on the command line, or radius in"
        " Python.",
    )


def _far(case: Case) -> Finding | None:
    if not case.agrees:
        return None
    far = float(np.abs(case.shift).max())
    if far <= FAR * case.radius:
        return None
    a, b = np.round(case.shift + case.offset).astype(int)
    return Finding(
        "A shift beyond half the radius",
        f"The common shift of {plain(far)} px is more than half the radius of"
        f" {case.radius} px: points that moved a little farther were lost, and what is"
        " left is drawn towards zero. Begin nearer, with --offset"
        f" {a} {b}, or search farther, with --radius {2 * case.radius}.",
    )


def _changed(case: Case) -> Finding | None:
    n = int(np.sum(np.isin(case.found.status, ("changed", "below threshold"))))
    if n < CHANGED * len(case.found.points):
        return None
    return Finding(
        "Places that look different",
        f"{count(n, 'point').capitalize()} of {len(case.found.points)} have texture in"
        " the reference image, and nothing like it was found. Fields are mown, clouds"
        " and their shadows move, other bands and seasons show other things. What is"
        " said here holds for the places that stayed.",
    )


def _crowded(case: Case) -> Finding | None:
    where = _statuses.crowded(case.found.points[case.found.accepted], case.size)
    if where is None:
        return None
    share, place = where
    return Finding(
        "Points in one part of the image",
        f"Nearly all accepted points lie within {100 * share:.0f} % of the reference"
        f" image, {place}. Elsewhere the shift is not known: give points over all that"
        " both images show, or find out why they are lost there.",
    )


def _trend(case: Case) -> Finding | None:
    affine = case.affine
    if affine is None or affine is case.model or not case.agrees:
        return None
    a1, a2, b1, b2 = affine.parameters[[1, 2, 4, 5]]
    half = np.ptp(case.found.points[affine.used], axis=0) / 2
    change = np.abs([(a1, a2), (b1, b2)]) @ half  # in a corner, against the middle
    sd = np.sqrt(np.diagonal(affine.covariance)[[1, 2, 4, 5]]).reshape(2, 2) @ half
    if np.all(change < TREND * np.maximum(case.known, sd)):
        return None
    return Finding(
        "A shift that changes over the image",
        f"Between the middle and a corner it changes by up to {plain(change.max())} px,"
        " as when the images differ in scale, are turned or sheared. One shift does not"
        " describe that: use --model affine on the command line, or"
        ' fit(found, "affine") in Python.',
    )


def _noise(case: Case) -> Finding | None:
    if case.model is None or case.model.sigma0 <= NOISE or not case.agrees:
        return None
    if _trend(case) is not None:  # that is why
        return None
    return Finding(
        "More scatter than predicted",
        f"sigma0 is {plain(case.model.sigma0)}: the shifts are so many times farther"
        " from the model than the noise of the chips explains. The rest is no noise:"
        " relief seen from two sides, what moved or changed, alias of what is finer"
        " than a pixel, or images that were resampled differently. Believe the scatter,"
        " not the predicted standard deviations.",
    )


def _blunders(case: Case) -> Finding | None:
    if case.model is None or not case.agrees:
        return None
    k = np.flatnonzero(case.found.accepted & ~case.model.used)
    if not len(k):
        return None
    do = "does" if len(k) == 1 else "do"
    return Finding(
        "Accepted points that do not fit",
        f"{count(len(k), 'point').capitalize()} {do} not follow the model and"
        f" {'was' if len(k) == 1 else 'were'} left out of it: {listed(k)}. Mean, RMSE"
        " and CE90 contain them; median and spread hardly change by them. Look at them"
        " in the images.",
    )


def _whole(case: Case) -> Finding | None:
    if case.asked["refine"] is not None or not np.any(case.found.accepted):
        return None
    return Finding(
        "Whole pixels only",
        "The shifts were not refined: each is rounded to a whole pixel, and all may be"
        " rounded to the same side. A mean of them is no better than a third of a"
        " pixel, however many there are. Least squares matching (--refine lsm) goes"
        " between the pixels.",
    )


def limits() -> list[str]:
    """Say what the method cannot tell, and of each limit why it is so large."""
    return [
        "Both images are compared with each other, not with the ground: if the"
        " reference lies wrong on the map, so does everything that is laid onto it."
        " Where the ground has relief and the two were seen from different directions,"
        " a part of the shifts is relief.",
        "r says how much alike a chip and what was found are, not how well it is"
        " placed: a chip with one straight edge reaches a high r anywhere along it, and"
        " a noisy one with good texture is placed well with a low r.",
        "What all points are off together, their scatter does not show. Besides the"
        " scatter, the headline therefore allows for"
        f" {COMMON['lsm']:g} px after least squares matching, {COMMON['parabola']:g} px"
        f" after a parabola and {COMMON[None]:.2f} px for whole pixels, as alias and"
        " the resampling that made the images leave them. Of an image with strong alias"
        " it may be a few hundredths of a pixel.",
        f"Fewer than {NUMBERS[FEW]} points are called few, and fewer than half of all."
        f" Peaks on the border are many from {100 * BORDER:.0f} % on, places that look"
        f" different from {100 * CHANGED:.0f} % on, and points lie in one part if the"
        " middle nine tenths of their columns and rows span less than"
        f" {100 * SMALL:.0f} % of the image. A sigma0 above {NOISE:g} is called large."
        " These are choices, no tests.",
        "Shifts agree if their robust standard deviation stays below half of what"
        " places that are drawn by lot from the search window would have.",
    ]
