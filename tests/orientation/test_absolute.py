"""Absolute orientation: a published example, independent programs, simulated errors.

What this does not prove: that the covariance holds for errors in the source that are
not the same in all directions.
"""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from pgm_lab import rotation
from pgm_lab.orientation import absolute
from tests.chance import assert_chi_square

# Example of the public-domain program conf3d by B. Dewitt (the companion of Wolf and
# Dewitt 2000): control points with model and ground coordinates, then model points.
CONF3D = np.array(
    [
        [390.35, 499.63, 469.43, 607.54, 501.63, 469.09],
        [371.68, 630.84, 81.25, 589.98, 632.36, 82.81],
        [425.65, 419.07, 82.49, 643.65, 421.28, 83.50],
        [410.50, 438.31, 81.13, 628.58, 440.51, 82.27],
        [448.22, 295.83, 97.79, 666.27, 298.16, 98.29],
        [414.60, 709.39, 101.77, 632.59, 710.62, 103.01],
    ]
)
MODEL, GROUND = CONF3D[:, :3], CONF3D[:, 3:]
CONF3D_POINTS = np.array(
    [
        [611.37, 498.98, 470.45],
        [637.49, 323.67, 85.67],
        [573.32, 401.51, 84.48],
        [647.00, 373.97, 83.76],
        [533.51, 285.01, 87.13],
    ]
)
ANGLE = st.floats(-3.1, 3.1)
SEED = st.integers(0, 2**32 - 1)


def similarity(scale, angles, shift, points):
    return scale * points @ rotation.matrix(*angles) + shift


@pytest.fixture(scope="module")
def conf3d():
    return absolute(MODEL, GROUND)


def test_conf3d_to_the_printed_digits(conf3d):
    p, sd = conf3d.parameters, conf3d.sd
    np.testing.assert_array_equal(
        np.degrees([p[1:4], sd[1:4]]).round(4),
        [[0.0540, -0.1318, -0.0002], [0.0295, 0.0404, 0.0417]],
    )
    assert (round(p[0], 5), round(sd[0], 5)) == (0.99674, 0.00051)
    np.testing.assert_array_equal(
        np.round([p[4:], sd[4:]], 3), [[219.620, 3.687, -0.060], [0.442, 0.414, 0.420]]
    )
    residuals = [
        [0.083, -0.385, 0.112],
        [-0.076, 0.032, -0.441],
        [0.044, 0.031, 0.030],
        [0.017, -0.021, -0.112],
        [-0.115, 0.298, 0.426],
        [0.047, 0.046, -0.016],
    ]
    np.testing.assert_array_equal(conf3d.residuals.round(3), residuals)
    assert conf3d.redundancy == 3 * 6 - 7 == 11 and round(conf3d.sigma0, 5) == 0.24755


def test_conf3d_transformed_points_and_their_precision_to_the_printed_digits(conf3d):
    printed = [
        [827.919, 500.595, 470.725, 0.266, 0.246, 0.237],
        [854.835, 326.217, 87.096, 0.204, 0.215, 0.207],
        [790.878, 403.805, 85.836, 0.156, 0.166, 0.162],
        [864.319, 376.355, 85.261, 0.187, 0.211, 0.204],
        [751.191, 287.683, 88.276, 0.200, 0.176, 0.172],
    ]
    covariance = conf3d.apply_covariance(CONF3D_POINTS)
    sd = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    found = np.hstack([conf3d.apply(CONF3D_POINTS), sd])
    np.testing.assert_array_equal(found.round(3), printed)
    stack = np.broadcast_to(CONF3D_POINTS, (2, 5, 3))
    np.testing.assert_array_equal(conf3d.apply(stack)[1], conf3d.apply(CONF3D_POINTS))
    assert conf3d.apply_covariance(stack).shape == (2, 5, 3, 3)


@given(
    SEED, st.floats(1e-3, 1e3), ANGLE, st.floats(-1.5, 1.5), ANGLE, st.integers(3, 9)
)
def test_error_free_points_give_the_parameters_back(seed, scale, omega, phi, kappa, n):
    rng = np.random.default_rng(seed)
    source, shift = rng.normal(0, 10, (n, 3)), rng.normal(0, 1000, 3)
    target = similarity(scale, (omega, phi, kappa), shift, source)
    found = absolute(source, target)
    # Rounding of the target, seen from a triangle that may be slim
    slim = np.linalg.svd(source - source.mean(axis=0))[1][1]
    rounding = 1e-13 * np.abs(target).max() / (scale * slim)
    assert found.scale == pytest.approx(scale, rel=rounding)
    R = rotation.matrix(omega, phi, kappa).T
    np.testing.assert_allclose(found.rotation, R, rtol=0, atol=rounding)
    again = rotation.matrix(*found.parameters[1:4]).T
    np.testing.assert_allclose(again, found.rotation, rtol=0, atol=1e-14)
    direct = found.scale * source @ found.rotation.T + found.translation
    for reached in (found.apply(source), direct):
        atol = 1e-12 * np.abs(target).max()
        np.testing.assert_allclose(reached, target, rtol=0, atol=atol)


