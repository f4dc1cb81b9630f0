"""Relative orientation: a published example, the dense collinearity adjustment, OpenCV,
simulated errors, starts far away and none at all.

What this does not prove: anything about wrong matches; least squares spreads them.
"""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from pgm_lab import rotation
from pgm_lab.adjustment import adjust
from pgm_lab.camera import Camera, collinearity, project
from pgm_lab.orientation import coplanarity, relative
from tests.chance import assert_chi_square

# Example of the public-domain program relor by B. Dewitt (the companion of Wolf and
# Dewitt 2000): x, y in the left photo, x, y in the right one, in mm.
RELOR = np.array(
    [
        [-4.878, 1.974, -97.920, -2.923],
        [89.307, 2.709, -1.507, -1.856],
        [0.261, 84.144, -90.917, 78.970],
        [90.334, 83.843, -1.571, 79.470],
        [-4.668, -86.821, -100.060, -95.748],
        [88.599, -85.274, -0.965, -94.319],
    ]
)
RELOR_CAMERA, RELOR_BASE = Camera(152.113), 91.9825
RELOR_PAIR = (RELOR_CAMERA, RELOR_CAMERA, RELOR[:, :2], RELOR[:, 2:])

LEFT_LENS = Camera(50.0, 0.1, -0.2, K1=-2e-5, P1=1e-5, b1=1e-4)
RIGHT_LENS = Camera(60.0, -0.3, 0.05, K1=1e-5, K2=1e-9, P2=-2e-5, lens="forward")
ORIGIN = np.zeros(6)
CAMERAS = Camera(50.0), Camera(60.0)


def scene(rng, n, planar=False):
    """Points in front of a left photo at the origin, 60 to 120 away."""
    plan = rng.uniform(-0.5, 0.5, (n, 2))
    depth = 80 * np.ones(n) if planar else rng.uniform(60, 120, n)
    if planar:
        depth = 80 / (1 - plan @ (0.2, -0.3))
    return np.column_stack([plan * depth[:, None], -depth])


def convergent(rng, swing=3.1):
    """Right photo that looks at the scene of `scene`, bx = 30."""
    base = np.array([30.0, *rng.uniform(-15, 15, 2)])
    aim = (base - (0, 0, -85)) / np.linalg.norm(base - (0, 0, -85))
    phi, omega = np.arcsin(aim[0]), np.arctan2(-aim[1], aim[2])
    M = rotation.matrix(*rng.uniform(-0.05, 0.05, 2), rng.uniform(-swing, swing))
    return np.concatenate([base, rotation.angles(M @ rotation.matrix(omega, phi, 0))])


def pair(rng, n=12, noise=0.0, planar=False, cameras=CAMERAS):
    """Points, right exterior and measured coordinates of a simulated stereo pair."""
    points, right = scene(rng, n, planar), convergent(rng)
    images = [
        project(camera, exterior, points) + rng.normal(0, 1, (n, 2)) * noise
        for camera, exterior in zip(cameras, (ORIGIN, right), strict=True)
    ]
    return points, right, images


def turn(first, second):
    return rotation.angle_between(rotation.matrix(*first), rotation.matrix(*second))


@pytest.fixture(scope="module")
def relor():
    return relative(*RELOR_PAIR, base=RELOR_BASE)


