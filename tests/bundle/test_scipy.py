"""The network of Muliawan 2013 solved a second time, by scipy alone.

Everything here is written anew from the conventions of chapter 0: the collinearity
equations, their derivatives (by complex steps), the solution (a dense trust region in
scipy), the datum, the covariance. It shares no code with the bundle adjustment, its
camera, its images of points or its least squares; only the data and the result's names.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from scipy.optimize import least_squares

from pgm_lab import bundle, datasets
from tests.networks import real

PHOTOS, POINTS, INTERIOR = 9, 50, 10
CAMERA_AND_PHOTOS = INTERIOR + 6 * PHOTOS


def turn(omega, phi, kappa):
    """Rows of the matrix that turns object space into image space."""
    so, sp, sk = np.sin(omega), np.sin(phi), np.sin(kappa)
    co, cp, ck = np.cos(omega), np.cos(phi), np.cos(kappa)
    return (
        (cp * ck, co * sk + so * sp * ck, so * sk - co * sp * ck),
        (-cp * sk, co * ck - so * sp * sk, so * ck + co * sp * sk),
        (sp, -so * cp, co * cp),
    )


def misclosure(x, photo, point, xy):
    """Computed minus observed (450, 2) in mm, lens backward; x may be complex."""
    c, x0, y0, K1, K2, K3, P1, P2, b1, b2 = x[:INTERIOR]
    X0, Y0, Z0, omega, phi, kappa = (
        x[INTERIOR:CAMERA_AND_PHOTOS].reshape(-1, 6)[photo].T
    )
    X, Y, Z = x[CAMERA_AND_PHOTOS:].reshape(-1, 3)[point].T
    dX, dY, dZ = X - X0, Y - Y0, Z - Z0
    U, V, W = (
        row[0] * dX + row[1] * dY + row[2] * dZ for row in turn(omega, phi, kappa)
    )
    mx, my = xy[:, 0] - x0, xy[:, 1] - y0
    r2 = mx**2 + my**2
    radial = K1 * r2 + K2 * r2**2 + K3 * r2**3
    dx = mx * radial + P1 * (r2 + 2 * mx**2) + 2 * P2 * mx * my + b1 * mx + b2 * my
    dy = my * radial + P2 * (r2 + 2 * my**2) + 2 * P1 * mx * my
    return np.stack([-c * U / W - (mx + dx), -c * V / W - (my + dy)], axis=1)


def derivatives(function, x):
    """Jacobian by complex steps: exact to rounding, since nothing is subtracted."""
    step = 1e-30
    columns = []
    for i in range(len(x)):
        moved = x.astype(complex)
        moved[i] += 1j * step
        columns.append(function(moved).imag.ravel() / step)
    return np.transpose(columns)


def freedom(points):
    """What a free network may do to its points: (150, 7), columns of length 1."""
    X, Y, Z = (points - points.mean(axis=0)).T
    one, zero = np.ones(len(X)), np.zeros(len(X))
    moves = [
        [one, zero, zero],
        [zero, one, zero],
        [zero, zero, one],
        [zero, -Z, Y],
        [Z, zero, -X],
        [-Y, X, zero],
        [X, Y, Z],
    ]
    columns = np.array([np.transpose(move).ravel() for move in moves]).T
    return columns / np.linalg.norm(columns, axis=0)


@pytest.fixture(scope="module")
def own():
    """Solution, sigma0, residuals and covariance of the free network."""
    data = datasets.muliawan2013()
    start = np.concatenate(
        [data.interior, data.exteriors.ravel(), data.object_points.ravel()]
    )
    datum = freedom(data.object_points)

    def weighted(x):
        # the seven rows of the datum can be met exactly: they cost nothing, whatever
        # their weight, and only choose one of the equally good solutions
        moved = (x - start)[CAMERA_AND_PHOTOS:]
        v = misclosure(x, data.photo, data.point, data.xy) / data.sigma
        return np.concatenate([v.ravel(), datum.T @ moved])

    found = least_squares(
        weighted,
        start,
        jac=lambda x: derivatives(weighted, x),
        method="trf",
        x_scale="jac",
        ftol=1e-15,
        xtol=1e-15,
        gtol=1e-15,
        max_nfev=100,
    )
    v = found.fun[:900].reshape(-1, 2)
    A = found.jac[:900]
    sigma0 = np.sqrt(np.sum(v**2) / (900 - 214 + 7))
    points = found.x[CAMERA_AND_PHOTOS:].reshape(-1, 3)
    # covariance of the inner constraints on all points: the bordered normal equations,
    # with columns of one length
    scale = 1 / np.linalg.norm(A, axis=0)
    G = np.zeros((214, 7))
    G[CAMERA_AND_PHOTOS:] = freedom(points)
    C = np.linalg.qr(scale[:, None] * G)[0]
    N = np.block([[(A * scale).T @ (A * scale), C], [C.T, np.zeros((7, 7))]])
    Q = scale[:, None] * np.linalg.inv(N)[:214, :214] * scale
    return {
        "interior": found.x[:INTERIOR],
        "exteriors": found.x[INTERIOR:CAMERA_AND_PHOTOS].reshape(-1, 6),
        "points": points,
        "sigma0": sigma0,
        "residuals": v * data.sigma,
        "redundancy_numbers": 1 - np.sum((A @ Q) * A, axis=1).reshape(-1, 2),
        "sd": sigma0 * np.sqrt(np.diag(Q)),
        "datum": datum.T @ (found.x - start)[CAMERA_AND_PHOTOS:],
        "gradient": found.jac[:900].T @ found.fun[:900] * np.sqrt(np.diag(Q)),
    }


@pytest.fixture(scope="module")
def ours():
    return bundle.adjust(real())


def similarity(source, target):
    """Scale, rotation and shift that lay source (n, 3) on target: least squares."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    U, S, Vt = np.linalg.svd(b.T @ a)
    R = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    scale = np.sum(b * (a @ R.T)) / np.sum(a**2)
    return scale, R, target.mean(axis=0) - scale * R @ source.mean(axis=0)


