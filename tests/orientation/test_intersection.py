"""Intersection against OpenCV, SciPy and simulations, and its named failures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.stats import chi2

from pgm_lab import rotation, simulate
from pgm_lab.camera import Camera, collinearity, project
from pgm_lab.orientation import intersect
from pgm_lab.orientation.rays import angle_between_rays, rays

PLAIN = Camera(50.0)
BACKWARD = Camera(50.0, 0.1, -0.2, K1=-1e-5, K2=1e-9, P1=1e-5, P2=-2e-5, b1=1e-4)
FORWARD = Camera(50.0, 0.1, -0.2, K1=-1e-5, K2=1e-9, P1=1e-5, P2=-2e-5, lens="forward")
PHOTOS = np.array(
    [
        [0.0, 0, 100, 0.02, -0.1, 0.3],
        [60, 0, 100, 0.02, 0.3, 0.1],
        [0, 60, 110, -0.3, 0.1, 1.1],
        [60, 60, 90, -0.3, 0.35, -2.0],
    ]
)


def scene(n, photos, camera, sigma=0.0, seed=1):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-20, 20, (n, 3))
    image = project(camera, photos[:, None], points)
    return points, image + sigma * rng.normal(size=image.shape)


EACH = [Camera(50.0), Camera(30.0, 0.5, K1=1e-5), Camera(80.0, P1=1e-5), PLAIN]


@pytest.mark.parametrize("camera", [PLAIN, BACKWARD, FORWARD, EACH])
@pytest.mark.parametrize("p", [2, 3, 4])
def test_error_free_rays_give_the_points_back(camera, p):
    cameras = EACH[:p] if camera is EACH else [camera] * p
    points = np.random.default_rng(1).uniform(-20, 20, (200, 3))
    image = np.array([project(c, e, points) for c, e in zip(cameras, PHOTOS)])
    found = intersect(cameras if camera is EACH else camera, PHOTOS[:p], image)
    assert np.all(found.status == "intersected")
    # 1e-15 of 100 units, over the angle of intersection
    np.testing.assert_allclose(found.points, points, rtol=0, atol=1e-11)
    assert np.all(found.redundancy == 2 * p - 3)
    assert np.abs(found.residuals).max() < 1e-12
    # The rays point from the cameras to the points
    d = points - PHOTOS[:p, None, :3]
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    directions = rays(cameras, PHOTOS[:p], image)
    np.testing.assert_allclose(directions, d, rtol=0, atol=1e-13)


@pytest.mark.parametrize("camera", [BACKWARD, FORWARD])
def test_same_as_scipy_least_squares(camera):
    _, image = scene(4, PHOTOS[:3], camera, sigma=0.01)
    found = intersect(camera, PHOTOS[:3], image)
    variance = (found.redundancy * found.sigma0**2).sum() / found.redundancy.sum()
    for i, X in enumerate(found.points):

        def misfit(x, i=i):
            return collinearity(camera, PHOTOS[:3], x, image[:, i], ()).v.ravel()

        peer = least_squares(misfit, X + 1, xtol=1e-15, ftol=1e-15, gtol=1e-15)
        sd = np.sqrt(np.diag(found.covariance[i]))
        assert np.all(np.abs(peer.x - X) < 1e-4 * sd)
        assert found.sigma0[i] == pytest.approx(np.sqrt(2 * peer.cost / 3), rel=1e-9)
        Q = np.linalg.inv(peer.jac.T @ peer.jac) * variance
        np.testing.assert_allclose(found.covariance[i], Q, rtol=0, atol=1e-5 * Q.max())


@pytest.mark.parametrize("p", [2, 4])
def test_covariance_predicts_the_scatter_and_sigma0_the_noise(p):
    """Pooled squared Mahalanobis distances against chi-square, 6000 degrees of freedom.

    Each bound is passed by chance once in a million.
    """
    points, image = scene(2000, PHOTOS[:p], BACKWARD, sigma=0.003)
    for found in (
        intersect(BACKWARD, PHOTOS[:p], image, sigma=0.003),
        intersect(BACKWARD, PHOTOS[:p], image),
    ):
        e = found.points - points
        total = np.einsum("ni,nij,nj->", e, np.linalg.inv(found.covariance), e)
        r = found.redundancy.sum()
        # Without sigma the pooled sigma0 adds its own chance, of r degrees of freedom
        spread = 5 * np.sqrt(2 * 6000 + 6000**2 * 2 / r)
        assert abs(total - 6000) < spread
        lower, upper = chi2.ppf([5e-7, 1 - 5e-7], r)
        assert lower < (found.redundancy * found.sigma0**2).sum() / 0.003**2 < upper


def test_residual_statistics():
    _, image = scene(50, PHOTOS, BACKWARD, sigma=0.003)
    image[2, 7] += [0.1, 0.0]  # a blunder
    found = intersect(BACKWARD, PHOTOS, image, sigma=0.003)
    w = np.abs(found.standardized)
    assert np.unravel_index(w.argmax(), w.shape) == (2, 7, 0)
    assert w.max() > 10
    ordinary = np.delete(found.standardized, 7, axis=1)
    assert 0.9 < ordinary.std() < 1.1  # 392 values, five standard deviations


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    p=st.integers(2, 4),
    scale=st.sampled_from([1e-3, 1, 1e4]),
)
def test_moves_turns_and_scales_with_object_space(seed, p, scale):
    rng = np.random.default_rng(seed)
    points, image = scene(5, PHOTOS[:p], PLAIN, sigma=0.01, seed=seed)
    found = intersect(PLAIN, PHOTOS[:p], image)
    (R,) = simulate.rotations(rng, 1)
    shift = scale * rng.uniform(-1e3, 1e3, 3)
    moved = np.empty((p, 6))
    moved[:, :3] = scale * PHOTOS[:p, :3] @ R.T + shift
    M = rotation.matrix(*PHOTOS[:p, 3:].T) @ R.T
    if np.any(rotation.is_gimbal(M, cosine=1e-3)):
        return
    moved[:, 3:] = rotation.angles(M)
    again = intersect(PLAIN, moved, image)
    expected = scale * found.points @ R.T + shift
    # 1e-6 of the standard deviation is where the iteration ends
    sd = scale * np.sqrt(np.trace(found.covariance, axis1=1, axis2=2)).max()
    np.testing.assert_allclose(again.points, expected, rtol=0, atol=1e-5 * sd)
    turned = scale**2 * R @ found.covariance @ R.T
    np.testing.assert_allclose(again.covariance, turned, rtol=0, atol=1e-4 * sd**2)
    np.testing.assert_allclose(again.sigma0, found.sigma0, rtol=1e-6, atol=1e-9)


def test_a_single_point_and_many_axes():
    _, image = scene(6, PHOTOS, PLAIN, sigma=0.01)
    whole = intersect(PLAIN, PHOTOS, image, sigma=0.01)
    single = intersect(PLAIN, PHOTOS, image[:, 2], sigma=0.01)
    assert single.points.shape == (3,) and single.status == "intersected"
    assert single.residuals.shape == (4, 2) and np.ndim(single.sigma0) == 0
    np.testing.assert_allclose(single.points, whole.points[2], rtol=0, atol=1e-12)
    np.testing.assert_allclose(single.covariance, whole.covariance[2], rtol=1e-9)
    grid = intersect(PLAIN, PHOTOS, image.reshape(4, 2, 3, 2), sigma=0.01)
    assert grid.points.shape == (2, 3, 3) and grid.residuals.shape == (4, 2, 3, 2)
    np.testing.assert_array_equal(grid.points.reshape(6, 3), whole.points)
    np.testing.assert_array_equal(grid.status.ravel(), whole.status)
    none = intersect(PLAIN, PHOTOS, image[:, :0])
    assert none.points.shape == (0, 3)


def test_unseen_rays_do_not_count_and_too_few_are_named():
    points, image = scene(4, PHOTOS, PLAIN, sigma=0.01)
    seen = np.array([[1, 1, 1, 0], [1, 1, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]], bool)
    image[~seen] = np.nan
    found = intersect(PLAIN, PHOTOS, image, seen=seen, sigma=0.01)
    expected = ["intersected", "intersected", "one ray", "one ray"]
    assert found.status.tolist() == expected
    assert found.redundancy.tolist() == [5, 1, -1, -3]
    only = intersect(PLAIN, PHOTOS[:2], image[:2, 1], sigma=0.01)
    np.testing.assert_allclose(found.points[1], only.points, rtol=0, atol=1e-9)
    assert np.all(np.isnan(found.points[2:])) and np.all(np.isnan(found.sigma0[2:]))
    assert np.array_equal(np.isnan(found.residuals[..., 0]), ~seen | [0, 0, 1, 1])


def test_pooled_variance_weights_each_point_by_its_redundancy():
    """Points in two, three and four photos: v'v of all over the sum of redundancies."""
    _, image = scene(60, PHOTOS, PLAIN, sigma=0.003)
    seen = np.arange(60) % 3 + 2 > np.arange(4)[:, None]
    found = intersect(PLAIN, PHOTOS, image, seen=seen)
    known = intersect(PLAIN, PHOTOS, image, seen=seen, sigma=1.0)
    variance = np.nansum(found.residuals**2) / found.redundancy.sum()
    expected = variance * known.covariance
    np.testing.assert_allclose(found.covariance, expected, rtol=1e-9)


