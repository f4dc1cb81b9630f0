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


def _nanometres(data, size):
    """Photo coordinates that follow from Table 4.1, whichever way y points; nm."""
    return (data.pixels - frames.image_centre(data.image_size)) * size * 1e6


def test_table_4_1_is_computed_from_photo_coordinates_with_six_decimals(
    data, pixel_size
):
    # All 40 numbers to all seven decimals: by chance about 1 in 10^116. The pattern
    # does not depend on the sign of y: that (2.5b) was used, Table 4.2 says.
    photo = np.round(_nanometres(data, pixel_size)) / 1e6
    back = photo / pixel_size + frames.image_centre(data.image_size)
    np.testing.assert_allclose(back, data.pixels, rtol=0, atol=5e-8 + 1e-12)
    # The same six-decimal numbers, rounded, are Table 4.2
    np.testing.assert_allclose(photo, data.photo, rtol=0, atol=PRINTED)


def test_listing_rounds_left_points_to_whole_pixels_and_table_4_1_has_none(data):
    # The listing rounds the centre of the template; its log prints X=332, Y=1063
    distance = np.abs(data.pixels[0] - np.round(data.pixels[0]))
    assert distance.min() > 0.01
    # Uniform between 0 and 1/2: mean 1/4, standard deviation of the mean of 20 0.032
    assert abs(distance.mean() - 0.25) < 3 * 0.032


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


def test_listing_and_2_4_put_the_centre_at_967_5_as_the_tables_do(data):
    # n/2 - 0.5 is right for integers at pixel centres. A program that counts corners
    # and converts with it would leave the same tables: they hold the constant, not the
    # place of the origin in the first pixel.
    for axis in (0, 1):
        *_, centre, centre_sd = _line_fit(
            data.pixels[..., axis].ravel(), data.photo[..., axis].ravel()
        )
        n = data.image_size[axis]
        assert abs(centre - (n / 2 - 0.5)) < 3 * centre_sd < 2e-4
        assert abs(centre - n / 2) > 1000 * centre_sd


def test_listing_constant_did_not_make_the_tables(data):
    nanometres = _nanometres(data, data.listing_pixel_size)
    miss = np.abs(nanometres / 1e6 - data.photo)
    np.testing.assert_allclose(miss.max(axis=(0, 1)), (3.6e-5, 6.54e-4), atol=5e-7)
    assert (miss < PRINTED).sum() <= 2
    # Nor do six decimals show: uniform distances, mean 1/4, three times 0.023
    distance = np.abs(nanometres - np.round(nanometres))
    assert abs(distance.mean() - 0.25) < 3 * 0.023


def test_listing_sign_is_that_of_2_3b_and_not_of_table_4_2(data):
    centre = frames.image_centre(data.image_size)
    y = (centre[1] - data.pixels[..., 1]) * data.listing_pixel_size
    assert np.all(np.sign(y) == -np.sign(data.photo[..., 1]))
