"""Each step from object point to image against its own derivative by complex step.

A complex step of 1e-30 has no truncation and no cancellation: the derivatives agree to
a few units in the last place, whatever their size."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pgm_lab import rotation
from pgm_lab.camera import imaging

EXTERIOR = np.array([120.0, -340.0, 900.0, 0.3, -0.4, 2.1])
POINT = np.array([310.0, -150.0, 45.0])
LENS = np.array([-8.3e-5, 4.1e-8, -6.7e-12, 2.9e-5, -1.7e-5, 3.1e-4, -2.3e-4])


def complex_step(function, x):
    """Derivatives (..., len(x)) of a function of one vector."""
    columns = [np.imag(function(x + 1e-30j * unit)) / 1e-30 for unit in np.eye(len(x))]
    return np.stack(columns, axis=-1)


def agree(analytic, function, x, columns=slice(None)):
    expected = complex_step(function, x)[..., columns]
    atol = 1e-14 * np.abs(expected).max()
    np.testing.assert_allclose(analytic, expected, rtol=1e-12, atol=atol)
    assert np.all(analytic.any(axis=-2)), "a column without any effect tests nothing"


def image(exterior, point):
    """The ideal image of a point, and its derivatives by the exterior orientation."""
    c, nothing = np.array([35.0, *np.zeros(9)]), np.zeros(2)
    v, _, by = imaging.misclosure(
        c, exterior, point, nothing, "backward", ("exterior",)
    )
    return v, by["exterior"]


@pytest.mark.parametrize("seed", range(5))
def test_ray_and_image_have_the_derivatives_that_complex_step_gives(seed):
    exterior = EXTERIOR + [0, 0, 0, *np.random.default_rng(seed).uniform(-3, 3, 3)]
    _, by_point = imaging.ray(exterior, POINT)
    agree(by_point, lambda x: imaging.ray(exterior, x)[0], POINT)
    agree(-by_point, lambda x: imaging.ray(x, POINT)[0], exterior, slice(3))
    by_exterior = image(exterior, POINT)[1]
    agree(by_exterior, lambda x: image(x, POINT)[0], exterior)


def test_ray_is_turned_as_scipy_turns_it():
    # First omega about x, then phi about the new y, kappa about the new z; M is R'
    turned = Rotation.from_euler("XYZ", EXTERIOR[3:]).inv()
    expected = turned.apply(POINT - EXTERIOR[:3])
    np.testing.assert_allclose(imaging.ray(EXTERIOR, POINT)[0], expected, rtol=1e-13)


def test_ray_agrees_with_the_rotation_matrix_and_its_derivatives():
    ray, by_point = imaging.ray(EXTERIOR, POINT)
    np.testing.assert_allclose(by_point, rotation.matrix(*EXTERIOR[3:]), atol=1e-15)
    ray_by_angles = rotation.derivatives(*EXTERIOR[3:]) @ (POINT - EXTERIOR[:3])
    axes = imaging.axes_of_angles(by_point, EXTERIOR[5])
    crossed = np.cross(ray, axes.T)  # a turn about an axis a moves the ray by ray x a
    np.testing.assert_allclose(ray_by_angles, crossed, rtol=1e-12, atol=1e-10)
    expected = imaging.perspective(35.0, ray)[2] @ ray_by_angles.T
    by_angles = image(EXTERIOR, POINT)[1][:, 3:]
    np.testing.assert_allclose(by_angles, expected, rtol=1e-12, atol=1e-12)


def test_perspective_has_the_derivatives_that_complex_step_gives():
    c, ray = np.array([35.0]), np.array([130.0, -75.0, -640.0])
    image, by_c, by_ray = imaging.perspective(c[0], ray)
    np.testing.assert_allclose(image, 35.0 * ray[:2] / 640.0, rtol=1e-15)
    agree(by_c, lambda x: imaging.perspective(x[0], ray)[0], c)
    agree(by_ray, lambda x: imaging.perspective(c[0], x)[0], ray)


def test_distortion_has_the_derivatives_that_complex_step_gives():
    image = np.array([9.0, -7.0])
    by_image = imaging.distortion_by_image(LENS, image)
    by_lens = imaging.distortion_by_lens(image)
    agree(by_image, lambda x: imaging.distortion(LENS, x), image)
    agree(by_lens, lambda x: imaging.distortion(x, image), LENS)


@pytest.mark.parametrize(
    ("name", "expected"),
    [  # each parameter alone, at (x, y) = (2, 1), r2 = 5, by hand
        ("K1", (10.0, 5.0)),
        ("K2", (50.0, 25.0)),
        ("K3", (250.0, 125.0)),
        ("P1", (5 + 8, 4)),
        ("P2", (4, 5 + 2)),
        ("b1", (2, 0)),
        ("b2", (1, 0)),
    ],
)
def test_each_parameter_of_the_lens_alone_at_a_point_by_hand(name, expected):
    names = ("K1", "K2", "K3", "P1", "P2", "b1", "b2")
    lens = np.array([1.0 if n == name else 0.0 for n in names])
    displacement = imaging.distortion(lens, np.array([2.0, 1.0]))
    np.testing.assert_allclose(displacement, expected, rtol=1e-15)
