"""Figures of chapter 7 and its case: marks stand where the numbers say, words hold."""

import numpy as np
import pytest

from pgm_book.ch07 import case_figures
from pgm_book.ch07 import figures as of_lesson
from pgm_book.ch07.case_checks import CANDIDATES
from pgm_lab import simulate

GREY = simulate.grey_values(
    simulate.texture(seed=1), np.stack(np.meshgrid(np.arange(48), np.arange(44)), -1)
)
R = np.array([[0.1, 0.2, 0.1], [0.3, 0.5, 0.9], [0.2, 0.4, 0.6]])
EDGE = np.tile(np.arange(60) >= 30, (50, 1)) * 100.0  # dark left, bright from column 30
MOVED = np.roll(EDGE, 2, axis=1)
MOVED[:, :2] = 0
EDGE, MOVED = 4 * EDGE, 4 * MOVED
AGAIN = np.ma.masked_array(EDGE, np.indices(EDGE.shape)[1] < 2)
ERROR, OF_ERROR = np.array([0.1, 0.2, 0.3, 5, 9]), np.array([0.9, 0.85, 0.4, 0.82, 0.1])
METHODS = {
    "one": np.tile([1.0, -1.0], (5, 1)),
    "other": np.tile([1.25, -0.75], (3, 1)),
}
DRAWN = [
    (
        of_lesson.chip_search,
        (GREY, np.roll(GREY, (1, -2), axis=(0, 1)), (22, 20), 9, 3),
        "the shift (-2, 1). Right, r for every shift as a map of 7 by 7",
    ),
    (
        of_lesson.chip_and_map,
        (GREY, (22, 20), R),
        "the highest, 0.90, framed, at dx = 1 and dy = 0. Within 0.1 of it are the"
        " shifts (1, 0); the lowest r is 0.10",
    ),
    (of_lesson.two_colours, (EDGE, MOVED, (30, 25), 21), "green on one side"),
    (of_lesson.before_and_after, (EDGE, MOVED, AGAIN), "Before, 3 %"),
    (of_lesson.before_and_after, (EDGE, MOVED, AGAIN), "After, 0 %"),
    (
        of_lesson.darts,
        (METHODS, np.array([1.25, -0.75])),
        "one 0.354 px, other 0.000 px",
    ),
    (
        of_lesson.beyond,
        (
            np.array([0, 4.5, 5, 6]),
            np.array([0.0, 3, 3, 3]),
            np.array([1, 0.9, 0.85, 0.3]),
        ),
        "2 of 3 wrong chips stay above 0.8",
    ),
    (
        case_figures.beyond,
        (np.array([0, 3, 4]), [0, 3, 3.1], [1, 1, 0.84]),
        "4 px: 3.10 px, 84%",
    ),
    (
        case_figures.r_and_shift,
        (np.array([0.9, 0.8, 0.4]), np.array([2, 2, 3]), np.array([0.0, 0.99, 1.0])),
        "1 of 3 matches are wrong by a pixel or more; their median r is 0.40, of the"
        " right ones 0.85",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), DRAWN, ids=[d[0].__name__ for d in DRAWN]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)


def test_sliders_draw_the_sensed_image_back(monkeypatch, figures):
    sliders = {}
    monkeypatch.setattr(of_lesson, "interact", lambda f, **s: sliders.update(s, f=f))
    of_lesson.fringe_by_hand(EDGE, MOVED, (30, 25))
    for dx in (0, 2):
        sliders["f"](dx, 0)
        colours = np.asarray(figures[-1][0].axes[0].images[0].get_array())
        grey = np.array_equal(colours[..., 0], colours[..., 1])
        assert grey == (dx == 2)
        assert f"back by {dx} columns" in figures[-1][1]


# --- The case of the fifty shifts ---


def test_the_candidates_print_one_rmse_and_differ_in_what_they_hide():
    for shifts in CANDIDATES.values():
        assert shifts.shape == (50, 2) and (shifts**2).sum() == 286
        assert np.abs(shifts).max() <= 3
    means = [np.hypot(*s.mean(axis=0)) for s in CANDIDATES.values()]
    assert means == pytest.approx([2.353, 0, 0.063], abs=0.001)
