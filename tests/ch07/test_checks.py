"""Exercise feedback of chapter 7: right answers pass, each slip is named."""

import numpy as np
import pytest

from pgm_book.ch07 import checks as chapter7
from pgm_book.program import registration as program_registration
from pgm_lab import image, ncc
from tests.common.slips import unnamed


def loop(reference, sensed, point, chip, radius):
    """The search, as the lesson shows it."""
    x, y = point
    template = image.cut(reference, (x, y), chip)
    r = np.zeros((2 * radius + 1, 2 * radius + 1))
    for i in range(2 * radius + 1):
        for j in range(2 * radius + 1):
            middle = x + j - radius, y + i - radius
            r[i, j] = ncc.correlation(template, image.cut(sensed, middle, chip))
    row, column = np.unravel_index(r.argmax(), r.shape)
    return column - radius, row - radius, r


def at_once(reference, sensed, point, chip, radius):
    """The same by one call, with a list for an answer."""
    (x, y), half = point, chip // 2
    t = reference[y - half : y + half + 1, x - half : x + half + 1]
    room = half + radius
    if min(x, y) < room or x + room >= sensed.shape[1] or y + room >= sensed.shape[0]:
        raise ValueError("the search leaves the image")
    s = sensed[y - room : y + room + 1, x - room : x + room + 1]
    r = ncc.correlation_map(t, s)
    best = max((value, i, j) for (i, j), value in np.ndenumerate(r))
    return [best[2] - radius, best[1] - radius, r.tolist()]


@pytest.mark.parametrize("answer", [(2, -1), [2.0, -1.0], np.array([2.3, -0.8])])
def test_what_was_measured_by_hand_passes(answer, capsys):
    chapter7.fringe(answer)
    assert capsys.readouterr().out.count("✓") == 1


def test_a_slip_by_hand_is_named():
    slips = [
        (..., "still empty"),
        (2, "two numbers"),
        ((-2, 1), "magenta minus green"),
        ((-1, 2), "columns come first"),
        ((1, -2), "columns come first, and the sign"),
        ((2, 1), "downwards"),
        ((-2, -1), "sign of the columns"),
        ((60, -30), "metres"),
        ((0, 0), "has a width"),
        ((3, -1), "columns once more"),
        ((2.5, -1), "rows are right"),
    ]
    assert unnamed(chapter7.fringe, slips) == []


def test_right_root_mean_squares_pass(capsys):
    chapter7.rmse(program_registration.rmse)
    chapter7.rmse(
        lambda dx, dy: [
            (x := (sum(d * d for d in dx) / len(dx)) ** 0.5),
            (y := np.linalg.norm(dy) / np.sqrt(dy.size)),
            (x**2 + y**2) ** 0.5,
        ]
    )
    assert capsys.readouterr().out.count("✓") == 2


def three(one):
    return lambda dx, dy: (one(dx), one(dy), np.hypot(one(dx), one(dy)))


def root(d):
    return np.sqrt(np.mean(d**2))


def test_a_slip_of_the_root_mean_squares_is_named():
    slips = [
        (three(np.std), "mean was subtracted"),
        (three(lambda d: np.std(d, ddof=1)), "standard deviation, with n − 1"),
        (three(lambda d: np.sqrt(np.sum(d**2) / (len(d) - 1))), "by n here"),
        (three(lambda d: np.sqrt(np.sum(d**2))), "not divided yet"),
        (three(lambda d: np.mean(d**2)), "root is missing"),
        (three(lambda d: abs(np.mean(d))), "square each shift"),
        (three(lambda d: np.mean(np.abs(d))), "absolute values"),
        (lambda dx, dy: (root(dx), root(dy), root(dx) + root(dy)), "not the sum"),
        (
            lambda dx, dy: (root(dx), root(dy), (root(dx) + root(dy)) / 2),
            "not the mean",
        ),
        (
            lambda dx, dy: (root(dx), root(dy), np.hypot(root(dx), root(dy)) / 2**0.5),
            "divided by 2",
        ),
        (lambda dx, dy: (root(dx), root(dy), root(dx) ** 2 + root(dy) ** 2), "root of"),
        (lambda dx, dy: (root(dx), root(dy), root(dy)), "missing"),
        (lambda dx, dy: (root(dy), root(dx), np.hypot(root(dx), root(dy))), "exchang"),
        (lambda dx, dy: (np.hypot(root(dx), root(dy)), root(dx), root(dy)), "last"),
        (three(lambda d: np.sqrt(np.sum(d) ** 2 / len(d))), "then sum"),
        (lambda dx, dy: (root(dx), root(dy)), "shape"),
        (lambda dx, dy: (0, 0, 0), "do not follow"),
    ]
    assert unnamed(chapter7.rmse, slips) == []


