"""Rotations: scipy as the independent program, round trips up to the singular cases.

What this does not prove: that a source or a program means the same angles; see
tests/audit and the conventions table of chapter 4.
"""

import warnings

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation

from pgm_lab import rotation

EPS = np.finfo(float).eps
QUARTER = np.pi / 2
# Also the angles at and just beside the singular cases
SPECIAL = st.sampled_from([0.0, QUARTER, -QUARTER, np.pi, -np.pi])
TINY = st.sampled_from([0.0, 1e-16, -1e-13, 1e-11, 1e-9, -1e-7, 1e-4])
ANGLE = st.floats(-np.pi, np.pi) | st.builds(lambda a, b: a + b, SPECIAL, TINY)
THREE = st.tuples(ANGLE, ANGLE, ANGLE)
STACK = hnp.arrays(
    float,
    st.tuples(st.integers(0, 3), st.integers(1, 4), st.just(3)),
    elements=st.floats(-4, 4),
)


def random_matrices(n, seed=1):
    """Uniformly distributed rotations that scipy made, object to image."""
    rotations = Rotation.random(n, np.random.default_rng(seed))
    return rotations.as_matrix().swapaxes(-1, -2)


def ignoring_ambiguity(function, *arguments):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return function(*arguments)


# --- against other programs ---------------------------------------------------------


@given(THREE)
def test_matrix_is_the_transposed_intrinsic_xyz_rotation_of_scipy(three):
    expected = Rotation.from_euler("XYZ", three).as_matrix().T
    # Products of three cosines: a few roundings
    np.testing.assert_allclose(rotation.matrix(*three), expected, rtol=0, atol=4 * EPS)


def test_angles_quaternions_and_vectors_agree_with_scipy():
    M = random_matrices(1000)
    scipy = Rotation.from_matrix(M.swapaxes(-1, -2))
    np.testing.assert_allclose(
        rotation.angles(M), scipy.as_euler("XYZ"), rtol=0, atol=1e-12
    )
    # None is singular, and a warning would fail this test
    rotation.to_tilt_azimuth_swing(M)
    assert not rotation.is_gimbal(M).any()
    q = np.roll(scipy.as_quat(), 1, axis=-1)
    q *= np.where(q[:, :1] < 0, -1, 1)
    np.testing.assert_allclose(rotation.to_quaternion(M), q, rtol=0, atol=1e-14)
    # From scipy's angle times axis; near the half turn the vector grows without limit
    turn = scipy.as_rotvec()
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    vector = 2 * np.tan(angle / 2) * turn / angle
    np.testing.assert_allclose(rotation.to_rodrigues(M), vector, rtol=1e-9, atol=1e-9)


def test_rodrigues_of_opencv_is_the_same_turn_with_another_length():
    vector = np.array([0.3, -0.5, 0.8])
    length = np.linalg.norm(vector)
    rvec = vector / length * 2 * np.arctan(length / 2)
    # OpenCV turns vectors by rvec; ours turns the camera, so vectors the other way
    expected = cv2.Rodrigues(rvec)[0].T
    np.testing.assert_allclose(
        rotation.from_rodrigues(vector), expected, rtol=0, atol=1e-15
    )


def test_nearest_and_angle_between_agree_with_scipy():
    M, N = random_matrices(200), random_matrices(200, seed=2)
    noisy = M + np.random.default_rng(3).normal(0, 0.1, M.shape)
    expected = Rotation.align_vectors  # the same problem, solved one by one
    for one, near in zip(noisy, rotation.nearest(noisy), strict=True):
        # Rotating the axes onto the columns of the matrix, least squares
        np.testing.assert_allclose(
            near, expected(one.T, np.eye(3))[0].as_matrix(), rtol=0, atol=1e-7
        )
    between = (Rotation.from_matrix(M) * Rotation.from_matrix(N).inv()).magnitude()
    np.testing.assert_allclose(rotation.angle_between(M, N), between, atol=1e-13)


# --- what a camera does -------------------------------------------------------------


def test_a_positive_angle_turns_the_camera_counter_clockwise():
    # The rows of M are the camera's axes in object space
    turn = 0.1
    x, y, _ = rotation.matrix(0, 0, turn)
    np.testing.assert_allclose(x, (np.cos(turn), np.sin(turn), 0))
    np.testing.assert_allclose(y, (-np.sin(turn), np.cos(turn), 0))
    view = -rotation.matrix([turn, 0], [0, turn], 0)[:, 2]
    assert view[0, 1] > 0  # omega: the view goes from down towards +Y
    assert view[1, 0] < 0  # phi: the view goes from down towards -X


