"""Files of photos: as the sensor saw them, with what EXIF says."""

import numpy as np
import pytest
from PIL import Image

from pgm_lab import camera, frames
from pgm_lab.calibration import Board, measure, pixel_size
from pgm_lab.calibration.measure import _eccentricity
from pgm_lab.simulate import boards
from tests.calibration import rendered

ORIENTATION, MAKE, MODEL, MORE, FOCAL, FOCAL_35 = 274, 271, 272, 0x8769, 0x920A, 0xA405


def exif(orientation=1, focal=4.2, focal_35=26):
    one = Image.Exif()
    one[ORIENTATION], one[MAKE], one[MODEL] = orientation, "Acme\0", "Phone 9"
    more = one.get_ifd(MORE)
    more[FOCAL], more[FOCAL_35] = focal, focal_35
    return one


@pytest.mark.slow
def test_a_photo_held_upright_is_read_as_the_sensor_saw_it(tmp_path):
    grey = rendered.scene()[1][0].grey
    found = []
    for orientation in (1, 3, 6, 8):
        path = tmp_path / f"{orientation}.png"
        Image.fromarray(grey).save(path, exif=exif(orientation))
        found.append(measure(path, rendered.BOARD))
    for one in found:
        assert one.image_size == rendered.SIZE
        assert one.model == ("Acme", "Phone 9") and one.focal == pytest.approx(4.2)
        np.testing.assert_allclose(one.pixels, found[0].pixels, atol=1e-9)
    assert found[0].name == "1.png"


@pytest.mark.slow
def test_a_photo_as_iphones_save_it_is_read(tmp_path):
    heif = pytest.importorskip("pillow_heif")
    grey = rendered.scene()[1][0].grey
    path = tmp_path / "IMG_1.HEIC"
    upright = np.ascontiguousarray(np.rot90(grey, -1))
    heif.from_pillow(Image.fromarray(upright).convert("RGB")).save(path, quality=95)
    assert measure(path, rendered.BOARD).image_size == rendered.SIZE[::-1]


def test_heic_without_its_reader_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pillow_heif", None)
    path = tmp_path / "IMG_1.HEIC"
    path.write_bytes(b"\0\0\0\x18ftypheic" + bytes(100))
    with pytest.raises(ValueError, match="HEIC .*pip install pillow-heif.* or save"):
        measure(path, rendered.BOARD)


@pytest.mark.slow
def test_the_size_of_a_pixel_follows_from_two_focal_lengths():
    one = rendered.scene()[2][0]
    assert pixel_size([one]) is None
    known = one.__class__(**{**vars(one), "focal": 4.2, "focal_35": 28.0})
    diagonal = np.hypot(36, 24) * 4.2 / 28
    assert pixel_size([one, known]) == pytest.approx(diagonal / 600)  # 480 x 360


def test_a_photo_without_a_board_says_so():
    found = measure(np.full((300, 400), 99, np.uint8), rendered.BOARD, "wall")
    assert found.words.startswith("no marker is seen") and found.name == "wall"
    assert len(found.ids) == 0 and found.image_size == (400, 300)


def test_the_centre_of_an_ellipse_is_not_that_of_its_circle():
    """Against points around circles, imaged: their ellipse's centre."""
    board = Board("circles", 7, 5, 25.0, 15.0)
    lens, exterior = camera.Camera(4.0), boards.view(board, 260.0, 40.0, 30.0)
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    around = 7.5 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)

    def seen(points):
        xy = camera.project(lens, exterior, points)
        return frames.photo_to_pixel(xy, (640, 480), 0.01)

    centres = []
    for ring in seen(board.points[:, None] + around):
        x, y = (ring - ring.mean(axis=0)).T
        A = np.stack([x * x, x * y, y * y, x, y], axis=1)
        a, b, c, d, e = np.linalg.lstsq(A, np.ones(400), rcond=None)[0]
        centre = np.linalg.solve([[2 * a, b], [b, 2 * c]], [-d, -e])
        centres.append(ring.mean(axis=0) + centre)
    ids, centres = np.arange(35), np.array(centres)
    moved = centres - _eccentricity(board, ids, centres)
    assert np.abs(centres - seen(board.points)).max() > 0.2
    np.testing.assert_allclose(moved, seen(board.points), atol=0.02)
