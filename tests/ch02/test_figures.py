"""Figures of the search by correlation: they show what they get, in words too."""

import numpy as np
import pytest

from pgm_book.ch02 import case_figures as ch02_case_figures
from pgm_book.ch02 import figures as ch02_figures
from pgm_book.ch02 import figures as search
from pgm_book.ch02.checks import FIVE
from pgm_lab import datasets, ncc


@pytest.fixture(scope="module")
def pair():
    return datasets.motorcycle()


def test_r_with_the_first_window_stands_below_each(figures):
    ch02_figures.window_numbers({"g": FIVE, "negative": 255 - FIVE})
    fig, alt = figures[0]
    assert [ax.get_xlabel() for ax in fig.axes] == ["r = 1.00", "r = −1.00"]
    assert "negative: r = -1.00" in alt


def test_a_single_window_shows_its_grey_values_and_no_r(figures):
    ch02_figures.window_numbers({"g": FIVE})
    fig, alt = figures[0]
    assert [int(t.get_text()) for t in fig.axes[0].texts] == FIVE.ravel().tolist()
    assert "r =" not in alt


def test_the_arrow_of_another_exposure_lies_along_the_first(figures):
    ch02_figures.window_arrows()
    fig, _ = figures[0]
    arrows = [t for t in fig.axes[1].texts if not t.get_text()]
    a, other, negative, b = (np.array(arrow.xy) for arrow in arrows)
    np.testing.assert_allclose(other, 0.6 * a)
    np.testing.assert_allclose(negative, -a)
    cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
    assert np.isclose(cosine, ncc.correlation([[60, 110, 40]], [[50, 70, 120]]))


def test_the_parts_of_a_search_say_the_shift(figures, pair):
    ch02_figures.parts_of_r(pair.left, pair.right, (318, 318), (278, 318))
    assert "at the shift (-8, 0) px" in figures[0][1]


def test_small_templates_have_more_summits(figures, pair):
    ch02_figures.templates(pair.left, pair.right, (318, 318), (278, 318))
    words = figures[0][1].split("above 0.6: ")[1].rstrip(".").split("; ")
    counts = [int(word.split(": ")[1]) for word in words]
    assert counts[0] > 20 and counts[2:] == [1, 1]
    assert counts == sorted(counts, reverse=True)


def test_sliders_place_the_template(monkeypatch, figures, pair):
    sliders = {}
    monkeypatch.setattr(search, "interact", lambda f, **s: sliders.update(s, f=f))
    ch02_figures.search_by_hand(pair.left, pair.right, pair.disparity)
    for name, value in (("x", 640), ("y", 420), ("size", 61)):
        assert sliders[name].min <= value <= sliders[name].max + 50
    for place in ((318, 318, 21), (130, 60, 61), (680, 440, 61)):
        sliders["f"](*place)
        assert f"template of {place[2]} px at {place[:2]}" in figures[-1][1]
    circles = [line for line in figures[0][0].axes[2].lines if line.get_marker() == "o"]
    assert len(circles) == 1  # the truth


def test_five_of_six_searches_are_in_trouble_and_one_is_accepted(figures, pair):
    six = ch02_figures.six_troubles(pair, datasets.yellowstone().grey)
    found = [ncc.match(a, b, [p], [q], w, w + 60) for a, p, b, q, w, _ in six]
    ch02_figures.gallery(six, [m.points[0] for m in found])
    assert len(figures[0][0].axes) == 3 * 6 + 1
    off = [np.abs(m.points[0] - s[-1]).max() for m, s in zip(found, six, strict=True)]
    accepted = [m.accepted[0] for m in found]
    assert accepted == [True, False, False, True, False, False]
    assert off[0] < 1 and min(off[1:]) > 2


def test_right_and_wrong_points_are_counted(figures, pair):
    places = [(100, 100), (200, 120), (300, 200), (400, 150)]
    ch02_figures.right_and_wrong(pair.left, places, [True, True, False, True])
    fig, alt = figures[0]
    names = [line.get_label() for line in fig.axes[0].lines]
    assert names == ["right, 75 %", "wrong, 25 %"] and "1 are wrong" in alt


def test_the_top_of_the_parabola_is_marked(figures):
    ch02_figures.summit([0.5, 0.9, 0.7])
    curve, dots, top = figures[0][0].axes[0].lines
    assert np.isclose(top.get_xdata()[0], 1 / 6)
    assert np.allclose(
        np.interp((-1, 0, 1), *curve.get_data()), dots.get_ydata(), atol=1e-3
    )


def test_locking_says_how_far_it_goes(figures):
    ch02_figures.locking([-0.5, 0, 0.5], {"soft": [0, 0.01, -0.02]})
    assert "soft at most 0.020 px" in figures[0][1]


def test_depths_are_drawn_on_one_scale(figures, pair):
    places, true = [(100, 100), (200, 120)], [10.0, 40]
    ch02_figures.depths(pair.left, places, [11.0, np.nan], true)
    limits = [ax.collections[0].get_clim() for ax in figures[0][0].axes[:2]]
    assert limits == [(10, 40), (10, 40)]


def test_figures_of_the_case_say_what_they_show(figures):
    r = np.linspace(-1, 1, 9).reshape(3, 3)
    ch02_case_figures.two_maps(np.outer(np.arange(31), np.arange(31)), r, r)
    ch02_case_figures.before_and_after(
        {"one": [0.9, 0.8, 0.7], "other": [0.9, 0.9, 0.2]}
    )
    names = ("stereo pair", "orthophoto", "texture")
    shares = {name: [0.5, 0.64, 0.53] for name in names}
    ch02_case_figures.study([5, 9, 41], shares, shares)
    ch02_case_figures.reach((332, 1063), (268, 1049), {"printed": 21, "needed": 149})
    words = [alt for _, alt in figures]
    assert "one: median 0.80; other: median 0.90" in words[1]
    assert "motorcycle 64 % at most, 53 % at last" in words[2]
    assert "(-64, -14) px" in words[3]
    (match,) = [p for p in figures[3][0].axes[0].patches if p.get_width() == 19]
    assert match.get_xy() == (268 - 9.5, 1049 - 9.5)
