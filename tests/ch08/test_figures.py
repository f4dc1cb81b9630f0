"""Figures of chapter 8 and its case: what is drawn where, and what their words say."""

from types import SimpleNamespace

import numpy as np
import pytest

from pgm_book.ch08 import case_figures
from pgm_book.ch08 import figures as of_lesson
from pgm_lab import simulate, stereo

GREY = 50 + 10.0 * (np.indices((60, 80)).sum(axis=0) % 7)
PHOTO = SimpleNamespace(grey=GREY)
LINE = np.array([(0.0, 30), (79, 31)])
ERROR = np.array([0.1, 0.2, 0.3, 0.4, 3.0, 4.0])
OF_ERROR = np.array([0.9, 0.9, 0.9, 0.5, 0.9, 0.2])


def normal_pair(left, right):
    origin = np.array([(3.0, 0.0), (-6.0, 0.0)])
    stations = np.array([(0.0, 0, 1000), (400.0, 0, 1000)])
    return stereo.NormalPair(left, right, np.eye(3), stations, 24.0, 0.005, origin)


@pytest.fixture(scope="module")
def pair():
    """A bright strip whose disparity is 6 px; 0.5 m of height a pixel."""
    column = np.arange(120)
    left = np.tile(100.0 * (np.abs(column - 60) < 6), (90, 1))
    right = np.tile(100.0 * (np.abs(column - 54) < 6), (90, 1))
    return normal_pair(left, right)


DRAWN = [
    (of_lesson.parallax_sketch, (), "greater for the top than for the foot"),
    (of_lesson.parallax_plane, (), "all lie on the epipolar line of p'"),
    (of_lesson.parallax_worth, (), "2.0 times"),
    (
        of_lesson.epipolar_line,
        (PHOTO, PHOTO, (40, 30), LINE, LINE, (0, 20)),
        "2 strokes on it where the point would lie at 0, 20 m",
    ),
    (
        of_lesson.y_parallaxes,
        ({"as it is": np.array([0.0, 0.02, 0.1]), "ω": np.array([0.5, -0.4, 0.6])},),
        "as it is: 0.02 px; ω: 0.50 px",
    ),
    (
        of_lesson.height_threshold,
        (ERROR, OF_ERROR, 0.8),
        "At 0.8 it keeps 75 % of the right ones and 50 % of the wrong ones",
    ),
    (
        case_figures.compared,
        ({"open": (0.2, 0.1)}, {"open": (1.4, 1.5)}, 0.55),
        "right: open 0.20 and 0.10 m; base 0.55 m too long: open 1.40 and 1.50 m",
    ),
    (
        case_figures.bowl,
        (
            np.array([(0, 0), (9, 9), (0, 9)]),
            np.array([1.5, -2.5, 0]),
            np.array([0.05, -0.08, 0]),
        ),
        "from -2.5 to 1.5 m. Right a histogram of y parallaxes from -1 to 1 px: none is"
        " larger than 0.08 px",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), DRAWN, ids=[d[0].__name__ for d in DRAWN]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)


def test_photos_and_their_rows_are_drawn(pair, closed):
    assert len(of_lesson.photo_pair(PHOTO, PHOTO).axes) == 2
    rows = of_lesson.epipolar_rows(PHOTO, PHOTO, pair, 30, (10, 90)).axes
    assert all(ax.lines[0].get_ydata()[0] == 30 for ax in rows)


def green_and_magenta_agree(ax):
    colours = np.asarray(ax.images[0].get_array())
    return np.array_equal(colours[..., 0], colours[..., 1])


def test_the_slider_moves_the_right_photo_and_says_the_height(
    pair, figures, monkeypatch
):
    given = {}
    monkeypatch.setattr(
        of_lesson, "interact", lambda draw, **s: given.update(s, draw=draw)
    )
    of_lesson.mark_by_hand(pair, (60, 45), start=0, reach=8)
    for d in (0.0, 6.0):
        given["draw"](d, of_lesson.COLOURS)
        fig, alt = figures[-1]
        assert green_and_magenta_agree(fig.axes[2]) == (d == 6)
        Z = pair.object_points(60, 45, d)[2]
        assert f"Z = {Z:.1f} m" in fig.get_suptitle()
        assert f"Disparity {d:.1f} px" in alt
    assert (given["disparity"].min, given["disparity"].max) == (-8, 8)
    # Glasses get the left photo in red
    given["draw"](0.0, of_lesson.GLASSES)
    image = np.asarray(figures[-1][0].axes[2].images[0].get_array())
    red, green, blue = np.moveaxis(image, -1, 0)
    assert np.array_equal(green, blue) and red[20, 20] == 1
    assert red[:, 20 - 5].min() == 1 and green[:, 20 - 5].min() == 1
    assert green[:, 20 + 3].max() == 0  # the right strip lies 6 px to the left


def test_the_window_of_the_search_stands_where_r_is_highest(pair, figures):
    of_lesson.row_search(pair, (55, 45), 9, 3, 9)
    fig, alt = figures[0]
    assert "7 values" in alt and "at 6 px" in alt
    frame = fig.axes[1].patches[0]
    assert frame.get_x() + frame.get_width() / 2 == 55 - 6


# --- The case of the three locations ---


@pytest.mark.parametrize("disparity", [0, -6, 9])
def test_the_scale_shows_the_disparity_of_the_same_ground(figures, disparity):
    """A bright pixel is moved by a disparity; it is found where the scale says so."""
    left, right = np.zeros((2, 60, 120))
    left[30, 60] = right[30, 60 - disparity] = 100
    places = np.array([(60, 30)])
    case_figures.marks(normal_pair(left, right), places, [disparity + 5])
    tile, strip = (ax.images[0] for ax in figures[0][0].axes)
    assert np.argwhere(tile.get_array() > 0.5).tolist() == [[9, 15]]
    first, last, *_ = strip.get_extent()
    ((row, column),) = np.argwhere(strip.get_array() > 0.5)
    assert row == 9 and first - 0.5 - column == disparity and last < first


@pytest.fixture(scope="module")
def surveyed():
    """A landscape, its surface 5 m too high, and its ground as it is."""
    land = simulate.landscape((-30, -20, 30, 20), seed=3)
    x, y = np.meshgrid(np.arange(-28.0, 28, 2), np.arange(18.0, -18, -2))
    z = land.at(land.dtm, x, y)
    dsm = stereo.Surface(z + 5, (-28.0, 18.0), 2.0, z > -1)
    dtm = stereo.Terrain(z, np.zeros(z.shape, np.uint8), (-28.0, 18.0), 2.0)
    return land, dsm, dtm


def test_a_terrain_without_error_says_so(alt_of, surveyed):
    land, dsm, dtm = surveyed
    assert "RMSE 0.00 m open" in alt_of(of_lesson.terrain, dsm, dtm, land)
