"""The printed coefficients of (M 2.24) are no derivatives in four places."""

import numpy as np

from pgm_book.ch05 import printed_equations as as_printed
from pgm_lab import camera

F = 35.0


def test_moving_the_unknowns_gives_the_derivatives_of_the_camera():
    # Central differences: 1e-9 of rounding over the step, 1e-10 of the next order
    rng = np.random.default_rng(8)
    for _ in range(5):
        exterior = np.append(rng.normal(0, 100, 3) + (0, 0, 900), rng.normal(0, 0.3, 3))
        point = rng.normal(0, 80, 3)
        exact = camera.collinearity(camera.Camera(F), exterior, point, (0, 0))
        both = np.hstack([exact.exterior[:, 3:], exact.point])
        moved = as_printed.moved_by_each(F, exterior, point)
        np.testing.assert_allclose(moved, both, rtol=1e-6, atol=1e-8)


def test_printed_coefficients_fail_in_four_places_at_every_attitude():
    rng = np.random.default_rng(9)
    for _ in range(5):
        exterior = np.append(rng.normal(0, 100, 3) + (0, 0, 900), rng.normal(0, 0.5, 3))
        point = rng.normal(0, 80, 3)
        moved = as_printed.moved_by_each(F, exterior, point)
        off = as_printed.coefficients(F, exterior, point) / moved - 1
        wrong = np.argwhere(np.abs(off) > 1e-4)  # a misprint deviates by per cents
        assert [f"b{i + 1}{j + 1}" for i, j in wrong] == ["b13", "b22", "b23", "b26"]
