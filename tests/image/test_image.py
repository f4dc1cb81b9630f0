"""Centroid: exact truth, an independent program, and covariance against simulation.

What this does not prove: anything about targets seen at an angle, uneven lighting or
correlated noise.
"""

from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage, stats

from pgm_lab import image, simulate

OFFSET = st.floats(-0.5, 0.5)


@given(OFFSET, OFFSET, st.floats(4.0, 12.0))
def test_finds_the_true_centre_of_a_target_without_noise(dx, dy, diameter):
    truth = (12 + dx, 10 + dy)
    window = simulate.target(truth, diameter, shape=(21, 25))
    found = image.centroid(window, background=40.0, sigma=1.0)
    np.testing.assert_allclose(found.position, truth, rtol=0, atol=2e-5)
    assert found.status == "ok"


def test_dark_target_is_the_mirror_of_a_bright_one():
    bright = simulate.target((10.2, 9.6))
    dark = image.centroid(240.0 - bright, sigma=2.0, dark=True)
    expected = image.centroid(bright, sigma=2.0)
    np.testing.assert_allclose(dark.position, expected.position, atol=1e-12)
    np.testing.assert_allclose(dark.covariance, expected.covariance, atol=1e-15)


def test_agrees_with_the_moments_of_opencv_and_scipy():
    window = simulate.photograph(simulate.target((9.7, 11.2)), noise=4.0, seed=3)
    found = image.centroid(window, background=40.0, sigma=4.0).position
    moments = cv2.moments(window - 40.0)
    opencv = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
    np.testing.assert_allclose(found, opencv, rtol=0, atol=1e-10)
    scipy = ndimage.center_of_mass(window - 40.0)[::-1]
    np.testing.assert_allclose(found, scipy, rtol=0, atol=1e-10)


@pytest.mark.parametrize("background", [None, 40.0])
@pytest.mark.parametrize(
    ("threshold", "dark"), [(0.0, False), (40.0, False), (0, True)]
)
def test_covariance_is_error_propagation_by_finite_differences(
    background, threshold, dark
):
    window = simulate.target((10.3, 9.8), diameter=7.0)
    if dark:
        window = 80.0 - window
    options = {"background": background, "threshold": threshold, "dark": dark}

    def position(grey):
        return image.centroid(grey, sigma=1.0, **options).position

    step = 1e-4
    change = step * np.eye(window.size).reshape(-1, *window.shape)
    difference = position(window + change) - position(window - change)
    jacobian = difference.T / (2 * step)
    found = image.centroid(window, sigma=3.0, **options).covariance
    np.testing.assert_allclose(found, 9.0 * jacobian @ jacobian.T, rtol=1e-5, atol=1e-9)


@cache
def _targets():
    """True centres of 1500 targets and their windows without noise."""
    truth = 8 + np.random.default_rng(51).uniform(-0.5, 0.5, (1500, 2))
    return truth, simulate.target(truth, diameter=9.0, shape=(17, 17))


def _normalised_errors(noise, threshold, seed):
    """Squared Mahalanobis distances between found and true centres."""
    truth, windows = _targets()
    windows = simulate.photograph(windows, noise, seed)
    found = image.centroid(windows, sigma=noise, threshold=threshold)
    error = found.position - truth
    weight = np.linalg.inv(found.covariance)
    return np.einsum("ni,nij,nj->n", error, weight, error)


@pytest.mark.parametrize("noise", [1.0, 5.0])
def test_covariance_agrees_with_simulated_errors(noise):
    # The sum is chi-square with 2n degrees of freedom; false alarm 1 in 1000
    errors = _normalised_errors(noise, threshold=0.0, seed=52)
    low, high = stats.chi2.ppf([0.0005, 0.9995], 2 * len(errors))
    assert low < errors.sum() < high


def test_noise_is_estimated_from_the_ring_of_border_pixels():
    window = simulate.photograph(np.full((5000, 21, 21), 50.0), 4.0, seed=8)
    sigma = image.centroid(window).sigma
    # 5000 rings of 80 pixels give the variance to 0.22 per cent, three of them; to
    # divide by n in place of n - 1 would be 1.25 per cent off
    assert np.mean(sigma**2) == pytest.approx(16.0, rel=0.0067)


def test_one_window_and_a_stack_give_the_same():
    truth = np.array([[[10.2, 9.5], [9.4, 10.1]], [[10, 10], [11.5, 8.8]]])
    windows = simulate.photograph(simulate.target(truth), 2.0, seed=5)
    stack = image.centroid(windows)
    assert stack.position.shape == (2, 2, 2)
    assert stack.covariance.shape == (2, 2, 2, 2)
    one = image.centroid(windows[1, 0])
    np.testing.assert_allclose(one.position, stack.position[1, 0], rtol=1e-14)
    np.testing.assert_allclose(one.covariance, stack.covariance[1, 0], rtol=1e-12)


