"""The smooth field against scipy, and against itself without a point."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from pgm_lab._robust import nmad
from pgm_lab.registration import field


def scattered(n=80, noise=0.05, seed=1):
    """Points, shifts with noise, the standard deviations of that, and the shifts."""
    random = np.random.default_rng(seed)
    points = random.uniform(0, 400, (n, 2))
    x, y = points.T / 100
    truth = np.stack([np.sin(x) + 0.3 * y, np.cos(x - y)], axis=1)
    sd = noise * random.uniform(0.5, 2, n)
    return points, truth + sd[:, None] * random.normal(size=(n, 2)), sd, truth


def test_it_is_scipys_spline_for_the_same_smoothness():
    points, shifts, sd, _ = scattered()
    found = field.fit(points, shifts, sd)
    size = np.ptp(points[found.used], axis=0).max()
    places = np.random.default_rng(2).uniform(0, 400, (50, 2))
    for i in range(2):
        smoothing = sd[found.used] ** 2 / (2 * found.spline.ratio[i])  # r2 log r2
        other = RBFInterpolator(
            points[found.used] / size, shifts[found.used, i], smoothing=smoothing
        )
        expected = other(places / size)
        np.testing.assert_allclose(found.at(places)[:, i], expected, atol=1e-6)


def test_a_residual_is_that_of_the_field_without_the_point():
    points, shifts, sd, _ = scattered(40)
    spline = field.Spline.through(points, shifts, sd)
    size = np.ptp(points, axis=0).max()
    keep = np.arange(40) != 7
    for i in range(2):
        smoothing = sd[keep] ** 2 / (2 * spline.ratio[i])
        other = RBFInterpolator(
            points[keep] / size, shifts[keep, i], smoothing=smoothing
        )
        expected = other(points[7:8] / size)[0] - shifts[7, i]
        assert spline.left_out[7, i] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("times", [1.0, 3.0])
def test_noise_and_uncertainty_follow_from_the_shifts(times):
    """Of 20 sets: the spline is rougher than these waves, and takes some noise."""
    sigma0, errors = [], []
    for seed in range(20):
        points, shifts, sd, truth = scattered(150, seed=seed)
        found = field.fit(points, shifts, sd / times)
        sigma0.append(found.sigma0)
        errors.append((found.at(points) - truth) / found.spline.sd_at(points))
    assert np.mean(sigma0) == pytest.approx(times, rel=0.2)
    assert 0.75 < nmad(np.concatenate(errors)) < 1.2


def test_blunders_are_left_out_and_a_lattice_changes_nothing():
    points, shifts, sd, truth = scattered(200)
    shifts[:40] += np.random.default_rng(3).uniform(-3, 3, (40, 2))
    found = field.fit(points, shifts, sd)
    far = np.hypot(*(shifts - truth).T) > 0.5
    assert not found.used[far].any() and found.used[40:].mean() > 0.97
    pixels = np.stack(np.meshgrid(*[np.arange(0.0, 400)] * 2), axis=-1)
    some = pixels[::7, ::11]
    np.testing.assert_allclose(found.at(pixels)[::7, ::11], found.at(some), atol=2e-3)
    assert field.fit(points[:5], shifts[:5], sd[:5]) is None
    assert field.fit(points * (1, 0), shifts, sd) is None