def test_tilt_azimuth_swing_say_where_the_camera_looks():
    tilt, azimuth, swing = 0.4, 0.7, -2.0
    M = rotation.from_tilt_azimuth_swing(tilt, azimuth, swing)
    view = -M[2]
    assert np.arccos(-view[2]) == pytest.approx(tilt)  # from straight down
    assert np.arctan2(view[0], view[1]) == pytest.approx(azimuth)  # from +Y clockwise
    nadir = M @ (0, 0, -1)
    x, y = -nadir[:2] / nadir[2]
    assert np.arctan2(x, y) == pytest.approx(swing)  # from +y clockwise


# --- round trips --------------------------------------------------------------------


@given(STACK)
def test_every_matrix_is_a_rotation(three):
    for M in (
        rotation.matrix(*np.moveaxis(three, -1, 0)),
        rotation.from_tilt_azimuth_swing(*np.moveaxis(three, -1, 0)),
        rotation.from_rodrigues(three),
    ):
        assert M.shape == (*three.shape, 3)
        assert np.all(rotation.defect(M) < 10 * EPS)
        assert np.all(np.linalg.det(M) > 0)


@given(THREE)
@example((0.3, QUARTER, 0.2))
@example((0.3, QUARTER - 3e-11, 0.2))
@example((0.3, -QUARTER + 2e-10, 0.2))
def test_angles_give_the_matrix_back_also_beside_gimbal_lock(three):
    M = rotation.matrix(*three)
    found = ignoring_ambiguity(rotation.angles, M)
    locked = np.abs(np.cos(three[1])) < 2e-10
    # In gimbal lock what is left out is smaller than its limit of 1e-10
    tolerance = 4e-10 if locked else 20 * EPS
    np.testing.assert_allclose(rotation.matrix(*found), M, rtol=0, atol=tolerance)
    assert np.all(np.abs(found) <= np.pi) and abs(found[1]) <= QUARTER


@given(THREE)
@example((0.0, 0.3, 0.2))
@example((np.pi, 0.3, 0.2))
@example((3e-10, 0.3, 0.2))
def test_tilt_azimuth_swing_give_the_matrix_back_also_beside_the_vertical(three):
    M = rotation.from_tilt_azimuth_swing(*three)
    found = ignoring_ambiguity(rotation.to_tilt_azimuth_swing, M)
    vertical = np.abs(np.sin(three[0])) < 2e-10
    tolerance = 4e-10 if vertical else 20 * EPS
    again = rotation.from_tilt_azimuth_swing(*found)
    np.testing.assert_allclose(again, M, rtol=0, atol=tolerance)
    assert np.all(np.abs(found) <= np.pi) and found[0] >= 0


@given(THREE)
def test_quaternions_give_the_matrix_back_for_every_rotation(three):
    M = rotation.matrix(*three)
    q = rotation.to_quaternion(M)
    assert q[0] >= 0 and abs(np.linalg.norm(q) - 1) < 4 * EPS
    np.testing.assert_allclose(rotation.from_quaternion(q), M, rtol=0, atol=10 * EPS)
    np.testing.assert_array_equal(
        rotation.from_quaternion(q), rotation.from_quaternion(-q)
    )


@given(
    hnp.arrays(float, 3, elements=st.floats(-1, 1)),
    st.sampled_from([0.0, 1e-300, 1e-12, 1e-3, 1.0, 1e3, 1e7]),
)
def test_rodrigues_vectors_come_back_from_no_turn_to_nearly_a_half_turn(part, size):
    vector = part * size
    found = rotation.to_rodrigues(rotation.from_rodrigues(vector))
    # A rounding of the matrix, eps, changes a long vector by its square times eps
    tolerance = 20 * EPS * (1 + vector @ vector)
    np.testing.assert_allclose(found, vector, rtol=0, atol=tolerance)
    # A huge one is a half turn, and its square does not overflow
    M = rotation.from_rodrigues([1e300, 0.0, 0.0])
    np.testing.assert_allclose(M, np.diag([1, -1, -1]), atol=1e-15)


@given(STACK)
def test_a_stack_gives_what_its_members_give(three):
    angles = np.moveaxis(three, -1, 0)
    M = rotation.matrix(*angles)
    by_angles = rotation.derivatives(*angles)
    for index in np.ndindex(M.shape[:-2]):
        one = rotation.derivatives(*three[index])
        np.testing.assert_allclose(by_angles[index], one, rtol=0, atol=4 * EPS)
    functions = [rotation.angles, rotation.to_tilt_azimuth_swing]
    functions += [rotation.to_quaternion, rotation.defect, rotation.nearest]
    for function in functions:
        whole = ignoring_ambiguity(function, M)
        for index in np.ndindex(M.shape[:-2]):
            one = ignoring_ambiguity(function, M[index])
            np.testing.assert_allclose(whole[index], one, rtol=0, atol=4 * EPS)


# --- derivatives and small angles ---------------------------------------------------


