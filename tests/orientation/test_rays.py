"""Scale factors: equal to the intersection for rays without errors, and what y parallax
does to the printed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import lstsq

from pgm_lab import rotation
from pgm_lab.camera import Camera, ideal, project
from pgm_lab.orientation import scale_factors

ANGLES = st.tuples(*[st.floats(-0.4, 0.4)] * 3)
LEFT = np.array([0, 0, 100, 0.02, -0.03, 0.1])
RIGHT = np.array([60, 5, 103, -0.01, 0.02, -0.2])


def rays(camera, exterior, points):
    free = ideal(camera, project(camera, exterior, points))
    return np.insert(free, 2, -camera.c, axis=-1)


@given(ANGLES, ANGLES, st.integers(0, 2**32 - 1))
def test_error_free_rays_give_the_point_and_all_forms_agree(left, right, seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform((0, 10, -20), (60, 40, 20), (5, 3))  # off the base in y
    left, right = (np.array([x, 0, 100, *a]) for x, a in ((0, left), (60, right)))
    camera = Camera(50.0)
    pair = [rays(camera, exterior, points) for exterior in (left, right)]
    found = scale_factors(left, right, *pair)
    for side, exterior in enumerate((left, right)):
        R = rotation.matrix(*exterior[3:]).T
        reached = exterior[:3] + found[:, side, None] * pair[side] @ R.T
        np.testing.assert_allclose(reached, points, atol=1e-9)
    for components in ("xy", "xz"):
        other = scale_factors(left, right, *pair, components=components)
        np.testing.assert_allclose(other, found, rtol=1e-9)


@pytest.mark.parametrize("components", ["xyz", "xy", "xz"])
def test_rays_with_errors_are_solved_as_scipy_solves_the_equations(components):
    rng = np.random.default_rng(2)
    points = rng.uniform((0, 10, 0), (60, 40, 20), (10, 3))
    pair = [rays(Camera(50.0), e, points) for e in (LEFT, RIGHT)]
    pair[1][:, :2] += rng.normal(0, 0.5, (10, 2))
    found = scale_factors(LEFT, RIGHT, *pair, components=components)
    used = ["xyz".index(axis) for axis in components]
    base = (RIGHT - LEFT)[used]
    for i in range(10):
        u1, u2 = (
            (rotation.matrix(*e[3:]).T @ ray[i])[used]
            for e, ray in zip((LEFT, RIGHT), pair, strict=True)
        )
        expected, *_ = lstsq(np.column_stack([u1, -u2]), base)
        np.testing.assert_allclose(found[i], expected, rtol=1e-8)


def test_printed_form_drifts_where_y_is_small_and_the_others_do_not():
    """A y parallax of 10 micrometres, seen 5 mm and 0.05 mm from the base."""
    left, right = np.array([0, 0, 100.0, 0, 0, 0]), np.array([60.0, 0, 100, 0, 0, 0])
    y = np.array([5.0, 0.05])
    pair = [np.array([[x, v, -50.0] for v in y]) for x in (10.0, -20.0)]
    pair[1][:, 1] += 0.01
    exact = 2.0
    errors = {
        components: np.abs(
            scale_factors(left, right, *pair, components=components)[:, 0] - exact
        )
        for components in ("xyz", "xy", "xz")
    }
    assert errors["xy"][0] < 0.01 * exact and errors["xy"][1] > 0.1 * exact
    assert errors["xz"].max() < 1e-12  # x and z have no error here
    assert errors["xyz"].max() < 1e-3 * exact


@pytest.mark.parametrize("y", [0.0, 1e-14])
def test_printed_form_is_refused_where_it_is_zero_by_zero(y):
    left, right = np.array([0, 0, 100.0, 0, 0, 0]), np.array([60.0, 0, 100, 0, 0, 0])
    pair = (
        np.array([[10, 3, -50], [10, y, -50]]),
        np.array([[-20, 3, -50], [-20, y, -50]]),
    )
    with pytest.raises(
        ValueError, match=r"rays\[1\] are parallel.*take components 'xyz'"
    ):
        scale_factors(left, right, *pair, components="xy")
    np.testing.assert_allclose(scale_factors(left, right, *pair), 2.0, rtol=1e-12)


def test_point_behind_the_camera_has_negative_factors():
    left, right = np.array([0, 0, 0, 0, 0, 0.0]), np.array([60.0, 0, 0, 0, 0, 0])
    found = scale_factors(left, right, (-10, 5, -50), (20, 5, -50))
    np.testing.assert_allclose(found, -2.0)