@pytest.mark.parametrize("sigma", [None, 3.0])
@pytest.mark.parametrize("background", [None, 90.0])
@pytest.mark.parametrize("threshold", [0.0, 3.0, 6.0, 9.0])
@pytest.mark.parametrize("size", [7, 21, pytest.param(41, marks=pytest.mark.slow)])
def test_empty_windows_are_named_and_have_no_position(
    size, threshold, background, sigma
):
    noise = simulate.photograph(np.full((500, size, size), 90.0), 3.0, seed=4)
    found = image.centroid(noise, background, sigma, threshold)
    # A robust border finds a cut target in noise once in some thousand windows
    assert np.all((found.status == "flat") | (found.status == "border"))
    assert np.mean(found.status == "flat") > 0.99
    assert np.all(np.isnan(found.position)) and np.all(np.isnan(found.covariance))


@pytest.mark.parametrize("centre", [(1.0, 10.0), (10.0, 18.5), (3.0, 10.0)])
def test_target_cut_by_the_border_is_named(centre):
    window = simulate.photograph(simulate.target(centre), 2.0, seed=2)
    found = image.centroid(window)
    assert found.status == "border"
    assert np.all(np.isnan(found.position))


@pytest.mark.parametrize(("centre", "status"), [(4.5, "border"), (6.0, "ok")])
def test_border_status_begins_at_a_quarter_of_the_height(centre, status):
    # Edge of the disc at 0 ... 1 px: 1/4 of the height is passed on the way
    window = simulate.target((centre, 10.0), diameter=10.0)
    share = (window[:, 0].max() - 40) / 160
    assert (share > 0.25) == (status == "border")
    assert image.centroid(window, sigma=1.0).status == status


def test_bright_pixel_in_the_ring_counts_above_six_sigma_only():
    window = simulate.photograph(
        simulate.target((10, 10), foreground=70.0), 3.0, seed=6
    )
    ring = np.r_[window[0], window[-1], window[1:-1, 0], window[1:-1, -1]]
    spread = 1.4826 * np.median(np.abs(ring - np.median(ring)))
    for times, status in ((5.5, "ok"), (7.0, "border")):
        changed = window.copy()
        changed[0, 5] = np.median(ring) + times * spread
        assert image.centroid(changed, threshold=9.0).status == status


def test_whole_target_in_strong_noise_is_not_called_cut():
    windows = simulate.target(np.full((300, 2), 10.0), diameter=8.0)
    status = image.centroid(simulate.photograph(windows, 12.0, seed=9), threshold=36.0)
    assert np.mean(status.status == "ok") == 1.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"window": np.zeros((2, 5))}, "at least 3 x 3 pixels"),
        ({"window": np.zeros((5, 5)), "sigma": -1.0}, "sigma must not be negative"),
        (
            {"window": np.zeros((2, 5, 5)), "background": [1, 2, 3]},
            r"background must be one number, or one for each window, shape \(2,\)",
        ),
        ({"window": np.zeros((5, 5)), "threshold": -5.0}, "threshold must not be neg"),
    ],
)
def test_bad_input_says_what_was_expected(arguments, message):
    with pytest.raises(ValueError, match=message):
        image.centroid(**arguments)


@pytest.mark.parametrize("lacking", [np.nan, np.inf, np.ma.masked])
def test_a_window_with_no_data_in_it_is_refused_and_another_is_cut(lacking):
    grey = np.ma.array(np.arange(200.0).reshape(10, 20), mask=np.zeros((10, 20), bool))
    grey[2, 3] = lacking
    np.testing.assert_array_equal(
        image.cut(grey, (12, 5), 3), np.ma.getdata(grey)[4:7, 11:14]
    )
    with pytest.raises(ValueError, match="image, in the window"):
        image.cut(grey, (4, 3), 3)


@pytest.mark.parametrize("k", [0.5, 1.0, 2.0, 3.0])
def test_noise_is_flat_and_a_bright_target_is_found_at_any_threshold(k):
    sigma, rng = 2.0, np.random.default_rng(7)
    noise = rng.normal(100, sigma, (200, 21, 21))
    found = image.centroid(noise, sigma=sigma, threshold=k * sigma)
    assert not np.any(found.status == "ok")
    # 50 pixels, 18 sigma high: several times what all 441 may weigh as noise
    target = simulate.target((10, 10), 8.0, foreground=18 * sigma, background=0)
    found = image.centroid(noise + target, sigma=sigma, threshold=k * sigma)
    assert np.all(found.status == "ok")
    assert np.abs(found.position - 10).max() < 0.3
