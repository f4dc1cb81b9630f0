"""Figures of chapter 7 and its case: marks stand where the numbers say, words hold."""

import numpy as np
import pytest

from pgm_book.ch07 import case_figures
from pgm_book.ch07 import figures as of_lesson
from pgm_book.ch07.case_checks import CANDIDATES
from pgm_lab import datasets, simulate

GREY = simulate.grey_values(
    simulate.texture(seed=1), np.stack(np.meshgrid(np.arange(48), np.arange(44)), -1)
)
R = np.array([[0.1, 0.2, 0.1], [0.3, 0.5, 0.9], [0.2, 0.4, 0.6]])
EDGE = np.tile(np.arange(60) >= 30, (50, 1)) * 100.0  # dark left, bright from column 30
MOVED = np.roll(EDGE, 2, axis=1)
MOVED[:, :2] = 0
EDGE, MOVED = 4 * EDGE, 4 * MOVED
AGAIN = np.ma.masked_array(EDGE, np.indices(EDGE.shape)[1] < 2)
GROUND = datasets.yellowstone().grey[:90, :90]
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


def test_the_highest_r_is_framed_at_its_shift_and_numbers_lose_their_zero(figures):
    of_lesson.chip_and_map(GREY, (22, 20), R)
    r = np.array([[1, -0.05, 0.1], [0, 0.5, 0.9], [-1, 0.99, 0.004]])
    of_lesson.chip_and_map(GREY, (22, 20), r)
    one, other = (fig.axes[1] for fig, _ in figures)
    assert one.patches[0].get_xy() == (0.5, -0.5)  # dx = 1, dy = 0
    written = [t.get_text() for t in other.texts]
    assert " ".join(written) == "1.0 −.05 .10 .00 .50 .90 −1.0 .99 .00"


def test_each_chip_has_its_square(closed):
    fig = of_lesson.chip_places(GREY, [(20, 20), (30, 12)])
    corners = [square.get_xy() for square in fig.axes[0].patches]
    assert np.allclose(corners, [(9.5, 9.5), (19.5, 1.5)])


def test_the_parabola_goes_through_the_three_values_and_its_peak_is_marked(closed):
    fig = of_lesson.chip_parabola(0.5, 0.9, 0.7)
    curve, dots, cross = fig.axes[0].lines
    x, y = curve.get_data()
    assert np.allclose(np.interp(dots.get_xdata(), x, y), dots.get_ydata(), atol=1e-4)
    assert np.isclose(cross.get_xdata()[0], 1 / 6) and cross.get_ydata()[0] >= y.max()


def test_the_share_that_changed_stands_above_the_map(closed):
    fig = of_lesson.changes(EDGE, MOVED, limit=50)
    titles = [ax.get_title() for ax in fig.axes]
    assert f"black: differ by more than 50 grey values, {100 * 2 / 60:.0f} %" in titles


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


def test_a_disc_lies_at_its_shift_and_the_ring_at_the_mean(figures):
    case_figures.on_the_grid({"one": [(2, 1)] * 3 + [(2, -3)], "other": [(0, 0)]})
    fig, alt = figures[0]
    discs = fig.axes[0].collections[0]
    assert discs.get_offsets().tolist() == [[2, -3], [2, 1]]
    assert discs.get_sizes()[0] < discs.get_sizes()[1]
    (mean,) = fig.axes[0].lines
    assert mean.get_xydata().tolist() == [[2, 0]]
    assert fig.axes[0].yaxis_inverted()  # rows count downwards
    assert [text.get_text() for text in fig.axes[0].texts] == ["1", "3"]
    assert "mean (2.00, 0.00) px" in fig.axes[0].get_title()
    assert "one: RMSE_T 2.65 px, mean shift 2.00 px long" in alt


def test_the_candidates_print_one_rmse_and_differ_in_what_they_hide():
    for shifts in CANDIDATES.values():
        assert shifts.shape == (50, 2) and (shifts**2).sum() == 286
        assert np.abs(shifts).max() <= 3
    means = [np.hypot(*s.mean(axis=0)) for s in CANDIDATES.values()]
    assert means == pytest.approx([2.353, 0, 0.063], abs=0.001)


def test_a_sum_is_marked_where_it_lies(figures):
    drawn = {"one": np.array([380, 400, 420, 440]), "other": np.array([600, 610])}
    case_figures.sums(np.array([(3, -3), (3, 1)]), drawn, 390)
    fig, alt = figures[0]
    grid, ax = fig.axes
    assert grid.yaxis_inverted() and "2 blind chips" in grid.get_title()
    assert ax.lines[0].get_xdata()[0] == 390
    assert "one: mean 410" in alt and "0.25000" in alt and "other: mean 605" in alt
    for bars in ax.containers:
        assert sum(bar.get_height() for bar in bars) == pytest.approx(100)  # %


def test_a_chip_is_drawn_with_the_sensed_image_moved_back(figures):
    sensed = np.roll(GROUND, (-2, 3), axis=(0, 1))
    case_figures.chips(GROUND, sensed, np.array([(44, 40)]), np.array([(3, -2)]))
    (fig, _), here = figures[0], GROUND[40 - 25 : 40 + 26, 44 - 25 : 44 + 26]
    drawn = {ax.get_title(): ax.images[0].get_array() for ax in fig.axes}
    one, other = drawn["reference"], drawn["sensed, back"]
    np.testing.assert_array_equal(one, other)
    assert np.corrcoef(one.ravel(), here.ravel())[0, 1] > 0.98
    assert np.ptp(drawn["P: both"], axis=2).max() == 0  # alike everywhere: grey
    assert fig.axes[0].patches[0].get_xy() == (25 - 10.5, 25 - 10.5)
