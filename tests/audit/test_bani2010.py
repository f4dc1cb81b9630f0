"""Proofs of the verdicts on Bani 2010. What chapter 1 touches: (2.3) to (2.5), Tables
4.1 and 4.2, the image and sensor size of appendix B, the conversion in the listing."""

import numpy as np
import pytest

from pgm_lab import datasets, frames

PRINTED = 5e-6 + 1e-12  # mm: half of the last printed digit of Table 4.2


@pytest.fixture(scope="module")
def data():
    return datasets.bani2010()


@pytest.fixture(scope="module")
def pixel_size(data):
    return frames.pixel_size_from_sensor(data.sensor_size, data.image_size)


@pytest.fixture(scope="module")
def computed(data, pixel_size):
    """Table 4.1 turned into photo coordinates by (2.3a), (2.3b), (2.4a), (2.4b)."""
    return frames.pixel_to_photo(data.pixels, data.image_size, pixel_size)


def test_table_4_2_x_follows_from_table_4_1_to_the_printed_digits(data, computed):
    np.testing.assert_allclose(
        computed[..., 0], data.photo[..., 0], rtol=0, atol=PRINTED
    )


def test_table_4_2_y_follows_from_2_3b_only_with_its_sign_turned(data, computed):
    np.testing.assert_allclose(
        -computed[..., 1], data.photo[..., 1], rtol=0, atol=PRINTED
    )
    misfit = np.abs(computed[..., 1] - data.photo[..., 1])
    assert misfit.min() > 0.2 and misfit.max() > 11.7


def test_2_3b_turns_rows_downwards_into_y_upwards(data, pixel_size):
    # Geometry, not algebra: the top edge of the sensor is half its height above the
    # centre, the bottom edge half its height below
    edges = [(0.0, -0.5), (0.0, data.image_size[1] - 0.5)]
    y = frames.pixel_to_photo(edges, data.image_size, pixel_size)[:, 1]
    np.testing.assert_allclose(y, (7.9, -7.9), rtol=0, atol=1e-12)


def test_2_5a_undoes_2_3a(data, computed, pixel_size):
    x = computed[..., 0] / pixel_size[0] + frames.image_centre(data.image_size)[0]
    np.testing.assert_allclose(x, data.pixels[..., 0], rtol=0, atol=1e-9)


def test_2_5b_does_not_undo_2_3b_but_mirrors_the_rows(data, computed, pixel_size):
    y = computed[..., 1] / pixel_size[1] + frames.image_centre(data.image_size)[1]
    mirrored = data.image_size[1] - 1 - data.pixels[..., 1]
    np.testing.assert_allclose(y, mirrored, rtol=0, atol=1e-9)
    assert np.abs(y - data.pixels[..., 1]).max() > 900


def test_2_5_turns_table_4_2_into_table_4_1(data, pixel_size):
    back = data.photo / pixel_size + frames.image_centre(data.image_size)
    half_digit = PRINTED / pixel_size
    assert np.all(np.abs(back - data.pixels) <= half_digit + 5e-8)


def _six_decimal_photo(data, pixel_size):
    centre = frames.image_centre(data.image_size)
    return np.round((data.pixels - centre) * pixel_size, 6)


def test_table_4_1_follows_by_2_5_from_photo_coordinates_with_six_decimals(
    data, pixel_size
):
    # All 40 numbers to all seven decimals: by chance about 1 in 10^116
    photo = _six_decimal_photo(data, pixel_size)
    back = photo / pixel_size + frames.image_centre(data.image_size)
    np.testing.assert_allclose(back, data.pixels, rtol=0, atol=5e-8 + 1e-12)


def test_six_decimal_photo_coordinates_round_to_table_4_2(data, pixel_size):
    photo = _six_decimal_photo(data, pixel_size)
    np.testing.assert_allclose(photo, data.photo, rtol=0, atol=PRINTED)


def test_other_pixel_sizes_leave_no_six_decimal_pattern(data):
    centre = frames.image_centre(data.image_size)
    nanometres = (data.pixels - centre) * data.listing_pixel_size * 1e6
    distance = np.abs(nanometres - np.round(nanometres))
    # Uniform between 0 and 1/2 has the mean 1/4; 40 values leave it within 0.07
    assert 0.18 < distance.mean() < 0.32


def _line_fit(pixels, photo):
    """Pixel size and centre with standard deviations, from a straight line."""
    design = np.column_stack([pixels, np.ones_like(pixels)])
    (slope, shift), *_ = np.linalg.lstsq(design, photo, rcond=None)
    residuals = design @ (slope, shift) - photo
    variance = residuals @ residuals / (len(photo) - 2)
    covariance = variance * np.linalg.inv(design.T @ design)
    centre = -shift / slope
    gradient = np.array([shift / slope**2, -1 / slope])
    return (
        slope,
        covariance[0, 0] ** 0.5,
        centre,
        (gradient @ covariance @ gradient) ** 0.5,
    )


@pytest.mark.parametrize("axis", [0, 1])
def test_tables_themselves_give_sensor_size_and_image_centre(data, axis):
    slope, slope_sd, centre, centre_sd = _line_fit(
        data.pixels[..., axis].ravel(), data.photo[..., axis].ravel()
    )
    columns_or_rows = data.image_size[axis]
    assert slope_sd * columns_or_rows < 5e-6  # mm on the whole sensor
    assert abs(slope * columns_or_rows - data.sensor_size[axis]) < 3 * (
        slope_sd * columns_or_rows
    )
    assert centre_sd < 1e-4
    assert abs(centre - (columns_or_rows / 2 - 0.5)) < 3 * centre_sd


def test_origin_at_the_corner_of_the_image_contradicts_the_tables(data):
    for axis in (0, 1):
        *_, centre, centre_sd = _line_fit(
            data.pixels[..., axis].ravel(), data.photo[..., axis].ravel()
        )
        assert abs(centre - data.image_size[axis] / 2) > 1000 * centre_sd


def test_listing_constant_misses_table_4_2(data):
    centre = frames.image_centre(data.image_size)
    photo = (data.pixels - centre) * data.listing_pixel_size
    miss = np.abs(photo - data.photo).max(axis=(0, 1))
    np.testing.assert_allclose(miss, (3.6e-5, 6.54e-4), atol=5e-7)
    assert (np.abs(photo - data.photo) < PRINTED).sum() <= 2


def test_listing_sign_is_that_of_2_3b_and_not_of_table_4_2(data):
    centre = frames.image_centre(data.image_size)
    y = (centre[1] - data.pixels[..., 1]) * data.listing_pixel_size
    assert np.all(np.sign(y) == -np.sign(data.photo[..., 1]))


def test_second_copy_of_the_page_prints_a_sensor_that_the_tables_refute(data):
    slope, slope_sd, *_ = _line_fit(
        data.pixels[..., 0].ravel(), data.photo[..., 0].ravel()
    )
    width, width_sd = slope * 1936, slope_sd * 1936
    assert abs(width - 23.6) < 3 * width_sd
    assert abs(width - 53.0) > 1e6 * width_sd


def test_pixel_of_the_camera_is_square_to_one_in_ten_thousand(pixel_size):
    assert abs(pixel_size[1] / pixel_size[0] - 1) == pytest.approx(1.05e-4, abs=5e-7)
