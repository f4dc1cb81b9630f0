"""Proofs of the verdicts on Harintaka 2020, the stereo model: parallax in x and y, the
mark above, below and on the ground, and what an uncorrected lens does to the model."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import camera as cam
from pgm_lab import datasets, orientation
from pgm_lab.camera import Camera

DATA = datasets.harintaka2020()
PIXEL, SENSOR = DATA.camera_pixel_size, np.array(DATA.camera_image_size)
C, HEIGHT = 24.0, 1000.0
PLAIN = Camera(C)
BASE = 0.4 * SENSOR[0] * PIXEL * HEIGHT / C  # 60 per cent along the long side
WORTH = HEIGHT / BASE * PIXEL * HEIGHT / C  # m of height for a pixel of parallax
NORMAL = np.array([(0.0, 0, HEIGHT, 0, 0, 0), (BASE, 0, HEIGHT, 0, 0, 0)])
FLOWN = np.array(
    [
        (-BASE / 2, 0, 1000, 0.010, -0.020, 0.030),
        (BASE / 2, 3, 1004, -0.010, 0.015, -0.025),
    ]
)
GROUND = np.random.default_rng(8).uniform((50, -250, 0), (350, 250, 40), (60, 3))


def images(points, exteriors=NORMAL, camera=PLAIN):
    return cam.project(camera, exteriors[:, None], points)


def met(both, exteriors=NORMAL):
    """Where the rays of both photos come nearest: points (n, 3)."""
    return orientation.intersect(PLAIN, exteriors, both).points


def lens(share):
    """A lens that displaces the corner of the photo by this share of its radius."""
    return Camera(C, K1=share / np.sum((SENSOR * PIXEL / 2) ** 2))


def model_without_lens(share, relief=0.0):
    """Photos through a lens, oriented without it: y parallax in pixels, and dZ in m."""
    X, Y = np.meshgrid(np.linspace(-280, 280, 13), np.linspace(-310, 310, 13))
    Z = relief / 2 * (np.sin(X / 90) + np.cos(Y / 70))
    points = np.stack([X, Y, Z], -1).reshape(-1, 3)
    both = images(points, FLOWN, lens(share))
    seen = (np.abs(both) < SENSOR * PIXEL / 2).all(axis=(0, 2))
    found = orientation.relative(PLAIN, PLAIN, *both[:, seen], base=BASE)
    across = np.linalg.norm(found.residuals[0] - found.residuals[1], axis=1)
    off = orientation.absolute(found.points, points[seen]).residuals[:, 2]
    return np.sqrt(np.mean((across / PIXEL) ** 2)), off, points[seen]


# Parallax


def test_x_parallax_never_vanishes_and_is_the_height():
    left, right = images(GROUND)
    p = left[:, 0] - right[:, 0]
    close(C * BASE / p, HEIGHT - GROUND[:, 2], rtol=1e-12)
    assert p.min() > 9  # mm: without x parallax a point is infinitely far away
    # What vanishes at the right height is the difference to the mark's parallax
    close(left[:, 1], right[:, 1], atol=1e-12)


def test_y_parallax_vanishes_with_good_orientation_but_also_with_a_bad_base():
    both = images(GROUND)
    turned = NORMAL + [(0,) * 6, (0, 0, 0, 0, 0, np.radians(0.1))]
    py = images(GROUND, turned)[1, :, 1] - both[0, :, 1]
    assert np.abs(py).max() / PIXEL > 1  # 0.1 degrees are seen
    # A base that is 0.55 m too long is not: rays meet, and heights are 1.4 m wrong
    longer = NORMAL + [(0,) * 6, (0.55, 0, 0, 0, 0, 0)]
    wrong = met(both, longer)
    close(images(wrong, longer), both, atol=1e-9)
    assert np.mean(wrong[:, 2] - GROUND[:, 2]) == approx(-1.37, abs=0.03)


def test_tie_points_fit_as_well_wherever_the_whole_block_lies():
    rng = np.random.default_rng(9)
    both = images(GROUND) + rng.normal(0, 0.07 * PIXEL, (2, len(GROUND), 2))
    lifted = NORMAL + (0, 0, 1.4, 0, 0, 0)
    here, there = met(both), met(both, lifted)
    v = [images(p, e) - both for p, e in ((here, NORMAL), (there, lifted))]
    close(v[0], v[1], atol=1e-9)
    close(there - here, np.tile((0, 0, 1.4), (60, 1)), atol=1e-6)
    # Noise of 0.07 pixel gives what is printed of tie points: a few centimetres
    assert np.std(here[:, 2] - GROUND[:, 2]) == approx(0.057, abs=0.015)


def test_a_mark_of_more_x_parallax_is_above_and_a_mark_of_less_below():
    both = images(np.array([[200.0, 30.0, 12.0]]))
    assert met(both)[0, 2] == approx(12.0)
    for columns in (4, -4):
        # The left mark to the right of the object, the right one to its left; or not
        moved = both + np.array([[[columns / 2]], [[-columns / 2]]]) * (PIXEL, 0)
        rise = met(moved)[0, 2] - 12.0
        assert np.sign(rise) == np.sign(columns)
        assert rise == approx(columns * WORTH * 0.976, rel=0.01)
    # With the photos exchanged before the eyes, near and far exchange as well
    p = images(GROUND)[0, :, 0] - images(GROUND)[1, :, 0]
    assert np.all(np.diff(GROUND[np.argsort(p), 2]) > 0)
    assert np.all(np.diff(GROUND[np.argsort(-p), 2]) < 0)


def shifted(columns, axis):
    """What it does to a point if its image in the right photo moves so far."""
    both = images(GROUND)
    both[1, :, axis] += columns * PIXEL
    return met(both) - GROUND


@pytest.mark.parametrize("columns", [-3, 3])
def test_a_wrong_match_floats_above_or_pierces_the_ground(columns):
    dz = shifted(columns, 0)[:, 2]
    assert np.all(np.sign(dz) == -np.sign(columns))
    assert np.abs(dz).mean() == approx(3 * WORTH, rel=0.06)


def test_a_shift_across_the_base_leaves_heights_and_a_shift_along_it_does_not():
    along, across = np.abs(shifted(1, 0)), np.abs(shifted(1, 1))
    assert along[:, 2].mean() == approx(WORTH, rel=0.06)
    assert across[:, 2].max() < 1e-3
    # Across, the point moves by half a pixel on the ground
    assert across[:, 1].mean() == approx(0.112, abs=0.005)


def test_intervals_of_search_shrink_from_a_square_to_a_line():
    """Places tried for a search of s pixels each way, as the two texts describe it."""
    for s, ratio in ((5, 11), (12, 25), (30, 61)):
        line = range(-s, s + 1)
        assert len(list(itertools.product(line, line))) / len(line) == ratio


# The lens


def test_a_lens_left_uncorrected_bends_the_model_and_hardly_shows_in_y_parallax():
    assert model_without_lens(0.0)[0] < 1e-6
    py, dz, points = model_without_lens(0.01)
    assert py == approx(0.063, abs=0.006)  # px, after relative orientation
    assert np.std(dz) == approx(1.0, abs=0.1)  # m
    assert np.ptp(dz) > 4
    # A bowl: nearly all of it is one parabola about the middle of the model
    X, Y = points[:, 0], points[:, 1]
    bowl = np.stack([np.ones_like(X), X, Y, X**2 + Y**2], -1)
    left = dz - bowl @ np.linalg.lstsq(bowl, dz, rcond=None)[0]
    assert np.std(left) < 0.05 * np.std(dz)
    # 1.4 per cent would be enough for all of Table 1
    assert np.std(model_without_lens(0.014)[1]) == approx(1.4, abs=0.1)


def test_relative_orientation_again_mends_the_y_parallax_and_not_the_height():
    points = np.array([(x, y, 0.0) for x in (-150, 0, 150) for y in (-250, 0, 250)])
    both = images(points, FLOWN, lens(0.01))
    # Before: the true orientation, the lens ignored
    v = images(met(both, FLOWN), FLOWN) - both
    before = np.sqrt(np.mean(np.sum((v[0] - v[1]) ** 2, -1))) / PIXEL
    after, dz, _ = model_without_lens(0.01)
    assert before > 2 and after < before / 20
    assert np.std(dz) > 0.9
    # With relief a tenth of a pixel is left, and heights still bend
    assert model_without_lens(0.01, 40.0)[0] == approx(0.10, abs=0.02)
    assert np.std(model_without_lens(0.01, 40.0)[1]) > 0.9


def test_h_over_f_is_the_scale_of_vertical_photos_at_one_height():
    number = HEIGHT * 1000 / C
    step = np.array([(0.0, 0, 0), (1.0, 0, 0), (0, 0, 40.0), (1.0, 0, 40.0)])
    vertical = images(step, NORMAL)[0]
    flat, hill = (np.linalg.norm(vertical[k + 1] - vertical[k]) for k in (0, 2))
    assert 1000 / flat == approx(number)
    assert 1000 / hill == approx(0.96 * number)  # 40 m of relief: 4 per cent
    # Tilted by 3 degrees the two ends of the long side differ by 5 per cent
    tilted = np.array([(0.0, 0, HEIGHT, 0, np.radians(3), 0)])
    corners = np.array([(x + d, 0.0, 0) for x in (-490, 490) for d in (-1.0, 1.0)])
    seen = cam.project(PLAIN, tilted, corners)
    scales = 2000 / np.linalg.norm(seen[1::2] - seen[::2], axis=1)
    assert np.ptp(scales) / number == approx(0.10, abs=0.03)
