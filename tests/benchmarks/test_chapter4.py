"""Times of chapter 4 beside scipy, in one run: `make benchmark`.

Compare the medians within a group; the tests assert that both give the same, no times.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pgm_lab import rotation

N = 1_000_000


@pytest.fixture(scope="module")
def angles():
    return np.random.default_rng(1).uniform(-1.5, 1.5, (N, 3))


@pytest.fixture(scope="module")
def matrices(angles):
    return rotation.matrix(*angles.T)


def close(found, expected):
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.benchmark(group="a million matrices from angles")
def test_matrix(benchmark, angles):
    benchmark(rotation.matrix, *angles.T)


@pytest.mark.benchmark(group="a million matrices from angles")
def test_scipy_matrix(benchmark, angles, matrices):
    found = benchmark(lambda: Rotation.from_euler("XYZ", angles).as_matrix())
    close(found.swapaxes(-1, -2), matrices)


@pytest.mark.benchmark(group="angles from a million matrices")
def test_angles(benchmark, angles, matrices):
    close(benchmark(rotation.angles, matrices), angles)


@pytest.mark.benchmark(group="angles from a million matrices")
def test_scipy_angles(benchmark, angles, matrices):
    turned = matrices.swapaxes(-1, -2)
    close(benchmark(lambda: Rotation.from_matrix(turned).as_euler("XYZ")), angles)


@pytest.mark.benchmark(group="quaternions from a million matrices")
def test_quaternions(benchmark, matrices):
    benchmark(rotation.to_quaternion, matrices)


@pytest.mark.benchmark(group="quaternions from a million matrices")
def test_scipy_quaternions(benchmark, matrices):
    turned = matrices.swapaxes(-1, -2)
    found = np.roll(benchmark(lambda: Rotation.from_matrix(turned).as_quat()), 1, -1)
    # q and -q are the same rotation
    close(np.abs(np.sum(found * rotation.to_quaternion(matrices), axis=-1)), 1.0)


@pytest.mark.benchmark(group="a million derivatives")
def test_derivatives(benchmark, angles):
    benchmark(rotation.derivatives, *angles.T)