def test_scipy_has_arrived_at_the_minimum(own):
    # where no unknown could gain more than a millionth of its sd, and in its datum
    assert np.abs(own["gradient"]).max() < 1e-6
    assert np.abs(own["datum"]).max() < 1e-8


def test_sigma0_and_redundancy_are_those_of_scipy(own, ours):
    assert ours.redundancy == 900 - 10 - 54 - 150 + 7
    close(ours.sigma0, own["sigma0"], rtol=1e-9)
    # v'Pv = 84.3987 with sigmas of 0.001 mm, after Tables 4.1 to 4.12
    close(693 * ours.sigma0**2, 84.39872310, rtol=1e-8)


def test_camera_and_its_standard_deviations_are_those_of_scipy(own, ours):
    sd = own["sd"][:INTERIOR]
    difference = ours.cameras[0].interior - own["interior"]
    assert np.abs(difference / sd).max() < 1e-4
    close(ours.sd_interior, sd, rtol=1e-4)


def test_residuals_and_redundancy_numbers_are_those_of_scipy(own, ours):
    # no datum in either: 1e-4 of a sigma of 0.001 mm
    close(ours.residuals, own["residuals"], atol=1e-7)
    close(ours.redundancy_numbers, own["redundancy_numbers"], atol=1e-6)
    standardized = own["residuals"] / (1e-3 * own["sigma0"])
    standardized = standardized / np.sqrt(own["redundancy_numbers"])
    close(ours.standardized, standardized, atol=1e-4)


def test_points_and_photos_are_those_of_scipy_after_a_similarity(own, ours):
    scale, R, shift = similarity(ours.points, own["points"])
    sd = own["sd"][CAMERA_AND_PHOTOS:].reshape(-1, 3)
    moved = scale * ours.points @ R.T + shift
    assert np.abs((moved - own["points"]) / sd).max() < 1e-4

    sd = own["sd"][INTERIOR:CAMERA_AND_PHOTOS].reshape(-1, 6)
    centres = scale * ours.exteriors[:, :3] @ R.T + shift
    assert np.abs((centres - own["exteriors"][:, :3]) / sd[:, :3]).max() < 1e-4
    M = [np.array(turn(*angles)) @ R.T for angles in ours.exteriors[:, 3:]]
    expected = [turn(*angles) for angles in own["exteriors"][:, 3:]]
    close(M, expected, atol=1e-4 * sd[:, 3:].min())


def test_standard_deviations_of_points_and_photos_are_those_of_scipy(own, ours):
    # both in the datum of inner constraints on all points, whose coordinates differ by
    # less than 1e-4 of the object between the two
    sd = own["sd"][INTERIOR:CAMERA_AND_PHOTOS].reshape(-1, 6)
    close(ours.sd_exteriors, sd, rtol=1e-4)
    sd = own["sd"][CAMERA_AND_PHOTOS:].reshape(-1, 3)
    close(ours.sd_points, sd, rtol=1e-4)
