"""The thirty lines of lesson 6 give what the program gives."""

import numpy as np
import pytest

from pgm_book.ch06 import published
from pgm_book.program import bundle as program
from pgm_lab import bundle, datasets, simulate
from pgm_lab.camera import Camera, measured

DATA = datasets.muliawan2013()
RAYS = DATA.photo, DATA.point, DATA.xy, 0.001
START = np.array(DATA.interior), DATA.exteriors, DATA.object_points


def test_the_photos_of_2013_give_the_camera_and_the_covariance_of_the_program():
    camera, C, sigma0, points = program.adjust(*RAYS, *START)
    found = bundle.adjust(published.network())
    sd = found.sd_interior
    np.testing.assert_allclose((camera - found.interior) / sd, 0, atol=1e-3)
    np.testing.assert_allclose(np.sqrt(np.diag(C)), sd, rtol=1e-4)
    np.testing.assert_allclose(sigma0, found.sigma0, rtol=1e-6)
    assert (round(camera[0], 3), round(np.sqrt(C[0, 0]), 3)) == (34.581, 0.014)
    apart = np.linalg.norm(points[0] - points[-1])
    size = np.linalg.norm(found.points[0] - found.points[-1])
    again = np.linalg.norm(points[3] - points[20]) / apart
    assert again == pytest.approx(
        np.linalg.norm(found.points[3] - found.points[20]) / size, rel=1e-6
    )


def test_the_reduced_matrix_has_the_corner_of_the_whole_inverse():
    rng = np.random.default_rng(1)
    J = rng.normal(size=(40, 10))
    J[:, 4:] *= np.kron(np.arange(40)[:, None] % 2 == np.arange(2), np.ones(3))
    N = J.T @ J
    E = N[:4, 4:].reshape(4, 2, 3).swapaxes(0, 1)
    V = np.array([N[4:7, 4:7], N[7:, 7:]])
    whole = np.linalg.inv(N)[:4, :4]
    np.testing.assert_allclose(np.linalg.inv(program.reduced(N[:4, :4], E, V)), whole)


def test_the_lens_is_that_of_the_camera():
    camera = Camera(35, 0.1, -0.2, 3e-5, -4e-7, 2e-9, 4e-6, -7e-6, 3e-4, -2e-4)
    ideal = np.array([(3.0, 4.0), (-8.5, 2.0), (0.5, -6.0)])
    seen = measured(camera, ideal)
    numbers = [getattr(camera, n) for n in "c x0 y0 K1 K2 K3 P1 P2 b1 b2".split()]
    np.testing.assert_allclose(program.without_lens(seen, numbers), ideal, atol=1e-9)


def test_what_the_rays_do_not_determine_is_refused():
    few = np.isin(DATA.photo, (0, 1)) & (DATA.point < 4)
    two = DATA.photo[few], DATA.point[few], DATA.xy[few], 0.001
    with pytest.raises(ValueError, match="as many unknowns"):
        program.adjust(*two, START[0], START[1][:2], START[2][:4])


def test_a_network_without_noise_is_found_exactly():
    true = Camera(34.0, 0.05, -0.02, K1=2e-5)
    net = simulate.network(true, 6, 40, np.random.default_rng(3))
    numbers = np.array([34.5, 0, 0, 0, 0, 0, 0, 0, 0, 0.0])
    rays = net.photo, net.point, net.xy, 0.001
    camera, *_ = program.adjust(*rays, numbers, net.exteriors, net.points)
    np.testing.assert_allclose(camera[:4], (34.0, 0.05, -0.02, 2e-5), atol=0.01)
