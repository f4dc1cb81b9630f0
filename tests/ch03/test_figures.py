"""Figures of chapter 3 are drawn as the notebook does; their words are true."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch03 import case_figures
from pgm_book.ch03 import figures as of_lesson
from pgm_book.program.lsm import match
from pgm_lab import simulate

AFFINE = (3.0, 1.02, 0.05, -2.0, -0.04, 0.98)
POINT, WINDOW = (40, 45), 21
LEFT, RIGHT = simulate.texture_pair(
    simulate.texture(seed=4), (90, 90), AFFINE, gain=0.8, offset=20.0
)
TRUTH = np.array([3 + 1.02 * 40 + 0.05 * 45, 1.02, 0.05, 0, -0.04, 0.98, -25, 1.25])
TRUTH[3] = -2 - 0.04 * 40 + 0.98 * 45
START = np.array([44, 1, 0, 41, 0, 1, 0, 1.0])


@pytest.fixture
def film():
    fig = of_lesson.film_strip(
        LEFT, RIGHT, POINT, WINDOW, np.array([START, TRUTH]), ["start", "end"]
    )
    yield np.array(fig.axes[:9]).reshape(3, 3)
    plt.close(fig)


def shown(ax):
    return np.asarray(ax.images[0].get_array())


def test_residuals_are_computed_minus_observed_and_empty_at_the_truth(film):
    for column in (1, 2):
        difference = shown(film[1, column]) - shown(film[1, 0])
        np.testing.assert_allclose(shown(film[2, column]), difference, atol=1e-9)
    # The cubic spline leaves 0.1 of a contrast of 40 on this texture, on the average
    assert np.sqrt(np.mean(shown(film[2, 2]) ** 2)) < 0.3
    assert np.sqrt(np.mean(shown(film[2, 1]) ** 2)) > 10


def test_sliders_name_the_steps_that_they_show(monkeypatch, figures):
    """The first, the middle and the last step, by their numbers in the trail."""
    monkeypatch.setattr(of_lesson, "interact", lambda draw, **_: draw(1, 1, 0))
    truth = TRUTH[[0, 3]]
    of_lesson.shift_by_hand(LEFT, RIGHT, POINT, WINDOW, truth)
    start = [*(np.round(truth[0]) + 1, 1, 0), *(np.round(truth[1]) + 1, 0, 1, 0, 1)]
    trail, _, _ = match(LEFT, RIGHT, POINT, start, WINDOW)
    fig, _ = figures[0]
    titles = [ax.get_title() for ax in fig.axes if "px off" in ax.get_title()]
    last = len(trail) - 1
    assert last > 2
    expected = ["start", f"step {(last + 1) // 2}", f"step {last}"]
    assert [title.split("\n")[0] for title in titles] == expected


AWAY = np.array([0, 1, 10, 1083.0])
ROW = np.cumsum(np.random.default_rng(1).normal(0, 9, 41)) + 120
CLOUD = {"edge": (np.full((9, 2), 0.01), 1e-4 * np.eye(2))}
FIGURES = [
    (
        of_lesson.window_pair,
        (LEFT, RIGHT, POINT, np.reshape(AFFINE, (2, 3)), 21),
        "aer",
    ),
    (of_lesson.window_slope, (ROW, ROW + 5, 29), "difference divided by the slope"),
    (of_lesson.eight_parameters, (LEFT, POINT), "Eight small photos"),
    (of_lesson.interpolation, (), "less than 1"),
    (
        of_lesson.iteration_film,
        (LEFT, RIGHT, POINT, WINDOW, [START, TRUTH], TRUTH[[0, 3]]),
        "Pixels from the truth: 2.110, 0.000",
    ),
    (of_lesson.half_wave, (), "the wrong valley"),
    (of_lesson.pull_in, (), "nearly all do from 4 pixels"),
    (of_lesson.ellipses, (LEFT, {"edge": POINT}, CLOUD), "95 % ellipse"),
    (
        case_figures.origin,
        (AWAY, 10.0 ** AWAY[:4].clip(0, 9), AWAY + 1, AWAY + 1),
        "1084 t",
    ),
    (case_figures.s0, (np.array([7, 17, 41]), np.array([6.5, 6.5, 6.5])), "near 6.5"),
    (case_figures.costs, (), "Bilinear costs a factor of 2.8"),
    (
        case_figures.radiometric,
        ([1, 1.1], np.array([0.01, 0.01]), np.array([0.01, 0.2])),
        "20 times",
    ),
    (
        case_figures.on_photo,
        (LEFT, np.array([POINT, POINT]), np.array([0.05, 2.0])),
        "1 < 0.1 px, 0 0.1 to 1 px, 1 > 1 px",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), FIGURES, ids=[f[0].__name__ for f in FIGURES]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)
