"""OpenCV's 26 photos of one board, by two cameras of a rig: what is bent, and how far.

The two cameras took them at the same 13 moments. What both find is the board's.
"""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pgm_lab import bundle, datasets, frames, orientation, rotation
from pgm_lab.calibration import Board, calibrate, measure, refine, solve
from pgm_lab.camera import Camera, files

BOARD = Board("chequerboard", 10, 7, 1.0)
SIZE, PIXEL = (640, 480), 0.001
SIDES = "left", "right"


@pytest.fixture(scope="module")
def photos():
    """What is measured in the photos of both cameras."""
    return {
        side: [measure(path, BOARD) for path in datasets.chequerboard(side).photos]
        for side in SIDES
    }


@pytest.fixture(scope="module")
def found(photos):
    return {side: calibrate(photos[side], BOARD) for side in SIDES}


@pytest.mark.slow
def test_two_cameras_find_the_same_shape_of_the_board_and_it_is_not_flat(found):
    left, right = (found[side] for side in SIDES)
    for axis in range(3):
        r = np.corrcoef(left.shape[:, axis], right.shape[:, axis])[0, 1]
        assert r > 0.95
    # They differ by no more than is predicted
    ratio = (left.shape - right.shape) / np.hypot(left.sd_shape, right.sd_shape)
    assert 0.5 < np.sqrt(np.mean(ratio**2)) < 1.1
    assert np.abs(left.shape[:, 2] / left.sd_shape[:, 2]).max() > 5


@pytest.mark.slow
def test_halves_say_that_photos_have_errors_of_their_own(found):
    """The residuals alone predict half of what two cameras from halves differ by."""
    for one in found.values():
        assert 1.5 < one.factor[0] < 3.5


@pytest.mark.slow
def test_a_flat_board_shifts_c_by_more_than_its_standard_deviation(found):
    for one in found.values():
        off = (one.flat.cameras[0].c - one.camera.c) / np.sqrt(one.covariance[0, 0])
        assert off < -3
        assert one.flat.sigma0 > 2.5 * one.result.sigma0


def of_opencv(photos):
    """OpenCV's camera: the board flat, one weight for all."""
    points = [(BOARD.points[one.ids] * (1, -1, -1)).astype("f4") for one in photos]
    pixels = [one.pixels[:, None].astype("f4") for one in photos]
    flags = cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_USE_INTRINSIC_GUESS
    start = np.array([[530.0, 0, 320], [0, 530, 240], [0, 0, 1]])
    given = points, pixels, SIZE, start, np.zeros(5)
    _, K, k, *_ = cv2.calibrateCamera(*given, flags=flags)
    return files.from_opencv(K, k, SIZE, PIXEL)


@pytest.mark.slow
def test_photos_that_took_no_part_are_predicted_better_by_a_free_board(photos):
    left_over = {"free": [], "flat": [], "OpenCV": []}
    for side, part in ((side, part) for side in SIDES for part in (0, 1)):
        own, others = photos[side][part::2], photos[side][1 - part :: 2]
        free, flat = (calibrate(own, BOARD, flat=one) for one in (False, True))
        places = {
            "free": dict(zip(free.result.network.point_names, free.result.points)),
            "flat": dict(enumerate(BOARD.points)),
        }
        models = {
            "free": (free.camera, places["free"]),
            "flat": (flat.camera, places["flat"]),
            "OpenCV": (of_opencv(own), places["flat"]),
        }
        for photo in others:
            xy = frames.pixel_to_photo(photo.pixels, SIZE, PIXEL)
            for name, (camera, board) in models.items():
                there = np.array([board[i] for i in photo.ids])
                v = orientation.resect(camera, xy, there).residuals
                left_over[name].append(np.sqrt(np.mean(v**2)) / PIXEL)
    free, flat, theirs = (np.array(one) for one in left_over.values())
    for other in (flat, theirs):
        assert np.mean(free < other) > 0.8
        assert np.median(free) < 0.8 * np.median(other)


