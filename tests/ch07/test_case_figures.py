"""Figures of the case of the fifty shifts: they show what they get, in words too."""

import numpy as np
import pytest

from pgm_book.ch07 import case_figures as ch07_case_figures
from pgm_lab import datasets

GROUND = datasets.yellowstone().grey[:90, :90]


def test_a_disc_lies_at_its_shift_and_the_ring_at_the_mean(figures):
    ch07_case_figures.on_the_grid({"one": [(2, 1)] * 3 + [(2, -3)], "other": [(0, 0)]})
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


def test_the_suspects_print_one_rmse_and_differ_in_what_they_hide():
    for shifts in ch07_case_figures.SUSPECTS.values():
        assert shifts.shape == (50, 2) and (shifts**2).sum() == 286
        assert np.abs(shifts).max() <= 3
    means = [np.hypot(*s.mean(axis=0)) for s in ch07_case_figures.SUSPECTS.values()]
    assert means == pytest.approx([2.353, 0, 0.063], abs=0.001)


def test_a_sum_is_marked_where_it_lies(figures):
    drawn = {"one": [380, 400, 420, 440], "other": [600, 610]}
    ch07_case_figures.sums([(3, -3), (3, 1)], drawn, 390)
    fig, alt = figures[0]
    grid, ax = fig.axes
    assert grid.yaxis_inverted() and "2 blind chips" in grid.get_title()
    assert ax.lines[0].get_xdata()[0] == 390
    assert "one: mean 410" in alt and "0.25000" in alt and "other: mean 605" in alt
    for bars in ax.containers:
        assert sum(bar.get_height() for bar in bars) == pytest.approx(100)  # %


@pytest.mark.parametrize("drawn", [{}, {"one": []}, dict.fromkeys("abc", [1])])
def test_no_draws_or_too_many_are_refused(drawn):
    with pytest.raises(ValueError, match="drawn must"):
        ch07_case_figures.sums([(0, 0)], drawn, 286)


def test_a_reported_shift_stands_over_the_true_one(figures):
    ch07_case_figures.beyond([0, 3, 4], [0, 3, 3.1], [1, 1, 0.84])
    fig, alt = figures[0]
    assert fig.axes[0].lines[1].get_xydata()[-1].tolist() == [4, 3.1]
    assert fig.axes[1].lines[0].get_xydata()[-1].tolist() == [4, 0.84]
    assert "4 px: 3.10 px, 84%" in alt


def test_a_match_counts_as_wrong_from_one_pixel_on(figures):
    ch07_case_figures.r_and_shift([0.9, 0.8, 0.4], [2, 2, 3], [0.0, 0.99, 1.0])
    fig, alt = figures[0]
    (untold,) = fig.axes[0].lines  # as in the paper, which does not know the truth
    assert untold.get_ydata().tolist() == [2, 2, 3]
    assert fig.axes[1].lines[0].get_ydata().tolist() == [0.0, 0.99]
    assert "1 of 3" in alt and "r is 0.40, of the right ones 0.85" in alt


def test_without_a_wrong_match_no_median_is_named(figures):
    ch07_case_figures.r_and_shift([0.9], [2], [0.0])
    assert "their median r is none" in figures[0][1]


def test_a_chip_is_drawn_with_the_sensed_image_moved_back(figures):
    sensed = np.roll(GROUND, (-2, 3), axis=(0, 1))
    ch07_case_figures.chips(GROUND, sensed, [(44, 40)], [(3, -2)])
    (fig, _), here = figures[0], GROUND[40 - 25 : 40 + 26, 44 - 25 : 44 + 26]
    drawn = {ax.get_title(): ax.images[0].get_array() for ax in fig.axes}
    one, other = drawn["reference"], drawn["sensed, back"]
    both = drawn["P: both"]
    np.testing.assert_array_equal(one, other)
    assert np.corrcoef(one.ravel(), here.ravel())[0, 1] > 0.98
    assert np.ptp(both, axis=2).max() == 0  # alike everywhere: grey
    corner = fig.axes[0].patches[0].get_xy()
    assert corner == (25 - 10.5, 25 - 10.5)


@pytest.mark.parametrize("point", [(20, 40), (40, 20), (70, 40), (40, 70)])
def test_a_chip_near_the_edge_is_named(point):
    with pytest.raises(ValueError, match=r"leaves the \w+ image of 90 columns"):
        ch07_case_figures.chips(GROUND, GROUND, [point], [(0, 0)])


def test_more_than_four_chips_are_refused():
    with pytest.raises(ValueError, match="one to four; got 5"):
        ch07_case_figures.chips(GROUND, GROUND, [(44, 44)] * 5, [(0, 0)] * 5)
