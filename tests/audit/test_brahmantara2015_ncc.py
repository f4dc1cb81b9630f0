"""Proofs of the verdicts on Brahmantara 2015. What chapter 2 touches: (1)."""

import re
from fractions import Fraction

import numpy as np
from pytest import approx

from pgm_lab import ncc, simulate

from . import as_printed


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
    assert ncc.correlation(X, Y) == approx(r, abs=1e-14)


def test_441_grey_values_in_a_chip_of_21_by_21_and_nine_positions_for_radius_one():
    said = as_printed.brahmantara_2015()["Metode, below (1)"]
    columns, rows, count = map(int, re.findall(r"\d+", said))
    assert columns * rows == count == 441
    chip = np.random.default_rng(1).normal(size=(23, 23))
    assert ncc.correlation_map(chip[1:22, 1:22], chip).size == 9


def spreads(chip):
    """Standard deviations of 49 correlations for radius 3: Pearson's, and products over
    norms with the means left in."""
    reference = chip[3:24, 3:24]
    windows = np.lib.stride_tricks.sliding_window_view(chip, (21, 21))
    norms = np.sqrt((windows**2).sum(axis=(2, 3)) * (reference**2).sum())
    with_means = (windows * reference).sum(axis=(2, 3)) / norms
    assert with_means.shape == (7, 7) and with_means.max() == approx(1)
    return ncc.correlation_map(reference, chip).std(), with_means.std()


def test_pearson_spreads_more_than_correlation_without_the_means_taken_off():
    """The mean of 120 in every product makes all places look alike."""
    points = np.stack(np.meshgrid(np.arange(27.0), np.arange(27.0)), axis=-1)
    ratios = []
    for seed in range(15, 19):
        texture = simulate.texture(0.2, contrast=40, mean=120, seed=seed)
        chip = simulate.grey_values(texture, points)
        pearson, with_means = spreads(chip)
        ratios.append(pearson / with_means)
        # Without a mean brightness there is no difference to speak of
        assert np.divide(*spreads(chip - chip.mean())) == approx(1, abs=0.2)
    assert min(ratios) == approx(8.4, abs=0.1)
    assert max(ratios) == approx(12.0, abs=0.1)
