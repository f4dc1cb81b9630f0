"""Proofs of the verdicts on the program for least squares matching of Bani 2010:
chapter III.3, steps 4 to 10, and the class LSM6A of the appendix. For its log see
test_bani2010_lsm_log.py.

The listing is described here in our own words, one property at a time."""

import numpy as np
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_lab import datasets

from .matching import (
    PRINTED,
    PRINTED_POINT,
    PRINTED_S0,
    START,
    affine,
    design,
    gradient,
    grey,
    window,
)

SHIFT = PRINTED_POINT - START


def lattice(p, n=19):
    """x', y' of the grid of the listing: n pairs, of the pixels on the diagonal, give
    the columns their x' and the rows their y'. Our description of the listing, to be
    read beside it; the log does not reach a second step and cannot confirm it."""
    steps = np.arange(n) - n // 2
    columns, rows = affine(p, steps, steps)
    return np.meshgrid(columns, rows)


def true_grid(p, n=19):
    steps = np.arange(n) - n // 2
    return affine(p, *np.meshgrid(steps, steps))


def test_nineteen_pairs_cannot_carry_a_shear_or_a_rotation():
    # x' of the lattice is the same in every row, whatever the six parameters: all its
    # transformations span four dimensions, those of (2.8) and (2.9) six
    for grid, rank in ((lattice, 4), (true_grid, 6)):
        spanned = [np.concatenate(grid(e)).ravel() for e in np.eye(6)]
        assert np.linalg.matrix_rank(spanned) == rank
    local = PRINTED.copy()
    local[[0, 3]] = SHIFT
    x1, y1 = lattice(local)
    assert np.ptp(x1, axis=0).max() == 0 and np.ptp(y1, axis=1).max() == 0
    # With the printed shear of -0.127, a corner would be wrong by more than 2 px
    wrong = np.hypot(*np.subtract(lattice(local), true_grid(local)))
    assert wrong.max() == approx(2.34, abs=0.01)


def test_lattice_turns_the_shears_into_scales():
    p = np.array([0, 1.0, 0.02, 0, -0.03, 1.0])
    x1, y1 = lattice(p)
    close(np.diff(x1, axis=1), 1.02, rtol=1e-12)
    close(np.diff(y1, axis=0), 0.97, rtol=1e-12)


def test_differences_between_lattice_points_are_gradients_only_at_their_spacing():
    # Half the difference over two steps of 1.02 px: 2 per cent too large on a ramp.
    x1, _ = lattice(np.array([0, 1.02, 0, 0, 0, 1.0]))
    ramp = 7.0 * x1
    close((ramp[:, 2:] - ramp[:, :-2]) / 2, 7.0 * 1.02)
    # A step is then shorter by this factor, and zero where the right one is zero
    x, y = window(8)
    gx, gy = gradient(x, y)
    L = grey(x + 0.1, y + 0.1) - grey(x, y)
    steps = [np.linalg.lstsq(design(k * gx, k * gy, x, y), L)[0] for k in (1, 1.02)]
    close(steps[0], 1.02 * steps[1], rtol=1e-9)


def bilinear(image, x, y):
    X, Y = x.astype(int), y.astype(int)
    dx, dy = x - X, y - Y
    upper = image[Y, X] * (1 - dx) + image[Y, X + 1] * dx
    return (
        upper * (1 - dy) + (image[Y + 1, X] * (1 - dx) + image[Y + 1, X + 1] * dx) * dy
    )


def small_image(contrast=9.0):
    y, x = np.mgrid[0:60, 0:60].astype(float)
    return np.round(grey(x, y, contrast))


