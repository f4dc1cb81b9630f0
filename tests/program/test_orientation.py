"""The few lines of lesson 5 against the library that does the same with care."""

import numpy as np
import pytest

from pgm_book.program.camera import project
from pgm_book.program.orientation import intersection, relative, resection
from pgm_lab import datasets, orientation, rotation
from pgm_lab.camera import Camera

POINTS = np.array([[0.0, 0, 0], [90, 0, 5], [0, 80, 9], [85, 70, 0], [40, 30, 2]])


def test_two_rays_that_meet_are_given_their_point_at_any_length():
    stations = np.array([[0.0, 0, 100], [60, 0, 100]])
    point = np.array([20.0, 7, 3])
    directions = (point - stations) * [[1e-150], [1e150]]
    assert np.allclose(intersection(stations, directions), point, atol=1e-9)


def test_no_point_near_it_has_a_smaller_sum_of_squared_distances():
    rng = np.random.default_rng(5)
    stations, d = rng.normal(0, 50, (5, 3)), rng.normal(0, 1, (5, 3))
    found = intersection(stations, d)

    def total(point):
        return np.sum(np.cross(point - stations, d) ** 2 / (d**2).sum(1)[:, None])

    moved = [found + step for step in (*0.1 * np.eye(3), *-0.1 * np.eye(3))]
    assert all(total(found) < total(other) for other in moved)


def test_points_of_2010_are_near_those_of_the_adjustment():
    bani, printed = datasets.bani2010(), datasets.bani2010_intersection()
    exteriors = printed["exterior"]
    rays = np.stack(
        [np.insert(p, 2, -18.5558, axis=1) @ rotation.matrix(*e[3:])
         for e, p in zip(exteriors, bani.photo)], axis=1,
    )  # fmt: skip
    found = [intersection(exteriors[:, :3], two) for two in rays]
    adjusted = orientation.intersect(Camera(18.5558), exteriors, bani.photo).points
    # Both are within the residuals of 51 um, which are 0.005 at the object
    assert np.allclose(found, adjusted, rtol=0, atol=0.005)


def test_parallel_rays_and_rays_that_go_nowhere_are_refused():
    stations = [[0.0, 0, 0], [1, 0, 0]]
    with pytest.raises(ValueError, match="parallel"):
        intersection(stations, [[0, 0, 1], [0, 0, 2]])
    with pytest.raises(ValueError, match="has no direction"):
        intersection(stations, [[0, 0, 1], [0, 0, 0]])


def test_the_loop_finds_the_photo_and_its_precision_as_resect_does():
    truth = np.array([40.0, 35, 120, 0.05, -0.03, 0.4])
    noise = np.random.default_rng(2).normal(0, 0.003, (5, 2))
    image = project(truth, POINTS, 35.0) + noise
    exterior, sd = resection([45, 30, 110, 0, 0, 0], image, POINTS, 35.0)
    other = orientation.resect(Camera(35.0), image, POINTS)
    assert np.allclose(exterior, other.exterior, rtol=0, atol=1e-6)
    assert np.allclose(sd, np.sqrt(np.diag(other.covariance)), rtol=1e-4)


def test_the_relative_orientation_is_that_of_the_library_but_for_weights():
    rng = np.random.default_rng(4)
    points = rng.uniform((-2, -2, -9), (4, 2, -6), (20, 3))
    right = np.array([1.0, 0.1, -0.15, 0.08, 0.2, -0.1])
    exact = [project(e, points, 35.0) for e in (np.zeros(6), right)]
    assert np.allclose(relative(*exact, 35.0), right, rtol=0, atol=1e-9)
    measured = np.array(exact) + rng.normal(0, 0.002, (2, 20, 2))
    other = orientation.relative(Camera(35.0), Camera(35.0), *measured, sigma=0.002)
    off = (relative(*measured, 35.0) - other.exterior)[1:] / other.sd[1:]
    assert np.abs(off).max() < 0.5
