"""Figures of the case of the three locations: they show what they get, in words too."""

import numpy as np
import pytest

from pgm_book.ch08 import case_figures as _follows
from pgm_book.ch08 import case_figures as ch08_case_figures
from pgm_lab import simulate, stereo


def test_bars_of_the_differences_are_as_long_as_the_rounding(figures):
    ch08_case_figures.six((44, 71), (1.39, 1.71), (1.42, 1.75))
    fig, alt = figures[0]
    (bars,) = fig.axes[1].collections
    low, high = np.array([one[:, 1] for one in bars.get_segments()]).T
    assert low == pytest.approx([2, 3]) and high == pytest.approx([4, 5])  # cm
    assert "location 2: 1.71 and 1.75 m, difference 4 ± 1 cm" in alt


@pytest.mark.parametrize("disparity", [0, -6, 9])
def test_the_scale_shows_the_disparity_of_the_same_ground(figures, disparity):
    """A bright pixel is moved by a disparity; it is found where the scale says so."""
    left, right = np.zeros((2, 60, 120))
    left[30, 60] = right[30, 60 - disparity] = 100
    origin, stations = np.zeros((2, 2)), np.array([(0.0, 0, 9), (1, 0, 9)])
    pair = stereo.NormalPair(left, right, np.eye(3), stations, 24.0, 0.005, origin)
    ch08_case_figures.marks(pair, [(60, 30)], [disparity + 5])
    tile, strip = (ax.images[0] for ax in figures[0][0].axes)
    assert np.argwhere(tile.get_array() > 0.5).tolist() == [[9, 15]]
    first, last, *_ = strip.get_extent()
    ((row, column),) = np.argwhere(strip.get_array() > 0.5)
    assert row == 9 and first - 0.5 - column == disparity and last < first


def test_a_mark_near_the_edge_is_refused():
    pair = simulate_pair()
    places = (10, 30), (110, 30), (60, 5), (60, 55)
    for place, start in (*((place, 0) for place in places), ((60, 30), 45)):
        with pytest.raises(ValueError, match="edge"):
            ch08_case_figures.marks(pair, [place], [start])
    with pytest.raises(ValueError, match="one to four"):
        ch08_case_figures.marks(pair, [(60, 30)] * 5, [0] * 5)


def simulate_pair():
    origin, stations = np.zeros((2, 2)), np.array([(0.0, 0, 9), (1, 0, 9)])
    blank = np.zeros((60, 120))
    return stereo.NormalPair(blank, blank, np.eye(3), stations, 24.0, 0.005, origin)


def test_a_profile_runs_through_the_chosen_row(figures):
    land = simulate.landscape((-30, -20, 30, 20), seed=3)
    x, y = np.meshgrid(np.arange(-28.0, 28, 2), np.arange(18.0, -18, -2))
    z = land.at(land.dtm, x, y)
    dsm = stereo.Surface(z + 5, (-28.0, 18.0), 2.0, z > -1)
    dtm = stereo.Terrain(z, np.zeros(z.shape, np.uint8), (-28.0, 18.0), 2.0)
    spots = np.array([(0.0, 10.0, 7.0), (5.0, -10.0, 8.0)])
    ch08_case_figures.gaps(land, spots, dsm, dtm, row=4)  # Y = 10
    above, below = figures[0][0].axes
    assert above.lines[0].get_xydata().tolist() == spots[:, :2].tolist()
    lines = {line.get_label(): line for line in below.lines}
    assert lines["operator"].get_xydata().tolist() == [[0, 7]]
    for name in ("true ground", "automatic, filtered"):
        assert np.allclose(lines[name].get_ydata(), z[4])


def test_bars_are_as_high_as_their_numbers(figures):
    ch08_case_figures.compared({"open": (0.2, 0.1)}, {"open": (1.4, 1.5)}, 0.55)
    fig, alt = figures[0]
    heights = [[bar.get_height() for bar in ax.patches] for ax in fig.axes]
    assert heights == [[0.2, 0.1], [1.4, 1.5]]
    assert (
        "right: open 0.20 and 0.10 m; base 0.55 m too long: open 1.40 and 1.50 m" in alt
    )


def test_nothing_to_compare_is_refused():
    with pytest.raises(ValueError, match="one kind of ground"):
        ch08_case_figures.compared({}, {}, 0.55)


def test_a_bowl_says_its_range_and_the_largest_parallax(figures):
    ch08_case_figures.bowl([(0, 0), (9, 9), (0, 9)], (1.5, -2.5, 0), (0.05, -0.08, 0))
    alt = figures[0][1]
    assert "from -2.5 to 1.5 m" in alt and "larger than 0.08 px" in alt
    with pytest.raises(ValueError, match="one length"):
        ch08_case_figures.bowl([(0, 0)], (1.0, 2.0), (0.1, 0.1))


def test_every_figure_printed_stands_in_a_box(figures):
    ch08_case_figures.follows()
    fig, alt = figures[0]
    texts = [text.get_text() for text in fig.axes[0].texts if text.get_text()]
    assert len(texts) == len(_follows.BOXES)
    assert all(end in _follows.BOXES for arrow in _follows.ARROWS for end in arrow)
    for _, _, printed, fate in _follows.BOXES.values():
        assert any(
            printed in text and (fate in text or fate == "given") for text in texts
        )
    assert "Purple has no source" in alt
