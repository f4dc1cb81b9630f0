"""Proofs of the verdicts on Harintaka 2020, the numbers of its stereo plotting: Table 1
and what the text says of it, tie points, figure 6, contours. The errors behind Table 1
are not printed: what is proved is what follows from its eighteen digits."""

import itertools
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx
from scipy import stats

from pgm_book.common import ledger
from pgm_lab import datasets, frames

DATA = datasets.harintaka2020()
N, INTERACTIVE, AUTOMATIC = DATA.test_points, DATA.interactive, DATA.automatic
BOTH = np.stack([INTERACTIVE, AUTOMATIC])
HALF_DIGIT = 0.005  # m, of a printed mean
PIXEL, SENSOR = DATA.camera_pixel_size, np.array(DATA.camera_image_size)
HEIGHT, C = DATA.flight["flying_height"], DATA.flight["principal_distance"]
GSD = frames.ground_sampling_distance(PIXEL, HEIGHT, C)
# The base is not printed: 60 per cent overlap along the long or the short side
BASES = 0.4 * SENSOR * GSD
PER_PIXEL = HEIGHT / BASES * GSD  # m of height for a pixel of parallax


PRINTED = {
    row["place"]: row["printed"]
    for row in ledger.verdicts("8", source="Harintaka 2020")
}


def said(place):
    """Numbers that are printed at a place, as the ledger has them."""
    text = PRINTED[place].replace(",", "")
    return np.array([float(one) for one in re.findall(r"\d+(?:\.\d+)?", text)])


def rms(values, axis=-1):
    return np.sqrt(np.mean(np.square(values), axis=axis))


# Table 1


def test_no_reading_of_the_six_means_needs_other_points():
    """Six lists of errors of the printed numbers have the printed means, three ways."""
    rng = np.random.default_rng(1)
    for n, means in zip(N, BOTH.T):
        for mean in means:
            errors = rng.normal(0, 1, n)
            signed = errors - errors.mean() + mean
            absolute = errors * mean / np.abs(errors).mean()
            squared = errors * mean / rms(errors)
            assert signed.mean() == approx(mean)
            assert np.abs(absolute).mean() == approx(mean)
            assert rms(squared) == approx(mean)
            # And their scatter about their mean differs: 1 m, mean / 0.80, mean
            assert signed.std() < 1.3 and squared.std() > mean - 0.1


def test_three_readings_of_mean_accuracy_differ_by_a_quarter_and_more():
    """Normal errors about zero: mean |e| = 0.80 RMSE, and the signed mean is zero."""
    errors = np.random.default_rng(2).normal(0, 1, 1_000_000)
    assert np.abs(errors).mean() == approx(np.sqrt(2 / np.pi), abs=2e-3)
    assert abs(errors.mean()) < 0.005
    as_absolute = BOTH / np.sqrt(2 / np.pi)  # RMSE, if the table holds means of |e|
    assert as_absolute.min() == approx(1.68, abs=0.005)
    assert as_absolute.max() == approx(2.19, abs=0.005)
    # As signed means all six are 19 or more standard errors from zero if each point
    # scatters by half a metre: one shift would mend them
    assert (BOTH.min() / (0.5 / np.sqrt(N))).min() > 17


def test_weighted_means_of_table_1_are_150_and_153_and_only_location_2_gives_17():
    means = BOTH @ N / N.sum()
    pooled = np.sqrt(BOTH**2 @ N / N.sum())  # if the entries are RMSE
    assert [*means, *pooled] == approx([1.503, 1.533, 1.513, 1.544], abs=5e-4)
    each = BOTH.mean(axis=0)  # location, over both methods
    every = [*means, *pooled, *BOTH.mean(axis=1), np.mean(BOTH), *BOTH.ravel(), *each]
    near = [value for value in every if 1.65 <= value < 1.75]
    assert near == [INTERACTIVE[1], each[1]] == approx([1.71, 1.73])
    # To one decimal the text's horizontal 1.5 is what the table gives for the vertical
    assert set(np.round([*means, *pooled], 1)) == {1.5}


def test_differences_overlap_when_the_digits_are_rounded():
    difference = AUTOMATIC - INTERACTIVE
    assert difference == approx([0.03, 0.04, 0.02])
    low, high = difference - 2 * HALF_DIGIT, difference + 2 * HALF_DIGIT
    assert low[1] < high[0] and low[0] < high[2]
    assert low[1] == approx(high[2])  # 2 exceeds 3, perhaps by a hair
    # As a share of the mean location 1 differs as much as location 2
    share = difference / INTERACTIVE
    assert share == approx([0.0216, 0.0234, 0.0149], abs=5e-5)


