"""Warnings: what the reader of a matching should look at first, in words."""

import numpy as np

from pgm_lab._rounding import plain
from pgm_lab.matching import RECOMMENDED_QUALITY, Match
from pgm_lab.report import _statuses
from pgm_lab.report._layout import NUMBERS, Finding, count, listed
from pgm_lab.report._statuses import SMALL

FEW = 12  # matches
OFTEN = 0.2  # of the points
TURNED, SCALED = 15.0, 1.25  # degrees, times
ODD = 1.5  # times longer or shorter than in the other windows
WEAK, COARSE = 0.2, 1.0  # px, for a usual and for a single point
STILL = 0.02  # px
ASIDE = 0.1  # of the width of the left photo

AMBIGUOUS = "ambiguous", "left-right check failed"


def findings(found: Match) -> list[Finding]:
    """List all warnings of a matching; none when nothing is wrong."""
    checks = (
        _still,
        _few,
        _doubtful,
        _crowded,
        _ambiguous,
        _mirrored,
        _turned,
        _odd,
        _imprecise,
        _exchanged,
        _sizes,
    )
    said = (check(found) for check in checks)
    return [one for one in said if one is not None]


def shape(found: Match) -> np.ndarray:
    """Median shape (2, 2) of the accepted windows: how the right photo lies."""
    return np.median(found.shape[found.accepted], axis=0)


def turn_and_scale(A: np.ndarray) -> tuple[float, float]:
    """Angle in degrees, clockwise as one sees it, and scale from left to right."""
    angle = np.degrees(np.arctan2(A[1, 0] - A[0, 1], A[0, 0] + A[1, 1]))
    return float(angle), float(np.sqrt(np.abs(np.linalg.det(A))))


def parallaxes(found: Match) -> np.ndarray:
    """Differences (m, 2) of the accepted points, right less left, in pixels."""
    return (found.points - found.chosen)[found.accepted]


def doubtful(found: Match) -> np.ndarray:
    """Indices of accepted points whose quality is below the recommended one."""
    return np.flatnonzero(found.accepted & (found.quality < RECOMMENDED_QUALITY))


def _doubtful(found: Match) -> Finding | None:
    points = doubtful(found)
    if not len(points):
        return None
    have = "has" if len(points) == 1 else "have"
    q = f"{RECOMMENDED_QUALITY:g}"
    return Finding(
        "Doubtful matches",
        f"{count(len(points), 'match').capitalize()} of {np.sum(found.accepted)} {have}"
        f" a quality below {q}: {listed(points)}. The parts of such a window do not"
        " agree where it belongs, as at an edge in depth, where it sees two surfaces."
        " Some are wrong, others right all the same. To keep only those above, leave"
        " --quality out on the command line, or least_quality in Python.",
    )


def _still(found: Match) -> Finding | None:
    if not np.any(found.accepted):
        return None
    length = float(np.median(np.hypot(*parallaxes(found).T)))
    if length > STILL:
        return None
    return Finding(
        "No parallax",
        f"Between the photos a usual point moved by less than {STILL:g} px. Is it the"
        " same photo twice? Photos from one and the same place show no depth.",
    )


def _few(found: Match) -> Finding | None:
    words = _statuses.few(found, FEW)
    return Finding("Few matches", words) if words else None


def _crowded(found: Match) -> Finding | None:
    where = _statuses.crowded(found.chosen[found.accepted], found.left_size)
    if where is None:
        return None
    share, place = where
    return Finding(
        "Matches in one part of the photo",
        f"Nearly all matches lie within {100 * share:.0f} % of the left photo, {place}."
        " What is computed from them, such as the orientation, is uncertain elsewhere:"
        " choose points over all that both photos show.",
    )


def _ambiguous(found: Match) -> Finding | None:
    number = int(np.sum(np.isin(found.status, AMBIGUOUS)))
    if number < OFTEN * len(found.chosen):
        return None
    return Finding(
        "Many ambiguous points",
        f"{count(number, 'point').capitalize()} of {len(found.chosen)} look the same"
        " elsewhere, as windows of a house or rows of plants do. Among the accepted"
        " ones there may be some that jumped to a neighbour. A larger template tells"
        " more, and a smaller search leaves fewer places.",
    )


def _mirrored(found: Match) -> Finding | None:
    if not np.any(found.accepted) or np.linalg.det(shape(found)) > 0:
        return None
    return Finding(
        "Mirrored photo",
        "One of the photos is a mirror image of the other, as from a scanned slide"
        " that lay upside down. Mirror it before you measure in it.",
    )


