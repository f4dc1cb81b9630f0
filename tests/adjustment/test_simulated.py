"""Do the standard deviations hold? The adjustment repeated with new errors, many times.

Each test draws seeded errors for thousands of problems, adjusts them in one call, and
compares a pooled statistic with its distribution. ALARM is the probability of a false
alarm for a fresh seed, of each comparison. What is not tested here: errors that are not
normal, and nonlinearity that is large against the standard deviations.
"""

import numpy as np
import pytest
from scipy.stats import beta, chi2, f, kstest

from pgm_lab.adjustment import adjust

ALARM = 1e-6
RUNS = 4000
STATIONS = np.array([[0.0, 0.0], [90.0, 10.0], [70.0, 80.0], [-20.0, 60.0], [40, -30]])
TRUTH = np.array([50.0, 30.0, 0.4])


def distances(x):
    """Distances from five stations with a common offset: weakly nonlinear."""
    difference = x[..., None, :2] - STATIONS
    distance = np.linalg.norm(difference, axis=-1)
    one = np.ones_like(difference[..., :1])
    jacobian = np.concatenate([difference / distance[..., None], one], axis=-1)
    return distance + x[..., 2:], jacobian


def circle(x):
    """The point is known to lie on a circle about the origin."""
    row = 2 * x * (1, 1, 0)
    misclosure = np.sum(x[..., :2] ** 2, axis=-1) - TRUTH[:2] @ TRUTH[:2]
    return misclosure[..., None], row[..., None, :]


def repeated(kind, prior):
    """RUNS adjustments of observations with standard deviations near 1 cm."""
    rng = np.random.default_rng(2013)
    sigma = np.array([0.010, 0.014, 0.008, 0.012, 0.020])
    exact, _ = distances(TRUTH)
    options = {"weights": (0.01 / sigma) ** 2, "sigma0_prior": prior}
    root = np.diag(sigma)
    if kind == "covariance":
        turn = rng.normal(size=(5, 5))
        covariance = root @ (turn @ turn.T / 5 + 0.2 * np.eye(5)) @ root
        root = np.linalg.cholesky(covariance)
        options |= {"weights": None, "covariance": covariance / 0.01**2}
    if kind == "weighted parameters":
        sd = np.array([0.02, 0.01, 0.005])
        options["parameter_values"] = TRUTH + sd * rng.normal(size=(RUNS, 3))
        options["parameter_weights"] = (0.01 / sd) ** 2
    if kind == "constraint":
        options["constraints"] = circle
    observations = exact + rng.normal(size=(RUNS, 5)) @ root.T
    found = adjust(distances, np.tile(TRUTH, (RUNS, 1)) + 0.5, observations, **options)
    assert np.all(found.status == "converged")
    return found


def assert_chi2(statistic, degrees):
    """Two-sided: neither too large nor too small."""
    low, high = chi2.ppf([ALARM / 2, 1 - ALARM / 2], degrees)
    assert low < statistic < high


KINDS = ["weights", "covariance", "weighted parameters", "constraint"]


def mahalanobis(found, covariance):
    """Squared distance of each result from the truth, and its dimension."""
    error = found.x - TRUTH
    if found.redundancy[0] == 3:  # on the circle: drop what the constraint fixes
        error, covariance = error[:, 1:], covariance[:, 1:, 1:]
    inverse = np.linalg.inv(covariance)
    return np.einsum("mi,mij,mj->m", error, inverse, error), error.shape[1]


@pytest.mark.parametrize("kind", KINDS)
def test_errors_of_the_parameters_have_the_predicted_covariance(kind):
    found = repeated(kind, prior=0.01)
    covariance = 0.01**2 * found.cofactor
    squared, u = mahalanobis(found, covariance)
    assert_chi2(squared.sum(), RUNS * u)
    assert kstest(squared, chi2(u).cdf).pvalue > ALARM


@pytest.mark.parametrize("kind", KINDS)
def test_with_estimated_sigma0_the_distances_follow_fisher(kind):
    found = repeated(kind, prior=None)
    squared, u = mahalanobis(found, found.covariance)
    assert kstest(squared / u, f(u, found.redundancy[0]).cdf).pvalue > ALARM


@pytest.mark.parametrize("kind", KINDS)
def test_sigma0_follows_chi_square_and_the_global_test_keeps_its_level(kind):
    found = repeated(kind, prior=0.01)
    redundancy = {"weights": 2, "covariance": 2, "constraint": 3}.get(kind, 5)
    assert np.all(found.redundancy == redundancy)
    test = found.global_test(alpha=0.05)
    assert_chi2(test.statistic.sum(), RUNS * redundancy)
    assert kstest(test.statistic, chi2(redundancy).cdf).pvalue > ALARM
    # refused in 5 per cent of RUNS; five standard deviations of a binomial count
    refused = np.count_nonzero(~test.accepted)
    assert abs(refused - 0.05 * RUNS) < 5 * np.sqrt(RUNS * 0.05 * 0.95)


@pytest.mark.parametrize("kind", KINDS)
def test_standardised_residuals_are_normal_with_the_prior_sigma0(kind):
    w = repeated(kind, prior=0.01).standardized
    for of_one_observation in w.T:  # those of one problem are correlated
        assert_chi2(np.sum(of_one_observation**2), RUNS)
        assert kstest(of_one_observation, "norm").pvalue > ALARM


@pytest.mark.parametrize("kind", KINDS)
def test_standardised_residuals_follow_popes_tau_with_the_estimated_sigma0(kind):
    found = repeated(kind, prior=None)
    r = found.redundancy[0]
    assert np.all(found.standardized**2 <= r * (1 + 1e-9))  # tau is bounded
    for tau in found.standardized.T:
        assert kstest(tau**2 / r, beta(0.5, (r - 1) / 2).cdf).pvalue > ALARM


def test_five_per_cent_wrong_a_sigma_would_be_noticed():
    found = repeated("weights", prior=0.01)
    for factor in (0.95, 1.05):
        with pytest.raises(AssertionError):
            squared, u = mahalanobis(found, (0.01 * factor) ** 2 * found.cofactor)
            assert_chi2(squared.sum(), RUNS * u)
