"""Proofs of the verdicts on the log of the least squares matching of Bani 2010, IV.1.3:
the parameters, the corrected point, S0, the determinant and the stop rule."""

from fractions import Fraction

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from .matching import (
    LOG,
    PRINTED,
    PRINTED_A,
    PRINTED_B,
    PRINTED_POINT,
    PRINTED_S0,
    START,
    affine,
    design,
    gradient,
    grey,
    window,
)

GRID = int(LOG["row_col"])
ROWS, UNKNOWNS = len(range(2, GRID)) ** 2, 6  # loops from 2 to 18 over a grid of 19
SHIFT = PRINTED_POINT - START


def test_corrected_point_follows_from_the_six_parameters_to_the_last_digit():
    # Parameters of 15 digits times 1049 are good to 1e-12; so is the sum. The update of
    # the listing takes for y the x that has just been updated
    x, y = START
    x = x + PRINTED_A @ (1, x, y)
    y = y + PRINTED_B @ (1, x, y)
    assert (f"{x:.12f}", f"{y:.11f}") == (LOG["corrected X"], LOG["corrected Y"])


def test_update_of_y_takes_the_updated_x_which_costs_0001_px_here():
    as_2_9 = START[1] + PRINTED_B @ (1, *START)
    assert PRINTED_POINT[1] - as_2_9 == approx(0.0014, abs=5e-5)
    # It is the product of two corrections, and vanishes with them
    assert PRINTED_POINT[1] - as_2_9 == approx(PRINTED_B[1] * SHIFT[0], rel=1e-6)


def test_a0_and_b0_are_the_shift_at_the_corner_of_the_image_1083_px_away():
    close(affine(PRINTED, 0, 0), (130.34, 48.50), atol=5e-3)
    close(affine(PRINTED, *START), (-0.0495, 0.0589), atol=5e-5)
    # Increments: with (2.8) for x' itself the match would lie beside the image
    assert affine(PRINTED, *START)[0] < 0


def normal_matrix(centre, half=8, contrast=9.0):
    """A'A of the listing for a window of the test image, the origin of x and y moved
    so that the window lies at `centre`."""
    x, y = window(half)
    A = design(*gradient(x, y, contrast), x + centre[0], y + centre[1])
    return A.T @ A


def test_standard_deviation_of_a0_is_two_hundred_times_that_of_the_shift():
    # The distance from the origin over the spread of the pixels: sqrt(8 * 9 / 3) = 4.9
    near, far = (
        np.sqrt(np.diag(np.linalg.inv(normal_matrix(c)))) for c in ((0, 0), START)
    )
    even = np.hypot(1, np.hypot(*START) / np.std(window(8)[0]))
    assert even == approx(221, abs=0.5)
    assert far[0] / near[0] == approx(262, abs=1)
    assert far[3] / near[3] == approx(243, abs=1)
    # A scale or a shear keeps its own
    close(far[[1, 2, 4, 5]], near[[1, 2, 4, 5]], rtol=1e-4)


def exact_determinant(matrix):
    """Elimination loses digits with the far origin: whole numbers are exact."""
    m, result = [[Fraction(int(v)) for v in row] for row in matrix], Fraction(1)
    for k in range(len(m)):
        result *= m[k][k]
        for row in m[k + 1 :]:
            factor = row[k] / m[k][k]
            row[k:] = [a - factor * b for a, b in zip(row[k:], m[k][k:])]
    return result


def test_determinant_does_not_depend_on_the_origin_of_the_coordinates():
    # x + c = x * 1 + c: a triangular matrix with ones on its diagonal, determinant 1
    x, y = window(8)
    gx, gy = np.round(gradient(x, y, 9.0))
    A = [design(gx, gy, x + a, y + b).astype(np.int64) for a, b in ((0, 0), START)]
    near, far = (exact_determinant(a.T @ a) for a in A)
    assert near == far > 0


def test_condition_does_depend_on_the_origin_and_the_determinant_does_not_see_it():
    near, far = (np.linalg.cond(normal_matrix(c)) for c in ((0, 0), START))
    assert near < 1e3 and far > 1e10
    # The determinant follows the contrast instead, with its twelfth power
    one, two = (np.linalg.det(normal_matrix((0, 0), contrast=c)) for c in (9.0, 18.0))
    assert two / one == approx(2**12, rel=1e-9)


