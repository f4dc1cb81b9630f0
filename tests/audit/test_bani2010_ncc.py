"""Proofs of the verdicts on Bani 2010. What chapter 2 touches: correlation (2.6a) to
(2.6f), the windows, the printed output of figure 4.6 and the listing."""

import re

import cv2
import numpy as np
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_book.common import ledger
from pgm_lab import ncc, simulate

RNG = np.random.default_rng(26)
TEMPLATE, MATCHING = RNG.uniform(0, 255, (2, 21, 21))
MATCHING = 0.6 * TEMPLATE + 0.4 * MATCHING + 30.0


def printed(place):
    """Numbers that the ledger quotes from a place, in their order."""
    quoted = ledger.verdicts("2", [place])[0]["printed"]
    return [float(number) for number in re.findall(r"\d+(?:\.\d+)?", quoted)]


*CENTRE, TOP, LEFT, RIGHT, BOTTOM = printed("Figure 4.6, rectangle")
PRINTED_R, *MATCHED = printed("Figure 4.6, r")


def sums(x, y):
    """(2.6a), (2.6b), (2.6c) as printed."""
    x, y, n = x.ravel(), y.ravel(), x.size
    return (
        np.sum(x**2) - np.sum(x) ** 2 / n,
        np.sum(y**2) - np.sum(y) ** 2 / n,
        np.sum(x * y) - np.sum(x) * np.sum(y) / n,
    )


def test_2_6a_to_2_6c_are_the_sums_about_the_means():
    x, y = TEMPLATE - TEMPLATE.mean(), MATCHING - MATCHING.mean()
    expected = np.sum(x * x), np.sum(y * y), np.sum(x * y)
    close(sums(TEMPLATE, MATCHING), expected, rtol=1e-10)


def test_2_6d_is_the_line_by_least_squares_and_2_6e_lacks_the_mean_of_y():
    # y = alpha + beta x; the listing has the mean of y
    sxx, _, sxy = sums(TEMPLATE, MATCHING)
    line = np.polynomial.Polynomial.fit(TEMPLATE.ravel(), MATCHING.ravel(), 1)
    alpha, beta = line.convert().coef
    assert sxy / sxx == approx(beta, rel=1e-12)
    as_printed = -sxy / sxx * TEMPLATE.sum() / TEMPLATE.size
    assert as_printed + MATCHING.sum() / MATCHING.size == approx(alpha, rel=1e-12)
    assert ncc.regression(TEMPLATE, MATCHING).alpha == approx(alpha, rel=1e-12)
    assert alpha - as_printed == approx(MATCHING.mean(), rel=1e-12)


def test_2_6f_and_the_listing_give_the_correlation_coefficient():
    sxx, syy, sxy = sums(TEMPLATE, MATCHING)
    expected = np.corrcoef(TEMPLATE.ravel(), MATCHING.ravel())[0, 1]
    assert ncc.correlation(TEMPLATE, MATCHING) == approx(expected, abs=1e-14)
    assert sxy / np.sqrt(sxx * syy) == approx(expected, abs=1e-12)


def test_h0_and_h1_of_2_7_need_the_left_window_regressed_on_the_right():
    """Left = h0 + h1 right; the listing has x = template (left), y = matching."""
    right = RNG.uniform(0, 255, (21, 21))
    left = 20.0 + 0.5 * right
    needed = ncc.regression(right, left)
    assert (needed.alpha, needed.beta) == approx((20.0, 0.5))
    listing = ncc.regression(left, right)
    assert (listing.alpha, listing.beta) == approx((-40.0, 2.0))


def test_r_is_one_exactly_for_a_positive_linear_relation():
    for gain, offset in ((0.1, 200.0), (3.0, -50.0)):
        positive = ncc.correlation(TEMPLATE, gain * TEMPLATE + offset)
        negative = ncc.correlation(TEMPLATE, -gain * TEMPLATE + offset)
        assert positive == approx(1, abs=1e-14)
        assert negative == approx(-1, abs=1e-14)
    # and only then: 1 - r^2 is the share that the line leaves unexplained
    line = ncc.regression(TEMPLATE, MATCHING)
    residuals = MATCHING - line.alpha - line.beta * TEMPLATE
    assert 1 - line.r**2 == approx(residuals.var() / MATCHING.var(), rel=1e-9)
    noise = RNG.normal(size=(2, 2000, 441))
    r = [ncc.correlation(a, b) for a, b in zip(*noise, strict=True)]
    # Nothing in common: near 0, with a standard deviation of 1 / sqrt(440)
    assert np.mean(r) == approx(0, abs=0.005)
    assert np.std(r) == approx(440**-0.5, rel=0.1)