def test_relor_to_the_printed_digits(relor):
    assert relor.status == "converged"
    degrees = np.degrees([relor.exterior[3:], relor.sd[3:]]).round(4)
    np.testing.assert_array_equal(
        degrees, [[2.4077, 0.5550, -0.2053], [0.0065, 0.0069, 0.0032]]
    )
    assert relor.exterior[0] == RELOR_BASE and relor.sd[0] == 0
    station = relor.exterior[1:3] + (0, 152.113)  # its left photo stands at Z = f
    np.testing.assert_array_equal(
        np.round([station, relor.sd[1:3]], 4), [[-1.7187, 148.3025], [0.0209, 0.0075]]
    )
    points = [
        [-4.8433, 1.9618, 1.0824, 0.0049, 0.0041, 0.0375],
        [89.0766, 2.7002, 0.3923, 0.0178, 0.0042, 0.0312],
        [0.2590, 83.5083, 1.1473, 0.0045, 0.0200, 0.0384],
        [89.2623, 82.8493, 1.8047, 0.0180, 0.0187, 0.0311],
        [-4.6281, -86.0801, 1.2995, 0.0049, 0.0213, 0.0396],
        [89.3199, -85.9670, -1.2378, 0.0189, 0.0203, 0.0333],
    ]
    sd = np.sqrt(np.diagonal(relor.points_covariance, axis1=1, axis2=2))
    found = np.hstack([relor.points + (0, 0, 152.113), sd])
    np.testing.assert_array_equal(found.round(4), points)
    residuals = [
        [0.0000, 0.0019, -0.0000, -0.0018],
        [-0.0000, -0.0018, 0.0000, 0.0018],
        [-0.0000, -0.0010, 0.0000, 0.0010],
        [0.0000, 0.0010, -0.0000, -0.0010],
        [0.0000, -0.0009, -0.0000, 0.0008],
        [-0.0000, 0.0009, 0.0000, -0.0008],
    ]
    found = np.concatenate(relor.residuals, axis=1)
    np.testing.assert_array_equal(found.round(4), residuals)
    # 24 coordinates, 5 + 3 * 6 unknowns
    assert relor.redundancy == 6 - 5 == 1 and round(relor.sigma0, 5) == 0.00452


def test_sigma_scales_the_covariance_and_the_base_the_model(relor):
    known = relative(*RELOR_PAIR, base=RELOR_BASE, sigma=0.01)
    np.testing.assert_allclose(known.exterior, relor.exterior, rtol=1e-9)
    assert known.sigma0 == pytest.approx(relor.sigma0, rel=1e-9)
    ratio = (0.01 / relor.sigma0) ** 2
    np.testing.assert_allclose(
        known.points_covariance, ratio * relor.points_covariance, rtol=1e-6
    )
    unit = relative(*RELOR_PAIR)
    np.testing.assert_allclose(unit.points * RELOR_BASE, relor.points, rtol=1e-6)
    np.testing.assert_allclose(unit.sd[3:], relor.sd[3:], rtol=1e-6)


def dense(cameras, images, right, points):
    """The same model with 5 + 3 n unknowns by collinearity, on the general core."""
    n = len(points)
    stations = np.stack([ORIGIN, right])

    def equations(x):
        stations[1, 1:] = x[:5]
        v, A = [], np.zeros((2, n, 2, 5 + 3 * n))
        for i in range(2):
            found = collinearity(
                cameras[i], stations[i], x[5:].reshape(n, 3), images[i]
            )
            v.append(found.v)
            for j in range(n):
                A[i, j, :, 5 + 3 * j : 8 + 3 * j] = found.point[j]
            if i:
                A[i, :, :, :5] = found.exterior[..., 1:]
        return np.ravel(v), A.reshape(4 * n, -1)

    start = np.concatenate([right[1:], np.ravel(points)])
    return adjust(equations, start, np.zeros(4 * n), tolerance=1e-9)


@pytest.mark.parametrize("noise", [0.002, 0.5])
@pytest.mark.parametrize("planar", [False, True])
def test_equals_the_dense_adjustment_of_all_unknowns(noise, planar):
    """Also with errors of a hundredth of the image, where nothing is linear."""
    cameras = (LEFT_LENS, Camera(60.0, 0.1, 0.2, K1=1e-5))
    points, right, images = pair(np.random.default_rng(4), 9, noise, planar, cameras)
    found = relative(*cameras, *images, base=30.0, start=right[1:])
    whole = dense(cameras, images, found.exterior, found.points)
    assert found.status in ("converged", "weak geometry", "no base")
    x = np.concatenate([found.exterior[1:], found.points.ravel()])
    assert np.max(np.abs(whole.x - x) / whole.sd) < 1e-6
    assert found.redundancy == whole.redundancy == 4
    assert found.sigma0 == pytest.approx(whole.sigma0, rel=1e-8)
    residuals = found.residuals.ravel()
    np.testing.assert_allclose(residuals, whole.residuals, atol=1e-7 * noise)

    def close(part, expected):
        size = np.sqrt(np.diagonal(expected))
        difference = (part - expected) / np.outer(size, size)
        np.testing.assert_allclose(difference, 0, atol=1e-6)

    close(found.covariance[1:, 1:], whole.covariance[:5, :5])
    for j, part in enumerate(found.points_covariance):
        own = slice(5 + 3 * j, 8 + 3 * j)
        close(part, whole.covariance[own, own])
    w = whole.standardized.reshape(2, 9, 2)
    np.testing.assert_allclose(
        np.abs(w), np.abs(found.standardized)[:, None] + 0 * w, atol=1e-5
    )


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=5)
def test_error_free_photos_give_orientation_and_points_back(seed):
    rng = np.random.default_rng(seed)
    cameras = (LEFT_LENS, RIGHT_LENS)
    points, right, images = pair(rng, 15, cameras=cameras)
    found = relative(*cameras, *images, base=30.0, sigma=0.001)
    assert found.status == "converged"
    # Rounding, some 1e-12 of the image, against errors of 1e-3 mm
    assert np.max(np.abs(found.exterior - right)[1:] / found.sd[1:]) < 1e-5
    np.testing.assert_allclose(found.points, points, atol=1e-6)
    assert np.abs(found.residuals).max() < 1e-9


