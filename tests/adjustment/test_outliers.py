"""Limits of Baarda's w and Pope's tau: by other distributions, and by chance itself."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx
from scipy import stats

from pgm_lab.adjustment import adjust, critical_tau, critical_w
from pgm_lab.adjustment.outliers import NAMES, residual_test


def test_the_limit_of_w_is_the_one_of_the_tables():
    # Baarda 1968: 3.29 for a thousandth, 2.58 for a hundredth, 1.96 for five
    assert critical_w() == critical_w(0.001)
    found = [critical_w(alpha) for alpha in (0.001, 0.01, 0.05)]
    close(found, (3.2905, 2.5758, 1.9600), atol=5e-5)


def test_the_limit_of_tau_is_that_of_a_direction_in_space():
    # tau^2 / r is a squared coordinate of a random direction: beta(1/2, (r - 1)/2).
    # With r = 2 it is |cos| of an even angle, with r = 3 even along the diameter
    for alpha in (0.05, 0.001):
        r = np.array([2, 3, 4, 18, 693, 100_000])
        squared = r * stats.beta.isf(alpha, 0.5, (r - 1) / 2)
        close(critical_tau(r, alpha), np.sqrt(squared), rtol=1e-9)
        even = 2**0.5 * np.cos(alpha * np.pi / 2)
        assert critical_tau(2, alpha) == approx(even)
        assert critical_tau(3, alpha) == approx(3**0.5 * (1 - alpha))


def test_the_limit_of_tau_is_exceeded_as_often_as_alpha_says():
    # Fifty thousand times six observations of one value, r = 5, residuals by hand
    observed = np.random.default_rng(1976).normal(size=(50_000, 6))
    v = observed.mean(axis=1, keepdims=True) - observed
    sigma0 = np.sqrt(np.sum(v**2, axis=1, keepdims=True) / 5)
    tau = v / (sigma0 * np.sqrt(5 / 6))
    for alpha in (0.001, 0.05):
        for limit, holds in (
            (critical_tau(5, alpha), True),
            (critical_w(alpha), False),
        ):
            # one observation of each, so that the cases are independent: five sd
            count = np.sum(np.abs(tau[:, 2]) > limit)
            expected = alpha * 50_000
            assert (abs(count - expected) < 5 * expected**0.5) == holds


def test_the_limit_of_tau_grows_to_that_of_w_and_stays_below_the_root_of_r():
    # A second redundant observation is needed before tau tells anything
    assert critical_tau(0) == critical_tau(1) == np.inf
    equal(critical_tau([[1, 2]]) < np.inf, [[False, True]])
    r = np.arange(2, 3000)
    limits = critical_tau(r)
    assert np.all(np.diff(limits) > 0) and np.all(limits < np.sqrt(r))
    assert limits[-1] < critical_w() and critical_w() - limits[-1] < 0.003


def mean(x):
    return np.full(5, x[0]), np.ones((5, 1))


OBSERVED = np.array([0.0, 0.1, -0.2, 0.1, 3.0])


def test_an_adjustment_says_which_test_it_has_made():
    assert (residual_test(None), residual_test(2.0)) == ("tau", "w")
    assert set(NAMES) == {"tau", "w"}
    tau, w = (adjust(mean, [0.0], OBSERVED, sigma0_prior=p) for p in (None, 2))
    assert (tau.residual_test, w.residual_test) == ("tau", "w")
    v, r = tau.residuals, 4 / 5
    close(tau.standardized, v / (tau.sigma0 * r**0.5), rtol=1e-12)
    close(w.standardized, v / (2 * r**0.5), rtol=1e-12)


@pytest.mark.parametrize("alpha", [0, 5, np.nan, "0.05"])
def test_what_is_no_probability_is_refused(alpha):
    found = adjust(mean, [0.0], OBSERVED, sigma0_prior=1.0)
    for test in (critical_w, lambda alpha: critical_tau(9, alpha), found.global_test):
        with pytest.raises(ValueError, match="alpha"):
            test(alpha)
