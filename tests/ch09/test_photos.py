"""The photos of lesson 9: corners as they are measured, turned photos, a folder."""

import dataclasses
import shutil
from functools import partial
from unittest import mock

import cv2
import matplotlib.pyplot as plt
import nbformat
import numpy as np
import pytest

from pgm_book.ch09 import photos
from pgm_book.make.notebooks import FOLDER
from pgm_book.make.student import tags
from pgm_book.program import lsm
from pgm_book.program.bundle import without_lens
from pgm_book.program.camera import project
from pgm_lab import calibration, datasets, frames, ncc
from pgm_lab.image import cut

NONE = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("camera", ["left", "right"])
def test_the_table_of_corners_is_what_the_photos_give(camera):
    data = datasets.chequerboard(camera)
    for k in (1, 8):  # one of them upside down; all of them in the slow test
        found = photos.corners(data.photos[k], *data.corners)
        np.testing.assert_allclose(found, data.pixels[k], atol=0.002)


@pytest.mark.slow
def test_all_corners_of_the_table_are_what_the_photos_give():
    for camera in ("left", "right"):
        data = datasets.chequerboard(camera)
        found = [photos.corners(path, *data.corners) for path in data.photos]
        np.testing.assert_allclose(found, data.pixels, atol=0.002)


def test_another_camera_is_refused():
    with pytest.raises(ValueError, match="camera must be"):
        datasets.chequerboard("middle")


def test_start_values_are_near_what_the_lesson_finds():
    seen = photos.board()[0]
    camera, exteriors = seen.start
    assert 0.5 < camera[0] < 0.6 and np.all(camera[1:] == 0)
    for one, exterior in zip(seen.pixels, exteriors):
        off = project(exterior, seen.grid, camera[0]) / photos.PIXEL[0]
        xy = frames.pixel_to_photo(one, seen.size, photos.PIXEL) / photos.PIXEL[0]
        assert np.sqrt(np.mean((off - xy) ** 2)) < 5  # px, with all distortion
    turned = dataclasses.replace(seen, grid=photos.grid(6, 9))
    with pytest.raises(ValueError, match="the grid does not fit the corners"):
        _ = turned.start


def test_photos_that_are_not_turned_are_the_benchmark_s():
    """The same grey values, moved to where the principal point is in the middle."""
    pair, scene = photos.pair(NONE), datasets.motorcycle()
    middle = np.subtract(photos.SIZE, 1) / 2
    for k, (ours, theirs) in enumerate(
        ((pair.left, scene.left), (pair.right, scene.right))
    ):
        shift = np.add(photos.PRINCIPAL, (k * scene.doffs, 0)) - middle
        column, row = np.round(np.add((300, 200), shift)).astype(int)
        one, other = cut(ours, (300, 200), 61), cut(theirs, (column, row), 61)
        assert ncc.correlation(one, other) > 0.95


@pytest.mark.parametrize("turned", [photos.TURNED, NONE])
def test_the_truth_projects_to_where_the_right_photo_shows_it(turned):
    """By the true orientation and the true points, as windows that look alike."""
    pair = photos.pair(turned)
    points = np.array([(181, 220), (222, 229), (281, 259), (346, 239), (376, 182)])
    e = pair.exterior.copy()
    e[:3] *= 0.193001 / np.linalg.norm(e[:3])
    xy = project(e, pair.truth(points), pair.c)
    there = frames.photo_to_pixel(xy, pair.size, photos.PIXEL)
    r = [
        ncc.correlation(
            cut(pair.left, p, 15), cut(pair.right, np.round(q).astype(int), 15)
        )
        for p, q in zip(points, there)
    ]
    assert np.median(r) > 0.75
    assert np.isnan(
        photos.Pair(*[np.zeros((9, 9))] * 2, 1, points[:2], 1, (1, 2)).exterior
    ).all()


def test_a_measured_point_has_the_distortion_that_is_removed():
    camera = np.array([0.53, 0.006, -0.004, -0.8, 1, 0, 0.002, -0.001, 3e-4, -2e-4])
    ideal = np.random.default_rng(3).uniform(-0.3, 0.3, (40, 2))
    back = without_lens(photos.measured(ideal, camera), camera)
    np.testing.assert_allclose(back, ideal, atol=1e-9)


@pytest.fixture
def folder(tmp_path):
    """A reader's folder: the built-in photos, as if somebody had taken them."""
    (tmp_path / "board").mkdir()
    for path in datasets.chequerboard("left").photos[:9]:
        shutil.copy(path, tmp_path / "board")
    blank = np.full((480, 640), 128, np.uint8)
    cv2.imwrite(str(tmp_path / "board" / "zz.png"), blank)
    calibration.Board("chequerboard", 10, 7, 30.0).save(tmp_path / "board.json")
    pair = photos.pair()
    for name in ("left", "right"):
        cv2.imwrite(str(tmp_path / f"{name}.png"), getattr(pair, name).astype(np.uint8))
    return tmp_path


