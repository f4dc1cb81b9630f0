"""Proofs of the verdicts on Brahmantara 2015, whole but for (1): fifty chips of two
SPOT 6 images, their shifts summed up to one number. The images and the fifty shifts
are not printed: what is proved is what follows from the digits, from arithmetic, and
from a Landsat scene that is shifted by what we know."""

import math
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_book.common import results
from pgm_lab import datasets, matching, ncc, simulate
from pgm_lab.registration import accuracy, register

from . import as_printed

PRINTED = as_printed.brahmantara_2015()
RMSE_T = 2.391652149  # px, of both abstracts
HALF_DIGIT = 0.5e-9
PIXEL = 6.0  # m
JAKARTA = 106.8, -6.2  # degrees, longitude and latitude
LOWEST_R = 0.585041
# Of equal, independent normal errors of both coordinates
CE90_OVER_SD = math.sqrt(2 * math.log(10))
RMSE_OVER_SD = math.sqrt(2)


def numbers(place):
    """Numbers of a printed sentence, as they are written."""
    return re.findall(r"\d+(?:\.\d+)?", PRINTED[place])


def whole_sums(n, fraction=1):
    """Whole numbers that n times the square of the printed RMSE can stand for.

    In units of a square of the fraction of a pixel.
    """
    low, high = (fraction**2 * n * (RMSE_T + s) ** 2 for s in (-HALF_DIGIT, HALF_DIGIT))
    return list(range(math.ceil(low), math.floor(high) + 1)), high - low


LANDSAT = datasets.landsat().grey
SCENE = LANDSAT.astype(float)
CHIPS = matching.pick(LANDSAT, 400, margin=100)  # textured, far from the edges
POINTS = CHIPS[:200]
ELSEWHERE = (40, -35), (-60, 20), (33, 70)  # offsets at which no ground is the same


def peaks(reference, sensed, points, offset=(0, 0), radius=3):
    """Each chip at its highest r, as in the paper: without a threshold or a test."""
    return register(
        *(reference, sensed, points),
        radius=radius,
        offset=offset,
        threshold=-1,
        ratio=1,
    )


def moved(shift, image=SCENE):
    """The image moved by whole (columns, rows)."""
    return np.roll(image, (shift[1], shift[0]), axis=(0, 1))


def on_border(found, radius=3):
    return np.maximum(abs(found.dx), abs(found.dy)) == radius


def found_length(found):
    return accuracy(found.dx, found.dy).rmse_t


def noise(sigma, seed):
    return np.random.default_rng(seed).normal(0, sigma, SCENE.shape)


# The numbers of the abstracts


def test_the_digits_fix_the_sum_of_fifty_squares_to_286():
    whole, width = whole_sums(50)
    assert whole == [286] and width == approx(2.4e-7, rel=0.01)
    assert math.sqrt(286 / 50) == approx(RMSE_T, abs=HALF_DIGIT)
    # A real sum meets a whole number with this chance: once in four million
    assert 1 / width == approx(4.2e6, rel=0.01)
    # Halves: four times the sum must be whole, and is, as for any other fraction that
    # divides a pixel. The digits do not rule them out; the method does, by whole pixels
    for fraction in (2, 3, 4, 10):
        assert 286 * fraction**2 in whole_sums(50, fraction)[0]
    # But by chance: one sum in four of halves is whole, one in a hundred of tenths
    rng = np.random.default_rng(286)
    for fraction, chance in ((2, 0.25), (10, 0.01)):
        parts = rng.integers(-3 * fraction, 3 * fraction + 1, (20_000, 100))
        share = np.mean((parts**2).sum(axis=1) % fraction**2 == 0)
        assert share == approx(chance, rel=0.25)


def test_fifty_and_not_another_number_of_chips_below_75_gives_a_whole_sum():
    fits = [n for n in range(1, 101) if whole_sums(n)[0]]
    assert fits == [25, 50, 75, 100]  # 5.72 = 143 / 25


