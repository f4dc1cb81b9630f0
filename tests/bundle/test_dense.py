"""The textbook's adjustment with one large matrix, and the published network."""

import numpy as np
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal

from pgm_lab import bundle
from pgm_lab.bundle import dense
from tests.networks import real

NET = real()
STATE = NET.interior[0], NET.exteriors, NET.points, NET.photo, NET.point, NET.xy


def step(interior, exteriors, points, *image):
    """One step of (M 2.94): the corrections d1, d3, d2, and the cofactors."""
    v, A1, A3, A2 = dense.derivatives(interior, exteriors, points, *image)
    A = dense.design(A1, A3, A2, *image[:2], len(exteriors), len(points))
    N = dense.bordered(dense.normal_matrix(A, 0.001), dense.G(points))
    delta, Q = dense.solve(N, -A.T @ v.ravel() / 0.001**2)
    d1, d3, d2 = np.split(delta, [54, 64])
    return d1.reshape(9, 6)[:, dense.ANGLES_FIRST], d3, d2.reshape(50, 3), Q


def test_a_step_is_that_of_the_reduced_normal_equations():
    d1, d3, d2, _ = step(*STATE)
    found = bundle.adjust(NET, max_iterations=1, line_search=False)
    for ours, start, moved, sd in (
        (d1, NET.exteriors, found.exteriors, found.sd_exteriors),
        (d3, NET.interior[0], found.interior, found.sd_interior),
        (d2, NET.points, found.points, found.sd_points),
    ):
        assert np.abs((start + ours - moved) / sd).max() < 1e-5


def test_cofactors_are_those_of_the_reduced_normal_equations():
    found = bundle.adjust(NET, tolerance=1e-9)
    state = found.interior, found.exteriors, found.points
    sd = found.sigma0 * np.sqrt(np.diagonal(step(*state, *STATE[3:])[-1]))
    exteriors = sd[:54].reshape(9, 6)[:, dense.ANGLES_FIRST]
    close(exteriors, found.sd_exteriors, rtol=1e-7)
    close(sd[54:64], found.sd_interior, rtol=1e-7)
    close(sd[64:].reshape(50, 3), found.sd_points, rtol=1e-7)


def test_several_cameras_have_columns_of_their_own():
    _, A1, A3, A2 = dense.derivatives(*STATE)
    camera = np.arange(9) % 2
    A = dense.design(A1, A3, A2, NET.photo, NET.point, 9, 50, camera)
    one = dense.design(A1, A3, A2, NET.photo, NET.point, 9, 50)
    assert A.shape == (900, 54 + 20 + 150)
    both = A[:, 54:74].reshape(900, 2, 10)
    equal(both.sum(axis=1), one[:, 54:64])
    odd = np.repeat(camera[NET.photo] == 1, 2)
    assert not both[odd, 0].any() and not both[~odd, 1].any()