def test_19_in_21_allows_nine_positions_and_the_printed_shift_is_not_among_them():
    template, searched = printed("IV.1.2.1, step 3")[::2]
    # 25 values need 9 x 9
    for window, search, count in ((5, 9, 25), (int(template), int(searched), 9)):
        grey = RNG.normal(size=(window, window)), RNG.normal(size=(search, search))
        assert ncc.correlation_map(*grey).size == count
    assert RIGHT - LEFT == 21
    shift = np.subtract(MATCHED, np.floor(np.add(CENTRE, 0.5)).astype(int))
    assert tuple(shift) == (-64, -14)
    # Farther than the listing's +-15 around the point, too: its search window lies
    # around the best place in the whole image
    assert np.abs(shift).max() > 15


def test_printed_rectangle_is_21_wide_around_the_rounded_centre():
    column, row = (int(value + 0.5) for value in CENTRE)
    assert (column, row) == (332, 1063)
    left, top = column - 10, row - 10
    # Right and bottom are the first column and row outside
    assert (TOP, LEFT, RIGHT, BOTTOM) == (top, left, left + 21, top + 21)


def test_searching_again_around_the_highest_value_finds_the_same():
    image = simulate_image()
    template = image[60:81, 50:71] + RNG.normal(0, 5, (21, 21))
    whole = ncc.correlation_map(template, image)
    row, column = np.unravel_index(whole.argmax(), whole.shape)
    around = whole[row - 15 : row + 16, column - 15 : column + 16]
    assert np.unravel_index(around.argmax(), around.shape) == (15, 15)
    opencv = cv2.matchTemplate(
        image.astype(np.float32), template.astype(np.float32), cv2.TM_CCOEFF_NORMED
    )
    assert np.unravel_index(opencv.argmax(), opencv.shape) == (row, column)


def simulate_image():
    texture = simulate.texture(0.2, seed=1)
    columns, rows = np.meshgrid(np.arange(140.0), np.arange(130.0))
    return simulate.grey_values(texture, np.stack([columns, rows], axis=-1))


def searched_as_listed(template, windows):
    """Best position and r, alpha and beta as the loop of the listing hands them on: our
    description of it in our own words. That the listing reads so, no test can show; it
    must be read beside this."""
    best, highest, alpha, beta = None, 0.7, 0.0, 0.0
    for position in np.ndindex(windows.shape[:2]):
        line = ncc.regression(template, windows[position])
        alpha, beta = line.alpha, line.beta
        if line.r > highest:
            best, highest = position, line.r
    return best, highest, alpha, beta


def test_listing_hands_on_alpha_and_beta_of_the_last_window_not_of_the_best():
    image = simulate_image()
    template = 1.25 * image[60:81, 50:71] - 10
    search = image[55:91, 45:81]
    windows = np.lib.stride_tricks.sliding_window_view(search, (21, 21))
    best, highest, alpha, beta = searched_as_listed(template, windows)
    assert best == (5, 5) and highest == approx(1)
    right = ncc.regression(template, windows[best])
    assert (right.alpha, right.beta) == approx((8.0, 0.8))
    last = ncc.regression(template, windows[-1, -1])
    assert (alpha, beta) == (last.alpha, last.beta)
    assert abs(beta - 0.8) > 0.3


def test_listing_hands_on_0_7_where_nothing_correlates_and_0_695_never_decides():
    noise = RNG.normal(size=(30, 30))
    windows = np.lib.stride_tricks.sliding_window_view(noise, (21, 21))
    best, highest, *_ = searched_as_listed(RNG.normal(size=(21, 21)), windows)
    assert best is None
    accepted, _ = printed("Listing, threshold")
    assert highest > accepted


def test_printed_correlation_has_no_unit_and_no_published_image():
    """r does not change when pixels or grey values are measured in other units."""
    assert PRINTED_R > printed("Listing, threshold")[0]  # what the listing accepts
    r = ncc.correlation(TEMPLATE, MATCHING)
    assert ncc.correlation(TEMPLATE / 255, MATCHING / 255) == approx(r)
    larger = (np.kron(window, np.ones((2, 2))) for window in (TEMPLATE, MATCHING))
    assert ncc.correlation(*larger) == approx(r)


def test_whole_pixels_are_good_to_half_a_pixel_and_a_parabola_to_hundredths():
    points = np.array([(x, y) for x in range(40, 200, 20) for y in range(40, 200, 20)])
    texture = simulate.texture(0.2, seed=3)
    errors = {None: [], "parabola": []}
    # Shifts spread evenly over a pixel: 1 / sqrt(12) = 0.289
    fractions = (np.arange(8) + 0.5) / 8 - 0.5
    for k in range(8):
        shift = np.array([1 + fractions[k], fractions[3 * k % 8] - 2])
        affine = (shift[0], 1, 0, shift[1], 0, 1)
        pair = simulate.texture_pair(texture, (240, 240), affine, sigma=2.0, seed=k)
        for refine, found in errors.items():
            matched = ncc.match(*pair, points, search=31, refine=refine)
            assert set(matched.status) == {"accepted"}
            found.append(matched.points - points - shift)
    rms = {refine: np.sqrt(np.mean(np.square(e))) for refine, e in errors.items()}
    assert rms[None] == approx(0.289, abs=0.01)
    assert np.abs(errors[None]).max() < 0.6
    assert rms["parabola"] == approx(0.014, abs=0.003)
