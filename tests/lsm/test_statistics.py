"""The predicted covariance of least squares matching is the sampled one.

Pooled over thousands of windows that do not overlap. The bands are those of the chi
square distribution that a right covariance leaves once in a million.
"""

import numpy as np
import pytest
from scipy import stats

from pgm_book.ch03.studies import scene as lsm_scene
from pgm_lab import lsm, simulate

FALSE_ALARM = 1e-6


@pytest.fixture(
    scope="module",
    params=[pytest.param(1.0, marks=pytest.mark.slow), 2.0],
    ids="sigma {}".format,
)
def sample(request):
    """Sigma, errors (n, 2) of matches, their covariance (n, 2, 2), sigma0, redundancy.

    5600 points in five soft textures; start values are rounded to whole pixels.
    """
    parts = []
    for seed in range(5):
        scene = lsm_scene.scene(lsm_scene.SOFT, seed)
        left, right = scene.images(request.param, seed=seed)
        found = lsm.match(left, right, scene.points, scene.start)
        assert np.all(found.accepted)
        parts.append((found.points - scene.truth, found.covariance, found.sigma0))
    return request.param, *map(np.concatenate, zip(*parts)), found.redundancy


@pytest.mark.slow
def test_errors_are_as_large_as_the_covariance_says(sample):
    """Both coordinates with their correlation: the sum of e' C^-1 e.

    sigma0 is estimated from 433 redundant grey values, so that e' C^-1 e / 2 is from
    Fisher's distribution; its mean is 433 / 431.
    """
    _, error, C, _, redundancy = sample
    z2 = np.einsum("ni,nij,nj->n", error, np.linalg.inv(C), error)
    low, high = stats.chi2.ppf([FALSE_ALARM / 2, 1 - FALSE_ALARM / 2], error.size)
    # Standard deviations wrong by 5 per cent leave this band 99 times in 100
    assert stats.chi2.cdf(high / 1.05**2, error.size) < 0.01
    assert low < z2.sum() * (redundancy - 2) / redundancy < high


def test_sigma0_is_the_noise_of_a_grey_value_difference(sample):
    """sigma sqrt(1 + 1 / gain^2), freed from the smoothing by interpolation.

    Interpolation correlates neighbouring residuals, so that the scatter of sigma0 from
    point to point is measured, not taken from chi square. To one per cent: what the
    noise in the gradients adds to vᵀv is of that order.
    """
    sigma, _, _, sigma0, _ = sample
    variance = sigma0**2 / (sigma**2 * (1 + 1.08**-2))
    uncertainty = variance.std() / np.sqrt(len(variance))
    assert uncertainty < 0.002
    assert abs(np.sqrt(variance.mean()) - 1) < 0.01


def test_with_poor_contrast_the_noise_in_the_gradients_counts():
    """At a contrast of 10 and sigma 2 a tenth of the design matrix is noise.

    Without the allowance for it, e' C^-1 e would be 2.4 on the average. It is taken to
    the second order, which is good to five per cent there.
    """
    texture = simulate.texture(contrast=10.0, seed=6)
    affine = (3.3, 1.015, 0.01, -2.2, -0.012, 0.99)
    left, right = simulate.texture_pair(texture, (800, 800), affine, gain=1.08, sigma=2)
    at = np.arange(30, 770, 22.0)
    points = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
    truth = points @ np.reshape(affine, (2, 3))[:, 1:].T + (affine[0], affine[3])
    found = lsm.match(left, right, points, np.rint(truth))
    assert found.accepted.mean() > 0.995
    good = found.accepted
    error = (found.points - truth)[good]
    z2 = np.einsum("ni,nij,nj->n", error, np.linalg.inv(found.covariance[good]), error)
    # Five standard deviations of the mean of so many chi squares with two degrees
    assert abs(z2.mean() - 2) < 0.1 + 5 * 2 / np.sqrt(len(z2))
