"""Proofs of the verdicts on Bani 2010: grey values, gradients and resampling.

(2.1), (2.12), (2.13), II.1.1.4.2, III.3 steps 4 and 7, and the appendix's listing.
"""

from itertools import product

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_book.common import ledger
from pgm_lab import image, simulate

TEXTURE = simulate.texture(0.2, seed=1)
POINTS = np.random.default_rng(3).uniform((0, 0), (138.99, 118.99), (20_000, 2))


def texture_image(dtype=None, contrast=40.0):
    texture = simulate.texture(0.2, contrast=contrast, seed=1)
    same = (0, 1, 0, 0, 0, 1)
    return simulate.texture_pair(texture, (120, 140), same, dtype=dtype)[0]


# Statistics and histogram


def test_2_1_is_the_mean_and_the_standard_deviation_that_is_right_on_average():
    windows = np.random.default_rng(1).normal(100, 5, (4000, 3, 3))
    found = [image.statistics(window) for window in windows]
    variance = np.mean([s.sd**2 for s in found])
    # 4000 variances with 8 degrees of freedom: standard deviation 25 sqrt(2 / 32000)
    assert variance == approx(25.0, abs=4 * 0.2)
    assert abs(variance * 8 / 9 - 25) > 4 * 0.2  # with RC below it is too small
    g = windows[0].ravel()
    g_m = sum(g) / 9
    sigma = np.sqrt(sum((g - g_m) ** 2) / 8)
    assert (found[0].mean, found[0].sd) == approx((g_m, sigma), rel=1e-12)


def test_equalisation_gives_both_photos_one_brightness_and_contrast_but_not_a_patch():
    left = texture_image(np.uint8)
    # The same scene taken darker and flatter, monotone but not linear
    right = np.round(150 * (left / 255.0) ** 1.5 + 20).astype(np.uint8)
    before = [image.statistics(g) for g in (left, right)]
    after = [image.statistics(image.equalize(g)) for g in (left, right)]
    assert before[0].mean - before[1].mean > 40 and before[0].sd - before[1].sd > 5
    # Evenly from 0 to 255: mean 127.5, standard deviation 256 / sqrt(12)
    for s in after:
        assert s.mean == approx(127.5, abs=1.5)
        assert s.sd == approx(73.9, abs=1)
    # The right photo shows the same patch, and a bright wall beside it
    wall = np.full((120, 70), 240, dtype=np.uint8)
    shifted = np.hstack([right[:, 70:], wall])
    patch = image.equalize(left)[50:71, 90:111], image.equalize(shifted)[50:71, 20:41]
    means = [image.statistics(g).mean for g in patch]
    sds = [image.statistics(g).sd for g in patch]
    assert abs(means[0] - means[1]) > 30
    assert sds[0] / sds[1] > 1.5


def test_8_bits_are_256_grey_values_and_rounding_to_them_adds_029():
    printed = ledger.verdicts("2", ["II.1.1.1"])[0]["printed"]
    assert printed.startswith(
        f"{len(set(product((0, 1), repeat=8)))} grey values, 8 bit"
    )
    smooth = texture_image()
    error = (texture_image(np.uint8) - smooth)[(smooth > 0) & (smooth < 255)]
    assert error.std() == approx(1 / np.sqrt(12), rel=0.02)
    assert np.abs(error).max() <= 0.5
    # 12 bits over the same range: a sixteenth
    fine = np.round(smooth * 4095 / 255) * 255 / 4095
    assert (fine - smooth).std() == approx(1 / np.sqrt(12) / 16, rel=0.02)


# Gradients


def test_2_12_and_2_13_are_the_slope_through_three_pixels():
    """Exact for a parabola, a known share of a wave; (3.2), (3.3) are the same."""
    rows, columns = np.indices((9, 11)).astype(float)
    gx, gy = image.gradient(2 * columns**2 - 3 * columns + rows**2 + columns * rows)
    inner = np.s_[1:-1, 1:-1]
    close(gx[inner], (4 * columns - 3 + rows)[inner], atol=1e-12)
    close(gy[inner], (2 * rows + columns)[inner], atol=1e-12)
    for f, share in ((0.05, 0.984), (0.2, 0.757), (0.4, 0.234)):
        gx, _ = image.gradient(np.tile(np.sin(2 * np.pi * f * np.arange(101)), (3, 1)))
        assert gx[1, 50] / (2 * np.pi * f * np.cos(2 * np.pi * f * 50)) == (
            approx(share, abs=5e-4)
        )


