"""Figures of stereo plotting: what is drawn where, and what their words say."""

import numpy as np
import pytest

from pgm_book.ch08 import figures as ch08_figures
from pgm_book.ch08 import figures as mark
from pgm_lab import stereo
from tests import good_arguments


@pytest.fixture(scope="module")
def pair():
    """A bright strip whose disparity is 6 px; 0.5 m of height a pixel."""
    column = np.arange(120)
    left = np.tile(100.0 * (np.abs(column - 60) < 6), (90, 1))
    right = np.tile(100.0 * (np.abs(column - 54) < 6), (90, 1))
    origin = np.array([(3.0, 0.0), (-6.0, 0.0)])
    stations = np.array([(0.0, 0, 1000), (400.0, 0, 1000)])
    return stereo.NormalPair(left, right, np.eye(3), stations, 24.0, 0.005, origin)


def green_and_magenta_agree(ax):
    colours = np.asarray(ax.images[0].get_array())
    return np.array_equal(colours[..., 0], colours[..., 1])


def test_the_ground_is_grey_where_the_mark_stands_on_it(pair, figures):
    ch08_figures.mark_positions(pair, (60, 45), (2, 6, 10))
    fig, alt = figures[0]
    assert [green_and_magenta_agree(ax) for ax in fig.axes] == [False, True, False]
    assert "2.0, 6.0, 10.0 px" in alt
    heights = [float(ax.get_title().split(": ")[1][:-2]) for ax in fig.axes]
    assert heights == sorted(heights)  # the larger the disparity, the higher


def test_the_slider_moves_the_right_photo_and_says_the_height(
    pair, figures, monkeypatch
):
    given = {}
    monkeypatch.setattr(mark, "interact", lambda draw, **s: given.update(s, draw=draw))
    ch08_figures.mark_by_hand(pair, (60, 45), start=0, reach=8)
    for d in (0.0, 6.0):
        given["draw"](d, mark.COLOURS)
        fig, alt = figures[-1]
        assert green_and_magenta_agree(fig.axes[2]) == (d == 6)
        Z = pair.object_points(60, 45, d)[2]
        assert f"Z = {Z:.1f} m" in fig.get_suptitle()
        assert f"Disparity {d:.1f} px" in alt
    assert (given["disparity"].min, given["disparity"].max) == (-8, 8)


def test_glasses_get_the_left_photo_in_red(pair, figures, monkeypatch):
    given = {}
    monkeypatch.setattr(mark, "interact", lambda draw, **s: given.update(s, draw=draw))
    ch08_figures.mark_by_hand(pair, (60, 45))
    given["draw"](0.0, mark.GLASSES)
    red, green, blue = np.moveaxis(
        np.asarray(figures[0][0].axes[2].images[0].get_array()), -1, 0
    )
    assert np.array_equal(green, blue) and red[20, 20] == 1
    assert red[:, 20 - 5].min() == 1 and green[:, 20 - 5].min() == 1
    assert green[:, 20 + 3].max() == 0  # the right strip lies 6 px to the left


def test_a_mark_at_the_edge_is_refused(pair):
    with pytest.raises(ValueError, match="leaves the image"):
        ch08_figures.mark_positions(pair, (10, 45), (0,))


def test_one_photo_is_laid_on_the_other_by_the_disparity(pair, figures):
    for d in (6, 0, -3):
        ch08_figures.laid(pair, d)
        colours = np.asarray(figures[-1][0].axes[0].images[0].get_array())
        inside = colours[:, 10:110]
        assert np.array_equal(inside[..., 0], inside[..., 1]) == (d == 6)


def test_the_window_of_the_search_stands_where_r_is_highest(pair, figures):
    ch08_figures.row_search(pair, (55, 45), 9, 3, 9)
    fig, alt = figures[0]
    assert "7 values" in alt and "at 6 px" in alt
    frame = fig.axes[1].patches[0]
    assert frame.get_x() + frame.get_width() / 2 == 55 - 6


def test_the_threshold_says_what_it_keeps(figures):
    error = np.array([0.1, 0.2, 0.3, 0.4, 3.0, 4.0])
    r = np.array([0.9, 0.9, 0.9, 0.5, 0.9, 0.2])
    ch08_figures.height_threshold(error, r)
    assert "75 % of the right" in figures[0][1] and "50 % of the wrong" in figures[0][1]


def test_predicted_and_measured_errors_have_the_same_area(figures):
    error = np.random.default_rng(1).normal(0, 0.1, 4000)
    ch08_figures.height_errors(error, 0.1)
    fig, alt = figures[0]
    bars = sum(p.get_height() * p.get_width() for p in fig.axes[0].patches)
    x, y = fig.axes[0].lines[0].get_data()
    assert np.isclose(np.trapezoid(y, x), bars, rtol=0.01)
    assert "NMAD 0.10 m" in alt


def test_a_profile_follows_the_row_and_says_how_much_is_right(figures):
    land = good_arguments.level_land()
    X = np.linspace(-50, 50, 21)
    own = np.column_stack([X, 0.1 * X, np.where(X > 20, 25.0, 20.1)])
    own[3] = np.nan
    ch08_figures.height_profile(own, own, land)
    assert "70 % of the 20 heights" in figures[0][1]


def test_light_comes_from_the_upper_left():
    from pgm_book.ch08.figures import _shaded

    x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    assert _shaded(x + y, 1.0).mean() > _shaded(0 * x, 1.0).mean()
    assert _shaded(0 * x, 1.0).mean() > _shaded(-x - y, 1.0).mean()
    assert np.all(_shaded(np.full((4, 4), np.nan), 1.0) == 1)


@pytest.mark.parametrize("draw", ["sketch", "plane", "worth"])
def test_a_sketch_is_shown_with_its_words(draw, figures):
    getattr(ch08_figures, f"parallax_{draw}")()
    assert len(figures) == 1 and len(figures[0][1]) > 60


def test_half_the_base_makes_the_diamond_twice_as_high(figures):
    ch08_figures.parallax_worth()
    assert "2.0 times" in figures[0][1]
    tall = [np.ptp(ax.patches[0].get_xy()[:, 1]) for ax in figures[0][0].axes]
    assert 1.9 < tall[1] / tall[0] < 2.1