@pytest.mark.slow
def test_a_folder_of_one_s_own_goes_the_same_way(folder, capsys):
    odd, even = photos.board(folder)
    assert "zz.png is left out: " in capsys.readouterr().out
    assert (len(odd.pixels), len(even.pixels)) == (5, 4) and odd.size == (640, 480)
    left = photos.board()[0]
    np.testing.assert_allclose(odd.pixels, left.pixels[:9:2], atol=0.002)
    np.testing.assert_allclose(np.ptp(odd.grid, axis=0), np.ptp(left.grid, axis=0))
    built_in = photos.pair()
    camera = np.array([built_in.c, *np.zeros(9)])
    own = photos.own_pair(folder, camera, built_in.ends, 1.0, (2, 5))
    np.testing.assert_allclose(own.left, built_in.left, atol=1)
    assert np.isnan(own.truth(built_in.ends)).all() and own.c == built_in.c
    with pytest.raises(ValueError, match="do not lie in the left photo"):
        photos.own_pair(folder, camera, 9 * built_in.ends, 1.0, (2, 5))
    (folder / "right.png").unlink()
    with pytest.raises(FileNotFoundError, match="there is no right.jpg"):
        photos.own_pair(folder, camera, built_in.ends, 1.0, (2, 5))
    for path in sorted((folder / "board").glob("*.jpg"))[3:]:
        path.unlink()
    with pytest.raises(ValueError, match="3 of 4 photos show the board"):
        photos.board(folder)


def test_a_large_photo_is_reduced_and_its_corners_with_it(tmp_path):
    grey = cv2.resize(
        photos.read(datasets.chequerboard("left").photos[0]), None, fx=3, fy=3
    )
    cv2.imwrite(str(tmp_path / "large.png"), grey)
    assert photos.read(tmp_path / "large.png").shape[1] == photos.MOST
    middle = (np.array(grey.shape[::-1]) - 1) / 2
    there = photos._reduced(middle[None], grey.shape[::-1])[0]
    np.testing.assert_allclose(there, (499.5, 374.5), atol=0.01)
    (tmp_path / "large.png").write_text("no photo")
    with pytest.raises(ValueError, match="cannot be read as a photo"):
        photos.read(tmp_path / "large.png")


def test_matches_lie_where_the_truth_says_and_what_fails_is_left_out():
    scene = photos.pair()
    points = [*scene.ends, (3, 3)]  # the last window leaves the photo
    found = photos.matches(scene, points, ncc.correlation_map, lsm.match)
    np.testing.assert_array_equal(found[:, :2], scene.ends)
    right = scene.exterior.copy()
    right[:3] *= datasets.motorcycle().baseline / 1000 / np.linalg.norm(right[:3])
    xy = project(right, scene.truth(found[:, :2]), scene.c)
    there = frames.photo_to_pixel(xy, scene.size, photos.PIXEL)
    assert np.abs(found[:, 2:] - there).max() < 0.5


def test_the_scatter_of_neighbours_is_the_noise_of_a_sloping_surface():
    x, y = np.meshgrid(np.arange(0, 600, 10), np.arange(0, 400, 10))
    places = np.column_stack([x.ravel(), y.ravel()])
    noise = np.random.default_rng(9).normal(0, 0.3, len(places))
    noise[::20] = np.nan  # no match
    found = photos.scatter(places, 40 + 0.1 * places[:, 0] + noise)
    assert abs(found / 0.3 - 1) < 0.06  # 1700 triples, which overlap


def test_a_file_of_points_is_read_as_any_program_reads_it():
    points = np.array([(0.12344, -1, -2.5), (3, 4, -5.00006)])
    text = photos.ply(points, np.array([7.0, 255]))
    assert "element vertex 2" in text
    back = np.loadtxt(text.splitlines(), skiprows=10)
    np.testing.assert_allclose(back[:, :3], points, atol=0.00005)
    assert back[:, 3:].tolist() == [[7] * 3, [255] * 3]


def measured(turned):
    """Run the lesson's cells up to the depths; return errors over sds, of both."""
    notebook = nbformat.read(FOLDER / "09_your_camera.ipynb", as_version=4)
    space = {"__name__": "__main__"}
    left_out = {"draw", "check", "claims", "task", "predict"}
    with (
        mock.patch.object(photos, "pair", partial(photos.pair, turned)),
        mock.patch.object(plt, "show"),
        plt.rc_context(),
    ):
        for cell in notebook.cells:
            skipped = left_out & set(tags(cell)) or "held = [" in cell.source
            if cell.cell_type == "code" and not skipped:
                exec(compile(cell.source, "lesson 9", "exec"), space)
                plt.close("all")
            if "depth_sd =" in cell.source:
                break
    Z, N, c = space["surface"][:, 2], space["N"], space["scene"].c
    xy = np.insert(space["left_xy"], 2, -c, axis=1) @ N
    at = frames.photo_to_pixel(-c * xy[:, :2] / xy[:, 2:], photos.SIZE, photos.PIXEL)
    depths = (Z - (photos.truth(at, turned) @ N.T)[:, 2]) / space["depth_sd"]
    orientation = (space["exterior"] - photos.exterior(turned))[1:] / space["sd"]
    return orientation, depths[np.isfinite(depths)]


@pytest.mark.slow
def test_errors_of_orientation_and_depths_are_as_large_as_predicted():
    """For photos turned in several ways, by the cells of the lesson."""
    chance = np.random.RandomState(1)
    off, typical = [], []
    for _ in range(6):
        turn = chance.uniform(-1.5, 1.5, (2, 3)) * (0.8, 1, 1.6)
        turn += [(0, -1.8, 0), (0, -0.2, 0)]
        orientation, depths = measured(tuple(map(tuple, turn)))
        off.append(orientation)
        typical.append(np.median(np.abs(depths)) / 0.6745)
    assert np.abs(off).max() < 3
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 1.6
    # Each pair has one error of its orientation, which all of its depths share
    assert 0.8 < np.sqrt(np.mean(np.square(typical))) < 1.25
