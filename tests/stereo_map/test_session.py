"""Measured points against the truth of simulated photos; the steps of a session."""

import itertools
from dataclasses import replace

import cv2
import numpy as np
import pytest

from pgm_lab import orientation, simulate, stereo_map
from pgm_lab.camera import Camera, collinearity
from pgm_lab.stereo_map import drawing, measuring
from pgm_lab.stereo_map.session import Measurement
from tests.stereo_map.conftest import true_ground

GRID = list(itertools.product(range(40, 400, 45), range(40, 280, 40)))


@pytest.fixture(scope="module")
def measured(oriented):
    return [stereo_map.measure(oriented, pixel) for pixel in GRID]


@pytest.fixture(scope="module")
def found(pair, measured):
    """On open ground: a window on an edge of a roof or a crown shows two surfaces."""
    land = pair.landscape
    objects = (land.kind > 0).astype(np.uint8)
    near = cv2.dilate(objects, np.ones((33, 33)))  # 2.4 m, half of a template
    points = [(p, true_ground(pair, p)) for p in measured if p.accepted]
    return [p for p, (X, Y, _) in points if not land.at(near, X, Y, cv2.INTER_NEAREST)]


def test_points_lie_where_both_photos_show_them_within_three_standard_deviations(
    pair, found
):
    assert len(found) >= 15
    w = np.array([(p.xyz - true_ground(pair, p)) / p.sd for p in found])
    assert np.abs(w).max() < 3
    rms = np.sqrt(np.mean(w**2, axis=0))
    assert np.all((rms > 0.3) & (rms < 1.2))  # sd of the right size
    for point in found:
        truth = pair.right.project(true_ground(pair, point))
        assert np.abs(point.right - truth).max() < 0.5
        assert abs(point.y_parallax) < 0.3
        near = np.hypot(*(point.curve - point.right).T).min()
        assert near < np.hypot(*np.diff(point.curve, axis=0).T).max()


def test_object_point_and_its_errors_are_those_of_the_intersection(oriented, measured):
    point = next(p for p in measured if p.accepted)
    for k, photo in enumerate(oriented.photos):
        place = (point.left, point.right)[k]
        np.testing.assert_allclose(point.photo[k], photo.to_photo(place), atol=1e-12)
    cameras = [photo.camera for photo in oriented.photos]
    exteriors = [photo.exterior for photo in oriented.photos]
    sigma = float(np.sqrt(np.mean(point.photo_sd**2)))
    plain = orientation.intersect(cameras, exteriors, point.photo, sigma=sigma)
    # With one sigma for all, where StereoMap has a covariance a photo
    assert np.abs((plain.points - point.xyz) / point.sd).max() < 1
    # Predicted errors are those of many repetitions
    rng = np.random.default_rng(4)
    roots = np.linalg.cholesky(point.photo_covariance)
    noise = np.einsum("kij,nkj->nki", roots, rng.normal(size=(3000, 2, 2)))
    xy = np.moveaxis(point.photo + noise, 1, 0)
    places = orientation.intersect(cameras, exteriors, xy).points
    np.testing.assert_allclose(places.std(axis=0), point.sd, rtol=0.06)


@pytest.mark.parametrize(
    ("pixel", "status"),
    [
        ((-20, 30), "outside"),
        ((1e9, 30), "outside"),
        ((-0.6, 100), "outside"),  # pixels reach half a pixel from their centres
        ((-0.4, 100), "template leaves the image"),
        ((419.4, 299.4), "template leaves the image"),
        ((419.6, 100), "outside"),
        ((3, 100), "template leaves the image"),
        ((417, 297), "template leaves the image"),
        ((130, 130), "flat template"),
    ],
)
def test_what_cannot_be_measured_gets_a_reason(pair, pixel, status):
    flat = pair.left.grey.copy()
    flat[80:180, 80:180] = 117
    oriented = stereo_map.open_pair(replace(pair.left, grey=flat), pair.right)
    point = stereo_map.measure(oriented, pixel)
    assert point.status == status and not point.accepted
    assert np.isnan(point.right).all() and np.isnan(point.xyz).all()
    assert point.why.endswith(".")
    with pytest.raises(ValueError, match="only a point that was found is kept"):
        stereo_map.add(oriented, point)
    said = drawing.lines(oriented, point)[0]
    assert ("Sought" in said) == (status == "flat template")


