"""Proofs of the verdicts on what Bani 2010 says about correlation: the search, figure
2.8 and what a coefficient of 0.746 means. For the formulas see test_bani2010_ncc.py."""

import re
from functools import cache

import numpy as np
import pytest
from pytest import approx
from scipy import stats

from pgm_book.ch02.checks import FIVE
from pgm_book.common import ledger
from pgm_lab import ncc, simulate

QUOTED = ledger.verdicts("2", ["Figure 4.6, r"])[0]["printed"]
PRINTED_R = float(QUOTED.split()[0])
RNG = np.random.default_rng(746)


def test_figure_2_8_prints_one_window_twice_as_no_two_photos_would():
    quoted = ledger.verdicts("2", ["Figure 2.8"])[0]["printed"]
    assert quoted.startswith(
        f"{FIVE.size} grey values from {FIVE.min()} to {FIVE.max()}"
    )
    assert ncc.correlation(FIVE, FIVE) == approx(1.0, abs=1e-14)
    # With noise of half a grey value in each photo before rounding, the chance that all
    # 25 agree is below 1e-7, wherever between two whole numbers the truth lies
    bounds = np.array([-0.5, 0.5])
    agree = []
    for between in np.linspace(-0.5, 0.5, 101):
        steps = np.arange(-5, 6)[:, None] + bounds - between
        share = np.diff(stats.norm.cdf(steps, scale=0.5)).ravel()
        agree.append(np.sum(share**2))
    assert max(agree) ** 25 < 1e-7


TEXTURE = simulate.texture(0.2, seed=1)
PLACES = np.random.default_rng(1).uniform(0, 5000, (200, 2))


@cache
def windows(c=1.0, s=0.0):
    """Windows of a texture at 200 places, turned or scaled."""
    step = np.stack(np.meshgrid(np.arange(-10, 11), np.arange(-10, 11)), axis=-1)
    step = step @ np.array([[c, s], [-s, c]])
    return simulate.grey_values(TEXTURE, PLACES[:, None, None] + step)


def seen_again(after):
    """r between windows and the same places as they are seen again."""
    both = zip(windows(), after, strict=True)
    return np.mean([ncc.correlation(a, b) for a, b in both])


def turned(degrees):
    return windows(np.cos(np.radians(degrees)), np.sin(np.radians(degrees)))


@pytest.mark.slow
def test_r_suffers_from_geometry_and_from_brightness_only_where_it_is_not_linear():
    assert seen_again(turned(10)) == approx(0.63, abs=0.01)
    assert seen_again(turned(20)) == approx(0.15, abs=0.01)
    assert seen_again(windows(1.2)) == approx(0.53, abs=0.01)
    # Gain and offset: nothing. A gamma of 1/2: hardly anything
    window = RNG.uniform(0, 200, (21, 21))
    assert ncc.correlation(window, 0.3 * window + 60) == approx(1, abs=1e-14)
    darker = 255 * (np.clip(windows(), 0, 255) / 255) ** 0.5
    assert seen_again(darker) == approx(0.99, abs=0.005)


def test_any_path_of_the_search_ends_at_the_same_highest_value():
    r = ncc.correlation_map(RNG.normal(size=(5, 5)), RNG.normal(size=(19, 23)))
    by_rows = list(np.ndindex(r.shape))  # as in the listing
    zigzag = [(i, j if i % 2 == 0 else r.shape[1] - 1 - j) for i, j in by_rows]
    # To and fro: each position once, none more than one pixel from the one before
    assert sorted(zigzag) == by_rows
    assert np.abs(np.diff(zigzag, axis=0)).sum(axis=1).max() == 1
    assert max(zigzag, key=lambda at: r[at]) == max(by_rows, key=lambda at: r[at])


def test_search_from_minus_15_to_15_has_31_by_31_positions_in_51_by_51_pixels():
    template = RNG.normal(size=(21, 21))
    r = ncc.correlation_map(template, RNG.normal(size=(51, 51)))
    assert r.shape == 2 * (len(range(-15, 15 + 1)),)  # both ends belong to the loops
    (quoted,) = ledger.verdicts("2", ["Listing, comment on the search"])
    commented = [int(n) for n in re.findall(r"\d+", quoted["printed"])]
    with pytest.raises(ValueError, match="search"):
        ncc.correlation_map(template, RNG.normal(size=commented))


def test_windows_with_the_printed_r_share_56_per_cent_of_their_variance():
    # A window with exactly this r to a first one, and the regression line through it
    a, e = stats.zscore(RNG.normal(size=(2, 441)), axis=1)
    e -= ncc.regression(a, e).beta * a
    b = PRINTED_R * a + np.sqrt(1 - PRINTED_R**2) * e / e.std()
    line = ncc.regression(a, b)
    assert line.r == approx(PRINTED_R, abs=1e-12)
    left_over = np.var(b - line.alpha - line.beta * a) / np.var(b)
    assert left_over == approx(1 - PRINTED_R**2, rel=1e-9)
    assert left_over == approx(0.444, abs=5e-4)
    # White noise in both photos takes r down to contrast^2 / (contrast^2 + sigma^2)
    sigma = np.sqrt(1 / PRINTED_R - 1)
    assert sigma == approx(0.584, abs=5e-4)
    scene = RNG.normal(size=200_000)
    noisy = scene + sigma * RNG.normal(size=(2, 200_000))
    assert ncc.correlation(*noisy) == approx(PRINTED_R, abs=0.005)


def test_printed_r_does_not_tell_the_right_place_where_the_pattern_repeats():
    # Dashes of a road marking, one every 26 rows, with the noise of the printed r
    rows, columns = np.mgrid[0:73, 0:47]
    road = (np.abs(columns - 23) < 3) * (0.5 + 0.5 * np.cos(2 * np.pi * rows / 26))
    sigma = np.sqrt(1 / PRINTED_R - 1) * road[13:34, 13:34].std()
    right, wrong = (13, 13), (39, 13)
    highest, best = [], []
    for _ in range(200):
        left, search = road + sigma * RNG.normal(size=(2, *road.shape))
        r = ncc.correlation_map(left[13:34, 13:34], search)
        best.append(np.unravel_index(r.argmax(), r.shape))
        highest.append(r.max())
    best = np.array(best)
    near = [np.abs(best - place).max(axis=1) <= 2 for place in (right, wrong)]
    assert np.mean(near[0] | near[1]) > 0.95
    # Half of the matches lie 26 px aside, with an r as high as that of the others
    assert np.mean(near[1]) == approx(0.5, abs=0.15)
    assert np.mean(np.array(highest)[near[1]]) == approx(
        np.mean(np.array(highest)[near[0]]), abs=0.01
    )
    assert np.mean(np.array(highest)[near[1]]) == approx(PRINTED_R, abs=0.03)
    # By chance alone 441 unrelated pixels do not reach it: 15 standard deviations
    chance = [ncc.correlation(*g) for g in RNG.normal(size=(2000, 2, 441))]
    assert PRINTED_R / np.std(chance) == approx(15.6, abs=1)
