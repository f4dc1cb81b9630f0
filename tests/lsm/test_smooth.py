"""Images smoothed before they are matched: what is done, and what is said of it."""

import cv2
import numpy as np
import pytest

from pgm_lab import lsm, simulate
from pgm_lab.lsm import half_pixels

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


def test_errors_in_smoothed_images_are_as_predicted():
    """Residuals of the nearest pixels alone would predict two thirds of them."""
    texture = simulate.texture(0.1, seed=2)
    pair = simulate.texture_pair(
        texture, (280, 280), (2.3, 1, 0, -1.4, 0, 1), sigma=4.0
    )
    points = np.mgrid[40:241:20, 40:241:20].reshape(2, -1).T
    found = lsm.match(*pair, points, points + (2, -1), smooth=2.0)
    assert found.accepted.all()
    errors = found.points - points - (2.3, -1.4)
    variance = np.trace(found.covariance, axis1=1, axis2=2).mean()
    assert 0.8 < np.sqrt(np.sum(errors**2, axis=1).mean() / variance) < 1.25


def test_no_data_reach_as_far_as_the_smoothing():
    """Grey values around a hole rest on it."""
    left, right = PAIR
    hole = right.copy()
    hole[55:57, 65:67] = np.nan
    found = lsm.match(
        left, hole, [(70, 60), (100, 80)], [(72, 59), (102, 79)], smooth=1
    )
    assert list(found.status) == ["no data in the window", "accepted"]
