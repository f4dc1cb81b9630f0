"""The predicted covariance, where one of the images is noisier than the other."""

import numpy as np
import pytest

from pgm_book.ch03.studies import scene as lsm_scene
from pgm_lab import lsm, simulate


@pytest.fixture(scope="module")
def scene():
    """Soft texture of a contrast of 6 grey values: weak beside noise of 2.8."""
    return lsm_scene.scene(lsm_scene.SOFT, 1, contrast=6.0)


def matches(scene, sigma, gain=1.08, **options):
    """Errors (n, 2) of some 1100 points over their predicted standard deviations."""
    images = simulate.texture_pair(
        scene.texture, scene.shape, scene.affine, gain=gain, offset=4
    )
    rng = np.random.default_rng(5)
    left, right = (
        image + rng.normal(0, s, image.shape)
        for image, s in zip(images, sigma, strict=True)
    )
    found = lsm.match(left, right, scene.points, scene.start, threshold=0.2, **options)
    assert found.accepted.mean() > 0.999
    sd = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))
    return ((found.points - scene.truth) / sd)[found.accepted]


@pytest.mark.parametrize("gain", [0.4, 1.08, 2.5])
def test_errors_are_as_predicted_whatever_the_gain(scene, gain):
    """Half of what the derivatives hold is noise: known to the second order, 15 %.

    2200 errors give their root mean square to 1.5 per cent.
    """
    sigma = 2.0 * min(gain, 1)
    z = matches(scene, (sigma, sigma), gain, correlated=False)
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.06, abs=0.09)


def test_noise_of_the_right_image_alone_is_overrated(scene):
    """It is not in the derivatives, which are of the left image."""
    z = matches(scene, (0.0, 2.8))
    assert np.sqrt(np.mean(z**2)) < 0.85
