"""The constants of the adjustment, each from either side."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import bundle
from pgm_lab.adjustment import RankDefect, adjust, normal
from pgm_lab.bundle import datum, snooping, solve
from tests.networks import real, small


def inflated(times):
    """Normal matrix whose two parameters inflate each other's variance so often."""
    r = np.sqrt(1 - 1 / times)
    return np.array([[1.0, r], [r, 1.0]])


@pytest.mark.parametrize("times, singular", [(0.9e12, False), (1.1e12, True)])
def test_a_variance_inflated_a_million_million_times_is_not_determined(times, singular):
    N = inflated(times)
    dx, Q, _, found = normal.solve(N, np.ones(2))
    assert found == singular == bool(np.isnan(dx).all())
    if not singular:
        assert Q[0, 0] == approx(times, rel=1e-3)
    # of constraints the same: two that are nearly one
    C = np.linalg.cholesky(N)
    assert normal.solve(np.eye(2), np.ones(2), C)[3] == singular


@pytest.mark.parametrize("times, defect", [(0.22e12, 0), (0.28e12, 1), (1.1e12, 1)])
def test_what_is_not_determined_is_always_named(times, defect):
    # smaller eigenvalue 1 - r, half of 1 / times, against 2 / 1e12
    found = normal.null_space(inflated(times), ["one", "other"])
    assert found.defect == defect
    assert found.names == ("one", "other")[: 2 * defect]


@pytest.mark.parametrize("variance, fixed", [(0.8e-14, True), (1.25e-14, False)])
def test_a_variance_that_constraints_deflate_to_rounding_is_zero(variance, fixed):
    C = np.array([[1.0, np.sqrt(variance)]])
    Q = normal.solve(np.eye(2), np.ones(2), C)[1]
    expected = 0 if fixed else variance
    assert Q[0, 0] == approx(expected, rel=0.1)
    assert (Q[0, 1] == 0) == fixed
    assert Q[1, 1] == approx(1)


@pytest.mark.parametrize("halvings, arrives", [(20, True), (21, False)])
def test_a_step_is_halved_twenty_times_and_no_more(halvings, arrives):
    # derivatives too small by as much: only the shortest step lowers vᵀPv
    def short(x):
        return x, np.full((1, 1), 2.0**-halvings)

    found = adjust(short, [0.0], [1.0], max_iterations=1)
    assert (found.history.step[0] == 2.0**-20) == arrives
    assert (found.status == "diverged") == (not arrives)
    assert found.x[0] == approx(1.0 if arrives else 0.0)


def falls(share):
    """Equation whose full step lowers vᵀPv by this share, and half of it by more."""
    heights = [1.0, 0.1, np.sqrt(1 - share)]

    def function(x):
        return np.interp(x, [0, 0.5, 1], heights), np.array([[-1.0]])

    return function


@pytest.mark.parametrize("share, step", [(1.9e-4, 0.5), (2.1e-4, 1.0)])
def test_a_step_must_bring_a_ten_thousandth_of_what_it_promises(share, step):
    # vᵀPv / 2 is what is promised for the full step: 2e-4 of vᵀPv
    found = adjust(falls(share), [0.0], [0.0], max_iterations=1)
    assert found.history.step[0] == step


@pytest.mark.parametrize("eps, iterations", [(190, 1), (210, 2)])
def test_without_errors_a_step_below_a_hundred_roundings_is_the_last(eps, iterations):
    # 100 eps of the observations, and as much of the parameter: 200 eps in all
    def four(x):
        return np.full(4, x[0]), np.ones((4, 1))

    start = 1 + eps * np.finfo(float).eps
    found = adjust(four, [start], np.ones(4))
    assert (found.iterations, found.status) == (iterations, "converged")
    assert found.x[0] == approx(1, abs=1e-15)


@pytest.mark.parametrize("weight, tested", [(0.9e-9, False), (1.1e-9, True)])
def test_an_observation_controlled_by_less_than_a_billionth_is_not_tested(
    weight, tested
):
    def two(x):
        return np.full(2, x[0]), np.ones((2, 1))

    found = adjust(two, [0.0], [0.0, 1.0], weights=[1.0, weight], sigma0_prior=1.0)
    assert found.redundancy_numbers[0] == approx(weight, rel=1e-5)
    assert (found.standardized[0] != 0) == tested
    assert found.standardized[1] != 0