@pytest.mark.parametrize("seed", range(1))
def test_agrees_with_opencv_on_error_free_photos(seed):
    _, right, (left_image, right_image) = pair(np.random.default_rng(seed), 20)
    found = relative(*CAMERAS, left_image, right_image, base=30.0, sigma=0.001)
    # OpenCV: normalised coordinates, y down, the camera looks along +z
    normalised = [left_image / (50, -50), right_image / (60, -60)]
    E, _ = cv2.findEssentialMat(*normalised, np.eye(3), threshold=1e-6)
    _, R, t, _ = cv2.recoverPose(E[:3], *normalised)
    flip = np.diag([1, -1, -1])
    M = flip @ R @ flip
    base = -M.T @ flip @ t.ravel()
    np.testing.assert_allclose(rotation.matrix(*found.exterior[3:]), M, atol=1e-6)
    np.testing.assert_allclose(found.exterior[:3], base * 30 / base[0], atol=1e-4)


@pytest.mark.slow
def test_covariance_of_orientation_and_points_holds_in_100_simulated_cases():
    rng, sigma = np.random.default_rng(21), 0.01
    points, right, images = pair(rng, 10)
    orientation, point, squares, w = [], [], [], []
    for _ in range(100):
        noisy = [image + rng.normal(0, sigma, image.shape) for image in images]
        found = relative(*CAMERAS, *noisy, base=30.0, start=right[1:], sigma=sigma)
        d = (found.exterior - right)[1:]
        orientation.append(d @ np.linalg.solve(found.covariance[1:, 1:], d))
        d = found.points[3] - points[3]
        point.append(d @ np.linalg.solve(found.points_covariance[3], d))
        squares.append(np.sum(found.residuals**2) / sigma**2)
        w.append(found.standardized)
    assert_chi_square(orientation, 5)
    assert_chi_square(point, 3)
    assert_chi_square(squares, 5)
    assert np.var(w) == pytest.approx(1, abs=0.14)  # 100 * 5 free ones: 2 sd


@pytest.mark.parametrize(
    ("seed", "pairs"), [(36, 4), pytest.param(31, 40, marks=pytest.mark.slow)]
)
def test_from_a_start_30_degrees_and_half_the_base_off(seed, pairs):
    """Of the first four pairs one is lost if nothing around the start is tried."""
    rng = np.random.default_rng(seed)
    for _ in range(pairs):
        _, right, images = pair(rng, 12, noise=0.005)
        away = rng.normal(0, 1, 3)
        M = rotation.matrix(*(np.radians(30) * away / np.linalg.norm(away)))
        M = M @ rotation.matrix(*right[3:])
        off = rng.normal(0, 1, 2)
        start = [*(right[1:3] + 15 * off / np.linalg.norm(off)), *rotation.angles(M)]
        found = relative(*CAMERAS, *images, base=30.0, start=start, sigma=0.005)
        assert found.status == "converged"
        assert turn(found.exterior[3:], right[3:]) < 0.02


