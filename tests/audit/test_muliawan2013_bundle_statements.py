"""Proofs of the verdicts on statements of Muliawan 2013, chapters III, IV and V."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_book.ch06 import published
from pgm_lab import bundle, orientation, rotation
from pgm_lab.camera import Camera, project

from . import muliawan2013_network as net
from .muliawan2013_network import INTERIOR, OBJECT, PRINTED

EXTERIOR_DIFFERENCES = PRINTED.published_exterior_differences
POINT_DIFFERENCES = PRINTED.published_object_point_differences


@pytest.fixture(scope="module")
def solved():
    return net.adjusted()


def precision(photos, points=range(net.POINTS)):
    """Standard deviations (3,) of c, x0, y0 and the mean one of a point, in mm.

    Of the design with these photos (from 1) and points, at the precision that the whole
    network has.
    """
    result, x = net.adjusted()
    photos, points = np.asarray(photos) - 1, np.asarray(points)
    seen = np.isin(net.PHOTO, photos) & np.isin(net.POINT, points)
    exterior = (6 * photos[:, None] + np.arange(6)).ravel()
    places = (OBJECT.start + 3 * points[:, None] + np.arange(3)).ravel()
    unknowns = np.concatenate([exterior, np.arange(214)[INTERIOR], places])
    A = net.misclosure(x)[1][np.repeat(seen, 2)][:, unknowns] / net.SIGMA
    border = net.constraints(net.unpack(x)[2])[unknowns]
    Q = net.cofactor(A.T @ A, border)
    sd = result.sigma0 * np.sqrt(np.diag(Q))
    k = len(exterior)
    return sd[k : k + 3], np.sqrt(np.mean(sd[k + 10 :] ** 2))


# Chapter I


def test_1_4_interior_start_values_are_a_length_and_nine_zeros():
    assert PRINTED.interior[0] == 35 and not np.any(PRINTED.interior[1:])
    result, x = net.adjusted()
    t = np.abs(net.unpack(x)[0] / result.sd[INTERIOR])
    assert t[1] > 24 and t[2] > 6.5


def test_1_5_more_observations_than_unknowns_do_not_make_it_unique(solved):
    # 900 coordinates, 214 unknowns, and seven of these remain open
    _, A = net.misclosure(solved[1])
    assert A.shape == (900, 214)
    assert np.linalg.matrix_rank(A / np.linalg.norm(A, axis=0), tol=1e-10) == 207
    # As many as unknowns are enough, if they are independent: three points, one photo
    exterior, points = PRINTED.exteriors[2], PRINTED.object_points[[0, 9, 40]]
    camera = Camera(35.0)
    image = project(camera, exterior, points)
    found = orientation.resect(camera, image, points)
    off = np.abs(found.solutions[:, :3] - exterior[:3]).max(axis=1)
    assert off.min() < 1e-6 and len(found.solutions) <= 4


def test_1_5_missing_rays_are_no_problem_but_the_listing_counts_them(solved):
    whole = published.network()
    seen = np.random.default_rng(15).random(450) > 0.2
    rays = whole.photo[seen], whole.point[seen], whole.xy[seen]
    some = bundle.Network(whole.cameras, whole.exteriors, whole.points, *rays, 0.001)
    found = bundle.adjust(some)
    assert seen.sum() == 375 and found.status == "converged"
    assert found.redundancy == 2 * 375 - 214 + 7 == 543
    off = (found.interior - net.unpack(solved[1])[0]) / found.sd_interior
    assert np.abs(off).max() < 1.5
    # Its degrees of freedom would stay 2mn - (3n + 6m) = 696: sigma0 12 per cent small
    assert np.sqrt(543 / 696) == approx(0.88, abs=0.005)


# Chapter III: the material


def test_photo_coordinates_do_not_fit_on_the_sensor_of_a_canon_s90():
    # Its sensor is of type 1/1.7, about 7.4 x 5.6 mm, its lens has 6.0 to 22.5 mm. A
    # frame for the coordinates has 19 x 13 mm at least (24 x 16 mm would do), c 34.6 mm
    width, height = 2 * np.abs(PRINTED.xy).max(axis=0)
    assert width > 19 and height > 13
    assert width > 2.5 * 7.4 and height > 2.3 * 5.6
    c = net.unpack(net.adjusted()[1])[0][0]
    assert c > 1.5 * 22.5
    # In units of a 36 mm wide frame (28 to 105 mm) it would fit: the unit decides
    assert 28 < c < 105 and width < 36


def test_photos_are_convergent_and_from_five_places():
    stations, exteriors = PRINTED.exteriors[:, :3], PRINTED.exteriors
    near = np.linalg.norm(stations[:, None] - stations, axis=-1) < 10
    places = {tuple(np.flatnonzero(row) + 1) for row in near}
    assert places == {(1, 2), (3, 4, 5), (6,), (7,), (8, 9)}
    axes = np.array([-rotation.matrix(*e[3:])[2] for e in exteriors])
    convergence = np.degrees(np.arccos(np.clip(axes @ axes.T, -1, 1)))
    assert convergence.max() == approx(56, abs=1)
    # The targets lie in a plane, to 0.8 mm
    centred = PRINTED.object_points - PRINTED.object_points.mean(axis=0)
    spread = np.linalg.svd(centred, compute_uv=False) / np.sqrt(net.POINTS)
    assert spread[2] == approx(0.77, abs=0.01) and spread[1] > 60


def test_design_of_the_network_cannot_be_neglected():
    # Three photos from one place give no points; four places without a turn of the
    # camera leave c and the principal point 12 to 37 times less certain, the points 36
    camera, points = precision(range(1, 10))
    assert points == approx(0.0100, abs=2e-4)
    _, one_place = precision([3, 4, 5])
    assert one_place == approx(115, abs=5)  # nearly singular: fewer digits hold
    unrolled, unrolled_points = precision([1, 3, 6, 7])
    rolled, rolled_points = precision([2, 3, 6, 8])
    assert unrolled_points == approx(0.36, abs=0.02)
    assert rolled_points == approx(0.049, abs=0.002)
    assert np.all(unrolled > 10 * camera)
    assert np.all(unrolled[:2] > 1.5 * rolled[:2])


def test_object_of_appendix_a_has_half_a_metre_if_the_unit_is_mm(solved):
    # 0.54 x 0.20 m and flat to 3 mm, from 1.1 to 1.6 m away, if the unit is mm. A piece
    # of a bridge 20 m long needs a unit of 37 mm, and fits the photos as well (5.2 c)
    _, exteriors, points = net.unpack(solved[1])
    centred = points - points.mean(axis=0)
    size = np.ptp(centred @ np.linalg.svd(centred)[2].T, axis=0)
    close(size, (542, 205, 3.15), rtol=0.005)
    close(np.ptp(points, axis=0)[1:], (364, 428), atol=1)
    away = np.linalg.norm(exteriors[:, :3] - points.mean(axis=0), axis=1)
    assert 1080 < away.min() and away.max() < 1570


def centroid(image):
    rows, columns = np.indices(image.shape)
    return (image * columns).sum() / image.sum(), (image * rows).sum() / image.sum()


def test_centroid_finds_any_symmetric_target():
    # (2.15) on a square and on a cross: the centre, to 1e-12 px
    y, x = np.indices((41, 41)) - 20.0
    square = ((np.abs(x) <= 7) & (np.abs(y) <= 7)) * 200.0
    cross = ((np.abs(x) <= 2) | (np.abs(y) <= 2)) * 200.0
    for image in (square, cross):
        close(centroid(image), (20, 20), rtol=0, atol=1e-12)
    # A target without a point of symmetry is another matter
    half = square * (x + y < 0)
    assert np.abs(np.array(centroid(half)) - 20).min() > 1


# 4.3.1 and 5.1: the differences


def test_largest_difference_is_an_angle_in_radians_and_the_smallest_zero():
    stations, angles = np.split(np.abs(EXTERIOR_DIFFERENCES), 2, axis=1)
    assert np.abs(EXTERIOR_DIFFERENCES).argmax() == 6 * 1 + 5  # kappa of photo 2
    assert angles[1, 2] == approx(0.0079, abs=5e-5)
    assert np.degrees(angles[1, 2]) == approx(0.455, abs=0.001)
    # In the photo, at 10 mm from the centre, it is 0.08 mm
    assert 10 * angles[1, 2] == approx(0.08, abs=0.001)
    # In millimetres the largest is that of a station, which is rounding
    assert stations.max() == 5e-4
    assert stations.min() == np.abs(POINT_DIFFERENCES).min() == 0
    assert angles.min() == 0.00093


def test_means_of_the_differences_mix_signs_and_units(solved):
    assert EXTERIOR_DIFFERENCES.mean() == approx(0.000277, abs=1e-6)
    angles = np.abs(EXTERIOR_DIFFERENCES[:, 3:]).mean()
    assert angles == approx(0.0041, abs=1e-4)
    assert angles > 10 * EXTERIOR_DIFFERENCES.mean()
    assert POINT_DIFFERENCES.mean() == approx(1.59e-5, abs=0.01e-5)
    assert np.abs(POINT_DIFFERENCES).mean() == approx(1.2e-4, abs=0.01e-4)
    assert np.abs(POINT_DIFFERENCES).max() == approx(0.0005, abs=2e-6)
    moved = np.abs(net.unpack(solved[1])[2] - PRINTED.object_points)
    assert moved.mean() == approx(0.0027, abs=5e-5)
    assert moved.max() == approx(0.0103, abs=2e-4)


def test_plots_of_right_and_wrong_points_are_the_same(solved):
    points = net.unpack(solved[1])[2]
    size = np.ptp(points, axis=0).max()
    moved = np.linalg.norm(points - PRINTED.published_object_points, axis=1).max()
    assert 100 * moved / size < 0.004
    wrong = net.misclosure(net.PUBLISHED)[0]
    assert net.rms(net.PUBLISHED) > 900 * net.rms(solved[1])
    assert np.abs(wrong).max() == approx(4.92, abs=0.01)


# 4.3.2 and chapter V


def test_matrices_of_any_size_do_not_fit_into_a_computer():
    # P of the listing is full, 2mn x 2mn. Nine photos: 6.5 MB. A hundred photos of a
    # thousand points: 320 GB, for 200 000 numbers that are not zero
    def gigabytes(photos, points):
        return 8 * (2 * photos * points) ** 2 / 1e9

    assert gigabytes(9, 50) == approx(0.0065, abs=1e-4)
    assert gigabytes(100, 1000) == approx(320)


def test_5_2_a_start_values_from_the_photo_coordinates_alone(solved):
    # Relative orientation of photos 3 and 8, then resection of all nine on its model;
    # c = 35 mm and no lens. The adjustment ends where that of Tables 4.1 to 4.3 ends
    xy, camera = PRINTED.xy.reshape(9, 50, 2), Camera(35.0)
    model = orientation.relative(camera, camera, xy[2], xy[7], base=-1.0)
    assert model.status == "converged" and model.sigma0 < 0.0005
    found = [orientation.resect(camera, photo, model.points) for photo in xy]
    assert all(one.status == "converged" for one in found)
    exteriors = np.array([one.exterior for one in found])
    result, x = net.adjust(net.pack(PRINTED.interior, exteriors, model.points))
    assert result.status == "converged"
    assert net.rms(x) == approx(net.rms(solved[1]), rel=1e-6)
    difference = (x - solved[1])[INTERIOR] / solved[0].sd[INTERIOR]
    assert np.abs(difference).max() < 0.01


def test_5_2_b_more_photos_and_points_raise_the_precision():
    camera, points = precision(range(1, 10))
    fewer_camera, fewer = precision([1, 3, 6, 7, 8])
    assert fewer > 1.8 * points and np.all(fewer_camera > 1.5 * camera)
    few_camera, few = precision(range(1, 10), range(0, 50, 4))
    assert 1.3 * points < few < 2 * points and np.all(few_camera > 1.8 * camera)


@pytest.mark.parametrize("x", [net.PUBLISHED, net.START])
def test_5_2_c_a_similarity_of_the_object_changes_no_residual(x):
    # So with seven coordinates absolute orientation shows nothing: the published
    # solution fits as badly after it as before. Nor does the unit of the object follow
    # from the photos
    interior, exteriors, points = net.unpack(x)
    R = rotation.matrix(0.3, -0.2, 0.9)
    shift, scale = np.array([1000.0, 2000.0, 50.0]), 3.7
    moved = exteriors.copy()
    moved[:, :3] = scale * exteriors[:, :3] @ R.T + shift
    for e in moved:
        e[3:] = rotation.angles(rotation.matrix(*e[3:]) @ R.T)
    there = net.pack(interior, moved, scale * points @ R.T + shift)
    close(net.misclosure(there)[0], net.misclosure(x)[0], rtol=0, atol=1e-9)


def test_5_2_c_absolute_orientation_tests_the_points_if_control_is_surplus(solved):
    # Four control points, twelve coordinates: bent points leave residuals. The printed
    # ones do not, though their camera and angles are wrong: they never moved
    interior, exteriors, true = net.unpack(solved[1])
    control, printed = [0, 9, 30, 40], net.unpack(net.PUBLISHED)[2]
    bent = true + 1e-3 * true[:, :1] ** 2 * np.array([0, 0, 1])

    def left(points):
        fit = orientation.absolute(points[control], true[control])
        return np.sqrt(np.mean((fit.apply(points[control]) - true[control]) ** 2))

    assert left(bent) > 1 and left(printed) < 0.005
    fit = orientation.absolute(printed, true)
    off = np.sqrt(np.mean((fit.apply(printed) - true) ** 2))
    assert off == approx(0.003, abs=5e-4)
    assert net.rms(net.PUBLISHED) > 100 * net.rms(solved[1])