def test_286_cannot_be_split_into_the_two_coordinates():
    """Each split is a sum of fifty squares up to 9, twice; and the mean may be any."""
    sums = {0}
    for _ in range(50):
        sums = {s + square for s in sums for square in (0, 1, 4, 9) if s <= 286}
    splits = [x for x in range(287) if x in sums and 286 - x in sums]
    assert splits == list(range(287))
    # Shifts that lie alike, or in all directions, or right but for 17: one RMSE_T
    alike = np.array([(2, 1)] * 38 + [(2, 2)] * 12)
    turned = alike * np.resize([1, -1], 50)[:, None]
    corners = [(3, 3), (-3, -3), (3, -3), (-3, 3)]
    blunders = np.array((corners * 4)[:15] + [(2, 2), (-2, -2)] + [(0, 0)] * 33)
    means = []
    for dx, dy in (alike.T, turned.T, blunders.T):
        found = accuracy(dx, dy)
        assert found.rmse_t == approx(RMSE_T, abs=HALF_DIGIT)
        means.append(math.hypot(found.mean_x, found.mean_y))
    assert means == approx([2.353, 0, 0.085], abs=0.001)
    # The longest mean, of whole pixels as the text says, and of halves
    assert longest_mean(1) == approx((2.361, 106, 52), abs=5e-4)
    assert longest_mean(2)[0] == approx(2.380, abs=5e-4)


