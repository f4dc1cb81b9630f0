"""Reliability, data snooping and the tests of parameters, against planted errors."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx
from scipy import stats

from pgm_lab import bundle
from pgm_lab.bundle.reliability import Significance
from tests.networks import real, small

SOME = ("c", "x0", "y0", "K1", "P1", "P2", "b1")


@pytest.fixture(scope="module")
def found():
    return bundle.adjust(small(), SOME)


@pytest.fixture(scope="module")
def of_2013():
    return bundle.adjust(real())


def with_error(network, ray, error):
    xy = network.xy.copy()
    xy[ray] += error
    return replace(network, xy=xy)


def test_an_error_of_the_internal_reliability_moves_its_test_by_delta0():
    # with the backward lens residuals are formed at corrected coordinates, where an
    # error of the measured ones appears 0.2 per cent larger
    network = small("forward", photos=8, points=20)
    found = bundle.adjust(network, SOME, sigma0_prior=1.0, tolerance=1e-9)
    limits = bundle.reliability(found)
    for ray, axis in ((0, 0), (37, 1), (100, 0)):
        # a hundredth of it, so that the model stays linear to 1e-3
        error = np.zeros(2)
        error[axis] = limits.internal[ray, axis] / 100
        wrong = with_error(network, ray, error)
        there = bundle.adjust(wrong, SOME, sigma0_prior=1.0, tolerance=1e-9)
        moved = there.standardized - found.standardized
        assert moved[ray, axis] == approx(-0.0413, rel=1e-3)
        in_sd = np.abs(there.interior - found.interior) / found.sd_interior
        in_sd *= found.sigma0  # its sd are a posteriori
        assert in_sd.max() < limits.external[ray, axis] / 100 * 1.001
        assert in_sd.max() > 0


def test_planted_blunders_are_found_one_by_one_with_their_size():
    network = small(photos=8, points=20)
    planted = {11: (0.03, 0.0), 57: (-0.012, 0.02), 130: (0.0, -0.015)}
    wrong = network
    for ray, error in planted.items():
        wrong = with_error(wrong, ray, error)
    found = bundle.snoop(wrong, SOME)
    assert [blunder.ray for blunder in found.removed] == [11, 57, 130]
    for blunder in found.removed:
        assert blunder.photo == wrong.photo[blunder.ray] + 1
        assert blunder.point == wrong.point[blunder.ray] + 1
        equal(blunder.xy, wrong.xy[blunder.ray])
    # the last one stands alone: its error is known to a sigma / root of r, 1.5 um
    last = found.removed[-1]
    close(last.error, planted[130], atol=0.004)
    clean = bundle.adjust(network.without([11, 57, 130]), SOME)
    close(found.result.sigma0, clean.sigma0, rtol=1e-8)
    assert found.stopped == "no residual above the limit"
    falling = [blunder.sigma0 for blunder in found.removed] + [found.result.sigma0]
    assert np.all(np.diff(falling) < 0)


def test_snooping_leaves_good_observations_alone_and_stops_at_its_limit():
    network = small(photos=8, points=20)
    clean = bundle.snoop(network, SOME)
    assert clean.removed == ()
    assert clean.before is clean.result
    wrong = with_error(with_error(network, 11, (0.03, 0)), 57, (0, 0.03))
    found = bundle.snoop(wrong, SOME, most=1)
    assert len(found.removed) == 1
    assert found.stopped == "limit of blunders reached"


def test_snooping_stops_at_a_ray_that_the_network_needs_and_says_what_is_left():
    network = small("forward", photos=8, points=20)
    of_point = np.flatnonzero(network.point == 5)
    wrong = with_error(network, of_point[0], (0.5, 0.5)).without(of_point[2:])
    found = bundle.snoop(wrong, SOME, sigma0_prior=1.0)
    # nothing tells which of two rays is wrong, and good ones are not to suffer for it
    assert found.removed == ()
    assert found.stopped.startswith("point 6 in photo ")
    assert "cannot be removed: a point needs at least two rays" in found.stopped
    large = np.abs(found.result.standardized).max(axis=1) > found.critical
    assert f"largest residual of {large.sum()} above" in found.stopped


def test_snooping_blames_a_wrong_control_point_before_good_rays():
    network = small(photos=8, points=20)
    index = np.array([0, 5, 11, 17])
    free = bundle.adjust(network, SOME)
    given = free.points[index].copy()
    given[2, 1] += 5.0
    wrong = replace(network, control=(index, given, 0.05))
    found = bundle.snoop(wrong, SOME)
    assert found.removed == ()
    assert found.stopped.startswith("control point 12 has the largest residual")
    worst = np.abs(found.result.control_standardized).max()
    assert worst > np.abs(found.result.standardized).max()


def test_a_false_alarm_happens_as_often_as_alpha_says():
    network = small(photos=5, points=10)
    rng = np.random.default_rng(8)
    truth = small(photos=5, points=10, sigma=1e-12)
    above, count = 0, 0
    for _ in range(60):
        noise = network.sigma * rng.normal(size=network.xy.shape)
        found = bundle.adjust(replace(network, xy=truth.xy + noise), ("c", "x0", "y0"))
        limit = bundle.critical_value(found, 0.05)
        above += np.sum(np.abs(found.standardized) > limit)
        count += found.standardized.size
    # 6000 tests, correlated within a network: 5 per cent to a relative 15 per cent
    assert above / count == approx(0.05, rel=0.15)


def test_the_real_network_has_eight_rays_beyond_the_limit():
    found = bundle.snoop(real())
    named = [(blunder.photo, blunder.point) for blunder in found.removed]
    assert named[:3] == [(6, 29), (7, 28), (7, 9)]
    assert len(named) == 8
    assert found.before.sigma0 == approx(0.34898, abs=1e-5)
    assert found.result.sigma0 == approx(0.30202, abs=1e-5)


def test_correlations_are_those_of_the_covariance_largest_first(of_2013):
    found = of_2013
    pairs = bundle.correlations(found, 0.9)
    size = [abs(r) for _, _, r in pairs]
    assert size == sorted(size, reverse=True) and min(size) > 0.9
    index = {name: i for i, name in enumerate(found.names)}
    C = found.covariance
    for one, other, r in pairs:
        i, j = index[one], index[other]
        assert r == approx(C[i, j] / np.sqrt(C[i, i] * C[j, j]))
    assert ("K1", "K2") in [(one, other) for one, other, _ in pairs]
    triangle = np.triu(np.abs(found.correlation), 1)
    assert len(pairs) == np.sum(triangle > 0.9)


def test_significance_tells_planted_parameters_from_absent_ones():
    found = bundle.adjust(small(photos=8, points=20), (*SOME, "b2"))
    by_name = {one.name: one for one in bundle.significance(found, alpha=0.001)}
    assert "c" not in by_name
    assert by_name["b1"].significant  # 2e-4, planted
    assert not by_name["b2"].significant  # not there
    one: Significance = by_name["b1"]
    assert one.t == approx(one.value / one.sd)
    assert one.p == approx(2 * stats.t.sf(abs(one.t), found.redundancy))
    # b1 displaces by b1 x, largest at the border
    largest = np.abs(found.network.xy[:, 0] - found.cameras[0].x0).max()
    assert one.effect == approx(abs(one.value) * largest)


def test_w_judges_by_the_stated_sigma_and_tau_by_the_estimated_one():
    # The image points of 2013 are stated to 1 um and measured to 0.35 um
    w, tau = bundle.adjust(real(), sigma0_prior=1.0), bundle.adjust(real())
    assert (w.residual_test, tau.residual_test) == ("w", "tau")
    close(w.standardized, tau.standardized * tau.sigma0, atol=1e-9)
    assert np.abs(w.standardized).max() == approx(2.81, abs=0.005)
    assert np.abs(tau.standardized).max() == approx(8.06, abs=0.005)
    limits = bundle.critical_value(w), bundle.critical_value(tau)
    close(limits, (3.2905, 3.2812), atol=5e-5)


@pytest.mark.parametrize("stated, rays", [(1.0, 0), (0.349, 6), (None, 8)])
def test_snooping_with_a_stated_sigma0_keeps_its_measure(stated, rays):
    # tau measures by a sigma0 that falls with each ray removed, and so removes more
    found = bundle.snoop(real(), sigma0_prior=stated)
    assert len(found.removed) == rays
    assert found.stopped == "no residual above the limit"
    assert found.result.sigma0_prior == found.before.sigma0_prior == stated
    assert found.critical == bundle.critical_value(found.result)
    assert found.result.residual_test == ("tau" if stated is None else "w")
    for blunder in found.removed[:1]:
        assert blunder.sigma0 == found.before.sigma0
