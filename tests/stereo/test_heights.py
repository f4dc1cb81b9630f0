"""Space intersection: equal to the adjusted one and to scale factors; its errors."""

import numpy as np
import pytest
from scipy import stats

from pgm_lab import orientation, rotation, stereo
from pgm_lab.camera import Camera
from pgm_lab.stereo import DenseMatch, NormalPair

C, PIXEL, BASE = 24.0, 0.005, 400.0
ANGLES = (0.02, -0.03, 0.4)
SHAPE = (30, 40)


def normal_pair(angles=ANGLES):
    """Of the normal case turned as a whole, the base along the turned x axis."""
    R = rotation.matrix(*angles)
    one = np.array([100.0, 50, 1000])
    grey = np.zeros(SHAPE, np.float32)
    origin = np.array([(4.0, 1.5), (-5.5, 1.5)])
    stations = np.stack([one, one + BASE * R[0]])
    return NormalPair(grey, grey, R, stations, C, PIXEL, origin)


def dense(seed=1, sd=0.3):
    rng = np.random.default_rng(seed)
    d = rng.normal(0, 20, SHAPE).astype(np.float32)
    status = (rng.random(SHAPE) < 0.3).astype(np.uint8) * 3
    d[status > 0] = np.nan
    r = rng.uniform(0.8, 1, SHAPE).astype(np.float32)
    return DenseMatch(d, r, np.full(SHAPE, sd, np.float32), status)


def photo_coordinates(pair, cells, d):
    x = pair.origin[0, 0] + PIXEL * cells[:, 0]
    y = pair.origin[0, 1] - PIXEL * cells[:, 1]
    return np.stack([x, y], -1), np.stack([x - pair.parallax(d), y], -1)


def disparities(match, points):
    return match.disparity[points.cells[:, 1], points.cells[:, 0]].astype(float)


def test_no_point_is_without_coordinates_or_standard_deviations():
    pair, match = normal_pair(), dense()
    match.disparity[:, :9] = -4000  # behind the photos
    match.sd[:9] = np.nan
    points = stereo.intersect(pair, match)
    assert np.isfinite(np.hstack([points.xyz, points.sd])).all()
    np.testing.assert_array_equal(points.cells.min(axis=0), (9, 9))


def test_points_and_sigma_z_are_those_of_the_adjusted_intersection():
    # x' and x'' each with sigma: their difference, the disparity, with sqrt(2) sigma
    pair, sigma = normal_pair((0, 0, 0.4)), 0.2
    match = dense(sd=np.sqrt(2) * sigma)
    points = stereo.intersect(pair, match)
    exteriors = [(*station, 0, 0, 0.4) for station in pair.stations]
    xy = photo_coordinates(pair, points.cells, disparities(match, points))
    found = orientation.intersect(Camera(C), exteriors, xy, sigma=sigma * PIXEL)
    assert np.allclose(points.xyz, found.points, atol=1e-7)
    assert np.allclose(points.sd[:, 2] ** 2, found.covariance[:, 2, 2], rtol=1e-6)
    # As in textbooks: H / B times the GSD times the error in pixels
    H = pair.stations[0, 2] - points.xyz[:, 2]
    textbook = H / BASE * (PIXEL * H / C) * np.sqrt(2) * sigma
    assert np.allclose(points.sd[:, 2], textbook, rtol=1e-6)


def test_rays_that_meet_behind_the_photos_give_no_points():
    match = dense()
    matched = np.argwhere(match.status == 0)
    match.disparity[tuple(matched[0])] = -1e5
    points = stereo.intersect(normal_pair(), match)
    assert len(points.xyz) == len(matched) - 1
    assert np.isfinite(points.xyz).all()


def test_points_are_those_of_the_scale_factors_at_every_step():
    pair, match = normal_pair(), dense()
    points = stereo.intersect(pair, match)
    left, right = (
        np.column_stack([xy, np.full(len(xy), -C)])
        for xy in photo_coordinates(pair, points.cells, disparities(match, points))
    )
    exteriors = [(*station, *ANGLES) for station in pair.stations]
    factors = orientation.scale_factors(*exteriors, left, right)
    along = factors[:, :1] * left @ pair.rotation
    assert np.allclose(points.xyz, pair.stations[0] + along, atol=1e-7)
    part = stereo.intersect(pair, match, step=3)
    chosen = (points.cells % 3 == 0).all(-1)
    assert np.array_equal(points.xyz[chosen], part.xyz)


def test_the_standard_deviation_is_that_of_many_trials():
    pair, rng = normal_pair(), np.random.default_rng(5)
    one = DenseMatch(*np.array([[[2.0]], [[0.9]], [[0.3]]]), np.zeros((1, 1), np.uint8))
    small = NormalPair(np.zeros((1, 1)), np.zeros((1, 1)), pair.rotation,
                       pair.stations, C, PIXEL, pair.origin)  # fmt: skip
    points = stereo.intersect(small, one)
    n = 40_000
    zero, d = np.zeros(n), rng.normal(0, 0.3, n)
    trials = small.object_points(zero, zero, 2.0 + d).std(0)
    # From n trials it is good to sqrt(1 / 2n) = 0.4 %
    assert np.allclose(points.sd[0], trials, rtol=0.015)


def test_quality_by_hand_where_it_is_asked_for_and_known():
    found = stereo.quality([1.0, 2.5, np.nan, 3.0], [0.0, 2.0, 5.0, 3.0])
    assert found.n == 3 and found.completeness == 0.75
    assert found.mean == pytest.approx(0.5)
    assert found.rmse == pytest.approx(np.sqrt(1.25 / 3))
    assert found.nmad == pytest.approx(1.4826 * 0.5)
    truth = np.array([[0.0, np.nan], [0.0, 0.0]])
    found = stereo.quality(np.ones((2, 2)), truth, [[True, True], [False, True]])
    assert found.n == 2 and found.completeness == 1
    none = stereo.quality([np.nan, np.nan], [1.0, 2.0])
    assert none.n == 0 and none.completeness == 0 and np.isnan(none.rmse)


def test_nmad_is_the_standard_deviation_of_normal_errors_and_ignores_blunders():
    e = np.random.default_rng(1).normal(0.1, 0.3, 40_000)
    found = stereo.quality(e, np.zeros_like(e))
    assert found.nmad == pytest.approx(0.3, rel=0.02)
    share = np.diff(stats.norm(0.1, 0.3).cdf([-found.le95, found.le95]))
    assert share == pytest.approx(0.95, abs=0.005)
    e[:400] = 100
    spoilt = stereo.quality(e, np.zeros_like(e))
    assert spoilt.nmad == pytest.approx(0.3, rel=0.03) and spoilt.rmse > 9
