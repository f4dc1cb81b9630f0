"""Proofs of the verdicts on Harintaka 2020. What chapter 2 touches: correlation (1)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx
from scipy import stats

from pgm_lab import image, ncc

RNG = np.random.default_rng(20)


def printed(g1, g2):
    """(1) as printed: one sum over the products of the squares in the denominator."""
    a, b = g1 - np.mean(g1), g2 - np.mean(g2)
    return np.sum(a * b) / np.sqrt(np.sum(a**2 * b**2))


def test_1_gives_the_root_of_n_over_kurtosis_for_a_perfect_match():
    """21 for a chessboard of 21 x 21, the most that 441 pixels can give."""
    chessboard = 100.0 + 50 * (-1.0) ** np.add.outer(np.arange(21), np.arange(21))
    assert printed(chessboard, chessboard) == approx(21.0, abs=0.01)
    assert ncc.correlation(chessboard, chessboard) == approx(1.0)
    for grey in (RNG.normal(size=(21, 21)), RNG.uniform(0, 255, (21, 21))):
        d = grey - grey.mean()
        kurtosis = np.mean(d**4) / np.mean(d**2) ** 2
        expected = np.sqrt(grey.size / kurtosis)
        assert printed(grey, grey) == approx(expected, rel=1e-12)
        assert expected > 10
    # With the sums apart it is the correlation coefficient
    a, b = RNG.normal(size=(2, 21, 21))
    a, b = a - a.mean(), b - b.mean()
    apart = np.sum(a * b) / np.sqrt(np.sum(a**2) * np.sum(b**2))
    assert apart == approx(ncc.correlation(a, b), abs=1e-14)


def test_rho_of_the_right_formula_lies_between_minus_1_and_1():
    """Cauchy and Schwarz; windows of 3 x 3 to 21 x 21, some with few bright pixels."""
    r, misprinted = [], []
    for size in (3, 7, 21):
        windows = RNG.lognormal(0, 2, (300, 2, size, size))
        r += [ncc.correlation(a, b) for a, b in windows]
        r += [ncc.correlation(a, -(a**3)) for a, _ in windows]
        misprinted += [abs(printed(a, a)) / size for a, _ in windows]
    assert -1 <= min(r) < -0.9 and 0.9 < max(r) <= 1
    assert max(misprinted) <= 1  # the bound of (1) as printed: the root of n = size^2


def test_rho_is_1_and_minus_1_for_lines_and_0_also_for_a_ramp_and_itself_turned():
    g1, g2 = RNG.uniform(0, 255, (2, 21, 21))
    assert ncc.correlation(g1, 0.5 * g1 + 20) == approx(1, abs=1e-14)
    assert ncc.correlation(g1, 255 - g1) == approx(-1, abs=1e-14)
    # Unrelated: 0 on average, standard deviation 1 / sqrt(440)
    r = [ncc.correlation(*pair) for pair in RNG.uniform(0, 255, (500, 2, 21, 21))]
    assert np.mean(r) == approx(0, abs=0.01)
    assert np.std(r) == approx(0.048, abs=0.005)
    # 0 is no proof of a wrong place: a ramp and the same ramp turned by 90 degrees
    ramp = np.add.outer(np.zeros(21), np.arange(21.0))
    assert ncc.correlation(ramp, np.rot90(ramp)) == approx(0, abs=1e-14)


def test_08_is_passed_by_chance_in_windows_of_3_by_3_and_not_of_7_by_7():
    """Student's t with n - 2 degrees of freedom; windows as named in the text."""
    chance = {}
    for size in (3, 5, 7):
        n = size**2
        chance[size] = stats.t.sf(0.8 * np.sqrt((n - 2) / (1 - 0.8**2)), n - 2)
    assert chance[3] == approx(1 / 210, rel=0.05)
    assert chance[5] == approx(8e-7, rel=0.1) and chance[7] < 1e-11
    pairs = RNG.normal(size=(2, 200_000, 9))
    a, b = pairs - pairs.mean(axis=2, keepdims=True)
    r = (a * b).sum(axis=1) / np.sqrt((a**2).sum(axis=1) * (b**2).sum(axis=1))
    assert np.mean(r > 0.8) == approx(chance[3], rel=0.15)
    # Of a right match with equal noise in both photos: up to half the contrast
    signal, *noise = RNG.normal(size=(3, 1_000_000))
    noisy = [signal + 0.5 * one for one in noise]
    assert ncc.correlation(*noisy) == approx(0.8, abs=0.002)


def test_homogeneous_windows_correlate_near_zero_with_noise_and_not_at_all_without():
    noise = 100 + RNG.normal(0, 1, (300, 2, 21, 21))
    r = [ncc.correlation(*pair) for pair in noise]
    assert np.abs(np.mean(r)) < 0.01
    assert np.std(r) == approx(440**-0.5, rel=0.15)
    with pytest.raises(ValueError, match="flat"):  # 0/0
        ncc.correlation(np.full((21, 21), 100), noise[0, 0])


def test_at_the_sixth_of_levels_halved_each_time_a_pixel_is_32_wide():
    """Level 1 is the image: five halvings. A ramp tells where each pixel comes from."""
    column = np.tile(np.arange(1025.0), (1025, 1))
    levels = image.pyramid(column, 6)
    assert [len(level) for level in levels] == [1025, 513, 257, 129, 65, 33]
    middle = levels[5][:, 8:-8]  # away from the border, where smoothing bends the ramp
    close(np.diff(middle, axis=1), 32, rtol=1e-9)
