"""Figures of chapter 2 are drawn as the notebook does; their words are true."""

import numpy as np
import pytest

from pgm_book.ch02 import case_figures
from pgm_book.ch02 import figures as of_lesson
from pgm_book.ch02.checks import FIVE
from pgm_lab import datasets, ncc

PAIR = datasets.motorcycle()
SEARCH = PAIR.left, PAIR.right, np.array([318, 318]), np.array([278, 318])
PLACES = [(100, 100), (200, 120), (300, 200), (400, 150)]
R = np.linspace(-1, 1, 9).reshape(3, 3)
SCENE = np.outer(np.arange(31), np.arange(31))
SHARES = {
    name: np.array([0.5, 0.64, 0.53])
    for name in ("stereo pair", "orthophoto", "texture")
}
POINT = np.array([332, 1063])
FIGURES = [
    (of_lesson.window_numbers, ({"g": FIVE, "dark": 255 - FIVE},), "dark: r = -1.00"),
    (of_lesson.window_numbers, ({"g": FIVE},), "A window of grey values"),
    (of_lesson.parts_of_r, (*SEARCH, 21, 81), "at the shift (-8, 0) px"),
    (of_lesson.summit, (np.array([[0.1, 0.5, 0.9, 0.7]]),), "dotted line at its top"),
    (
        case_figures.locking,
        (np.linspace(-0.5, 0.5, 3), {"soft": np.array([0, 0.01, -0.02])}),
        "soft at most 0.020 px",
    ),
    (
        of_lesson.right_and_wrong,
        (PAIR.left, PLACES, [True, True, False, True]),
        "4 accepted points. 1 are wrong",
    ),
    (case_figures.two_maps, (SCENE, R, R), "with the mean subtracted first"),
    (
        case_figures.before_and_after,
        ({"one": [0.9, 0.8, 0.7], "other": [0.9, 0.9, 0.2]},),
        "one: median 0.80; other: median 0.90",
    ),
    (
        case_figures.study,
        ([5, 9, 41], SHARES, SHARES),
        "motorcycle 64 % at most, 53 % at last",
    ),
    (
        case_figures.reach,
        (POINT, POINT - (64, 14), {"printed": 21, "needed": 149}),
        "(-64, -14) px",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), FIGURES, ids=[f[0].__name__ for f in FIGURES]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)


def test_small_templates_have_more_summits(alt_of):
    words = alt_of(of_lesson.templates, *SEARCH).split("above 0.6: ")[1]
    counts = [int(word.split(": ")[1]) for word in words.strip(". \n").split("; ")]
    assert counts[0] > 20 and counts[2:] == [1, 1]
    assert counts == sorted(counts, reverse=True)


def test_sliders_place_the_template(monkeypatch, figures):
    sliders = {}
    monkeypatch.setattr(of_lesson, "interact", lambda f, **s: sliders.update(s, f=f))
    of_lesson.search_by_hand(PAIR.left, PAIR.right, PAIR.disparity)
    for place in ((318, 318, 21), (130, 60, 61), (680, 440, 61)):
        assert all(
            sliders[name].min <= value <= sliders[name].max + 50
            for name, value in zip(("x", "y", "size"), place)
        )
        sliders["f"](*place)
        assert f"template of {place[2]} px at {place[:2]}" in figures[-1][1]
    circles = [line for line in figures[0][0].axes[2].lines if line.get_marker() == "o"]
    assert len(circles) == 1  # the truth


def test_five_of_six_searches_are_in_trouble_and_one_is_accepted(figures):
    six = of_lesson.six_troubles(PAIR, datasets.yellowstone().grey)
    found = [ncc.match(a, b, [p], [q], w, w + 60) for a, p, b, q, w, _ in six]
    of_lesson.gallery(six, [m.points[0] for m in found])
    assert len(figures[0][0].axes) == 3 * 6 + 1
    off = [np.abs(m.points[0] - s[-1]).max() for m, s in zip(found, six, strict=True)]
    accepted = [m.accepted[0] for m in found]
    assert accepted == [True, False, False, True, False, False]
    assert off[0] < 1 and min(off[1:]) > 2
