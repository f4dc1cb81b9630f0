"""Two ortho images with a known shift: the truth by other means than averaging."""

import numpy as np
import pytest
from scipy import signal

from pgm_lab import datasets, simulate


def periodic(side, seed):
    """Scene that continues at its edges, of waves up to the finest that it can hold."""
    rng = np.random.default_rng(seed)
    return 5000 + 1000 * rng.normal(size=(side, side))


def fourier_shifted(image, shift):
    """The image moved by a part of a pixel: each of its waves turned by its phase."""
    fy, fx = np.meshgrid(*map(np.fft.fftfreq, image.shape), indexing="ij")
    turn = np.exp(-2j * np.pi * (fx * shift[0] + fy * shift[1]))
    return np.fft.ifft2(np.fft.fft2(image) * turn).real


def filtered(image, keep):
    """The image with only the waves (cycles per pixel) that `keep` keeps."""
    fy, fx = np.meshgrid(*map(np.fft.fftfreq, image.shape), indexing="ij")
    return np.fft.ifft2(np.fft.fft2(image) * keep(fx, fy)).real


@pytest.mark.parametrize(("shift", "factor"), [((1, 0), 2), ((1, -2), 3), ((-3, 5), 4)])
def test_band_limited_scene_moves_as_its_waves_turn(shift, factor):
    """The truth without any averaging: by the shift theorem of Fourier.

    The scene is periodic and has no wave that the small pixels cannot hold; three
    periods of it, so that the middle one is cut out where nothing is missing.
    """
    side = 24 * factor
    scene = filtered(
        periodic(side, 1),
        lambda fx, fy: np.maximum(abs(fx), abs(fy)) < 0.49 / factor,
    )
    pair = simulate.ortho_pair(np.tile(scene, (3, 3)), shift, factor)
    np.testing.assert_array_equal(pair.shift, np.array(shift) / factor)
    period = pair.reference[:24, :24]
    np.testing.assert_allclose(
        pair.sensed[:24, :24], fourier_shifted(period, pair.shift), rtol=0, atol=1e-7
    )


def test_whole_pixels_are_exactly_the_same_ground():
    scene = datasets.landsat().grey[:400, :400]
    pair = simulate.ortho_pair(scene, (12, -8), 4, blur=0.7)
    np.testing.assert_array_equal(pair.shift, [3, -2])
    # Mirrored edges of the scene reach 6 x 0.7 pixels into the images
    inside = pair.sensed[5:-7, 8:-5]
    np.testing.assert_array_equal(inside, pair.reference[7:-5, 5:-8])


def test_blur_takes_the_alias_out_of_a_real_scene():
    """Sensed against the reference moved by Fourier: what is left is alias.

    A window that is flat in the middle lets the images end softly.
    """
    scene = datasets.landsat().grey
    soft = signal.windows.tukey(290, 0.5)
    middle = slice(100, 190)
    left = {}
    for blur in (0.0, 0.5, 0.7, 1.0):
        pair = simulate.ortho_pair(scene, (2, 1), 4, blur=blur)
        one, other = (
            (image[5:295, 5:295] - 6968) * np.outer(soft, soft)
            for image in (pair.reference, pair.sensed)
        )
        rest = (other - fourier_shifted(one, pair.shift))[middle, middle]
        left[blur] = rest.std() / other[middle, middle].std()
    assert left.pop(1.0) < 1e-3
    assert left == pytest.approx({0.0: 0.290, 0.5: 0.049, 0.7: 0.011}, rel=0.05)


def test_gain_offset_noise_and_rounding_are_as_said():
    scene = datasets.landsat().grey[:600, :600]
    clean = simulate.ortho_pair(scene, (1, 1), 2)
    pair = simulate.ortho_pair(
        scene, (1, 1), 2, gain=0.9, offset=40, sigma=15, dtype=np.uint16, seed=3
    )
    assert pair.sensed.dtype == pair.reference.dtype == np.uint16
    for noisy, ground in (
        (pair.reference, clean.reference),
        (pair.sensed, 0.9 * clean.sensed + 40),
    ):
        error = noisy - ground
        n = error.size
        assert error.mean() == pytest.approx(0, abs=4 * 15 / np.sqrt(n))
        # White noise, and what rounding adds
        sd = np.sqrt(15**2 + 1 / 12)
        assert error.std() == pytest.approx(sd, rel=4 / np.sqrt(2 * n))
    errors = (pair.reference - clean.reference, pair.sensed - 0.9 * clean.sensed)
    assert abs(np.corrcoef(errors[0].ravel(), errors[1].ravel())[0, 1]) < 4 / np.sqrt(n)


def test_fields_change_where_the_mask_says_and_nowhere_else():
    scene = datasets.landsat().grey
    before = simulate.ortho_pair(scene, (8, -4), 4)
    after = simulate.ortho_pair(scene, (8, -4), 4, changed=0.25, seed=1)
    np.testing.assert_array_equal(after.reference, before.reference)
    differs = after.sensed != before.sensed
    # The mask lies on the reference, two columns to the left and a row below
    np.testing.assert_array_equal(differs[:-1, 2:] & ~after.changed[1:, :-2], False)
    assert np.mean(differs[:-1, 2:][after.changed[1:, :-2]]) > 0.99
    # Some 150 fields, and pixels on the edges of changed fields count
    assert after.changed.mean() == pytest.approx(0.27, abs=0.08)
    assert not before.changed.any()


def test_haze_takes_contrast_and_adds_light_smoothly():
    scene = datasets.landsat().grey
    clear = simulate.ortho_pair(scene, (2, 2), 4)
    hazy = simulate.ortho_pair(scene, (2, 2), 4, haze=0.6, seed=4)
    np.testing.assert_array_equal(hazy.reference, clear.reference)
    light = np.quantile(scene, 0.99)
    kept = (hazy.sensed - light) / (clear.sensed - light)
    kept = kept[np.abs(clear.sensed - light) > 100]
    assert kept.min() == pytest.approx(0.4, abs=0.01)
    assert kept.max() == pytest.approx(1, abs=0.01)
    change = np.diff((hazy.sensed - light) / (clear.sensed - light), axis=1)
    assert np.quantile(np.abs(change), 0.999) < 0.6 * 2 * np.pi * 2.5 / 300 / 2 * 2
