"""Proofs of the verdicts on Brahmantara 2015. What chapter 2 touches: (1)."""

from fractions import Fraction

import numpy as np
import pytest

from pgm_lab import ncc


def test_1_is_the_correlation_coefficient_and_2_6f_of_bani():
    """N^2 times the sums about the means, above and below: exact in whole numbers."""
    X, Y = np.random.default_rng(15).integers(0, 256, (2, 21 * 21)).tolist()
    N = len(X)

    def s(p, q):
        return sum(x * y for x, y in zip(p, q, strict=True))

    covariance = N * s(X, Y) - sum(X) * sum(Y)
    variances = [N * s(g, g) - sum(g) ** 2 for g in (X, Y)]

    def about_means(p, q):
        mp, mq = Fraction(sum(p), N), Fraction(sum(q), N)
        return N * sum((x - mp) * (y - mq) for x, y in zip(p, q, strict=True))

    assert covariance == about_means(X, Y)
    assert variances == [about_means(X, X), about_means(Y, Y)]
    r = covariance / (variances[0] * variances[1]) ** 0.5
    assert ncc.correlation(X, Y) == pytest.approx(r, abs=1e-14)


def test_441_grey_values_in_a_chip_of_21_by_21_and_nine_positions_for_radius_one():
    assert 21 * 21 == 441
    chip = np.random.default_rng(1).normal(size=(23, 23))
    assert ncc.correlation_map(chip[1:22, 1:22], chip).size == 9
