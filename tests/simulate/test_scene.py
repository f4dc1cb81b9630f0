"""Photos of a relief: the collinearity equations lead back to the pixel."""

import numpy as np
import pytest

from pgm_lab import camera, frames, simulate

LENS = camera.Camera(4.0, 0.02, -0.01, K1=2e-3, P1=1e-4)
EXTERIOR = (10, -5, 100, 0.1, -0.15, 2.0)
HILLS = simulate.texture(0.01, contrast=4.0, mean=8.0, waves=20, seed=5)
CELL = 0.25
GRID = np.stack(np.meshgrid(*2 * [np.linspace(-1.5, 1.5, 20)]), axis=-1)


def test_points_lie_on_the_relief_and_on_their_rays():
    xy = np.random.default_rng(1).uniform(-1.5, 1.5, (7, 9, 2))
    X = simulate.on_relief(LENS, EXTERIOR, xy, HILLS, CELL)
    heights = simulate.grey_values(HILLS, X[..., :2] / CELL)
    np.testing.assert_allclose(X[..., 2], heights, rtol=0, atol=1e-6)
    back = camera.project(LENS, EXTERIOR, X)
    np.testing.assert_allclose(back, xy, rtol=0, atol=1e-9)
    assert np.ptp(X[..., 2]) > 5  # the hills are there


@pytest.mark.parametrize("cell", [CELL, 1.0])
def test_a_pixel_shows_the_texture_of_its_ground_point(cell):
    texture = simulate.texture(0.2, waves=50)
    size, pixel = (30, 20), (0.05, 0.04)
    grey = simulate.relief_photo(LENS, EXTERIOR, HILLS, texture, size, pixel, cell=cell)
    column, row = 25, 4
    photo = frames.pixel_to_photo((column, row), size, pixel)
    X = simulate.on_relief(LENS, EXTERIOR, photo, HILLS, cell)
    expected = simulate.grey_values(texture, X[:2] / cell)
    assert grey.shape == (20, 30)
    assert grey[row, column] == pytest.approx(expected, abs=1e-6)


def test_noise_is_seeded_and_as_large_as_asked():
    texture = simulate.texture(0.2, waves=50)
    plain, noisy, again = (
        simulate.relief_photo(
            LENS, EXTERIOR, HILLS, texture, (80, 60), 0.02, sigma=s, seed=7
        )
        for s in (0, 5, 5)
    )
    assert abs(np.std(noisy - plain) - 5) < 4 * 5 / np.sqrt(2 * 4800)
    np.testing.assert_array_equal(noisy, again)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"exterior": (0, 0, 100, 3.0, 0, 0)}, "must look down"),
        ({"image_points": GRID, "cell": 0.02}, "too steep"),
    ],
)
def test_what_shows_no_ground_is_refused(changes, message):
    arguments = dict(exterior=EXTERIOR, image_points=(0, 0), relief=HILLS, cell=CELL)
    with pytest.raises(ValueError, match=message):
        simulate.on_relief(LENS, **(arguments | changes))
