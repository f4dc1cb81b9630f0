"""Figures of chips and their shifts: marks stand where the numbers say."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch07 import figures as ch07_figures
from pgm_lab import simulate

GREY = simulate.grey_values(
    simulate.texture(seed=1), np.stack(np.meshgrid(np.arange(48), np.arange(44)), -1)
)
R = np.array([[0.1, 0.2, 0.1], [0.3, 0.5, 0.9], [0.2, 0.4, 0.6]])


def test_the_search_says_which_shift_it_found(alt_of):
    moved = np.roll(GREY, (1, -2), axis=(0, 1))
    alt = alt_of(ch07_figures.chip_search, GREY, moved, (22, 20), 9, 3)
    assert "the shift (-2, 1)" in alt and "7 by 7" in alt
    assert "Within 0.1 of it are the shifts" in alt


def test_the_highest_r_is_framed_at_its_shift(closed):
    fig, ax = plt.subplots()
    ch07_figures.table_of_r(ax, R, numbers=True)
    (frame,) = ax.patches
    assert frame.get_xy() == (0.5, -0.5)  # dx = 1, dy = 0
    assert sorted(t.get_text() for t in ax.texts)[-1] == ".90"


def test_numbers_lose_the_zero_before_the_point_and_nothing_else(closed):
    fig, ax = plt.subplots()
    ch07_figures.table_of_r(
        ax, [[1, -0.05, 0.1], [0, 0.5, 0.9], [-1, 0.99, 0.004]], True
    )
    written = [t.get_text() for t in ax.texts]
    assert " ".join(written) == "1.0 −.05 .10 .00 .50 .90 −1.0 .99 .00"


def test_a_chip_and_its_map_say_where_r_is_high(alt_of):
    alt = alt_of(ch07_figures.chip_and_map, GREY, (22, 20), R)
    assert "the highest, 0.90, framed, at dx = 1 and dy = 0" in alt
    assert (
        "Within 0.1 of it are the shifts (1, 0);" in alt and "lowest r is 0.10" in alt
    )


def test_each_chip_has_its_square(closed):
    fig = ch07_figures.chip_places(GREY, [(20, 20), (30, 12)], 9)
    corners = [square.get_xy() for square in fig.axes[0].patches]
    assert np.allclose(corners, [(15.5, 15.5), (25.5, 7.5)])


def test_the_parabola_goes_through_the_three_values_and_its_peak_is_marked(closed):
    fig = ch07_figures.chip_parabola(0.5, 0.9, 0.7)
    curve, dots, cross = fig.axes[0].lines
    x, y = curve.get_data()
    assert np.allclose(np.interp(dots.get_xdata(), x, y), dots.get_ydata(), atol=1e-4)
    assert np.isclose(cross.get_xdata()[0], 1 / 6) and cross.get_ydata()[0] >= y.max()


def test_darts_say_how_far_each_median_is_off(alt_of):
    methods = {
        "one": np.tile([1.0, -1.0], (5, 1)),
        "other": np.tile([1.25, -0.75], (3, 1)),
    }
    alt = alt_of(ch07_figures.darts, methods, (1.25, -0.75))
    assert "one 0.354 px, other 0.000 px" in alt


def test_beyond_the_radius_counts_the_wrong_that_keep_a_high_r(alt_of):
    alt = alt_of(
        ch07_figures.beyond, [0.0, 4.5, 5, 6], [0.0, 3, 3, 3], [1, 0.9, 0.85, 0.3]
    )
    assert "2 of 3 wrong chips stay above 0.8" in alt


def test_a_trial_says_what_a_threshold_lets_pass(alt_of):
    error, r = np.array([0.1, 0.2, 0.3, 5, 9]), np.array([0.9, 0.85, 0.4, 0.82, 0.1])
    tests, accepted = {"r": r, "other": -error}, error < 0.25
    alt = alt_of(ch07_figures.trial, error, r, tests, accepted)
    assert "67 per cent of the right and 50 of the wrong" in alt
    assert "together pass 67 and 0.0" in alt


def test_a_trial_needs_right_and_wrong_chips():
    for error in ([0.1, 0.2], [3.0, 4.0]):
        with pytest.raises(ValueError, match="chips within a pixel and chips beyond"):
            ch07_figures.trial(error, [0.9, 0.8], {"r": [0.9, 0.8]}, [True, False])
    with pytest.raises(ValueError, match="one number for each chip"):
        ch07_figures.trial([0.1, 3.0], [0.9, 0.8], {"r": [0.9]}, [True, False])
