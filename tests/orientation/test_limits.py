"""Where the geometry gives out: several solutions, mirrors, and none."""

import numpy as np
import pytest

from pgm_lab.camera import Camera
from pgm_lab.orientation import absolute, resect

CAMERA = Camera(50.0)


@pytest.mark.parametrize("better", [29, 31])
def test_a_similarity_is_mirrored_if_that_fits_thirty_times_better(better):
    # Heights h on the wrong side and errors e aside, which nothing explains: vᵀPv is
    # n (e^2 + (2 h)^2), and n e^2 of the mirror image
    x, y = np.mgrid[-1:1:8j, -1:1:8j].reshape(2, -1)
    rows = np.array([1, -1] * 4)
    h = 0.01 * np.kron(rows, [1, -1, 1, -1, -1, 1, -1, 1])
    e = 0.02 / np.sqrt(better - 1) * np.kron(rows, [1, 1, -1, -1, -1, -1, 1, 1])
    assert np.allclose([e @ h, e @ x, e @ y, h @ x, h @ y], 0)
    source, target = np.column_stack([x, y, h]), np.column_stack([x + e, y, -h])
    if better < 30:
        assert absolute(source, target).status == "converged"
    else:
        with pytest.raises(ValueError, match="mirror image of source"):
            absolute(source, target)


def test_three_rays_that_no_place_has_are_no_solution():
    # The middle one of three points nearly on a line is seen far aside of the others
    points = [[-10.0, 0, 0], [0, 1, 0], [10, 0, 0]]
    found = resect(CAMERA, [[0.0, 0], [30, 0], [1, 0]], points)
    assert found.status == "no solution" and len(found.solutions) == 0
    assert np.all(np.isnan(found.exterior))