def test_normal_matrix_is_positive_definite_where_gradients_point_in_two_directions():
    # Rounding does not spoil it, not even at the far origin: 1e10 is below 1e16
    for c in ((0, 0), START):
        np.linalg.cholesky(normal_matrix(c))
    # One straight edge, and nothing but whole numbers: a0, a1, a2 only, or less
    x, y = window(8)
    A = design(np.where(x == 0, 50.0, 0.0), np.zeros_like(x), x, y)
    assert np.linalg.matrix_rank(A.T @ A) == 2
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(A.T @ A)
    # It says nothing of the accuracy: any contrast will do
    np.linalg.cholesky(normal_matrix((0, 0), contrast=0.01))


def root_mean_square_gradient():
    """Grey values a pixel that the printed determinant stands for, if the gradients are
    spread evenly over the window and over all directions."""
    spread = np.mean(window(8)[0] ** 2)
    assert spread == approx(24)
    return np.sqrt((float(LOG["det AtA"]) / spread**4) ** (1 / 6) / ROWS)


def test_printed_determinant_stands_for_gradients_of_about_5_5_a_pixel():
    # That the even spread is a fair guess: within a third for 20 windows of the test
    # image. Which pixels it was, only the photo could tell
    printed = root_mean_square_gradient()
    assert printed == approx(5.52, abs=0.01)
    ratios = []
    for k in range(20):
        x, y = window(8, (40.0 * k, 0.0))
        g = gradient(x, y)
        centred = design(*g, *window(8))
        determinant = np.linalg.det(centred.T @ centred)
        guess = np.sqrt((determinant / 24**4) ** (1 / 6) / ROWS)
        ratios.append(guess / np.sqrt((g**2).mean()))
    assert 2 / 3 < min(ratios) and max(ratios) < 4 / 3


def test_printed_s0_is_the_root_divided_by_r_and_stands_for_6_46_grey_values():
    # The listing divides the root by r = 289 - 6. The same V'V in (2.14e):
    r = ROWS - UNKNOWNS
    S0 = np.sqrt((PRINTED_S0 * r) ** 2 / r)
    assert S0 == approx(6.4628, abs=5e-5)
    # 0.384 grey values would be less than the rounding of two images to whole ones
    assert PRINTED_S0 < np.sqrt(2 / 12) < S0


def test_s0_of_the_listing_depends_on_the_size_of_the_window_and_2_14e_does_not():
    rng = np.random.default_rng(7)
    s0 = []
    for half in (5, 8, 16):
        x, y = window(half)
        A, L = design(*gradient(x, y), x, y), rng.normal(0, 6.5, x.size)
        V, r = A @ np.linalg.lstsq(A, L)[0] - L, x.size - 6
        s0.append((np.sqrt(V @ V) / r, np.sqrt(V @ V / r)))
    listing, printed = np.transpose(s0)
    close(printed, 6.5, rtol=0.25)
    assert listing[0] > 2.5 * listing[2]


def test_s0_has_the_unit_of_the_grey_values_and_not_of_the_pixel():
    # Grey values in other units: S0 follows, the shift and its standard deviation stay
    x, y = window(8)
    noise = np.random.default_rng(8).normal(0, 6.5, x.size)
    found = []
    for unit in (1.0, 1 / 255):
        A = unit * design(*gradient(x, y, 9.0), x, y)
        L = unit * (grey(x + 0.05, y - 0.06, 9.0) - grey(x, y, 9.0) + noise)
        X = np.linalg.lstsq(A, L)[0]
        V = A @ X - L
        S0 = np.sqrt(V @ V / (x.size - 6))
        found.append((S0, X[0], S0 * np.sqrt(np.linalg.inv(A.T @ A)[0, 0])))
    assert found[0][0] / found[1][0] == approx(255, rel=1e-9)
    close(found[0][1:], found[1][1:], rtol=1e-9)


