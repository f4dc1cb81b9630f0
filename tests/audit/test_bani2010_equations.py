"""Proofs of the verdicts on the equations of Bani 2010: (2.2) and appendix B, (1) to
(8), without its printed numbers."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import camera as cam
from pgm_lab import rotation
from pgm_lab.camera import Camera

from . import as_printed

F, CENTRE = 18.5, (0.2, -0.1)
CAMERA = Camera(F, *CENTRE)
EXTERIORS = np.array(
    [(0.2, -0.1, 40.0, 0.12, -0.2, 0.7), (9.0, 1.5, 42.0, -0.1, 0.25, -1.9)]
)
POINT = np.array([4.5, -2.0, 3.0])


@pytest.mark.parametrize("exterior", EXTERIORS)
def test_2_2_and_appendix_1_are_the_projection(exterior):
    # By the quotient written out, and by the point carried along the camera's axes
    r, ray = rotation.matrix(*exterior[3:]), POINT - exterior[:3]
    U, V, W = [sum(row * ray) for row in r]
    right, up, back = r
    geometric = np.array([ray @ right, ray @ up]) * F / -(ray @ back) + CENTRE
    close((CENTRE[0] - F * U / W, CENTRE[1] - F * V / W), geometric, rtol=1e-13)
    close(cam.project(CAMERA, exterior, POINT), geometric, rtol=0, atol=1e-13)


@pytest.mark.parametrize("exterior", EXTERIORS)
def test_appendix_4_takes_object_coordinates_and_no_image_coordinates(exterior):
    image = cam.project(CAMERA, exterior, POINT) - CENTRE
    (q, r, s), _ = as_printed.bani_4_and_5(F, exterior, POINT)
    close((-F * r / q, -F * s / q), image, rtol=1e-12)
    # "(XA, YA) photo coordinates and ZA the principal distance" does not give them back
    for z in (F, -F):
        (q, r, s), _ = as_printed.bani_4_and_5(F, exterior, (*image, z))
        assert np.linalg.norm(-F * np.array([r, s]) / q - image) > 1


@pytest.mark.parametrize("exterior", EXTERIORS)
def test_appendix_5_is_the_derivative_by_the_point_and_its_second_b24_is_b26(exterior):
    _, b = as_printed.bani_4_and_5(F, exterior, POINT)
    for k, move in enumerate(1e-4 * np.eye(3)):
        ahead, behind = (
            cam.project(CAMERA, exterior, POINT + s * move) for s in (1, -1)
        )
        printed = b[as_printed.ROW_X[3 + k]], b[as_printed.ROW_Y[3 + k]]
        close(printed, (ahead - behind) / 2e-4, rtol=1e-8)
    # The second b24 is the derivative of y by Z, and far from that of y by X
    by_X, _, by_Z = cam.collinearity(CAMERA, exterior, POINT, (0, 0)).point[1]
    assert b["b26"] == approx(by_Z, rel=1e-11)
    assert abs(b["b26"] / by_X - 1) > 0.5


def misclosure(point, observed):
    """L by (5a), (5b) and A by (5), for both photos."""
    L, A = [], []
    for exterior, measured in zip(EXTERIORS, observed):
        (q, r, s), b = as_printed.bani_4_and_5(F, exterior, point)
        L += [measured[0] - CENTRE[0] + F * r / q, measured[1] - CENTRE[1] + F * s / q]
        A += [[b[k] for k in row[3:]] for row in (as_printed.ROW_X, as_printed.ROW_Y)]
    return np.array(L), np.array(A)


NOISE = np.array([[0.003, -0.004], [-0.002, 0.005]])
OBSERVED = cam.project(CAMERA, EXTERIORS, POINT) + NOISE


def test_appendix_5a_and_5b_are_observed_minus_computed_image_coordinates():
    # Both in mm of the photo: no object coordinate is subtracted
    L, _ = misclosure(POINT, OBSERVED)
    close(L.reshape(2, 2), NOISE, atol=1e-12)
    moved = POINT + (1.0, -2.0, 3.0)
    L, _ = misclosure(moved, OBSERVED)
    v = cam.collinearity(CAMERA, EXTERIORS, moved, OBSERVED, wrt=()).v
    close(L, -v.ravel(), atol=1e-12)


@pytest.mark.parametrize(("steps", "converged"), [(1, False), (8, True)])
def test_appendix_6_repeated_gives_the_least_squares_point_and_then_7_its_residuals(
    steps, converged
):
    point = POINT + (0.8, -0.5, 1.2)
    for _ in range(steps):
        L, A = misclosure(point, OBSERVED)
        X = np.linalg.inv(A.T @ A) @ (A.T @ L)  # (6)
        V = A @ X - L  # (7)
        point = point + X

    def v(move=0):
        return cam.collinearity(CAMERA, EXTERIORS, point + move, OBSERVED, wrt=()).v

    assert np.allclose(V, v().ravel(), rtol=0, atol=1e-10) == converged
    # Converged, no neighbour does better
    near = [(v(1e-3 * s * e) ** 2).sum() for e in np.eye(3) for s in (1, -1)]
    assert (min(near) > (v() ** 2).sum()) == converged


def test_appendix_8_estimates_the_noise_with_the_redundancy_one():
    # Two photos, one point: r = 4 - 3 = 1. The mean of S0^2 over 4000 draws is sigma^2
    # to 5 standard deviations, sqrt(2 / 4000) each. A vector L beside the root, as
    # one of two scans of the page shows, would have no meaning
    rng = np.random.default_rng(4)
    sigma, n = 0.002, 4000
    _, A = misclosure(POINT, OBSERVED)
    L = rng.normal(0, sigma, (n, 4))
    V = L @ (np.linalg.pinv(A).T @ A.T) - L
    s0 = np.sqrt((V**2).sum(axis=1) / (4 - 3))
    assert np.mean(s0**2) == approx(sigma**2, rel=5 * np.sqrt(2 / n))
