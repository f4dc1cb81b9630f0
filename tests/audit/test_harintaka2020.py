"""Proofs of the verdicts on Harintaka 2020. What chapter 1 touches: H/f, the ground
sampling distance and the size of an image file."""

import numpy as np
import pytest

from pgm_lab import datasets, frames


@pytest.fixture(scope="module")
def data():
    return datasets.harintaka2020()


def test_mean_scale_number_lies_in_its_range_but_does_not_follow_from_the_height(data):
    number = frames.scale_number(
        data.flight["flying_height"], data.flight["principal_distance"]
    )
    mean = data.flight["mean_scale_number"]
    low, high = data.flight["least_scale_number"], data.flight["greatest_scale_number"]
    assert low < mean < high and low < number < high
    assert round(number) == 41667
    # To the two digits that its range is printed with, they differ
    assert round(number, -3) != mean


@pytest.mark.parametrize(
    ("pixel_size", "gsd", "height"),
    [(0.00549, 0.22875, 874.32), (23.7 / 4288, 0.23029, 868.46)],
)
def test_ground_sampling_distance_is_23_cm_and_not_20(data, pixel_size, gsd, height):
    h, c = data.flight["flying_height"], data.flight["principal_distance"]
    found = frames.ground_sampling_distance(pixel_size, h, c)
    assert found == pytest.approx(gsd, abs=5e-6)
    assert round(100 * found) == 23
    printed = data.flight["ground_sampling_distance"]
    assert pixel_size / 1000 * data.flight["least_scale_number"] > printed + 0.01
    assert pixel_size / 1000 * data.flight["greatest_scale_number"] < 0.238
    needed = frames.flying_height(printed, pixel_size, c)
    assert needed == pytest.approx(height, abs=0.005)


def test_printed_scale_range_gives_flying_heights_around_1000_m(data):
    numbers = np.array([39_000, 43_000])
    heights = numbers * data.flight["principal_distance"] / 1000
    np.testing.assert_allclose(heights, (936, 1032))
    np.testing.assert_allclose(
        frames.scale_number(heights, data.flight["principal_distance"]), numbers
    )


def test_70_megabytes_need_48_bits_a_pixel_and_not_24(data):
    columns, rows = data.camera_image_size
    megabytes = {bits: columns * rows * bits / 8 / 1e6 for bits in (24, 48)}
    assert megabytes[24] == pytest.approx(36.6, abs=0.05)
    assert megabytes[48] == pytest.approx(73.3, abs=0.05)
    printed = data.flight["file_size_uncompressed"]
    assert abs(megabytes[48] - printed) < 0.05 * printed < abs(megabytes[24] - printed)
