"""Where to begin: pairs that lie far apart, or whose shift changes over the image."""

import cv2
import numpy as np
import pytest

from pgm_lab._robust import nmad
from pgm_lab.datasets import landsat, yellowstone
from pgm_lab.registration import (
    approximate,
    fit,
    grid,
    pick,
    register,
    resample,
)
from pgm_lab.registration.start import _affine, cause, chance
from tests.registration.images import uneven


def errors(found, truth):
    """Of the accepted shifts."""
    d = np.stack([found.dx, found.dy], axis=1) - truth(found.points)
    return d[found.accepted]


def begun(pair, number=100, **how):
    """Registered from where `approximate` says."""
    start = approximate(*pair)
    points = pick(pair[0], number, sensed=pair[1], offset=start.typical)
    how |= {"start": start.shifts(points), "radius": start.radius}
    return start, register(*pair, points, refine="lsm", **how)


@pytest.mark.parametrize(
    "shift", [pytest.param((18.0, -11.0), marks=pytest.mark.slow), (-90.0, 60.0)]
)
def test_a_shift_that_is_far_and_uneven_is_found(shift):
    """Nothing is found in the usual radius; from the start nearly all, to 0.1 px."""
    *pair, truth = uneven(shift)
    points = pick(pair[0], 100, sensed=pair[1])
    assert not register(*pair, points, refine="lsm").accepted.any()
    start, found = begun(pair)
    inside = grid(pair[0].shape, 40, 120)
    off = start.shifts(inside) - truth(inside)
    assert np.abs(off).max() < start.radius and nmad(off) < 0.5
    assert found.accepted.mean() > 0.8
    assert np.median(np.hypot(*errors(found, truth).T)) < 0.1
    assert np.hypot(*errors(found, truth).T).max() < 1


@pytest.mark.slow
def test_no_data_and_an_offset_change_nothing_of_the_start():
    *pair, truth = uneven((18.0, -11.0))
    reference = np.ma.array(pair[0], mask=False)
    reference[200:260, 100:300] = np.ma.masked
    sensed = pair[1][30:, 20:].astype(float)
    sensed[350:400, 300:420] = np.nan
    start = approximate(reference, sensed, offset=(-20, -30))
    inside = grid(reference.shape, 40, 60)
    assert nmad(start.shifts(inside) - truth(inside)) < 0.5


def test_the_middle_of_a_reduced_pixel_is_not_that_of_its_first():
    """Of images that are left reduced: half a pixel would be missed."""
    scene = landsat().grey
    wide = np.hstack([scene[:600], scene[600:]])
    start = approximate(wide[20:, 31:], wide[:-20, :-31])
    assert start.scale == 2
    np.testing.assert_allclose(start.typical, (31, 20), atol=0.1)


def test_positions_at_random_agree_with_no_transformation():
    """Of 5000 draws of three points, the best has others beside them by chance."""
    random = np.random.default_rng(1)
    for _ in range(40):
        points = random.uniform(0, 400, (50, 2))
        places = points + random.uniform(-25, 25, points.shape)
        assert not len(_affine(points, places, 25))
    places[:12] = points[:12] @ [[1.01, 0.02], [-0.02, 0.99]] + (4, -9)
    assert set(range(12)) <= set(_affine(points, places, 25))


@pytest.mark.slow
def test_two_places_have_no_start():
    """However much is searched: of 15 pairs none agrees by chance."""
    scenes = landsat().grey, (50 * yellowstone().grey.astype(np.uint16))
    for i in range(15):
        x, y = np.random.default_rng(i).integers(0, 800, 2)
        parts = scenes[0][y : y + 300, x : x + 300], scenes[1][x : x + 300, y : y + 300]
        assert approximate(*parts) is None
    assert approximate(*(one[:30, :30] for one in scenes)) is None


def test_an_image_without_data_is_no_image():
    scene = landsat().grey[:200, :200]
    for pair, name in (
        ((scene, np.nan * scene), "sensed"),
        ((np.nan * scene, scene), "reference"),
    ):
        with pytest.raises(ValueError, match=f"{name} has no data"):
            approximate(*pair)


def seen(turn=0.0, times=1.0, flip=1, invert=0, size=500):
    """The middle of a scene, and the same turned, enlarged, mirrored or inverted."""
    scene, middle = landsat().grey, np.array([600.0, 580.0])
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    # From a pixel of the sensed image to the scene
    A = np.array([[c, s], [-s, c]]) @ np.diag([flip, 1]) / times
    M = np.column_stack([A, middle - A @ [size / 2, size / 2]])
    how = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    sensed = cv2.warpAffine(scene, M, (size, size), flags=how)
    return scene[330:830, 350:850], 40_000 - sensed if invert else sensed


