"""Texture between the pixels, and pairs made of it, against their definitions.

What this does not prove: that real surfaces look like a sum of waves.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pgm_lab import simulate

PLACE = st.floats(-200.0, 200.0)
SMALL = st.floats(-0.3, 0.3)


@given(PLACE, PLACE, st.sampled_from([0.05, 0.2, 0.4]))
def test_grey_value_and_gradient_are_the_sum_written_out_wave_by_wave(x, y, cutoff):
    """The gradient by a complex step, of the order of 40 grey values a pixel."""
    texture = simulate.texture(cutoff, mean=90.0, seed=7)

    def value(x, y):
        waves = zip(texture.frequencies, texture.amplitudes, texture.phases)
        return 90.0 + sum(
            a * np.cos(2 * np.pi * (fx * x + fy * y) + phi)
            for (fx, fy), a, phi in waves
        )

    h = 1e-30
    derivative = value(x + 1j * h, y).imag / h, value(x, y + 1j * h).imag / h
    tight = {"rtol": 0, "atol": 1e-9}
    grey = simulate.grey_values(texture, (x, y))
    np.testing.assert_allclose(grey, value(x, y), **tight)
    found = simulate.grey_gradients(texture, (x, y))
    np.testing.assert_allclose(found, derivative, **tight)


def test_many_points_give_what_each_gives_alone():
    """The pieces in which they are computed do not show."""
    texture = simulate.texture(seed=5)
    points = np.random.default_rng(2).uniform(0, 100, (3, 1500, 2))
    values = simulate.grey_values(texture, points)
    gradients = simulate.grey_gradients(texture, points)
    assert values.shape == (3, 1500) and gradients.shape == points.shape
    for i in ((0, 0), (1, 700), (2, 1499)):
        one = simulate.grey_values(texture, points[i])
        np.testing.assert_allclose(values[i], one, rtol=0, atol=1e-10)
        one = simulate.grey_gradients(texture, points[i])
        np.testing.assert_allclose(gradients[i], one, rtol=0, atol=1e-10)
    assert simulate.grey_values(texture, np.empty((0, 2))).shape == (0,)


@pytest.mark.parametrize("cutoff", [0.2, 0.4])
def test_mean_and_standard_deviation_over_the_plane_are_as_asked(cutoff):
    texture = simulate.texture(cutoff, contrast=25.0, mean=80.0, seed=11)
    points = np.random.default_rng(0).uniform(-1e5, 1e5, (20_000, 2))
    values = simulate.grey_values(texture, points)
    # 20,000 independent points give a standard deviation to 0.5 per cent: four of them
    assert values.std() == pytest.approx(25.0, rel=0.02)
    assert values.mean() == pytest.approx(80.0, abs=4 * 25 / np.sqrt(20_000))


def test_frequencies_fill_the_disc_evenly():
    radius = np.linalg.norm(
        simulate.texture(0.3, waves=20_000).frequencies / 0.3, axis=1
    )
    assert radius.max() <= 1
    # A quarter of the area lies within half the radius: binomial, four deviations
    assert np.mean(radius < 0.5) == pytest.approx(0.25, abs=4 * 0.0031)


@given(PLACE, SMALL, SMALL, PLACE, SMALL, SMALL)
def test_a_pair_holds_the_grey_values_at_warped_coordinates(t, a, b, u, c, d):
    affine = (t, 1 + a, b, u, c, 1 + d)
    texture = simulate.texture(0.4, waves=30, seed=9)
    left, right = simulate.texture_pair(
        texture, (12, 17), affine, gain=1.08, offset=4.0
    )
    rows, columns = np.indices((12, 17))
    pixels = np.stack([columns, rows], axis=-1)
    J = np.array(affine).reshape(2, 3)[:, 1:]
    back = (pixels - (t, u)) @ np.linalg.inv(J).T
    tight = {"rtol": 0, "atol": 1e-9}
    np.testing.assert_allclose(left, simulate.grey_values(texture, pixels), **tight)
    expected = 1.08 * simulate.grey_values(texture, back) + 4
    np.testing.assert_allclose(right, expected, **tight)


def test_noise_of_both_images_has_the_wanted_size_and_is_independent():
    texture = simulate.texture(seed=1)
    same = (0, 1, 0, 0, 0, 1)
    clean = simulate.texture_pair(texture, (200, 200), same)
    noisy = simulate.texture_pair(texture, (200, 200), same, sigma=3.0, seed=5)
    errors = [(b - a).ravel() for a, b in zip(clean, noisy)]
    for error in errors:
        # 40,000 values give the standard deviation to 0.35 per cent; four of them
        assert error.std() == pytest.approx(3.0, rel=0.014)
    assert abs(np.corrcoef(errors)[0, 1]) < 4 / 200


@pytest.mark.parametrize(
    ("dtype", "highest", "gain"), [(np.uint8, 255, 1.0), (np.uint16, 65535, 257.0)]
)
def test_whole_grey_values_are_rounded_and_clipped(dtype, highest, gain):
    texture = simulate.texture(contrast=90.0, seed=6)
    affine = (0.3, 1.02, 0, 0, 0, 1)
    exact = simulate.texture_pair(texture, (80, 80), affine, gain=gain)
    coded = simulate.texture_pair(texture, (80, 80), affine, gain=gain, dtype=dtype)
    for a, b in zip(exact, coded):
        assert b.dtype == dtype
        np.testing.assert_array_equal(b, np.clip(np.round(a), 0, highest))
    assert exact[1].min() < 0 and exact[1].max() > highest  # else nothing was clipped
    assert simulate.texture_pair(texture, (3, 3), affine)[0].dtype == float


@pytest.mark.parametrize("factor", [2, 4])
@pytest.mark.parametrize("shift", [(0, 0), (3, 1), (-5, 2), (1, -6)])
def test_shrunk_pixels_are_the_means_of_their_squares(shift, factor):
    image = np.random.default_rng(0).integers(0, 65536, (41, 54)).astype(np.uint16)
    before = image.copy()
    left, right = simulate.shrunk_pair(image, shift, factor)
    np.testing.assert_array_equal(image, before)
    dx, dy = shift
    assert left.shape == right.shape
    assert left.shape == ((41 - abs(dy)) // factor, (54 - abs(dx)) // factor)
    x, y = max(dx, 0), max(dy, 0)
    for r, c in ((0, 0), (2, 3), tuple(np.array(left.shape) - 1)):
        r0, c0 = y + r * factor, x + c * factor
        square = image[r0 : r0 + factor, c0 : c0 + factor].astype(float)
        assert left[r, c] == square.mean()
        square = image[r0 - dy :, c0 - dx :][:factor, :factor].astype(float)
        assert square.shape == (factor, factor)
        assert right[r, c] == square.mean()
