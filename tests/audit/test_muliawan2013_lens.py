"""Proofs of the verdicts on Muliawan 2013, (2.46) to (2.55): the lens."""

import numpy as np
from numpy.testing import assert_allclose as close

from pgm_book.ch06 import published
from pgm_lab import bundle
from pgm_lab import camera as cam
from pgm_lab.camera import Camera, imaging

from . import muliawan2013_network as net

LENS = np.array([-2e-5, 3e-7, -2e-9, 2e-6, -5e-6, 3e-4, -2e-4])  # K1 ... b2
K = LENS[:3]
RNG = np.random.default_rng(46)
XY = RNG.uniform(-11, 11, (200, 2))  # mm, reduced to the principal point
R = np.linalg.norm(XY, axis=1)
DR = K[0] * R**3 + K[1] * R**5 + K[2] * R**7  # (2.47)


def lens(**given):
    """Displacement with the named parameters alone."""
    names = cam.PARAMETERS[3:]
    return imaging.distortion(np.array([given.get(n, 0.0) for n in names]), XY)


RADIAL = lens(K1=K[0], K2=K[1], K3=K[2])


def test_2_46_gives_both_axes_the_same_displacement():
    # The sum is the radial displacement (2.47); as dx and as dy it moves every point
    # along the diagonal, and further by sqrt(2)
    as_printed = np.stack([DR, DR], axis=-1)
    outward = np.sum(RADIAL * XY, axis=1) / R
    close(outward, DR, rtol=1e-12)
    length = np.linalg.norm(as_printed, axis=1)
    close(length, np.sqrt(2) * np.abs(DR), rtol=1e-12)
    assert np.abs(as_printed - RADIAL).max() > np.abs(RADIAL).max()


def test_2_47_to_2_50_are_the_radial_distortion_of_the_camera_model():
    close(R**2, XY[:, 0] ** 2 + XY[:, 1] ** 2, rtol=1e-14)
    close(XY * (DR / R)[:, None], RADIAL, rtol=1e-12)
    # (2.49): the three quotients are one
    close(RADIAL / XY, (DR / R)[:, None] * [1, 1], rtol=1e-10)


def test_2_48_takes_its_coordinates_from_2_55_and_not_from_2_46():
    # (2.46) needs r, so r cannot come from (2.46); its left sides are displacements
    camera = Camera(35.0, x0=0.2, y0=-0.1)
    measured = XY + (0.2, -0.1)
    close(cam.ideal(camera, measured), XY, atol=1e-14)
    assert np.abs(np.hypot(DR, DR) - R).min() > 0.1


def test_2_51_needs_the_opposite_k_of_2_89():
    # x - dx with K is x + dx with -K: the program adds what (2.51) subtracts, so the
    # sign of every K from Table 4.14 must be turned before (2.51) can use it
    K1, K2, K3 = K
    subtracted = XY - RADIAL
    added = cam.ideal(Camera(35.0, K1=-K1, K2=-K2, K3=-K3), XY)
    close(added, subtracted, rtol=0, atol=1e-14)
    same = cam.ideal(Camera(35.0, K1=K1, K2=K2, K3=K3), XY)
    close(same - subtracted, 2 * RADIAL, rtol=0, atol=1e-13)


def test_one_to_two_pixels_at_the_border_need_a_pixel_size():
    # The lens of the nine photos, correctly adjusted: 0.009 mm at the outermost
    # targets, one or two pixels of 9 or 4 micrometres; no pixel size is named
    interior = net.unpack(net.adjusted()[1])[0]
    reduced = net.PRINTED.xy - interior[1:3]
    r = np.linalg.norm(reduced, axis=1)
    K1, K2, K3 = interior[3:6]
    border = np.abs(K1 * r**3 + K2 * r**5 + K3 * r**7).max()
    assert 0.0085 < border < 0.0089