@given(SEED)
def test_agrees_with_scipy_and_opencv(seed):
    rng = np.random.default_rng(seed)
    source = rng.normal(0, 10, (8, 3))
    angles = rng.uniform(-1.5, 1.5, 3)
    target = similarity(1.7, angles, (5, 6, 7), source) + rng.normal(0, 0.3, (8, 3))
    found = absolute(source, target)
    s, t = source - source.mean(axis=0), target - target.mean(axis=0)
    turned, _ = Rotation.align_vectors(t, s)
    np.testing.assert_allclose(found.rotation, turned.as_matrix(), atol=1e-9)
    # With force_rotation it is the similarity of Umeyama 1991
    affine, scale = cv2.estimateAffine3D(source, target, force_rotation=True)
    assert found.scale == pytest.approx(scale, rel=1e-6)
    np.testing.assert_allclose(found.rotation, affine[:, :3], atol=1e-6)


@given(SEED, st.booleans())
def test_weights_give_the_minimum_that_scipy_finds(seed, each_coordinate):
    rng = np.random.default_rng(seed)
    source, angles = rng.normal(0, 10, (6, 3)), rng.uniform(-1.2, 1.2, 3)
    sigma = 10 ** rng.uniform(-2, 0, (6, 3) if each_coordinate else 6)
    spread = sigma if each_coordinate else sigma[:, None]
    target = similarity(0.6, angles, (50, 60, 7), source)
    target = target + rng.normal(0, 1, (6, 3)) * spread
    found = absolute(source, target, sigma)

    def misfit(x):
        computed = similarity(x[0], x[1:4], x[4:], source)
        return ((computed - target) / spread).ravel()

    tight = {"x_scale": "jac", "xtol": 1e-14, "ftol": 1e-14}
    peer = least_squares(misfit, found.parameters, **tight)
    assert np.max(np.abs(peer.x - found.parameters) / found.sd) < 1e-4
    Q = np.linalg.inv(peer.jac.T @ peer.jac)
    np.testing.assert_allclose(
        found.covariance, Q, rtol=1e-4, atol=1e-5 * found.sd.max() ** 2
    )
    assert found.sigma0 == pytest.approx(np.sqrt(2 * peer.cost / 11), rel=1e-6)


@pytest.mark.parametrize("angles", [(0.4, -0.3, 2.0), (0.4, np.pi / 2, 2.0)])
@pytest.mark.parametrize(
    "spread",
    [*(pytest.param(s, marks=pytest.mark.slow) for s in ("scalar", "points")), "axes"],
)
def test_covariance_holds_in_250_simulated_cases(angles, spread):
    """Squared Mahalanobis distances of scale, turns and centroid against chi-square."""
    rng = np.random.default_rng(11)
    source = rng.uniform(-50, 50, (7, 3)) + (1000, 2000, 300)
    sigma = {
        "scalar": 0.05,
        "points": rng.uniform(0.01, 0.1, 7),
        "axes": rng.uniform(0.01, 0.1, (7, 3)),
    }[spread]
    sd = sigma[:, None] if spread == "points" else sigma
    exact = similarity(1.3, angles, (10, 20, 30), source)
    far = np.array([1100, 2100, 400])
    true_far, R = similarity(1.3, angles, (10, 20, 30), far), rotation.matrix(*angles).T
    distances, outside, variances, w = [], [], [], []
    for _ in range(250):
        found = absolute(source, exact + rng.normal(0, 1, (7, 3)) * sd, sigma)
        turn = Rotation.from_matrix(found.rotation @ R.T).as_rotvec()
        moved = found.apply(source.mean(axis=0)) - exact.mean(axis=0)
        error = np.concatenate([[found.scale - 1.3], turn, moved])
        distances.append(error @ np.linalg.solve(found.local_covariance, error))
        error = found.apply(far) - true_far
        outside.append(error @ np.linalg.solve(found.apply_covariance(far), error))
        variances.append(14 * found.sigma0**2)
        w.append(found.standardized)
    assert_chi_square(distances, 7)
    assert_chi_square(outside, 3)
    assert_chi_square(variances, 14)
    assert np.var(w) == pytest.approx(1, abs=0.07)


