"""Slips are named where the images prove them, and nothing is where they do not."""

import re
from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import simulate, stereo
from pgm_lab.stereo import slips
from tests.stereo import blocks
from tests.stereo.test_parallax import HEIGHTS, LEFT, ONE_OFF, RIGHT, photographed

CASES = [None, *ONE_OFF, "a turned photo"]
FEET = "Z of the stations in feet"
FOOT, EARTH = 0.3048, 6.371e6
AWAY = np.array([0, 0, 3000.0])  # m: ground so high that feet and metres differ


@pytest.fixture(scope="module")
def photos():
    return photographed(LEFT), photographed(RIGHT)


@pytest.fixture(scope="module")
def pixels(photos):
    return slips.common_points(photos)


@pytest.fixture
def matched(pixels, monkeypatch):
    """Without matching the same images again and again."""
    monkeypatch.setattr(slips, "common_points", lambda _: pixels)


def oriented(photos, change):
    """The photos with what a function makes of their exterior orientations."""
    return tuple(replace(one, exterior=change(one.exterior)) for one in photos)


def told(photos, heights):
    try:
        return stereo.y_parallax(stereo.epipolar_pair(*photos, heights)).message
    except ValueError as error:
        return str(error)


def degrees_of_the_earth(exterior):
    lat = np.radians(-33)
    x, y = np.degrees(exterior[:2] / EARTH)
    return np.r_[x / np.cos(lat) + 25, y - 33, exterior[2:]]


SLIPS = {
    "in degrees": lambda e: np.r_[e[:3], np.degrees(e[3:])],
    "in gon": lambda e: np.r_[e[:3], np.degrees(e[3:]) / 0.9],
    "in radians, converted": lambda e: np.r_[e[:3], np.radians(e[3:])],
    "X and Y exchanged": lambda e: e[[1, 0, 2, 3, 4, 5]],
    "longitude and latitude": degrees_of_the_earth,
    FEET: lambda e: e / [1, 1, FOOT, 1, 1, 1],
    "each photo turned.* 180 degrees": lambda e: e + [0, 0, 0, 0, 0, np.pi],
    "each photo turned.* -90 degrees": lambda e: e + [0, 0, 0, 0, 0, np.pi / 2],
}


@pytest.mark.parametrize("words", SLIPS)
def test_a_wrong_unit_of_the_orientation_is_named(photos, matched, words):
    assert re.search(words, told(oriented(photos, SLIPS[words]), HEIGHTS))


@pytest.mark.parametrize("unit, times", [("gon", 10 / 9), ("degrees", 9 / 10)])
def test_angles_converted_from_a_wrong_unit_are_named(photos, unit, times):
    turned = oriented(photos, lambda e: e + [0, 0, 0, 0, 0, 2])
    X = np.random.default_rng(3).uniform((-150, -99, -60), (150, 99, 60), (40, 3))
    wrong = oriented(turned, lambda e: e * np.r_[1, 1, 1, np.full(3, times)])
    at = tuple(one.project(X) for one in turned)
    found = slips.likely(wrong, "heights", np.array(HEIGHTS), at)
    assert f"Are the angles in {unit}, converted" in found


@pytest.mark.parametrize("axis, how", [(0, "left to right"), (1, "upside down")])
def test_mirrored_photos_are_named(photos, pixels, axis, how, monkeypatch):
    last = np.flip(photos[0].grey.shape)[axis] - 1
    swapped = [abs(last * (np.arange(2) == axis) - at) for at in pixels]
    monkeypatch.setattr(slips, "common_points", lambda _: swapped)
    mirrored = [replace(p, grey=np.flip(p.grey, 1 - axis)) for p in photos]
    assert f"mirrored, {how}" in told(mirrored, HEIGHTS)


@pytest.mark.parametrize("unit, times", [("micrometres", 1e3), ("metres", 1e-3)])
def test_a_pixel_size_in_another_unit_is_named(photos, matched, unit, times):
    wrong = [replace(one, pixel_size=one.pixel_size * times) for one in photos]
    assert f"pixel size in {unit}, or" in told(wrong, HEIGHTS)


@pytest.mark.parametrize(
    "words, of",
    [
        ("focal length in pixels", lambda c, pixel: {"c": c.c / pixel}),
        ("1.9 times as large a pixel, or as short a", lambda c, _: {"c": 2 * c.c}),
        ("0.56 times as large a pixel, or as", lambda c, _: {"c": 0.57 * c.c}),
        ("principal point in pixels", lambda c, _: {"x0": 2144.0, "y0": 1424.0}),
    ],
)
def test_an_interior_orientation_in_pixels_or_of_another_camera_is_named(
    photos, matched, words, of
):
    wrong = [
        replace(p, camera=replace(p.camera, **of(p.camera, p.pixel_size)))
        for p in photos
    ]
    assert words in told(wrong, HEIGHTS)


def test_one_mirrored_photo_and_the_same_photo_twice_are_named(photos):
    left, right = photos
    mirrored = replace(left, grey=np.fliplr(left.grey))
    assert "Is one photo mirrored" in told((mirrored, right), HEIGHTS)
    assert "same photo twice" in told((left, replace(right, grey=left.grey)), HEIGHTS)


