"""Time of the bundle adjustment beside COLMAP's, in one run: `make benchmark`.

The same networks, start values, unknowns and convergence, one thread, all covariances.
pycolmap runs twice: with full Gauss-Newton steps, as ours, and with its own settings.
Its covariances of the points leave out the uncertainty of camera and photos, ours hold
it; ours come with redundancy numbers, too.
"""

import numpy as np
import pytest

from pgm_book.ch06.studies.network import ESTIMATE, network
from pgm_lab import bundle
from pgm_lab.camera import collinearity

colmap = pytest.importorskip("pgm_book.ch06.studies.colmap", exc_type=ImportError)

# photos, points, rays of a point, block, rounds
SIZES = {
    "9 photos x 50 points, all rays": (9, 50, None, False, 20),
    "50 photos x 2000 points x 8 rays": (50, 2000, 8, False, 5),
    "60 photos x 26,000 points x 3.4 rays": (60, 26_000, 3.4, True, 3),
}


@pytest.fixture(scope="module", params=SIZES)
def case(request):
    """A network, our result, rounds."""
    *size, rounds = SIZES[request.param]
    net = network(*size)
    return request.param, net, bundle.adjust(net, ESTIMATE), rounds


def test_adjust(case, benchmark):
    benchmark.group, net, result, rounds = case
    found = benchmark.pedantic(
        bundle.adjust, (net, ESTIMATE), rounds=rounds, warmup_rounds=1
    )
    assert found.status == "converged"
    benchmark.extra_info["iterations"] = found.iterations


@pytest.mark.parametrize("steps", ["gauss_newton", "default"])
def test_pycolmap(case, steps, benchmark):
    benchmark.group, net, ours, rounds = case

    def setup():
        return (colmap.reconstruction(net), steps == "gauss_newton"), {}

    found, summary, covariance = benchmark.pedantic(
        colmap.adjust, setup=setup, rounds=rounds, warmup_rounds=1
    )
    benchmark.extra_info["iterations"] = (
        summary.num_successful_steps + summary.num_unsuccessful_steps
    )
    # OPENCV stretches the distortion by b1, too: a thousandth of a standard deviation
    cost = 2 * summary.final_cost
    np.testing.assert_allclose(cost, ours.redundancy * ours.sigma0**2, rtol=2e-5)
    sigma = net.sigma[0, 0]
    theirs = covariance.get_other_params_cov(found.cameras[1].params)
    cofactor = ours.covariance_interior / ours.sigma0**2
    cofactor = colmap.parameters_covariance(ours.cameras[0], cofactor, sigma)
    sd = np.sqrt(np.diagonal(theirs))
    np.testing.assert_allclose(np.sqrt(np.diagonal(cofactor)), sd, rtol=1e-3)
    difference = found.cameras[1].params - colmap.parameters(ours.cameras[0], sigma)
    assert np.abs(difference / sd).max() < 0.005

    # their covariance of a point: the inverse of its own block of the normal equations,
    # in a network as large as the two fixed photos have it
    J = collinearity(
        ours.cameras[0],
        ours.exteriors[net.photo[net.point == 0]],
        ours.points[0],
        net.xy[net.point == 0],
        "point",
    ).point.reshape(-1, 3)
    theirs = np.array([found.point3D(i + 1).xyz for i in range(len(ours.points))])
    scale = np.std(theirs - theirs.mean(axis=0))
    scale /= np.std(ours.points - ours.points.mean(axis=0))
    np.testing.assert_allclose(
        np.linalg.eigvalsh(covariance.get_point_cov(1)),
        np.linalg.eigvalsh(scale**2 * sigma**2 * np.linalg.inv(J.T @ J)),
        rtol=1e-3,
    )
