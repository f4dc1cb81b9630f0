"""Normal equations: scaling, constraints, and the diagnosis of what is undetermined."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose as close

from pgm_lab.adjustment import normal


def design(seed, n=8, u=4):
    return np.random.default_rng(seed).normal(size=(n, u))


@given(st.integers(0, 2**32 - 1), st.integers(-9, 9))
def test_solution_and_cofactor_in_any_units(seed, decade):
    A = design(seed)
    units = 10.0 ** (decade * np.array([1, -1, 0.5, 0]))
    N, n = A.T @ A, A.T @ np.arange(8.0)
    dx, Q, _, singular = normal.solve(N * units * units[:, None], n * units)
    expected = np.linalg.lstsq(A, np.arange(8.0), rcond=None)[0]
    cofactor = np.linalg.inv(N)
    assert not singular
    close(dx * units, expected, rtol=1e-6, atol=1e-9)
    scaled = Q * units * units[:, None]
    close(scaled, cofactor, rtol=1e-6, atol=1e-9)


def test_correlates_are_the_lagrange_multipliers():
    A = design(1)
    N, n = A.T @ A, A.T @ np.arange(8.0)
    C, c = np.array([[1.0, 2, 0, 0], [0, 3e5, 0, -1e5]]), np.array([0.3, -2e5])
    dx, _, k, _ = normal.solve(N, n, C, c)
    close(N @ dx + C.T @ k, n, rtol=1e-9, atol=1e-9)
    close(C @ dx, -c, rtol=1e-12)


def test_null_space_is_the_direction_that_no_observation_sees():
    A = design(5)
    A[:, 3] = 1e-5 * (A[:, 0] - 2 * A[:, 1])
    found = normal.null_space(A.T @ A, ["a", "b", "c", "d"])
    assert found.defect == 1 and found.names == ("a", "b", "d")
    direction = found.vectors[:, 0] / found.vectors[3, 0]
    close(direction, [-1e-5, 2e-5, 0, 1], atol=1e-12)


def test_two_defects_are_counted_and_each_parameter_named_once():
    A = design(6)
    A[:, 0], A[:, 2] = 0, A[:, 1]
    found = normal.null_space(A.T @ A)
    assert found.defect == 2 and found.names == ("x1", "x2", "x3")
    message = str(normal.RankDefect(found))
    assert "rank 2 of 4" in message and "x1, x2, x3" in message


def test_a_constraint_takes_its_direction_out_of_the_null_space():
    A = design(8)
    A[:, 0], A[:, 2] = 0, A[:, 1]
    found = normal.null_space(A.T @ A, constraint=np.array([[0.0, 1e6, -1e6, 0]]))
    assert found.defect == 1 and found.names == ("x1",)