@given(THREE, st.integers(0, 2))
def test_derivatives_agree_with_central_differences(three, k):
    h = 1e-5
    step = h * np.eye(3)[k]
    plus, minus = rotation.matrix(*(three + step)), rotation.matrix(*(three - step))
    # Truncation h^2/6 = 2e-11, rounding eps/h = 2e-11
    np.testing.assert_allclose(
        rotation.derivatives(*three)[k], (plus - minus) / (2 * h), rtol=0, atol=1e-10
    )


# --- singular cases are named -------------------------------------------------------


@pytest.mark.parametrize(("phi", "sign"), [(QUARTER, 1), (-QUARTER, -1)])
def test_gimbal_lock_keeps_the_sum_or_the_difference_and_says_so(phi, sign):
    M = rotation.matrix(0.3, phi, 0.2)
    assert rotation.is_gimbal(M)
    near = rotation.matrix(0.3, phi - sign * 1e-4, 0.2)
    assert not rotation.is_gimbal(near) and rotation.is_gimbal(near, cosine=1e-3)
    with pytest.warns(RuntimeWarning, match="gimbal lock: omega and kappa of M cannot"):
        found = rotation.angles(M)
    np.testing.assert_allclose(found, (0.3 + sign * 0.2, phi, 0.0), atol=1e-15)


@pytest.mark.parametrize("gap", [70.0, 10.0, 1.0, 0.1])
def test_rounding_grows_as_one_over_cos_phi_near_gimbal_lock_and_the_sum_is_spared(gap):
    """Five printed digits: uniform rounding errors of 1e-5, over cos phi."""
    omega, kappa = np.random.default_rng(4).uniform(-1.5, 1.5, (2, 4000))
    printed = rotation.matrix(omega, np.radians(90 - gap), kappa).round(5)
    found = rotation.angles(printed, tolerance=1e-4)
    predicted = 1e-5 / np.sqrt(12) / np.sin(np.radians(gap))
    assert abs(np.std(found[:, 0] - omega) / predicted - 1) < 0.1
    if gap <= 1:
        assert np.std(found[:, 0] + found[:, 2] - omega - kappa) < 2e-5


@pytest.mark.parametrize(("tilt", "sign"), [(0.0, 1), (np.pi, -1)])
def test_vertical_photo_keeps_swing_and_azimuth_together_and_says_so(tilt, sign):
    M = rotation.from_tilt_azimuth_swing(tilt, 0.3, 0.2)
    with pytest.warns(RuntimeWarning, match="vertical photo: azimuth and swing of M"):
        found = rotation.to_tilt_azimuth_swing(M)
    np.testing.assert_allclose(found[::2], (tilt, np.pi), atol=1e-15)
    np.testing.assert_allclose(
        np.exp(1j * (sign * found[1] - found[2])), np.exp(1j * (sign * 0.3 - 0.2))
    )


@given(st.tuples(*3 * [st.floats(-1, 1)]).filter(lambda v: np.linalg.norm(v) > 0.1))
def test_half_turn_has_a_quaternion_but_no_rodrigues_vector(axis):
    axis = np.array(axis) / np.linalg.norm(axis)
    M = 2 * np.outer(axis, axis) - np.eye(3)
    with pytest.raises(ValueError, match="M rotates by 180 degrees and has no Rod"):
        rotation.to_rodrigues(M)
    q = rotation.to_quaternion(M)
    np.testing.assert_allclose(rotation.from_quaternion(q), M, rtol=0, atol=10 * EPS)


# --- bad input ----------------------------------------------------------------------

MIRROR = np.diag([1.0, 1.0, -1.0])
MIRRORED = np.stack([np.eye(3), MIRROR])
M = rotation.matrix(0.1, 0.2, 0.3)


def test_mirror_or_flat_matrix_has_no_nearest_rotation():
    with pytest.raises(ValueError, match="the determinant of M is not positive"):
        rotation.nearest(MIRROR)
    with pytest.raises(ValueError, match=r"of M\[1\] \(one of 1\) is not positive"):
        rotation.nearest(np.stack([np.eye(3), np.ones((3, 3))]))


@pytest.mark.parametrize(
    ("function", "arguments", "message"),
    [
        (rotation.from_quaternion, ([2, 0, 0, 0],), "length 1; it differs by up to 1,"),
        (rotation.angles, (np.eye(3) + 0.01,), r"M is not a rotation: .* 0\.02, more"),
        (rotation.angles, (M.round(5),), "For a matrix copied from print, set the tol"),
        (rotation.to_quaternion, (MIRRORED,), r"M\[1\] \(one of 1\) is not a rotation"),
        (rotation.angle_between, (np.eye(3), MIRROR), "second is not a rotation but a"),
        (rotation.angle_between, (MIRROR, np.eye(3)), "first is not a rotation but a"),
    ],
)
def test_bad_numbers_are_named(function, arguments, message):
    with pytest.raises(ValueError, match=message):
        function(*arguments)