def test_one_turned_photo_is_named_and_what_level_photos_leave_open(photos):
    rng = np.random.default_rng(3)
    X = rng.uniform((-150, -200, -60), (150, 200, 60), (40, 3))
    level = oriented(photos, lambda e: np.r_[e[0], 2, 1000, 0, 0, 0])
    for given, whose in ((photos, "the left photo"), (level, "each photo")):
        pixels = [one.project(X) for one in given]
        turned = oriented(given, lambda e: e + [0, 0, 0, 0, 0, np.pi])
        if given is photos:
            turned = turned[0], given[1]
        found = slips.likely(turned, "heights", np.array(HEIGHTS), pixels)
        assert f"Is {whose} turned" in found
        assert ("Are the photos exchanged?" in found) == (given is level)


@pytest.mark.slow
def test_feet_of_all_coordinates_are_named(photos, matched):
    high = oriented(photos, lambda e: e + [*AWAY, 0, 0, 0])
    heights = np.add(HEIGHTS, AWAY[2])
    assert told(high, heights).endswith("well oriented.")
    feet = oriented(high, lambda e: np.r_[e[:3] / FOOT, e[3:]])
    assert "the stations in feet" in told(feet, heights)
    assert "the heights in feet" in told(high, heights / FOOT)


@pytest.mark.parametrize("times", [2.5, 8])
def test_the_pixel_size_of_a_photo_before_it_was_reduced_is_named(
    photos, matched, times
):
    wrong = (replace(one, pixel_size=one.pixel_size / times) for one in photos)
    words = told(wrong, HEIGHTS).partition("About ")[2]
    assert float(words.split()[0]) == pytest.approx(times, rel=0.05)


def test_a_slip_is_named_where_too_few_points_are_matched(photos, matched):
    pair = stereo.epipolar_pair(*oriented(photos, SLIPS[FEET]), HEIGHTS)
    flat = replace(pair, left=np.ones_like(pair.left))
    assert FEET in stereo.y_parallax(flat).message


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_orientation_without_a_slip_is_not_called_one(photos, pixels, name):
    k, error = ONE_OFF.get(name, (5, np.radians(40) if name else 0))
    left, right = photos
    wrong = replace(right, exterior=right.exterior + error * (np.arange(6) == k))
    limits = np.array(HEIGHTS, float)
    assert slips.likely((left, wrong), "heights", limits, pixels) == ""
    # Not with limits that were badly guessed, either
    for guess in ((-300, -250), (150, 300), (-600, 600)):
        assert slips.likely((left, wrong), "heights", np.array(guess), pixels) == ""


def test_wrong_heights_are_no_slip_where_photos_without_tilt_prove_nothing(photos):
    """Any pixel size explains any depth, and feet of the heights leave a fifth."""
    level = oriented(photos, lambda e: e * [1, 1, 1, 0, 0, 0])
    rng = np.random.default_rng(3)
    X = rng.uniform((-150, -200, -60), (150, 200, 60), (40, 3))
    pixels = tuple(one.project(X) + rng.normal(0, 0.3, (40, 2)) for one in level)
    assert slips.likely(level, "heights", np.array([580, 620]), pixels) == ""


@pytest.mark.slow
def test_right_photos_have_no_slip_and_bare_ones_prove_none(photos):
    scene = simulate.aerial_pair(part=(300, 200))
    strip = blocks.strip()[0]
    for pair in ((scene.left, scene.right), strip[:2], photos[::-1]):
        assert slips.common_points(pair) is not None
        assert slips.likely(pair, "heights", np.array([0.0, 60])) == ""
    bare = [replace(one, grey=np.zeros_like(one.grey)) for one in photos]
    assert slips.likely(oriented(bare, SLIPS["in degrees"]), "heights", HEIGHTS) == ""


def test_a_file_with_more_than_a_turn_is_refused(photos, tmp_path):
    np.save(tmp_path / "a.npy", photos[0].grey)
    whole = stereo.PhotoFile(tmp_path / "a.npy", photos[0].camera, LEFT, 0.1)
    assert whole.read().grey.shape == photos[0].grey.shape
    turned = replace(whole, exterior=(*LEFT[:5], -179.1))
    for act in (
        turned.read,
        turned.blank,
        lambda: stereo.neighbours([turned], ground=0),
    ):
        with pytest.raises(ValueError, match=r"a\.npy: .* -179.1 .*not degrees"):
            act()


def test_neighbours_say_when_there_are_none(photos, matched):
    with pytest.warns(UserWarning, match=r"share 6\d % \(a smaller least\)\.$"):
        assert stereo.neighbours(photos, ground=0, least=0.8).shape == (0, 2)
    far = oriented(photos, lambda e: e * [9, 1, 1, 1, 1, 1])
    with pytest.warns(UserWarning, match=r"none share any\.$"):
        stereo.neighbours(far, ground=0)
    small = [replace(one, pixel_size=one.pixel_size / 4) for one in photos]
    with pytest.warns(UserWarning, match="Is the pixel size that of the photos"):
        stereo.neighbours(small, ground=0)
    with pytest.raises(ValueError, match="does not look down.*angles in degrees"):
        stereo.neighbours(oriented(photos, SLIPS["in degrees"]), ground=0)


def test_a_pair_of_a_block_that_fails_names_the_slip(photos, matched, tmp_path):
    (tmp_path / "block").mkdir()
    feet = oriented(photos, SLIPS[FEET])
    with pytest.raises(ValueError, match=f"0 of 0 matched points lie between .*{FEET}"):
        stereo.plot_block(feet, [(0, 1)], tmp_path / "block", heights=HEIGHTS,
                          cell=5.0, workers=1, retries=0, progress=False)  # fmt: skip
