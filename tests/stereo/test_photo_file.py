"""A photo file whose camera is a camera.json: its pixel size, and what does not fit."""

import numpy as np
import pytest
from PIL import Image

from pgm_lab import stereo
from pgm_lab.camera import Camera, files

LENS = Camera(4.2, 0.01, K1=1e-3, lens="forward")
STATION = (1.0, 2.0, 30.0, 0.01, 0.0, 0.3)


@pytest.fixture
def lens(tmp_path):
    files.CameraFile(LENS, (60, 40), 0.05).save(tmp_path / "camera.json")
    return tmp_path / "camera.json"


def photo(folder, columns, rows, held=1):
    exif = Image.Exif()
    exif[0x0112] = held
    Image.new("L", (columns, rows), 7).save(folder / "a.jpg", exif=exif)
    return folder / "a.jpg"


def test_camera_and_pixel_size_come_from_the_file(tmp_path, lens):
    plain = stereo.PhotoFile(photo(tmp_path, 60, 40), LENS, STATION, 0.05)
    for path in (lens, str(lens)):
        found = stereo.PhotoFile(plain.path, camera=path, exterior=STATION)
        assert (found.camera, found.pixel_size) == (LENS, 0.05)
        assert found.fingerprint() == plain.fingerprint()
    ground = [(1.5, 2.0, 0.0)]
    np.testing.assert_array_equal(
        found.read().project(ground), plain.read().project(ground)
    )


def test_a_part_of_the_sensor_has_the_camera_of_the_whole(tmp_path, lens):
    np.save(tmp_path / "a.npy", np.zeros((10, 20), np.uint8))
    given = tmp_path / "a.npy", lens, STATION
    part = stereo.PhotoFile(*given, image_size=(60, 40), corner=(40, 30))
    assert part.read().sensor == (60, 40)
    with pytest.raises(ValueError, match=r"20 x 10 pixels.*60 x 40.*reduced or crop"):
        stereo.PhotoFile(*given)


@pytest.mark.parametrize(
    "taken, more, words",
    [
        ((40, 60), {}, r"a\.jpg has 40 x 60 .*json 60 x 40,.*was it turned.*its EXIF"),
        ((60, 40, 6), {}, "turned upright by its EXIF"),
        ((60, 40, 3), {}, "turned upright by its EXIF"),
        ((30, 20), {}, "has 30 x 20 pixels.*reduced or cropped"),
        ((60, 40), {"pixel_size": 0.06}, r"pixel_size is 0\.06, .* has 0\.05 mm"),
    ],
)
def test_a_photo_of_another_size_is_refused(tmp_path, lens, taken, more, words):
    with pytest.raises(ValueError, match=words):
        stereo.PhotoFile(photo(tmp_path, *taken), lens, STATION, **more)


def test_a_camera_alone_has_no_pixel_size(tmp_path):
    with pytest.raises(ValueError, match="pixel_size is missing"):
        stereo.PhotoFile(photo(tmp_path, 60, 40), LENS, STATION)