def test_standard_deviation_of_the_printed_match_is_nearer_007_than_001_px():
    # S0 over root of the gradient energy: even spread assumed, see the determinant
    S0 = PRINTED_S0 * np.sqrt(ROWS - UNKNOWNS)
    sd = S0 / (root_mean_square_gradient() * np.sqrt(ROWS))
    assert sd == approx(0.069, abs=0.001)
    # The one step that was made is no longer than that
    assert np.all(np.abs(SHIFT) < sd)


def test_typed_s0_has_a_digit_more_than_the_log():
    typed, log = LOG["So in the text"], LOG["So"]
    assert typed.replace("66", "6", 1) == log
    assert float(typed) - float(log) == approx(4.7e-7, abs=1e-8)


def goes_on(p, joined=any):
    """The stop rule: the two scales and the two shears, each pair against 0.03.

    Our description of the listing, to be read beside it. What a test can show is which
    of the two ways of joining agrees with the log, that ends after one step."""
    scales = joined(abs(v) <= 0.03 for v in p[[1, 5]])
    shears = joined(abs(v) <= 0.03 for v in p[[2, 4]])
    return not (scales and shears)


def test_iteration_stops_because_the_limits_are_joined_by_or():
    assert not goes_on(PRINTED, any)
    assert goes_on(PRINTED, all)
    # One of each pair lies beyond its limit, one of them four times
    assert abs(PRINTED[5]) > 0.03 and abs(PRINTED[2]) > 4 * 0.03


def test_stop_rule_does_not_look_at_the_shifts():
    # A window a hundred pixels off its place is accepted; the limit of 0.01 px that is
    # handed over is used nowhere
    moved = PRINTED.copy()
    moved[[0, 3]] += (100.0, -100.0)
    assert not goes_on(moved)
    # The three rules that stand beside it in comments would all have gone on: the move
    # of the point and all six unknowns against 0.01, and a0 and b0 against 0.5
    assert np.any(np.abs(SHIFT) > 0.01)
    assert np.any(np.abs(PRINTED) > 0.01)
    assert min(abs(PRINTED[0]), abs(PRINTED[3])) > 0.5


def test_only_step_moves_the_match_by_005_px_and_corners_by_more_than_a_pixel():
    close(SHIFT, (-0.0495, 0.0603), atol=5e-5)
    assert np.all(np.abs(SHIFT) > 0.01)
    signs = np.array([(-1, -1), (1, -1), (-1, 1), (1, 1)])
    for half, least, most in ((8, 1.061, 1.155), (9, 1.195, 1.293)):
        move = np.hypot(*affine(PRINTED, *(START + half * signs).T))
        close((move.min(), move.max()), (least, most), atol=1e-3)


def returned(solvable, steps):
    """What the caller of the listing gets: the flag starts false, and each solution
    sets it to whether the loop has to go on. This is our description of the listing, to
    be read beside it: the tests show what follows from it, not that it is so."""
    flag = False
    if solvable:
        for p in steps[:75]:
            flag = goes_on(p)
            if not flag:
                break
    return flag


def test_value_returned_is_false_when_the_iteration_has_stopped():
    large = np.array([0, 0.04, 0.04, 0, 0.04, 0.04])
    assert returned(True, [PRINTED]) is False
    assert returned(True, [large] * 80) is True
    assert returned(False, []) is False  # no telling it from a match


def test_three_window_sizes_are_given_and_the_log_is_that_of_17():
    # III.3: 21 x 21 equations; IV.1.2: a template of 19 x 19; the listing: 17 x 17 out
    # of a grid of 19, which its log counts. Each would give another S0 from one V'V
    root = PRINTED_S0 * (ROWS - UNKNOWNS)
    s0 = [root / np.sqrt(n**2 - UNKNOWNS) for n in (21, GRID, GRID - 2)]
    assert np.round(s0, 2).tolist() == [5.21, 5.77, 6.46]
    assert s0[2] == approx(PRINTED_S0 * np.sqrt(ROWS - UNKNOWNS))


def test_standard_deviations_of_the_parameters_need_more_than_s0():
    # The same S0 in two windows: contrast 40 and 9
    sd = [
        6.46 * np.sqrt(np.linalg.inv(normal_matrix((0, 0), contrast=c))[0, 0])
        for c in (40.0, 9.0)
    ]
    assert sd[1] / sd[0] == approx(40 / 9, rel=1e-9)
