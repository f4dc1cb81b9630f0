"""The lens in its parts, and its curve with the standard deviation."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import bundle
from pgm_lab.bundle import lens
from pgm_lab.camera import PARAMETERS, Camera, imaging
from tests.stand_in import stand_in

LENS = Camera(30.0, 0.2, -0.1, 2e-5, -3e-7, 2e-9, 3e-6, -4e-6, 1e-4, -3e-4)


def result(cameras=(LENS,), estimate=PARAMETERS, seed=1, **other):
    """What `bundle.adjust` returns, as far as the lens is concerned."""
    rng = np.random.default_rng(seed)
    u = len(estimate) * len(cameras)
    unknowns = [
        bundle.Unknown("camera", i + 1, name)
        for i in range(len(cameras))
        for name in estimate
    ]
    root = 1e-3 * rng.normal(size=(u, u))
    covariance = root @ root.T
    whole = dict(
        cameras=cameras,
        unknowns=tuple(unknowns),
        covariance_interior=covariance,
        sd_interior=np.sqrt(np.diag(covariance)),
    )
    return stand_in(bundle.Bundle, **whole | other)


def displacement(camera, r, angle):
    at = r * np.array([np.cos(angle), np.sin(angle)])
    return imaging.distortion(camera.interior[3:], at)


@pytest.mark.parametrize("shape", [(2,), (50, 2), (3, 4, 2)])
def test_parts_make_the_displacement_of_the_camera(shape):
    image = np.random.default_rng(3).uniform(-11, 11, shape)
    whole = sum(part(LENS, image) for part in (lens.radial, lens.decentring))
    whole = whole + lens.affinity(LENS, image)
    expected = imaging.distortion(LENS.interior[3:], image)
    close(whole, expected, rtol=1e-12, atol=1e-15)


def test_radial_profile_is_what_the_lens_does_along_a_radius():
    camera = Camera(30.0, K1=2e-5, K2=-3e-7, K3=2e-9)
    r = np.linspace(0, 10, 7)
    found, _ = lens.profile(result((camera,)), r)
    expected = [displacement(camera, radius, 0.0)[0] for radius in r]
    close(found, expected, rtol=1e-13)


def test_decentring_profile_is_the_least_displacement_at_a_radius():
    camera = Camera(30.0, P1=3e-6, P2=-4e-6)
    around = np.linspace(0, 2 * np.pi, 20001)
    size = [np.hypot(*displacement(camera, 8.0, angle)) for angle in around]
    (found,), _ = lens.profile(result((camera,)), [8.0], "decentring")
    assert found == approx(min(size), rel=1e-6)
    assert 3 * found == approx(max(size), rel=1e-6)


@pytest.mark.parametrize("kind", ["radial", "decentring"])
def test_standard_deviation_of_the_profile_is_that_of_simulated_lenses(kind):
    sd = np.abs(LENS.interior) / 30 + 1e-6
    signs = np.resize([1, 1, -1], 10)  # the neglect of a correlation would be seen
    correlation = 0.1 * np.eye(10) + 0.9 * np.outer(signs, signs)
    adjusted = result(covariance_interior=np.outer(sd, sd) * correlation)
    r = np.array([3.0, 6.0, 9.0])
    _, sd = lens.profile(adjusted, r, kind)
    # Small errors, so that the profile is linear in them
    C = 1e-4 * adjusted.covariance_interior
    rng = np.random.default_rng(2)
    simulated = []
    for interior in rng.multivariate_normal(LENS.interior, C, 4000, tol=1e-6):
        other = result((Camera(*interior),))
        simulated.append(lens.profile(other, r, kind)[0])
    # 4000 samples know a standard deviation to 1.1 %: allow four times as much
    close(np.std(simulated, axis=0), 1e-2 * sd, rtol=0.045)


def test_what_was_not_estimated_is_free_of_error():
    adjusted = result(estimate=("c", "K1"))
    r = np.array([2.0, 5.0])
    _, sd = lens.profile(adjusted, r)
    close(sd, r**3 * adjusted.sd_interior[1])
    assert not lens.profile(adjusted, r, "decentring")[1].any()


def test_second_camera_has_its_own_lens_and_covariance():
    other = Camera(30.0, K1=-5e-5)
    adjusted = result((LENS, other), estimate=("c", "K1"))
    distortion, sd = lens.profile(adjusted, [2.0], camera=1)
    close(distortion, -5e-5 * 8)
    close(sd, 8 * adjusted.sd_interior[3])
