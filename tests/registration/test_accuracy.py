"""Sums of shifts: numbers by hand, what may not change them, what they predict."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pgm_lab.registration import accuracy

SHIFTS = st.integers(2, 30).flatmap(
    lambda n: arrays(float, (n, 2), elements=st.integers(-999, 999).map(float))
)
LENGTHS = ["rmse_t", "ce90", "ce90_normal"]
ALL = ["mean_x", "sd_y", "sd_mean_x", "rmse_x", "median_y", "spread_x"]
ALL += ["sd_rmse_t", *LENGTHS]


def normal(n, sigma=1.0, mean=(0.0, 0.0), seed=1):
    return mean + sigma * np.random.default_rng(seed).normal(size=(n, 2))


def test_two_points_by_hand():
    """(Br 2) to (Br 4) with numbers that can be done on paper."""
    found = accuracy([1.0, -3.0], [2.0, 6.0])
    assert (found.mean_x, found.mean_y) == (found.median_x, found.median_y) == (-1, 4)
    assert found.rmse_x**2 == pytest.approx((1 + 9) / 2)
    assert found.rmse_y**2 == pytest.approx((4 + 36) / 2)
    assert found.rmse_t**2 == pytest.approx(25)
    assert found.sd_x**2 == pytest.approx(8)  # 2^2 + 2^2 over n - 1
    assert found.sd_mean_x == pytest.approx(2)
    # lengths squared 5 and 45: sd 20 sqrt(2), over 2 RMSE_T sqrt(2)
    assert found.sd_rmse_t == pytest.approx(20 / (2 * 5))


@given(SHIFTS, st.floats(0, 2 * np.pi), st.floats(1e-3, 1e3))
def test_axes_may_be_rotated_and_scaled(shifts, angle, size):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    one, other = accuracy(*shifts.T), accuracy(*turn @ shifts.T)
    for name in LENGTHS:
        expected = getattr(one, name)
        assert getattr(other, name) == pytest.approx(expected, rel=1e-9, abs=1e-10)
    metres = one.times(size)
    for name in ALL:
        expected = size * getattr(one, name)
        assert getattr(metres, name) == pytest.approx(expected, 1e-9, 1e-11 * size)
    assert one.times((30.0, 10.0)) == accuracy(*(shifts * (30, 10)).T)
    # A mean shift is part of the RMSE
    mean, sd, n = one.mean_y, one.sd_y, metres.n
    assert one.rmse_y**2 == pytest.approx(mean**2 + (n - 1) / n * sd**2)


def test_ce90_is_1_517_rmse_t_of_normal_shifts():
    """0.9 of 10^6 lengths are counted to 3e-4, so that CE90 is good to 1e-3 sigma."""
    shifts = normal(1_000_000)
    found = accuracy(*shifts.T)
    assert np.sum(np.hypot(*shifts.T) > found.ce90) == 100_000
    assert found.ce90_normal / found.rmse_t == pytest.approx(1.5174271, abs=1e-7)
    assert found.ce90 / found.rmse_t == pytest.approx(1.5174271, abs=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("mean", [(0.0, 0.0), (2.0, -1.0)])
def test_predicted_deviations_are_those_of_repeated_samples(mean):
    """2000 samples give a standard deviation to 1/sqrt(4000), here to 3 of those."""
    many = normal(2000 * 50, 0.5, mean, seed=4).reshape(2000, 50, 2)
    found = [accuracy(*one.T) for one in many]
    for name, sd in (("mean_x", "sd_mean_x"), ("rmse_t", "sd_rmse_t")):
        sampled = np.std([getattr(one, name) for one in found])
        predicted = np.sqrt(np.mean([getattr(one, sd) ** 2 for one in found]))
        assert predicted / sampled == pytest.approx(1, abs=0.05)


def test_robust_numbers_hold_with_a_fifth_of_blunders():
    good = normal(400, 0.1, (0.5, -0.2), seed=5)
    bad = good.copy()
    bad[:80] = np.random.default_rng(6).uniform(-3, 3, (80, 2))
    one, other = accuracy(*good.T), accuracy(*bad.T)
    assert other.rmse_t > 2 * one.rmse_t
    assert other.spread_x == pytest.approx(0.1, rel=0.5)
    assert one.spread_x == pytest.approx(0.1, rel=0.1)


def test_one_shift_alone_and_no_shift_at_all():
    found = accuracy([0.3], [-0.4])
    assert found.rmse_t == found.ce90 == pytest.approx(0.5)
    assert np.isnan([found.sd_x, found.sd_mean_y, found.sd_rmse_t]).all()
    found = accuracy(np.zeros(5), np.zeros(5))
    assert found.rmse_t == found.sd_rmse_t == found.ce90 == 0


@pytest.mark.parametrize("dx, dy", [([], []), ([1], [1, 2]), ([[1]], [[1]])])
def test_two_lists_of_the_same_length(dx, dy):
    with pytest.raises(ValueError, match="two lists of the same length"):
        accuracy(dx, dy)