def test_three_locations_and_one_factor_of_2_per_cent_give_all_six_numbers():
    """Four numbers for six, rounded as printed: nothing is left for location 2."""
    location = np.array([1.39, 1.712, 1.337])
    assert np.round(location, 2) == approx(INTERACTIVE)
    assert np.round(1.02 * location, 2) == approx(AUTOMATIC)
    # The locations differ more than ten times as much as the two methods
    assert np.ptp(location) / np.mean(AUTOMATIC - INTERACTIVE) > 10
    # And one number for all is not enough: the locations are needed
    assert np.abs(BOTH - BOTH.mean()).max() > 0.2


def test_two_methods_may_differ_from_4_cm_to_346_m_at_each_point_of_location_2():
    """The triangle inequality, for RMSE and for mean |e|; both ends are reached."""
    n, (i, a) = N[1], BOTH[:, 1]
    errors = np.random.default_rng(3).normal(0, 1, n)
    errors *= i / rms(errors)
    alike, opposed = errors * a / i, -errors * a / i
    assert rms(alike - errors) == approx(a - i) == approx(0.04)
    assert rms(opposed - errors) == approx(a + i) == approx(3.46)
    for other in (alike, opposed):
        assert rms(other) == approx(a)
    # Any value between: mix with errors at right angles
    for wanted in (0.5, 2.0):
        across = np.random.default_rng(4).normal(0, 1, n)
        across -= errors * (across @ errors) / (errors @ errors)
        across *= i / rms(across)
        cosine = (i**2 + a**2 - wanted**2) / (2 * i * a)
        mixed = a / i * (cosine * errors + np.sqrt(1 - cosine**2) * across)
        assert rms(mixed) == approx(a)
        assert rms(mixed - errors) == approx(wanted)


def test_4_cm_of_71_points_need_errors_that_agree_within_17_cm():
    """Two RMSE of the same n points: sd of their difference s sqrt((1 - rho^2) / n)."""
    n, s = N[1], BOTH[:, 1].mean()
    rng = np.random.default_rng(5)
    for rho in (0.0, 0.9, 0.995):
        first, second = rng.normal(0, s, (2, 20_000, n))
        second = rho * first + np.sqrt(1 - rho**2) * second
        spread = np.std(rms(second) - rms(first))
        assert spread == approx(s * np.sqrt((1 - rho**2) / n), rel=0.02)
    # 0.04 m are two standard deviations from rho = 0.995 on
    rho = np.sqrt(1 - (0.02 / s) ** 2 * n)
    assert rho == approx(0.9952, abs=1e-4)
    assert s * np.sqrt(2 * (1 - rho)) == approx(0.17, abs=0.005)
    # Independent errors: 0.04 m are a fifth of one standard deviation
    assert 0.04 / (s / np.sqrt(n)) == approx(0.195, abs=0.002)


# Numbers of the text that follow from others, or do not


FIGURE_6 = said("Gambar 6, three sizes")
SHOWN, SCALES = FIGURE_6[:3], FIGURE_6[4::2]  # px; 1:1500, 1:500, 1:250
SCREEN = 25.4 / 96  # mm, a pixel of a common screen
ON_SCREEN = GSD / SCALES * 1000  # mm, a pixel of the photo
ALLOWED = np.sqrt(2) * PER_PIXEL  # sigma of both photos is in a parallax, in pixels
FLIGHT = DATA.flight
NUMBER = np.array([FLIGHT["least_scale_number"], FLIGHT["greatest_scale_number"]])
SHARE = (AUTOMATIC - INTERACTIVE) / AUTOMATIC
TIE_PLAN, TIE_HEIGHT = said("Metode, tie points") / 1000  # m
(VERTICAL,) = said("Hasil dan Pembahasan, vertical")
INTERVAL, _, MAP = said("Hasil dan Pembahasan, contour interval")
BITS = FLIGHT["radiometric_resolution"] / 3  # of a colour
NINE_TENTHS = stats.norm.ppf(0.95)  # of the points within this many sd
# One plausible camera of medium format, flown from 500 to 2000 m, overlaps of 60 and
# 80 per cent, the mark set to half a pixel or to two
HEIGHTS = [H / (q * 7000) * s for H in (500, 1000, 2000) for q in (0.2, 0.4)
           for s in (0.5, 2.0)]  # fmt: skip

