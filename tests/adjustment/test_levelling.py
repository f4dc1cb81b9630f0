"""What lesson A1 says of its levelling net, its point and a printed table is true."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import datasets
from pgm_lab.adjustment import adjust, critical_tau, critical_w

LINES = ["AB", "BC", "CD", "DA", "AC", "BD", "DE", "AE"]
KM = np.array([1.2, 0.9, 1.6, 1.4, 2.0, 2.4, 0.4, 6.0])
OBSERVED = np.array(
    [3.4176, -1.5087, -3.6988, 1.7945, 1.9054, -5.2148, 0.8282, -0.9685]  # m
)
ENDS = np.array([[(n == b) - (n == a) for n in "ABCDE"] for a, b in LINES])
A, L = ENDS[:, 1:], OBSERVED - 100 * ENDS[:, 0]
TRUTH = np.array([103.4175, 101.9062, 98.2043, 99.0318])
CD, DE, AE = (np.arange(8) == LINES.index(line) for line in ("CD", "DE", "AE"))
SURVEYS = 2000


def levelled(observed=L, prior=0.002, weights=1 / KM, A=A):
    start = np.full((*observed.shape[:-1], A.shape[1]), 100.0)
    return adjust(
        lambda x: (x @ A.T, A), start, observed, weights=weights, sigma0_prior=prior
    )


def surveys():
    errors = 0.002 * np.sqrt(KM) * np.random.default_rng(2000).normal(size=(SURVEYS, 8))
    return A @ TRUTH + errors


def test_the_global_test_accepts_95_of_100_honest_surveys_and_no_boast():
    found, repeated = levelled(), levelled(surveys())
    assert found.global_test().accepted
    accepted = np.sum(repeated.global_test(alpha=0.05).accepted)
    assert abs(accepted - 0.95 * SURVEYS) < 50  # five sd of a count
    test = found.global_test(alpha=0.05)
    limits = 2 * np.sqrt(np.array([test.lower, test.upper]) / 4)  # of sigma0, in mm
    close(limits, (0.7, 3.3), atol=0.05)
    # 0.9 mm per root km would have been a boast
    assert not levelled(prior=0.0009).global_test().accepted


def test_tau_is_nearly_blind_with_four_spare_observations():
    limits = critical_w(), critical_tau(4)
    close(limits, (3.2905, 1.9823), atol=5e-5)
    assert critical_tau(693) == approx(3.2812, abs=5e-5)  # that of chapter 6
    bad = L + 0.020 * CD
    tau = levelled(bad, prior=None)
    assert tau.residual_test == "tau" and levelled().residual_test == "w"
    assert 1000 * tau.sigma0 == approx(7.1, abs=0.05)
    largest = np.abs(tau.standardized).max()
    assert largest == approx(1.97, abs=5e-3) and largest < limits[1]
    for prior, limit, percent in ((0.002, limits[0], 99), (None, limits[1], 10)):
        size = np.abs(levelled(surveys() + 0.020 * CD, prior).standardized)
        detected = (size.argmax(axis=1) == 2) & (size[:, 2] > limit)
        assert abs(100 * detected.mean() - percent) < 2


@pytest.mark.parametrize(
    ("observed", "mm", "passes"),
    [
        (L, 2, False),
        (L + 0.02 * CD, 2, True),
        (L + 0.02 * CD, 6, False),
        (L, 0.7, True),
    ],
)
def test_a_wrongly_stated_sigma0_hides_a_blunder_or_accuses_good_lines(
    observed, mm, passes
):
    w = np.abs(levelled(observed, mm / 1000).standardized).max()
    tau = np.abs(levelled(observed, None).standardized).max()
    assert (w > critical_w()) == passes and tau < critical_tau(4)


def test_two_lines_of_one_loop_have_equal_w():
    for size in (0.012, 0.040):
        w = np.abs(levelled(L + size * DE).standardized)
        assert w[6] == approx(w[7])
    assert w[6] == approx(7.875, abs=5e-4)


def test_levelled_twice_half_of_a_blunder_would_show():
    twice = levelled(
        np.append(L, L[6]), None, 1 / np.append(KM, 0.4), np.vstack([A, A[6]])
    )
    assert round(100 * twice.redundancy_numbers[6]) == 51
    assert round(100 * levelled().redundancy_numbers[6]) == 6


def test_a_blunder_of_that_size_is_found_four_times_in_five():
    share = levelled().redundancy_numbers
    smallest = 4.13 * 0.002 * np.sqrt(KM / share)
    close(1000 * smallest[6:], 22, atol=0.5)
    for k in (2, 6):
        spoilt = surveys() + smallest[k] * (np.arange(8) == k)
        w = np.abs(levelled(spoilt).standardized[:, k])
        # five standard deviations of a count of 2000
        assert np.mean(w > critical_w()) == approx(0.8, abs=0.045)


def test_a_printed_table_knows_its_sigma0():
    """Table 4.2 over table 4.1 of Bani 2010: its errors are those of its rounding."""
    bani = datasets.bani2010()
    pixel = bani.pixels[..., 0].ravel() - bani.image_size[0] / 2
    line = np.column_stack([pixel, np.ones(20)])
    nanometres = 1e6 * bani.photo[..., 0].ravel()
    stated = 10 / np.sqrt(12)  # of a number rounded to 10 nm
    fit = adjust(lambda x: (line @ x, line), [0, 0], nanometres, sigma0_prior=stated)
    assert fit.redundancy == 18 and fit.global_test().accepted
    assert fit.sigma0 == approx(2.4, abs=0.05)
    assert abs(fit.x[0] - 23.6e6 / 1936) < 3 * fit.sd[0]


STATIONS = np.array([[0.0, 0.0], [60.0, -15.0], [140.0, 5.0]])  # m
ANGLES = np.array([0.358705, 0.117091, -0.209473])  # rad


def directions(x):
    X, Y = np.moveaxis(x[..., None, :] - STATIONS, -1, 0)
    return np.arctan2(X, Y), np.stack([Y, -X], axis=-1) / (X**2 + Y**2)[..., None]


def test_from_three_times_the_distance_only_the_line_search_arrives():
    def depth(line_search, iterations):
        return adjust(
            directions, [90, 720], ANGLES, line_search=line_search,
            max_iterations=iterations,
        ).x[1]  # fmt: skip

    assert depth(False, 1) == approx(-675, abs=0.5)
    assert abs(depth(False, 4)) > 1e4
    assert depth(True, 4) == approx(240.1, abs=0.5)


def test_from_where_full_steps_arrive():
    X, Y = np.meshgrid(np.linspace(-300, 480, 80), np.linspace(6, 900, 60))
    starts = np.stack([X, Y], axis=-1)
    point = adjust(directions, [80, 200], ANGLES)
    arrived = []
    for search in (False, True):
        with np.errstate(all="ignore"):  # full steps end at 1e200 m and beyond
            runs = adjust(directions, starts, ANGLES, line_search=search)
        near = np.abs(runs.x - point.x).max(axis=-1) < 1
        arrived.append((runs.status == "converged") & near)
    full, damped = arrived
    assert full.mean() < 0.6 and damped.mean() > 0.98
    ahead = (-100 < X) & (X < 300) & (0.5 * point.x[1] < Y) & (Y < 1.6 * point.x[1])
    middle = STATIONS.mean(axis=0)
    times = np.linalg.norm(starts - middle, axis=-1)
    times /= np.linalg.norm(point.x - middle)
    assert full[ahead].all() and not full[times > 2.4].any()
    failed = ~full & (times < 2)
    assert failed.sum() / np.sum(times < 2) == approx(1 / 6, abs=0.01)
    assert (
        np.sum(failed & (Y < point.x[1]) & ((X < 0) | (X > 140))) > 0.8 * failed.sum()
    )
