"""Windows on surfaces that are no planes: what the covariance says of their errors."""

import numpy as np
import pytest

from pgm_lab import lsm, simulate
from pgm_lab.lsm import _normal_equations

SIZE, WAVE = 200, 100.0  # px


def matched(height, template=21, sigma=2.0, seed=1, **options):
    """Errors (n, 2) over their sd where the disparity is a wave of some height (px)."""
    texture = simulate.texture(0.2, seed=seed)
    pixels = np.stack(np.meshgrid(np.arange(SIZE), np.arange(SIZE)), axis=-1) * 1.0

    def there(points):
        x, y = np.moveaxis(points, -1, 0)
        wave = height * np.sin(2 * np.pi * (x + y / 2) / WAVE)
        return points + np.stack([wave, np.zeros_like(wave)], axis=-1)

    rng = np.random.default_rng(seed)
    left, right = (
        simulate.grey_values(texture, at) + rng.normal(0, sigma, (SIZE, SIZE))
        for at in (there(pixels), pixels)
    )
    at = np.arange(30.0, SIZE - 30, template)
    points = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    truth = there(points)
    found = lsm.match(left, right, points, np.rint(truth), template, **options)
    assert found.accepted.mean() > 0.95
    error, C = (found.points - truth)[found.accepted], found.covariance[found.accepted]
    return error / np.sqrt(np.diagonal(C, axis1=1, axis2=2))


def median_sd(z):
    return np.median(np.abs(z)) / 0.6745


@pytest.mark.parametrize("template", [21, pytest.param(31, marks=pytest.mark.slow)])
def test_a_curved_surface_makes_the_predicted_error_larger(template):
    """In x, along which it is curved, the textbook's is ten times too small."""
    assert median_sd(matched(1.0, template, correlated=False)[:, 0]) > 9
    z = matched(1.0, template)
    assert 0.8 < median_sd(z[:, 0]) < 1.25
    assert np.mean(np.abs(z) > 3) < 0.05


def test_on_a_plane_nearly_nothing_changes():
    with_curvature, white = (matched(0.0, correlated=c) for c in (True, False))
    assert median_sd(with_curvature) == pytest.approx(median_sd(white), rel=0.05)


def enlarged(design, v, half):
    """What six more parameters change in the others, and Fisher's F, by numpy."""
    y, x = np.mgrid[-half : half + 1, -half : half + 1].reshape(2, -1)
    more = [design[a] * p for a in (0, 3) for p in (x * x, x * y, y * y)]
    A = np.concatenate([design, more]).T
    change, (vv,), _, _ = np.linalg.lstsq(A, v)
    k, u = A.shape
    return change[: len(design)], (v @ v - vv) / 6 / (vv / (k - u))


def test_a_move_is_the_change_of_parameters_by_six_more_if_fishers_test_says_so():
    rng, half = np.random.default_rng(2), 7
    _, x, y = _normal_equations.window_grid(half)
    moved = []
    for bent in np.linspace(0, 0.01, 30):
        gx, gy = rng.normal(0, 5, (2, x.size))
        design = np.array([gx, gx * x, gx * y, gy, gy * x, gy * y, np.ones_like(x)])
        Q = np.linalg.inv(design @ design.T)
        v = rng.normal(size=x.size) + bent * (gx * x * x - gy * x * y)
        v -= design.T @ (Q @ (design @ v))
        change, F = enlarged(design, v, half)
        for larger in (1.0, 3.0):
            found = _normal_equations.moved_by_curvature(
                design[None].astype(np.float32), Q[None], v[None], np.array([larger])
            )[0]
            # F of (6, 212) exceeds 2.893 once in a hundred
            moved.append(F > 2.893 * larger)
            expected = -change if moved[-1] else np.zeros_like(change)
            np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-6)
    assert 10 < sum(moved) < 50


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_no_accepted_point_is_without_a_covariance():
    """Grey values of any size and kind: a status where they determine none."""
    accepted = 0
    for seed in range(16):
        rng = np.random.default_rng(seed)
        grey = rng.normal(size=(70, 80))
        grey = (
            np.kron(grey[::8, ::8], np.ones((8, 8)))[:70, :80],
            np.broadcast_to(grey[0], grey.shape),
            np.where(np.abs(grey) > 2.5, 1e9, 0.0),
            grey * 10.0 ** rng.integers(-40, 40),
        )[seed % 4]
        other = np.roll(grey, -1, axis=1)
        other = other + rng.normal(size=grey.shape) * grey.std() * 1e-3
        other[:, rng.integers(20, 80) :] = other[0, 0]
        points = rng.uniform(18, 55, (20, 2))
        for options in ({}, {"radiometric": False}, {"smooth": 1.0}):
            found = lsm.match(grey, other, points, points - (1, 0), 11, **options)
            good = found.accepted
            accepted += good.sum()
            assert np.isfinite(found.covariance[good]).all()
            assert np.isfinite(found.parameter_covariance[good]).all()
    assert accepted > 100
