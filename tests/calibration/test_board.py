"""The board: its points and drawing against OpenCV's, its file, and its page."""

import json
import re
import zlib

import cv2
import numpy as np
import pytest

from pgm_lab.calibration import board as boards
from pgm_lab.calibration.board import KINDS, Board, draw, screen, usual
from pgm_lab.plot.page import page as board_page


@pytest.mark.parametrize("size", [(13, 9), (8, 6)])
def test_a_charuco_board_is_that_of_opencv(size):
    """Its pattern pixel by pixel, and where its corners lie."""
    board = Board("charuco", *size, 15.0, 7.0)
    theirs = board.opencv()
    drawn = draw(board, 25.4)  # a pixel is a cell of a marker
    assert np.array_equal(drawn, theirs.generateImage(drawn.shape[::-1]))
    x, y = np.array(theirs.getChessboardCorners())[:, :2].T  # y down
    np.testing.assert_allclose(board.points[:, 0], x - 15)
    np.testing.assert_allclose(board.points[:, 1], 15 * (size[1] - 1) - y, atol=1e-5)


def test_tags_are_those_of_opencv():
    board = Board("apriltags", 4, 3, 10.0, 8.0)
    theirs = board.opencv()
    drawn = draw(board, 25.4)
    size = drawn.shape[1] - 4, drawn.shape[0] - 4
    inside = theirs.generateImage(size, marginSize=0)
    assert np.array_equal(drawn[2:-2, 2:-2], inside)
    points = np.concatenate([np.array(one) for one in theirs.getObjPoints()])
    np.testing.assert_allclose(board.points[:, 0], points[:, 0])
    np.testing.assert_allclose(board.points[:, 1], 28 - points[:, 1])


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_drawn_is_black_by_its_true_area(kind):
    """At 61 dpi no edge falls on a pixel's edge."""
    board = usual(kind)
    rectangles, circles = boards.ink(board)
    sides = rectangles[:, 2:] - rectangles[:, :2]
    area = np.prod(sides, 1).sum() + np.pi * (circles[:, 2] ** 2).sum()
    black = 1 - draw(board, 61) / 255.0
    assert black.sum() * (25.4 / 61) ** 2 == pytest.approx(area, rel=2e-3)


def test_the_letters_stand_clockwise_at_the_far_points():
    for kind in KINDS:
        board = usual(kind)
        A, B, C, D = board.points[list(board.letters.values()), :2]
        assert A[0] == D[0] == 0 and A[1] == B[1] == board.points[:, 1].max()
        assert C[1] == D[1] == 0 and B[0] == C[0]
        far = board.points[:, 0].max() - B[0]
        assert far == (board.square if kind == "asymmetric circles" else 0)


# --- The file ---


@pytest.mark.parametrize("kind", KINDS)
def test_a_board_is_read_as_it_was_saved(tmp_path, kind):
    board, path = usual(kind, square=12.5), tmp_path / "board.json"
    board.save(path)
    assert vars(Board.read(path)) == vars(board)
    with pytest.raises(FileExistsError):
        board.save(path)
    twice = board.scaled(25.0)
    np.testing.assert_allclose(twice.points, 2 * board.points)
    assert twice.bars[0][2] == 2 * board.bars[0][2]


GOOD = json.loads(usual().json())
BAR = {"points": [0, 11], "length": 220.0, "sd": 0.2}


