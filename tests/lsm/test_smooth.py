"""Images smoothed before they are matched: what is done, and what is said of it."""

import cv2
import numpy as np
import pytest

from pgm_lab import lsm, simulate
from pgm_lab.lsm import _normal_equations, half_pixels

PAIR = simulate.texture_pair(
    simulate.texture(0.35, seed=2), (120, 140), (2.3, 1, 0, -1.4, 0, 1), sigma=2.0
)
POINTS = np.array([(x, y) for x in (40, 70, 100) for y in (40, 60, 80)])


def test_both_images_are_smoothed_by_the_same_gaussian():
    """As if a photo editor had done it before; far from the edges."""
    found = lsm.match(*PAIR, POINTS, POINTS + (2, -1), smooth=1.0)
    before = [cv2.GaussianBlur(one, (7, 7), 1.0) for one in PAIR]
    expected = lsm.match(*before, POINTS, POINTS + (2, -1))
    assert found.accepted.all()
    np.testing.assert_allclose(found.points, expected.points, atol=1e-6)
    np.testing.assert_allclose(found.sigma0, expected.sigma0, rtol=0.2)


@pytest.mark.parametrize("smooth", [0.5, 1.0, 2.0])
def test_what_derivatives_make_of_smoothed_noise(smooth):
    """Their variance over that of a pixel, sampled."""
    noise = np.random.default_rng(1).normal(0, 1, (400, 400))
    smoothed = cv2.GaussianBlur(noise, (0, 0), smooth)[30:-30, 30:-30]
    gx, gy = (g[20:-20, 20:-20] for g in half_pixels.gradient(smoothed))
    ratio = np.mean([gx.var(), gy.var()]) / smoothed.var()
    assert abs(ratio / half_pixels.derivative_gain(smooth) - 1) < 0.05
    assert half_pixels.derivative_gain(smooth) < half_pixels.derivative_gain(0.0)


def test_residuals_are_compared_as_far_as_smoothed_noise_is_alike():
    """Half of all directions, no further than half a window."""
    assert _normal_equations._lags(0.0, 21) == _normal_equations.LAGS
    lags = _normal_equations._lags(1.0, 21)
    both = {*lags, *((-x, -y) for x, y in lags), (0, 0)}
    disc = {(x, y) for x in range(-3, 4) for y in range(-3, 4) if x * x + y * y <= 9}
    assert both == disc and 2 * len(lags) + 1 == len(disc)
    assert _normal_equations._reach(_normal_equations._lags(3.0, 5)) == 2


def test_no_data_reach_as_far_as_the_smoothing():
    """Grey values around a hole rest on it."""
    left, right = PAIR
    hole = right.copy()
    hole[55:57, 65:67] = np.nan
    found = lsm.match(
        left, hole, [(70, 60), (100, 80)], [(72, 59), (102, 79)], smooth=1
    )
    assert list(found.status) == ["no data in the window", "accepted"]


@pytest.mark.parametrize("smooth", [-1, 0.1, 3.5, np.nan])
def test_how_much_may_be_smoothed(smooth):
    with pytest.raises(ValueError, match="smooth"):
        lsm.match(*PAIR, POINTS, smooth=smooth)