def peak(a, b, c):
    return (c - a) / 2 / (2 * b - a - c)


def shifts(reference, sensed, points, chip, radius, part=lambda r, i, j: None):
    """The solution of exercise 7.4, in other words."""
    rows = []
    for point in points:
        dx, dy, r = at_once(reference, sensed, point, chip, radius)
        i, j, r = dy + radius, dx + radius, np.array(r)
        if 0 < i < 2 * radius and 0 < j < 2 * radius:
            rows.append(
                (dx + peak(*r[i, j - 1 : j + 2]), dy + peak(*r[i - 1 : i + 2, j]))
            )
        else:
            rows.append((np.nan, np.nan))
    return rows


def test_right_shifts_of_many_chips_pass(capsys):
    chapter7.chip_shifts(program_registration.chip_shifts)
    chapter7.chip_shifts(shifts)
    assert capsys.readouterr().out.count("✓") == 2


def altered(change):
    return lambda *a: change(np.array(shifts(*a)), np.array(a[2]))


def across_and_down_exchanged(reference, sensed, points, chip, radius):
    found = np.array(shifts(reference, sensed, points, chip, radius))
    whole = np.round(found)
    return whole + (found - whole)[:, ::-1]


def with_border(reference, sensed, points, chip, radius):
    found = np.array(shifts(reference, sensed, points, chip, radius))
    searched = [loop(reference, sensed, p, chip, radius)[:2] for p in points]
    return np.where(np.isfinite(found), found, searched)


def nan_inside_the_border(reference, sensed, points, chip, radius):
    """`abs(dx) < radius - 1` for `abs(dx) < radius`."""
    found = np.array(shifts(reference, sensed, points, chip, radius))
    near_it = np.abs(np.round(found)).max(axis=1, keepdims=True) >= radius - 1
    return np.where(near_it, np.nan, found)


def ends_at_the_border(reference, sensed, points, chip, radius):
    """`break` for `continue`."""
    found = np.array(shifts(reference, sensed, points, chip, radius))
    found[np.isnan(found).cumsum(axis=0) > 0] = np.nan
    return found


def stops_at_the_border(reference, sensed, points, chip, radius):
    found = np.array(shifts(reference, sensed, points, chip, radius))
    if np.isnan(found).any():
        raise IndexError("index 7 is out of bounds")
    return found


def test_a_slip_of_the_shifts_is_named():
    slips = [
        (altered(lambda f, p: np.round(f)), "whole pixels: add"),
        (altered(lambda f, p: f - np.round(f)), "alone"),
        (altered(lambda f, p: 2 * np.round(f) - f), "has to be added"),
        (altered(lambda f, p: f[:, ::-1]), "dx comes first"),
        (altered(lambda f, p: f + p), "positions in the sensed image"),
        (altered(lambda f, p: 0 * f + f[0]), "shift of its own"),
        (altered(lambda f, p: f.T), "shape"),
        (altered(lambda f, p: 0.5 * f), "best_shift plus"),
        (altered(lambda f, p: f * np.nan), "Your turn"),
        (across_and_down_exchanged, "across and down"),
        (altered(lambda f, p: f - np.round(f) + np.round(f)[:, ::-1]), "dx belongs"),
        (altered(lambda f, p: np.where([True, False], f, np.nan)), "dy is still NaN"),
        (with_border, "leave its row NaN"),
        (nan_inside_the_border, "both its neighbours"),
        (ends_at_the_border, "NaN included"),
        (stops_at_the_border, "it stops"),
    ]
    assert unnamed(chapter7.chip_shifts, slips) == []


DX = np.array([3.0, 0, -3, 1, 0, 3, 2])
DY = np.array([0.0, 3, 1, -3, 0, -3, -2])


def test_the_right_border_passes_as_array_and_as_list(capsys):
    right = np.maximum(np.abs(DX), np.abs(DY)) >= 3
    for answer in (right, right.tolist(), right.astype(int), 1.0 * right):
        chapter7.border(answer, DX, DY, 3)
    assert capsys.readouterr().out.count("✓") == 4


def test_a_slip_of_the_border_is_named():
    slips = [
        (..., "still empty"),
        ([1, 2], "True or False"),
        (np.abs(DX) == 3, "upper or the lower"),
        (np.abs(DY) == 3, "left or the right"),
        ((np.abs(DX) == 3) & (np.abs(DY) == 3), "corners alone"),
        ((DX == 3) | (DY == 3), "two more sides"),
        (DX == 3, "four sides"),
        (np.maximum(np.abs(DX), np.abs(DY)) < 3, "other way round"),
        (np.maximum(np.abs(DX), np.abs(DY)) >= 2, "no farther"),
    ]
    assert unnamed(lambda answer: chapter7.border(answer, DX, DY, 3), slips) == []
