"""Precision of `ncc.match` where one image is noisier, by Monte Carlo."""

from functools import cache

import numpy as np
import pytest

from pgm_lab import ncc, simulate

POINTS = np.stack(np.meshgrid(*2 * [np.arange(30, 270, 24)]), -1).reshape(-1, 2)


@cache
def seen_twice(cutoff, seed, column, row):
    return simulate.texture_pair(
        simulate.texture(cutoff, seed=seed), (300, 300), (column, 1, 0, row, 0, 1)
    )


def pair(cutoff, contrast, noise, gain, seed, shift):
    """A texture of this contrast, moved, in the right image with a gain, and noise."""
    rng = np.random.default_rng(seed)
    images = seen_twice(cutoff, seed, *shift)
    scale = contrast / images[0].std()
    return tuple(
        factor * scale * grey + rng.normal(0, sigma, grey.shape)
        for grey, factor, sigma in zip(images, (1, gain), noise, strict=True)
    )


def ratio(cutoff, contrast, noise, gain=1.0, times=5):
    """RMS error over what is predicted."""
    errors, predicted = [], []
    rng = np.random.default_rng(1)
    for seed in range(times):
        shift = rng.uniform(-0.5, 0.5, 2)
        images = pair(cutoff, contrast, noise, gain, seed, shift)
        found = ncc.match(*images, POINTS, None, 21, 31, 0.3, 1, "parabola")
        good = found.accepted
        assert good.mean() > 0.9
        errors.append((found.points - POINTS - shift)[good])
        predicted.append(np.diagonal(found.covariance, axis1=1, axis2=2)[good])
    return np.sqrt(
        np.mean(np.square(np.concatenate(errors))) / np.mean(np.concatenate(predicted))
    )


@pytest.mark.parametrize(
    ("cutoff", "contrast"), [(0.1, 10), (0.1, 30), (0.2, 10), (0.2, 30)]
)
@pytest.mark.parametrize("gain", [0.4, 1, 2.5])
def test_the_error_is_as_predicted_whatever_the_gain(cutoff, contrast, gain):
    """To 15 per cent; where the noise of both is as large as the texture itself, by
    which its peaks are no longer those of the texture, up to 1.6 times."""
    noise = 8 * min(gain, 1)
    much = cutoff == 0.1 and contrast == 10 and gain >= 1
    assert (
        0.85 < ratio(cutoff, contrast, (noise, noise), gain) < (1.6 if much else 1.15)
    )


def test_weak_texture_and_noise_on_the_left_alone():
    """Taken for the noise of both, it is predicted more than twice as large: the
    gradients of the left window are those of its noise."""
    assert ratio(0.1, 10, (8, 0)) < 0.6


def test_shares_of_noise_make_the_correlation():
    """(1 - p)(1 - q) = r^2, p : q as one to the variances, none above 1."""
    rng = np.random.default_rng(1)
    left, right = rng.uniform(1, 1e4, (2, 50))
    r = rng.uniform(0.2, 1, 50)
    p, q = ncc._peak._shares(left, right, r)
    np.testing.assert_allclose((1 - p) * (1 - q), r**2, rtol=1e-9)
    np.testing.assert_allclose(p * left, q * right)
    assert np.all((p >= 0) & (q >= 0) & (p < 1) & (q < 1))