@pytest.mark.parametrize(
    "wrong, message",
    [
        ({"kind": "chessboard"}, "kind must be one of 'charuco', 'chequerboard'"),
        ({"kind": None}, "missing 1 required positional argument: 'kind'"),
        ({"rows": 2}, "rows must be a whole number, at least 3; got 2"),
        ({"columns": 101}, "columns must be at most 100"),
        ({"square": -20}, r"square must be positive \(mm\); got -20"),
        ({"square": "20 mm"}, "square must be numbers; got '20 mm'"),
        ({"square": 10**400}, "square must be numbers"),
        ({"marker": 20.0}, "marker, 20 mm, must be smaller than square, 20 mm"),
        ({"dictionary": "5X5"}, "dictionary '5X5' is unknown to OpenCV"),
        ({"dictionary": "DICT_5X5_50"}, "needs 58 markers, DICT_5X5_50 has 50"),
        ({"kind": "chequerboard"}, "without marker or dictionary; leave it out"),
        ({"sqare": 20.0}, "unexpected keyword argument 'sqare'"),
        ({"bars": [BAR | {"length": 22}]}, "22 mm between points 0 and 11, which lie"),
        ({"bars": [BAR | {"points": [0, 96]}]}, "bar 1, point must be at most 95"),
        ({"bars": [BAR | {"points": [0, 0]}]}, "points 0 and 0, which lie 0 mm apart"),
        ({"bars": [BAR | {"points": [0]}]}, "not enough values to unpack"),
        ({"bars": [BAR | {"sd": 0}]}, "bar 1, sd must be positive"),
        ({"bars": [{"points": [0, 11]}]}, "'length'"),
        ({"bars": "A to B"}, "this is no board.json"),
    ],
)
def test_a_file_that_is_wrong_is_refused_in_a_sentence(tmp_path, wrong, message):
    given = {k: v for k, v in (GOOD | wrong).items() if v is not None}
    refused(tmp_path, json.dumps(given), message)


@pytest.mark.parametrize("text", ["[]", "7", "{", "\xff\x00", "[" * 10**5, "[[1, 2]]"])
def test_what_is_no_board_is_said_to_be_none(tmp_path, text):
    refused(tmp_path, text, "this is no board.json")


def refused(folder, text, message):
    path = folder / "board.json"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(ValueError, match=message) as error:
        Board.read(path)
    assert str(error.value).startswith(str(path)) and "\n" not in str(error.value)


# --- The page ---


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "paper, size",
    [
        ("A4", (297, 210)),
        pytest.param("A3", (420, 297), marks=pytest.mark.slow),
    ],
)
def test_the_page_has_its_true_size_and_so_has_the_board(kind, paper, size):
    """The media box, and the black shapes of the page, in points of 1/72 inch."""
    board = usual(kind, paper)
    pdf = board_page(board, paper)
    assert pdf == board_page(board, paper)
    (box,) = re.findall(rb"/MediaBox \[([^]]+)\]", pdf)
    media = np.array(box.split(), float)[2:] * 25.4 / 72
    np.testing.assert_allclose(media, size, atol=0.01)
    black = sorted(_filled(pdf), key=len)[-2:]  # but for the letters
    ruler, drawn = sorted((np.ptp(path, axis=0) for path in black), key=np.prod)
    np.testing.assert_allclose(ruler, (100.1, 6), atol=0.01)
    np.testing.assert_allclose(drawn, _extent(board), atol=0.01)


def _filled(pdf):
    """Points (n, 2) in mm of each path that the page fills, its control points too."""
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL):
        try:
            text = zlib.decompress(stream)
        except zlib.error:
            continue
        for path in text.split(b"\nf\n") if b" cs\n" in text else ():
            lines = re.findall(rb"^([-\d. ]+) [mlc]$", path, re.MULTILINE)
            if lines:
                numbers = np.concatenate([np.array(n.split(), float) for n in lines])
                yield numbers.reshape(-1, 2) * 25.4 / 72


def _extent(board):
    """Width and height of what is black."""
    rectangles, circles = boards.ink(board)
    x, y, r = circles.T
    low = np.concatenate([rectangles[:, :2], np.stack([x - r, y - r], 1)]).min(0)
    high = np.concatenate([rectangles[:, 2:], np.stack([x + r, y + r], 1)]).max(0)
    return high - low


@pytest.mark.parametrize("kind", KINDS)
def test_on_a_screen_all_squares_are_whole_pixels(kind):
    board, png = screen(usual(kind), (1280, 720))
    page = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_UNCHANGED)
    assert page.shape == (720, 1280)
    side = board.square * 96 / 25.4
    assert side == pytest.approx(round(side)) and board.bars == ()
    if kind == "chequerboard":
        assert set(np.unique(page)) == {0, 255}
    with pytest.raises(ValueError, match="too small for"):
        screen(usual(kind), (100, 100))
