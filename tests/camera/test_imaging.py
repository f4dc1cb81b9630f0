"""The steps from object point to image; all derivatives together are in test_model."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pgm_lab import rotation
from pgm_lab.camera import imaging

EXTERIOR = np.array([120.0, -340.0, 900.0, 0.3, -0.4, 2.1])
POINT = np.array([310.0, -150.0, 45.0])


def test_ray_is_turned_as_scipy_turns_it():
    # First omega about x, then phi about the new y, kappa about the new z; M is R'
    turned = Rotation.from_euler("XYZ", EXTERIOR[3:]).inv()
    ray, by_point = imaging.ray(EXTERIOR, POINT)
    expected = turned.apply(POINT - EXTERIOR[:3])
    np.testing.assert_allclose(ray, expected, rtol=1e-13)
    np.testing.assert_allclose(by_point, rotation.matrix(*EXTERIOR[3:]), atol=1e-15)


def test_axes_of_the_angles_give_the_derivatives_of_the_rotation_matrix():
    ray, M = imaging.ray(EXTERIOR, POINT)
    axes = imaging.axes_of_angles(M, EXTERIOR[5])
    by_angles = rotation.derivatives(*EXTERIOR[3:]) @ (POINT - EXTERIOR[:3])
    # A turn about an axis a moves the ray by ray x a
    np.testing.assert_allclose(by_angles, np.cross(ray, axes.T), rtol=1e-12, atol=1e-10)


def test_perspective_has_the_derivatives_that_complex_step_gives():
    """A step of 1e-30 has no truncation and no cancellation."""
    ray = np.array([130.0, -75.0, -640.0])
    image, by_c, by_ray = imaging.perspective(35.0, ray)
    np.testing.assert_allclose(image, 35.0 * ray[:2] / 640.0, rtol=1e-15)

    def derivative(step):
        return imaging.perspective(35.0 + step[0], ray + step[1:])[0].imag / 1e-30

    expected = np.stack([derivative(1e-30j * unit) for unit in np.eye(4)], axis=-1)
    found = np.hstack([by_c, by_ray])
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-16)


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
