"""The short least squares of lesson A1 gives what the core gives."""

import numpy as np
import pytest

from pgm_book.program import adjustment as program
from pgm_lab.adjustment import adjust

RNG = np.random.default_rng(4)
A, P, L = RNG.normal(size=(9, 3)), RNG.uniform(0.5, 2, 9), RNG.normal(size=9)
# A plane through ten metres of ground: its columns X, Y and 1
LOCAL = np.column_stack([*RNG.uniform(-5, 5, (2, 20)), np.ones(20)])
UTM = LOCAL + (500000, 9200000, 0)


def test_the_core_finds_the_same_unknowns_residuals_and_covariance():
    core = adjust(lambda x: (A @ x, A), np.zeros(3), L, weights=P)
    x, v, sigma0, Q = program.adjust(A, P, L)
    for ours, theirs in (
        (x, core.x),
        (v, core.residuals),
        (sigma0, core.sigma0),
        (sigma0**2 * Q, core.covariance),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-12)


def test_without_redundancy_there_is_no_sigma0():
    x, v, sigma0, _ = program.adjust([[2.0]], [3.0], [4.0])
    assert x == 2 and v == 0 and np.isnan(sigma0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: program.adjust([[1, 1], [2, 2], [3, 3]], [1, 1, 1], [1, 1, 1]),
         "do not determine all 2 unknowns"),
        (lambda: program.adjust([[1.0, 1]], [1.0], [1.0]),
         "the 1 observations do not determine"),
        (lambda: program.adjust(UTM, np.ones(20), LOCAL @ (1, 2, 100)),
         "Subtract their mean first: reduce them to their centre"),
        (lambda: adjust(lambda x: (UTM @ x, UTM), np.zeros(3), LOCAL @ (1, 2, 100)),
         "nearly multiples of one another: .* UTM, subtract their mean"),
        (lambda: program.normal_equations(A, -P, L), "p must be positive"),
        (lambda: program.normal_equations(A, np.diag(P), L), "one weight for each row"),
        (lambda: program.ellipse([[1.0, 2.0], [2.0, 1.0]]), "not positive semi-defi"),
        (lambda: program.suspect([1.0], [1.0, 2.0], [0.5]), "the same observations"),
    ],
)  # fmt: skip
def test_what_would_end_in_silence_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


@pytest.mark.parametrize("units", [(1, 1, 1), (1e6, 1e-6, 1)])
def test_a_plane_reduced_to_the_centre_is_right_in_any_units(units):
    x, v, *_ = program.adjust(LOCAL * units, np.ones(20), LOCAL @ (1, 2, 100))
    np.testing.assert_allclose(x * units, (1, 2, 100), rtol=1e-12)
    np.testing.assert_allclose(v, 0, atol=1e-12)


def test_redundancy_numbers_and_the_suspect_are_those_of_the_core():
    blunder = L + 8 * (np.arange(9) == 4)
    options = {"weights": P, "sigma0_prior": 1.0}
    core = adjust(lambda x: (A @ x, A), np.zeros(3), blunder, **options)
    r = program.redundancy_numbers(A, P)
    np.testing.assert_allclose(r, core.redundancy_numbers, rtol=1e-10)
    assert r.sum() == pytest.approx(6)
    row = program.suspect(core.residuals, 1 / np.sqrt(P), r)
    assert row == np.argmax(np.abs(core.standardized)) == 4


def test_a_residual_is_suspect_only_above_the_limit_and_where_it_is_controlled():
    assert program.suspect([3.28, 1], [1, 1], [1, 1]) == -1
    assert program.suspect([1, -3.3], [1, 1], [1, 1]) == 1
    assert program.suspect([1, -99], [1, 1], [1, 0]) == -1


def test_the_ellipse_of_a_turned_covariance():
    for t in (0.3, 1.2, 2.9):
        turn = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
        found = program.ellipse(turn @ np.diag([9.0, 4.0]) @ turn.T)
        np.testing.assert_allclose(found, (3, 2, np.degrees(t)), rtol=1e-12)
