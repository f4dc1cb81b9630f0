"""Times of chapter 5 beside its peers, in one run: `make benchmark`.

Compare the medians within a group; the tests assert that both give the same, no times.
How often the orientations converge is in convergence.py.
"""

import cv2
import numpy as np
import pytest

from pgm_lab import rotation, simulate
from pgm_lab.camera import Camera, ideal, imaging, project
from pgm_lab.orientation import intersect, resect

CAMERA = Camera(50.0, 0.1, -0.2, K1=-1e-5, P1=1e-5)
PHOTOS = np.array([[0.0, 0, 100, 0.02, -0.1, 0.3], [60, 0, 100, 0.02, 0.3, 0.1]])
SIGMA = 0.003


def scene(n):
    rng = np.random.default_rng(1)
    image = project(CAMERA, PHOTOS[:, None], rng.uniform(-20, 20, (n, 3)))
    return image + SIGMA * rng.normal(size=image.shape)


def opencv_intersect(image):
    """Linear intersection by OpenCV: no covariance, no residuals, no status."""
    projections, pairs = [], []
    for x, measured in zip(PHOTOS, image, strict=True):
        M = np.diag([1.0, -1.0, -1.0]) @ rotation.matrix(*x[3:])
        projections.append(np.column_stack([M, -M @ x[:3]]))
        pairs.append(np.ascontiguousarray((ideal(CAMERA, measured) * [1, -1] / 50).T))
    X = cv2.triangulatePoints(*projections, *pairs)
    return (X[:3] / X[3]).T


def loop_intersect(image):
    """Gauss-Newton in a Python loop over the points, as a first program does it."""
    rays = ideal(CAMERA, image)
    starts = opencv_intersect(image)
    found = np.empty((image.shape[1], 3))
    covariance = np.empty((image.shape[1], 3, 3))
    interior = np.array([CAMERA.c, *np.zeros(9)])
    for i, X in enumerate(starts):
        for _ in range(5):
            v, _, blocks = imaging.misclosure(
                interior, PHOTOS, X, rays[:, i], "backward", ("point",)
            )
            A, v = blocks["point"].reshape(-1, 3), v.ravel()
            Q = np.linalg.inv(A.T @ A)
            step = -Q @ A.T @ v
            X = X + step
            if np.abs(step).max() < 1e-9:
                break
        found[i], covariance[i] = X, Q * SIGMA**2
    return found, covariance


@pytest.mark.benchmark(group="intersection of 100,000 points in two photos")
def test_intersect(benchmark):
    benchmark(intersect, CAMERA, PHOTOS, scene(100_000), sigma=SIGMA)


@pytest.mark.benchmark(group="intersection of 100,000 points in two photos")
def test_opencv_triangulate_points(benchmark):
    image = scene(100_000)
    found = benchmark(opencv_intersect, image)
    ours = intersect(CAMERA, PHOTOS, image, sigma=SIGMA)
    # Its linear solution is another estimate: within the noise, not to the last digit
    sd = np.sqrt(np.diagonal(ours.covariance, axis1=1, axis2=2))
    assert np.abs((found - ours.points) / sd).max() < 1


@pytest.mark.benchmark(group="intersection of 1000 points in two photos")
def test_intersect_fewer(benchmark):
    benchmark(intersect, CAMERA, PHOTOS, scene(1000), sigma=SIGMA)


@pytest.mark.benchmark(group="intersection of 1000 points in two photos")
def test_python_loop(benchmark):
    image = scene(1000)
    points, covariance = benchmark(loop_intersect, image)
    ours = intersect(CAMERA, PHOTOS, image, sigma=SIGMA)
    np.testing.assert_allclose(ours.points, points, rtol=0, atol=1e-6)
    np.testing.assert_allclose(ours.covariance, covariance, rtol=1e-4, atol=1e-9)


@pytest.mark.benchmark(group="intersection of one point in two photos")
def test_intersect_one(benchmark):
    benchmark(intersect, CAMERA, PHOTOS, scene(1)[:, 0], sigma=SIGMA)


@pytest.mark.benchmark(group="resection from ten points, no start")
def test_resect(benchmark):
    _, points, image = control(10)
    benchmark(resect, Camera(35.0), image, points)


@pytest.mark.benchmark(group="resection from ten points, no start")
def test_opencv_solve_pnp(benchmark):
    exterior, points, image = control(10)
    flip = np.diag([1.0, -1.0, -1.0])

    def run():
        flipped = image * [1, -1]
        _, rvec, tvec = cv2.solvePnP(points, flipped, np.diag([35.0, 35, 1]), None)
        M = flip @ cv2.Rodrigues(rvec)[0]
        return -(M.T @ flip @ tvec[:, 0])

    found = benchmark(run)
    np.testing.assert_allclose(found, exterior[:3], rtol=0, atol=0.2)


def control(n):
    rng = np.random.default_rng(3)
    return simulate.control_photo(Camera(35.0), n, rng, sigma=0.002)