@pytest.mark.parametrize(
    "n", [30, *(pytest.param(n, marks=pytest.mark.slow) for n in (6, 300))]
)
@pytest.mark.parametrize("planar", [False, True])
def test_without_start_the_true_model_is_always_among_the_solutions(n, planar):
    rng = np.random.default_rng(41)
    for _ in range(5):
        _, right, images = pair(rng, n, noise=0.005, planar=planar)
        found = relative(*CAMERAS, *images, base=30.0, sigma=0.005)
        errors = [turn(solution[3:], right[3:]) for solution in found.solutions]
        assert min(errors) < 0.05
        if len(errors) == 1:
            assert found.status == "converged"
        else:
            assert planar or n == 6
            assert found.status == "several solutions"
        np.testing.assert_allclose(found.solutions[0], found.exterior, rtol=1e-4)


@pytest.mark.parametrize("pairs", [3, pytest.param(6, marks=pytest.mark.slow)])
def test_five_points_have_several_solutions_and_no_redundancy(pairs):
    rng = np.random.default_rng(51)
    counts = []
    for _ in range(pairs):
        _, right, images = pair(rng, 5)
        found = relative(*CAMERAS, *images, base=30.0)
        errors = [turn(solution[3:], right[3:]) for solution in found.solutions]
        assert min(errors) < 1e-6
        assert found.redundancy == 0 and np.isnan(found.sigma0)
        assert np.isnan(found.covariance[1:, 1:]).all()
        counts.append(len(errors))
        alone = found.status == "no redundancy"
        assert alone == (len(errors) == 1)
        assert alone or found.status == "several solutions"
    assert max(counts) > 1 and min(counts) == 1


def random_pair(rng, n=12, sigma=0.002):
    """Base of length 1 in any direction; the right photo looks at the points."""
    while True:
        base = rng.normal(size=3)
        base /= np.linalg.norm(base)
        distance = rng.uniform(1.5, 4)
        points = rng.uniform(-0.5, 0.5, (n, 3)) * distance * [1, 1, 0.5]
        points = points @ rotation.matrix(*rng.uniform(-0.5, 0.5, 2), 0.0)
        points -= (0, 0, distance)
        aim = (base - points.mean(axis=0)) / np.linalg.norm(base - points.mean(axis=0))
        towards = rotation.matrix(np.arctan2(-aim[1], aim[2]), np.arcsin(aim[0]), 0.0)
        M = rotation.matrix(*rng.uniform(-0.2, 0.2, 2), rng.uniform(-3.1, 3.1))
        right = np.array([*base, *rotation.angles(M @ towards)])
        in_view = points[:, 2] < -0.3, (points - base) @ (M @ towards)[2] < -0.3
        if np.all(in_view):
            images = [project(CAMERAS[0], e, points) for e in (ORIGIN, right)]
            if np.abs(images).max() < 25:
                return right, images + sigma * rng.normal(size=(2, n, 2))


def assert_is_the_truth(found, right):
    base = found.exterior[:3] / np.linalg.norm(found.exterior[:3])
    assert found.status == "converged"
    assert base @ right[:3] > np.cos(0.1)
    assert turn(found.exterior[3:], right[3:]) < 0.05


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(s, marks=pytest.mark.slow) for s in range(1, 5))]
)
def test_sign_of_a_missing_base_is_found_and_a_wrong_one_refused(seed):
    right, images = random_pair(np.random.default_rng([63, seed]))
    sign, pair = np.sign(right[0]), (CAMERAS[0], CAMERAS[0], *images)
    found = relative(*pair, sigma=0.002)
    assert found.exterior[0] == sign
    assert_is_the_truth(found, right)
    with pytest.raises(ValueError, match="has the wrong sign") as refused:
        relative(*pair, base=-sign, sigma=0.002)
    # What the message advises helps
    assert f"Write base = {sign:g}, or" in str(refused.value)
    reversed_start = [*(-found.exterior[1:3]), *found.exterior[3:]]
    with pytest.raises(ValueError, match="has the wrong sign"):
        relative(*pair, base=-sign, start=reversed_start, sigma=0.002)
    given = relative(*pair, base=sign, sigma=0.002)
    np.testing.assert_allclose(given.exterior, found.exterior, rtol=1e-6, atol=1e-8)