SIDE = np.array([[0.0, 0, 100, 0, 0, 0], [60, 0, 100, 0, 0, 0]])
# Two cameras face each other, 60 apart, and both look straight ahead
FACING = np.array([[0.0, 0, 100, 0, 0, 0], [60, 0, -100, np.pi, 0, 0]])


@pytest.mark.parametrize(
    ("photos", "image", "status"),
    [
        (SIDE, [[5.0, 3.0], [5, 3]], "parallel rays"),
        # As good as parallel: rays at 1e-10 rad meet 6e11 units away
        (SIDE, [[5.0, 3.0], [5 - 5e-9, 3]], "parallel rays"),
        *((FACING, [[0.0, 0], [off, 0]], "parallel rays") for off in (0, 1e-9, 1e-7)),
        # The rays diverge: their lines meet behind both cameras
        (SIDE, [[-10.0, 0], [20, 0]], "behind a camera"),
    ],
)
def test_rays_that_do_not_meet_in_front_are_named(photos, image, status):
    found = intersect(PLAIN, photos, image)
    assert found.status == status
    assert np.all(np.isnan(found.points)) and np.all(np.isnan(found.covariance))
    # Not so the other points of the photos
    both = np.stack([image, [[5.0, 3.0], [-20, 3]]], axis=1)
    assert intersect(PLAIN, photos, both).status[0] == status