def test_sigma_of_any_shape_scales_the_covariance_alone(conf3d):
    known = absolute(MODEL, GROUND, sigma=0.1)
    ratio = conf3d.sigma0 / 0.1
    np.testing.assert_allclose(
        known.covariance * ratio**2, conf3d.covariance, rtol=1e-9, atol=1e-20
    )
    assert known.sigma0 == pytest.approx(ratio, rel=1e-12)
    np.testing.assert_allclose(known.parameters, conf3d.parameters, rtol=1e-9)
    for sigma in (np.full(6, 0.1), np.full((6, 3), 0.1)):
        same = absolute(MODEL, GROUND, sigma)
        np.testing.assert_array_equal(same.parameters, known.parameters)
    # Of three points it counts the points, not the axes
    found = absolute(MODEL[:3], GROUND[:3], [1e-3, 1, 1])
    assert np.abs(found.residuals[0]).max() < 1e-5 < np.abs(found.residuals[1:]).min()


@pytest.mark.parametrize("sign", [-1, 1])
def test_gimbal_lock_is_named_and_all_else_holds(sign):
    angles = (0.3, sign * np.pi / 2, -0.8)
    source = np.random.default_rng(5).normal(0, 10, (6, 3))
    found = absolute(source, similarity(2.0, angles, (1, 2, 3), source), sigma=0.01)
    assert found.status == "gimbal lock"
    np.testing.assert_allclose(found.rotation, rotation.matrix(*angles).T, atol=1e-12)
    again = rotation.matrix(*found.parameters[1:4]).T
    np.testing.assert_allclose(again, found.rotation, atol=1e-12)
    known = [0, 2, 4, 5, 6]
    assert np.isnan(found.covariance[1]).all() and np.isnan(found.covariance[3]).all()
    assert np.isfinite(found.covariance[np.ix_(known, known)]).all()
    assert np.isfinite(found.apply_covariance(source)).all()


def test_points_in_a_plane_are_never_mirrored():
    rng = np.random.default_rng(8)
    for _ in range(60):
        source = rng.normal(0, 10, (5, 3)) * (1, 1, 0)
        angles = rng.uniform(-1.5, 1.5, 3)
        target = similarity(1.0, angles, 0, source) + rng.normal(0, 0.01, (5, 3))
        found = absolute(source + rng.normal(0, 0.01, (5, 3)), target)
        R = rotation.matrix(*angles).T
        np.testing.assert_allclose(found.rotation, R, atol=0.05)


def test_nearly_collinear_points_are_called_weak_geometry():
    rng = np.random.default_rng(2)
    source = np.linspace(0, 100, 6)[:, None] * (1, 2, 3) + rng.normal(0, 0.05, (6, 3))
    found = absolute(source, source + rng.normal(0, 0.05, (6, 3)), sigma=0.05)
    assert found.status == "weak geometry"


def mirrored(axis, noise):
    rng = np.random.default_rng(9)
    source = rng.normal(0, 10, (6, 3))
    target = similarity(3.0, (0.1, 0.2, 0.3), (4, 5, 6), source)
    target[:, axis] *= -1
    return {"source": source, "target": target + rng.normal(0, 1, (6, 3)) * noise}


LINE = np.arange(4.0)[:, None] * (1.0, 2.0, -1.0) + (5.0, 6.0, 7.0)
OCTAHEDRON = np.concatenate([np.eye(3), -np.eye(3)])
# Opposite points are moved alike: that tells nothing of the rotation, which a mirrored
# octahedron leaves open
SHAKEN = OCTAHEDRON * (2, 1, -1) + np.tile([(5, 0, 0), (-5, 0, 0), (0, 0, 0)], (2, 1))
GOOD = {"source": MODEL[:4], "target": GROUND[:4]}
BAD = [
    ({"source": MODEL[:2], "target": GROUND[:2]}, r"2 point\(s\).*three"),
    ({"source": MODEL[:3]}, r"same shape \(n, 3\); got \(3, 3\) and \(4, 3\)"),
    ({"source": LINE}, "source: all points lie on one line.*free"),
    ({"target": np.full((4, 3), 9.9e6)}, "target: all points lie at one place"),
    (mirrored(0, 0.0), "mirror image of source"),
    (mirrored(2, 0.01), "mirror image of source"),
    ({"source": OCTAHEDRON, "target": SHAKEN}, "do not fit together"),
    ({"sigma": np.ones(3)}, r"shape \(4,\) or \(4, 3\); got shape \(3,\)"),
]


@pytest.mark.parametrize(("change", "message"), BAD)
def test_bad_input_is_refused_and_named(change, message):
    with pytest.raises(ValueError, match=message):
        absolute(**(GOOD | change))
