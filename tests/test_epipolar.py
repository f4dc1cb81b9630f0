"""Epipolar geometry: against OpenCV, coplanarity, true points, and at its limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pgm_lab import epipolar, orientation
from pgm_lab.camera import Camera, Photo

PLAIN = Camera(24.0, 0.05, -0.03)
LENS = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
FORWARD = replace(LENS, lens="forward")
SENSOR, PIXEL = (4288, 2848), 5.49e-3
LEFT = (-390.0, 2, 1020, 0.014, -0.019, 0.035)
RIGHT = (391.0, 5, 1024, -0.01, 0.016, -0.026)
GREY = np.zeros((8, 10), np.uint8)

angle = st.floats(-0.2, 0.2)
station = st.tuples(st.floats(-30, 30), st.floats(-30, 30), st.floats(-30, 30))
turns = st.tuples(angle, angle, st.floats(-3, 3))


def photo(exterior, camera=PLAIN, corner=(2100, 1400), pixel=PIXEL):
    return Photo(GREY, camera, exterior, pixel, SENSOR, corner)


def two(camera=PLAIN, other=None):
    return photo(LEFT, camera), photo(RIGHT, other or camera, (300, 1300))


def off(left, right, p, q):
    """Distances of right points from the lines of left ones, in pixels."""
    line, xy = epipolar.line(left, right, p), right.ideal(q)
    return (np.sum(line[..., :2] * xy, axis=-1) + line[..., 2]) / right.pixel_size


def ground(n=40, seed=1):
    return np.random.default_rng(seed).uniform((-150, -150, 0), (150, 150, 60), (n, 3))


@given(turns, turns, station)
def test_true_points_lie_in_plane_on_line_and_curve_with_lens(one, other, base):
    cameras = LENS, FORWARD
    X = np.array([(3.0, -8, -400), (-40, 20, -380)])
    left = photo((0, 0, 0, *one), cameras[0])
    right = photo((*np.add(base, (60, 0, 0)), *other), cameras[1])
    p, q = left.project(X), right.project(X)
    n = epipolar.plane(left, right, p)
    assert np.abs(np.sum(n * X, axis=1)).max() < 1e-9
    assert np.abs(off(left, right, p, q)).max() < 1e-6
    for k in (0, 1):
        by_height = epipolar.curve(left, right, p[k], [X[k, 2]])
        np.testing.assert_allclose(by_height, q[k : k + 1], atol=1e-6)


def test_the_lens_bends_the_curve_and_without_it_it_is_straight():
    heights = np.linspace(0, 60, 7)
    for camera, least, most in ((PLAIN, 0, 1e-7), (replace(LENS, K1=-1e-3), 1e-3, 9)):
        left, right = photo(LEFT, camera), photo(RIGHT, camera)
        pixel = left.project((150.0, 100, 20))
        x, y = epipolar.curve(left, right, pixel, heights).T
        bend = np.abs(np.polyval(np.polyfit(x, y, 1), x) - y).max()
        assert least <= bend < most


def test_relative_orientation_alone_gives_the_same_lines():
    left, right = two()
    X = ground(12)
    m = left.to_photo(left.project(X)), right.to_photo(right.project(X))
    found = orientation.relative(PLAIN, PLAIN, *m)
    model = photo(np.zeros(6)), replace(right, exterior=found.exterior)
    p, q = left.project(ground(9, 3)), right.project(ground(9, 3))
    a, b = epipolar.line(left, right, p), epipolar.line(*model, p)
    np.testing.assert_allclose(a * np.sign(np.sum(a * b, 1, keepdims=True)), b,
                               atol=1e-9)  # fmt: skip
    assert np.abs(off(*model, p, q)).max() < 1e-6


def test_epipole_is_the_image_of_the_other_station_and_all_lines_meet_there():
    # Forwards through a tunnel: the second station is seen by the first photo
    one = photo((0, 0, 1000, 0.1, 0.02, 0.3), LENS)
    other = photo((30, -20, 700, -0.05, 0.03, -0.2), LENS)
    place = one.project(other.exterior[:3])
    whole = Photo(np.zeros(SENSOR[::-1], np.uint8), LENS, one.exterior, PIXEL)
    seen, behind = epipolar.epipole(whole, other)
    assert seen.status == "inside the photo"
    np.testing.assert_allclose(seen.pixel, place + one.corner, atol=1e-6)
    # The first station lies behind the second photo
    assert behind.direction[2] > 0
    lines = epipolar.line(whole, other, [(2000.0, 900), (3000, 1700), (700, 200)])
    assert np.abs(lines @ (*behind.ideal, 1)).max() < 1e-9


def test_epipole_of_the_normal_case_lies_at_infinity_along_the_base():
    left, right = photo((0, 0, 100, 0, 0, 0)), photo((30, 0, 100, 0, 0, 0))
    for one, x in zip(epipolar.epipole(left, right), (1, -1)):
        assert one.status == "at infinity" and one.ideal is None and one.pixel is None
        np.testing.assert_allclose(one.direction, (x, 0, 0), atol=1e-15)


def along_the_base():
    """A good pixel of the left photo, and the epipole."""
    left, right = photo((0, 0, 1000, 0, 0, 0)), photo((0, 0, 700, 0.1, 0, 0))
    at = epipolar.epipole(left, right)[0].ideal + (PLAIN.x0, PLAIN.y0)
    return left, right, np.array([(0.0, 0.0), left.to_pixel(at)])


def parallel():
    """The right photo looks along Y, the plane of the base and this ray is Y = 0."""
    left = photo((0, 0, 0, 0, 0, 0), Camera(24.0))
    right = photo((10, 0, 0, np.pi / 2, 0, 0), Camera(24.0))
    return left, right, left.to_pixel((0.0, 0))


SAME = photo(LEFT), photo((*LEFT[:3], 0.1, 0, 0))
PIXEL_34 = (3.0, 4)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: epipolar.epipole(*SAME), "have the same station"),
        (lambda: epipolar.line(*SAME, PIXEL_34), "have the same station"),
        (lambda: epipolar.curve(*SAME, PIXEL_34, [0.0]), "have the same station"),
        (lambda: epipolar.plane(*along_the_base()), r"pixels\[1\] look along the base"),
        (lambda: epipolar.line(*parallel()), "parallel to the right photo"),
        (
            lambda: epipolar.curve(*two(), PIXEL_34, [0.0, 2000.0]),
            r"does not reach heights\[1\]",
        ),
    ],
)
def test_geometry_that_has_no_answer_is_refused_and_named(ask, message):
    with pytest.raises(ValueError, match=message):
        ask()
