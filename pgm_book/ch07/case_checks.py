"""Checks of the exercises in the case of chapter 7, the fifty shifts."""

import numpy as np

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    first_slip,
    near,
    numbers,
    report,
)

RMSE_T = 2.391652149  # px, as printed
CHIPS = 50
RADIUS = 3  # px
SUM = 286  # square pixels

_TURNS = np.resize([(1, 1), (-1, -1), (1, -1), (-1, 1)], (CHIPS, 2))
_ALIKE = np.array([(2, 1)] * 38 + [(2, 2)] * 12)
_FEW = np.array([(3, 3)] * 15 + [(2, 2)] * 2 + [(0, 0)] * 33)
# Three sets of fifty whole shifts (dx, dy) with this sum of squares
CANDIDATES = {"A": _ALIKE, "B": _TURNS * _ALIKE, "C": _TURNS * _FEW}


def sum_of_squares(answer: object) -> None:
    """Check the sum of the squared shifts, to the printed digits."""
    found = float(numbers("sum_of_squares", answer))
    slips = [
        (RMSE_T**2, "that is the mean of the squares: how many chips are there?"),
        (CHIPS * RMSE_T, "RMSE_T is a root: square it first"),
        ((CHIPS * RMSE_T) ** 2, "the number of chips is not squared"),
        (2 * CHIPS * RMSE_T**2, "n counts chips: both coordinates are in one square"),
        (36 * CHIPS * RMSE_T**2, "those are square metres: give square pixels"),
    ]
    hint = first_slip(found, slips, "solve the formula above for the sum")
    # Half a unit of the last printed digit changes the sum by 1.2e-7
    good = near(found, CHIPS * RMSE_T**2, 1e-9)
    report("sum_of_squares", [("agrees with all the printed digits", good, hint)])


def constructed(shifts: object, mean: object) -> None:
    """Check a set of shifts that prints the RMSE_T of the paper, with a chosen mean."""
    wanted = numbers("mean", mean, (2,), "two numbers, (dx, dy)")
    length = float(np.hypot(*wanted))
    if shifts is ... or shifts is None:
        raise CheckFailed("fourth is still empty. Your turn!")
    try:
        count = len(shifts)  # type: ignore[arg-type]
    except Exception:  # whatever a reader's object raises
        raise CheckFailed("fourth must be a list of shifts (dx, dy)") from None
    if count != CHIPS:
        raise CheckFailed(f"fourth must have fifty shifts; it has {count}.")
    found = numbers("fourth", shifts, (CHIPS, 2), "fifty rows (dx, dy)")
    total, middle = float((found**2).sum()), found.mean(axis=0)
    over = "too large" if total > SUM else "too small"
    off = np.abs(middle - wanted).max()
    there = f"its mean is ({middle[0]:.2f}, {middle[1]:.2f}) px"
    too_long = "no fifty shifts have it: a mean is never longer than the RMS"
    hint = too_long if length > RMSE_T else f"{there}, and you chose another"
    shown = [name for name, one in CANDIDATES.items() if _same(found, one)]
    whole = bool(np.all(found == np.round(found)))
    far = float(np.abs(found).max())
    printed = abs(total - SUM) < 1e-6
    report(
        "fourth",
        [
            ("fifty shifts", along_with(True, printed), ""),
            (
                "whole pixels",
                along_with(whole, printed),
                "a shift is not a whole number of pixels",
            ),
            (
                "within the radius",
                along_with(far <= RADIUS, printed),
                f"a coordinate of {far:g} px lies beyond the search",
            ),
            (
                "the printed RMSE_T",
                printed,
                f"the sum of its squares is {over}: it is {total:g}",
            ),
            # Sums are whole, so a mean goes in steps of 1 / 50
            ("the mean you chose", along_with(bool(off <= 0.0101), printed), hint),
            (
                "and none of the three",
                along_with(not shown, printed),
                f"these are the shifts of {''.join(shown)}: construct others",
            ),
        ],
    )


def _same(shifts: np.ndarray, others: np.ndarray) -> bool:
    """Whether two sets hold the same shifts, in whatever order."""
    one, other = (s[np.lexsort(s.T)] for s in (shifts, others))
    return np.array_equal(one, other)