def test_base_across_the_x_axis_is_named():
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (12, 3)) * (1, 1, 1 / 3)
    right = np.array([1e-5, 0.0, 1.0, 0.1, -0.05, 0.3])
    images = [project(CAMERAS[0], e, points - (0, 0, 3)) for e in (ORIGIN, right)]
    with pytest.raises(ValueError, match="at right angles to the x axis"):
        relative(CAMERAS[0], CAMERAS[0], *images, sigma=0.002)


def test_phi_of_90_degrees_is_gimbal_lock_and_all_else_holds():
    rng = np.random.default_rng(71)
    points = rng.uniform(-20, 20, (12, 3)) + (0, 0, -85)
    right = np.array([85.0, 5.0, -85.0, 0.2, np.pi / 2, 0.0])
    images = [project(Camera(50.0), e, points) for e in (ORIGIN, right)]
    found = relative(Camera(50.0), Camera(50.0), *images, base=85.0, sigma=0.001)
    np.testing.assert_allclose(found.points, points, atol=1e-6)
    M = rotation.matrix(*right[3:])
    np.testing.assert_allclose(rotation.matrix(*found.exterior[3:]), M, atol=1e-8)
    assert np.isfinite(found.points_covariance).all()
    locked = rotation.is_gimbal(rotation.matrix(*found.exterior[3:]))
    assert (found.status == "gimbal lock") == locked
    assert found.sd[4] < 1e-3
    assert np.isnan(found.sd[3]) if locked else found.sd[3] > 1


def test_point_behind_a_camera_and_parallel_rays_are_named():
    """A pair of wrong rays beside good ones; and one that meets at infinity."""
    rng = np.random.default_rng(72)
    points = scene(rng, 30)
    right = np.array([30.0, 0, 0, 0, 0, 0])
    camera = Camera(50.0)
    left_image, right_image = (project(camera, e, points) for e in (ORIGIN, right))
    right_image[4] = left_image[4] + (1.0, 0.0)  # diverging rays
    right_image[7] = left_image[7]  # parallel rays
    found = relative(
        camera, camera, left_image, right_image, base=30.0, start=np.zeros(5)
    )
    assert found.status == "points behind a camera"
    assert found.point_status[4] == "behind a camera"
    assert found.point_status[7] in ("parallel rays", "behind a camera")
    named = found.point_status != "intersected"
    assert set(np.flatnonzero(named)) <= {4, 7}
    assert np.isnan(found.points[named]).all()
    assert np.isnan(found.points_covariance[named]).all()
    assert np.isfinite(found.points[~named]).all()


def test_lost_base_is_named():
    points = scene(np.random.default_rng(73), 20)
    angles = (0.1, 0.05, 0.4)
    images = [
        project(CAMERAS[0], e, points) + noise
        for e, noise in zip(
            (ORIGIN, [0, 0, 0, *angles]),
            np.random.default_rng(74).normal(0, 0.01, (2, 20, 2)),
        )
    ]
    for sigma in (0.01, None):
        found = relative(
            CAMERAS[0], CAMERAS[0], *images, start=(0, 0, *angles), sigma=sigma
        )
        assert found.status == "no base"


LINE = np.linspace(-10, 10, 6)[:, None] * (1.0, 0.3)
GOOD = dict(
    camera_left=RELOR_CAMERA,
    camera_right=RELOR_CAMERA,
    left_points=RELOR[:, :2],
    right_points=RELOR[:, 2:],
)
TURNED = project(
    Camera(152.113),
    [0, 0, 0, 0.1, 0.2, 0.3],
    np.insert(RELOR[:, :2], 2, -152.113, axis=1),
)
TWICE = [0, 1, 2, 3] * 2
BAD = [
    ({"left_points": RELOR[:4, :2], "right_points": RELOR[:4, 2:]}, "five or more"),
    ({"left_points": RELOR[:5, :2]}, "pair up; got 5 and 6"),
    ({"right_points": RELOR[:, :2]}, "differ by a rotation only"),
    ({"right_points": TURNED}, "differ by a rotation only"),
    ({"left_points": LINE, "right_points": LINE - (9, 0)}, "lie on lines"),
    ({"left_points": 0 * LINE, "right_points": 0 * LINE + 1}, "not all at one place"),
    # Four points, each twice: they do not determine five unknowns
    (
        {"left_points": RELOR[TWICE, :2], "right_points": RELOR[TWICE, 2:]},
        "point 4 is given twice",
    ),
    ({"base": 0.0}, "base must not be 0"),
    ({"start": np.zeros(6)}, r"start must be \(by, bz, omega, phi, kappa\)"),
]