# What is said: computed, expected, tolerance
FOLLOWS = {
    "base of 60 per cent": (BASES, [392.4, 260.6], 0.05),
    "a pixel of parallax in m": (PER_PIXEL, [0.583, 0.878], 5e-4),
    "Table 1 in pixels, least": (BOTH.min() / PER_PIXEL, [2.30, 1.53], 0.005),
    "Table 1 in pixels, most": (BOTH.max() / PER_PIXEL, [3.00, 1.99], 0.005),
    "Table 1 in per mille of H": (BOTH.min() / HEIGHT * 1000, 1.34, 0.005),
    "4 cm between the two methods": ((0.04 / PER_PIXEL).max(), 0.07, 0.005),
    "heights of flight and relief": (NUMBER * C / 1000, [936, 1032], 1e-9),
    # With one base sigma_Z goes with the square of the height: too little
    "sigma_Z by the height": ((NUMBER[1] / NUMBER[0]) ** 2, 1.216, 5e-4),
    "location 2 over 3": ((BOTH[:, 1] / BOTH[:, 2]).min(), 1.276, 5e-4),
    "setting of half a pixel": (PER_PIXEL / 2, [0.29, 0.44], 0.005),
    "1.7 m by that setting": (VERTICAL / (PER_PIXEL / 2), [5.8, 3.9], 0.05),
    "tie points in plan, pixels": (TIE_PLAN / GSD, 0.066, 5e-4),
    "tie points in height, pixels": (TIE_HEIGHT / PER_PIXEL, [0.069, 0.046], 5e-4),
    "parts of a pixel, of both photos": (PER_PIXEL / TIE_HEIGHT, [14.6, 21.9], 0.05),
    "parts of a pixel, of each": (ALLOWED / TIE_HEIGHT, [20.6, 31.0], 0.05),
    "least by tie points": (BOTH.min() / TIE_HEIGHT, 33.5, 1e-6),
    "most by tie points": (BOTH.max() / TIE_HEIGHT, 43.75, 1e-6),
    "sigma naught of a pixel": (ALLOWED, [0.82, 1.24], 0.005),
    # Rounded to five pixels, as all three seem to be, one size gives them
    "figure 6 in mm": (SHOWN * GSD / SCALES * 1000, [48.8, 48.0, 50.3], 0.05),
    "its least size": (((SHOWN - 2.5) * GSD / SCALES).max() * 1000, 48.4, 0.05),
    "its greatest size": (((SHOWN + 2.5) * GSD / SCALES).min() * 1000, 49.2, 0.05),
    "figure 6, widths by scales": (SHOWN / SCALES * 500, [106.7, 105, 110], 0.05),
    "a pixel on it in mm": (ON_SCREEN, [0.1525, 0.4575, 0.915], 1e-6),
    "in pixels of the screen": (ON_SCREEN / SCREEN, [0.58, 1.73, 3.46], 0.005),
    "1:1 on the screen": (GSD / SCREEN * 1000, 865, 0.5),
    "at H/f in m": (SCREEN / 1000 * FLIGHT["mean_scale_number"], 10.6, 0.05),
    "in pixels of the photo": (SCREEN / 1000 * 40_000 / GSD, 46, 0.5),
    "grey values of a colour": (2**BITS, 1.0 + np.iinfo(np.uint8).max, 1e-9),
    "a pixel of level 6 in m": (2 ** (6 - 1) * PER_PIXEL, [18.7, 28.1], 0.05),
    "photo at level 6": (SENSOR // 32, [134, 89], 0),
    "a relief of 40 m on it": (40 / (32 * PER_PIXEL), [2.1, 1.4], 0.05),
    "contours in mm of the map": (INTERVAL / MAP * 1000, 0.5, 1e-9),
    # Nine of ten points within half an interval; or an RMSE of a third of one
    "RMSE by nine points of ten": (INTERVAL / 2 / NINE_TENTHS, 0.76, 0.005),
    "RMSE by a third": (INTERVAL / 3, 0.83, 0.005),
    "interval for 1.34 m": (3 * BOTH.min(), 4.02, 1e-6),
    "interval for 1.75 m": (2 * NINE_TENTHS * BOTH.max(), 5.76, 0.005),
}  # fmt: skip


@pytest.mark.parametrize("said", FOLLOWS)
def test_numbers_that_follow_from_others(said):
    computed, expected, tolerance = FOLLOWS[said]
    close(computed, expected, rtol=0, atol=tolerance)


def test_bounds_that_decide_nothing():
    # Three differences of one sign happen by chance in one of four
    signs = list(itertools.product((-1, 1), repeat=3))
    assert np.mean([abs(sum(one)) == 3 for one in signs]) == 0.25
    assert np.all(AUTOMATIC > INTERACTIVE)
    # "Very accurate" stands for means that are smaller by 1.5 to 2.3 per cent, and
    # what needs hardly any editing in Table 2 needs none in the abstracts
    assert [SHARE.min(), SHARE.max()] == approx([0.015, 0.023], abs=5e-4)
    edited = PRINTED["Table 2, editing"], PRINTED["abstracts and Kesimpulan, editing"]
    assert ["hampir tidak" in words for words in edited] == [True, False]
    # At least 140 of 175 are no control or check points
    control, *locations = said("Metode and Table 1, points")
    assert locations == list(N) and sum(locations) - control == 140
    # One H/f: by the base a pixel is worth from 0.3 to 3.5 m
    worth = HEIGHT / np.multiply.outer([0.1, 0.9], SENSOR * GSD) * GSD
    assert worth.min() < 0.3 and worth.max() > 3.5
    # 40 mm need a sigma naught of a twentieth of a pixel: the bound says 20 times more
    assert (ALLOWED / TIE_HEIGHT).min() > 20
    # 87 cm need a pixel, a height and a base that are not printed
    (centimetres,) = said("Pendahuluan, Pranadita")
    assert min(HEIGHTS) < centimetres / 100 / 4 and max(HEIGHTS) > centimetres / 100


def test_location_2_is_the_worst_for_both_methods_and_hardly_by_chance():
    """If the entries are RMSE of normal errors: the largest against the two others, by
    chance. Location 2 was not named beforehand: it is the largest of three."""

    def others(squares, k):
        two = np.delete(squares, k, axis=-1) @ np.delete(N, k)
        return two / (N.sum() - N[k])

    ratio = BOTH[:, 1] ** 2 / others(BOTH**2, 1)
    drawn = np.random.default_rng(10).chisquare(N, (100_000, 3)) / N
    most = np.max([drawn[:, k] / others(drawn, k) for k in range(3)], axis=0)
    chance = np.mean(most[:, None] >= ratio, axis=0)
    assert np.all((0.05 < chance) & (chance < 0.065))
    # Of a location that was named it would be a third of that: the F test, one-sided
    named = stats.f.sf(ratio, N[1], N[0] + N[2])
    assert named == approx([0.017, 0.015], abs=5e-4)
    # It is larger by 0.35 m in both, and one method larger than the other by 0.04
    assert BOTH[:, 1] - np.sqrt(others(BOTH**2, 1)) == approx([0.35, 0.365], abs=0.005)


# What 1.4 to 1.7 m are


def test_horizontal_15_beside_vertical_17_m_is_not_what_image_noise_does():
    """Two rays, the same noise in each of four coordinates, flat ground: over the whole
    overlap, and in its corners."""
    rng = np.random.default_rng(6)

    def ratio(x, y, base):
        noise = rng.normal(0, PIXEL / 10, (4, len(x)))
        p = base * C / HEIGHT  # x counts from mid base
        left = (x + p / 2 + noise[0], y + noise[1])
        right = (x - p / 2 + noise[2], y + noise[3])
        scale = base / (left[0] - right[0])
        Z = rms(C * scale - HEIGHT)
        X = rms(scale * left[0] - base / 2 - x * HEIGHT / C)
        Y = rms(scale * (left[1] + right[1]) / 2 - y * HEIGHT / C)
        return Z / np.hypot(X, Y)

    for base, along, across, whole, corner in zip(
        BASES, SENSOR, SENSOR[::-1], (2.66, 2.80), (1.93, 1.79)
    ):
        reach = np.array([0.6 * along, across]) / 2 * PIXEL
        x, y = rng.uniform(-reach, reach, (50_000, 2)).T
        assert ratio(x, y, base) == approx(whole, abs=0.04)
        x, y = np.tile(reach, (50_000, 1)).T
        assert ratio(x, y, base) == approx(corner, abs=0.04)
    (horizontal,) = said("Hasil dan Pembahasan, horizontal")
    assert VERTICAL / horizontal == approx(1.13, abs=0.005)


# Figure 6, file and screen


def test_beyond_1_to_1_the_nearest_neighbour_repeats_pixels():
    grey = np.random.default_rng(7).integers(0, 256, (5, 5))
    shown = np.kron(grey, np.ones((3, 3), int))
    places = (np.arange(15) + 0.5) / 3
    rows = cols = places.astype(int)  # nearest pixel of each place on the screen
    assert np.array_equal(grey[np.ix_(rows, cols)], shown)


# Contours


def test_objects_that_differ_by_25_m_miss_a_contour():
    """Ground from 9 to 11 m: the contour of 10 m crosses it unseen."""
    x = np.linspace(0, 100, 200)
    ground = 10 + np.cos(2 * np.pi * x / 100)
    assert np.ptp(ground) < 2.5
    assert np.sum(np.diff(np.sign(ground - 10)) != 0) == 2
    first, chosen = ground[0], []
    for z in ground:  # digitise only what differs by 2.5 m from the last
        if abs(z - first) >= 2.5:
            chosen.append(z)
            first = z
    assert not chosen
    # Between two points of equal height a hollow of 1.2 m is missed whole
    hollow = np.abs(x / 100 - 0.5) * 2.4
    missed = np.abs(hollow - np.interp(x, [0, 100], hollow[[0, -1]])).max()
    assert missed == approx(1.2, abs=0.01)
