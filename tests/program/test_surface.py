"""The program of lesson 9 agrees with the library."""

import numpy as np
import pytest

from pgm_book.ch09 import checks
from pgm_book.program import surface
from pgm_lab import bundle, datasets
from pgm_lab.camera import Camera
from pgm_lab.rotation import matrix

RIGHT = np.array([1.0, 0.08, -0.12, 0.04, -0.06, 0.09])


def test_a_flat_board_gives_the_camera_of_the_bundle_with_fixed_points():
    xy, camera, exteriors, grid = checks._photos()
    photo, point = np.indices(xy.shape[:2]).reshape(2, -1)
    network = bundle.Network(
        Camera(camera[0]), exteriors, grid, photo, point, xy.reshape(-1, 2), 0.001,
        fixed=range(len(grid)),
    )  # fmt: skip
    theirs = bundle.adjust(network, datasets.INTERIOR)
    found, C, sigma0 = surface.flat_board(xy, camera, exteriors, grid)
    sd = np.sqrt(np.diag(C))
    expected = [getattr(theirs.cameras[0], name) for name in datasets.INTERIOR]
    assert np.all(np.abs(found - expected) < 0.01 * sd)
    assert sigma0 == pytest.approx(theirs.sigma0 * 0.001, rel=1e-4)
    np.testing.assert_allclose(
        sd, np.sqrt(np.diag(theirs.covariance_interior)), rtol=1e-3
    )


def test_y_parallaxes_vanish_where_rays_meet_and_the_base_is_that_of_the_scene():
    points = np.random.default_rng(2).uniform(-1, 1, (12, 3)) - (0, 0, 6)
    left, right = (surface.project(e, points, 24.0) for e in (np.zeros(6), RIGHT))
    assert np.abs(surface.y_parallaxes(RIGHT, left, right, 24.0)).max() < 1e-12
    distance = 3 * np.linalg.norm(points[1] - points[0])
    base = surface.base_length(RIGHT, left[:2], right[:2], 24.0, distance)
    assert base == pytest.approx(3 * np.linalg.norm(RIGHT[:3]))
    wrong = surface.y_parallaxes(RIGHT + (0, 0, 0, 0.01, 0, 0), left, right, 24.0)
    assert np.median(wrong) == pytest.approx(-0.24, rel=0.3) or np.all(wrong > 0.1)


def test_a_point_of_the_surface_is_that_of_the_library():
    scene = datasets.motorcycle()
    pair = scene.left[150:250, 250:450], scene.right[150:250, 250:450]
    found = surface.surface_point(pair, 140, 45, (20, 70), 0.193, 0.995, 0.001, 0.2)
    d = surface.best_disparity(*pair, 140, 45, 9, 20, 70)[0]
    assert found[2] == pytest.approx(-0.995 * 0.193 / (0.001 * d))
    assert found[3] == pytest.approx(found[2] ** 2 / (0.995 * 0.193) * 0.001 * 0.2)
    assert found[0] == pytest.approx((140 - 99.5) * 0.001 / 0.995 * -found[2])
    assert np.isnan(
        surface.surface_point(pair, 140, 45, (60, 70), 0.193, 0.995, 0.001, 0.2)
    ).all()


def test_the_normal_case_passes_the_check_of_lesson_8(capsys):
    from pgm_book.ch08 import checks as chapter8

    chapter8.normal_case(surface.normal_case)
    assert "each ray in its place" in capsys.readouterr().out


def test_the_frame_is_that_of_the_library_s_normal_pair():
    M, N = surface.frame(RIGHT)
    assert np.allclose(M, matrix(*RIGHT[3:])) and np.allclose(N @ N.T, np.eye(3))
    assert np.linalg.det(N) > 0 and np.allclose(N[1:] @ RIGHT[:3], 0)
    assert N[2] @ (M[2] + (0, 0, 1)) > 0
