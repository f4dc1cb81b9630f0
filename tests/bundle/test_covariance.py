"""Correlated image coordinates: the bundle against the dense adjustment, and samples.

The dense core takes the whole covariance matrix of the observations, and shares nothing
with the bundle here but the collinearity equations and their derivatives.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx
from scipy.linalg import block_diag

from pgm_lab import bundle
from pgm_lab.camera import project
from tests.networks import dense, small

SOME = ("c", "x0", "K1")
LENS = ("c", "x0", "y0", "K1", "P1", "P2", "b1")  # all that the true camera has


def correlated(**options):
    """A small network with covariances of all kinds, up to a correlation of 0.97."""
    network = small(**options)
    rho = np.random.default_rng(8).uniform(-0.97, 0.97, len(network.xy))
    C = network.sigma[:, :, None] * network.sigma[:, None, :]
    C[:, 0, 1] *= rho
    C[:, 1, 0] *= rho
    return replace(network, sigma=None, covariance=C)


def controlled(network):
    """Four points held, so that the dense core needs no constraints."""
    return replace(network, fixed=[0, 3, 6, 9])


@pytest.mark.parametrize(
    ("options", "estimate", "prior"),
    [
        ({}, SOME, None),
        ({"cameras": 2, "skip": 15}, SOME, 0.7),
        ({"lens": "forward", "photos": 4}, (), None),
    ],
)
def test_everything_is_as_from_the_dense_adjustment(options, estimate, prior):
    network = controlled(correlated(**options))
    found = bundle.adjust(network, estimate, sigma0_prior=prior, tolerance=1e-9)
    C = block_diag(*network.covariance)
    expected, (_, exteriors, points), _ = dense(
        network, estimate, free=~network.held, covariance=C, sigma0_prior=prior
    )
    assert found.sigma0 == approx(expected.sigma0, rel=1e-9)
    close(found.exteriors, exteriors, rtol=1e-8, atol=1e-9)
    close(found.points, points, rtol=1e-8, atol=1e-6)
    u, sd = len(found.covariance), np.sqrt(np.diagonal(found.covariance))
    off = (found.covariance - expected.covariance[:u, :u]) / np.outer(sd, sd)
    assert np.abs(off).max() < 1e-6
    for name, atol in (
        ("residuals", 1e-9),
        ("redundancy_numbers", 1e-7),
        ("standardized", 1e-5),
    ):
        core = getattr(expected, name).reshape(network.xy.shape)
        close(getattr(found, name), core, rtol=0, atol=atol)
    assert found.redundancy_numbers.sum() == approx(found.redundancy)


def test_without_correlation_a_covariance_is_the_same_as_standard_deviations():
    network = small(cameras=2)
    C = network.sigma[:, :, None] ** 2 * np.eye(2)
    one = bundle.adjust(network, SOME)
    other = bundle.adjust(replace(network, sigma=None, covariance=C), SOME)
    for name in ("sigma0", "points", "covariance", "standardized", "testable"):
        values = getattr(one, name), getattr(other, name)
        close(*values, rtol=1e-9, atol=1e-12)
    equal(one.testable, one.redundancy_numbers)


def test_errors_that_follow_the_covariances_scatter_as_predicted():
    network = correlated()
    fitted = bundle.adjust(network, ())
    truth = project(
        network.cameras[0],
        fitted.exteriors[network.photo],
        fitted.points[network.point],
    )
    L, rng = np.linalg.cholesky(network.covariance), np.random.default_rng(4)
    start = replace(network, exteriors=fitted.exteriors, points=fitted.points)
    sigma0, error = [], []
    for _ in range(60):
        e = np.einsum("kij,kj->ki", L, rng.normal(size=truth.shape))
        one = bundle.adjust(replace(start, xy=truth + e), (), sigma0_prior=1.0)
        sigma0.append(one.sigma0**2)
        sd = one.sd_points / one.sigma0
        error.append((one.points - fitted.points) / sd)
    n, r = 60, one.redundancy
    assert abs(np.mean(sigma0) - 1) < 4 * np.sqrt(2 / (n * r))
    # coordinates of one network are correlated: as if a third of them were independent
    free = n * network.points.size / 3
    assert abs(np.mean(np.square(error)) - 1) < 4 * np.sqrt(2 / free)