@pytest.mark.parametrize(
    ("pixel", "corner", "shape"),
    [
        ((4, 3), (0, 0), (14, 15)),  # rows, columns of a window of 21 pixels
        ((200, 3), (190, 0), (14, 21)),
        ((417, 298), (407, 288), (12, 13)),
    ],
)
def test_a_click_near_the_edge_shows_what_there_is_of_the_window(
    oriented, pixel, corner, shape
):
    point = stereo_map.measure(oriented, pixel)
    assert point.status == "template leaves the image"
    assert point.template.shape == shape
    column, row = corner
    part = oriented.left.grey[row : row + shape[0], column : column + shape[1]]
    np.testing.assert_array_equal(point.template, part)


def test_each_photo_has_half_of_the_error_in_its_own_pixels(pair):
    """A right photo of 1.5 times the scale across: its pixels are not the left ones."""
    rows, columns = pair.left.grey.shape
    wide = cv2.resize(pair.left.grey, (columns * 3 // 2, rows))
    session = stereo_map.open_pair(
        pair.left.grey, wide, camera=Camera(24.0), pixel_size=0.005
    )
    for pixel in GRID:
        point = stereo_map.measure(session, pixel, (1.5 * pixel[0] + 0.25, pixel[1]))
        if point.accepted:
            break
    assert point.shape[0, 0] == pytest.approx(1.5, abs=0.05)
    (left, right), across = point.photo_sd, np.sqrt(point.covariance[0, 0] / 2)
    assert right[0] == pytest.approx(0.005 * across, rel=1e-9)
    assert left[0] == pytest.approx(0.005 * across / 1.5, rel=0.05)


def test_the_search_is_wider_where_the_points_so_far_miss_their_lines(pair, measured):
    """An omega that is wrong by 7 px: the points are off their epipolar lines."""
    omega = 7 * pair.right.pixel_size / pair.right.camera.c
    right = replace(pair.right, exterior=pair.right.exterior + [0, 0, 0, omega, 0, 0])
    session = stereo_map.open_pair(pair.left, right)
    kept = [p for p in measured if p.accepted][:12]
    off = replace(session, points=(replace(kept[0], y_parallax=4.0),))

    def right_ones(session):
        found = [stereo_map.measure(session, p.left).right for p in kept]
        off = np.abs(found - np.array([p.right for p in kept])).max(axis=1)
        return np.sum(off < 0.2)

    assert right_ones(session) == 0 and right_ones(off) >= 6


def test_the_search_is_wider_where_the_points_so_far_disagree(unknown):
    """Of eight points one is 60 px off the transformation that the others follow."""
    apart = [
        replace(p, right=p.left + (20, 0) + (k == 3) * np.array([0, 60]))
        for k, p in enumerate(unknown.points[:8])
    ]
    session = replace(unknown, points=tuple(apart))
    place, half = measuring._predicted(session, np.array([200.0, 150]))
    A = np.column_stack([np.ones(8), [p.left for p in apart]])
    d = np.array([p.right - p.left for p in apart])
    residuals = np.hypot(*(d - A @ np.linalg.lstsq(A, d, rcond=None)[0]).T)
    np.testing.assert_allclose(half, 3 * residuals.max())
    assert half[0] > 2 * 0.08 * 480  # more than usual
    agree = tuple(replace(p, right=1.1 * p.left + (3, -2)) for p in apart)
    agreed = replace(unknown, points=agree)
    place, half = measuring._predicted(agreed, np.array([200.0, 150]))
    np.testing.assert_allclose(place, (223, 163))
    np.testing.assert_allclose(half, 0.08 * 480)


def test_the_search_goes_as_deep_as_the_heights_or_the_points_so_far(pair, oriented):
    """The ends of the epipolar curve are at the heights given, or a third beyond."""
    pixel, (left, right) = np.array([200.0, 150]), oriented.photos
    with_heights = replace(oriented, heights=(-20.0, 90.0))
    ray = left.rays(pixel)
    ends = [
        left.exterior[:3] + (Z - left.exterior[2]) / ray[2] * ray for Z in (90, -20)
    ]
    curve = stereo_map.measure(with_heights, pixel).curve
    np.testing.assert_allclose(curve[[0, -1]], right.project(ends), atol=1e-6)
    depths = np.array([400.0, 500, 560, 600, 700])
    xyz = left.exterior[:3] + depths[:, None] * ray / left.camera.c
    kept = tuple(Measurement(pixel, xyz=one, status="accepted") for one in xyz)
    for n, expected in (
        (5, (400 / 1.3, 700 * 1.3)),
        (3, (400 / 1.3, 560 * 1.3)),
        (2, np.array([1, 100]) * np.linalg.norm(right.exterior - left.exterior)),
    ):
        found = measuring._depths(replace(oriented, points=kept[:n]), pixel)
        np.testing.assert_allclose(found, expected, rtol=1e-3)


def test_the_object_point_has_the_least_weighted_squares(oriented, measured):
    """Where y of the right photo is ten times less certain, it moves ten times more."""
    point = next(p for p in measured if p.accepted)
    C = np.array([np.eye(2), np.diag([1.0, 100])]) * 1e-6
    xy = point.photo + [[0, 0], [0, 0.004]]
    xyz, covariance, _ = measuring._intersected(oriented.photos, xy, C)

    def squares(X):
        v = [
            collinearity(photo.camera, photo.exterior, X, one, ()).v
            for photo, one in zip(oriented.photos, xy)
        ]
        return sum(a @ np.linalg.solve(c, a) for a, c in zip(v, C))

    for step in np.linalg.cholesky(covariance).T:  # one sigma: one square more
        for sign in (1, -1):
            assert squares(xyz + sign * step) - squares(xyz) == pytest.approx(1, 0.05)


@pytest.mark.parametrize("off", [4, -4])
def test_a_match_off_its_epipolar_line_is_refused_on_both_sides(
    oriented, measured, off
):
    point = next(p for p in measured if p.accepted)
    moved = replace(point, right=point.right + (0, off))
    refused = measuring._positioned(oriented, moved, distance=2.0)
    assert refused.status == "off the epipolar line"
    assert abs(refused.y_parallax) == pytest.approx(4, abs=0.5)


def test_what_the_right_photo_does_not_show_is_not_found(pair, oriented):
    rows, columns = np.nonzero(pair.hidden[0][30:-30, 30:-30])
    hidden = np.column_stack([columns, rows])[:: len(rows) // 25] + 30
    wrong = [stereo_map.measure(oriented, pixel) for pixel in hidden]
    wrong = [p for p in wrong if p.accepted]
    # The window of a hidden pixel may rest on ground beside it that both photos show
    assert len(wrong) <= 0.2 * len(hidden)


def test_a_click_in_the_right_photo_says_where_to_look(unknown, bare):
    kept = unknown.points[6]
    blind = replace(unknown, points=(), before=None)
    there = stereo_map.measure(blind, kept.left, kept.right + (6, -4), reach=12)
    assert there.accepted and np.abs(there.right - kept.right).max() < 0.05
    assert there.reason == "where you clicked in the right photo"
    away = stereo_map.measure(blind, kept.left, kept.right + (80, 40), reach=12)
    assert not away.accepted


def test_matches_before_the_orientation_are_right_and_predict_the_next(bare, unknown):
    assert [p.reason for p in unknown.points[:3]] == [
        "in the whole photo",
        "near the place that one point predicts",
        "near the place that 2 points predict",
    ]
    for point in unknown.points:
        truth = bare.right.project(true_ground(bare, point))
        assert np.abs(point.right - truth).max() < 0.5
        assert np.isnan(point.xyz).all()


def test_measured_points_orient_the_pair(bare, unknown):
    model = stereo_map.orient(unknown)
    assert model.space == "model" and model.unit == "model units"
    assert model.oriented_by == tuple(range(1, 15))
    assert max(abs(p.y_parallax) for p in model.points) < 0.5
    # The model is the landscape but for its size and its place
    ground = np.array([true_ground(bare, p) for p in model.points])
    xyz = np.array([p.xyz for p in model.points])
    fit = orientation.absolute(xyz, ground)
    base = np.linalg.norm(bare.right.exterior[:3] - bare.left.exterior[:3])
    length = np.linalg.norm(model.right.exterior[:3])
    assert fit.scale * length == pytest.approx(base, rel=0.01)
    new = stereo_map.measure(model, (240, 170))
    assert new.reason == "along the epipolar line" and len(new.curve) > 1


def test_control_points_bring_the_model_to_the_ground(bare, unknown):
    control = {p.name: true_ground(bare, p) for p in unknown.points[::3]}
    ground = stereo_map.orient(unknown, control)
    assert ground.space == "object"
    turn = 4 * ground.relative.sd[3:].max()  # radians; a station 1000 m up goes along
    for mine, true in ((ground.left, bare.left), (ground.right, bare.right)):
        assert np.abs(mine.exterior[:3] - true.exterior[:3]).max() < 1000 * turn < 40
        assert np.abs(mine.exterior[3:] - true.exterior[3:]).max() < turn
    errors = np.array([p.xyz - true_ground(bare, p) for p in ground.points])
    assert np.sqrt(np.mean(errors**2, axis=0)).max() < 0.5  # m; a pixel is 0.69 m


def test_too_few_points_or_control_points_do_not_orient(unknown):
    few = replace(unknown, points=unknown.points[:4])
    with pytest.raises(ValueError, match="5 points or more.*there are 4"):
        stereo_map.orient(few)
    control = {1: (0, 0, 0), 2: (1, 0, 0)}
    with pytest.raises(ValueError, match="three points or more"):
        stereo_map.orient(unknown, control)
    with pytest.raises(ValueError, match="point 99, which is not on"):
        stereo_map.orient(unknown, control | {99: (0, 1, 0)})


def test_undo_takes_back_points_and_orientation_step_by_step(unknown):
    model = stereo_map.orient(unknown)
    assert stereo_map.undo(model) is unknown
    session = unknown
    for left in range(13, -1, -1):
        session = stereo_map.undo(session)
        assert [p.name for p in session.points] == list(range(1, left + 1))
    with pytest.raises(ValueError, match="nothing to take back"):
        stereo_map.undo(session)


def test_a_point_is_kept_once(oriented, measured):
    point = next(p for p in measured if p.accepted)
    session = stereo_map.add(oriented, point)
    assert oriented.points == () and session.points[0].name == 1
    with pytest.raises(ValueError, match="this is point 1"):
        stereo_map.add(session, point)


@pytest.mark.slow
def test_the_same_photo_twice_has_no_base(pair):
    """However many points were measured: rounding decides where their rays meet."""
    session = stereo_map.open_pair(*[replace(pair.left, exterior=np.zeros(6))] * 2)
    for pixel in np.random.default_rng(3).integers((20, 20), (400, 280), (16, 2)):
        point = stereo_map.measure(session, pixel)
        session = stereo_map.add(session, point) if point.accepted else session
        if len(session.points) in (6, 11, 12, 13):
            with pytest.raises(ValueError, match="no base|without a base"):
                stereo_map.orient(session)
    assert len(session.points) >= 13


def test_a_pair_without_overlap_finds_next_to_nothing(pair):
    other = simulate.texture(seed=5)
    grid = np.stack(np.meshgrid(np.arange(420), np.arange(300)), -1)
    grey = simulate.grey_values(other, grid)
    session = stereo_map.open_pair(
        pair.left.grey, grey, camera=Camera(24.0), pixel_size=0.005
    )
    found = [stereo_map.measure(session, pixel).accepted for pixel in GRID[::4]]
    assert sum(found) == 0


# --- What the program says of a point ---


@pytest.mark.slow
def test_the_base_of_a_model_has_its_sign(unknown):
    model = stereo_map.orient(unknown)
    assert "Model (base in x: 1): X" in drawing.lines(model, model.points[0])[-1]
    swapped = stereo_map.open_pair(unknown.right, unknown.left)
    for point in unknown.points:
        place = np.round(point.right)
        found = stereo_map.measure(swapped, place, point.left, reach=6)
        if found.accepted:
            swapped = stereo_map.add(swapped, found)
    model = stereo_map.orient(swapped)
    assert model.right.exterior[0] == -1
    assert "Model (base in x: −1): X" in drawing.lines(model, model.points[0])[-1]
