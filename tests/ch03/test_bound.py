"""The bound of Cramér and Rao, which the studies of lesson 3 compare with."""

import numpy as np

from pgm_book.ch03.studies.scene import cramer_rao
from pgm_lab import simulate


def windows(points, half=10):
    y, x = np.mgrid[-half : half + 1, -half : half + 1]
    return np.asarray(points)[:, None, None] + np.stack([x, y], axis=-1)


def test_the_bound_inverts_the_information_of_all_eight_parameters():
    """By differences of (2.10) itself: no formula of the gradients is shared."""
    sigma, gain = 1.5, 1.3
    turn = np.array([[1.1, 0.2], [-0.1, 0.9]])
    grid = windows([(50, 60)])[0]
    texture = simulate.texture(0.2, seed=9)

    def right(points):  # grey values where the right image is
        back = (points - (5, -3)) @ np.linalg.inv(turn).T
        return gain * simulate.grey_values(texture, back) + 7

    def left_minus(p):
        a0, a1, a2, b0, b1, b2, h0, h1 = p
        x, y = np.moveaxis(grid, -1, 0) - np.array([50, 60])[:, None, None]
        at = np.stack([a0 + a1 * x + a2 * y, b0 + b1 * x + b2 * y], axis=-1)
        return (h0 + h1 * right(at)).ravel()

    a0, b0 = turn @ (50, 60) + (5, -3)
    p = np.array([a0, *turn[0], b0, *turn[1], -7 / gain, 1 / gain])
    steps = 1e-4 * np.array([1, 0.1, 0.1, 1, 0.1, 0.1, 1, 0.1])
    J = np.transpose(
        [
            (left_minus(p + d) - left_minus(p - d)) / (2 * d.max())
            for d in np.diag(steps)
        ]
    )
    expected = np.linalg.inv(J.T @ J)[np.ix_([0, 3], [0, 3])]
    expected *= sigma**2 + (sigma / gain) ** 2
    found = cramer_rao(
        simulate.grey_values(texture, grid),
        simulate.grey_gradients(texture, grid),
        sigma,
        gain=gain,
        shape=turn,
    )
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_the_bound_counts_what_radiometric_parameters_cost():
    grid = windows(np.random.default_rng(2).uniform(20, 70, (20, 2)))
    grey = simulate.grey_values(simulate.texture(0.2, seed=4), grid)
    gradients = simulate.grey_gradients(simulate.texture(0.2, seed=4), grid)
    full = cramer_rao(grey, gradients, 1.0)
    known = cramer_rao(grey, gradients, 1.0, radiometric=False)
    assert np.linalg.eigvalsh(full - known).min() > -1e-15
    assert np.isinf(cramer_rao(np.ones((5, 5)), np.zeros((5, 5, 2)), 1.0)).all()
