"""Proofs of the verdicts on Bani 2010. What chapter 1 touches: (2.3) to (2.5), Tables
4.1 and 4.2, the image and sensor size of appendix B, the conversion in the listing."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close

from pgm_lab import datasets, frames

PRINTED = 5e-6 + 1e-12  # mm: half of the last printed digit of Table 4.2


DATA = datasets.bani2010()
CENTRE = frames.image_centre(DATA.image_size)
PIXEL = frames.pixel_size_from_sensor(DATA.sensor_size, DATA.image_size)
# Table 4.1 turned into photo coordinates by (2.3a), (2.3b), (2.4a), (2.4b)
COMPUTED = frames.pixel_to_photo(DATA.pixels, DATA.image_size, PIXEL)


def test_table_4_2_x_follows_from_table_4_1_to_the_printed_digits():
    close(COMPUTED[..., 0], DATA.photo[..., 0], rtol=0, atol=PRINTED)


def test_table_4_2_y_follows_from_2_3b_only_with_its_sign_turned():
    close(-COMPUTED[..., 1], DATA.photo[..., 1], rtol=0, atol=PRINTED)
    misfit = np.abs(COMPUTED[..., 1] - DATA.photo[..., 1])
    assert misfit.min() > 0.2 and misfit.max() > 11.7


def test_2_3b_turns_rows_downwards_into_y_upwards():
    # Geometry, not algebra: the edges of the sensor lie half its height off the centre
    edges = [(0.0, -0.5), (0.0, DATA.image_size[1] - 0.5)]
    y = frames.pixel_to_photo(edges, DATA.image_size, PIXEL)[:, 1]
    close(y, (7.9, -7.9), rtol=0, atol=1e-12)


def test_2_5a_undoes_2_3a():
    x = COMPUTED[..., 0] / PIXEL[0] + CENTRE[0]
    close(x, DATA.pixels[..., 0], rtol=0, atol=1e-9)


def test_2_5b_does_not_undo_2_3b_but_mirrors_the_rows():
    y = COMPUTED[..., 1] / PIXEL[1] + CENTRE[1]
    close(y, DATA.image_size[1] - 1 - DATA.pixels[..., 1], rtol=0, atol=1e-9)
    assert np.abs(y - DATA.pixels[..., 1]).max() > 900


def test_2_5_turns_table_4_2_into_table_4_1():
    back = DATA.photo / PIXEL + CENTRE
    assert np.all(np.abs(back - DATA.pixels) <= PRINTED / PIXEL + 5e-8)


def _nanometres(size):
    """Photo coordinates that follow from Table 4.1, whichever way y points; nm."""
    return (DATA.pixels - CENTRE) * size * 1e6


def test_table_4_1_is_computed_from_photo_coordinates_with_six_decimals():
    # All 40 numbers to all seven decimals: by chance about 1 in 10^116. The pattern
    # does not depend on the sign of y: that (2.5b) was used, Table 4.2 says.
    photo = np.round(_nanometres(PIXEL)) / 1e6
    close(photo / PIXEL + CENTRE, DATA.pixels, rtol=0, atol=5e-8 + 1e-12)
    # The same six-decimal numbers, rounded, are Table 4.2
    close(photo, DATA.photo, rtol=0, atol=PRINTED)


def test_listing_rounds_left_points_to_whole_pixels_and_table_4_1_has_none():
    # The listing rounds the centre of the template; its log prints X=332, Y=1063
    distance = np.abs(DATA.pixels[0] - np.round(DATA.pixels[0]))
    assert distance.min() > 0.01
    # Uniform between 0 and 1/2: mean 1/4, standard deviation of the mean of 20 0.032
    assert abs(distance.mean() - 0.25) < 3 * 0.032


@pytest.mark.parametrize("axis", [0, 1])
def test_tables_themselves_give_sensor_size_and_image_centre(axis):
    # n/2 - 0.5 is right for integers at pixel centres. A program that counts corners
    # and converts with it would leave the same tables: they hold the constant, not the
    # place of the origin in the first pixel.
    pixels, photo = DATA.pixels[..., axis].ravel(), DATA.photo[..., axis].ravel()
    design = np.column_stack([pixels, np.ones_like(pixels)])
    (slope, shift), *_ = np.linalg.lstsq(design, photo, rcond=None)
    residuals = design @ (slope, shift) - photo
    variance = residuals @ residuals / (len(photo) - 2)
    covariance = variance * np.linalg.inv(design.T @ design)
    gradient = np.array([shift / slope**2, -1 / slope])
    centre, centre_sd = -shift / slope, (gradient @ covariance @ gradient) ** 0.5
    n = DATA.image_size[axis]
    size, size_sd = slope * n, covariance[0, 0] ** 0.5 * n
    assert abs(size - DATA.sensor_size[axis]) < 3 * size_sd < 1.5e-5  # mm
    assert centre_sd < 2e-4 / 3
    assert abs(centre - (n / 2 - 0.5)) < 3 * centre_sd
    assert abs(centre - n / 2) > 1000 * centre_sd


def test_listing_constant_did_not_make_the_tables():
    nanometres = _nanometres(DATA.listing_pixel_size)
    miss = np.abs(nanometres / 1e6 - DATA.photo)
    close(miss.max(axis=(0, 1)), (3.6e-5, 6.54e-4), atol=5e-7)
    assert (miss < PRINTED).sum() <= 2
    # Nor do six decimals show: uniform distances, mean 1/4, three times 0.023
    distance = np.abs(nanometres - np.round(nanometres))
    assert abs(distance.mean() - 0.25) < 3 * 0.023


def test_listing_sign_is_that_of_2_3b_and_not_of_table_4_2():
    y = (CENTRE[1] - DATA.pixels[..., 1]) * DATA.listing_pixel_size
    assert np.all(np.sign(y) == -np.sign(DATA.photo[..., 1]))
