"""A thousand small nonlinear adjustments: one stack against loops, `make benchmark`.

Points in the plane from five distances each. The tests assert that all find the same.
"""

import numpy as np
import pytest
from scipy.optimize import least_squares

from pgm_lab.adjustment import adjust

STATIONS = np.array([[0.0, 0.0], [90.0, 10.0], [70.0, 80.0], [-20.0, 60.0], [40, -30]])
GROUP = "1000 points from five distances each"


def distances(x):
    difference = x[..., None, :] - STATIONS
    distance = np.linalg.norm(difference, axis=-1)
    return distance, difference / distance[..., None]


@pytest.fixture(scope="module")
def problems():
    rng = np.random.default_rng(1)
    truth = rng.uniform(10, 60, (1000, 2))
    readings = distances(truth)[0] + rng.normal(scale=0.05, size=(1000, 5))
    return truth + rng.normal(scale=5, size=(1000, 2)), readings


@pytest.mark.benchmark(group=GROUP)
def test_a_stack_in_one_call(benchmark, problems):
    found = benchmark(adjust, distances, *problems)
    assert np.all(found.status == "converged")


@pytest.mark.benchmark(group=GROUP)
def test_a_loop_over_adjust(benchmark, problems):
    found = benchmark(lambda: [adjust(distances, s, r).x for s, r in zip(*problems)])
    expected = adjust(distances, *problems).x
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.benchmark(group=GROUP)
@pytest.mark.parametrize("method", ["lm", "trf"])
def test_a_loop_over_scipy_without_covariances(benchmark, problems, method):
    def one(start, reading):
        return least_squares(
            lambda x: distances(x)[0] - reading,
            start,
            jac=lambda x: distances(x)[1],
            method=method,
        ).x

    found = benchmark(lambda: [one(s, r) for s, r in zip(*problems)])
    expected = adjust(distances, *problems).x
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)  # scipy's ftol
