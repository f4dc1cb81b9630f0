"""Stereo plotting in loops equals the functions that do it for all pixels at once."""

import numpy as np
import pytest
from scipy import ndimage

from pgm_book.program import stereo as program
from pgm_lab import epipolar, rotation, simulate, stereo
from pgm_lab.image import cut


@pytest.fixture(scope="module")
def photos():
    return simulate.aerial_pair((320, 200))


@pytest.fixture(scope="module")
def pair(photos):
    land = photos.landscape
    return stereo.epipolar_pair(
        photos.left, photos.right, (land.dsm.min(), land.dsm.max())
    )


def test_the_line_is_that_of_the_epipolar_room(photos):
    left, right = photos.left, photos.right
    pixels = np.array([(20.0, 30.0), (90.0, 100.0), (150.0, 5.0)])
    M = rotation.matrix(*right.exterior[3:])
    base = right.exterior[:3] - left.exterior[:3]
    for pixel, wanted in zip(pixels, epipolar.line(left, right, pixels)):
        line = program.epipolar_line(base, left.rays(pixel), M, right.camera.c)
        line = line / np.hypot(*line[:2])
        assert np.allclose(line * np.sign(line @ wanted), wanted, atol=1e-12)


def test_a_ray_along_the_base_has_no_line():
    with pytest.raises(ValueError, match="along the base"):
        program.epipolar_line((5, 0, 0), (10, 0, 0), np.eye(3), 24.0)


def test_the_model_point_is_that_of_the_normal_pair(pair):
    column, row, d = 40, 70, 3.25
    x, y = pair.origin[0] + pair.pixel_size * np.array([column, -row])
    model = program.model_point(x, y, pair.parallax(d), pair.base, pair.c)
    point = pair.stations[0] + model @ pair.rotation
    assert np.allclose(point, pair.object_points(column, row, d), atol=1e-9)


def test_the_best_disparity_is_that_of_a_shift():
    scene = ndimage.gaussian_filter(
        np.random.default_rng(4).normal(0, 100, (50, 90)), 1.5
    )
    for shift in (-4.3, 0.4, 6.0):
        right = ndimage.shift(scene, (0, -shift), order=5, mode="mirror")
        d, r = program.best_disparity(scene, right, 45, 25, 11, -9, 9)
        assert abs(d - shift) < 0.1 and r > 0.9  # a parabola is no better


def test_r_along_the_row_is_that_of_the_windows(pair):
    tried, r = program.along_row(pair.left, pair.right, 60, 50, 7, -5, 5)
    target = cut(pair.left, (60, 50), 7)
    for d, one in zip(tried, r):
        other = cut(pair.right, (60 - d, 50), 7)
        assert np.isclose(one, np.corrcoef(target.ravel(), other.ravel())[0, 1])


def test_a_peak_at_the_end_of_the_search_is_none(pair):
    tried, r = program.along_row(pair.left, pair.right, 60, 50, 7, -20, 20)
    best = int(tried[r.argmax()])
    d, _ = program.best_disparity(pair.left, pair.right, 60, 50, 7, best, best + 6)
    assert np.isnan(d)


def test_a_row_of_points_is_what_the_fast_functions_give(photos, pair):
    match = stereo.match_dense(pair, method="ncc")
    row = 40  # fields
    columns = np.flatnonzero(match.status[row] == 0)
    middle = int(np.median(match.disparity[row, columns]))
    columns = columns[(columns > 40) & (columns < 160)][::4]
    own = np.full((len(columns), 3), np.nan)
    for i, column in enumerate(columns):
        d, r = program.best_disparity(
            pair.left, pair.right, column, row, 7, middle - 15, middle + 15
        )
        if r >= 0.8:
            x, y = pair.origin[0] + pair.pixel_size * np.array([column, -row])
            model = program.model_point(x, y, pair.parallax(d), pair.base, pair.c)
            own[i] = pair.stations[0] + model @ pair.rotation
    fast = pair.object_points(columns, row, match.disparity[row, columns])
    off = np.abs(own - fast)[np.isfinite(own[:, 0])]
    assert len(off) > 8
    # A parabola and least squares matching differ by a tenth or two of 0.58 m a pixel
    assert np.median(off[:, 2]) < 0.12


def test_a_promise_is_the_derivative_of_the_depth():
    H, B, gsd, c = 1000.0, 392.0, 0.229, 24.0
    pixel = gsd * c / H  # mm
    parallax = c * B / H
    depth = [c * B / (parallax + s * 0.1 * pixel) for s in (-0.5, 0.5)]
    wanted = depth[0] - depth[1]
    assert np.isclose(program.sigma_height(H, B, gsd, 0.1), wanted, rtol=1e-6)
