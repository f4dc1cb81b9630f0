"""Drawings of matching: windows lie where they say, the summit is the maximum."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.common import figures as common_figures
from pgm_lab import image

IMAGE = np.arange(63.0).reshape(7, 9)


@pytest.fixture
def axes():
    fig, ax = plt.subplots()
    yield ax
    plt.close(fig)


def test_window_lies_around_the_nearest_pixel():
    expected = IMAGE[2:5, 4:7]
    assert np.array_equal(image.cut(IMAGE, (5.4, 2.6), 3), expected)


@pytest.mark.parametrize("centre", [(0, 3), (8, 3), (4, 0), (4, 6), (-5, 3), (40, 3)])
def test_window_outside_the_image_is_refused(centre):
    with pytest.raises(ValueError, match="leaves"):
        image.cut(IMAGE, centre, 3)


@pytest.mark.parametrize("size", [4, 0, -3])
def test_window_without_a_middle_is_refused(size):
    with pytest.raises(ValueError, match="odd"):
        image.cut(IMAGE, (4, 3), size)


def test_pixel_of_a_drawn_window_lies_at_its_own_coordinates(axes):
    common_figures.draw_window(axes, IMAGE, (5, 2), 3)
    (drawn,) = axes.images
    left, right, bottom, top = drawn.get_extent()
    assert (left, right, bottom, top) == (3.5, 6.5, 3.5, 0.5)
    assert np.array_equal(drawn.get_array(), IMAGE[1:4, 4:7])


def test_outline_runs_along_the_outer_edges_of_the_pixels(axes):
    box = common_figures.outline(axes, (5, 2), 3)
    assert (box.get_xy(), box.get_width()) == ((3.5, 0.5), 3)


def test_middle_of_a_map_is_no_shift(axes):
    r = np.zeros((5, 5))
    assert common_figures.shifts(r)[2] == 0
    assert common_figures.draw_map(axes, r).get_extent() == [-2.5, 2.5, 2.5, -2.5]


def test_summit_is_marked_where_the_map_is_highest():
    rng = np.random.default_rng(2)
    r = rng.uniform(-0.5, 0.5, (7, 7))
    r[1, 5] = 0.9
    fig = plt.figure()
    ax = fig.add_subplot(projection="3d")
    assert common_figures.draw_surface(ax, r) == (2, -2)
    assert ax.yaxis_inverted()
    plt.close(fig)
