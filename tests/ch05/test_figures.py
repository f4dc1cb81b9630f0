"""Sketches and figures of chapter 5 say what the numbers do."""

import numpy as np
import pytest

from pgm_book.ch05 import case_figures
from pgm_book.ch05 import figures as of_lesson
from pgm_lab.camera import Camera, project
from pgm_lab.orientation import intersect

LADDER = {"as published": 1.5, "as it stands": 0.051, "… + x0, y0, K1": 0.00054}
DRAWN = [
    (of_lesson.one_ray, (), "lie on one straight line"),
    (of_lesson.epipolar_plane, (), "the epipolar line"),
    (of_lesson.to_the_ground, (), "scale, rotation and shift"),
    (
        of_lesson.adjustment_steps,
        (np.array([1e-9, 1e-6, 1e-3]), np.array([1e-8, 1e-11, 1e-7])),
        "From 1e-06 to 1e-06 rad",
    ),
    (of_lesson.point_clouds, (), "10, 40, 90 and 150 degrees"),
    (case_figures.heights, (np.outer((1, 2, 4, 8), range(10)),), "after 3 steps"),
    (
        case_figures.residuals,
        (np.zeros((2, 3, 2)), np.full((2, 3, 2), 0.05)),
        "3 points and their residuals",
    ),
    (case_figures.ladder, (LADDER,), "as it stands: 51"),
    (
        case_figures.misprints,
        (np.array([1e-9, 0.8]), ["b11", "b12"]),
        "1 agree to some nine digits, b12 deviate",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), DRAWN, ids=[d[0].__name__ for d in DRAWN]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)


def test_two_rays_are_best_at_a_right_angle():
    def variances(angle):
        pair = of_lesson.towards(angle)
        image = project(Camera(35.0), pair, np.zeros(3))[:, None]
        return np.diag(intersect(Camera(35.0), pair, image, sigma=1e-3).covariance[0])

    angles = np.arange(60.0, 121, 5)
    total = [variances(angle).sum() for angle in angles]
    assert angles[np.argmin(total)] == 90
    sd = 1000 * np.sqrt(variances(90))
    np.testing.assert_allclose(sd, (0.286, 0.202, 0.286), rtol=0, atol=1e-3)
    # Depth as 1 / sin of half the angle, X as 1 / cos
    x, _, z = np.sqrt(variances(40) / variances(90))
    half = np.radians(20)
    assert np.isclose(z, np.sqrt(0.5) / np.sin(half), rtol=1e-3)
    assert np.isclose(x, np.sqrt(0.5) / np.cos(half), rtol=1e-3)


@pytest.mark.parametrize("base", [20.0, 40, 160])
def test_sigma_of_a_point_midway_between_vertical_photos_follows_the_formula(base):
    sx, sz = of_lesson.vertical_precision(base)
    h, c, sigma = 120.0, 35.0, 0.003
    assert np.isclose(sx, h / c * sigma / np.sqrt(2), rtol=1e-6)
    assert np.isclose(sz, h / base * h / c * np.sqrt(2) * sigma, rtol=1e-6)


def test_the_text_of_the_base_says_what_is_drawn(alt_of, monkeypatch):
    monkeypatch.setattr(of_lesson, "interact", lambda draw, **_: draw(80))
    alt = alt_of(of_lesson.base_by_hand)
    assert "base 80 m, rays that meet at 37 degrees" in alt
    assert "sigma Z 22 mm" in alt