def perspective(photo, point, c=50.0):
    """Image of a point on the line through the perspective centre, before or behind."""
    U, V, W = rotation.matrix(*photo[3:]) @ (point - photo[:3])
    return -c * U / W, -c * V / W


@pytest.mark.parametrize("behind", [0, 1, 2])
def test_a_point_behind_one_of_its_cameras_is_named(behind):
    # Two photos from above, one from below that looks down as well, away from the point
    photos = PHOTOS[:3].copy()
    photos[behind, 2] *= -1
    point = np.array([5.0, 8.0, 3.0])
    image = np.array([perspective(photo, point) for photo in photos])
    found = intersect(PLAIN, photos, image)
    assert found.status == "behind a camera" and np.all(np.isnan(found.points))
    # A photo that does not show the point may look where it likes
    seen = np.arange(3) != behind
    found = intersect(PLAIN, photos, image, seen=seen)
    assert found.status == "intersected"
    np.testing.assert_allclose(found.points, point, rtol=0, atol=1e-11)


def test_rays_from_one_place_have_no_base():
    photos = PHOTOS[[0, 0, 1]].copy()
    photos[1, 3:] += 0.05
    _, image = scene(2, photos, PLAIN)
    seen = np.array([[1, 1], [1, 1], [0, 1]], bool)
    found = intersect(PLAIN, photos, image, seen=seen)
    assert found.status.tolist() == ["no base", "intersected"]
    with pytest.raises(ValueError, match="all photos were taken from one place"):
        intersect(PLAIN, photos[:2], image[:2])


IMAGE = np.zeros((2, 3, 2))


@pytest.mark.parametrize(
    ("cameras", "photos", "image", "options", "message"),
    [
        (PLAIN, PHOTOS[:1], IMAGE[:1], {}, "two photos or more"),
        (PLAIN, PHOTOS[:3], IMAGE, {}, r"shape \(3, n, 2\)"),
        (PLAIN, PHOTOS[[0, 1, 0]], IMAGE[[0, 1, 0]], {}, "photos 0 and 2 are the same"),
        ([PLAIN] * 3, PHOTOS[:2], IMAGE, {}, "3 cameras for 2 photos"),
        ([BACKWARD, FORWARD], PHOTOS[:2], IMAGE, {}, "same lens direction"),
        (PLAIN, PHOTOS[:2], IMAGE, {"seen": np.ones((2, 3))}, "seen must be True or"),
    ],
)
def test_bad_input_is_refused(cameras, photos, image, options, message):
    with pytest.raises(ValueError, match=message):
        intersect(cameras, photos, image, **options)


def test_angle_is_that_of_the_photos_that_show_the_point():
    turn = np.radians([0, 20, 35, 80])
    directions = np.stack([np.sin(turn), 0 * turn, -np.cos(turn)], axis=1)
    directions = np.repeat(directions[:, None], 4, axis=1)
    seen = np.array([[1, 1, 0, 1], [1, 1, 1, 1], [1, 0, 1, 0], [1, 0, 0, 0]], bool)
    found = np.degrees(angle_between_rays(directions, seen))
    np.testing.assert_allclose(found, (80, 20, 15, 20), rtol=0, atol=1e-9)
    # And so in an intersection: nothing is known of where the others look
    points, image = scene(2, PHOTOS, PLAIN)
    seen = np.array([[1, 1], [1, 0], [0, 1], [0, 0]], bool)
    found = intersect(PLAIN, PHOTOS, image, seen=seen)
    d = points - PHOTOS[:, None, :3]
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    expected = np.arccos([d[0, 0] @ d[1, 0], d[0, 1] @ d[2, 1]])
    np.testing.assert_allclose(found.angle, expected, rtol=1e-9)
