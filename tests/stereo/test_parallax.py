"""Y parallax: zero where all is right, and a right diagnosis where something is not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from pgm_lab import simulate, stereo
from pgm_lab.camera import Camera, Photo
from pgm_lab.stereo import parallax

LENS = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
LEFT = np.array((-195.0, 2, 1000, 0.014, -0.019, 0.035))
RIGHT = np.array((195.0, 5, 1004, -0.01, 0.016, -0.026))
SIZE, PIXEL = (360, 240), 24 / 360  # a whole format of 24 x 16 mm, in coarse pixels
HEIGHTS = (-80, 80)
DEGREE = np.radians(1)
ONE_OFF = {
    "by": (1, 10.0),
    "bz": (2, 10.0),
    "omega": (3, DEGREE),
    "phi": (4, DEGREE),
    "kappa": (5, DEGREE),
}


def photographed(exterior, seed=1, slope=0.15):
    """A textured hillside, Z = slope X, seen through the lens."""
    photo = Photo(np.zeros(SIZE[::-1], np.uint8), LENS, exterior, PIXEL)
    u = photo.rays(np.stack(np.meshgrid(*map(np.arange, SIZE)), -1))
    X0, Y0, Z0 = exterior[:3]
    t = (slope * X0 - Z0) / (u[..., 2] - slope * u[..., 0])
    ground = np.stack([X0 + t * u[..., 0], Y0 + t * u[..., 1]], -1)
    texture = simulate.texture(seed=seed, waves=30)
    grey = simulate.grey_values(texture, ground / 2.8)
    noise = np.random.default_rng(seed).normal(0, 1, grey.shape)
    return replace(photo, grey=np.clip(grey + noise, 0, 255).round().astype(np.uint8))


@pytest.fixture(scope="module")
def photos():
    return photographed(LEFT), photographed(RIGHT)


@pytest.fixture(scope="module")
def aerial():
    return simulate.aerial_pair(part=(400, 300))


def turned(photo, element, by):
    exterior = np.array(photo.exterior)
    exterior[element] += by
    return replace(photo, exterior=exterior)


def measured(left, right, heights=HEIGHTS, **more):
    return stereo.y_parallax(stereo.epipolar_pair(left, right, heights), **more)


def relief(aerial):
    return aerial.landscape.dsm.min(), aerial.landscape.dsm.max()


@pytest.mark.slow
def test_a_simulated_flight_is_well_oriented(aerial):
    pair = stereo.epipolar_pair(aerial.left, aerial.right, relief(aerial))
    found = stereo.y_parallax(pair)
    assert found.verdict == "well oriented" and "well oriented" in found.message
    assert found.n > 20 and found.rmse < 0.1 and abs(found.mean) < 0.03
    assert found.nmad <= found.rmse * 1.5
    off = (found.points - found.matched)[found.used]
    np.testing.assert_array_equal(found.values[found.used], -off[:, 1])
    # Matched at the truth, in the columns too
    xyz = pair.object_points(*found.points[found.used].T, off[:, 0])
    column, row = np.rint(pair.to_photo(0, found.points[found.used])).astype(int).T
    assert np.median(np.abs(xyz - aerial.ground[0][row, column])) < 0.2


@pytest.mark.parametrize("name", ["by", "kappa"])
def test_in_a_whole_format_each_element_is_told_from_the_others(photos, name):
    left, right = photos
    k, error = ONE_OFF[name]
    pair = stereo.epipolar_pair(left, turned(right, k, error), HEIGHTS)
    found = stereo.y_parallax(pair, number=40)
    assert found.verdict == "wrong orientation"
    assert found.elements[0].name == name and f"{name} corrected by" in found.message
    # by and bz are counted across the base, which is not quite that of object space
    assert found.elements[0].correction == pytest.approx(-error, rel=0.05)
    assert found.elements[0].remaining < 0.1
    assert found.elements[1].remaining > 2 * found.elements[0].remaining
    if name == "kappa":  # turned by a degree: so much over the width of the image
        expected = pair.left.shape[1] * DEGREE
        assert abs(found.trend[1]) == pytest.approx(expected, rel=0.1)
        assert abs(found.trend[2]) < 0.1 * expected


@pytest.mark.parametrize("name", ONE_OFF)
def test_an_element_that_is_wrong_explains_the_parallaxes_of_exact_points(photos, name):
    left, right = photos
    X = np.random.default_rng(3).uniform((-150, -200, -60), (150, 200, 60), (40, 3))
    wrong = turned(right, *ONE_OFF[name])
    found, together = parallax.explanations(
        (left, wrong), left.project(X), right.project(X), PIXEL
    )
    assert found[0].name == name and together < 0.01
    assert found[0].correction == pytest.approx(-ONE_OFF[name][1], rel=0.05)
    assert found[1].remaining > 5 * found[0].remaining


def test_two_wrong_elements_need_a_new_relative_orientation(photos):
    left, right = photos
    wrong = turned(turned(right, 3, DEGREE), 5, 2 * DEGREE)
    found = measured(left, wrong, number=40)
    assert found.together < 0.1 < found.elements[0].remaining
    assert "No element of the right photo alone explains it" in found.message


def test_exchanged_images_are_found_out(photos):
    left, right = photos
    exchanged = replace(left, grey=right.grey), replace(right, grey=left.grey)
    found = measured(*exchanged, number=40)
    assert found.verdict == "photos exchanged"
    assert "exchange the images" in found.message


def test_photos_exchanged_with_their_orientations_are_as_good(photos):
    assert measured(*photos[::-1], number=40).verdict == "well oriented"


@pytest.mark.slow
def test_other_ground_and_water_have_too_few_points(photos):
    left, right = photos
    noise = np.random.default_rng(5).normal(90, 1, right.grey.shape).round()
    for grey in (photographed(RIGHT, seed=7).grey, noise):
        found = measured(left, replace(right, grey=grey), number=30)
        assert found.verdict == "too few points"
        assert "do not show the same ground" in found.message
        assert np.isnan(found.rmse) or found.n < 6


def test_waves_without_a_trend_are_not_blamed_on_the_orientation(photos):
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    rows, columns = np.indices(pair.right.shape)
    waves = rows + 0.35 * np.sin(columns / 9)  # a shaking scanner
    grey = ndimage.map_coordinates(np.nan_to_num(pair.right), [waves, columns], order=1)
    grey[np.isnan(pair.right)] = np.nan
    found = stereo.y_parallax(replace(pair, right=grey), number=60)
    assert found.verdict == "no trend" and 0.1 < found.rmse < 0.35
    assert "not the orientation" in found.message


def test_a_place_that_does_not_fit_is_left_out_by_name(photos):
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    middle = pair.left.shape[1] // 2
    moved = pair.right.copy()
    block = np.s_[80:150, middle : middle + 70]
    moved[block] = np.roll(pair.right[block], 2, axis=0)
    found = stereo.y_parallax(replace(pair, right=moved), number=60)
    off = found.matched[found.status == "off the trend"]
    assert len(off) >= 2
    near = off - (middle, 80)  # a window may reach in from outside
    assert ((near > -12) & (near < 82)).all()
    assert found.rmse < 0.1


def test_points_of_the_callers_are_measured_where_they_are(photos):
    pair = stereo.epipolar_pair(*photos, HEIGHTS)
    rows, columns = pair.left.shape
    x, y = np.linspace(40, columns - 40, 5), np.linspace(40, rows - 40, 4)
    chosen = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2).round()
    found = stereo.y_parallax(pair, chosen)
    np.testing.assert_array_equal(found.points, chosen)
    assert found.n >= 6 and found.rmse < 0.1


def test_without_photos_there_is_a_trend_but_no_explanation(photos):
    left, right = photos
    pair = stereo.epipolar_pair(left, turned(right, 3, DEGREE), HEIGHTS)
    found = stereo.y_parallax(replace(pair, photos=None), number=40)
    assert found.verdict == "wrong orientation" and found.elements == ()
    assert found.message.endswith("Orient the photos again.")
