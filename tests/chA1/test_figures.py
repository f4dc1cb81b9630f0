"""Figures of an adjustment: they say what was computed, and move with the sliders."""

import numpy as np
import pytest

from pgm_book.chA1 import figures as of_lesson

LINES = ["AB", "BC", "CA"]
A = np.array([[1.0, 0], [-1, 1], [0, -1]])
P = np.array([1.0, 2, 0.5])
L = np.array([3.001, -1.0, -1.999])
# One loop of L / km = 1, 0.5, 2: all |w| are misclosure / (sigma0 root of 3.5)
W = 2e-3 / (1e-3 * 3.5**0.5)
RNG = np.random.default_rng(1)
SURVEYS = 2 * np.sqrt(np.mean(RNG.normal(size=(4000, 4)) ** 2, axis=1))
STATIONS, C = np.array([(0.0, 0), (60, 0)]), np.diag([0.02**2, 0.05**2])
ERRORS = RNG.normal(size=(50, 2)) * (0.02, 0.05)
DRAWN = [
    (
        of_lesson.levelling_control,
        (LINES, np.array([0.5, 0.25, 0.9])),
        "AB 0.50, BC 0.25, CA 0.90",
    ),
    (
        of_lesson.tested,
        (A, P, {"ours": L}, 0.001, LINES),
        f"ours: AB {W:.1f}, BC {W:.1f}, CA {W:.1f}",
    ),
    # r of AB is 1 / 3.5; 7 mm leave 2 mm in the residual and 5 mm in the height of B
    (of_lesson.blunder, (A, P, L, 0.001, LINES, "AB", 7.0), "its r = 0.29"),
    (of_lesson.blunder, (A, P, L, 0.001, LINES, "AB", 7.0), "B +5.0"),
    (
        of_lesson.parabolas,
        (np.array([10.0, 10.004]), np.array([3, 1]), ["a", "b"]),
        "smallest at 10.0010 m",
    ),
    (
        of_lesson.scatter,
        (SURVEYS, 1.8, 2.0, 4),
        "95 per cent lie between the dashed limits 0.7 and 3.3 mm",
    ),
    (of_lesson.tangent, (140, 240, 720), "at Y = -677 m"),
    # Near the point the tangent is the curve
    (of_lesson.tangent, (140, 240, 241), "at Y = 240 m"),
    (
        of_lesson.point,
        (STATIONS, (30, 200), C, ERRORS),
        "20 mm in X and 50 mm in Y",
    ),
]


@pytest.mark.parametrize(
    ("draw", "arguments", "words"), DRAWN, ids=[d[0].__name__ for d in DRAWN]
)
def test_figure_says_what_it_shows(draw, arguments, words, alt_of):
    assert words in alt_of(draw, *arguments)


@pytest.mark.parametrize(
    ("draw", "arguments", "words"),
    [
        (
            of_lesson.levelling_net,
            (LINES, ["one", "two", "three"]),
            {"one", "two", "three", "A", "E", "known"},
        ),
        (of_lesson.observation_space, (), {"$v$", "plane of all $Ax$"}),
    ],
)
def test_words_stand_in_the_drawing(draw, arguments, words, closed):
    written = {text.get_text() for text in draw(*arguments).axes[0].texts}
    assert words <= written


def test_the_slider_and_the_list_choose_the_blunder(monkeypatch, figures):
    sliders = {}
    monkeypatch.setattr(of_lesson, "interact", lambda f, **s: sliders.update(s, f=f))
    of_lesson.blunder_by_hand(A, P, L, 0.001, LINES)
    assert sliders["line"].options == tuple(LINES)
    for size in (0, -20):
        sliders["f"]("CA", size)
        bars = figures[-1][0].axes[0].patches
        assert bars[2].get_hatch() and not bars[0].get_hatch()
    assert "−20 mm in CA" in figures[-1][1]
    assert "Bars of the shifts of the heights: B −0.0, C +0.0" not in figures[-1][1]
