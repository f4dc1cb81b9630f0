"""Figures of chapter 9: their words say what is drawn."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch09 import figures, photos
from pgm_lab import plot

GRID = photos.grid(4, 3)
SETS = tuple(
    photos.Board(name, np.zeros((5, 12, 2)) + 9.0, (60, 40), GRID, np.zeros((40, 60)))
    for name in ("left camera", "right camera")
)
BENT = np.column_stack([0.001 * GRID[:, :2], 0.02 * np.cos(GRID[:, 0])])
GREY = np.tile(np.arange(80.0), (60, 1))
SCENE = photos.Pair(GREY, GREY, 1.0, np.array([(10, 20), (60, 40)]), 1.25, (2.0, 5.0))


@pytest.fixture
def said(monkeypatch):
    """What was shown last: the words, and the figure is drawn and closed."""
    shown = []

    def show(figure, alt, **_):
        figure.canvas.draw()
        plt.close(figure)
        shown.append(alt)

    monkeypatch.setattr(plot, "show", show)
    return shown


@pytest.mark.parametrize(
    ("draw", "arguments", "words"),
    [
        (figures.boards, (SETS,), "each of its 12 inner corners"),
        (figures.shapes, (SETS, [BENT, BENT]), "r = 1.00, 1.00, 1.00 in x, y, z"),
        (
            figures.held_out,
            ({"flat board": np.array([0.3, 0.4]), "free": np.array([0.1, 0.1])},),
            "flat board: 0.354 px; free: 0.100 px",
        ),
        (figures.pair, (SCENE,), "two points 1.250 m apart"),
        (figures.matches, (SCENE, np.array([(10, 20, 8, 21)])), "1 points joined"),
        (
            figures.weakest,
            (["ω", "φ"], np.array([0.01, 0.1]), np.array([np.nan, np.nan])),
            "ω 0.010°, φ 0.100°",
        ),
        (
            figures.depths,
            (
                GREY,
                np.array([(10, 20), (30, 40), (50, 10)]),
                np.array([-3, -4, np.nan]),
                np.array([0.1, 0.2, np.nan]),
                np.array([-3.1, -5, -4]),
            ),
            "2 measured places.* typically 4.45. 50 % lie within three",
        ),
    ],
)
def test_a_figure_says_what_it_draws(draw, arguments, words, said):
    import re

    draw(*arguments)
    assert len(said) == 1 and re.search(words, said[0]), said


def test_the_surface_leaves_out_what_sticks_out(said, monkeypatch):
    monkeypatch.setattr(figures, "interact", lambda draw, **s: draw(-70, 25))
    x, y = np.meshgrid(np.arange(6) * 0.05, np.arange(5) * 0.05)
    points = np.column_stack([x.ravel(), y.ravel(), np.full(30, -2.0)])
    figures.surface(points, np.full(30, 100.0))
    assert "A surface of 40 triangles" in said[-1]
    points[14, 2] = -1.5  # a wrong match
    figures.surface(points, np.full(30, 100.0))
    assert "A surface of 40 triangles" not in said[-1]
