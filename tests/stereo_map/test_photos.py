"""A reader's photos from disk: colours, sizes, EXIF, and what is missing."""

import itertools

import numpy as np
import pytest
from PIL import Image

from pgm_lab import stereo_map
from pgm_lab.camera import Camera

CAMERA = {"camera": Camera(24.0), "pixel_size": 0.005}


@pytest.fixture(scope="module")
def easy(pair):
    """A pixel that is found without an orientation, and its true place."""
    session = stereo_map.open_pair(pair.left.grey, pair.right.grey, **CAMERA)
    for column, row in itertools.product(range(40, 380, 20), range(40, 260, 20)):
        truth = pair.right.project(pair.ground[0][row, column])
        if stereo_map.measure(session, (column, row), truth).r > 0.85:
            return (column, row), truth
    raise AssertionError("no pixel is easy")


@pytest.fixture
def files(pair, tmp_path):
    """The pair as a JPEG in colour and a TIFF of 16 bit."""
    left, right = tmp_path / "left.jpg", tmp_path / "right.tif"
    grey = pair.left.grey
    colours = np.stack([grey, grey // 2, 255 - grey // 3], -1).astype(np.uint8)
    Image.fromarray(colours).save(left, quality=95)
    Image.fromarray(pair.right.grey.astype(np.uint16) * 200).save(right)
    return left, right


def test_a_jpeg_in_colour_and_a_tiff_of_16_bit_are_matched(files, easy):
    session = stereo_map.open_pair(*files, **CAMERA)
    pixel, truth = easy
    point = stereo_map.measure(session, pixel, truth + 3)
    assert point.accepted, point.why
    assert np.abs(point.right - truth).max() < 0.5


def test_photos_of_different_size_each_have_their_own_centre(pair, easy):
    cut = pair.right.grey[:250, :380]
    session = stereo_map.open_pair(pair.left.grey, cut, **CAMERA)
    pixel, truth = easy
    point = stereo_map.measure(session, pixel, truth)
    assert point.accepted, point.why
    middle = np.array([379 / 2, 249 / 2])
    expected = (point.right - middle) * (0.005, -0.005)
    np.testing.assert_allclose(point.photo[1], expected, atol=1e-9)


def test_exif_gives_the_camera_where_it_states_one(tmp_path, pair):
    path = tmp_path / "camera.jpg"
    exif = Image.Exif()
    inside = exif.get_ifd(0x8769)
    inside[0x920A], inside[0xA20E], inside[0xA210] = 24.0, 2000.0, 3  # pixels a cm
    Image.fromarray(pair.left.grey).save(path, exif=exif)
    photo = stereo_map.read_photo(path)
    assert photo.camera == Camera(24.0)
    assert photo.pixel_size == pytest.approx(0.005)
    exif = Image.Exif()
    inside = exif.get_ifd(0x8769)
    inside[0x920A], inside[0xA405] = 4.0, 24  # as a phone says it
    Image.fromarray(pair.left.grey).save(path, exif=exif)
    diagonal = 43.2666 * 4 / 24
    size = stereo_map.exif_camera(path, (420, 300))[1]
    assert size == pytest.approx(diagonal / np.hypot(420, 300))
    assert stereo_map.exif_camera(pair.left.grey, (420, 300)) == (None, None)


def test_without_a_camera_the_reader_is_told_what_to_give(files):
    with pytest.raises(ValueError, match="give camera=Camera.*pixel_size"):
        stereo_map.open_pair(*files)


def test_a_missing_photo_is_named(files, tmp_path):
    with pytest.raises(FileNotFoundError, match="right, .*gone.jpg: there is no such"):
        stereo_map.open_pair(files[0], tmp_path / "gone.jpg", **CAMERA)


def test_what_is_no_photo_is_named(files, tmp_path):
    path = tmp_path / "notes.jpg"
    path.write_text("no photo")
    with pytest.raises(ValueError, match="left, .*notes.jpg: this is not an image"):
        stereo_map.open_pair(path, files[1], **CAMERA)


def test_an_oriented_photo_brings_its_own_camera(pair):
    with pytest.raises(ValueError, match="left is a Photo"):
        stereo_map.open_pair(pair.left, pair.right, **CAMERA)


def test_photos_from_one_place_are_refused(pair):
    same = np.ones((2, 6))
    with pytest.raises(ValueError, match="both photos stand at the same place"):
        stereo_map.open_pair(pair.left.grey, pair.right.grey, exteriors=same, **CAMERA)


def test_photos_smaller_than_a_template_are_refused():
    tiny = np.zeros((15, 15))
    with pytest.raises(ValueError, match="left must have at least 23 x 23"):
        stereo_map.open_pair(tiny, tiny, **CAMERA)


def test_pixels_without_data_are_no_grey_values(pair):
    grey = pair.left.grey.astype(float)
    grey[100:140, 60:110] = np.nan
    session = stereo_map.open_pair(grey, pair.right.grey, **CAMERA)
    assert np.isfinite(session.levels[0][0]).all()
    assert stereo_map.measure(session, (85, 120)).status == "no data in the template"
