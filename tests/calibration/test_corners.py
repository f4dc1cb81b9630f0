"""Corners by least squares, against a known truth and against OpenCV's."""

import cv2
import numpy as np
import pytest
import scipy

from pgm_lab.calibration import corners, refine

RIGHT = np.pi / 2


def corner(p, t1, t2, blur, sigma=0.0, size=27, rng=None):
    """A corner at p off the middle: 16 x 16 rays a pixel, blurred, then averaged."""
    n = 16
    at = (np.arange(size * n) + 0.5) / n - 0.5 - size // 2
    x, y = np.meshgrid(at - p[0], at - p[1])
    sides = [-np.sin(t) * x + np.cos(t) * y > 0 for t in (t1, t2)]
    fine = np.where(sides[0] == sides[1], 200.0, 50.0)
    fine = cv2.GaussianBlur(fine, None, blur * n)
    grey = fine.reshape(size, n, size, n).mean(axis=(1, 3))
    return grey + (sigma * rng.normal(size=grey.shape) if sigma else 0)


def test_two_edges_have_the_mean_of_a_bivariate_normal_distribution():
    x, y, r = 0.7, -1.3, 0.6
    orthant = scipy.stats.multivariate_normal([0, 0], [[1, r], [r, 1]]).cdf
    single = scipy.stats.norm.cdf
    expected = 4 * orthant([x, y]) - 2 * single(x) - 2 * single(y) + 1
    B, by, by_r = corners._two_edges(*np.array([[[x]], [[y]], [[r]]]))
    assert B[0, 0] == pytest.approx(expected, abs=2e-5)  # five nodes
    for values, h in (
        (by[0, 0, 0], (1e-5, 0, 0)),
        (by[0, 0, 1], (0, 1e-5, 0)),
        (by_r[0, 0], (0, 0, 1e-5)),
    ):
        ends = [
            corners._two_edges(
                *(np.array([[v + s * d]]) for v, d in zip((x, y, r), h))
            )[0]
            for s in (1, -1)
        ]
        assert values == pytest.approx((ends[0] - ends[1])[0, 0] / 2e-5, abs=1e-3)


def test_derivatives_of_the_grey_values_are_those_of_differences():
    x = np.array([[0.3, -0.4, 0.2, 1.9, 1.2, 100, 60, 0.002, -0.003]])
    axis = np.arange(-9, 10)
    offset = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    _, J = corners._edges(x, offset)
    for i, h in enumerate(1e-6 * np.maximum(1, np.abs(x[0]))):
        ends = [corners._edges(x + s * h * np.eye(9)[i], offset)[0] for s in (1, -1)]
        difference = (ends[0] - ends[1]) / (2 * h)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(J[..., i], difference, atol=1e-7 * scale)


@pytest.mark.parametrize("angle", [RIGHT, np.radians(55)])
def test_a_corner_without_noise_is_found_to_a_thousandth_of_a_pixel(angle):
    p = np.array([0.31, -0.22])
    found = refine(corner(p, 0.4, 0.4 + angle, 0.8), [(14, 12)], 9)
    assert found.status[0] == "measured"
    assert found.pixels[0] == pytest.approx(13 + p, abs=1e-3)
    assert found.blur[0] == pytest.approx(np.sqrt(0.8**2 + 1 / 12), abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("blur, angle", [(0.7, RIGHT), (1.5, np.radians(55))])
def test_errors_are_as_large_as_predicted_and_smaller_than_those_of_opencv(blur, angle):
    rng = np.random.default_rng(3)
    e, C, theirs = [], [], []
    for _ in range(80):
        p = rng.uniform(-0.5, 0.5, 2)
        t = rng.uniform(0, np.pi)
        grey = corner(p, t, t + angle, blur, 2.0, rng=rng)
        found = refine(grey, [(13, 13)], 9)
        e.append(found.pixels[0] - 13 - p)
        C.append(found.covariance[0])
        start = np.float32([[[13, 13]]])
        until = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-4)
        q = cv2.cornerSubPix(np.uint8(grey.round()), start, (6, 6), (-1, -1), until)
        theirs.append(q.ravel() - 13 - p)
    e = np.array(e)
    chi_square = np.einsum("ki,kij,kj->", e, np.linalg.inv(C), e) / 160
    assert 0.8 < chi_square < 1.25  # 160 degrees of freedom: sd 0.11
    assert np.sqrt(np.mean(e**2)) < 0.03
    assert np.sqrt(np.mean(e**2)) < 0.6 * np.sqrt(np.mean(np.square(theirs)))


def test_light_that_falls_off_moves_no_corner():
    p = np.array([0.2, 0.1])
    grey = corner(p, 0.3, 0.3 + RIGHT, 0.8)
    columns = np.arange(27) - 13
    found = refine(grey * (1 + 0.01 * columns), [(13, 13)], 9)
    assert found.pixels[0] == pytest.approx(13 + p, abs=2e-3)


def test_what_is_no_corner_is_said():
    edge = np.where(np.arange(27) > 13, 200.0, 50.0) + np.zeros((27, 1))
    rng = np.random.default_rng(1)
    noise = rng.normal(100, 20, (27, 27))
    good = corner((0, 0), 0.3, 0.3 + RIGHT, 0.8)
    for grey, near, radius, status in (
        (edge, (13, 13), 9, "no corner"),
        (noise, (13, 13), 9, "no corner"),
        (np.full((27, 27), 9.0), (13, 13), 9, "no corner"),
        (good, (3, 13), 9, "too near the border"),
        (good, (13, 13), 2, "too small"),
        (good, (8, 13), 8, "no corner"),
    ):
        found = refine(grey, [near], radius)
        assert found.status[0] == status
        assert np.isnan(found.pixels).all() and np.isnan(found.covariance).all()
    assert len(refine(good, np.zeros((0, 2)), 9.0).status) == 0
