"""The few lines of lesson 3 give what the program gives."""

import numpy as np
import pytest

from pgm_book.program import lsm as program
from pgm_lab import lsm, simulate

AFFINE = np.array([2.3, 1.02, 0.05, -1.6, -0.03, 0.99])
POINT = np.array([33, 36])
PLACE = AFFINE.reshape(2, 3) @ (1, *POINT)
START = np.array([38.0, 1, 0, 33, 0, 1, 0, 1])


def pair(sigma=0.0):
    return simulate.texture_pair(
        simulate.texture(seed=1), (70, 70), AFFINE, sigma=sigma, gain=1.1, offset=5.0
    )


def test_a_window_without_noise_is_found_to_a_thousandth_of_a_pixel():
    """What is left is the interpolation by a cubic spline: below 0.001 px, (B 2.7)."""
    trail, _, _ = program.match(*pair(), POINT, START, 21)
    np.testing.assert_allclose(trail[0], START)
    np.testing.assert_allclose(trail[-1, [0, 3]], PLACE, atol=1e-3)
    np.testing.assert_allclose(trail[-1, 7], 1 / 1.1, atol=1e-3)


def test_the_vectorised_adjustment_finds_the_same():
    """It interpolates on a doubled grid, which smooths the noise 2 % less."""
    left, right = pair(sigma=1.0)
    trail, sigma0, Q = program.match(left, right, POINT, START, 21)
    same = lsm.adjust(left, right, POINT[None].astype(float), START[None], 21)
    np.testing.assert_allclose(trail[-1, [0, 3]], same.x[0, [0, 3]], atol=2e-3)
    np.testing.assert_allclose(sigma0, same.sigma0[0], rtol=0.03)


def test_the_covariance_is_that_of_repeated_matches():
    """Sixty matches, two coordinates: their scatter is known to 7 %, three of them."""
    exact, errors, variances = pair(), [], []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(0, 1, (2, 70, 70))
        left, right = (g + e for g, e in zip(exact, noise))
        trail, sigma0, Q = program.match(left, right, POINT, START, 21)
        errors.append(trail[-1, [0, 3]] - PLACE)
        variances.append(sigma0**2 * np.diag(Q)[[0, 3]])
    ratio = np.sqrt(np.mean(np.square(errors)) / np.mean(variances))
    assert abs(ratio - 1) < 0.2


def test_the_design_matrix_agrees_with_differences():
    """Tolerance: slopes across two pixels keep 98 % of a wave of twenty pixels."""
    texture = simulate.texture(0.02, seed=2)
    _, right = simulate.texture_pair(texture, (70, 70), [0, 1, 0, 0, 0, 1.0])
    y, x = np.mgrid[-5:6, -5:6].reshape(2, -1)
    p = np.array([30.2, 1.02, 0.1, 34.6, -0.07, 0.97, 4, 0.9])

    def grey(q):
        return q[6] + q[7] * program.resampled(right, q, x, y)[0]

    steps = 1e-4 * np.eye(8)
    J = np.transpose([(grey(p + d) - grey(p - d)) / 2e-4 for d in steps])
    ours = program.design(*program.resampled(right, p, x, y), x, y, p[7])
    assert np.abs(ours - J).max() < 0.02 * np.abs(J).max()


def test_one_step_on_a_slope_is_exact():
    x = np.arange(20.0)
    assert program.row_shift(3 * (x + 0.4), 3 * x) == pytest.approx(0.4)


def test_what_cannot_be_matched_is_refused():
    left, right = pair()
    with pytest.raises(ValueError, match="leaves the left photo"):
        program.match(left, right, (5, 36), START, 21)
    with pytest.raises(ValueError, match="do not determine all 8 unknowns"):
        program.match(np.full((70, 70), 9.0), np.full((70, 70), 9.0), POINT, START, 21)
    with pytest.raises(ValueError, match="flat row fits everywhere"):
        program.row_shift([1.0, 2, 3], [5.0, 5, 5])


def arrived(cutoff, distance, textures=12):
    """Share of starts at a distance (px), in random directions, that end within 0.1 px.

    Windows of 21 pixels, noise of one grey value, no shift: the truth is (40, 40).
    """
    found = []
    for seed in range(textures):
        left, right = simulate.texture_pair(
            simulate.texture(cutoff, seed=seed), (80, 80), (0, 1, 0, 0, 0, 1), sigma=1.0
        )
        turns = np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)
        for x, y in 40 + distance * np.column_stack([np.cos(turns), np.sin(turns)]):
            try:
                trail, _, _ = program.match(
                    left, right, (40, 40), [x, 1, 0, y, 0, 1, 0, 1], 21
                )
            except ValueError:
                found.append(False)
            else:
                found.append(np.hypot(*(trail[-1, [0, 3]] - 40)) < 0.1)
    return np.mean(found)


@pytest.mark.parametrize(
    ("cutoff", "safe", "half_wave"),
    [(0.2, 1.7, 2.5), pytest.param(0.4, 1, 1.25, marks=pytest.mark.slow)],
)
def test_safe_from_near_and_lost_from_half_the_shortest_wave(cutoff, safe, half_wave):
    assert arrived(cutoff, safe) == 1
    assert arrived(cutoff, half_wave) < 0.4