@pytest.mark.slow
def test_the_rig_is_one_rig_in_all_pairs(found):
    """The right camera in the frame of the left one, thirteen times."""
    spread = {}
    for flat in (True, False):
        base, angles = [], []
        sides = [found[side].flat if flat else found[side].result for side in SIDES]
        for k, (one, other) in enumerate(zip(*(side.exteriors for side in sides))):
            names = [side.network.photo_names[k] for side in sides]
            assert names[0][-6:] == names[1][-6:]
            M, N = (rotation.matrix(*exterior[3:]) for exterior in (one, other))
            base.append(M @ (other[:3] - one[:3]))
            angles.append(rotation.angles(N @ M.T))
        spread[flat] = np.std(base, axis=0), np.std(angles, axis=0)
    # In squares and radians; the base is 3.3 squares long
    assert np.all(spread[False][0] < 0.02)
    assert np.linalg.norm(spread[False][0]) < np.linalg.norm(spread[True][0])
    assert np.linalg.norm(spread[False][1]) < 1.1 * np.linalg.norm(spread[True][1])


@pytest.mark.slow
def test_another_finder_of_corners_finds_the_same_shape(photos, found):
    """OpenCV's, with errors of its own that are three times as large."""
    until = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-4)
    theirs = []
    paths = datasets.chequerboard("left").photos
    for path, one in zip(paths, photos["left"]):
        grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        near = one.pixels[:, None].astype("f4")
        pixels = cv2.cornerSubPix(grey, near, (5, 5), (-1, -1), until)[:, 0]
        theirs.append(replace(one, pixels=pixels.astype(float)))
    other = calibrate(theirs, BOARD)
    for axis in (0, 2):
        r = np.corrcoef(other.shape[:, axis], found["left"].shape[:, axis])[0, 1]
        assert r > 0.85
    assert other.covariance[0, 0] > found["left"].covariance[0, 0]


@pytest.mark.slow
def test_a_free_board_is_that_of_opencv_with_one_weight(photos):
    """calibrateCameraRO (Strobl and Hirzinger 2011): the same model and corners."""
    every = set.intersection(*(set(one.ids.tolist()) for one in photos["left"]))
    ids = np.array(sorted(every))
    some = [
        replace(
            one,
            ids=ids,
            pixels=one.pixels[np.searchsorted(one.ids, ids)].astype("f4").astype(float),
            covariance=one.covariance[np.searchsorted(one.ids, ids)],
        )
        for one in photos["left"]
    ]
    points = [(BOARD.points[ids] * (1, -1, -1)).astype("f4")] * len(some)
    pixels = [one.pixels[:, None].astype("f4") for one in some]
    until = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 300, 1e-15)
    flags = cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_USE_INTRINSIC_GUESS
    # OpenCV 5's faster way refuses free boards; its flag turns on a tilted sensor, too
    flags |= getattr(cv2, "CALIB_DISABLE_SCHUR_COMPLEMENT", 0)
    flags |= cv2.CALIB_FIX_TAUX_TAUY
    start = np.array([[530.0, 0, 320], [0, 530, 240], [0, 0, 1]])
    # It holds three corners of the first and last row: a datum
    _, K, k, *_ = cv2.calibrateCameraRO(
        points, pixels, SIZE, 8, start, np.zeros(5), flags=flags, criteria=until
    )
    lens = Camera(0.53, lens="forward")
    stations = [solve._start_exterior(one, BOARD, lens, PIXEL) for one in some]
    network = solve._network(some, BOARD, lens, np.array(stations), PIXEL, False)
    sigma = np.full_like(network.xy, 1e-4)
    network = replace(network, sigma=sigma, covariance=None)
    ours = bundle.adjust(network, solve.SQUARE, tolerance=1e-10)
    theirs = files.from_opencv(K, k.ravel()[:5], SIZE, PIXEL).interior[:8]
    np.testing.assert_allclose(ours.interior, theirs, rtol=1e-4)
    assert ours.interior[0] == pytest.approx(theirs[0], rel=1e-6)


def test_corners_are_measured_alike_from_wherever_one_starts(photos):
    path = datasets.chequerboard("left").photos[0]
    grey = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    pixels = photos["left"][0].pixels
    rng = np.random.default_rng(1)
    again = refine(grey, pixels + rng.uniform(-1.5, 1.5, pixels.shape), 9.0)
    same = refine(grey, pixels, 9.0)
    np.testing.assert_allclose(again.pixels, same.pixels, atol=0.001)
