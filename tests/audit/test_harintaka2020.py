"""Proofs of the verdicts on Harintaka 2020. What chapter 1 touches: H/f, the ground
sampling distance and the size of an image file."""

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_book.common import ledger
from pgm_lab import datasets, frames


@pytest.fixture(scope="module")
def data():
    return datasets.harintaka2020()


def test_scale_number_from_the_height_lies_in_the_printed_range_not_at_its_mean(data):
    height, c = data.flight["flying_height"], data.flight["principal_distance"]
    number = frames.scale_number(height, c)
    low, high = data.flight["least_scale_number"], data.flight["greatest_scale_number"]
    mean = data.flight["mean_scale_number"]
    assert round(number) == 41667
    assert low < number < high and low < mean < high
    # The mean would need a flying height of 960 m, 40 m below the printed one
    assert mean * c / 1000 == approx(960.0)
    assert round(number, -3) != mean


@pytest.mark.parametrize(
    ("pixel_size", "gsd", "height"),
    [(None, 0.22875, 874.32), (23.7 / 4288, 0.23029, 868.46)],
    ids=["maker's pixel size", "sensor width over columns"],
)
def test_ground_sampling_distance_is_23_cm_and_not_20(data, pixel_size, gsd, height):
    pixel_size = pixel_size or data.camera_pixel_size
    h, c = data.flight["flying_height"], data.flight["principal_distance"]
    found = frames.ground_sampling_distance(pixel_size, h, c)
    assert found == approx(gsd, abs=5e-6)
    assert round(100 * found) == 23
    printed = data.flight["ground_sampling_distance"]
    assert pixel_size / 1000 * data.flight["least_scale_number"] > printed + 0.01
    assert pixel_size / 1000 * data.flight["greatest_scale_number"] < 0.238
    needed = frames.flying_height(printed, pixel_size, c)
    assert needed == approx(height, abs=0.005)


def test_70_megabytes_are_48_bits_a_pixel_and_not_24(data):
    columns, rows = data.camera_image_size
    bits = data.flight["radiometric_resolution"]
    assert bits == 24
    mebibytes = columns * rows * np.array([bits, 2 * bits]) / 8 / 2**20
    close(mebibytes, (34.94, 69.88), atol=0.005)
    assert round(mebibytes[1]) == data.flight["file_size_uncompressed"]


def test_7_megabytes_may_be_a_jpeg_of_many_qualities(data):
    (row,) = ledger.verdicts("8", ["Hasil dan Pembahasan, compressed file"])
    megabytes = float(row["printed"].split()[1])
    pixels = np.prod(data.camera_image_size)
    bits = megabytes * np.array([1e6, 2**20]) * 8 / pixels
    close(bits, (4.6, 4.8), atol=0.05)
    grey = datasets.yellowstone().grey.astype(np.uint8)
    files = [
        cv2.imencode(".jpg", grey, (cv2.IMWRITE_JPEG_QUALITY, q))[1] for q in (50, 100)
    ]
    taken = [8 * len(file) / grey.size for file in files]
    assert taken == approx([2, 9], abs=0.2)  # bits a pixel
