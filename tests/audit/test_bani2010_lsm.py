"""Proofs of the verdicts on the least squares matching of Bani 2010: equations (2.7) to
(2.20), Table 2.2, and what is said of its accuracy."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from .matching import (
    START,
    adjusted,
    affine,
    computed,
    derivatives,
    design,
    gradient,
    grey,
    window,
)

X, Y = window(10)
# a0, a1, a2, b0, b1, b2, h0, h1: no two alike, nothing near a special value
TRUTH = np.array([41.3, 1.02, -0.015, -27.6, 0.018, 0.985, 7.0, 0.9])
IDENTITY = np.array([41.0, 1.0, 0.0, -28.0, 0.0, 1.0, 0.0, 1.0])


def left(sigma=0.0, seed=0):
    noise = np.random.default_rng(seed).normal(0, sigma, X.size)
    return computed(TRUTH, X, Y) + noise


def test_2_7_to_2_10_are_satisfied_by_an_affine_pair():
    # The inverse: the right image at x', y' from the left one and its radiometry
    x1, y1 = affine(TRUTH, X, Y)
    close(grey(x1, y1), (left() - TRUTH[6]) / TRUTH[7], rtol=0, atol=1e-10)
    # (2.8), (2.9) put them where the matrix of the affine transformation does
    matrix = TRUTH[:6].reshape(2, 3)
    close(matrix @ [np.ones_like(X), X, Y], (x1, y1), rtol=0, atol=1e-12)


def test_eight_derivatives_below_2_11_are_those_of_2_10():
    # The complex step has no cut-off: f(p + ih) = f + ih f', h = 1e-30
    A = derivatives(TRUTH, X, Y)
    for k in range(8):
        p = TRUTH + 1e-30j * np.eye(8)[k]
        by_step = computed(p, X, Y).imag / 1e-30
        close(A[:, k], by_step, rtol=1e-9, atol=1e-9)


def test_2_11_and_2_14a_repeated_give_the_true_parameters():
    p, V, _ = adjusted(left(), IDENTITY, X, Y)
    close(p, TRUTH, rtol=0, atol=1e-9)
    assert np.abs(V).max() < 1e-9


def test_2_14a_minimises_the_weighted_sum_of_squares():
    rng = np.random.default_rng(1)
    A, L = derivatives(IDENTITY, X, Y), rng.normal(size=X.size)
    root = rng.normal(size=(X.size, X.size)) / 20 + np.eye(X.size)
    P = root.T @ root
    x = np.linalg.inv(A.T @ P @ A) @ A.T @ P @ L
    close(x, np.linalg.lstsq(root @ A, root @ L)[0], rtol=0, atol=1e-8 * abs(x).max())


def test_2_14b_and_2_14e_are_one_estimate_of_the_noise_with_r_of_2_14d():
    # Linear case, u = 8: the mean of s0^2 over 4000 draws is sigma^2, each draw with
    # the relative standard deviation sqrt(2 / r); five standard deviations are allowed
    A = derivatives(TRUTH, X, Y)
    n, u, sigma, draws = X.size, 8, 3.0, 4000
    L = np.random.default_rng(2).normal(0, sigma, (n, draws))
    V = A @ np.linalg.lstsq(A, L)[0] - L
    r = n - u
    variance_factor = (V**2).sum(axis=0) / r
    assert variance_factor.mean() == approx(sigma**2, rel=5 * np.sqrt(2 / r / draws))
    S0 = np.sqrt((V**2).sum(axis=0) / r)
    close(S0**2, variance_factor, rtol=1e-14)


@pytest.mark.parametrize(("steps", "agree"), [(1, False), (10, True)])
def test_2_14c_is_2_19_only_once_it_has_converged(steps, agree):
    # Both are computed minus observed, as in (2.10); V of a step is what the tangent
    # predicts
    observed = left(sigma=2.0)
    p, V, _ = adjusted(observed, IDENTITY, X, Y, steps)
    estimated_minus_template = computed(p, X, Y) - observed
    assert np.allclose(V, estimated_minus_template, rtol=0, atol=1e-6) == agree
    assert np.corrcoef(V, estimated_minus_template)[0, 1] > 0.5


def test_l_is_a_difference_of_grey_values():
    # Template minus matching window moves the window to where it belongs. The same
    # difference of coordinates is the shift itself at every pixel, whatever the image
    shift = np.array([0.3, -0.2])
    A = design(*gradient(X, Y), X, Y)
    difference = grey(X + shift[0], Y + shift[1]) - grey(X, Y)
    x = np.linalg.lstsq(A, difference)[0]
    close(x[[0, 3]], shift, rtol=0, atol=0.05)
    for coordinate in shift:
        x = np.linalg.lstsq(A, np.full_like(X, coordinate))[0]
        assert np.abs(x[[0, 3]] - shift).max() > 0.1


def test_identity_is_the_weight_matrix_of_white_noise_and_approximate_when_resampled():
    # Any multiple of I gives the same X; bilinear resampling half a pixel aside leaves
    # a quarter of the variance, and neighbours that share half of it
    A, L = derivatives(IDENTITY, X, Y), left(3.0) - computed(IDENTITY, X, Y)
    for P in (1.0, 1 / 9.0):
        x = np.linalg.solve(A.T * P @ A, A.T * P @ L)
        close(x, np.linalg.lstsq(A, L)[0], rtol=0, atol=1e-6)
    noise = np.random.default_rng(3).normal(size=(600, 600))
    mean = (noise[1:, 1:] + noise[1:, :-1] + noise[:-1, 1:] + noise[:-1, :-1]) / 4
    assert mean.var() == approx(1 / 4, rel=0.05)
    shared = (mean[:, 1:] * mean[:, :-1]).mean() / mean.var()
    assert shared == approx(1 / 2, rel=0.05)


def test_table_2_2_holds_six_of_the_columns_of_2_11_and_the_right_constant():
    # At h0 = 0, h1 = 1; the order is that of a0, a1, a2, b0, b1, b2
    at = affine(IDENTITY, X, Y)
    six = design(*gradient(*at), X, Y)
    close(six, derivatives(IDENTITY, X, Y)[:, :6], atol=1e-12)
    # t - m: from A + V = f0 + A X, V = A X - (t - m) is 0 for a perfect fit
    template = grey(*at) + six @ (0.02, 1e-3, -1e-3, 0.01, 2e-3, -1e-3)
    x = np.linalg.lstsq(six, template - grey(*at))[0]
    close(x, (0.02, 1e-3, -1e-3, 0.01, 2e-3, -1e-3), atol=1e-9)


def test_indices_of_table_2_2_mix_the_gradients_of_two_pixels():
    # Second line, pixel (2, 1): gx1, gx2 x2, gx2 y1, gy1, gy1 x2, gy1 y1. A quotient
    # of the printed second and first element must be x2, whatever the image
    x = np.array([1.0, 2.0])
    gx, gy = gradient(x, np.ones(2))
    printed = np.array([gx[0], gx[1] * x[1], gx[1] * 1, gy[0], gy[0] * x[1], gy[0]])
    right = design(gx[1], gy[1], x[1], 1.0)
    assert abs(printed[1] / printed[0] / x[1] - 1) > 0.1
    assert right[1] / right[0] == approx(x[1], rel=1e-14)
    assert right[4] / right[3] == approx(x[1], rel=1e-14)
    # Nor is it the gradient of a column in gx and of a row in gy: it changes with both
    along, across = gradient(X, Y).reshape(2, 21, 21).std(axis=1).mean(axis=-1)
    assert min(along, across) > 5


def test_2_16_is_the_differential_of_2_15():
    p, dp = TRUTH[:6], 1e-6 * np.array([3.0, -1.0, 2.0, -2.0, 1.0, 4.0])
    difference = np.array(affine(p + dp, X, Y)) - affine(p, X, Y)
    close(affine(dp, X, Y), difference, rtol=0, atol=1e-12)


def test_2_17_as_printed_cannot_tell_h0_from_h1():
    # Coefficient 1 for both: rank 7. With the grey value, as in (2.11), rank 8
    at = affine(IDENTITY, X, Y)
    one, six = np.ones_like(X), design(*gradient(*at), X, Y)
    printed = np.column_stack([six, one, one])
    assert np.linalg.matrix_rank(printed) == 7
    corrected = np.column_stack([six, one, grey(*at)])
    assert np.linalg.matrix_rank(corrected) == 8
    # gx and gy without the factor h1 are right where h1 = 1, and there alone
    close(corrected, derivatives(IDENTITY, X, Y), atol=1e-10)
    scaled = IDENTITY.copy()
    scaled[7] = 0.9
    close(0.9 * corrected[:, :6], derivatives(scaled, X, Y)[:, :6], atol=1e-10)


def test_any_pair_gives_the_start_values_of_2_20_and_2_20b_does_not_take_y0():
    # The printed pair: template (332, 1063), start of the matching (268, 1049)
    (x0, y0), (x1, y1) = (332, 1063), START
    for b0, beside in ((y0 - y1, 28), (y1 - y0, 0)):
        assert affine((x1 - x0, 1, 0, b0, 0, 1), x0, y0) == (x1, y1 + beside)
    # The lower left, the middle, the upper right pixel of windows of 21 x 21
    for x, y in ((-10, 10), (0, 0), (10, -10)):
        assert affine((-64, 1, 0, -14, 0, 1), x0 + x, y0 + y) == (x1 + x, y1 + y)


@pytest.mark.parametrize(("off", "reached"), [(0.5, True), (1.0, True), (8.0, False)])
def test_start_must_be_near_as_stated(off, reached):
    # The shortest waves are 5 px long: a pixel is near, 8 px are not
    start = IDENTITY.copy()
    start[[0, 3]] = TRUTH[[0, 3]] + (off, -off)
    with np.errstate(all="ignore"):
        p, *_ = adjusted(left(), start, X, Y, steps=30)
    assert np.allclose(p, TRUTH, rtol=0, atol=1e-6) == reached


@pytest.mark.parametrize(
    ("sigma", "contrast", "steps", "rms"),
    [
        (1.0, 40.0, 3, 0.0021),
        (2.0, 40.0, 3, 0.0043),
        (2.0, 9.0, 3, 0.019),
        (6.5, 9.0, 10, 0.062),
    ],
)
def test_001_px_is_reached_with_good_contrast_and_missed_with_poor(
    sigma, contrast, steps, rms
):
    # The same window, 30 draws of the noise; converged, the corrections vanish, and
    # the errors stay
    found, last = [], []
    for seed in range(30):
        noise = np.random.default_rng([9, seed]).normal(0, sigma, X.size)
        observed = computed(TRUTH, X, Y, contrast) + noise
        p, V, L = adjusted(observed, TRUTH, X, Y, steps, contrast)
        found.append(p[[0, 3]] - TRUTH[[0, 3]])
        last.append(np.abs(V + L).max())
    assert np.sqrt(np.mean(np.square(found))) == approx(rms, rel=0.03)
    if steps == 10:  # grey values that the last correction is worth
        assert max(last) < 1e-3


def test_a_step_of_lsm_multiplies_as_often_as_some_twenty_values_of_r():
    """No time is printed. Counted as they run: for r sums of xy and of y^2 over 21 x 21
    pixels; for a step, at each of 17 x 17, the products of A, all of A'A, A'b and five
    bilinear values."""

    class Number(float):
        products = 0

        def __mul__(self, other):
            Number.products += 1
            return Number(float(self) * other)

        def __add__(self, other):
            return Number(float(self) + other)

    def products(work):
        Number.products = 0
        work()
        return Number.products

    def numbers(*shape):
        return np.vectorize(Number, otypes=[object])(np.ones(shape))

    def bilinear(g, dx, dy):
        return g[0] + g[1] * dx + g[2] * dy + g[3] * dx * dy

    def step():
        x, y, gx, gy = numbers(4, 289)
        A = design(gx, gy, x, y)
        for _ in range(5):
            bilinear(numbers(4, 289), numbers(289), numbers(289))
        return A.T @ A, A.T @ numbers(289)

    x, y = numbers(2, 441)
    one_r, one_step = products(lambda: (x @ y, y @ y)), products(step)
    assert one_step / one_r == approx(21.6, abs=0.1)
    assert 31 * 31 * one_r / one_step == approx(44, abs=0.5)