@pytest.mark.parametrize(("change", "message"), BAD)
def test_bad_input_is_refused_and_named(change, message):
    with pytest.raises(ValueError, match=message):
        relative(**(GOOD | change))


def test_condition_is_the_determinant_of_base_and_rays():
    rng = np.random.default_rng(81)
    base, angles = rng.normal(0, 1, 3), rng.uniform(-1, 1, 3)
    left, right = rng.normal(0, 1, (2, 4, 3))
    R = rotation.matrix(*angles).T
    rows = [np.stack([base, u, R @ w]) for u, w in zip(left, right, strict=True)]
    np.testing.assert_allclose(
        coplanarity.condition(base, R, left, right), np.linalg.det(rows), atol=1e-14
    )


def test_derivatives_of_the_condition_against_differences():
    """F is linear in each of them, but for the turns: their step must be small."""
    rng = np.random.default_rng(86)
    left, right = np.insert(rng.uniform(-4, 4, (2, 5, 2)), 2, -10, axis=2)
    base, R = np.array([1.0, 0.2, -0.1]), rotation.matrix(0.1, -0.2, 0.3).T
    by_left, by_right = coplanarity.by_image(base, R, left, right)
    by_base, by_rotation = coplanarity.by_orientation(base, left, right @ R.T)

    def difference(moved, h):
        F = [coplanarity.condition(*moved(s * h)) for s in (1, -1)]
        return (F[0] - F[1]) / (2 * h)

    for k, e in enumerate(np.eye(3)):
        if k < 2:
            numeric = difference(lambda h, e=e: (base, R, left + h * e, right), 1.0)
            np.testing.assert_allclose(by_left[:, k], numeric, atol=1e-11)
            numeric = difference(lambda h, e=e: (base, R, left, right + h * e), 1.0)
            np.testing.assert_allclose(by_right[:, k], numeric, atol=1e-11)
        numeric = difference(lambda h, e=e: (base + h * e, R, left, right), 1.0)
        np.testing.assert_allclose(by_base[:, k], numeric, atol=1e-11)
        numeric = difference(
            lambda h, e=e: (base, rotation.matrix(*(h * e)).T @ R, left, right), 1e-5
        )
        np.testing.assert_allclose(by_rotation[:, k], numeric, rtol=1e-7, atol=1e-7)
    # Omega turns about the X axis at any attitude
    numeric = difference(
        lambda h: (base, rotation.matrix(0.1 + h, -0.2, 0.3).T, left, right), 1e-5
    )
    np.testing.assert_allclose(by_rotation[:, 0], numeric, rtol=1e-7, atol=1e-7)


def test_foot_points_are_the_nearest_that_scipy_finds():
    rng = np.random.default_rng(82)
    left, right = np.insert(rng.uniform(-40, 40, (2, 5, 2)), 2, -100, axis=2)
    base, R = np.array([1.0, 0.2, -0.1]), rotation.matrix(0.1, -0.2, 0.3).T
    right[:, :2] = left[:, :2] * 0.9 - (20, 0) + rng.normal(0, 5, (5, 2))
    found = coplanarity.distances(base, R, left, right)
    for i in range(5):
        v = np.concatenate([found.left[i], found.right[i]])

        def misclosure(v, i=i):
            corrected = left[i] + [*v[:2], 0], right[i] + [*v[2:], 0]
            return coplanarity.condition(base, R, *(u[None] for u in corrected))[0]

        assert abs(misclosure(v)) < 1e-9
        assert np.linalg.norm(v) == pytest.approx(abs(found.distance[i]), rel=1e-12)
        peer = minimize(
            lambda v: v @ v,
            0.9 * v,
            constraints={"type": "eq", "fun": lambda v: misclosure(v) / 1e3},
            options={"ftol": 1e-12},
        )
        np.testing.assert_allclose(v, peer.x, atol=1e-3)
