"""Proofs of the verdicts on Harintaka 2020. What chapter 2 touches: correlation (1)."""

import numpy as np
import pytest

from pgm_lab import ncc

RNG = np.random.default_rng(20)


def printed(g1, g2):
    """(1) as printed: one sum over the products of the squares in the denominator."""
    a, b = g1 - np.mean(g1), g2 - np.mean(g2)
    return np.sum(a * b) / np.sqrt(np.sum(a**2 * b**2))


def test_1_gives_21_for_a_perfect_match_of_a_chessboard():
    chessboard = 100.0 + 50 * (-1.0) ** np.add.outer(np.arange(21), np.arange(21))
    assert printed(chessboard, chessboard) == pytest.approx(21.0, abs=0.01)
    assert ncc.correlation(chessboard, chessboard) == pytest.approx(1.0)


def test_1_gives_the_root_of_n_over_kurtosis_for_a_perfect_match():
    """By Cauchy and Schwarz it lies between -sqrt(n) and sqrt(n), not -1 and 1."""
    for grey in (RNG.normal(size=(21, 21)), RNG.uniform(0, 255, (21, 21))):
        d = grey - grey.mean()
        kurtosis = np.mean(d**4) / np.mean(d**2) ** 2
        expected = np.sqrt(grey.size / kurtosis)
        assert printed(grey, grey) == pytest.approx(expected, rel=1e-12)
        assert expected > 10
    # With the sums apart it is the correlation coefficient
    a, b = RNG.normal(size=(2, 21, 21))
    a, b = a - a.mean(), b - b.mean()
    apart = np.sum(a * b) / np.sqrt(np.sum(a**2) * np.sum(b**2))
    assert apart == pytest.approx(ncc.correlation(a, b), abs=1e-14)


def test_homogeneous_windows_correlate_near_zero_with_noise_and_not_at_all_without():
    noise = 100 + RNG.normal(0, 1, (2, 300, 21, 21))
    r = [ncc.correlation(a, b) for a, b in zip(*noise, strict=True)]
    assert np.abs(r).max() < 0.25
    with pytest.raises(ValueError, match="flat"):  # 0/0
        ncc.correlation(np.full((21, 21), 100), noise[0, 0])
