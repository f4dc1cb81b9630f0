"""Resection against Dewitt's program, OpenCV, SciPy and simulations."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares
from scipy.stats import chi2

from pgm_lab import rotation, simulate
from pgm_lab.camera import Camera, collinearity, project
from pgm_lab.orientation import resect

# B. Dewitt, program resect (public domain): x, y mm; X, Y, Z of four and five targets.
FIVE = np.array(
    [
        [86.421, -83.977, 1268.1022, 1455.0274, -14.3939],
        [-100.916, 92.582, 732.1811, 545.3437, -14.7009],
        [-98.322, -89.161, 1454.5532, 731.6659, -14.3509],
        [78.812, 98.123, 545.2449, 1268.2324, -14.6639],
        [-8.641, 5.630, 1000.0, 1000.0, -14.4540],
    ]
)
FOUR = np.array(
    [
        [86.421, -83.977, 1268.102, 1455.027, 22.606],
        [-100.916, 92.582, 732.181, 545.344, 22.299],
        [-98.322, -89.161, 1454.553, 731.666, 22.649],
        [78.812, 98.123, 545.245, 1268.232, 22.336],
    ]
)
# What it prints: X, Y, Z; omega, phi, kappa in degrees; their standard deviations; the
# residuals; the "standard error of unit weight".
PRINTED = {
    5: (
        [1027.8700, 1044.1143, 611.1973],
        [-0.4109, 1.2108, 102.8003],
        [0.0124, 0.0125, 0.0045, 0.0009, 0.0009, 0.0004],
        [
            [0.0014, -0.0014],
            [0.0006, 0.0030],
            [0.0015, 0.0009],
            [-0.0030, 0.0001],
            [-0.0005, -0.0025],
        ],
        0.0018,
    ),
    4: (
        [1027.8571, 1044.1138, 648.1974],
        [-0.4109, 1.2101, 102.8003],
        [0.0134, 0.0134, 0.0042, 0.0009, 0.0009, 0.0004],
        [[0.0006, -0.0023], [-0.0001, 0.0024], [0.0021, 0.0003], [-0.0026, -0.0004]],
        0.0017,
    ),
}
LAST_DIGIT = 0.5000001e-4
CAMERAS = [
    Camera(152.916),
    Camera(35.0, 0.1, -0.2, K1=-8e-5, K2=1e-8, P1=1e-5, P2=-2e-5, b1=1e-4, b2=2e-4),
    Camera(35.0, 0.1, -0.2, K1=-8e-5, K2=1e-8, P1=1e-5, P2=-2e-5, lens="forward"),
]


def dewitt(n):
    data = {5: FIVE, 4: FOUR}[n]
    return resect(Camera(152.916), data[:, :2], data[:, 2:])


@pytest.mark.parametrize("n", [4, 5])
def test_dewitt_to_the_printed_digits(n):
    """Dewitt divides by observations, not redundancy: his deviations are too small."""
    place, angles, deviations, residuals, standard_error = PRINTED[n]
    found = dewitt(n)
    too_small = np.sqrt(found.redundancy / (2 * n))
    assert found.status == "converged" and found.redundancy == 2 * n - 6

    def printed(values, expected):
        np.testing.assert_allclose(values, expected, rtol=0, atol=LAST_DIGIT)

    printed(found.exterior[:3], place)
    printed(np.degrees(found.exterior[3:]), angles)
    printed(found.residuals, residuals)
    printed(found.sigma0 * too_small, standard_error)
    sd = np.sqrt(np.diag(found.covariance))
    printed(np.r_[sd[:3], np.degrees(sd[3:])] * too_small, deviations)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize(("n", "flat"), [(4, False), (4, True), (9, False), (9, True)])
def test_error_free_photo_gives_its_orientation_back(camera, n, flat):
    rng = np.random.default_rng(n + flat)
    for _ in range(5):
        exterior, points, image = simulate.control_photo(camera, n, rng, flat)
        found = resect(camera, image, points)
        # Rounding of 1e-16, times c / extent, times the weakness of four points
        np.testing.assert_allclose(found.exterior, exterior, rtol=0, atol=1e-8)
        assert found.sigma0 < 1e-12


@pytest.mark.parametrize("camera", CAMERAS)
def test_same_as_scipy_least_squares_on_the_projection(camera):
    rng = np.random.default_rng(5)
    exterior, points, image = simulate.control_photo(camera, 8, rng, sigma=0.01)
    found = resect(camera, image, points)

    def misfit(x):
        if camera.lens == "forward":
            return (project(camera, x, points) - image).ravel()
        # With the lens "backward" residuals are those of the corrected coordinates
        return collinearity(camera, x, points, image, ()).v.ravel()

    peer = least_squares(misfit, exterior, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    sd = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(peer.x - found.exterior) < 1e-4 * sd)
    Q = np.linalg.inv(peer.jac.T @ peer.jac) * 2 * peer.cost / 10
    np.testing.assert_allclose(
        found.covariance, Q, rtol=1e-4, atol=1e-4 * sd.min() ** 2
    )
    assert found.sigma0 == pytest.approx(np.sqrt(2 * peer.cost / 10), rel=1e-9)


FROM = (4, False), (6, False), pytest.param(10, True, marks=pytest.mark.slow)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "flat"), FROM)
def test_covariance_predicts_the_scatter(n, flat):
    """Pooled squared Mahalanobis distances against chi-square.

    With sigma known, 50 photos of 6 unknowns give chi-square with 300 degrees of
    freedom; the bounds are passed by chance once in a million.
    """
    rng = np.random.default_rng(10 * n + flat)
    total = 0.0
    for _ in range(50):
        exterior, points, image = simulate.control_photo(
            CAMERAS[0], n, rng, flat, sigma=0.002
        )
        found = resect(CAMERAS[0], image, points, sigma=0.002)
        Q = found.covariance
        e = found.exterior - exterior
        e[3:] = (e[3:] + np.pi) % (2 * np.pi) - np.pi
        total += e @ np.linalg.solve(Q, e)
    lower, upper = chi2.ppf([5e-7, 1 - 5e-7], 300)
    assert lower < total < upper


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(4, 12), flat=st.booleans())
def test_finds_the_photo_from_none_and_from_a_start_far_off(seed, n, flat):
    rng = np.random.default_rng(seed)
    exterior, points, image = simulate.control_photo(
        CAMERAS[0], n, rng, flat, sigma=1e-5
    )
    start = simulate.rough(exterior, rng, degrees=30, share=0.5)
    for found in (
        resect(CAMERAS[0], image, points),
        resect(CAMERAS[0], image, points, start=start),
    ):
        assert len(found.solutions) >= 1
        off = np.linalg.norm(found.solutions[:, :3] - exterior[:3], axis=1).min()
        assert off < 0.1


def test_order_and_frame_of_the_points_do_not_matter():
    rng = np.random.default_rng(7)
    exterior, points, image = simulate.control_photo(CAMERAS[1], 7, rng, sigma=0.01)
    found = resect(CAMERAS[1], image, points)
    order = rng.permutation(7)
    again = resect(CAMERAS[1], image[order], points[order])
    shifted = resect(CAMERAS[1], image, 1000 * points + [5e5, 9e6, 100])
    np.testing.assert_allclose(again.exterior, found.exterior, rtol=0, atol=1e-7)
    np.testing.assert_allclose(
        shifted.exterior[:3], 1000 * found.exterior[:3] + [5e5, 9e6, 100], atol=1e-3
    )
    assert shifted.sigma0 == pytest.approx(found.sigma0, rel=1e-6)
    assert again.sigma0 == pytest.approx(found.sigma0, rel=1e-9)


def test_quality_figures_of_the_adjustment():
    found = dewitt(5)
    assert found.redundancy_numbers.sum() == pytest.approx(4, abs=1e-9)
    v = found.residuals
    assert found.sigma0 == pytest.approx(np.sqrt((v**2).sum() / 4), rel=1e-12)
    expected = v / (found.sigma0 * np.sqrt(found.redundancy_numbers))
    np.testing.assert_allclose(found.standardized, expected, rtol=1e-6)
    known = resect(Camera(152.916), FIVE[:, :2], FIVE[:, 2:], sigma=0.002)
    expected = v / (0.002 * np.sqrt(found.redundancy_numbers))
    np.testing.assert_allclose(known.standardized, expected, rtol=1e-6)


def test_three_points_have_several_solutions_and_a_start_chooses():
    found = resect(Camera(152.916), FOUR[:3, :2], FOUR[:3, 2:])
    assert found.status == "several solutions" and len(found.solutions) == 2
    assert np.all(np.isnan(found.exterior))
    for solution in found.solutions:
        image = project(Camera(152.916), solution, FOUR[:3, 2:])
        np.testing.assert_allclose(image, FOUR[:3, :2], rtol=0, atol=1e-7)
        near = resect(
            Camera(152.916), FOUR[:3, :2], FOUR[:3, 2:], start=solution + 1e-3
        )
        np.testing.assert_allclose(near.exterior, solution, rtol=0, atol=1e-6)
        assert near.status == "several solutions" and np.isnan(near.sigma0)


def circle(n, outside):
    angle = np.linspace(0, 5.5, n) + 0.1 * np.sin(np.arange(n))
    points = 30 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    place = 30 * (1 + outside) * np.array([np.cos(0.7), np.sin(0.7)])
    exterior = np.array([*place, 100, 0.15, -0.2, 0.3])
    return exterior, points, project(Camera(50.0), exterior, points)


@pytest.mark.parametrize("outside", [0.0, 0.005])
def test_camera_over_the_circle_of_three_points_is_named(outside):
    exterior, points, image = circle(3, outside)
    for start in (None, exterior + 0.01):
        found = resect(Camera(50.0), image, points, start=start)
        assert found.status == "near the dangerous cylinder"
    # The warning is deserved: precision there is many times worse
    exterior, points, image = circle(3, 0.005)
    near = resect(Camera(50.0), image, points, start=exterior, sigma=0.002)
    exterior, points, image = circle(3, 0.2)
    off = resect(Camera(50.0), image, points, start=exterior, sigma=0.002)
    assert off.status == "several solutions"
    assert near.covariance[0, 0] > 1000 * off.covariance[0, 0]


def strip(image_scale=(1, 1), relief=60.0, n=12, seed=1):
    """An aerial photo over a relief: image points, mirrored or not, and ground."""
    rng = np.random.default_rng(seed)
    ground = np.c_[rng.uniform(-500, 500, (n, 2)), rng.uniform(0, relief, n)]
    image = project(Camera(150.0), (20, 30, 1000, 0.02, -0.03, 0.4), ground)
    return (image + rng.normal(0, 0.005, (n, 2))) * image_scale, ground


@pytest.mark.parametrize("n", [4, 12])
@pytest.mark.parametrize("image_scale", [(-1, 1), (1, -1)])
def test_a_mirrored_image_is_named_and_no_station_below_the_ground_is_given(
    image_scale, n
):
    camera = Camera(150.0)
    assert resect(camera, *strip(n=n, relief=200.0)).exterior[2] > 900
    with pytest.raises(ValueError, match="a mirror image.*times better"):
        resect(camera, *strip(image_scale, n=n, relief=200.0))


@pytest.mark.parametrize("seed", range(5))
def test_a_blunder_is_not_taken_for_a_mirror(seed):
    image, ground = strip(seed=seed, n=5)
    image[0] += np.random.default_rng(seed).uniform(-20, 20, 2)
    resect(Camera(150.0), image, ground)  # raises nothing


def test_points_on_a_line_are_named():
    points = np.linspace(0, 1, 6)[:, None] * [10, 20, 5]
    image = project(Camera(50.0), (5, 10, 80, 0, 0, 0), points)
    found = resect(Camera(50.0), image, points)
    assert found.status == "points on a line" and np.all(np.isnan(found.exterior))
    assert resect(Camera(50.0), image, 0 * points).status == "points on a line"


@pytest.mark.parametrize(
    ("sigma", "status", "solutions"),
    [(0.002, "converged", 1), (0.01, "several solutions", 2)],
)
def test_a_flat_target_far_away_is_ambiguous_only_within_the_noise(
    sigma, status, solutions
):
    """From afar a square looks the same when tilted to the other side."""
    square = [[-30, -30, 0], [30, -30, 0], [30, 30, 0], [-30, 30, 0], [5, 10, 0]]
    truth = np.array([0.0, -400, 1000, 0.35, 0, 0.2])
    image = project(Camera(35.0), truth, square)
    image += sigma * np.random.default_rng(0).normal(size=image.shape)
    found = resect(Camera(35.0), image, square)
    assert (found.status, len(found.solutions)) == (status, solutions)
    assert found.exterior[3] == pytest.approx(0.35, abs=0.02)


def test_a_camera_that_looks_away_is_no_solution():
    """Mirrored at the plane of the points it would fit too, with all rays reversed."""
    rng = np.random.default_rng(8)
    ground = np.column_stack([rng.uniform(-20, 20, (6, 2)), np.zeros(6)])
    truth = np.array([5.0, -3, 90, 0.1, 0.2, 0.3])
    image = project(Camera(50.0), truth, ground)
    M = -rotation.matrix(*truth[3:]) @ np.diag([1.0, 1, -1])
    mirrored = [5.0, -3, -90, *rotation.angles(M)]
    found = resect(Camera(50.0), image, ground, start=mirrored)
    assert found.status == "converged" and len(found.solutions) == 1
    np.testing.assert_allclose(found.exterior, truth, rtol=0, atol=1e-9)


def test_gimbal_lock_is_named_and_the_place_still_found():
    rng = np.random.default_rng(3)
    points = rng.uniform(-20, 20, (6, 3))
    exterior = np.array([-100.0, 0, 0, 0, -np.pi / 2, 0])
    image = project(Camera(50.0), exterior, points)
    found = resect(Camera(50.0), image, points)
    assert found.status == "gimbal lock"
    undetermined = np.isnan(np.diag(found.covariance))
    assert undetermined.tolist() == [False, False, False, True, False, True]
    np.testing.assert_allclose(found.exterior[:3], exterior[:3], rtol=0, atol=1e-9)
    M = rotation.matrix(*found.exterior[3:])
    np.testing.assert_allclose(M, rotation.matrix(*exterior[3:]), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("n", "m", "message"),
    [(2, 2, "2 points do not fix six unknowns"), (5, 4, "must be of the same points")],
)
def test_too_few_points_are_refused(n, m, message):
    with pytest.raises(ValueError, match=message):
        resect(Camera(152.916), FIVE[:n, :2], FIVE[:m, 2:])


def test_a_step_aside_and_a_tilt_look_alike_as_lesson_5_says():
    covariance = dewitt(5).covariance
    sd = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(sd, sd)
    assert np.allclose(
        (correlation[0, 4], correlation[1, 3]), (0.965, -0.965), atol=1e-3
    )
    assert np.allclose(sd[:3], (0.020, 0.020, 0.007), atol=5e-4)
    # The angles known: their rows and columns of the normal matrix go
    place = np.linalg.inv(np.linalg.inv(covariance)[:3, :3])
    assert np.allclose(np.sqrt(np.diag(place))[:2], 0.005, atol=3e-4)


@pytest.mark.parametrize("times", [2, 3])
def test_three_points_that_were_measured_again_are_three_points(times):
    """They have several solutions, and none of them is given as the exterior."""
    image, ground = (np.tile(one[:3], (times, 1)) for one in strip())
    with pytest.raises(ValueError, match="point 3 is given twice"):
        resect(Camera(150.0), image, ground)
    image += np.random.default_rng(times).normal(0, 0.005, image.shape)
    found = resect(Camera(150.0), image, ground)
    assert found.status == "several solutions" and np.all(np.isnan(found.exterior))
    assert len(found.solutions) > 1


@pytest.mark.parametrize("seed", range(2))
def test_points_that_leave_a_line_by_their_errors_are_on_it(seed):
    """A millimetre in a kilometre, which the image does not show."""
    rng = np.random.default_rng(seed)
    ground = np.linspace(-500, 500, 8)[:, None] * [1, 0.3, 0]
    ground += rng.normal(0, 0.001, ground.shape)
    image = project(Camera(150.0), (20, 30, 1000, 0.02, -0.03, 0.4), ground)
    image += rng.normal(0, 0.005, image.shape)
    assert resect(Camera(150.0), image, ground).status in (
        "points on a line",
        "weak geometry",
    )
