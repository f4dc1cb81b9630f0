"""Checks of the exercises of chapter 7, Pearson registration."""

import functools
from collections.abc import Callable

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view

from pgm_book.common.checks import (
    CheckFailed,
    answer_of,
    call,
    compare,
    first_slip,
    near,
    numbers,
    report,
)
from pgm_book.program import registration as program_registration
from pgm_lab._validate import real

SHIFT = np.array([2.0, -1.0])  # of the two images of the first section
CLOUDS = [
    (np.array([1.0, 1, 1, 1]), np.array([-1.0, -1, -1, -1])),
    (np.array([0.4, -1.2, 2.1, 0.3, 0.9]), np.array([-0.8, 1.5, 0.2, -2.2, 0.6])),
]


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
    otherwise = "count the pixels across the fringe of a vertical and a horizontal edge"
    hint = next((h for wrong, h in slips if near(found, wrong)), otherwise)
    good = bool(np.all(np.abs(found - SHIFT) <= 0.5))
    report("measured", [("within half a pixel", good, hint)])


def best_shift(function: Callable[..., object]) -> None:
    """Check the search for one chip: the whole map, and the shift of its peak."""
    maps, shifts, wanted = [], [], []
    for point, chip, radius, shift in SEARCHES:
        sensed = moved(shift)
        dx, dy, r = search_of(function, scene(), sensed, point, chip, radius)
        maps.append(r)
        shifts.append((dx, dy))
        wanted.append(map_of(scene(), sensed, point, chip, radius))
    right, hint = judge_maps(maps, wanted)
    found, true = np.array(shifts), np.array([s for *_, s in SEARCHES])
    radii = np.array([[radius] for _, _, radius, _ in SEARCHES])
    flat = np.array([[r.argmax() % len(r), r.argmax() // len(r)] for r in wanted])
    slips = [
        (-true, "the sign is reversed: sensed minus reference"),
        (true[:, ::-1], "dx and dy are exchanged: the second index of r is the column"),
        (-true[:, ::-1], "dx and dy are exchanged, and the sign is reversed"),
        (flat, "that is the position in the map: the shift 0 lies at its centre"),
        (
            flat[:, ::-1],
            "that is (row, column) in the map: the shift 0 lies at its centre",
        ),
        (true + np.array([p for p, *_ in SEARCHES]), "that is a position in the image"),
        (true + 1, "it is off by one: the shifts run from −radius to +radius"),
        (true - 1, "it is off by one: the shifts run from −radius to +radius"),
        (-radii + 0 * true, "that is the first position of the map, not the highest"),
    ]
    otherwise = "dx and dy are not the shift of the highest r in your map"
    where = first_slip(found, slips, otherwise)
    report(
        "best_shift",
        [
            ("every r is that of its shift", right, hint),
            ("the shift of the highest", near(found, true) or not right, where),
            (
                "no answer where a window leaves the image",
                keeps_inside(function),
                "near the edge of the image it returns r of windows that are not whole",
            ),
        ],
    )


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
    otherwise = "the three do not follow from (Br 2) to (Br 4)"
    holds, hint = compare(function, CLOUDS, right, slips, otherwise)
    report("rmse", [("(Br 2) to (Br 4), with the mean shift in it", holds, hint)])


def peak_of_parabola(function: Callable[..., object]) -> None:
    """Check the peak of a parabola through three values."""
    bend, top = np.array([0.1, 0.3, 0.02]), np.array([0.4, -0.25, 0.1])
    left, middle, right = (0.9 - bend * (at - top) ** 2 for at in (-1, 0, 1))
    found = np.array(
        [
            call(function, float(a), float(b), float(c), shape=())
            for a, b, c in zip(left, middle, right, strict=True)
        ]
    )
    even = call(function, 0.5, 0.9, 0.5, shape=())
    slips = [
        (-top, "the sign: the peak lies on the side of the higher neighbour"),
        (2 * top, "it is twice as far as it should be"),
        (-2 * top, "it is twice as far, and on the wrong side"),
        (top / 2, "it is half as far as it should be"),
        (-top / 2, "it is half as far, and on the wrong side"),
        ((right - left) / 2, "that is the slope: how strongly is the parabola bent?"),
        ((left - right) / 2, "that is the slope: how strongly is the parabola bent?"),
        (0.9 + 0 * top, "that is the height of the peak: its position is asked for"),
    ]
    hint = first_slip(found, slips, "the peak of an exact parabola is not found")
    report(
        "peak_of_parabola",
        [
            (
                "equal neighbours give 0",
                near(even, 0.0),
                "equal neighbours must give 0",
            ),
            ("exact for parabolas", near(found, top), hint),
        ],
    )


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
    report("border", [("all four sides of the search", good, hint)])


def chip_shifts(function: Callable[..., object]) -> None:
    """Check the shifts of many chips, refined, and NaN at the border of the search."""
    chip, radius = 11, 3
    points = np.array([(30, 40), (58, 33), (32, 62), (61, 58)])
    inside = moved((1.3, -0.6))
    right = program_registration.chip_shifts(scene(), inside, points, chip, radius)
    given = scene(), inside, points, chip, radius
    before = "exercises 7.2 and 7.4"
    found = call(function, *given, shape=right.shape, first=before)
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
            right + points,
            "those are positions in the sensed image: the shift is asked for",
        ),
        (np.broadcast_to(right[0], right.shape), "every chip has a shift of its own"),
        (np.broadcast_to(right[-1], right.shape), "every chip has a shift of its own"),
    ]
    otherwise = "the shifts are not those of best_shift plus peak_of_parabola"
    report(
        "chip_shifts",
        [
            (
                "whole pixels plus the peak, in x and in y",
                near(found, right, 1e-6),
                first_slip(found, slips, otherwise),
            ),
            *_at_the_border(function, points, chip, radius),
        ],
    )


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
    hint = "after a chip on the border, the chips that follow must still be measured"
    return [(claim, good, hint)]


# --- What the check of the search for one chip (chapter 7) looks at ---

SEARCHES = [  # point, chip, radius, shift of the sensed image
    ((38, 47), 9, 3, (2, -1)),
    ((51, 40), 7, 4, (-3, -2)),
    ((44, 36), 11, 2, (0, 1)),
]


@functools.cache
def scene() -> np.ndarray:
    """Smoothed noise, in which every window differs from the others."""
    noise = np.random.default_rng(7).normal(0, 100, (84, 96))
    return scipy.ndimage.gaussian_filter(noise, 1.2)


def moved(shift: tuple[float, float]) -> np.ndarray:
    """The scene with every point moved by (columns, rows)."""
    return scipy.ndimage.shift(scene(), shift[::-1], order=3, mode="mirror")


def search_of(
    function: Callable[..., object], *arguments: object
) -> tuple[float, float, np.ndarray]:
    """What the reader's search returns: two whole numbers and a square map."""
    radius = int(arguments[-1])  # type: ignore[call-overload]
    answer = answer_of(function, *arguments)
    try:
        dx, dy, r = answer
        found = np.array([float(dx), float(dy)])
        r = real(r, "r")
    except Exception:  # whatever a stranger's object raises
        raise CheckFailed("best_shift must return three things: dx, dy and r") from None
    n = 2 * radius + 1
    if r.shape != (n, n):
        raise CheckFailed(
            f"best_shift: with radius {radius} the map r must have shape ({n}, {n});"
            f" got {r.shape}"
        )
    return found[0], found[1], r


def judge_maps(maps: list[np.ndarray], wanted: list[np.ndarray]) -> tuple[bool, str]:
    """Whether all maps are right, and the hint to the slip that explains them."""

    def all_near(others: list[np.ndarray]) -> bool:
        return all(near(r, other, 1e-7) for r, other in zip(maps, others))

    if all_near(wanted):
        return True, ""
    cases = [(p, c, k, moved(s)) for p, c, k, s in SEARCHES]
    slips = {
        "rows come first: r[i, j] belongs to the row i and the column j": [
            r.T for r in wanted
        ],
        "the windows move the wrong way: dx is added to the column, dy to the row": [
            r[::-1, ::-1] for r in wanted
        ],
        "point is (column, row), and an image is indexed [row, column]": [
            map_of(scene(), s, p[::-1], c, k) for p, c, k, s in cases
        ],
        "the chip is cut out of the reference image, the windows out of the sensed": [
            map_of(s, scene(), p, c, k) for p, c, k, s in cases
        ],
        "both windows come from the reference image": [
            map_of(scene(), scene(), p, c, k) for p, c, k, s in cases
        ],
        "the chip moves along: it stays where it is in the reference image": [
            np.array([[_r(scene(), s, p, (i, j), (i, j), c) for i in range(-k, k + 1)]
                      for j in range(-k, k + 1)])
            for p, c, k, s in cases
        ],
        "the map is still zero at most positions: fill it for every dy and dx": [
            r * (r == r.max()) for r in wanted
        ],
        "the last row and column are still 0: the shifts go up to +radius": [
            np.pad(r[:-1, :-1], (0, 1)) for r in wanted
        ],
    }  # fmt: skip
    otherwise = "r is not the correlation of the chip with the window of each shift"
    if not any(np.any(r) for r in maps):
        return False, "the map is still zero: fill it for every dy and dx"
    return False, next(
        (h for h, others in slips.items() if all_near(others)), otherwise
    )


def map_of(
    reference: np.ndarray,
    sensed: np.ndarray,
    point: tuple[int, ...],
    chip: int,
    radius: int,
) -> np.ndarray:
    """All correlations of a search at once: another method than the loop."""
    x, y = point
    half, room = chip // 2, chip // 2 + radius
    t = reference[y - half : y + half + 1, x - half : x + half + 1]
    area = sensed[y - room : y + room + 1, x - room : x + room + 1]
    windows = sliding_window_view(area, t.shape)
    w, t = windows - windows.mean(axis=(2, 3), keepdims=True), t - t.mean()
    r = np.einsum("ijkl,kl->ij", w, t)
    return r / np.sqrt(np.einsum("ijkl,ijkl->ij", w, w) * np.sum(t * t))


def _r(
    reference: np.ndarray,
    sensed: np.ndarray,
    point: tuple[int, int],
    one: tuple[int, int],
    other: tuple[int, int],
    chip: int,
) -> float:
    """Correlation of two windows, each moved from the point by itself."""
    half, flat = chip // 2, []
    for image, (dx, dy) in ((reference, one), (sensed, other)):
        x, y = point[0] + dx, point[1] + dy
        flat.append(image[y - half : y + half + 1, x - half : x + half + 1].ravel())
    return float(np.corrcoef(flat)[0, 1])


def keeps_inside(function: Callable[..., object]) -> bool:
    """Whether a search near the edge stops, or leaves out what is outside."""
    step = np.arange(-3, 4)
    for x, y in ((5, 40), (40, 5), (90, 40), (40, 79)):
        whole_x = (x + step >= 4) & (x + step < scene().shape[1] - 4)
        whole_y = (y + step >= 4) & (y + step < scene().shape[0] - 4)
        try:
            _, _, r = answer_of(function, scene(), scene(), (x, y), 9, 3)
            left_out = real(r, "r")[~(whole_y[:, None] & whole_x)]
        except (CheckFailed, IndexError, TypeError, ValueError):
            continue
        if len(np.unique(left_out[np.isfinite(left_out)])) > 1:
            return False
    return True