def test_whole_gradients_cost_no_accuracy_at_good_contrast():
    # From the second iteration the listing cuts them towards zero. Any columns near the
    # right ones have their zero of A'V near the least squares point
    x, y = window(8)
    rng = np.random.default_rng(12)
    errors = {np.trunc: [], np.positive: []}
    for _ in range(40):
        template = grey(x + 0.3, y - 0.2) + rng.normal(0, 2, x.size)
        for whole, found in errors.items():
            p = np.array([0, 1, 0, 0, 0, 1.0])
            for _ in range(6):
                at = affine(p, x, y)
                A = design(*whole(gradient(*at)), x, y)
                p += np.linalg.lstsq(A, template - grey(*at))[0]
            found.append(p[[0, 3]] - (0.3, -0.2))
    cut, exact = (np.sqrt(np.mean(np.square(e))) for e in errors.values())
    assert 0 < abs(cut / exact - 1) < 0.02


def test_whole_grey_values_add_029_and_cutting_half_a_grey_value_of_brightness():
    image = small_image(40.0)
    x, y = np.meshgrid(np.arange(5, 50) + 0.37, np.arange(5, 50) + 0.61)
    value = bilinear(image, x, y)
    rounded, cut = np.floor(value + 0.5) - value, np.floor(value) - value
    assert rounded.std() == approx(np.sqrt(1 / 12), rel=0.1)
    assert abs(rounded.mean()) < 0.03
    assert cut.std() == approx(np.sqrt(1 / 12), rel=0.1)
    assert cut.mean() == approx(-0.5, abs=0.03)
    # Beside the 6.46 of the log the 0.29 adds a thousandth
    S0 = PRINTED_S0 * np.sqrt(283)
    assert np.hypot(S0, cut.std()) / S0 - 1 < 0.0011


def test_b_needs_the_grey_value_of_the_match_and_not_its_row():
    # III.3, 6.2 takes a name away that 6.1 gives no value; the appendix the grey value.
    # A row number would ask for grey values a thousand below zero
    x, y = window(8)
    A = design(*gradient(x, y), x, y)
    template = grey(x + 0.2, y - 0.1)
    for taken, right in ((grey(x, y), True), (y + START[1], False)):
        shift = np.linalg.lstsq(A, template - taken)[0][[0, 3]]
        assert np.allclose(shift, (0.2, -0.1), rtol=0, atol=0.03) == right


def test_image_to_resample_is_the_one_that_2_8_gives_fractions_in():
    # Template pixels are whole, their matches are not: III.3, 7 reads the template
    assert all(np.all(v == np.round(v)) for v in window(8, (332, 1063)))
    there = np.add(window(8, START), affine(PRINTED, *window(8, START)))
    assert np.all(np.abs(there - np.round(there)).max(axis=1) > 0.4)


def test_bilinear_interpolation_returns_the_pixels_of_the_template_themselves():
    # IV.1.3.1 applies it to both images: at whole coordinates nothing changes
    image = small_image(40.0)
    x, y = np.meshgrid(np.arange(5.0, 50), np.arange(5.0, 50))
    equal(bilinear(image, x, y), image[5:50, 5:50])


def test_arrangement_of_the_design_matrix_is_in_table_2_2_and_not_in_4_1():
    """Table 4.1 has four coordinates a point, the matrix six columns a pixel."""
    points = datasets.rows("bani2010_pixel_points.csv")
    coordinates = [name for name in points[0] if name != "point"]
    assert (len(points), len(coordinates)) == (10, 4)
    x, y = window(8)
    assert design(*gradient(x, y), x, y).shape == (17 * 17, 6)


def test_six_parameters_put_the_difference_of_brightness_into_s0():
    # Gain 1.08 and offset 4, noise 1: the listing has no h0 and h1, (2.18) has
    x, y = window(8)
    rng = np.random.default_rng(11)
    six = design(*gradient(x, y), x, y)
    eight = np.column_stack([six, np.ones_like(x), grey(x, y)])
    L = (grey(x, y) - 4) / 1.08 - grey(x, y) + rng.normal(0, 1, x.size)
    s0 = []
    for A in (six, eight):
        V = A @ np.linalg.lstsq(A, L)[0] - L
        s0.append(np.sqrt(V @ V / (x.size - A.shape[1])))
    assert s0[0] > 5 and s0[1] == approx(1, abs=0.15)
