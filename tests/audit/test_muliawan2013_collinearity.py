"""Proofs of the verdicts on Muliawan 2013, (2.18) to (2.29) and (2.63) to (2.68)."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import camera as cam
from pgm_lab import rotation
from pgm_lab.camera import Camera

from . import as_printed

F, CENTRE = 35.0, (0.4, -0.3)
CAMERA = Camera(F, *CENTRE)
# Attitudes without symmetry, in all quadrants of kappa; the points lie in front
EXTERIORS = np.array(
    [
        (120.0, -340.0, 900.0, 0.3, -0.4, 2.1),
        (-50.0, 60.0, 700.0, -0.5, 0.2, -0.6),
        (30.0, 10.0, 800.0, 0.2, 0.6, 0.9),
        (10.0, -90.0, 650.0, -0.1, -0.3, -2.5),
    ]
)
POINTS = np.array([(310.0, -150.0, 45.0), (40.0, 20.0, -30.0), (-200.0, 110.0, 60.0)])
CASES = [(e, p) for e in EXTERIORS for p in POINTS]


def ratio(x, exterior, point):
    """r, s, q written out, independent of the camera model; takes complex numbers."""
    so, sp, sk = np.sin(exterior[3:])
    co, cp, ck = np.cos(exterior[3:])
    turns = (
        np.array([[ck, sk, 0], [-sk, ck, 0], [0, 0, 1]]),
        np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]]),
        np.array([[1, 0, 0], [0, co, so], [0, -so, co]]),
    )
    r, s, q = turns[0] @ turns[1] @ turns[2] @ (point - exterior[:3])
    return np.array([-x * r / q, -x * s / q])


def derivatives(exterior, point):
    """{b11 ... b26: derivative of the computed coordinate}, by complex step."""
    unknowns = np.concatenate([exterior[3:], point])

    def computed(u):
        return ratio(F, np.concatenate([exterior[:3] + 0j, u[:3]]), u[3:])

    columns = [computed(unknowns + 1e-30j * e).imag / 1e-30 for e in np.eye(6)]
    names = as_printed.ROW_X + as_printed.ROW_Y
    return dict(zip(names, np.array(columns).T.ravel()))


def deviations(formula):
    """Largest deviation of each coefficient from the derivative, by its own size."""
    found = []
    for exterior, point in CASES:
        expected, values = derivatives(exterior, point), formula(F, exterior, point)
        found.append(
            [abs(values[k] - expected[k]) / abs(expected[k]) for k in expected]
        )
    return dict(zip(expected, np.max(found, axis=0)))


def test_2_18_and_2_19_give_the_image_with_the_scale_minus_f_over_q():
    # x = lambda R (X - Xc): lambda changes from point to point, and is positive.
    # R (X - Xc) are r, s, q of (2.25) to (2.27): the ray in the frame of the camera
    for exterior, point in CASES:
        *_, rays = as_printed.terms(exterior, point)
        scale = -F / rays[2]
        x, y, minus_f = scale * np.array(rays)
        assert scale > 0 and minus_f == approx(-F, rel=1e-15)
        image = cam.project(Camera(F), exterior, point)
        close((x, y), image, rtol=0, atol=1e-12)
        depth = cam.collinearity(CAMERA, exterior, point, (0, 0)).depth
        assert -rays[2] == approx(float(depth), rel=1e-13)
        distance = np.linalg.norm(point - exterior[:3])
        assert np.linalg.norm(rays) == approx(distance, rel=1e-13)


def test_2_20_and_2_21_hold_with_brackets_and_not_with_absolute_values():
    images = [cam.project(CAMERA, *case) - CENTRE for case in CASES]
    close(images, [ratio(F, *case) for case in CASES], rtol=1e-12)
    # -f |...| would be negative throughout; a half of the coordinates is not
    assert 0.2 < np.mean(np.array(images) > 0) < 0.8


def test_2_20_follows_from_2_19_and_not_from_2_2():
    # (2.2) turns by omega alone, without station and scale
    for exterior, point in CASES:
        x, y, minus_f = rotation.matrix(*exterior[3:]) @ (point - exterior[:3])
        close(
            (-F * x / minus_f, -F * y / minus_f), ratio(F, exterior, point), rtol=1e-12
        )
        x, y, minus_f = rotation.matrix(exterior[3], 0, 0) @ point
        off = np.array([-F * x / minus_f, -F * y / minus_f]) - ratio(F, exterior, point)
        assert np.linalg.norm(off) > 5  # mm


def test_2_22_and_2_23_are_first_order_with_v_computed_minus_observed():
    # The changes move the image by some 0.05 mm; what second order leaves is below
    # 3e-4 mm. (2.23) needs the residual of y: with that of x it would be off
    rng = np.random.default_rng(3)
    for exterior, point in CASES:
        observed = cam.project(CAMERA, exterior, point) + (0.02, -0.05)
        b = as_printed.muliawan_listing(F, exterior, point)
        move = rng.normal(size=9) * np.array([1e-3] * 3 + [0.3] * 6)  # angles, XL, XA
        moved = exterior + np.concatenate([move[3:6], move[:3]])
        v = cam.project(CAMERA, moved, point + move[6:]) - observed
        computed = cam.project(CAMERA, exterior, point)
        for row, axis in ((as_printed.ROW_X, 0), (as_printed.ROW_Y, 1)):
            angles, place = [b[k] for k in row[:3]], [b[k] for k in row[3:]]
            right = np.dot(angles, move[:3]) + np.dot(place, move[6:] - move[3:6])
            misclosure = observed[axis] - computed[axis]  # J or K
            assert v[axis] + misclosure == approx(right, abs=3e-4)
            assert abs(v[1 - axis] + misclosure - right) > 3e-3


RIGHT = ("b11", "b12", "b14", "b15", "b16", "b21", "b24", "b25")


def test_2_24_eight_coefficients_are_the_derivatives():
    off = deviations(as_printed.muliawan_2_24)
    assert all(off[name] < 1e-12 for name in RIGHT)
    assert sorted(set(off) - set(RIGHT)) == ["b13", "b22", "b23", "b26"]


def repaired(name, change):
    """The printed coefficient with one element replaced, and the derivative."""
    assert deviations(as_printed.muliawan_2_24)[name] > 0.1
    for exterior, point in CASES:
        m, _, differences, (_, s, q) = as_printed.terms(exterior, point)
        printed = as_printed.muliawan_2_24(F, exterior, point)[name]
        right = printed + change(m, differences, s, q)
        assert right == approx(derivatives(exterior, point)[name], rel=1e-12)


def test_2_24_b13_needs_m21_for_m12():
    repaired("b13", lambda m, d, s, q: -F / q * (m[1, 0] - m[0, 1]) * d[0])
    # Turning the camera about its own axis moves x by y: b13 = y
    for case in CASES:
        b13 = as_printed.muliawan_listing(F, *case)["b13"]
        assert b13 == approx(ratio(F, *case)[1], rel=1e-12)


def test_2_24_b26_needs_m33_for_m32():
    repaired("b26", lambda m, d, s, q: F / q**2 * s * (m[2, 2] - m[2, 1]))


def test_2_24_b22_needs_two_signs_turned():
    assert deviations(as_printed.muliawan_2_24)["b22"] > 0.1
    # All eight combinations of signs: one alone gives the derivative, one the print
    fits = {"right": [], "printed": []}
    for signs in itertools.product((1, -1), repeat=3):
        off = []
        for exterior, point in CASES:
            _, angles, d, (_, s, q) = as_printed.terms(exterior, point)
            (so, sp, sk), (co, cp, _) = np.sin(angles), np.cos(angles)
            common = cp * d[0] + sp * (so * d[1] - co * d[2])
            turned = sk * np.dot(signs, (sp * d[0], so * cp * d[1], co * cp * d[2]))
            b22 = F / q**2 * (s * common - q * turned)
            in_text = as_printed.muliawan_2_24(F, exterior, point)["b22"]
            off.append((b22 / derivatives(exterior, point)["b22"], b22 / in_text))
        for name, worst in zip(fits, np.abs(np.array(off) - 1).max(axis=0)):
            if worst < 1e-12:
                fits[name].append(signs)
    assert fits == {"right": [(1, -1, 1)], "printed": [(-1, -1, -1)]}


def test_2_24_b23_has_the_wrong_sign():
    for exterior, point in CASES:
        printed = as_printed.muliawan_2_24(F, exterior, point)["b23"]
        assert -printed == approx(derivatives(exterior, point)["b23"], rel=1e-12)
        x, _ = ratio(F, exterior, point)
        assert -printed == approx(-x, rel=1e-12)  # y moves by -x


def test_listing_computes_all_twelve_coefficients_right():
    off = deviations(as_printed.muliawan_listing)
    assert max(off.values()) < 1e-12
    # And the camera model agrees: exterior (XL, angles), point
    for exterior, point in CASES:
        b = as_printed.muliawan_listing(F, exterior, point)
        result = cam.collinearity(CAMERA, exterior, point, (0, 0))
        for row, axis in ((as_printed.ROW_X, 0), (as_printed.ROW_Y, 1)):
            values = np.array([b[name] for name in row])
            model = [*result.exterior[axis, 3:], *result.point[axis]]
            close(values, model, rtol=1e-11)
            close(-values[3:], result.exterior[axis, :3], rtol=1e-11)


def test_2_28_and_2_29_are_observed_minus_computed():
    for exterior, point in CASES:
        observed = cam.project(CAMERA, exterior, point) + (0.02, -0.05)
        *_, (r, s, q) = as_printed.terms(exterior, point)
        misclosure = observed - CENTRE + F * np.array([r, s]) / q
        close(misclosure, (0.02, -0.05), atol=1e-12)


# Resection, (2.63) to (2.68)

GROUND = np.array(
    [
        (-300, -200, 20),
        (280, -260, -30),
        (310, 240, 60),
        (-250, 290, -10),
        (20, 40, 90),
        (150, -90, 10),
        (-120, 60, -50),
    ],
    float,
)
TRUE = EXTERIORS[1]


def test_2_63_needs_the_matrix_from_object_to_image():
    # a, b, c number the columns: (a1, b1, c1) is the first row of (2.8). The matrix of
    # the section before, (2.60), is the other one, and its rows do not fit
    image = cam.project(CAMERA, TRUE, GROUND) - CENTRE
    M = rotation.matrix(*TRUE[3:])
    for m, fits in ((M, True), (M.T, False)):
        rays = (GROUND - TRUE[:3]) @ m.T
        agree = np.allclose(-F * rays[:, :2] / rays[:, 2:], image, rtol=0, atol=1e-10)
        assert agree == fits


def step(exterior, observed, points):
    """One solution of (2.65) to (2.67) for the corrections of the exterior."""
    result = cam.collinearity(CAMERA, exterior, points, observed, wrt=("exterior",))
    b = -result.v.ravel()  # x - (x), y - (y)
    A = result.exterior.reshape(-1, 6)
    return np.linalg.lstsq(A, b, rcond=None)[0], A, b


def test_2_65_to_2_67_converge_to_the_true_exterior():
    observed = cam.project(CAMERA, TRUE, GROUND)
    exterior = TRUE + (20, -30, 40, 0.05, -0.04, 0.06)
    for _ in range(6):
        exterior = exterior + step(exterior, observed, GROUND)[0]
    close(exterior, TRUE, rtol=0, atol=1e-8)


def test_2_64_holds_to_first_order_for_finite_increments():
    # The partial signs before Xs ... kappa stand for differences: halved, they leave a
    # quarter of the error
    move = np.array([0.4, -0.3, 0.5, 1e-3, -8e-4, 1e-3])
    before = cam.project(CAMERA, TRUE, GROUND)
    A = cam.collinearity(CAMERA, TRUE, GROUND, before, wrt=("exterior",)).exterior
    left = [
        cam.project(CAMERA, TRUE + part * move, GROUND) - before - A @ (part * move)
        for part in (1, 0.5)
    ]
    assert np.abs(left[0]).max() < 1e-3 < 0.05 < np.abs(A @ move).max()
    close(left[1], left[0] / 4, rtol=0, atol=2e-6)


def test_2_64_second_row_needs_y_on_the_left():
    # With x - (y), as printed, the iteration has no meaning: it never comes close
    observed = cam.project(CAMERA, TRUE, GROUND)
    exterior = TRUE + (1e-3, 0, 0, 0, 0, 0)
    _, A, b = step(exterior, observed, GROUND)
    computed = observed.ravel() - b
    printed = b.copy()
    printed[1::2] = observed[:, 0] - computed[1::2]
    close(np.linalg.lstsq(A, b, rcond=None)[0], TRUE - exterior, rtol=0, atol=1e-6)
    wrong = np.linalg.lstsq(A, printed, rcond=None)[0]
    assert np.linalg.norm(wrong[:3]) > 100  # start values good to a millimetre


@pytest.mark.parametrize(
    ("n", "rank"), [(2, 4), (3, 6), (4, 6), (5, 6), (6, 6), (7, 6)]
)
def test_2_68_rank_is_six_from_three_points_on_and_below_n_from_seven_on(n, rank):
    observed = cam.project(CAMERA, TRUE, GROUND)
    _, A, _ = step(TRUE, observed[:n], GROUND[:n])
    scaled = A / np.linalg.norm(A, axis=0)
    assert np.linalg.matrix_rank(scaled, tol=1e-9) == rank
    # (2.68) wants rank < n. With n for the control points, as the text has it, it asks
    # for seven; the 2n observations exceed the rank from four on
    assert (rank < n) == (n >= 7)
    if n > 2:
        assert (rank < 2 * n) == (n >= 4)


def test_ground_points_need_intersection_and_two_photos():
    # One photo, oriented: two equations for three unknowns. Two photos: four
    point = POINTS[1]
    one = cam.collinearity(CAMERA, EXTERIORS[0], point, (0, 0), wrt=("point",)).point
    assert np.linalg.matrix_rank(one) == 2
    two = cam.collinearity(CAMERA, EXTERIORS[:2], point, (0, 0), wrt=("point",)).point
    assert np.linalg.matrix_rank(two.reshape(4, 3)) == 3