@pytest.mark.parametrize(
    "how, words",
    [
        ({"turn": 34}, "turned by 34 degrees clockwise"),
        ({"turn": -12}, "turned by 12 degrees counter-clockwise"),
        ({"turn": 90}, "turned by 90 degrees clockwise"),
        ({"turn": 180}, "turned by 180 degrees "),
        ({"times": 1.2}, "1.20 times as large"),
        ({"flip": -1}, "mirrored, left to right"),
        ({"invert": 1}, "inverted, dark where the other is bright"),
        (
            {"turn": 200, "times": 0.8, "flip": -1, "invert": 1},
            "turned by 160 degrees counter-clockwise and 0.80 times as large and"
            " mirrored, left to right and inverted, dark where the other is bright",
        ),
    ],
)
def test_why_nothing_fits_is_said_with_a_cure_that_works(how, words, monkeypatch):
    """As it stands there, in Python; from features of reduced images."""
    monkeypatch.setattr("pgm_lab.registration.start.SMALL", 200)
    reference, sensed = seen(**how)
    told = cause(reference, sensed)
    assert f"the sensed image is {words}" in told
    cure = told.split("in Python, ")[1].removesuffix(".")
    again = eval(cure, {"cv2": cv2, "np": np, "sensed": sensed})
    found = register(reference, again, pick(reference, 60, sensed=again), refine="lsm")
    assert found.accepted.mean() > 0.5
    assert np.hypot(*np.median(found.shifts[found.accepted], axis=0)) < 0.1


def test_no_cause_is_named_where_there_is_none():
    """Images that lie alike, however noisy, or have nothing in common or no texture."""
    *pair, _ = uneven((18.0, -11.0), noise=200.0, blur=1.0, gamma=0.6)
    assert cause(*pair) == ""
    one, other = landsat().grey[:400, :400], yellowstone().grey[:400, :400]
    assert cause(one, other) == cause(one, 0.0 * one) == cause(one > 9000, one) == ""
    assert cause(one[:12, :12], one[:12, :12]) == cause(one, np.nan * one) == ""


def test_chance_is_what_one_of_a_hundred_wrong_places_reaches():
    """Of an image and noise, as many positions as the search has give that r."""
    scene = landsat().grey[:600, :600]
    noise = np.random.default_rng(1).normal(size=scene.shape)
    points = pick(scene, 400)
    least = chance(scene, noise, points, points, 21, 3)
    found = register(scene, noise, points, threshold=-1)
    assert np.mean(found.r > least) == pytest.approx(0.01, abs=0.01)


@pytest.mark.parametrize(
    "how",
    [{"blur": 1.0, "gamma": 0.6}, {"noise": 60.0}],
)
@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [0.0, 3.0])
def test_errors_are_as_predicted_where_light_sharpness_and_shift_differ(how, amplitude):
    """The residuals alone predict twice as much with another sharpness."""
    *pair, truth = uneven((6.3, -4.6), amplitude, **how)
    found = begun(pair, 150)[1]
    z = errors(found, truth) / found.sd[found.accepted][:, None]
    assert found.accepted.sum() > 80
    assert 0.8 < nmad(z) < 1.25
    assert np.mean(np.abs(z) > 3) < 0.05


@pytest.mark.slow
def test_a_local_model_follows_the_shift_and_says_how_closely():
    *pair, truth = uneven((3.0, -2.0))
    found = begun(pair, 400)[1]
    model = fit(found, "local")
    inside = grid(pair[0].shape, 23, 50)
    off = model.apply(inside) - inside - truth(inside)
    left = model.residuals[model.used]
    assert nmad(off) < 0.1 < 1.0 < nmad(fit(found, "affine").residuals[found.accepted])
    assert 0.5 < nmad(off / model.sd_at(inside)) < 1.25
    assert nmad(off) < 2 * nmad(left)  # what a point left out says of the field
    # Resampled by it, the images lie on each other
    again = resample(pair[1], model, pair[0].shape)
    after = register(pair[0], again, inside, refine="lsm")
    length = np.hypot(*after.shifts[after.accepted].T)
    assert after.accepted.mean() > 0.8 and np.median(length) < 0.15
