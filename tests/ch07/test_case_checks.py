"""Exercise feedback of the case of chapter 7: right answers pass, slips are named."""

import numpy as np
import pytest

from pgm_book.ch07 import case_checks as chapter7c
from tests.common.slips import unnamed

RMSE_T = 2.391652149
DY = [3, -3] * 13 + [1, -1] + [0] * 22
OWN = np.column_stack([np.ones(50), DY])


def test_the_sum_passes_with_the_printed_digits_and_as_the_whole_number(capsys):
    chapter7c.sum_of_squares(50 * RMSE_T**2)
    chapter7c.sum_of_squares(286)
    assert "✓" in capsys.readouterr().out


def test_slips_of_the_sum_are_named():
    slips = [
        (RMSE_T**2, "how many chips"),
        (50 * RMSE_T, "square it first"),
        ((50 * RMSE_T) ** 2, "not squared"),
        (100 * RMSE_T**2, "both coordinates"),
        (50 * 14.34991289**2, "square metres"),
        (50 * 2.39**2, "solve the formula"),
        (..., "Your turn"),
        ("many", "one number"),
    ]
    assert unnamed(chapter7c.sum_of_squares, slips) == []


@pytest.mark.parametrize("answer", [OWN, OWN.tolist(), OWN.astype(int), -OWN])
def test_a_set_of_shifts_passes_in_any_container(answer, capsys):
    chapter7c.constructed(answer, np.mean(answer, axis=0))
    assert "✓ fourth: fifty shifts" in capsys.readouterr().out


def test_a_chosen_mean_may_lie_between_the_steps():
    chapter7c.constructed(OWN, (1.01, -0.01))


def changed(row, shift):
    other = OWN.copy()
    other[row] = shift
    return other


def test_slips_of_a_set_of_shifts_are_named():
    A, B, C = chapter7c.CANDIDATES.values()
    slips = [
        (..., (1, 0), "fourth is still empty"),
        (OWN, ..., "mean is still empty"),
        (OWN, 1, "two numbers"),
        (7, (1, 0), "list of shifts"),
        (OWN[:49], (1, 0), "fifty shifts; it has 49"),
        (OWN.T, (1, 0), "fifty shifts; it has 2"),
        (OWN[:, 0], (1, 0), "fifty rows"),
        (changed(0, (1.5, 2.5)), (1, 0), "not a whole number"),
        (changed(0, (1, 4)), (1, 0), "4 px lies beyond the search"),
        (changed(0, (1, 2)), (1, 0), "too small: it is 281"),
        (changed(49, (1, 1)), (1, 0), "too large: it is 287"),
        (OWN, (0, 0), r"its mean is \(1.00, 0.00\) px"),
        (OWN, (2, 2), "never longer than the RMS"),
        (A, (2, 1.24), "the shifts of A"),
        (B[::-1], (0, 0), "the shifts of B"),
        (C.tolist(), (0.06, 0.02), "the shifts of C"),
    ]
    assert unnamed(chapter7c.constructed, slips) == []
