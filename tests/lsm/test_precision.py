"""The fine interpolation and the dense adjustment, each on its own."""

import numpy as np
import pytest

from pgm_lab import lsm, simulate
from pgm_lab.lsm import _normal_equations, half_pixels

SOFT = simulate.texture(0.2, seed=4)


def inner_points(n=200, seed=2):
    """Points of an image of 90 x 100 pixels, away from its mirrored borders."""
    return np.random.default_rng(seed).uniform(20, 70, (n, 2))


def image_of(texture, shape=(90, 100)):
    return simulate.texture_pair(texture, shape, (0, 1, 0, 0, 0, 1))[0]


# Largest error in grey values for a contrast of 40: what design and spline leave
@pytest.mark.parametrize(
    ("cutoff", "largest"), [(0.1, 0.02), (0.2, 0.05), (0.3, 0.2), (0.4, 1.0)]
)
def test_fine_interpolation_errs_by_a_thousandth_of_the_contrast(cutoff, largest):
    texture = simulate.texture(cutoff, seed=6)
    points = inner_points()
    fine = half_pixels.coefficients(image_of(texture))
    found = half_pixels.sample(fine, *points.T)
    np.testing.assert_allclose(
        found, simulate.grey_values(texture, points), rtol=0, atol=largest
    )


def test_gradients_are_those_of_the_texture():
    image = image_of(SOFT)
    points = inner_points()
    truth = simulate.grey_gradients(SOFT, points)
    found = half_pixels.sample_gradient(half_pixels.coefficients(image), *points.T)
    # Of some 25 grey values per pixel
    np.testing.assert_allclose(found.T, truth, rtol=0, atol=0.15)
    y, x = np.mgrid[20:70, 20:70]
    gx, gy = half_pixels.gradient(image)
    truth = simulate.grey_gradients(SOFT, np.stack([x, y], axis=-1))
    found = np.stack([gx, gy], axis=-1)[20:70, 20:70]
    # At 0.2 cycles a pixel the quintic spline loses 0.3 per cent of slopes up to 80
    np.testing.assert_allclose(found, truth, rtol=0, atol=0.25)


def test_interpolation_averages_noise_as_much_as_noise_gain_says():
    rng = np.random.default_rng(8)
    noise = rng.normal(size=(400, 400))
    fine = half_pixels.coefficients(noise)
    y, x = np.mgrid[20:380, 20:380].astype(float)
    for dx, dy in [(0, 0), (0.5, 0.5), (0.25, 0.5), (0.1, 0.8)]:
        variance = np.var(half_pixels.sample(fine, x + dx, y + dy))
        expected = half_pixels.noise_gain(np.array(20.0 + dx), np.array(-3 + dy))
        # Variance of the variance of 130,000 values that are nearly independent
        assert abs(variance / expected - 1) < 5 * np.sqrt(2 / x.size) * 1.5


@pytest.mark.parametrize("half", [2, 6, 10, 12])
def test_the_noise_of_a_window_is_that_of_its_pixels(half):
    T = np.array([[[30.3, 1, 0], [40.5, 0, 1]], [[30.3, 1.04, 0.02], [40.5, -0.03, 1]]])
    x, y = np.moveaxis(T @ _normal_equations.window_grid(half), 1, 0)
    expected = half_pixels.noise_gain(x, y).mean(axis=1)
    found = _normal_equations._noise_gain(T, half)
    assert found[0] == pytest.approx(expected[0])  # a shift: all pixels alike
    assert found[1] == pytest.approx(expected[1], abs=0.02)  # 49 of them


def test_the_dense_adjustment_finds_the_minimum_and_says_how_good_it_is():
    affine = (3.3, 1.015, 0.02, -2.2, -0.025, 0.99)
    left, right = simulate.texture_pair(SOFT, (100, 110), affine, sigma=1.0)
    points = np.array([(50.3, 48.8), (60.0, 40.0)])
    x, y = points.T
    a0, a1, a2, b0, b1, b2 = affine
    truth = np.tile([0, a1, a2, 0, b1, b2, 0, 1.0], (2, 1))
    truth[:, 0], truth[:, 3] = a0 + a1 * x + a2 * y, b0 + b1 * x + b2 * y
    start = truth + [0.4, 0, 0, -0.3, 0, 0, 0, 0]
    found = lsm.adjust(left, right, points, start)
    assert found.status.tolist() == ["converged"] * 2
    assert np.all(np.abs(found.x - truth) < 5 * found.sd)
    np.testing.assert_allclose(found.redundancy_numbers.sum(axis=1), 433, rtol=1e-9)
    np.testing.assert_allclose(
        found.sigma0**2 * 433, (found.residuals**2).sum(axis=1), rtol=1e-9
    )
    # At the minimum of vᵀv no parameter can be moved to a smaller one
    for k in range(8):
        for sign in (-1, 1):
            x = found.x + 0
            x[:, k] += sign * 0.3 * found.sd[:, k]
            other = lsm.adjust(left, right, points, x, max_iterations=1)
            assert np.all(other.history.objective[0] > found.sigma0**2 * 433)


def test_the_dense_adjustment_names_windows_that_leave_an_image():
    left, right = simulate.texture_pair(SOFT, (60, 60), (0, 1, 0, 0, 0, 1))
    p = np.array([[30, 1, 0, 30, 0, 1, 0, 1.0], [55, 1, 0, 30, 0, 1, 0, 1.0]])
    found = lsm.adjust(left, right, [(30, 30), (30, 30)], p)
    assert found.status.tolist() == ["converged", "diverged"]
    with pytest.raises(ValueError, match=r"points \[1\] leave the left image"):
        lsm.adjust(left, right, [(30, 30), (4, 30)], p)
    with pytest.raises(ValueError, match="parameters must be"):
        lsm.adjust(left, right, [(30, 30)], p)


def test_without_radiometric_parameters_the_covariance_is_as_promised():
    """Errors of many matches, and the bound for known h0 and h1."""
    affine = (2.3, 1, 0, -1.6, 0, 1)
    grid = np.arange(25.0, 235, 14)
    points = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    errors, predicted = [], []
    for seed in range(3):
        left, right = simulate.texture_pair(
            SOFT, (260, 260), affine, sigma=2.0, seed=seed
        )
        found = lsm.match(left, right, points, points + (2, -2), 11, radiometric=False)
        assert found.redundancy == 11**2 - 6
        assert not found.parameter_covariance[found.accepted][:, 6:].any()
        np.testing.assert_array_equal(
            found.parameters[found.accepted][:, 6:], [[0, 1]] * found.accepted.sum()
        )
        errors.append((found.points - points - (2.3, -1.6))[found.accepted])
        predicted.append(found.covariance[found.accepted])
    e, C = np.concatenate(errors), np.concatenate(predicted)
    distance = np.einsum("ni,nij,nj->n", e, np.linalg.inv(C), e)
    # Chi square with two degrees of freedom: mean 2, standard deviation 2
    assert np.mean(distance) == pytest.approx(2, abs=4 * 2 / np.sqrt(len(e)))
