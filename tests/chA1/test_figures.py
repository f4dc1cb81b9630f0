"""Figures of an adjustment: they say what was computed, and move with the sliders."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.chA1 import figures as estimates
from pgm_book.chA1 import figures as levelling
from pgm_lab import plot

LINES = ["AB", "BC", "CA"]
A = np.array([[1.0, 0], [-1, 1], [0, -1]])
P = np.array([1.0, 2, 0.5])
L = np.array([3.001, -1.0, -1.999])


@pytest.fixture(autouse=True, scope="module")
def style():
    with plt.rc_context(plot.STYLE):
        yield


def test_each_line_of_the_net_has_its_label(closed):
    fig = levelling.levelling_net(LINES, ["one", "two", "three"])
    written = [t.get_text() for t in fig.axes[0].texts]
    assert {"one", "two", "three", "A", "E", "known"} <= set(written)


def test_lines_that_are_none_are_refused():
    with pytest.raises(ValueError, match="lines must be names like 'AB'"):
        levelling.levelling_net(["AX"], ["one"])


def test_the_net_says_who_is_controlled(alt_of):
    assert "AB 0.50, BC 0.25, CA 0.90" in alt_of(
        levelling.levelling_control, LINES, [0.5, 0.25, 0.9]
    )


def test_bars_of_w_are_those_of_baarda(alt_of):
    # One loop of L / km = 1, 0.5, 2: all |w| are misclosure / (sigma0 root of 3.5)
    alt = alt_of(levelling.tested, A, P, {"ours": L}, 0.001, LINES)
    w = 2e-3 / (1e-3 * 3.5**0.5)
    assert f"ours: AB {w:.1f}, BC {w:.1f}, CA {w:.1f}" in alt


def test_a_blunder_moves_the_heights_by_what_its_residual_does_not_show(alt_of):
    alt = alt_of(levelling.blunder, A, P, L, 0.001, LINES, "AB", 7.0)
    # r of AB is 1 / 3.5; 7 mm leave 2 mm in the residual and 5 mm in the height of B
    assert "+7 mm in AB" in alt and "its r = 0.29" in alt and "B +5.0" in alt


def test_the_slider_and_the_list_choose_the_blunder(monkeypatch, closed):
    drawn, sliders = [], {}
    monkeypatch.setattr(levelling, "interact", lambda f, **s: sliders.update(s, f=f))
    monkeypatch.setattr(
        levelling.basic, "show", lambda fig, alt, **_: drawn.append((fig, alt))
    )
    levelling.blunder_by_hand(A, P, L, 0.001, LINES)
    assert sliders["line"].options == tuple(LINES)
    for size in (0, -20):
        sliders["f"]("CA", size)
        bars = drawn[-1][0].axes[0].patches
        assert bars[2].get_hatch() and not bars[0].get_hatch()
    assert "−20 mm in CA" in drawn[-1][1]
    assert "Bars of the shifts of the heights: B −0.0, C +0.0" not in drawn[-1][1]


def test_a_line_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match="line"):
        levelling.blunder(A, P, L, 0.001, LINES, "DE", 7.0)


def test_the_sum_of_the_parabolas_is_least_at_the_weighted_mean(alt_of):
    alt = alt_of(estimates.parabolas, [10.0, 10.004], [3, 1], ["a", "b"])
    assert "least at 10.0010 m" in alt


def test_the_residuals_stand_on_the_plane(closed):
    words = [t.get_text() for t in estimates.observation_space().axes[0].texts]
    assert "$v$" in words and "plane of all $Ax$" in words


def test_95_of_100_honest_surveys_lie_between_the_limits(alt_of):
    chi = np.random.default_rng(1).normal(size=(4000, 4))
    alt = alt_of(estimates.scatter, 2 * np.sqrt(np.mean(chi**2, axis=1)), 1.8, 2.0, 4)
    assert "95 per cent lie between the dashed limits 0.7 and 3.3 mm" in alt


def test_the_tangent_of_a_start_too_far_leads_behind_the_stations(alt_of):
    assert "at Y = -677 m" in alt_of(estimates.tangent, 140, 240, 720)
    # Near the point the tangent is the curve
    assert "at Y = 240 m" in alt_of(estimates.tangent, 140, 240, 241)


def test_a_point_has_the_standard_deviations_of_its_covariance(alt_of):
    errors = np.random.default_rng(1).normal(size=(50, 2)) * (0.02, 0.05)
    C = np.diag([0.02**2, 0.05**2])
    alt = alt_of(estimates.point, [(0.0, 0), (60, 0)], (30, 200), C, errors)
    assert "20 mm in X and 50 mm in Y" in alt
