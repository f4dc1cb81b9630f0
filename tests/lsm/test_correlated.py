"""Noise that neighbouring pixels share, and what it does to the predicted precision."""

import cv2
import numpy as np
import pytest

from pgm_lab import lsm
from pgm_lab.lsm import _correlated
from tools.studies import lsm_scene

SIZES = 11, 21, 31


def matched(
    texture, template, sigma=2.0, *, blur=0.0, contrast=40.0, seed=5, **options
):
    """Result and errors (n, 2) of some 1000 windows; noise under a Gaussian blur."""
    scene = lsm_scene.scene(texture, seed, contrast=contrast, room=20)
    left, right = scene.images(0.0 if blur else sigma, seed=seed)
    if blur:
        rng = np.random.default_rng(seed)
        left, right = (
            image + shared_noise(image.shape, sigma, blur, rng)
            for image in (left, right)
        )
    found = lsm.match(left, right, scene.points, scene.start, template, **options)
    assert found.accepted.all() and len(found.points) > 1000
    return found, found.points - scene.truth


def shared_noise(shape, sigma, blur, rng):
    """Normal noise of `sigma` whose correlation is exp(-d^2 / (4 blur^2))."""
    noise = cv2.GaussianBlur(rng.normal(size=shape), (0, 0), blur)
    return sigma * noise / noise.std()


def over_predicted(found, error):
    """Root mean square of errors over their predicted standard deviations."""
    return np.sqrt(np.mean(lsm_scene.squared(error, found.covariance)))


@pytest.mark.parametrize("template", SIZES)
@pytest.mark.parametrize(
    ("texture", "sigma", "contrast"),
    [
        (lsm_scene.SOFT, 1.0, 40.0),
        (lsm_scene.SOFT, 5.0, 40.0),
        (lsm_scene.SOFT, 2.0, 10.0),
        (lsm_scene.SHARP, 1.0, 40.0),
        (lsm_scene.SHARP, 5.0, 40.0),
    ],
)
def test_white_noise_is_left_alone(texture, sigma, contrast, template):
    """The mean prediction of 1000 windows and the errors over it, to 2 per cent."""
    found, error = matched(texture, template, sigma, contrast=contrast)
    plain, _ = matched(texture, template, sigma, contrast=contrast, correlated=False)
    ratio = np.sqrt(found.covariance[:, 0, 0] / plain.covariance[:, 0, 0])
    assert ratio.mean() == pytest.approx(1, abs=0.02)
    assert over_predicted(found, error) / over_predicted(plain, error) == (
        pytest.approx(1, abs=0.02)
    )
    np.testing.assert_array_equal(plain.effective_pixels, template**2)
    np.testing.assert_array_equal(plain.sigma0, found.sigma0)


@pytest.mark.parametrize("template", SIZES)
@pytest.mark.parametrize("blur", [0.6, 1.0])
def test_errors_are_as_predicted_where_neighbours_share_their_noise(blur, template):
    """White noise was said to give 0.6 to 0.45 of the errors that there are.

    Windows of 11 pixels hold hardly more than the adjustment takes: 15 per cent.
    """
    found, error = matched(lsm_scene.SOFT, template, blur=blur)
    assert over_predicted(found, error) == pytest.approx(
        1, abs=0.15 if template == 11 else 0.1
    )
    plain, _ = matched(lsm_scene.SOFT, template, blur=blur, correlated=False)
    assert over_predicted(plain, error) > 1.5
    assert np.median(found.effective_pixels) < template**2 / 2
    # Sharp texture: the noise is blurred, and its frequencies are not
    found, error = matched(lsm_scene.SHARP, template, blur=blur)
    assert 0.75 < over_predicted(found, error) < 1.05
