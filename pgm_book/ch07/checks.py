"""Checks of the exercises of chapter 7, Pearson registration."""

from collections.abc import Callable

import numpy as np
import scipy

from pgm_book.common.checks import (
    CheckFailed,
    along_with,
    answer_of,
    call,
    chance,
    compare,
    first_slip,
    near,
    numbers,
    report,
    shaken,
    varied,
)
from pgm_book.program import registration as program_registration
from pgm_lab import datasets
from pgm_lab._validate import real

SHIFT = np.array([2.0, -1.0])  # of the two images of the first section
CLOUDS = [
    (np.array([1.0, 1, 1, 1]), np.array([-1.0, -1, -1, -1])),
    (np.array([0.4, -1.2, 2.1, 0.3, 0.9]), np.array([-0.8, 1.5, 0.2, -2.2, 0.6])),
]


def images() -> tuple[np.ndarray, np.ndarray]:
    """Reference and sensed image of the first section; they differ by SHIFT."""
    first, second = datasets.landsat_pair()
    right, down = SHIFT.astype(int)
    across, up = slice(10 - right, 990 - right), slice(10 - down, 590 - down)
    return first.grey[10:590, 10:990].astype(float), second.grey[up, across] * 1.0


def fringe(answer: object) -> None:
    """Check the shift that the reader measured by eye, to half a pixel."""
    found = numbers("measured", answer, (2,), "two numbers, (columns, rows)")
    slips = [
        (-SHIFT, "that is reference minus sensed: magenta minus green is asked for"),
        (SHIFT[::-1], "columns come first, then rows"),
        (-SHIFT[::-1], "columns come first, and the sign is sensed minus reference"),
        (SHIFT * (1, -1), "rows are counted downwards: look at the sign of the rows"),
        (SHIFT * (-1, 1), "look at the sign of the columns: is magenta to the right?"),
        (30 * SHIFT, "those are metres: give pixels"),
        (np.zeros(2), "the fringe has a width: count the pixels across it"),
    ]
    right = np.abs(found - SHIFT) < 0.5
    otherwise = "count the pixels across the fringe of a vertical and a horizontal edge"
    if right.any():
        sure, other = ("columns", "rows") if right[0] else ("rows", "columns")
        otherwise = f"the {sure} are right; count the {other} once more"
    hint = next((h for wrong, h in slips if near(found, wrong)), otherwise)
    report("measured", [("within half a pixel", bool(right.all()), hint)])


