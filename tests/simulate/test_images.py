"""Simulated targets: their truth by an independent integration, and their noise."""

import numpy as np
import pytest
from scipy import integrate, special

from pgm_lab import simulate


@pytest.mark.parametrize("pixel", [(10, 10), (13, 10), (12, 7)])
def test_grey_value_is_the_integral_over_the_pixel(pixel):
    centre, diameter, blur = (10.3, 9.6), 7.0, 0.7

    def profile(y, x):
        radius = np.hypot(x - centre[0], y - centre[1])
        return 0.5 * special.erfc((radius - diameter / 2) / (np.sqrt(2) * blur))

    column, row = pixel
    area, _ = integrate.dblquad(
        profile, column - 0.5, column + 0.5, row - 0.5, row + 0.5, epsabs=1e-9
    )
    stack = simulate.target([[centre]] * 3, diameter, (19, 17), blur=blur)
    assert stack.shape == (3, 1, 19, 17)
    found = stack[2, 0, row, column]
    assert found == pytest.approx(40 + 160 * area, abs=1e-3)


def test_noise_has_the_wanted_size_and_repeats_with_its_seed():
    flat = np.full((200, 200), 100.0)
    noisy = simulate.photograph(flat, noise=3.0, seed=1)
    # 40,000 values give the standard deviation to 0.35 per cent; four of them
    assert noisy.std() == pytest.approx(3.0, rel=0.014)
    np.testing.assert_array_equal(noisy, simulate.photograph(flat, 3.0, seed=1))
    assert np.any(noisy != simulate.photograph(flat, 3.0, seed=2))


def test_eight_bits_are_whole_numbers_from_0_to_255():
    wide = np.linspace(-50, 300, 1000)
    coded = simulate.photograph(wide, noise=1.0, seed=1, bits=8)
    np.testing.assert_array_equal(coded, np.round(coded))
    assert coded.min() == 0 and coded.max() == 255


def test_an_edge_too_sharp_for_the_quadrature_is_refused():
    with pytest.raises(ValueError, match="blur must be at least 0.3"):
        simulate.target((1, 2), blur=0.1)
