"""Corners and a camera beside OpenCV's, `make benchmark`.

OpenCV has no covariance of its corners, one weight for all, and no search for blunders.
"""

import cv2
import numpy as np
import pytest

from pgm_lab.calibration import calibrate, refine
from tests.calibration import rendered

UNTIL = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)


@pytest.fixture(scope="module")
def seen():
    one = rendered.scene()[1][0]
    return one.grey, one.pixels[one.inside]


@pytest.mark.benchmark(group="48 corners in a photo")
def test_corners_by_least_squares(benchmark, seen):
    found = benchmark(refine, *seen, 9.0)
    assert np.nanmedian(np.abs(found.pixels - seen[1])) < 0.01


@pytest.mark.benchmark(group="48 corners in a photo")
def test_corners_by_opencv(benchmark, seen):
    grey, near = seen
    start = near[:, None].astype("f4")
    given = (6, 6), (-1, -1), UNTIL
    found = benchmark(lambda: cv2.cornerSubPix(grey, start.copy(), *given))
    assert np.median(np.abs(found[:, 0] - near)) < 0.05


@pytest.mark.benchmark(group="A camera from 10 photos")
def test_a_camera_with_the_board_free(benchmark):
    photos = rendered.scene()[2]
    found = benchmark(calibrate, photos, rendered.BOARD, pixel_size=0.01)
    truth = rendered.scene()[0]
    assert found.camera.c == pytest.approx(truth.c, rel=1e-3)


@pytest.mark.benchmark(group="A camera from 10 photos")
def test_a_camera_by_opencv_with_a_flat_board(benchmark):
    photos, board = rendered.scene()[2], rendered.BOARD
    points = [(board.points[one.ids] * (1, -1, -1)).astype("f4") for one in photos]
    pixels = [one.pixels[:, None].astype("f4") for one in photos]
    given = points, pixels, rendered.SIZE, None, None
    found = benchmark(lambda: cv2.calibrateCamera(*given, criteria=UNTIL))
    assert found[0] > 0.1  # px: the board is bent
