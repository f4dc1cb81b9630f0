"""Proofs of the verdicts on Muliawan 2013. What chapter 1 touches: (2.1), (2.15) to
(2.17) and the precision of a centroid."""

from functools import cache

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_lab import frames, image, simulate


def test_2_1_gives_the_ray_from_the_perspective_centre():
    # Geometry: the perspective centre is c above the principal point, so the ray
    # prolonged to the depth -D meets the plane there at D/c times the offset
    x, y, x0, y0, c, depth = 3.0, -2.0, 0.1, -0.3, 35.0, 700.0
    ray = frames.interior_matrix(c, x0, y0) @ (x, y, 1)
    met = ray * depth / c
    close(met, ((x - x0) * 20, (y - y0) * 20, -depth), rtol=1e-15)


def _centroid_2_15(window, first_index):
    """(2.15) as printed, with the sums over all rows i and columns j."""
    i, j = np.indices(window.shape) + first_index
    return np.array([(j * window).sum(), (i * window).sum()]) / window.sum()


def test_2_15_counted_from_1_lies_one_pixel_beyond_2_17():
    # A target in the middle of the image must come out at the centre by (2.17)
    window = simulate.target((10, 7), diameter=5, shape=(15, 21), background=0)
    centre = frames.image_centre((21, 15))
    close(_centroid_2_15(window, 1) - centre, 1, atol=1e-6)
    close(_centroid_2_15(window, 0) - centre, 0, atol=1e-6)


def test_2_15_needs_rows_up_to_n_and_columns_up_to_m():
    # Printed: i (rows) up to m (columns). In an upright window rows are then missing.
    window = simulate.target((4, 15), diameter=5, shape=(21, 9), background=0)
    rows, columns = window.shape
    printed = window[: min(columns, rows), : min(rows, columns)]
    assert printed.sum() < 1e-6 * window.sum()
    close(_centroid_2_15(window, 0), (4, 15), atol=1e-6)


def test_2_15_without_background_removal_is_pulled_to_the_window_centre():
    truth = np.array([12.5, 8.0])
    window = simulate.target(truth, diameter=8)
    pull = _centroid_2_15(window, 0) - truth
    assert pull[0] < -1 and pull[1] > 0.8
    close(image.centroid(window, background=40.0, sigma=1.0).position, truth, atol=1e-4)


def test_2_16_and_2_17_agree_with_the_camera_matrix_of_opencv():
    size, pixel = (4288, 2848), 0.0055
    pixels = np.array([[0.0, 0.0], [4287.0, 2847.0], [1000.5, 2000.25]])
    focal = 24.0 / pixel
    camera = np.array(
        [[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1.0]]
    )
    normalised = cv2.undistortPoints(pixels[:, None], camera, None)[:, 0]
    expected = normalised * 24.0 * (1, -1)  # OpenCV's y points down
    photo = frames.pixel_to_photo(pixels, size, pixel)
    close(photo, expected, rtol=0, atol=1e-12)


def test_image_centre_is_the_principal_point_only_if_x0_and_y0_are_zero():
    # (2.16) puts (0, 0) at the image centre; the ray of the principal point has no
    # x and y component, so it is the image centre only for x0 = y0 = 0
    centre = frames.pixel_to_photo(frames.image_centre((100, 60)), (100, 60), 0.01)
    straight = frames.interior_matrix(35.0) @ (*centre, 1)
    equal(straight, (0, 0, -35))
    oblique = frames.interior_matrix(35.0, 0.2, -0.1) @ (*centre, 1)
    assert np.hypot(*oblique[:2]) == approx(np.hypot(0.2, 0.1))


@cache
def targets(diameter, window):
    """Centres (1500, 2) of targets somewhere in the middle pixel, and their windows."""
    middle = (window - 1) / 2
    centre = middle + np.random.default_rng(20131).uniform(-0.5, 0.5, (1500, 2))
    return centre, simulate.target(centre, diameter, shape=(window, window))


@pytest.mark.parametrize(
    ("diameter", "noise", "window", "threshold", "px"),
    [
        (10, 3, 21, 0, 0.0302),  # the quoted number, and its neighbours
        (10, 1, 21, 0, 0.0101),
        pytest.param(6, 3, 21, 0, 0.081, marks=pytest.mark.slow),
        pytest.param(10, 3, 31, 0, 0.066, marks=pytest.mark.slow),
        (10, 3, 21, 9, 0.0088),
    ],
)
def test_003_px_follows_from_one_set_of_conditions_and_not_from_others(
    diameter, noise, window, threshold, px
):
    # Contrast 160, 8 bit; 3000 errors give the rms to 1.3 per cent, three of them
    centre, clean = targets(diameter, window)
    grey = simulate.photograph(clean, noise=noise, seed=20132, bits=8)
    found = image.centroid(grey, threshold=threshold)
    rms = np.sqrt(np.mean((found.position - centre) ** 2))
    assert rms == approx(px, rel=0.04)