def rmse(function: Callable[..., object]) -> None:
    """Check the root mean squares of shifts, along x, along y and together."""

    def both(one: Callable) -> Callable:
        def all_three(dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
            return np.array([one(dx), one(dy), np.hypot(one(dx), one(dy))])

        return all_three

    def right(dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
        return np.array(program_registration.rmse(dx, dy))

    def total(of: Callable) -> Callable:
        def changed(dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
            x, y, _ = right(dx, dy)
            return np.array([x, y, of(x, y)])

        return changed

    slips = {
        "the mean was subtracted first: a standard deviation does not contain the"
        " shift that all have in common": both(np.std),
        "a standard deviation, with n − 1: the mean is subtracted": both(
            lambda d: np.std(d, ddof=1)
        ),
        "the sum of the squares is divided by n here, not by n − 1": both(
            lambda d: np.sqrt(np.sum(d**2) / (len(d) - 1))
        ),
        "the sum of the squares is not divided yet": both(
            lambda d: np.sqrt(np.sum(d**2))
        ),
        "the root is missing": both(lambda d: np.mean(d**2)),
        "square each shift before you take the mean": both(lambda d: np.abs(d.mean())),
        "those are means of absolute values: squares are asked for": both(
            lambda d: np.mean(np.abs(d))
        ),
        "RMSE_T is not the sum: the two are at right angles": total(lambda x, y: x + y),
        "RMSE_T is not the mean of the two": total(lambda x, y: (x + y) / 2),
        "RMSE_T is not divided by 2 once more": total(
            lambda x, y: np.sqrt((x**2 + y**2) / 2)
        ),
        "the root of RMSE_T is missing": total(lambda x, y: x**2 + y**2),
        "RMSE_T is missing: x or y is returned twice": total(lambda x, y: y),
    }
    slips |= {
        "RMSE_x and RMSE_y are exchanged: dx gives the first": lambda dx, dy: right(
            dx, dy
        )[[1, 0, 2]],
        "RMSE_T comes last: RMSE_x, RMSE_y, RMSE_T": lambda dx, dy: right(dx, dy)[
            [2, 0, 1]
        ],
        "square each shift first, then sum": both(
            lambda d: np.sqrt(np.sum(d) ** 2 / len(d))
        ),
    }
    clouds = [(shaken(71, dx, 0.3), shaken(72, dy, 0.3)) for dx, dy in CLOUDS]
    otherwise = "the three do not follow from (Br 2) to (Br 4)"
    holds, hint = compare(function, clouds, right, slips, otherwise)
    report("rmse", [("(Br 2) to (Br 4), with the mean shift in it", holds, hint)])


def border(answer: object, dx: np.ndarray, dy: np.ndarray, radius: int) -> None:
    """Check which whole-pixel shifts lie on the border of the search."""
    if answer is ... or answer is None:
        raise CheckFailed("border is still empty. Your turn!")
    try:
        found = np.asarray(answer)
    except Exception:  # whatever a reader's object raises
        found = np.empty(0)
    if found.dtype.kind in "iuf" and np.all((found == 0) | (found == 1)):
        found = found.astype(bool)
    if found.dtype != bool or found.shape != np.shape(dx):
        raise CheckFailed(
            f"border must be {len(dx)} times True or False, one for each chip: compare"
            " the arrays dx and dy with the radius"
        )
    at_x, at_y = np.abs(dx) == radius, np.abs(dy) == radius
    slips = [
        (at_x, "a peak may also lie on the upper or the lower border"),
        (at_y, "a peak may also lie on the left or the right border"),
        (at_x & at_y, "those are the corners alone: one of the two is enough"),
        ((dx == radius) | (dy == radius), "the search has two more sides, at −radius"),
        ((dx == radius), "the search has four sides"),
        (~(at_x | at_y), "it is the other way round: True on the border"),
    ]
    otherwise = "dx or dy is as far from 0 as the search goes, and no farther"
    hint = next((h for s, h in slips if np.array_equal(found, s)), otherwise)
    good = np.array_equal(found, at_x | at_y)
    report("border", [("the peaks on the border of the search", good, hint)])


def chip_shifts(function: Callable[..., object]) -> None:
    """Check the shifts of many chips, refined, and NaN at the border of the search."""
    chip, radius = 11, 3
    fixed = np.array([(30, 40), (58, 33), (32, 62), (61, 58)])
    points = varied(73, fixed, lambda rng: fixed + rng.integers(-3, 4, (4, 2)))
    inside = moved(shaken(74, (1.3, -0.6)))
    right = program_registration.chip_shifts(scene(), inside, points, chip, radius)
    given = scene(), inside, points, chip, radius
    answer = answer_of(function, *given)
    if _nan_alone(answer):
        raise CheckFailed("chip_shifts returns nothing but NaN yet. Your turn!")
    if isinstance(answer, np.ndarray) and answer.ndim and _nan_alone(answer[1:]):
        raise CheckFailed(
            "chip_shifts: only the first chip has a shift: is `return` in the loop?"
        )
    missing = _nan_columns(answer)
    for name, other, k in (("dx", "dy", 0), ("dy", "dx", 1)):
        if missing == [k]:
            raise CheckFailed(f"chip_shifts: {other} is there, but {name} is still NaN")
    found = call(function, *given, shape=right.shape)
    whole = np.round(right)
    slips = [
        (whole, "those are whole pixels: add the peak of the parabola"),
        (right - whole, "that is the peak of the parabola alone: add the whole pixels"),
        (2 * whole - right, "the peak of the parabola has to be added"),
        (right[:, ::-1], "dx comes first, then dy"),
        (
            whole + (right - whole)[:, ::-1],
            "across and down are exchanged: a row of r holds the shifts in x",
        ),
        (
            whole[:, ::-1] + (right - whole),
            "dx belongs to the row of r, dy to its column: these two are exchanged",
        ),
        (
            right + points,
            "those are positions in the sensed image: the shift is asked for",
        ),
        (
            right + radius,
            "row and column count from the corner of r: the peak is added to dx and dy",
        ),
        (np.broadcast_to(right[0], right.shape), "every chip has a shift of its own"),
        (np.broadcast_to(right[-1], right.shape), "every chip has a shift of its own"),
    ]
    otherwise = "the shifts are not those of best_shift plus peak_of_parabola"
    good = near(found, right, 1e-6)
    border = [
        (text, along_with(holds, good), hint)
        for text, holds, hint in _at_the_border(function, points, chip, radius)
    ]
    report(
        "chip_shifts",
        [
            (
                "whole pixels plus the peak, in x and in y",
                good,
                first_slip(found, slips, otherwise),
            ),
            *border,
        ],
    )


def _nan_alone(answer: object) -> bool:
    """Whether an answer is numbers, and not one of them is one."""
    try:
        return bool(np.all(np.isnan(real(answer, "the answer"))))
    except ValueError:  # no numbers: `call` says so
        return False


def _nan_columns(answer: object) -> list[int]:
    """Which columns of a table hold no number."""
    try:
        table = real(answer, "the answer")
    except ValueError:  # no numbers: `call` says so
        return []
    return np.flatnonzero(np.isnan(table).all(axis=0)).tolist()


def _at_the_border(
    function: Callable[..., object], points: np.ndarray, chip: int, radius: int
) -> list[tuple[str, bool, str]]:
    """Whether a peak on the border becomes NaN, on all four sides, and no other."""

    def nan_at(sensed: np.ndarray) -> np.ndarray:
        answer = answer_of(function, scene(), sensed, points, chip, radius)
        return np.isnan(real(answer, "the answer")).all(axis=-1)

    claim = "NaN where the peak lies on the border of the search, and only there"
    left = np.arange(scene().shape[1]) < 46
    inside = moved((1.8, -2.2))  # the peak one pixel from the border
    try:
        for shift in ((3, 0), (-3, 1), (0, 3), (1, -3)):
            if not nan_at(moved(shift)).all():
                hint = "a peak on the border of the search is not a shift: leave its"
                return [(claim, False, f"{hint} row NaN")]
        if nan_at(inside).any():
            hint = "a peak one pixel inside the border has both its neighbours: keep it"
            return [(claim, False, hint)]
        mixed = nan_at(np.where(left, moved((3, 0)), inside))
    except (CheckFailed, ValueError):
        hint = "it stops where the peak lies on the border of the search"
        return [(claim, False, hint)]
    good = np.array_equal(mixed, left[points[:, 0]])
    hint = "one row for each point, NaN included: go on after a chip on the border"
    return [(claim, good, hint)]


# --- What the check of the shifts looks at ---


def scene() -> np.ndarray:
    """Smoothed noise, in which every window differs from the others."""
    noise = chance(7).normal(0, 100, (84, 96))
    return scipy.ndimage.gaussian_filter(noise, 1.2)


def moved(shift: tuple[float, float]) -> np.ndarray:
    """The scene with every point moved by (columns, rows)."""
    return scipy.ndimage.shift(scene(), shift[::-1], order=3, mode="mirror")
