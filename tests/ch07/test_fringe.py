"""Figures of two ortho images: what is drawn where, and what their words say."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch07 import figures as ch07_figures
from pgm_book.ch07.figures import fringe_by_hand as by_hand
from pgm_lab import plot
from pgm_lab.plot.basic import composite

EDGE = np.tile(np.arange(60) >= 30, (50, 1)) * 100.0  # dark left, bright from column 30
MOVED = np.roll(EDGE, 2, axis=1)
MOVED[:, :2] = 0


def test_where_both_are_alike_it_is_grey_and_elsewhere_one_colour_is_left():
    red, green, blue = np.moveaxis(composite(EDGE, MOVED), -1, 0)
    assert np.array_equal(red, blue)
    fringe = green > red
    assert set(np.flatnonzero(fringe.any(axis=0))) == {30, 31}
    assert np.array_equal(red[~fringe], green[~fringe])


def test_the_colours_of_the_paper_are_red_and_green():
    red, green, blue = np.moveaxis(composite(EDGE, MOVED, paper=True), -1, 0)
    assert not blue.any()
    assert np.all(green[:, 30] > red[:, 30])


def test_what_is_missing_is_white():
    again = np.ma.masked_array(EDGE, EDGE < 50)
    assert np.all(composite(EDGE, again)[:, :30] == 1)
    assert np.all(composite(np.where(EDGE < 50, np.nan, EDGE), EDGE)[:, :30] == 1)


def test_images_of_two_shapes_are_refused():
    for draw in (plot.overlay, ch07_figures.changes):
        with pytest.raises(ValueError, match="same pixels"):
            draw(EDGE, EDGE[1:])


def test_an_overlay_says_which_colour_is_which():
    fig = plot.overlay(EDGE, MOVED)
    assert fig.axes[0].get_title() == "green: reference, magenta: sensed, grey: alike"
    fig = plot.overlay(EDGE, MOVED, paper=True)
    assert "red: sensed" in fig.axes[0].get_title()
    plt.close("all")


def test_the_share_that_changed_stands_above_the_map():
    fig = ch07_figures.changes(EDGE, MOVED, limit=50)
    titles = [ax.get_title().replace("\n", " ") for ax in fig.axes]
    assert f"black: differ by more than 50 grey values, {100 * 2 / 60:.0f} %" in titles
    plt.close(fig)


def test_before_and_after_say_how_much_is_left(alt_of):
    again = np.where(np.arange(60) < 2, np.nan, EDGE)
    alt = alt_of(ch07_figures.before_and_after, EDGE, MOVED, again, limit=50)
    assert "Before, 3 %" in alt and "After, 0 %" in alt


def test_sliders_draw_the_sensed_image_back(monkeypatch):
    drawn, sliders = [], {}
    monkeypatch.setattr(ch07_figures, "interact", lambda f, **s: sliders.update(s, f=f))
    monkeypatch.setattr(
        ch07_figures.basic, "show", lambda fig, alt, **_: drawn.append((fig, alt))
    )
    by_hand(EDGE, MOVED, (30, 25), 21)
    for dx in (0, 2):
        sliders["f"](dx, 0)
        colours = np.asarray(drawn[-1][0].axes[0].images[0].get_array())
        grey = np.array_equal(colours[..., 0], colours[..., 1])
        assert grey == (dx == 2)
        assert f"back by {dx} columns" in drawn[-1][1]
    plt.close("all")


def test_a_part_beyond_the_image_is_refused():
    with pytest.raises(ValueError, match="leaves the image"):
        by_hand(EDGE, MOVED, (12, 25), 21)
    with pytest.raises(ValueError, match="leaves the image"):
        ch07_figures.two_colours(EDGE, MOVED, (12, 25), 31)
