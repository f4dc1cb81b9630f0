"""Where the geometry gives out: each limit of an orientation from both sides."""

import numpy as np
import pytest
from scipy.stats import chi2

from pgm_lab.camera import Camera, project
from pgm_lab.orientation import (
    _common,
    absolute,
    relative,
    resect,
)

C = 50.0
CAMERA = Camera(C)
# Rays that are parallel


# Points on a line, or at one place


# Geometry that is weak


@pytest.mark.parametrize("off_the_line", [0.05, 0.08, 0.1, 0.2])
def test_a_photo_is_weak_if_other_unknowns_inflate_a_variance_a_million_times(
    off_the_line,
):
    # A photo without turns, the origin amid the points: its own frame is object space
    x = np.array([-10.0, -6, -2, 2, 6, 10])
    off = off_the_line * np.array([[1, -1, 1, -1, -1, 1], [1, 1, -1, -1, 1, -1]])
    points = np.column_stack([x, *off])
    points -= points.mean(axis=0)
    image = project(CAMERA, (0, 0, 80.0, 0, 0, 0), points)
    found = resect(CAMERA, image, points, sigma=1e-6)
    alone = 1 / np.diag(np.linalg.inv(found.covariance))  # the others known
    inflation = np.diag(found.covariance) / alone
    weak = inflation.max() > 1e6
    assert found.status == ("weak geometry" if weak else "converged")
    assert weak == (off_the_line < 0.09)


def test_a_similarity_is_weak_if_a_turn_is_uncertain_by_a_tenth():
    source = np.random.default_rng(5).normal(size=(6, 3)) * (3, 2, 1)
    one = absolute(source, source, sigma=1.0).local_covariance
    sd = np.sqrt(np.linalg.eigvalsh(one[1:4, 1:4])[-1])
    for turn, status in ((0.08, "converged"), (0.12, "weak geometry")):
        assert absolute(source, source, sigma=turn / sd).status == status


def stereo():
    """Twelve points that a photo at the origin and one beside it show."""
    points = np.random.default_rng(5).uniform(-1, 1, (12, 3)) - (0, 0, 3)
    right = np.array([1.0, 0.1, 0.05, 0, 0, 0])
    rays = points, points - right[:3]
    return right, *(-C * u / u[:, 2:] for u in rays)


def test_a_pair_is_weak_if_a_direction_is_uncertain_by_a_tenth():
    right, *rays = stereo()
    images = [u[:, :2] for u in rays]

    def with_errors(sigma):
        return relative(CAMERA, CAMERA, *images, start=right[1:], base=1, sigma=sigma)

    cofactor = with_errors(1e-3).covariance / 1e-6
    b = right[:3]
    across = np.eye(3) - np.outer(b, b) / (b @ b)
    of_base = np.trace(across @ cofactor[:3, :3] @ across) / (b @ b)
    sd = np.sqrt(max(np.trace(cofactor[3:, 3:]), of_base))  # without turns
    for direction, weak in ((0.08, False), (0.12, True)):
        assert (with_errors(direction / sd).status == "weak geometry") == weak


# Several solutions


def test_errors_of_known_size_exceed_their_limit_once_in_a_thousand():
    # Of two errors: P(v'v > q) = exp(-q / 2 sigma^2)
    limit = _common.largest_objective(0.0, 2, 0.3, 0.99)
    assert np.exp(-limit / (2 * 0.3**2)) == pytest.approx(1e-3)
    limit = _common.largest_objective(0.0, 7, 0.3, 0.99)
    assert chi2.sf(limit / 0.3**2, 7) == pytest.approx(1e-3)
    assert _common.largest_objective(99.0, 7, 0.3, 0.99) == 99


@pytest.mark.parametrize("seed", [33, 113])
def test_starts_that_end_a_millionth_apart_have_found_one_solution(seed):
    """Points near a line leave the place uncertain, and each start ends beside it."""
    rng = np.random.default_rng(seed)
    off = 10 ** rng.uniform(-2, 0)
    points = np.column_stack([rng.uniform(-20, 20, 7), off * rng.normal(size=(7, 2))])
    image = project(CAMERA, (3, 4, 80, 0.1, 0.2, 0.3), points)
    found = resect(CAMERA, image + 0.02 * rng.normal(size=(7, 2)), points).solutions
    apart = np.linalg.norm(found[:, None, :3] - found[:, :3], axis=-1) / 200
    assert np.all(apart[np.triu_indices(len(found), 1)] > 1e-5)


@pytest.mark.parametrize("better", [29, 31])
def test_a_similarity_is_mirrored_if_that_fits_thirty_times_better(better):
    # Heights h on the wrong side and errors e aside, which nothing explains: vᵀPv is
    # n (e^2 + (2 h)^2), and n e^2 of the mirror image
    x, y = np.mgrid[-1:1:8j, -1:1:8j].reshape(2, -1)
    rows = np.array([1, -1] * 4)
    h = 0.01 * np.kron(rows, [1, -1, 1, -1, -1, 1, -1, 1])
    e = 0.02 / np.sqrt(better - 1) * np.kron(rows, [1, 1, -1, -1, -1, -1, 1, 1])
    assert np.allclose([e @ h, e @ x, e @ y, h @ x, h @ y], 0)
    source, target = np.column_stack([x, y, h]), np.column_stack([x + e, y, -h])
    if better < 30:
        assert absolute(source, target).status == "converged"
    else:
        with pytest.raises(ValueError, match="mirror image of source"):
            absolute(source, target)


def test_three_rays_that_no_place_has_are_no_solution():
    # The middle one of three points nearly on a line is seen far aside of the others
    points = [[-10.0, 0, 0], [0, 1, 0], [10, 0, 0]]
    found = resect(CAMERA, [[0.0, 0], [30, 0], [1, 0]], points)
    assert found.status == "no solution" and len(found.solutions) == 0
    assert np.all(np.isnan(found.exterior))
