"""Times of chapter 1 beside its peers, in one run: `make benchmark`.

Compare the medians within a group; the tests assert that both give the same, no times.
"""

import cv2
import numpy as np
import pytest
from scipy import ndimage

from pgm_lab import frames, image, simulate

SIZE, PIXEL, C = (4288, 2848), 0.0055, 24.0


@pytest.fixture(scope="module")
def pixels():
    return np.random.default_rng(1).uniform(0, 2848, (1_000_000, 2))


@pytest.fixture(scope="module")
def windows():
    centres = 10 + np.random.default_rng(2).uniform(-0.5, 0.5, (1000, 2))
    return simulate.photograph(simulate.target(centres), 3.0, seed=3)


@pytest.mark.benchmark(group="a million pixels to photo coordinates")
def test_frames(benchmark, pixels):
    benchmark(frames.pixel_to_photo, pixels, SIZE, PIXEL)


@pytest.mark.benchmark(group="a million pixels to photo coordinates")
def test_opencv_camera_matrix(benchmark, pixels):
    matrix = np.diag([C / PIXEL, C / PIXEL, 1.0])
    matrix[:2, 2] = (SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2
    points = pixels[:, None]

    def run():
        return cv2.undistortPoints(points, matrix, None)[:, 0] * (C, -C)

    found = benchmark(run)
    expected = frames.pixel_to_photo(pixels, SIZE, PIXEL)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)


@pytest.mark.benchmark(group="centroids of 1000 windows of 21 x 21")
def test_centroid_with_covariance(benchmark, windows):
    benchmark(image.centroid, windows, background=40.0, sigma=3.0)


@pytest.mark.benchmark(group="centroids of 1000 windows of 21 x 21")
def test_scipy_center_of_mass_in_a_loop(benchmark, windows):
    found = benchmark(lambda: [ndimage.center_of_mass(w - 40.0) for w in windows])
    expected = image.centroid(windows, background=40.0, sigma=3.0).position
    np.testing.assert_allclose(np.array(found)[:, ::-1], expected, rtol=0, atol=1e-9)


@pytest.mark.benchmark(group="centroids of 1000 windows of 21 x 21")
def test_opencv_moments_in_a_loop(benchmark, windows):
    def run():
        moments = [cv2.moments(window - 40.0) for window in windows]
        return np.array([(m["m10"] / m["m00"], m["m01"] / m["m00"]) for m in moments])

    found = benchmark(run)
    expected = image.centroid(windows, background=40.0, sigma=3.0).position
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)
