"""Collinearity as lesson 5 writes it gives what the camera gives."""

import numpy as np
import pytest

from pgm_book.program import camera as program
from pgm_lab import camera

PHOTO = (10.0, 5.0, 100.0, 0.02, -0.01, 0.3)
POINTS = np.array([(20.0, 2, 4), (12, 9, 8), (3, 14, -6)])


def test_an_ideal_camera_projects_the_same():
    np.testing.assert_allclose(
        program.project(PHOTO, POINTS, 35.0),
        camera.project(camera.Camera(35.0), PHOTO, POINTS),
        atol=1e-12,
    )


def test_differences_find_the_derivatives_of_the_collinearity_equations():
    """Tolerance: steps of 1e-6 leave errors of 1e-9 of the largest derivative."""
    ideal = program.project(PHOTO, POINTS, 35.0)
    equations = camera.collinearity(camera.Camera(35.0), PHOTO, POINTS, ideal)
    J = program.derivatives(lambda e: program.project(e, POINTS, 35.0), PHOTO)
    theirs = equations.exterior.reshape(6, 6)
    np.testing.assert_allclose(J, theirs, atol=1e-8 * np.abs(theirs).max())


def test_a_point_behind_the_camera_is_refused():
    with pytest.raises(ValueError, match="point 1 of points does not lie in front"):
        program.project(PHOTO, [[10, 5, 0], [10, 5, 200]], 35.0)
