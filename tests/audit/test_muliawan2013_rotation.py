"""Proofs of the verdicts on Muliawan 2013. What chapter 4 touches: (2.2) to (2.14),
(2.56) to (2.62). Each matrix is written as printed; scipy says what a rotation is."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx
from scipy.spatial.transform import Rotation

from pgm_lab import datasets, rotation

# Angles without symmetry, also beyond a right angle
ATTITUDES = [(0.3, 0.4, 0.5), (-2.0, 0.9, 1.1), (2.5, -1.2, -2.9)]
anywhere = pytest.mark.parametrize("attitude", ATTITUDES)


def parts(angle):
    return np.cos(angle), np.sin(angle)


def r_omega(omega):
    """(2.3)."""
    c, s = parts(omega)
    return np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


def r_phi(phi):
    """(2.5)."""
    c, s = parts(phi)
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def r_kappa(kappa):
    """(2.7)."""
    c, s = parts(kappa)
    return np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def full_matrix(omega, phi, kappa):
    """(2.8), printed again in 3.3.2.1 and programmed in rotationmatriks.m."""
    (co, so), (cp, sp), (ck, sk) = parts(omega), parts(phi), parts(kappa)
    return np.array(
        [
            [cp * ck, so * sp * ck + co * sk, -co * sp * ck + so * sk],
            [-cp * sk, -so * sp * sk + co * ck, co * sp * sk + so * ck],
            [sp, -so * cp, co * cp],
        ]
    )


def matrix_2_62(omega, phi, kappa):
    (co, so), (cp, sp), (ck, sk) = parts(omega), parts(phi), parts(kappa)
    return np.array(
        [
            [cp * ck, -cp * sk, co],
            [co * sk + so * sp * ck, co * sk - so * sp * sk, -so * cp],
            [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp],
        ]
    )


def matrix_2_13(tilt, azimuth, swing):
    (ct, st), (ca, sa), (cs, ss) = parts(tilt), parts(azimuth), parts(swing)
    return np.array(
        [
            [-ca * cs - sa * ct * ss, sa * cs - ca * ct * ss, -st * ss],
            [ca * ss - sa * ct * cs, -sa * ss - ca * ct * cs, -st * cs],
            [-sa * st, -ca * st, ct],
        ]
    )


def matrix_2_14(a, b, c):
    s = np.array([[a * a - b * b - c * c, 0, 0], [0, b * b - a * a - c * c, 0],
                  [0, 0, c * c - a * a - b * b]]) / 4  # fmt: skip
    turn = [[1, -c + a * b / 2, b + a * c / 2], [c + b * a / 2, 1, -a + b * c / 2],
            [-b + c * a / 2, a + c * b / 2, 1]]  # fmt: skip
    return (turn + s) / (1 + (a * a + b * b + c * c) / 4)


@pytest.mark.parametrize(
    ("printed", "axis"), [(r_omega, "x"), (r_phi, "y"), (r_kappa, "z")]
)
def test_2_3_2_5_2_7_are_coordinates_in_a_frame_that_was_turned_right_handed(
    printed, axis
):
    # scipy turns vectors right-handed; coordinates in the turned frame are the inverse
    expected = Rotation.from_euler(axis, 0.7).inv().as_matrix()
    close(printed(0.7), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("printed", "axis"), [(r_omega, 0), (r_phi, 1), (r_kappa, 2)])
def test_positive_turns_are_clockwise_for_an_eye_that_looks_along_the_axis(
    printed, axis
):
    # An axis of the frame, not parallel to the turn, before and after it
    other = (axis + 2) % 3
    both = np.eye(3)[other], printed(0.1)[other]
    for forward, clockwise in ((np.eye(3)[axis], True), (-np.eye(3)[axis], False)):
        up = np.roll(forward, 1)
        right = np.cross(forward, up)
        before, after = (np.arctan2(v @ up, v @ right) for v in both)
        assert (after < before) == clockwise


@anywhere
def test_turns_follow_each_other_only_if_2_4_and_2_6_take_the_turned_vector(attitude):
    omega, phi, kappa = attitude
    X = np.array([0.3, -1.2, 2.0])
    thrice = r_kappa(kappa) @ (r_phi(phi) @ (r_omega(omega) @ X))
    close(thrice, full_matrix(*attitude) @ X, rtol=0, atol=1e-14)
    # As printed the last equation knows neither omega nor phi
    assert np.abs(r_kappa(kappa) @ X - thrice).max() > 0.3


@anywhere
def test_2_8_is_r_kappa_r_phi_r_omega_and_not_the_order_of_the_sentence(attitude):
    omega, phi, kappa = attitude
    product = r_kappa(kappa) @ r_phi(phi) @ r_omega(omega)
    close(full_matrix(*attitude), product, rtol=0, atol=1e-15)
    other = r_omega(omega) @ r_phi(phi) @ r_kappa(kappa)
    between = Rotation.from_matrix(other @ product.T).magnitude()
    assert between > np.radians(10)


@anywhere
def test_2_8_is_the_transposed_intrinsic_xyz_rotation_of_scipy(attitude):
    expected = Rotation.from_euler("XYZ", attitude).as_matrix().T
    close(full_matrix(*attitude), expected, rtol=0, atol=1e-15)


def test_2_10_holds_for_the_nine_photos_with_the_quadrant_from_both_signs():
    stations, exteriors = np.split(datasets.muliawan2013().exteriors, 2, axis=1)
    M = np.array([full_matrix(*attitude) for attitude in exteriors])
    omega, phi, kappa = exteriors.T
    m = np.moveaxis(M, 0, -1)
    close(m[2, 0], np.sin(phi), rtol=0, atol=1e-15)
    close(-m[2, 1] / m[2, 2], np.tan(omega), rtol=1e-10)
    close(-m[1, 0] / m[0, 0], np.tan(kappa), rtol=1e-10)
    # An arctangent of the quotient misses the quadrant in seven of the nine photos
    plain = np.arctan([-m[2, 1] / m[2, 2], -m[1, 0] / m[0, 0]])
    off = np.abs(plain - (omega, kappa)).max(axis=0)
    equal(off < 1e-9, [1, 0, 1, 0, 0, 0, 0, 0, 0])
    close(off[off > 1e-9], np.pi, rtol=1e-9)
    # Six of them then look away from the object, photo 2 is rolled by 180 degrees
    turned = np.array([full_matrix(o, p, k) for (o, k), p in zip(plain.T, phi)])
    angle = np.degrees(Rotation.from_matrix(np.swapaxes(M, 1, 2) @ turned).magnitude())
    assert np.all((angle[off > 1e-9] > 163) & (angle[off > 1e-9] < 180.001))
    to_object = datasets.muliawan2013().object_points.mean(axis=0) - stations
    along = np.sum(-turned[:, 2] * to_object, axis=1)
    equal(along > 0, [1, 1, 1, 0, 0, 0, 0, 0, 0])
    assert np.all(np.sum(-M[:, 2] * to_object, axis=1) > 0)
    assert angle[1] == approx(180)
    close(turned[1, 2], M[1, 2], rtol=0, atol=1e-9)
    both = np.arctan2([-m[2, 1], -m[1, 0]], [m[2, 2], m[0, 0]])
    close(both, (omega, kappa), rtol=0, atol=1e-14)


@anywhere
def test_2_11_and_2_12_hold_for_2_8_and_for_its_mirror(attitude):
    R = full_matrix(*attitude)
    # Only the determinant tells them apart
    for matrix, determinant in ((R, 1), (np.diag([1, 1, -1]) @ R, -1)):
        close(matrix.T @ matrix, np.eye(3), rtol=0, atol=1e-15)
        close(matrix @ matrix.T, np.eye(3), rtol=0, atol=1e-15)
        close(np.linalg.inv(matrix), matrix.T, rtol=0, atol=1e-15)
        assert np.linalg.det(matrix) == approx(determinant)


@anywhere
def test_2_13_is_a_rotation_from_object_to_image_and_names_the_nadir(attitude):
    tilt, azimuth, swing = attitude
    R = matrix_2_13(*attitude)
    product = r_kappa(swing - np.pi) @ r_omega(tilt) @ r_kappa(-azimuth)
    close(R, product, rtol=0, atol=1e-15)
    expected = rotation.from_tilt_azimuth_swing(*attitude)
    close(R, expected, rtol=0, atol=1e-15)
    # Direction of view: the tilt from the nadir, towards the azimuth
    toward = np.array([np.sin(azimuth), np.cos(azimuth), 0]) * np.sin(tilt)
    close(-R[2], toward - (0, 0, np.cos(tilt)), atol=1e-15)


@pytest.mark.parametrize("vector", [(0.3, -0.5, 0.8), (4.0, 1.0, -2.0)])
def test_2_14_is_a_rotation_by_its_vector_and_transposed_to_2_8(vector):
    R = matrix_2_14(*vector)
    length = np.linalg.norm(vector)
    turn = np.array(vector) / length * 2 * np.arctan(length / 2)
    close(R, Rotation.from_rotvec(turn).as_matrix(), atol=1e-15)
    close(R.T, rotation.from_rodrigues(vector), atol=1e-15)
    close(R.T, matrix_2_14(*-np.array(vector)), atol=1e-15)
    # The same turn about z
    kappa = 0.6
    R = matrix_2_14(0, 0, 2 * np.tan(kappa / 2))
    close(R.T, full_matrix(0, 0, kappa), rtol=0, atol=1e-15)
    assert np.abs(R - full_matrix(0, 0, kappa)).max() > 1


@anywhere
def test_2_57_to_2_59_turn_from_image_to_object_and_combine_to_2_60(attitude):
    (co, so), (cp, sp), (ck, sk) = map(parts, attitude)
    printed = (
        np.array([[1, 0, 0], [0, co, -so], [0, so, co]]),
        np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]]),
        np.array([[ck, -sk, 0], [sk, ck, 0], [0, 0, 1]]),
    )
    for m, r, angle in zip(printed, (r_omega, r_phi, r_kappa), attitude):
        equal(m, r(angle).T)
    product = np.linalg.multi_dot(printed)  # (2.60), (2.61)
    close(product, full_matrix(*attitude).T, rtol=0, atol=1e-15)


@anywhere
def test_seven_elements_of_2_62_are_those_of_the_transposed_2_8(attitude):
    printed, right = matrix_2_62(*attitude), full_matrix(*attitude).T
    wrong = np.abs(printed - right) > 1e-12
    equal(np.argwhere(wrong), [(0, 2), (1, 1)])


@anywhere
def test_2_62_is_a_rotation_only_with_sin_phi_and_cos_kappa(attitude):
    omega, phi, kappa = attitude
    for first, second in itertools.product((False, True), repeat=2):
        M = matrix_2_62(*attitude)
        if first:
            M[0, 2] = np.sin(phi)
        if second:
            M[1, 1] += np.cos(omega) * (np.cos(kappa) - np.sin(kappa))
        right = first and second  # each of the two is needed
        assert rotation.defect(M) < 1e-15 if right else rotation.defect(M) > 0.1
