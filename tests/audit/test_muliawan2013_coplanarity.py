"""Proofs of the verdicts on Muliawan 2013, (2.30) to (2.45): coplanarity."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import camera as cam
from pgm_lab import rotation
from pgm_lab.camera import Camera

F = 35.0
CAMERA = Camera(F)
LEFT = np.array([10.0, -20.0, 800.0, 0.06, -0.09, 0.3])
RIGHT = np.array([420.0, 60.0, 850.0, -0.2, 0.15, -0.7])
RNG = np.random.default_rng(8)
POINTS = RNG.uniform((-100, -300, -80), (450, 300, 90), (12, 3))
IMAGES = [cam.project(CAMERA, exterior, POINTS) for exterior in (LEFT, RIGHT)]


def turned(omega, phi, kappa):
    """M of (2.8) as a product; takes complex numbers."""
    (so, sp, sk), (co, cp, ck) = (
        np.sin([omega, phi, kappa]),
        np.cos([omega, phi, kappa]),
    )
    x = np.array([[1, 0, 0], [0, co, so], [0, -so, co]])
    y = np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])
    return np.array([[ck, sk, 0], [-sk, ck, 0], [0, 0, 1]]) @ y @ x


def ray(image, angles):
    """(2.33) to (2.35): u, v, w of an image point."""
    m, (x, y) = turned(*angles), image
    u = m[0, 0] * x + m[1, 0] * y - m[2, 0] * F
    v = m[0, 1] * x + m[1, 1] * y - m[2, 1] * F
    w = m[0, 2] * x + m[1, 2] * y - m[2, 2] * F
    return np.array([u, v, w])


def expanded(b, one, two):
    """(2.31): the determinant, written out."""
    (bx, by, bz), (u1, v1, w1), (u2, v2, w2) = b, one, two
    return (
        bx * (v1 * w2 - w1 * v2) - by * (u1 * w2 - w1 * u2) + bz * (u1 * v2 - v1 * u2)
    )


BASE = RIGHT[:3] - LEFT[:3]  # (2.32)
PAIRS = [(ray(one, LEFT[3:]), ray(other, RIGHT[3:])) for one, other in zip(*IMAGES)]


def condition(left=LEFT, right=RIGHT, first=None, second=None, i=0):
    first = IMAGES[0][i] if first is None else first
    second = IMAGES[1][i] if second is None else second
    b = right[:3] - left[:3]
    return expanded(b, ray(first, left[3:]), ray(second, right[3:]))


def complex_step(function, x):
    return np.array([function(x + 1e-30j * e).imag / 1e-30 for e in np.eye(len(x))])


def test_2_30_to_2_32_vanish_for_two_rays_of_one_point_only():
    size = np.linalg.norm(BASE) * F * F
    for (i, (one, _)), (j, (_, two)) in itertools.product(enumerate(PAIRS), repeat=2):
        value = expanded(BASE, one, two)
        assert value == approx(np.linalg.det([BASE, one, two]), abs=1e-12 * size)
        assert abs(value) < 1e-12 * size if i == j else abs(value) > 1e-5 * size


def test_2_33_to_2_35_turn_the_ray_into_object_space():
    # Parallel to the vector from the station to the point, and on the same side
    for exterior, images in ((LEFT, IMAGES[0]), (RIGHT, IMAGES[1])):
        for point, image in zip(POINTS, images):
            there, here = point - exterior[:3], ray(image, exterior[3:])
            close(np.cross(there, here), 0, atol=1e-8)
            assert there @ here > 0
    # The coordinates must be reduced to the principal point, as (2.44) writes them
    shifted = cam.project(Camera(F, 0.5, -0.4), LEFT, POINTS[0])
    there = POINTS[0] - LEFT[:3]
    assert np.abs(np.cross(there, ray(shifted, LEFT[3:]))).max() > 100
    reduced = shifted - (0.5, -0.4)
    close(np.cross(there, ray(reduced, LEFT[3:])), 0, atol=1e-8)


def test_2_36_differentiates_one_row_at_a_time():
    start, change = RNG.normal(size=(2, 3, 3))
    derivative = sum(  # of det(start + t change) by t, at 0
        np.linalg.det(np.where(np.arange(3)[:, None] == row, change, start))
        for row in range(3)
    )
    step = 1e-5
    numeric = (
        np.linalg.det(start + step * change) - np.linalg.det(start - step * change)
    ) / (2 * step)
    assert derivative == approx(numeric, rel=1e-8)


UNKNOWN = [1, 2, 3, 4, 5]  # YL, ZL, omega, phi, kappa of the right photo


def linearised(right, images):
    """F, and its derivatives by (x1, y1, x2, y2) and by the five unknowns."""
    F0, A, B = [], [], []
    for first, second in zip(*images):
        F0.append(condition(LEFT, right, first, second))
        image = np.concatenate([first, second])
        A.append(complex_step(lambda x: condition(LEFT, right, x[:2], x[2:]), image))
        B.append(
            complex_step(lambda x, p=(first, second): condition(LEFT, x, *p), right)
        )
    return np.array(F0), np.array(A), np.array(B)[:, UNKNOWN]


def test_2_37_needs_minus_f_on_the_right_hand_side():
    # The condition at the adjusted place: F + A v + B delta = 0. Error-free points, so
    # that v = 0: with -F a step shrinks the error of the start, with F it doubles it
    # (with it corrections that are subtracted, approximate - delta, would be right)
    error = np.array([0.5, -0.3, 1e-3, -1e-3, 2e-3])
    start = RIGHT.copy()
    start[UNKNOWN] += error
    F0, _, B = linearised(start, IMAGES)
    right, printed = (np.linalg.lstsq(B, f, rcond=None)[0] for f in (-F0, F0))
    assert np.all(np.abs(error + right) < 0.02 * np.abs(error))
    close(error + printed, 2 * error, rtol=0.02)
    assert np.all(np.abs(error - printed) < 0.02 * np.abs(error))
    # The same for the residuals of one pair: F + A v = 0 with v = -A'(AA')^-1 F
    pair = IMAGES[0][3] + (0.01, -0.02), IMAGES[1][3] + (-0.015, 0.01)
    F0, A, _ = linearised(RIGHT, ([pair[0]], [pair[1]]))
    v = -A[0] * F0[0] / (A[0] @ A[0])
    after = condition(first=pair[0] + v[:2], second=pair[1] + v[2:])
    assert abs(after) < 1e-3 * abs(F0[0])
    assert abs(condition(first=pair[0] - v[:2], second=pair[1] - v[2:])) > abs(F0[0])


def test_last_element_of_b_below_2_37_is_a_derivative_and_no_quotient():
    # F / kappa, as printed, is 0 for a pair that fits; dF / dkappa is not
    F0, _, B = linearised(RIGHT, IMAGES)
    quotient = F0 / RIGHT[5]
    assert np.abs(quotient).max() < 1e-9 * np.abs(B[:, 4]).min()
    # And the elements of B multiply finite corrections, whatever sign stands there
    move = 1e-4 * np.array([100, -80, 1, -1, 2])
    right = RIGHT.copy()
    right[UNKNOWN] += move
    after, _, _ = linearised(right, IMAGES)
    close(after - F0, B @ move, rtol=0.02)


@pytest.mark.parametrize("i", range(12))
def test_2_38_to_2_42_are_the_derivatives_by_an_image_coordinate_and_the_base(i):
    one, two = PAIRS[i]
    a13 = np.linalg.det([BASE, one, rotation.matrix(*RIGHT[3:])[0]])
    numeric = complex_step(lambda x: condition(second=x, i=i), IMAGES[1][i])
    assert a13 == approx(numeric[0], rel=1e-10)
    (u1, v1, w1), (u2, v2, w2) = one, two
    numeric = complex_step(lambda x: condition(LEFT, x, i=i), RIGHT)
    assert -(u1 * w2 - u2 * w1) == approx(numeric[1], rel=1e-10)  # (2.41)
    assert u1 * v2 - u2 * v1 == approx(numeric[2], rel=1e-10)  # (2.42)


@pytest.mark.parametrize("i", range(12))
def test_2_43_to_2_45_are_the_derivative_by_omega_at_any_attitude(i):
    one, (_, v2, w2) = PAIRS[i]
    moved = complex_step(lambda a: ray(IMAGES[1][i], a), RIGHT[3:])
    close(moved[0], (0, -w2, v2), rtol=1e-12)  # (2.44)
    u1, v1, w1 = one
    bx, by, bz = BASE
    printed = bx * (v1 * v2 - (-w1 * w2)) - by * (u1 * v2) + bz * (-w2 * u1)  # (2.45)
    numeric = complex_step(lambda x: condition(LEFT, x, i=i), RIGHT)
    assert printed == approx(numeric[3], rel=1e-10)
    assert printed == approx(np.linalg.det([BASE, one, (0, -w2, v2)]), rel=1e-10)


@pytest.mark.parametrize("i", range(12))
def test_phi_and_kappa_turn_about_axes_that_the_other_angles_have_moved(i):
    # Omega is the outermost turn of R': its axis stays (1, 0, 0), hence (2.44). The
    # axes of phi and kappa are M_omega' (0, 1, 0) and M' (0, 0, 1); with the pattern
    # of (2.44) about (0, 1, 0) and (0, 0, 1) the derivatives would be wrong
    here = PAIRS[i][1]
    moved = complex_step(lambda a: ray(IMAGES[1][i], a), RIGHT[3:])
    axes = turned(RIGHT[3], 0, 0)[1], turned(*RIGHT[3:])[2]
    for k, axis in zip((1, 2), axes):
        close(moved[k], np.cross(axis, here), rtol=1e-11)
        wrong = np.linalg.norm(np.cross(np.eye(3)[k], here) - moved[k])
        assert wrong > 0.01 * np.linalg.norm(here)


def test_names_of_dependent_and_independent_relative_orientation_are_exchanged():
    # Both sets of five are good: each removes the whole rank defect
    left, right = LEFT.copy(), RIGHT.copy()
    left[:] = (0, 0, 0, *LEFT[3:])
    right[:3] = (410, 0, 0)  # the base is the X axis
    points = RNG.uniform((-100, -300, -900), (450, 300, -700), (30, 3))
    images = [cam.project(CAMERA, e, points) for e in (left, right)]

    def jacobian(columns):
        def value(x, pair):
            return condition(x[:6], x[6:], *pair)

        both = np.concatenate([left, right])
        rows = [complex_step(lambda x, p=p: value(x, p), both) for p in zip(*images)]
        chosen = np.array(rows)[:, columns]
        return chosen / np.linalg.norm(chosen, axis=0)

    printed = {
        "dependent": [3, 4, 5, 10, 11],  # omega1, phi1, kappa1, phi2, kappa2
        "independent": [7, 8, 9, 10, 11],  # by, bz, omega2, phi2, kappa2
    }

    def moves(columns):
        """Whether the left ray and the base move with any of the unknowns."""
        both = np.concatenate([left, right])
        rays = complex_step(lambda x: ray(images[0][0], x[3:6]), both)
        bases = complex_step(lambda x: x[6:9] - x[:3], both)
        return bool(np.any(rays[columns])), bool(np.any(bases[columns]))

    for columns in printed.values():
        assert np.linalg.matrix_rank(jacobian(columns), tol=1e-6) == 5
    # Dependent: one photo is fitted to the other, which keeps its attitude; the base
    # is found. Independent: both photos are turned over a base that stays as it is
    assert moves(printed["independent"]) == (False, True)
    assert moves(printed["dependent"]) == (True, False)
