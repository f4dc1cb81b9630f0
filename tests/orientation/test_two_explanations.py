"""Two models of the photos of 2010 fit alike, and give two objects (case 5c)."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from pgm_lab import datasets, orientation, rotation
from pgm_lab.camera import Camera, collinearity, project

CAMERA = Camera(18.5558)


def with_the_lens(photo, exteriors, start):
    """Points (10, 3) adjusted together with x0, y0 and K1."""

    def v_of(x):
        interior = np.array([18.5558, *x[:3], 0, 0, 0, 0, 0, 0])
        points = x[3:].reshape(10, 3)
        return collinearity(interior, exteriors[:, None], points, photo, wrt=()).v

    first = np.concatenate([np.zeros(3), start.ravel()])
    tight = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14, "x_scale": "jac"}
    found = least_squares(lambda x: v_of(x).ravel(), first, **tight)
    return found.x[3:].reshape(10, 3)


@pytest.mark.slow
def test_the_two_objects_differ_by_more_than_their_errors():
    exteriors = datasets.bani2010_intersection()["exterior"]
    photo = datasets.bani2010().photo
    start = orientation.intersect(CAMERA, exteriors, photo).points
    M_left, M_right = rotation.matrix(*exteriors[:, 3:].T)
    base = (M_left @ (exteriors[1, :3] - exteriors[0, :3]))[0]
    relative = orientation.relative(CAMERA, CAMERA, *photo, base=base)
    assert np.isclose(relative.sigma0, 0.001837, atol=2e-6)
    lens = with_the_lens(photo, exteriors, start)
    fitted = orientation.absolute(relative.points, lens)
    off = np.sqrt(np.mean(fitted.residuals**2))
    assert 0.0006 < off < 0.0008 and np.ptp(lens[:, 0]).round(1) == 1.5
    # The errors of the image points alone leave about 0.0003, seldom more than 0.0005
    rng, chance = np.random.default_rng(4), []
    both = np.array([np.zeros(6), relative.exterior])
    perfect = project(CAMERA, both[:, None], relative.points)
    for _ in range(40):
        noisy = perfect + rng.normal(0, relative.sigma0, perfect.shape)
        again = orientation.relative(
            CAMERA, CAMERA, *noisy, base=base, start=relative.exterior[1:]
        )
        again = orientation.absolute(again.points, relative.points)
        chance.append(np.sqrt(np.mean(again.residuals**2)))
    assert 0.0002 < np.mean(chance) < 0.0004 and np.mean(chance > off) < 0.1
