"""Rendered photos of boards: the map behind them, and corners measured in them."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.special import erf

from pgm_lab import camera as cameras
from pgm_lab import frames
from pgm_lab.calibration.board import usual
from pgm_lab.camera import Camera
from pgm_lab.simulate import boards
from pgm_lab.simulate.boards import photograph, view

LENSES = [
    Camera(4.2, x0=0.05, y0=-0.03, K1=-0.008, K2=5e-4, P1=1e-4, lens="forward"),
    Camera(4.2, x0=-0.05, K1=0.004, K2=-2e-4, P2=1e-4, b1=1e-3, lens="backward"),
]
SIZE, PIXEL = (1600, 1200), 0.0035
SMALL, COARSE = (200, 150), 0.028  # the same photo, where its grey does not matter


def bent(x, y):
    return 2 * np.sin(x / 80) * np.cos(y / 60)


def points_of(board):
    """Its points bent, and shifted in the paper by 0.2 mm."""
    x, y, z = board.points.T
    return np.stack([x + 0.2 * np.sin(y / 50), y, z + bent(x, y)], 1)


@pytest.mark.parametrize("lens", LENSES)
@pytest.mark.parametrize("shape", [None, bent, points_of])
def test_the_ray_of_a_point_comes_from_the_point(lens, shape):
    """From board to photo by `camera.project`, back by what renders: to 2e-3 px."""
    board = usual()
    shape = shape(board) if shape is points_of else shape
    at = view(board, 350, 40, 70, 25)
    bend = boards._bending(board, shape)
    points = board.points + bend(board.points[:, :2])
    if shape is not None:
        heights = bent(*board.points[:, :2].T)
        np.testing.assert_allclose(points[:, 2], heights, atol=1e-6)
    pixels = frames.photo_to_pixel(cameras.project(lens, at, points), SIZE, PIXEL)
    back = boards._mapping(board, lens, at, SIZE, PIXEL, bend)
    for (column, row), point in zip(pixels[::5], board.points[::5]):
        x, y = back(np.array([column]), np.array([row]))
        np.testing.assert_allclose((x[0, 0], y[0, 0]), point[:2], atol=5e-4)


def saddle(grey, start):
    """Corner by a least squares fit of two blurred edges that cross: (column, row)."""
    column, row = np.rint(start).astype(int)
    y, x = np.mgrid[-4:5, -4:5]
    window = grey[row - 4 : row + 5, column - 4 : column + 5].astype(float)

    def misfit(p):
        u, v = x - p[0], y - p[1]
        one, two = (u * np.cos(a) + v * np.sin(a) for a in p[4:6])
        return (p[2] + p[3] * erf(one / p[6]) * erf(two / p[6]) - window).ravel()

    starts = [(s, a) for s in (90, -90) for a in (0, 0.8, -0.8)]
    fits = [
        least_squares(misfit, [0, 0, 125, s, a, a + np.pi / 2, 1.5]) for s, a in starts
    ]
    return min(fits, key=lambda fit: fit.cost).x[:2] + (column, row)


@pytest.mark.slow
def test_corners_lie_where_they_are_said_to_be():
    """Measured independently: 0.005 px on the mean, single ones by rounded greys."""
    board = usual()
    at = view(board, 330, 35, 60, 20)
    photo = photograph(board, LENSES[0], at, SIZE, PIXEL, shape=bent, blur=1.2)
    projected = cameras.project(LENSES[0], at, photo.points)
    true = frames.photo_to_pixel(projected, SIZE, PIXEL)
    np.testing.assert_allclose(photo.pixels, true)
    true = true[::8]
    off = np.array([saddle(photo.grey, one) for one in true]) - true
    assert np.abs(off.mean(0)).max() < 0.005
    assert np.sqrt(np.mean(off**2)) < 0.01


def test_light_noise_and_jpeg_are_as_asked():
    board = usual()
    at, plain = view(board, 900, 0, 0), {"blur": 0.0}
    still = photograph(board, LENSES[0], at, (800, 600), 0.007, **plain).grey.astype(
        float
    )
    again = photograph(
        board, LENSES[0], at, (800, 600), 0.007, noise=4, rng=np.random.default_rng(1)
    )
    around = np.s_[:80]  # nothing but the table
    assert np.ptp(still[around]) == 0
    assert again.grey[around].std() == pytest.approx(4, rel=0.02)
    lit = photograph(board, LENSES[0], at, (800, 600), 0.007, light=0.5, **plain).grey
    assert lit[0, -1] / lit[0, 0] == pytest.approx(1.25 / 0.75, rel=0.02)
    coarse = photograph(board, LENSES[0], at, (800, 600), 0.007, quality=20, **plain)
    assert 0.5 < np.abs(coarse.grey - still).mean() < 5


def test_what_lies_outside_of_the_photo_is_said_to():
    board = usual()
    photo = photograph(board, LENSES[0], view(board, 150, 0, 0), SMALL, COARSE)
    outside = np.any((photo.pixels < 0) | (photo.pixels > (199, 149)), axis=1)
    assert 0 < outside.sum() < 96 and np.array_equal(photo.inside, ~outside)
