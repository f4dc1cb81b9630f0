"""Detection in rendered photos with known truth, and in one page as it is printed."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pgm_lab.calibration.board import KINDS, Board, draw, usual
from pgm_lab.calibration.detect import LEAST, _regular, detect
from pgm_lab.camera import Camera
from pgm_lab.simulate.boards import photograph, view

PHONE = Camera(4.2, x0=0.05, K1=-0.008, K2=5e-4, P1=1e-4, lens="forward")
# From the front, slanted, turned by 90 and 180 degrees: distance, tilt, azimuth, roll
VIEWS = [(300, 0, 0, 0), (330, 35, 60, 20), (420, 45, 200, 91), (350, 30, 300, 180)]


def bent(x, y):
    return 2 * np.sin(x / 80) * np.cos(y / 60)


def seen(board, at=VIEWS[1], size=(1280, 960), **more):
    """A photo of a board that is bent by 2 mm, with noise and a gradient of light."""
    how = {"shape": bent, "noise": 3, "light": 0.4, "rng": np.random.default_rng(1)}
    width = 5.6 / size[0]
    return photograph(board, PHONE, view(board, *at), size, width, **(how | more))


@pytest.mark.parametrize(
    "at",
    [
        VIEWS[1],
        *(pytest.param(v, marks=pytest.mark.slow) for v in VIEWS if v != VIEWS[1]),
    ],
)
@pytest.mark.parametrize("kind", KINDS)
def test_all_points_of_each_kind_are_found_to_a_pixel(kind, at):
    """From any side, with the right ids; from the upper end where none can be told."""
    board = usual(kind)
    photo = seen(board, at)
    found = detect(photo.grey, board)
    assert found.reason == "" and len(found.ids) == len(board.points)
    true = photo.pixels[found.ids]
    if board.symmetric and at[3] > 90:
        true = true[::-1]
    assert np.abs(found.pixels - true).max() < 1


@pytest.mark.parametrize("stretch", [256, 0.5])
def test_sixteen_bits_of_any_range_show_the_same(stretch):
    board = usual()
    photo = seen(board)
    found = detect((photo.grey * np.float64(stretch) + 100).astype(np.uint16), board)
    assert len(found.ids) == 96
    assert np.abs(found.pixels - photo.pixels).max() < 1


@pytest.mark.slow
@pytest.mark.parametrize("size", [(2400, 1800), (4000, 3000)])
def test_a_large_photo_is_taken_up_at_full_size(size):
    """Also where the board is so small that the first copy loses it."""
    for kind, distance in (("charuco", 1000), ("apriltags", 330)):
        board = usual(kind)
        photo = seen(board, (distance, 35, 60, 20), size, noise=0)
        found = detect(photo.grey, board)
        assert len(found.ids) == len(board.points)
        assert np.abs(found.pixels - photo.pixels).max() < 0.5


@pytest.mark.parametrize("kind", ["charuco", "apriltags"])
def test_a_coded_board_may_be_partly_hidden(kind):
    """A tag that is cut a little is still read: its corner is what is left of it."""
    photo = seen(usual(kind))
    grey = photo.grey.copy()
    grey[250:550, 550:] = 120
    found = detect(grey, usual(kind))
    assert LEAST < len(found.ids) < len(photo.pixels)
    off = np.abs(found.pixels - photo.pixels[found.ids]).max(axis=1)
    assert np.mean(off < 1) > 0.97


CHEQUER = usual("chequerboard")
NONE = "is seen: no board, another one, mirrored"


@pytest.mark.parametrize(
    "shown, given, reason",
    [
        (usual(), Board("charuco", 12, 8, 20.0), "58 markers that are seen do not lie"),
        (usual(), Board("charuco", 14, 9, 20.0), "do not lie as on one of 14 x 9"),
        *(
            pytest.param(
                usual(),
                Board("charuco", *size, 20.0),
                "do not lie",
                marks=pytest.mark.slow,
            )
            for size in ((9, 13), (13, 7))
        ),
        (usual("apriltags"), Board("apriltags", 5, 8, 30.0), "as on one of 5 x 8"),
        (usual(), replace(usual(), dictionary="DICT_4X4_100"), NONE),
        (usual("circles"), usual(), NONE),
        (
            CHEQUER,
            Board("chequerboard", 5, 4, 25.0),
            "are not seen, but 11 x 8: another board, or its file does not count",
        ),
        (CHEQUER, usual("circles"), "the 12 x 9 circles are not seen: no board"),
    ],
)
def test_another_board_than_the_file_says_is_named(shown, given, reason):
    found = detect(seen(shown).grey, given)
    assert reason in found.reason and not len(found.ids)


def test_what_shows_no_board_gets_a_reason():
    photo = seen(usual()).grey
    hidden = photo.copy()
    hidden[:, 450:] = 120
    hidden[450:] = 120
    part = seen(CHEQUER).grey
    part[:, 700:] = 120
    for grey, board, reason in [
        (photo[:, ::-1], usual(), NONE),
        (hidden, usual(), "too few points"),
        (np.full((480, 640), 90), usual(), NONE),
        (
            part,
            CHEQUER,
            "11 x 8 inner corners are not seen: no board, another one, not",
        ),
    ]:
        assert reason in detect(grey, board).reason


def test_a_point_with_the_id_of_another_is_noticed():
    board = usual()
    pixels = seen(board).pixels
    pixels[[40, 70]] = pixels[[70, 40]]
    good = _regular(np.arange(96), pixels, board)
    assert not good[40] and not good[70] and good.sum() > 75


def test_the_symmetry_of_a_board_is_that_of_its_picture():
    """Rotated by 180 degrees, it looks the same or it does not."""
    for board in [usual(kind) for kind in KINDS] + [
        Board("chequerboard", 12, 10, 20.0),
        Board("asymmetric circles", 7, 10, 15.0),
    ]:
        drawn = draw(board, 50)
        x, y, width, height = cv2.boundingRect(255 - drawn)
        black = drawn[y : y + height, x : x + width].astype(float)
        same = np.abs(black - black[::-1, ::-1]).mean() < 10
        assert same == board.symmetric, (board.kind, board.columns, board.rows)