def longest_mean(fraction):
    """Longest mean of fifty such shifts in fractions of a pixel, and its two sums."""
    # Fifty numbers of a given sum have the least squares if they are alike
    total, sums = 286 * fraction**2, range(150 * fraction + 1)
    least = [(50 - s % 50) * (s // 50) ** 2 + s % 50 * (s // 50 + 1) ** 2
             for s in sums]  # fmt: skip
    return max(
        (math.hypot(x, y) / 50 / fraction, x, y)
        for x in sums
        for y in range(x + 1)
        # a square is odd where its number is
        if least[x] + least[y] <= total and (x + y - total) % 2 == 0
    )


def test_both_abstracts_print_the_same_numbers():
    indonesian, english = (numbers(f"abstract, {s}") for s in ("Indonesian", "English"))
    assert set(indonesian) == set(english) >= {"2013", "2014", "50", "21", "6"}
    assert {str(RMSE_T), "14.34991289"} <= set(english)


def test_printed_pixels_and_metres_agree_with_six_metres_a_pixel():
    for pixels in (RMSE_T, math.sqrt(286 / 50)):
        assert f"{pixels * PIXEL:.8f}" == "14.34991289"
    assert f"{RMSE_T:.2f}" == "2.39" and f"{RMSE_T * PIXEL:.2f}" == "14.35"
    assert f"{2.39 * PIXEL:.2f}" == "14.34"  # 14.35 was not computed from 2.39
    low, high = ((14.34991289 + s * 5e-9) / (RMSE_T - s * HALF_DIGIT) for s in (-1, 1))
    assert low < 6 < high and high - low < 1e-8
    assert {"2.39", "14.35"} <= set(numbers("Hasil, below Gambar 3.2"))
    # 18 m are three pixels, as the radius is; two are 12 m, as in the question
    *_, pixels, metres = map(float, numbers("Metode, below Gambar 2.2"))
    assert pixels * PIXEL == metres
    _, pixels, metres = map(float, numbers("discussion, answer on the radius"))
    _, two, size, _ = map(float, numbers("discussion, question on the radius"))
    assert pixels == two and pixels * size == 2 * PIXEL < metres == 3 * PIXEL


# Equations (2) to (4) and what stands below them


def test_2_to_4_are_root_mean_squares_and_not_spreads():
    dx, dy = np.random.default_rng(2015).integers(-3, 4, (2, 50)) + [[2], [0]]
    found = accuracy(dx, dy)
    assert found.n == 50
    assert found.rmse_x == approx(math.sqrt(sum(d * d for d in dx) / 50))
    assert found.rmse_y == approx(math.sqrt(sum(d * d for d in dy) / 50))
    # A shift that all have in common counts as error
    assert found.rmse_x**2 == approx(dx.mean() ** 2 + dx.var())
    assert found.rmse_t == approx(math.hypot(found.rmse_x, found.rmse_y))
    assert found.rmse_t == approx(np.sqrt(np.mean(np.hypot(dx, dy) ** 2)))


def test_column_and_easting_give_one_rmse_but_for_the_pixel_size():
    dx, dy = np.random.default_rng(6).integers(-3, 4, (2, 50))
    pixels, metres = accuracy(dx, dy), accuracy(PIXEL * dx, -PIXEL * dy)
    assert metres.rmse_t == approx(PIXEL * pixels.rmse_t)
    assert metres.rmse_y == approx(PIXEL * pixels.rmse_y)  # northing runs up
    assert pixels.times(PIXEL).rmse_t == approx(metres.rmse_t)


def utm(longitude, latitude, central):
    """Easting and northing on a sphere, in metres (transverse Mercator)."""
    lon, lat = np.radians(longitude - central), np.radians(latitude)
    size = 0.9996 * 6.371e6
    east = size * np.arctanh(np.cos(lat) * np.sin(lon))
    return 5e5 + east, 1e7 + size * np.arctan2(np.tan(lat), np.cos(lon))


def test_easting_goes_with_longitude_and_northing_with_latitude():
    here = np.array(utm(*JAKARTA, 105))
    along = np.array(utm(JAKARTA[0] + 0.01, JAKARTA[1], 105)) - here
    up = np.array(utm(JAKARTA[0], JAKARTA[1] + 0.01, 105)) - here
    assert along == approx((1106, -4), abs=1.5)  # m; 1107 on the ellipsoid
    assert up == approx((4, 1112), abs=2)


def test_jakarta_lies_in_utm_zone_48_south():
    longitude, latitude = JAKARTA
    (zone,) = map(int, numbers("Metode, first paragraph"))
    assert math.floor((longitude + 180) / 6) + 1 == zone and latitude < 0
    assert -180 + 6 * (zone - 1) == 102 < longitude < 108


# 10 m CE90


def test_4_35_m_subtracts_a_ce90_from_an_rmse():
    sums = RMSE_T * PIXEL, 10.0
    assert f"{sums[0] - sums[1]:.2f}" in numbers("Hasil, below Gambar 3.2")
    ratio = CE90_OVER_SD / RMSE_OVER_SD
    assert ratio == approx(1.5174, abs=5e-5)
    assert ratio * sums[0] == approx(21.77, abs=0.005)  # as CE90
    # The difference of two independent images, each of 10 m CE90
    relative = math.sqrt(2) * sums[1]
    assert relative == approx(14.14, abs=0.005)
    assert relative / ratio == approx(9.32, abs=0.005)  # as RMSE_T
    # Like with like the pair is still worse than that, by half
    assert sums[0] / (relative / ratio) == approx(1.54, abs=0.005)
    # But one pair has one common shift: of such pairs every eleventh lies farther apart
    chance = 10 ** -((sums[0] / relative) ** 2)
    assert chance == approx(0.0934, abs=5e-5)
    # Fifty errors of their own, each as claimed, would not: a sum of 100 squares
    rng = np.random.default_rng(35)
    squares = rng.normal(0, relative / CE90_OVER_SD, (20_000, 100)) ** 2
    fifty = np.sqrt(squares.sum(axis=1) / 50)
    assert fifty.max() < sums[0] < np.mean(fifty) + 8 * fifty.std()
    assert (sums[0] - fifty.mean()) / fifty.std() > 7
    # sampled, with the formulas left out
    rng = np.random.default_rng(90)
    one, other = (rng.normal(0, 10 / CE90_OVER_SD, (2, 400_000)) for _ in range(2))
    assert np.quantile(np.hypot(*one), 0.9) == approx(10, rel=0.005)
    apart = accuracy(*(one - other))
    assert apart.rmse_t == approx(9.32, rel=0.005)
    assert apart.ce90 == approx(relative, rel=0.005)
    assert np.mean(np.hypot(*(one - other)) > sums[0]) == approx(0.093, abs=2e-3)


def test_ce90_is_a_length_that_single_points_exceed_and_no_rms():
    """One point in ten is farther off, as the paper concludes; the RMS is 6.6 m."""
    assert 10 / (CE90_OVER_SD / RMSE_OVER_SD) == approx(6.59, abs=0.005)
    errors = np.random.default_rng(10).normal(0, 10 / CE90_OVER_SD, (2, 400_000))
    found = accuracy(*errors)
    assert found.rmse_t == approx(6.59, rel=0.005)
    assert np.mean(np.hypot(*errors) > 10) == approx(0.1, abs=0.002)
    assert np.mean(np.hypot(*errors) > found.rmse_t) == approx(1 / math.e, abs=2e-3)


def test_a_shift_common_to_both_images_is_not_seen():
    """No image is regarded as true: what is measured is relative."""
    for x, y in ((0, 0), (3, 2)):
        found = peaks(moved((x, y)), moved((x + 2, y - 1)), POINTS)
        assert np.all(found.dx == 2) and np.all(found.dy == -1)


# The radius


def test_radius_one_has_nine_coefficients_and_radius_three_49():
    image = np.random.default_rng(9).normal(size=(27, 27))
    for radius, count in ((1, 9), (2, 25), (3, 49)):
        half = 10 + radius
        window = image[13 - half : 14 + half, 13 - half : 14 + half]
        r = ncc.correlation_map(image[3:24, 3:24], window)
        assert r.size == count == (2 * radius + 1) ** 2


def test_radius_three_finds_18_m_along_an_axis_and_25_along_the_diagonal():
    for shift, metres in (((3, 0), 18.0), ((0, -3), 18.0), ((3, 3), 25.456)):
        found = peaks(SCENE, moved(shift), POINTS)
        assert np.all(found.dx == shift[0]) and np.all(found.dy == shift[1])
        assert PIXEL * found_length(found) == approx(metres, abs=0.001)
        assert np.all(on_border(found))
    # A radius of two does not find them, and four pixels come out as three: the border
    # does not tell them apart
    assert not np.any(peaks(SCENE, moved((3, 0)), POINTS, radius=2).dx == 3)
    beyond = peaks(SCENE, moved((4, 0)), POINTS)
    assert np.mean(on_border(beyond)) > 0.99
    assert found_length(beyond) == approx(3, abs=0.02)
    corner = peaks(SCENE, moved((4, 4)), POINTS)
    assert found_length(corner) == approx(math.hypot(3, 3), abs=0.05)
    # The digits say how many at most: each peak on the border has a square of 9 or more
    (total,), _ = whole_sums(50)
    assert total // 9 == 31 and 50 * 9 > total


def test_12_m_are_more_than_10_m_and_still_too_few():
    """Points of two images of 10 m CE90 that a radius loses, with whole pixels."""
    assert 2 * PIXEL > 10
    sd = math.sqrt(2) * 10 / CE90_OVER_SD  # of a coordinate of the difference

    def lost(metres, sd=sd):
        return 1 - math.erf(metres / sd / math.sqrt(2)) ** 2

    # of the measured 2.39 px, if all of it were scatter
    assert lost(3, RMSE_T / math.sqrt(2)) == approx(0.15, abs=0.005)

    assert [lost(r * PIXEL) for r in (2, 3)] == approx([0.133, 0.0126], abs=5e-4)
    # a shift rounds to the next whole pixel: half a pixel more is found
    assert [lost((r + 0.5) * PIXEL) for r in (2, 3)] == approx(
        [0.0452, 0.0029], abs=5e-5
    )


def test_a_blind_matcher_scores_more_than_286():
    """Uniform on 7 x 7: 400 +- 35. On real ground its peaks crowd at the border."""
    x, y = np.mgrid[-3:4, -3:4].reshape(2, -1)
    one, total = np.bincount(x * x + y * y) / 49, np.ones(1)
    for _ in range(50):
        total = np.convolve(total, one)
    k = np.arange(len(total))
    mean = k @ total
    sd = math.sqrt((k - mean) ** 2 @ total)
    assert (mean, sd) == approx((400, 34.64), abs=0.01)
    assert (286 - mean) / sd == approx(-3.29, abs=0.005)
    assert total[:287].sum() == approx(3.7e-4, rel=0.01)
    assert math.sqrt(mean / 50) == approx(2.83, abs=0.005)
    assert np.sum(np.maximum(abs(x), abs(y)) == 3) == 24
    elsewhere = [peaks(LANDSAT, LANDSAT, CHIPS, offset=offset) for offset in ELSEWHERE]
    assert np.mean([on_border(f) for f in elsewhere]) == approx(0.80, abs=0.01)
    assert np.mean([found_length(f) for f in elsewhere]) == approx(3.48, abs=0.01)
    # By the choice of chips: fifty of strong texture, a thousand anywhere
    anywhere = np.random.default_rng(0).integers(100, 1100, (1000, 2))
    for chips in (CHIPS[:50], anywhere):
        for offset in ELSEWHERE:
            others = peaks(LANDSAT, LANDSAT, chips, offset=offset)
            assert 3.1 < found_length(others) < 3.6
    # A part of the fifty may have been blind, the others perfect: the same sum
    one = np.mean([found_length(f) ** 2 for f in elsewhere])
    assert 23 * one == approx(278, abs=1) and 24 * one > 286


# r


def test_r_lies_between_minus_one_and_one():
    rng = np.random.default_rng(1)
    for _ in range(300):
        a, b = rng.integers(0, 4096, (2, 441))
        assert -1 <= ncc.correlation(a, b) <= 1
    a = rng.integers(0, 4096, 441)
    assert ncc.correlation(a, 3 * a + 7) == approx(1, abs=1e-12)
    assert ncc.correlation(a, 9 - 2 * a) == approx(-1, abs=1e-12)
    # but for constant windows, which have no r: 0 / 0
    with pytest.raises(ValueError):
        ncc.correlation(a, np.full(441, 7))


def test_highest_r_lies_where_the_images_coincide():
    found = peaks(SCENE, moved((-2, 1), 0.9 * SCENE + noise(15, 7)), POINTS)
    assert np.all(found.dx == -2) and np.all(found.dy == 1) and np.all(found.r > 0.99)
    # inside the radius, and to half a pixel
    half = simulate.ortho_pair(SCENE, (5, -3), 4, blur=0.7)  # 1.25, -0.75 px
    chips = matching.pick(np.rint(half.reference).astype(np.uint16), 50)
    found = peaks(half.reference, half.sensed, chips)
    error = np.column_stack([found.dx, found.dy]) - half.shift
    assert np.mean(np.abs(error).max(axis=1) < 0.5) >= 0.9


def test_r_of_a_right_match_does_not_know_the_shift():
    """Moved by whole pixels the same chips have the same r, to the last digit."""
    sensed = 0.9 * SCENE + noise(600, 8)
    near, far = (peaks(SCENE, moved(s, sensed), POINTS) for s in ((0, 0), (3, -2)))
    right = (near.dx == 0) & (near.dy == 0)
    assert np.mean(right) > 0.9
    close(far.r[right], near.r[right], atol=1e-12)
    assert set(far.dx[right] - near.dx[right]) == {3}
    assert near.r[right].min() < 0.8 < near.r[right].max()


@pytest.fixture(scope="module")
def changed_fields():
    pair = simulate.ortho_pair(
        *(SCENE, (5, -2), 3), gain=0.9, sigma=15, haze=0.3, changed=0.3, seed=1,
        dtype=np.uint16,
    )  # fmt: skip
    chips = matching.pick(pair.reference, 400)
    found = peaks(pair.reference, pair.sensed, chips)
    error = np.hypot(found.dx - pair.shift[0], found.dy - pair.shift[1])
    return found, error


@pytest.fixture(scope="module")
def many_chips():
    """The pair of the notebook: shifted by whole (2, -1) px, 1841 chips."""
    pair = simulate.ortho_pair(
        *(LANDSAT, (4, -2), 2), gain=0.9, sigma=15, haze=0.3,
        changed=0.3, seed=4, dtype=np.uint16,
    )  # fmt: skip
    chips = matching.pick(pair.reference, 2000, margin=32)
    found = peaks(pair.reference, pair.sensed, chips)
    return found, np.hypot(found.dx - 2, found.dy + 1)


def test_whether_r_and_error_go_together_needs_the_truth(changed_fields, many_chips):
    """Of a pair with truth: not among right matches; low r has more wrong ones."""
    found, error = changed_fields
    right = error < 1
    length = np.hypot(found.dx, found.dy)
    high, low = found.r > 0.8, found.r < 0.5
    assert high.sum() > 100 and low.sum() > 30
    assert np.mean(~right[high]) < 0.02 < 0.15 < np.mean(~right[low])
    # Of many more chips: nearly every second; and right and wrong ones together
    found_more, error_more = many_chips
    low = found_more.r < 0.5
    assert np.mean(error_more[low] >= 1) == approx(0.46, abs=0.01)
    lengths = np.hypot(found_more.dx, found_more.dy)
    assert np.corrcoef(found_more.r, lengths)[0, 1] == approx(-0.45, abs=0.01)
    # of the right ones the shift, which the paper calls the error, is one number, and
    # its rounding to whole pixels is all that differs
    assert {2.236} < set(length[right].round(3)) <= {1.0, 1.414, 2.0, 2.236}


def test_low_r_has_other_causes_than_changed_ground():
    """On one unchanged scene: noise, and a shift beyond the radius."""
    assert peaks(SCENE, moved((3, 0)), POINTS).r.min() > 0.999
    assert np.mean(peaks(SCENE, moved((5, 0)), POINTS).r < LOWEST_R) > 0.7
    assert np.mean(peaks(SCENE, SCENE + noise(1000, 5), POINTS).r < LOWEST_R) > 0.2
    # changed ground is one more
    fields = simulate.ortho_pair(SCENE, (4, -2), 2, changed=0.5, seed=1)
    chips = matching.pick(np.rint(fields.reference).astype(np.uint16), 100)
    column, row = chips.astype(int).T
    new = fields.changed[row, column]
    r = peaks(fields.reference, fields.sensed, chips).r
    assert np.median(r[new]) < 0.6 and np.median(r[~new]) > 0.8


def test_a_lowest_r_of_0585041_speaks_for_the_fifty(many_chips):
    """Ground that is not the same hardly ever reaches it; r^2 is a third."""
    assert LOWEST_R**2 == approx(0.342, abs=0.0005)

    def share(grey, chips, offset):
        return np.mean(peaks(grey, grey, chips, offset=offset).r >= LOWEST_R)

    assert all(share(LANDSAT, CHIPS, offset) < 0.01 for offset in ELSEWHERE)
    # another texture: an orthophoto of 0.1 m, averaged to 0.4 m
    meadow = datasets.yellowstone().grey.reshape(384, 4, 384, 4).mean(axis=(1, 3))
    chips = matching.pick(np.rint(meadow).astype(np.uint8), 200, margin=45)
    assert all(share(meadow, chips, offset) < 0.03 for offset in ((40, -30), (-35, 33)))
    # Near the right place a wrong match reaches it more easily
    found, error = many_chips
    assert np.mean(found.r[error >= 1] >= LOWEST_R) == approx(0.15, abs=0.01)
    # of a shift one pixel beyond the radius four of five chips do, all fifty never
    reach = np.mean(peaks(LANDSAT, moved((4, 0), LANDSAT), CHIPS).r >= LOWEST_R)
    assert reach == approx(0.80, abs=0.05) and reach**50 < 1e-3


# Pearson against other measures: the standard deviation over the search


def measures(chip, windows):
    """Four measures of one chip in its 7 x 7 windows."""
    product = (windows * chip).sum(axis=(2, 3))
    a = chip - chip.mean()
    w = windows - windows.mean(axis=(2, 3), keepdims=True)
    r = (w * a).sum(axis=(2, 3)) / np.sqrt((w**2).sum(axis=(2, 3)) * (a**2).sum())
    norms = np.sqrt((windows**2).sum(axis=(2, 3)) * (chip**2).sum())
    return {
        "r": r,
        "(1 + r) / 2": (1 + r) / 2,
        "cosine": product / norms,
        "product": product,
    }


def successes(sensed, shift):
    """Share of chips found at the shift, and the median deviation over the search."""
    right, spread = {}, {}
    for column, row in POINTS.astype(int):
        chip = SCENE[row - 10 : row + 11, column - 10 : column + 11]
        window = sensed[row - 13 : row + 14, column - 13 : column + 14]
        windows = np.lib.stride_tricks.sliding_window_view(window, (21, 21))
        for name, m in measures(chip, windows).items():
            i, j = np.unravel_index(m.argmax(), m.shape)
            right.setdefault(name, []).append((j - 3, i - 3) == shift)
            spread.setdefault(name, []).append(m.std())
    return [
        {k: f(v) for k, v in one.items()}
        for one, f in ((right, np.mean), (spread, np.median))
    ]


def test_a_larger_standard_deviation_does_not_make_a_match_safer():
    shift, sensed = (2, -1), moved((2, -1), 0.9 * SCENE + noise(300, 0))
    right, spread = successes(sensed, shift)
    # Half the deviation, the same places; a 75th, the same too; 10^9 times as large,
    # and nearly half are wrong
    assert spread["(1 + r) / 2"] == approx(spread["r"] / 2)
    assert spread["r"] / spread["cosine"] == approx(75, abs=1)
    assert right["r"] == right["(1 + r) / 2"] == right["cosine"] == 1
    assert spread["product"] / spread["r"] > 1e9 and right["product"] < 0.6
    # Within one measure it says something, but less than the highest value itself
    (study,) = (
        row
        for row in results.rows("ch07", "spread")
        if (row["condition"], row["measure"]) == ("changed fields", "Pearson r")
    )
    assert 0.5 < float(study["area"]) == approx(0.8, abs=0.05)
    assert float(study["area_highest"]) == approx(0.9, abs=0.05)
    # What makes Pearson safer is that an offset does not touch it
    right, after = successes(sensed - 5000, shift)
    assert right["r"] == 1 and right["cosine"] == approx(0.905, abs=0.01)
    # while the cosine's own deviation rises four times
    assert 4 < after["cosine"] / spread["cosine"] < 4.5


def test_pearson_registers_two_images(changed_fields):
    """With fields changed, haze, another gain and noise, and with the truth known."""
    found, error = changed_fields
    sure = found.r >= 0.8
    assert np.mean(error[sure] < 1) > 0.98
    assert np.median(found.dx) == 2 and np.median(found.dy) == -1  # of 1.67, -0.67


# Yellow


def overlay(reference, sensed):
    """Red the sensed and green the reference image, stretched alike to 0 ... 1."""
    low, high = np.quantile(reference, [0.02, 0.98])
    return [np.clip((g - low) / (high - low), 0, 1) for g in (sensed, reference)]


def test_red_and_green_of_one_grey_value_are_yellow():
    red, green = overlay(SCENE, SCENE)
    equal(red, green)  # a hue of 60 degrees everywhere
    # with another gain and offset only after a stretch of its own
    red, green = overlay(SCENE, 0.9 * SCENE - 300)
    assert np.abs(red - green).mean() > 0.1


def test_yellow_is_also_what_is_merely_even():
    """Moved by 2.24 px, three quarters of the pixels look as if they were not."""
    red, green = overlay(SCENE, moved((2, 1)))
    alike = np.abs(red - green) < 0.1
    assert 0.5 < np.mean(alike) < 0.9
    edge = np.hypot(*np.gradient(green)) > 0.1
    assert np.mean(alike[edge]) < 0.5 * np.mean(alike[~edge])


# Names


def scene_of(year):
    """Digits of the printed name of a scene."""
    (name,) = re.findall(rf"SP6_MS_({year}\d*_?\d*)_", PRINTED["Gambar 1.1, caption"])
    return name


def test_scene_of_2013_was_taken_at_the_local_time_of_the_orbit():
    """Year to tenths of a second in 15 digits; the satellite crosses at 10 o'clock."""
    name = scene_of(2013)
    assert len(name) == 4 + 2 + 2 + 2 + 2 + 2 + 1
    hour = int(name[8:10]) + int(name[10:12]) / 60 + int(name[12:]) / 36000
    local = hour + 106.8 / 15
    assert local == approx(9.85, abs=0.005)
    assert abs(local - 10) < 0.5


def test_name_of_the_scene_of_2014_tells_a_date_and_no_time_of_the_orbit():
    date, rest = scene_of(2014).split("_")
    assert len(date + rest) == len(scene_of(2013)) + 1 == 16
    hour = int(rest[:2]) + int(rest[2:4]) / 60
    utc, jakarta = hour + 106.8 / 15, hour - 7 + 106.8 / 15
    # Seen up to 45 degrees aside from 694 km: 6.3 degrees of longitude, 25 minutes
    aside = 60 * np.degrees(694 * math.tan(math.radians(45)) / 6371) / 15
    assert aside == approx(25, abs=0.1)
    assert utc == approx(13.1, abs=0.01) and jakarta == approx(6.1, abs=0.01)
    assert min(abs(utc - 10), abs(jakarta - 10)) > 3 > aside / 60


def test_the_file_of_figure_3_2_is_misspelt_and_numbered_as_the_text_says():
    pattern = re.compile(r"(\w+)_window21x21_(\d+)\.ers")
    first, zero = pattern.search(PRINTED["Gambar 1.1, caption"]).groups()
    third, five = pattern.search(PRINTED["Gambar 3.2, caption"]).groups()
    words = re.search(r"\((.*)\)", PRINTED["abstract, English, chip"])[1]
    assert first == "".join(word[0] for word in words.split()).lower()
    assert [a == b for a, b in zip(first, third, strict=True)] == [True, False, True]
    assert zero == "0" and numbers("Hasil, below Gambar 3.1")[0] == five