def _turned(found: Match) -> Finding | None:
    if not np.any(found.accepted) or np.linalg.det(A := shape(found)) <= 0:
        return None
    angle, scale = turn_and_scale(A)
    if abs(angle) <= TURNED and 1 / SCALED <= scale <= SCALED:
        return None
    direction = "clockwise" if angle > 0 else "counterclockwise"
    return Finding(
        "Turned or scaled photo",
        f"The right photo shows things turned by {abs(angle):.0f} degrees {direction}"
        f" and {plain(scale)} times as large. The start values took this into account."
        " Correlation of upright windows alone, as in ncc.match, does not, and needs"
        " photos that are turned and scaled alike.",
    )


def odd(found: Match) -> np.ndarray:
    """Indices of accepted points whose shape is far from that of the others."""
    good = np.flatnonzero(found.accepted)
    if not len(good) or np.linalg.det(A := shape(found)) == 0:
        return good[:0]
    s = np.linalg.svd(found.shape[good] @ np.linalg.inv(A), compute_uv=False)
    return good[(s[:, 0] > ODD) | (s[:, 1] < 1 / ODD)]


def _odd(found: Match) -> Finding | None:
    points = odd(found)
    if not len(points):
        return None
    have = "has a window" if len(points) == 1 else "have windows"
    return Finding(
        "Odd shapes",
        f"{count(len(points), 'point').capitalize()} {have} more than {ODD:g} times"
        " longer or shorter in the right photo than the others make one expect:"
        f" {listed(points)}. Steep slopes do this, and so do wrong matches: compare"
        " them in the photos.",
    )


def _imprecise(found: Match) -> Finding | None:
    if not np.any(found.accepted):
        return None
    sd = float(np.median(found.sd[found.accepted]))
    if sd > WEAK:
        return Finding(
            "Imprecise matches",
            f"A usual match has a standard deviation of {plain(sd)} px. The photos are"
            " blurred or noisy, or their texture is weak: sharper photos, corners in"
            " place of soft ground, or a larger template help.",
        )
    weak = np.flatnonzero(found.accepted & (found.sd > COARSE))
    if not len(weak):
        return None
    have = "has" if len(weak) == 1 else "have"
    return Finding(
        "Imprecise points",
        f"{count(len(weak), 'point').capitalize()} {have} a standard deviation above"
        f" {COARSE:g} px: {listed(weak)}. Give such a point the weight that follows"
        " from it, or leave it out.",
    )


def _exchanged(found: Match) -> Finding | None:
    if not np.any(found.accepted):
        return None
    angle, _ = turn_and_scale(shape(found))
    dx, dy = np.median(parallaxes(found), axis=0)
    aside = dx > ASIDE * found.left_size[0] and dx > 2 * abs(dy)
    if abs(angle) > TURNED or not aside:
        return None
    return Finding(
        "Exchanged photos?",
        f"In the right photo a usual point lies {plain(dx, 3)} px farther to the right,"
        " as if that photo had been taken from the left. The matches are good either"
        " way; exchange the photos if what follows expects the base to point right.",
    )


def _sizes(found: Match) -> Finding | None:
    if found.left_size == found.right_size:
        return None
    (a, b), (c, d) = found.left_size, found.right_size
    cause = (
        "One was held upright: turn it, or give its camera coordinates of its own."
        if (a, b) == (d, c)
        else "One was cut, reduced or taken with another camera: one set of camera"
        " parameters cannot serve both."
    )
    return Finding(
        "Different sizes", f"The photos have {a} x {b} and {c} x {d} px. {cause}"
    )


def limits() -> list[str]:
    """Say of each limit what it decides, and why it is so large."""
    return [
        f"Fewer than {NUMBERS[FEW]} matches are called few, as a relative orientation"
        " has five unknowns and each match gives one equation; so are fewer than half"
        " of the points.",
        f"A match is doubtful below a quality of {RECOMMENDED_QUALITY:g}: on photos of"
        " known depth that limit left out most of the wrong ones, and about a fifth of"
        " the right ones.",
        f"Matches lie in one part if the middle nine tenths of their columns and rows"
        f" span less than {100 * SMALL:.0f} % of the left photo. Ambiguous points are"
        f" many from {100 * OFTEN:.0f} % on. Both are choices, no tests.",
        f"A photo is turned beyond {TURNED:g} degrees, or scaled beyond {SCALED:g}"
        " times: from there on correlation of upright windows loses many points. A"
        f" single shape is odd if a length differs by more than {ODD:g} times from what"
        " the median shape of all windows makes of it.",
        f"A usual standard deviation above {WEAK:g} px is called imprecise: good"
        f" texture gives a few hundredths. A single one above {COARSE:g} px is hardly a"
        " measurement. A parallax below"
        f" {STILL:g} px is not told from none.",
    ]