def test_whole_number_gradients_of_the_listing_are_cut_towards_zero():
    """Differences of whole grey values, halved as whole numbers: cut towards zero."""
    for contrast, shrunk in ((40.0, 0.014), (5.0, 0.11)):
        g = texture_image(np.uint8, contrast=contrast)
        right = image.gradient(g)[0][:, 1:-1]
        difference = g[:, 2:].astype(int) - g[:, :-2]
        whole = np.trunc(difference / 2)
        odd = difference % 2 == 1
        assert odd.mean() == approx(0.5, abs=0.02)
        equal(np.abs(right) - np.abs(whole), odd / 2)
        found = 1 - np.abs(whole).sum() / np.abs(right).sum()
        assert found == approx(shrunk, rel=0.1)


# Resampling


def test_nearest_neighbour_is_the_value_of_the_nearest_pixel():
    g, points = texture_image(), POINTS[:300]
    rows, columns = np.indices(g.shape)
    squared = (columns - points[:, 0, None, None]) ** 2
    squared += (rows - points[:, 1, None, None]) ** 2
    nearest = squared.reshape(300, -1).argmin(axis=1)
    equal(image.resample(g, points, "nearest"), g.ravel()[nearest])


def four_pixels(g, points):
    """Grey values of the four around each point, its distance from the first."""
    x, y = np.floor(points).astype(int).T
    return g[y, x], g[y, x + 1], g[y + 1, x], g[y + 1, x + 1], *(points % 1).T


def test_bilinear_value_is_the_weighted_mean_of_four_pixels_and_not_their_mean():
    g = texture_image()
    g0, g1, g2, g3, dx, dy = four_pixels(g, POINTS)
    plain = (g0 + g1 + g2 + g3) / 4
    weighted = (1 - dy) * ((1 - dx) * g0 + dx * g1) + dy * ((1 - dx) * g2 + dx * g3)
    close(image.resample(g, POINTS, "bilinear"), weighted, rtol=0, atol=1e-10)
    # The plain mean is right in the middle of the four only
    middle = np.floor(POINTS[:200]) + 0.5
    close(image.resample(g, middle, "bilinear"), plain[:200], rtol=0, atol=1e-10)
    truth = simulate.grey_values(TEXTURE, POINTS)
    assert np.std(weighted - truth) < 3.5 and np.std(plain - truth) > 10


def test_cubic_convolution_takes_sixteen_pixels():
    unit = np.eye(144).reshape(144, 12, 12)
    for point in ((5.3, 6.8), (4.01, 7.5)):
        weights = [image.resample(g, point, "cubic") for g in unit]
        rows, columns = np.nonzero(np.reshape(weights, (12, 12)))
        assert len(rows) == 16
        assert np.all(np.abs(columns - point[0]) < 2)
        assert np.all(np.abs(rows - point[1]) < 2)


def polynomial(g, points):
    """Bilinear polynomial of four pixels, in our words, beside the two listings."""
    g0, g1, g2, g3, dx, dy = four_pixels(g, points)
    return g0 + (g1 - g0) * dx + (g2 - g0) * dy + (g3 + g0 - g1 - g2) * dx * dy


def test_polynomial_of_the_listing_is_the_bilinear_one():
    g = texture_image(np.uint8).astype(float)
    found = image.resample(g, POINTS, "bilinear")
    close(polynomial(g, POINTS), found, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("offset", "mean"), [(0.0, -0.5), (0.5, 0.0)])
def test_listing_of_chapter_iii_cuts_half_a_grey_value_off_and_the_appendix_rounds(
    offset, mean
):
    value = polynomial(texture_image(np.uint8).astype(float), POINTS)
    error = np.trunc(value + offset) - value
    # Errors are even over one grey value: 1 / sqrt(12) = 0.289; 20,000 of them give
    # the mean to 0.002
    assert np.mean(error) == approx(mean, abs=0.01)
    assert np.std(error) == approx(0.289, abs=0.005)
