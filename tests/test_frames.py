"""Frames and scale: round trips, an independent program, covariances, exchanged sizes.

What this does not prove: that the conventions are the ones a camera's maker uses.

"""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pgm_lab import frames

SIZE = st.tuples(st.integers(1, 100_000), st.integers(1, 100_000))
PIXEL = st.floats(1e-4, 10.0)
STACK = st.tuples(st.integers(0, 4), st.integers(1, 5), st.just(2))
FRACTION = hnp.arrays(float, STACK, elements=st.floats(0, 1))
EPS = np.finfo(float).eps


@given(SIZE, PIXEL, PIXEL, FRACTION)
def test_round_trips_are_exact_for_any_size_and_stack(size, px, py, part):
    pixels = part * size - 0.5  # anywhere in the image
    photo = frames.pixel_to_photo(pixels, size, (px, py))
    back = frames.photo_to_pixel(photo, size, (px, py))
    assert photo.shape == pixels.shape
    assert np.all(np.abs(back - pixels) <= 4 * EPS * max(size))
    photo = (part - 0.5) * np.array(size) * px
    back = frames.pixel_to_photo(frames.photo_to_pixel(photo, size, px), size, px)
    assert np.all(np.abs(back - photo) <= 4 * EPS * max(size) * px)


@given(SIZE, PIXEL, PIXEL)
def test_corners_of_the_sensor_are_half_its_size_away_from_the_centre(size, px, py):
    corners = [(-0.5, -0.5), (size[0] - 0.5, size[1] - 0.5)]
    photo = frames.pixel_to_photo(corners, size, (px, py))
    half = np.array([size[0] * px, size[1] * py]) / 2
    np.testing.assert_allclose(photo, [half * (-1, 1), half * (1, -1)], rtol=1e-14)


def test_pixels_and_rays_agree_with_the_camera_matrix_of_opencv():
    rng = np.random.default_rng(7)
    size, pixel, c, x0, y0 = (4000, 3000), (0.004, 0.005), 28.0, 0.21, -0.13
    pixels = rng.uniform(0, 3000, (100, 2))
    matrix = np.diag([c / pixel[0], c / pixel[1], 1.0])
    # OpenCV's normalised coordinates are x / c and, with y down, -y / c
    matrix[:2, 2] = (size[0] - 1) / 2, (size[1] - 1) / 2
    expected = cv2.undistortPoints(pixels[:, None], matrix, None)[:, 0] * (c, -c)
    photo = frames.pixel_to_photo(pixels, size, pixel)
    np.testing.assert_allclose(photo, expected, rtol=0, atol=1e-12)
    matrix[:2, 2] = frames.photo_to_pixel((x0, y0), size, pixel)
    expected = cv2.undistortPoints(pixels[:, None], matrix, None)[:, 0] * (c, -c)
    rays = np.insert(photo, 2, 1, axis=1) @ frames.interior_matrix(c, x0, y0).T
    np.testing.assert_allclose(rays[:, :2], expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(rays[:, 2], -c)


# --- Covariances ---

WINDOW, AXES = (400, 300), (0.01, 0.02)
C = np.array([[0.04, 0.03], [0.03, 0.09]])


def test_the_covariance_is_that_of_many_points_turned_one_by_one():
    pixels = np.random.default_rng(1).multivariate_normal((150, 120), C, 200_000)
    sample = np.cov(frames.pixel_to_photo(pixels, WINDOW, AXES).T)
    photo, found = frames.pixel_to_photo((150, 120), WINDOW, AXES, covariance=C)
    np.testing.assert_array_equal(
        photo, frames.pixel_to_photo((150, 120), WINDOW, AXES)
    )
    # An element of a sampled covariance scatters by sqrt(2 / n) of the variances
    sd = np.sqrt(np.diag(found))
    assert np.all(np.abs(sample - found) < 5 * np.sqrt(2 / 200_000) * np.outer(sd, sd))
    # The y axis changes its direction
    np.testing.assert_allclose(found, C * [[1e-4, -2e-4], [-2e-4, 4e-4]], rtol=1e-14)


@pytest.mark.parametrize("shape", [(2, 2), (5, 2, 2), (3, 5, 2, 2)])
def test_covariances_come_back_for_one_or_one_a_point(shape):
    pixels = np.random.default_rng(2).uniform(0, 300, (3, 5, 2))
    given = np.broadcast_to(C, shape)
    photo, there = frames.pixel_to_photo(pixels, WINDOW, AXES, covariance=given)
    back, again = frames.photo_to_pixel(photo, WINDOW, AXES, covariance=there)
    assert there.shape == again.shape == (3, 5, 2, 2)
    np.testing.assert_allclose(again, np.broadcast_to(C, again.shape), rtol=1e-13)
    np.testing.assert_allclose(back, pixels, rtol=1e-13)


@pytest.mark.parametrize("turn", [frames.pixel_to_photo, frames.photo_to_pixel])
@pytest.mark.parametrize("wrong", [[[1, 0.5], [0.4, 1]], [[1, 2], [2, 1]], [C, C, C]])
def test_what_is_no_covariance_is_refused(turn, wrong):
    with pytest.raises(ValueError, match="covariance"):
        turn([(1, 2), (3, 4)], WINDOW, AXES, covariance=wrong)


# --- Columns and rows exchanged ---


@pytest.mark.parametrize("pixel", [(29.6, 10.0), (39.5, 29.5), (39.5, -0.5)])
def test_point_that_fits_only_into_the_exchanged_image_is_refused(pixel):
    with pytest.raises(ValueError, match="image_size must be"):
        frames.pixel_to_photo(pixel, (30, 40), 0.01)


# The image ends half a pixel outside its outermost centres; points outside both images
# are not taken for an exchange
@pytest.mark.parametrize(
    "pixel", [(-0.5, -0.5), (29.5, 39.5), (39.6, 10.0), (35.0, 29.6), (35.0, -0.6)]
)
def test_other_points_are_converted(pixel):
    frames.pixel_to_photo(pixel, (30, 40), 0.01)


def test_exchanged_sensor_and_image_are_refused():
    with pytest.raises(ValueError, match="both portrait or both landscape"):
        frames.pixel_size_from_sensor((23.6, 15.8), (1296, 1936))


# --- Scale ---


@given(
    st.floats(1e-4, 1e-1), st.floats(1.0, 1e4), st.floats(1.0, 1e3), st.floats(0.1, 10)
)
def test_flying_height_undoes_the_ground_sampling_distance(pixel, height, c, factor):
    gsd = frames.ground_sampling_distance(pixel, height, c)
    assert frames.flying_height(gsd, pixel, c) == pytest.approx(height, rel=1e-14)
    larger = frames.ground_sampling_distance(pixel * factor, height, c)
    assert larger == pytest.approx(gsd * factor, rel=1e-14)
