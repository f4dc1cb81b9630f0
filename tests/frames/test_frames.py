"""Frames and scale: round trips, an independent program, and bad input.

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
FRACTION = hnp.arrays(
    float,
    st.tuples(st.integers(0, 4), st.integers(1, 5), st.just(2)),
    elements=st.floats(0, 1),
)
EPS = np.finfo(float).eps


@given(SIZE, PIXEL, PIXEL, FRACTION)
def test_pixel_to_photo_and_back_is_exact_for_any_size_and_stack(size, px, py, part):
    pixels = part * size - 0.5  # anywhere in the image
    photo = frames.pixel_to_photo(pixels, size, (px, py))
    back = frames.photo_to_pixel(photo, size, (px, py))
    assert photo.shape == pixels.shape
    assert np.all(np.abs(back - pixels) <= 4 * EPS * max(size))


@given(SIZE, PIXEL, FRACTION)
def test_photo_to_pixel_and_back_is_exact_for_any_size_and_stack(size, pixel, part):
    photo = (part - 0.5) * np.array(size) * pixel
    back = frames.pixel_to_photo(frames.photo_to_pixel(photo, size, pixel), size, pixel)
    assert np.all(np.abs(back - photo) <= 4 * EPS * max(size) * pixel)


@given(SIZE, PIXEL, PIXEL)
def test_corners_of_the_sensor_are_half_its_size_away_from_the_centre(size, px, py):
    corners = [(-0.5, -0.5), (size[0] - 0.5, size[1] - 0.5)]
    photo = frames.pixel_to_photo(corners, size, (px, py))
    half = np.array([size[0] * px, size[1] * py]) / 2
    np.testing.assert_allclose(photo, [half * (-1, 1), half * (1, -1)], rtol=1e-14)


def test_axes_x_to_the_right_and_y_up():
    left_top, right, down = frames.pixel_to_photo(
        [(0, 0), (1, 0), (0, 1)], (40, 30), (0.01, 0.02)
    )
    np.testing.assert_allclose(right - left_top, (0.01, 0))
    np.testing.assert_allclose(down - left_top, (0, -0.02))


def test_agrees_with_the_camera_matrix_of_opencv():
    rng = np.random.default_rng(7)
    size, pixel, c = (4000, 3000), (0.004, 0.005), 28.0
    pixels = rng.uniform(0, 3000, (100, 2))
    matrix = np.diag([c / pixel[0], c / pixel[1], 1.0])
    matrix[:2, 2] = (size[0] - 1) / 2, (size[1] - 1) / 2
    # OpenCV's normalised coordinates are x / c and, with y down, -y / c
    normalised = cv2.undistortPoints(pixels[:, None], matrix, None)[:, 0]
    expected = normalised * (c, -c)
    photo = frames.pixel_to_photo(pixels, size, pixel)
    np.testing.assert_allclose(photo, expected, rtol=0, atol=1e-12)


def test_interior_matrix_gives_the_ray_that_opencv_gives():
    c, x0, y0, pixel, size = 35.0, 0.21, -0.13, 0.005, (400, 300)
    photo = np.array([1.5, -2.5])
    ray = frames.interior_matrix(c, x0, y0) @ (*photo, 1)
    matrix = np.diag([c / pixel, c / pixel, 1.0])
    matrix[:2, 2] = frames.photo_to_pixel((x0, y0), size, pixel)
    column_row = frames.photo_to_pixel(photo, size, pixel)
    normalised = cv2.undistortPoints(column_row[None, None], matrix, None).ravel()
    np.testing.assert_allclose(ray[:2] / c, normalised * (1, -1), atol=1e-12)
    assert ray[2] == -c


@given(
    st.floats(1e-4, 1e-1), st.floats(1.0, 1e4), st.floats(1.0, 1e3), st.floats(0.1, 10)
)
def test_flying_height_undoes_the_ground_sampling_distance(pixel, height, c, factor):
    gsd = frames.ground_sampling_distance(pixel, height, c)
    assert frames.flying_height(gsd, pixel, c) == pytest.approx(height, rel=1e-14)
    assert frames.ground_sampling_distance(pixel * factor, height, c) == pytest.approx(
        gsd * factor, rel=1e-14
    )


def test_ground_sampling_distance_equals_two_projected_pixels():
    # Two neighbouring pixels, projected onto the ground along their rays
    pixel, height, c = 0.00549, 1000.0, 24.0
    photo = frames.pixel_to_photo([(100, 50), (101, 50)], (4288, 2848), pixel)
    rays = [frames.interior_matrix(c) @ (*point, 1) for point in photo]
    ground = np.array([ray[:2] * height / -ray[2] for ray in rays])
    gsd = frames.ground_sampling_distance(pixel, height, c)
    assert np.hypot(*(ground[1] - ground[0])) == pytest.approx(gsd, rel=1e-11)


def test_scale_and_gsd_take_arrays():
    heights = np.array([500.0, 1000.0])
    np.testing.assert_allclose(frames.scale_number(heights, 50.0), (10_000, 20_000))
    gsd = frames.ground_sampling_distance(0.005, heights[:, None], [25.0, 50.0])
    np.testing.assert_allclose(gsd, [[0.1, 0.05], [0.2, 0.1]])


def test_pixel_size_from_sensor_keeps_x_and_y_apart():
    np.testing.assert_allclose(
        frames.pixel_size_from_sensor((23.6, 15.8), (1936, 1296)),
        (23.6 / 1936, 15.8 / 1296),
        rtol=1e-15,
    )


def test_image_centre_of_even_and_odd_sizes():
    np.testing.assert_array_equal(frames.image_centre((4, 5)), (1.5, 2.0))


GOOD = {"pixels": [[1.0, 2.0]], "image_size": (40, 30), "pixel_size": 0.01}
BAD = [
    ({"pixels": np.zeros((5, 3))}, r"pixels must have shape \(\.\.\., 2\).*\(5, 3\)"),
    ({"pixels": 3.0}, r"pixels must have shape"),
    ({"pixels": [[1.0, np.nan]]}, r"pixels\[0, 1\] is not a finite number"),
    ({"pixels": [[np.inf, 1.0]]}, r"pixels\[0, 0\] is not a finite number"),
    ({"pixels": [["a", "b"]]}, "pixels must be numbers"),
    ({"pixel_size": -0.01}, r"pixel_size must be positive \(mm\); got -0.01"),
    ({"pixel_size": 0.0}, "pixel_size must be positive"),
    ({"pixel_size": np.nan}, "pixel_size is not a finite number"),
    ({"pixel_size": (0.1, 0.1, 0.1)}, r"one number or \(x, y\) in mm"),
    ({"image_size": (30, 40, 3)}, r"image_size must be \(columns, rows\)"),
    ({"image_size": (40.5, 30)}, "two whole numbers"),
    ({"image_size": (-40, 30)}, "image_size must be positive"),
    ({"image_size": 40}, r"image_size must be \(columns, rows\)"),
    (
        {"pixels": [[39.0, 29.0]], "image_size": (30, 40)},
        r"outside an image of 30 columns and 40 rows.*must be\s+\(columns, rows\)",
    ),
]


@pytest.mark.parametrize(("change", "message"), BAD)
def test_bad_input_says_what_was_expected(change, message):
    with pytest.raises(ValueError, match=message):
        frames.pixel_to_photo(**(GOOD | change))


@pytest.mark.parametrize(("change", "message"), BAD[:12])
def test_bad_input_on_the_way_back_says_what_was_expected(change, message):
    arguments = GOOD | change
    with pytest.raises(ValueError, match=message.replace("pixels", "photo")):
        frames.photo_to_pixel(
            arguments["pixels"], arguments["image_size"], arguments["pixel_size"]
        )


@pytest.mark.parametrize("pixel", [(-0.5, -0.5), (29.5, 39.5)])
def test_image_ends_half_a_pixel_outside_its_outermost_centres(pixel):
    frames.pixel_to_photo(pixel, (30, 40), 0.01)


@pytest.mark.parametrize("pixel", [(29.6, 10.0), (39.5, 29.5), (39.5, -0.5)])
def test_point_that_fits_only_into_the_exchanged_image_is_refused(pixel):
    with pytest.raises(ValueError, match="image_size must be"):
        frames.pixel_to_photo(pixel, (30, 40), 0.01)


@pytest.mark.parametrize("pixel", [(39.6, 10.0), (35.0, 29.6), (35.0, -0.6)])
def test_point_outside_both_is_not_taken_for_an_exchange(pixel):
    frames.pixel_to_photo(pixel, (30, 40), 0.01)


@given(SIZE, FRACTION)
def test_round_trip_outside_the_image_with_the_check_switched_off(size, part):
    photo = (part - 0.5) * 100.0
    pixels = frames.photo_to_pixel(photo, size, 0.01)
    back = frames.pixel_to_photo(pixels, size, 0.01, check_size=False)
    np.testing.assert_allclose(back, photo, rtol=0, atol=1e-12 * max(100, *size))


def test_exchanged_sensor_and_image_are_refused():
    with pytest.raises(ValueError, match="both upright or both wide"):
        frames.pixel_size_from_sensor((23.6, 15.8), (1296, 1936))


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [
        (frames.interior_matrix, (-35.0,), "c must be positive"),
        (frames.interior_matrix, (35.0, np.nan), "x0 is not a finite number"),
        (frames.interior_matrix, ([35.0, 1.0],), "c must be one number"),
        (frames.scale_number, (1000.0, 0.0), "principal_distance must be positive"),
        (frames.flying_height, (-0.2, 0.005, 24.0), "gsd must be positive"),
        (frames.ground_sampling_distance, (0.0, 1.0, 1.0), "pixel_size must be"),
    ],
)
def test_bad_camera_numbers_are_named(function, arguments, message):
    with pytest.raises(ValueError, match=message):
        function(*arguments)
