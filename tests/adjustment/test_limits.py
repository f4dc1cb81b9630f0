"""The constants of the adjustment, each from either side."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import bundle
from pgm_lab.adjustment import adjust, normal
from tests.networks import real


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
