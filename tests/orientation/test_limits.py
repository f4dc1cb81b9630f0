"""Where the geometry gives out: each limit of an orientation from both sides."""

import numpy as np
import pytest
from scipy.stats import chi2

from pgm_lab.camera import Camera, project
from pgm_lab.orientation import (
    _common,
    absolute,
    intersect,
    relative,
    resect,
    scale_factors,
)

C = 50.0
CAMERA = Camera(C)
ABOVE = np.array([0.0, 0, 100, 0, 0, 0])


# Rays that are parallel


@pytest.mark.parametrize("components", ["xyz", "xy", "xz"])
def test_two_rays_have_scale_factors_down_to_an_angle_of_1e_12(components):
    # The rays differ by the angle in the plane of two components, as do the stations
    left, normal = {"xz": ((30.0, 0, -40), (0, 1, 0))}.get(
        components, ((30.0, 40, 0), (0, 0, 1))
    )
    across = np.cross(left, normal)

    def factors(angle):
        photos = ABOVE, ABOVE + [*across, 0, 0, 0]
        rays = left, left + angle * across
        return scale_factors(*photos, *rays, components)

    assert factors(2e-12) == pytest.approx(-1 / 2e-12, rel=1e-2)
    with pytest.raises(ValueError, match="are parallel in the components"):
        factors(0.5e-12)


@pytest.mark.parametrize(
    ("angle", "status"), [(0.5e-8, "parallel rays"), (5e-7, "intersected")]
)
def test_two_rays_meet_down_to_half_a_millionth(angle, status):
    # Below, the point is too uncertain along its rays for the normal equations
    photos = [(0.0, 0, 100, 0, 0, 0), (60, 0, 100, 0, 0, 0)]
    found = intersect(CAMERA, photos, [[0.0, 3.0], [-C * angle, 3.0]])
    assert found.status == status
    if status == "intersected":
        assert found.points[2] == pytest.approx(100 - 60 / angle, rel=1e-6)


# Points on a line, or at one place


def along_a_line(width):
    """Six points whose width is so large a part of their length."""
    along = np.array([-5.0, -3, -1, 1, 3, 5])
    off = np.array([1.0, -1, 0, 0, -1, 1])  # no part of it along the line
    ratio = np.linalg.norm(along) / np.linalg.norm(off)
    return np.column_stack([along, width * ratio * off, 0 * along])


@pytest.mark.parametrize("moved", [0, 1])
def test_similarity_wants_points_a_millionth_off_the_line(moved):
    thin, wide = (along_a_line(width) for width in (0.8e-6, 1.2e-6))
    assert absolute(wide, 2 * wide + 7).scale == pytest.approx(2)
    pair = [wide, wide]
    pair[moved] = thin
    with pytest.raises(ValueError, match="all points lie on one line"):
        absolute(*pair)


@pytest.mark.parametrize("far", [0, 1])
def test_points_far_away_are_at_one_place_if_only_rounding_tells_them_apart(far):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    corners /= np.linalg.norm(corners - corners.mean(axis=0), 2)

    def fitted(extent):
        pair = [corners, corners]
        pair[far] = 1e6 + extent * 1e6 * corners
        return absolute(*pair).scale * 1e6 ** (1 - 2 * far)

    assert fitted(2e-12) == pytest.approx(2e-12 ** (2 * far - 1), rel=1e-3)
    with pytest.raises(ValueError, match="all points lie at one place"):
        fitted(0.5e-12)


def test_image_points_on_a_line_to_1e_9_are_named_as_such():
    def answer(width):
        left = along_a_line(width)[:, :2]
        right = left - (3.0, 0) + np.outer(left[:, 0] ** 2, (0.02, 0))
        try:
            return relative(CAMERA, CAMERA, left, right).status
        except ValueError as told:
            return str(told)

    assert "lie on lines" in answer(0.8e-9)
    assert "lie on lines" not in answer(1.2e-9)


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


@pytest.mark.parametrize("side", [-1, 1])
def test_solutions_a_ten_thousandth_apart_are_two(side):
    """Near the dangerous cylinder two of the four solutions of three points unite."""
    azimuth = np.array([0.1, 2.2, 4.1])
    points = 10 * np.column_stack([np.cos(azimuth), np.sin(azimuth), 0 * azimuth])
    radius = 10 * (1 + side * 5e-5)
    truth = (radius * np.cos(1), radius * np.sin(1), 40, 0, 0, 0)
    found = resect(CAMERA, project(CAMERA, truth, points), points).solutions
    apart = np.linalg.norm(found[:, None, :3] - found[:, :3], axis=-1) / 70
    assert len(found) == 4 and 1e-4 < apart[np.triu_indices(4, 1)].min() < 1.5e-4


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


def test_a_second_solution_is_found_though_the_first_fits_without_errors():
    """A square from afar, tilted to the other side, is right to some 1e-4 rad."""
    square = [[-30, -30, 0], [30, -30, 0], [30, 30, 0], [-30, 30, 0], [5, 10, 0]]
    truth = (0, -1000 * np.sin(0.35), 1000 * np.cos(0.35), 0.35, 0, 0.2)
    image = project(Camera(35.0), truth, square)
    found = resect(Camera(35.0), image, square, sigma=0.03)
    assert found.status == "several solutions" and len(found.solutions) == 2
    assert resect(Camera(35.0), image, square, sigma=0.003).status == "converged"


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
