"""What a user hands over by mistake is refused with a message that names it."""

import numpy as np
import pytest

from pgm_lab import _validate, bundle, frames, lsm, ncc
from pgm_lab.camera import Camera
from tests.networks import real

GREY = np.random.default_rng(2).uniform(0, 255, (44, 48))
POINTS = [(20.0, 20.0), (26, 22)]
MASKED = np.ma.masked_array(np.ones((3, 2)), mask=[[0, 0], [0, 1], [0, 0]])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ([[1, 2], [3, np.nan]], r"xy\[1, 1\] is not a finite number; 1 value\(s\) are"),
        ([[1, 2], [3]], r"xy must be numbers; got \[\[1, 2\], \[3\]\]"),
        ([["1", "2"]], "xy must be numbers"),
        ([[1j, 2]], "xy must be numbers; got"),
        (MASKED, "xy has masked values"),
        ([(1, 2, 3)], r"xy must have shape \(..., 2\), one \(x, y\) in the last axis"),
    ],
)
def test_points_that_are_none_are_named(values, message):
    with pytest.raises(ValueError, match=message):
        _validate.points(values, 2, "xy")


@pytest.mark.parametrize(
    ("refused", "message"),
    [
        (lambda: _validate.number(True, "c"), "c must be a number; got True"),
        (lambda: _validate.number([1.0], "c"), "c must be one number; got shape"),
        (lambda: _validate.positive_number(0, "c", "mm"), r"positive \(mm\); got 0"),
        (lambda: _validate.not_negative(-1, "c", "mm"), "must not be negative"),
        (lambda: _validate.probability(1, "alpha"), "alpha must lie between 0 and 1"),
        (lambda: _validate.standard_deviation(0), "sigma must be positive, or None"),
        (lambda: _validate.whole(2.5, "n", 1), "n must be a whole number, at least 1"),
        (lambda: _validate.window(4, "size"), "size must be an odd number of pixels"),
        (lambda: _validate.smoothing(9), "smooth must be 0, or from 0.3 to 3 px"),
        (lambda: _validate.pair([1, 2, 3], "size", "mm"), r"one number or \(x, y\)"),
        (lambda: _validate.one_point(POINTS, 2, "p"), r"shape \(2,\), one only"),
        (lambda: _validate.point_list(POINTS, "p", 3), r"must have shape \(3, 2\)"),
        (lambda: _validate.indices([0, 9], 9, "ray"), "ray must be indices from 0 to"),
        (lambda: _validate.image_size((4.5, 3)), "must be .columns, rows., two whole"),
        (lambda: _validate.image(np.ones((3, 4, 3))), "Take one channel of a colour"),
        (lambda: _validate.window_shapes(np.eye(3), 2), r"shape must be \(\(a1, a2\)"),
        (lambda: _validate.flag(1, "back"), "back must be True or False; got 1"),
        (lambda: _validate.instance(3, Camera, "lens"), "lens must be a Camera; got 3"),
        (lambda: _validate.several("ab", "names"), "names must be a sequence of valu"),
        (lambda: _validate.mapping([1], "photos"), "photos must be a mapping"),
        (lambda: _validate.texts(["a"], "names", 2), "names must be 2 texts; got 1"),
        (lambda: _validate.text(" ", "crs"), "crs must be a text that is not empty"),
        (lambda: _validate.choice("b", "lens", ("a",)), "lens must be one of 'a'; got"),
        (lambda: frames.image_centre((4,)), r"From an array, it is image.shape\[1::-1"),
        (lambda: ncc.match(GREY, GREY, "x"), "points must be numbers"),
    ],
)
def test_each_kind_of_argument_says_what_it_must_be(refused, message):
    with pytest.raises(ValueError, match=message):
        refused()


def test_a_generator_is_a_sequence_too():
    assert _validate.several((n for n in "ab"), "names", str) == ["a", "b"]


@pytest.mark.parametrize("kind", [np.uint8, np.int64])
def test_a_small_integer_type_does_not_overflow(kind):
    small = lsm.match(GREY, GREY, POINTS, POINTS, kind(21))
    assert small.redundancy == 21**2 - 8
    found = ncc.match(GREY, GREY, POINTS, template=kind(11), search=kind(21))
    np.testing.assert_allclose(found.points, POINTS, atol=1e-9)


def test_a_network_keeps_no_array_of_the_caller():
    given = real()
    parts = [given.exteriors.copy(), given.points.copy(), given.xy.copy()]
    kept = bundle.Network(
        *(given.cameras, parts[0], parts[1], given.photo, given.point, parts[2]),
        given.sigma,
    )
    for part in parts:
        part += 1
    np.testing.assert_array_equal(kept.exteriors, given.exteriors)
    np.testing.assert_array_equal(kept.points, given.points)
    np.testing.assert_array_equal(kept.xy, given.xy)
