"""A reader's photos from disk: colours, sizes, EXIF, and what is missing."""

import itertools

import numpy as np
import pytest
from PIL import Image

from pgm_lab import stereo_map
from pgm_lab.camera import Camera
from pgm_lab.camera.files import CameraFile

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
    pixel, truth = easy
    session = stereo_map.open_pair(*files, **CAMERA)
    point = stereo_map.measure(session, pixel, truth + 3)
    assert point.accepted, point.why
    assert np.abs(point.right - truth).max() < 0.5


def test_a_camera_json_stands_for_camera_and_pixel_size(files, tmp_path):
    with Image.open(files[0]) as image:
        columns, rows = image.size
        turned = image.convert("L").rotate(90, expand=True)
    path = tmp_path / "camera.json"
    CameraFile(CAMERA["camera"], (columns, rows), 0.005).save(path)
    for photo in stereo_map.open_pair(*files, camera=path).photos:
        assert (photo.camera, photo.pixel_size) == (CAMERA["camera"], 0.005)
    words = f"right has {rows} x {columns} pixels.*{columns} x {rows}.*its EXIF"
    with pytest.raises(ValueError, match=words):
        stereo_map.open_pair(files[0], turned, camera=path)
    upside_down = turned.rotate(90, expand=True)
    upside_down.getexif()[0x0112] = 3
    upside_down.save(tmp_path / "b.jpg", exif=upside_down.getexif())
    for photo in (upside_down, tmp_path / "b.jpg"):
        with pytest.raises(ValueError, match="upright by its EXIF"):
            stereo_map.open_pair(files[0], photo, camera=path)


def test_photos_of_different_size_each_have_their_own_centre(pair, easy):
    pixel, truth = easy
    cut = pair.right.grey[:250, :380]
    session = stereo_map.open_pair(pair.left.grey, cut, **CAMERA)
    point = stereo_map.measure(session, pixel, truth)
    assert point.accepted, point.why
    expected = (point.right - (379 / 2, 249 / 2)) * (0.005, -0.005)
    np.testing.assert_allclose(point.photo[1], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("tags", "c", "pixel_size"),
    [
        ({0x920A: 24.0, 0xA20E: 5080.0}, 24.0, 0.005),  # pixels an inch, as is usual
        ({0x920A: 24.0, 0xA20E: 5080.0, 0xA210: 2}, 24.0, 0.005),
        ({0x920A: 24.0, 0xA20E: 2000.0, 0xA210: 3}, 24.0, 0.005),  # a cm
        ({0x920A: 24.0, 0xA20E: 200.0, 0xA210: 4}, 24.0, 0.005),  # a mm
        ({0x920A: 24.0, 0xA20E: 0.2, 0xA210: 5}, 24.0, 0.005),  # a micrometre
        # a ratio of no unit says nothing
        ({0x920A: 4.0, 0xA20E: 2000.0, 0xA210: 1, 0xA405: 24}, 4.0, 0.0139712225),
        # as a phone says it
        ({0x920A: 4.0, 0xA405: 24}, 4.0, 43.2666 * 4 / 24 / np.hypot(420, 300)),
    ],
)
def test_exif_gives_the_camera_where_it_states_one(tmp_path, pair, tags, c, pixel_size):
    exif = Image.Exif()
    exif.get_ifd(0x8769).update(tags)
    Image.fromarray(pair.left.grey).save(tmp_path / "camera.jpg", exif=exif)
    photo = stereo_map.read_photo(tmp_path / "camera.jpg")
    assert photo.camera == Camera(c)
    assert photo.pixel_size == pytest.approx(pixel_size)
    assert stereo_map.exif_camera(pair.left.grey, (420, 300)) == (None, None)


def test_what_cannot_be_opened_is_named(pair, files, tmp_path):
    (tmp_path / "notes.jpg").write_text("no photo")
    tiny, same = np.zeros((15, 15)), np.ones((2, 6))
    grey = pair.left.grey, pair.right.grey
    for photos, how, error, words in (
        (files, {}, ValueError, "give camera=Camera.*pixel_size"),
        ((files[0], tmp_path / "gone.jpg"), CAMERA, FileNotFoundError,
         "right, .*gone.jpg: there is no such"),
        ((tmp_path / "notes.jpg", files[1]), CAMERA, ValueError,
         "left, .*notes.jpg: this is not an image"),
        ((pair.left, pair.right), CAMERA, ValueError, "left is a Photo"),
        (grey, CAMERA | {"exteriors": same}, ValueError,
         "both photos stand at the same place"),
        ((tiny, tiny), CAMERA, ValueError, "left must have at least 23 x 23"),
    ):  # fmt: skip
        with pytest.raises(error, match=words):
            stereo_map.open_pair(*photos, **how)


def test_pixels_without_data_are_no_grey_values(pair):
    grey = pair.left.grey.astype(float)
    grey[100:140, 60:110] = np.nan
    session = stereo_map.open_pair(grey, pair.right.grey, **CAMERA)
    assert np.isfinite(session.levels[0][0]).all()
    assert stereo_map.measure(session, (85, 120)).status == "no data in the template"