def test_2_5_1_positive_is_outwards_by_2_51_and_inwards_by_2_89():
    # The image of one point by a lens with K1 > 0 alone, and without the lens
    exterior, point = net.PRINTED.exteriors[0], net.PRINTED.object_points
    straight = np.hypot(*cam.project(Camera(35.0), exterior, point).T)
    # (2.51): true = measured - displacement, so measured = true + displacement
    outwards = cam.project(Camera(35.0, K1=2e-5, lens="forward"), exterior, point)
    assert np.all(np.hypot(*outwards.T) > straight)
    # (2.89) and the program add to what was measured: it lies inwards
    inwards = cam.project(Camera(35.0, K1=2e-5, lens="backward"), exterior, point)
    assert np.all(np.hypot(*inwards.T) < straight)
    # The nine photos, correctly adjusted, by the outermost targets: inwards
    K = net.unpack(net.adjusted()[1])[0][3:6]
    assert K[0] * 9.6**3 + K[1] * 9.6**5 + K[2] * 9.6**7 > 0.003


def test_2_5_1_k_are_correlated_among_themselves_and_hardly_with_c():
    def correlations(photos=None):
        found = bundle.adjust(published.network(photos))
        k = [found.names.index(name) for name in ("c", "K1", "K2", "K3")]
        return found.correlation[np.ix_(k, k)]

    every = correlations()
    among = every[[1, 1, 2], [2, 3, 3]]  # K1 K2, K1 K3, K2 K3
    close(among, (-0.92, 0.84, -0.98), rtol=0, atol=0.005)
    close(every[0, 1:], (0.26, -0.25, 0.25), rtol=0, atol=0.005)
    # It is the network: with three of the photos c and K3 are hardly told apart
    assert abs(correlations([1, 4, 7])[0, 3]) > 0.9


def test_2_52_is_the_decentring_distortion_of_the_camera_model():
    P1, P2 = LENS[3:5]
    x, y = XY.T
    dx = P1 * (R**2 + 2 * x**2) + 2 * P2 * x * y
    dy = P2 * (R**2 + 2 * y**2) + 2 * P1 * x * y
    close(np.stack([dx, dy], -1), lens(P1=P1, P2=P2), atol=1e-15)


def test_decentring_is_not_only_across_the_radius():
    # The text above (2.52) says perpendicular to the radius; along it (2.52) moves a
    # point up to three times as far
    d = lens(P1=LENS[3], P2=LENS[4])
    along = np.abs(np.sum(d * XY, axis=1) / R)
    across = np.abs(d[:, 0] * XY[:, 1] - d[:, 1] * XY[:, 0]) / R
    size = R**2 * np.hypot(*LENS[3:5])
    close((along / size).max(), 3, atol=0.01)
    close((across / size).max(), 1, atol=0.01)


def test_2_54_does_not_follow_from_2_53():
    # (2.53) moves a point along its radius, whatever the polynomial; (2.54) does not
    x, y = XY.T
    radial = XY / R[:, None] * (1e-3 + 2e-4 * x - 1e-4 * y + 3e-5 * x * y)[:, None]
    assert np.abs(radial[:, 0] * y - radial[:, 1] * x).max() < 1e-15
    affine = np.stack([3e-4 * x - 2e-4 * y, 0 * x], axis=-1)
    assert np.abs(affine[:, 0] * y - affine[:, 1] * x).max() > 1e-2


def test_2_54_is_affinity_and_shear_of_the_camera_model():
    b1, b2 = LENS[5:]
    x, y = XY.T
    close(np.stack([b1 * x + b2 * y, 0 * y], -1), lens(b1=b1, b2=b2), atol=1e-15)


def test_2_55_is_right_and_has_the_sign_that_2_89_lacks():
    # dx = dxp - (x / z) dc with z = -c: the image moves with the principal point and
    # outward with c. (2.89) has -1 and -x/c
    c = 35.0
    exterior, point = net.PRINTED.exteriors[0], net.PRINTED.object_points
    before = cam.project(Camera(c), exterior, point)
    moved = cam.project(Camera(c + 0.01, x0=0.02, y0=-0.03), exterior, point)
    x, y, z = *before.T, -c
    expected = np.stack([0.02 - x / z * 0.01, -0.03 - y / z * 0.01], axis=-1)
    close(moved - before, expected, rtol=0, atol=1e-12)
    by_2_89 = np.stack([-0.02 - x / c * 0.01, 0.03 - y / c * 0.01], axis=-1)
    close(by_2_89, -expected, rtol=0, atol=1e-12)
