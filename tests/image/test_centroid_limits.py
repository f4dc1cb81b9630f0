"""A window is flat if it may be noise alone, and not if it cannot be."""

import numpy as np
import pytest

from pgm_lab import image, simulate


@pytest.mark.parametrize("k", [0.5, 1.0, 2.0, 3.0])
def test_noise_is_flat_and_a_bright_target_is_found_at_any_threshold(k):
    sigma, rng = 2.0, np.random.default_rng(7)
    noise = rng.normal(100, sigma, (200, 21, 21))
    found = image.centroid(noise, sigma=sigma, threshold=k * sigma)
    assert not np.any(found.status == "ok")
    # 50 pixels, 18 sigma high: several times what all 441 may weigh as noise
    target = simulate.target((10, 10), 8.0, foreground=18 * sigma, background=0)
    found = image.centroid(noise + target, sigma=sigma, threshold=k * sigma)
    assert np.all(found.status == "ok")
    assert np.abs(found.position - 10).max() < 0.3
