"""The normal pair: true points in equal rows, grey values where they belong, limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pgm_lab import camera, orientation, simulate, stereo
from pgm_lab.camera import Camera, Photo

LENS = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
LEFT = (-150.0, 2, 1020, 0.014, -0.019, 0.035)
RIGHT = (151.0, 5, 1024, -0.01, 0.016, -0.026)
SIZE, PIXEL = (300, 280), 0.08  # coarse pixels: the whole format in a small image
HEIGHTS = (0.0, 60.0)
SIDES = (0, 1)

angle = st.floats(-0.15, 0.15)
kappa = st.floats(-3.1, 3.1)


def ramp(exterior=LEFT, camera=LENS, size=SIZE, pixel=PIXEL, by=(1.0, 0.0)):
    """A photo whose grey value is its column, or its row."""
    columns, rows = size
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    return Photo(by[0] * x + by[1] * y, camera, exterior, pixel)


def points(n=300, seed=2):
    low, high = (-700, -500, HEIGHTS[0]), (700, 500, HEIGHTS[1])
    return np.random.default_rng(seed).uniform(low, high, (n, 3))


def inside(image, pixels, margin=0.0):
    size = np.array(image.shape[::-1])
    return ((pixels >= -0.5 + margin) & (pixels <= size - 0.5 - margin)).all(-1)


def seen_by_both(photos, X):
    pixels = [p.seen_at(X - p.exterior[:3]) for p in photos]
    return np.all([inside(p.grey, at) for p, at in zip(photos, pixels)], axis=0)


def mesh(image, step=7):
    rows, columns = image.shape
    return np.stack(
        np.meshgrid(np.arange(0, columns, step), np.arange(0, rows, step)), -1
    )


def check(photos, pair, X):
    """True points that both photos show: in equal rows, inside, and found again."""
    X = X[seen_by_both(photos, X)]
    assert len(X) > 20
    np.testing.assert_allclose(np.linalg.det(pair.rotation), 1)  # not in a mirror
    one, other = (pair.from_photo(k, photos[k].project(X)) for k in SIDES)
    assert np.abs(one[:, 1] - other[:, 1]).max() < 1e-6
    assert inside(pair.left, one, -1).all() and inside(pair.right, other, -1).all()
    back = pair.object_points(*one.T, one[:, 0] - other[:, 0])
    np.testing.assert_allclose(back, X, atol=1e-6)
    assert np.abs(np.median(one[:, 0] - other[:, 0])) < 3  # zero in mid-height
    for k in SIDES:
        pixels = photos[k].project(X)
        there = pair.from_photo(k, pixels)
        np.testing.assert_allclose(pair.to_photo(k, there), pixels, atol=1e-6)


@given(angle, angle, kappa, angle, angle, kappa, st.floats(-60, 60), st.floats(-60, 60))
@settings(max_examples=10)
def test_any_two_photos_have_no_y_parallax(o1, p1, k1, o2, p2, k2, by, bz):
    photos = (
        ramp((-150, 0, 1020, o1, p1, k1)),
        ramp((150, by, 1020 + bz, o2, p2, k2), replace(LENS, lens="forward")),
    )
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    check(photos, pair, points())
    for k in SIDES:  # nothing is lost, and little is there that nobody shows
        shown = np.isfinite((pair.left, pair.right)[k]).mean()
        assert shown > 0.4


@pytest.mark.parametrize("by, axis", [((1, 0), 0), ((0, 1), 1)])
def test_grey_values_come_from_where_to_photo_says(by, axis):
    # Upper right corners of both photos, in real pixels: there the lens bends most
    photos = tuple(
        replace(ramp(e, by=by, pixel=5.49e-3), image_size=(4288, 2848), corner=corner)
        for e, corner in (((0, 0, 1020, 0.01, 0, 0.02), (3988, 0)),
                          ((8, 0, 1024, 0.01, 0, 0.03), (3950, 0)))
    )  # fmt: skip
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    assert pair.left.shape[0] > 256  # more than one band of rows
    for k, image in zip(SIDES, (pair.left, pair.right)):
        at = mesh(image)
        grey = image[at[..., 1], at[..., 0]]
        place = pair.to_photo(k, at)
        # The spline bends at the edge of the photo alone
        middle = inside(photos[k].grey, place, 8)
        assert middle.sum() > 300
        assert np.abs(grey - place[..., axis])[middle].max() < 1e-3
        assert np.isfinite(grey[inside(photos[k].grey, place, 0.51)]).all()
        assert np.isnan(grey[~inside(photos[k].grey, place, 0.49)]).all()


def test_pixels_without_data_stay_without():
    hole = np.zeros(SIZE[::-1], bool)
    hole[130:150, 140:170] = True
    left, right = ramp(LEFT), ramp(RIGHT)
    full = stereo.epipolar_pair(left, right, HEIGHTS)
    with_nan = np.where(hole, np.nan, left.grey)
    for grey in (with_nan, np.ma.array(left.grey, mask=hole)):
        pair = stereo.epipolar_pair(replace(left, grey=grey), right, HEIGHTS)
        at = mesh(pair.left, 1)
        place = pair.to_photo(0, at)
        deep = inside(np.zeros((20, 30)), place - (140, 130))
        assert np.isnan(pair.left[deep]).all()
        far = ~inside(np.zeros((20, 30)), place - (140, 130), -2)
        np.testing.assert_array_equal(
            np.isnan(pair.left[far]), np.isnan(full.left[far])
        )
        # The hole does not swing into its neighbours
        assert np.nanmax(np.abs((pair.left - full.left)[far])) < 0.5
        np.testing.assert_array_equal(pair.right, full.right)


def test_a_lens_that_turns_back_right_outside_the_photo_does_no_harm():
    # The measured corner at 16.4 mm is ideal at 12.0; there is none beyond 12.2
    lens = Camera(24.0, K1=-1e-3)
    photos = (
        ramp((-150, 0, 1020, 0, 0.2, 0.4), lens),
        ramp((150, 0, 1020, 0.1, 0, 0), lens),
    )
    with pytest.raises(ValueError, match="displaces no point"):
        photos[0].to_pixel(camera.measured(lens, (9.0, 9.0)))
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    check(photos, pair, points())
    for k, image in zip(SIDES, (pair.left, pair.right)):
        x, y = np.meshgrid(*(np.arange(15, n - 15, 30) for n in SIZE))
        there = pair.from_photo(k, np.stack([x, y], -1))
        column, row = np.rint(there[inside(image, there)]).astype(int).T
        # What the photo shows has grey values, up to its corners
        assert np.isfinite(image[row, column]).all()


@pytest.mark.parametrize("finer", [0, 1])
def test_of_two_scales_the_coarser_keeps_its_pixels(finer):
    cameras = [LENS, LENS]
    cameras[finer] = Camera(50.0, 0.1, K1=1e-5)
    sizes = [SIZE, SIZE]
    sizes[finer] = (620, 590)
    photos = tuple(ramp(e, c, s) for e, c, s in zip((LEFT, RIGHT), cameras, sizes))
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    angle_of_pixel = pair.pixel_size / pair.c
    assert angle_of_pixel == pytest.approx(PIXEL / LENS.c, rel=0.06)
    check(photos, pair, points())


def test_fine_texture_of_the_finer_photo_is_taken_out_and_not_aliased():
    left = ramp(LEFT)
    right = ramp(RIGHT, Camera(60.0), (740, 700))
    stripes = 100 + 50 * (np.indices((700, 740))[1] % 2)
    pair = stereo.epipolar_pair(left, replace(right, grey=stripes), HEIGHTS)
    assert np.nanstd(pair.right) < 8  # of 25
    assert np.nanmean(pair.right) == pytest.approx(125, abs=0.5)


def test_exchanged_photos_give_the_same_ground_and_images_turned_by_180_degrees():
    photos = ramp(LEFT, by=(1, 2)), ramp(RIGHT, by=(1, 2))
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    turned = stereo.epipolar_pair(*photos[::-1], HEIGHTS)
    check(photos[::-1], turned, points())
    R = turned.rotation @ pair.rotation.T
    np.testing.assert_allclose(R, np.diag([-1.0, -1, 1]), atol=1e-12)
    assert turned.left.shape == pair.left.shape
    np.testing.assert_allclose(turned.base, pair.base)


def test_relative_orientation_alone_is_enough():
    photos = ramp(LEFT), ramp(RIGHT)
    X = points()[seen_by_both(photos, points())][:12]
    found = orientation.relative(
        LENS, LENS, *(p.to_photo(p.project(X)) for p in photos), base=1.0
    )
    model = (
        replace(photos[0], exterior=np.zeros(6)),
        replace(photos[1], exterior=found.exterior),
    )
    depths = -found.points[:, 2]
    pair = stereo.epipolar_pair(*model, depths=(depths.min(), depths.max()))
    one, other = (pair.from_photo(k, photos[k].project(X)) for k in SIDES)
    assert np.abs(one[:, 1] - other[:, 1]).max() < 1e-6
    back = pair.object_points(*one.T, one[:, 0] - other[:, 0])
    np.testing.assert_allclose(back, found.points, atol=1e-7)


REFUSED = {
    "the same station": ((*LEFT[:3], 0.1, 0, 0), {}, "have the same station"),
    "no overlap": ((5000.0, 0, 1000, 0, 0, 0), {}, "no ground in common"),
    "wrong heights": (RIGHT, {"heights": (2000, 2100)}, "no ground in common"),
    "one above the other": (
        (-150.0, 10, 700, 0, 0, 0), {}, "epipole lies inside the left photo",
    ),
    "face to face": (
        (150.0, 0, 1020, 0, np.pi - 0.1, 0), {}, "more than 90 degrees apart",
    ),
    "no heights": (RIGHT, {"heights": None}, "either heights or depths"),
    "a strip": ((850.0, 0, 1020, 0, 0, 0), {}, "at least 32"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_normal_case_is_refused_with_the_reason(case):
    exterior, change, words = REFUSED[case]
    arguments = {"heights": HEIGHTS} | change
    with pytest.raises(ValueError, match=words):
        stereo.epipolar_pair(ramp(LEFT), ramp(exterior), **arguments)


def test_parts_with_exchanged_orientations_are_told_so():
    scene = simulate.aerial_pair(part=(240, 180))
    wrong = (
        replace(scene.left, exterior=scene.right.exterior),
        replace(scene.right, exterior=scene.left.exterior),
    )
    with pytest.raises(ValueError, match="Are the photos exchanged"):
        stereo.epipolar_pair(*wrong, HEIGHTS)


def test_disparities_that_do_not_meet_in_front_have_no_point():
    pair = stereo.epipolar_pair(ramp(LEFT), ramp(RIGHT), HEIGHTS)
    found = pair.object_points([5.0, 5, 5], 7.0, [0.0, np.nan, -1e4])
    np.testing.assert_array_equal(np.isnan(found[:, 0]), [False, True, True])