@pytest.mark.parametrize("r, estimated", [(0.9e-9, False), (1.1e-9, True)])
def test_of_an_uncontrolled_blunder_no_size_is_estimated(r, estimated):
    found = bundle.adjust(small(), ("c",))
    numbers = found.testable.copy()
    numbers[5, 0] = r
    error = snooping._blunder(replace(found, testable=numbers), 5, 5).error
    expected = -found.residuals[5, 0] / r if estimated else 0
    assert error[0] == approx(expected)
    other = -found.residuals[5, 1] / found.testable[5, 1]
    assert error[1] == approx(other)


def test_a_network_without_redundancy_takes_the_sigma0_that_was_stated():
    """Five points in two photos: 20 coordinates, and as many unknowns to find."""
    network = real()
    rays = np.isin(network.photo, (0, 8)) & (network.point < 5)
    bare = bundle.Network(
        *(network.cameras, network.exteriors[[0, 8]], network.points[:5]),
        *(network.photo[rays] // 8, network.point[rays], network.xy[rays]),
        network.sigma[rays],
    )
    unknown = bundle.adjust(bare, ())
    assert unknown.redundancy == 0 and np.isnan(unknown.sigma0)
    for covariance in (unknown.covariance, unknown.covariance_points):
        assert np.isnan(covariance).all()
    one, three = (
        bundle.adjust(bare, (), sigma0_prior=prior, tolerance=1e-10)
        for prior in (1.0, 3.0)
    )
    close(three.covariance, 9 * one.covariance, rtol=1e-9)
    close(three.sd_points, 3 * one.sd_points, rtol=1e-9)
    assert one.sd_points.min() > 0 and np.isnan(one.sigma0)
    # Q itself: the same network with sigmas three times as large
    wide = replace(bare, sigma=3 * bare.sigma)
    wide = bundle.adjust(wide, (), sigma0_prior=1.0, tolerance=1e-10)
    close(three.sd_points, wide.sd_points, rtol=1e-6)
    for found in (unknown, one, three):
        assert found.status == "converged"
        assert not found.redundancy_numbers.any() and not found.standardized.any()
    assert bundle.snoop(bare, ()).removed == ()
    assert np.isinf(bundle.critical_value(unknown))


def test_the_change_counts_in_the_sigma0_that_was_stated_or_else_in_the_residuals():
    A = np.array([[1.0], [1.0]])
    for observed, prior, sigma in (
        ([1.0, 3.0], 0.5, 0.5),
        ([1.0, 3.0], None, np.sqrt(1 + 9)),  # v at the start; redundancy 1
        ([2.0], None, 2.0),  # without redundancy: as if it were 1
        ([2.0], 0.5, 0.5),
    ):
        rows = A[: len(observed)]
        found = adjust(
            lambda x, A=rows: (A @ x, A), [0.0], observed, sigma0_prior=prior
        )
        sd = sigma / np.sqrt(len(observed))
        assert found.history.change[0] == approx(2.0 / sd)


@pytest.mark.parametrize("share, regular", [(0.8e-12, False), (1.25e-12, True)])
def test_the_bundle_has_the_same_limit_of_inflation(share, regular):
    """Of x0 only this share is its own: c and the rest explain all of it but that."""
    problem = solve.Problem.of(small(), ("c", "x0"))
    state = problem.start
    move = datum.free_motions(problem.network, state, problem.rays.interior)
    reduced = solve.Reduced.of(problem, state, problem.equations(state))
    S = reduced.S.copy()
    times = np.sqrt(reduced.diagonal[1] / S[0, 0])
    S[1], S[:, 1] = times * S[0], times * S[:, 0]
    S[1, 1] = times**2 * S[0, 0] * (1 + share)
    alike = replace(reduced, S=S)
    if regular:
        solve._factor(problem, state, alike, move)
    else:
        with pytest.raises(RankDefect, match="rank 37 of 38"):
            solve._factor(problem, state, alike, move)
