"""Chips found by Pearson's correlation, against other programs, and what fails."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import pearsonr

from pgm_lab import datasets, matching, simulate
from pgm_lab.registration import register

SCENE = datasets.landsat().grey[300:500, 200:420]
POINTS = np.array([(x, y) for x in range(30, 191, 32) for y in range(30, 171, 28)])
TEXTURE = simulate.texture(0.3, contrast=30.0, seed=5)


def moved(image, dx, dy):
    """The image with all that it shows (dx, dy) farther right and down."""
    return np.roll(image, (dy, dx), axis=(0, 1))


def noisy(image, sigma=40.0, seed=0, gain=0.9):
    noise = np.random.default_rng(seed).normal(0, sigma, image.shape)
    return gain * image + 300 + noise


def shifts(found):
    return np.stack([found.dx, found.dy], axis=1)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32, float])
def test_r_is_pearsons(kind):
    """Of the very windows, by two other programs."""
    scale = 100 if kind == np.uint8 else 1
    reference = ((SCENE - SCENE.min()) / scale).clip(0, 255 * 257 / scale).astype(kind)
    sensed = noisy(moved(reference * 1.0, 2, -1), 40 / scale) - 300
    sensed = sensed.clip(0, 255 * 257 / scale).astype(kind)
    found = register(reference, sensed, POINTS, threshold=-1)
    assert found.accepted.sum() > 20
    for i in range(len(POINTS)):
        x, y = POINTS[i]
        u, v = (POINTS[i] + shifts(found)[i]).astype(int)
        a = reference[y - 10 : y + 11, x - 10 : x + 11].ravel().astype(float)
        b = sensed[v - 10 : v + 11, u - 10 : u + 11].ravel().astype(float)
        assert abs(found.r[i] - np.corrcoef(a, b)[0, 1]) < 1e-12
        assert abs(found.r[i] - pearsonr(a, b).statistic) < 1e-12


def test_shifts_are_those_of_opencv():
    sensed = noisy(moved(SCENE, -2, 1), 400.0)
    found = register(SCENE, sensed, POINTS, threshold=-1)
    for i, (x, y) in enumerate(POINTS):
        r = cv2.matchTemplate(
            sensed[y - 13 : y + 14, x - 13 : x + 14].astype(np.float32),
            SCENE[y - 10 : y + 11, x - 10 : x + 11].astype(np.float32),
            cv2.TM_CCOEFF_NORMED,
        )
        _, highest, _, (column, row) = cv2.minMaxLoc(r)
        assert (found.dx[i], found.dy[i]) == (column - 3, row - 3)
        assert abs(found.r[i] - highest) < 1e-4
    assert found.accepted.sum() > 20


@settings(max_examples=20)
@given(st.integers(-2, 2), st.integers(-2, 2), st.integers(-3, 3), st.integers(-3, 3))
def test_an_image_that_is_moved_has_its_shifts_moved(dx, dy, p, q):
    """By whole pixels; the points too, so that none of them nears an edge."""
    sensed = noisy(SCENE)
    before = register(SCENE, sensed, POINTS, radius=3)
    after = register(SCENE, moved(sensed, dx, dy), POINTS, radius=3)
    both = before.accepted & after.accepted
    assert both.sum() > 20
    np.testing.assert_array_equal(shifts(after)[both], shifts(before)[both] + (dx, dy))
    # And of the whole pair nothing is changed
    together = register(moved(SCENE, p, q), moved(sensed, p, q), POINTS + (p, q))
    np.testing.assert_array_equal(shifts(together), shifts(before))
    np.testing.assert_allclose(together.r, before.r, atol=1e-12)


@pytest.mark.parametrize("refine", [None, "parabola", "lsm"])
@settings(max_examples=20)
@given(st.floats(0.1, 20), st.floats(-1e4, 1e5))
def test_gain_and_offset_change_nothing(refine, gain, offset):
    sensed = noisy(moved(SCENE, 1, 2))
    few = POINTS[:6]
    one = register(SCENE, sensed, few, refine=refine)
    other = register(SCENE, gain * sensed + offset, few, refine=refine, noise=(1, gain))
    np.testing.assert_array_equal(other.status, one.status)
    np.testing.assert_allclose(other.r, one.r, atol=1e-9)
    np.testing.assert_allclose(shifts(other), shifts(one), atol=1e-3)


@pytest.mark.parametrize("refine", [None, "lsm"])
def test_images_exchanged_turn_the_sign(refine):
    sensed = noisy(moved(SCENE, 2, -1))
    there = register(SCENE, sensed, POINTS, refine=refine)
    back = register(sensed, SCENE, POINTS + (2, -1), refine=refine)
    both = there.accepted & back.accepted
    assert both.sum() > 20
    limit = 0 if refine is None else 0.01
    np.testing.assert_allclose(shifts(back)[both], -shifts(there)[both], atol=limit)


@pytest.mark.parametrize(
    ("refine", "limit"), [(None, 0.5), ("parabola", 0.12), ("lsm", 0.01)]
)
def test_a_part_of_a_pixel(refine, limit):
    pair = simulate.texture_pair(TEXTURE, (200, 220), (1.4, 1, 0, -0.7, 0, 1))
    found = register(*pair, POINTS, refine=refine)
    assert found.accepted.all()
    assert np.abs(shifts(found) - (1.4, -0.7)).max() <= limit


@pytest.mark.parametrize("refine", [None, "parabola", "lsm"])
def test_points_between_the_pixels(refine):
    """The chip lies around the nearest pixel; an ortho image has one shift for both."""
    sensed = moved(SCENE, 2, -1)
    one = register(SCENE, sensed, POINTS, refine=refine)
    other = register(SCENE, sensed, POINTS + (0.3, -0.4), refine=refine)
    np.testing.assert_allclose(shifts(other), shifts(one), atol=0.005)
    np.testing.assert_array_equal(other.points, POINTS + (0.3, -0.4))


@pytest.mark.parametrize("refine", [None, "lsm"])
def test_an_offset_is_not_part_of_the_shift(refine):
    """A sensed image that begins 17 columns and 9 rows farther, and is smaller."""
    sensed = moved(SCENE, 2, -1)
    whole = register(SCENE, sensed, POINTS, refine=refine)
    part = register(SCENE, sensed[9:, 17:190], POINTS, refine=refine, offset=(-17, -9))
    inside = part.accepted
    assert 15 < inside.sum() < len(POINTS)
    np.testing.assert_allclose(shifts(part)[inside], shifts(whole)[inside], atol=1e-3)
    assert set(part.status[~inside]) <= {
        "peak on the edge of the image",
        "window leaves the image",
        *(set(whole.status) - {"accepted"}),
    }
    # Of half a pixel as well
    half = register(SCENE, sensed, POINTS, refine=refine, offset=(0.5, 0.25))
    known = whole.accepted & half.accepted
    np.testing.assert_allclose(
        shifts(half)[known], shifts(whole)[known] - (0.5, 0.25), atol=1e-3
    )


@pytest.mark.parametrize("refine", [None, "parabola", "lsm"])
def test_no_data_is_told_in_three_ways(refine):
    sensed = moved(SCENE, 1, 1).astype(float)
    hole = np.zeros(SCENE.shape, bool)
    hole[60:90, 60:100] = True
    zero, nan = np.where(hole, 0, sensed), np.where(hole, np.nan, sensed)
    masked = np.ma.array(sensed, mask=hole)
    by_value = register(SCENE, zero, POINTS, refine=refine, nodata=0)
    for other in (nan, masked):
        found = register(SCENE, other, POINTS, refine=refine)
        np.testing.assert_array_equal(found.status, by_value.status)
        np.testing.assert_array_equal(found.dx, by_value.dx)
    lost = set(by_value.status)
    assert "no data in the window" in lost or "peak on the edge of the image" in lost
    in_reference = register(
        np.where(hole, 0, SCENE), sensed, POINTS, refine=refine, nodata=0
    )
    assert "no data in the template" in in_reference.status
    touching = np.array(
        [hole[y - 10 : y + 11, x - 10 : x + 11].any() for x, y in POINTS]
    )
    np.testing.assert_array_equal(
        in_reference.status == "no data in the template", touching
    )


def test_a_shift_as_large_as_the_radius_is_reported_but_not_accepted():
    found = register(SCENE, moved(SCENE, 3, 0), POINTS)
    assert set(found.status) == {"peak on the border of the search"}
    assert np.all(shifts(found) == (3, 0)) and np.all(found.r > 0.999)
    wider = register(SCENE, moved(SCENE, 3, 0), POINTS, radius=4)
    assert wider.accepted.sum() > 30 and np.all(shifts(wider)[wider.accepted] == (3, 0))


def test_the_statuses_of_single_chips():
    reference = SCENE.astype(float)
    reference[50:85, 50:85] = 7000  # flat
    y, x = np.indices(SCENE.shape)
    rows = 7000 + 900 * np.sin(np.pi / 2 * y + 0.5) + 300 * np.sin(x / 2)
    rows += 0.05 * (SCENE - SCENE.mean())
    reference[120:160, 60:110] = rows[120:160, 60:110]
    points = [(5, 50), (67, 67), (85, 140), (180, 100), (12, 100), (500, 20)]
    found = register(reference, moved(reference, 0, 1), points)
    assert list(found.status) == [
        "template leaves the image",
        "flat template",
        "ambiguous",
        "accepted",
        "accepted",
        "template leaves the image",
    ]
    assert (
        np.isnan(found.dx[[0, 1, 5]]).all() and np.isfinite(found.dx[[2, 3, 4]]).all()
    )
    assert set(found.status) <= set(matching.STATUSES)


def test_what_is_predicted_to_be_uncertain_is_not_accepted():
    """Weak texture under noise: r would let it pass, its precision does not."""
    weak = simulate.texture(0.08, contrast=10.0, waves=8, seed=5)
    pair = simulate.texture_pair(
        weak, (200, 220), (0.5, 1, 0, 0.25, 0, 1), sigma=1.0, seed=1
    )
    free = register(*pair, POINTS, refine="lsm", largest_sd=10.0)
    limit = np.nanmedian(free.sd)
    tight = register(*pair, POINTS, refine="lsm", largest_sd=limit)
    too_much = free.sd > limit
    assert 3 < too_much.sum() and 3 < tight.accepted.sum()
    assert np.all(tight.status[too_much & free.accepted] == "not precise enough")
    np.testing.assert_array_equal(tight.accepted, free.accepted & ~too_much)
    assert np.isnan(tight.covariance[too_much]).all()
    error = np.hypot(*(shifts(free) - (0.5, 0.25)).T)
    assert error[too_much].mean() > error[tight.accepted].mean()


def test_least_squares_matching_keeps_near_the_peak_or_fails():
    """Whatever it does, the shift stays within a pixel of the highest whole one."""
    sensed = noisy(moved(SCENE, 1, 0), 900.0)
    whole = register(SCENE, sensed, POINTS, threshold=0.2)
    fine = register(SCENE, sensed, POINTS, refine="lsm", threshold=0.2, largest_sd=10.0)
    assert np.abs(shifts(fine) - shifts(whole)).max() <= 1
    failed = whole.accepted & ~fine.accepted
    np.testing.assert_array_equal(shifts(fine)[failed], shifts(whole)[failed])


def test_nothing_of_the_arguments_is_changed():
    sensed, points = noisy(SCENE), POINTS.astype(float)
    before = SCENE.copy(), sensed.copy(), points.copy()
    register(SCENE, sensed, points, refine="lsm", nodata=0)
    for one, other in zip((SCENE, sensed, points), before, strict=True):
        np.testing.assert_array_equal(one, other)


def test_no_points_give_no_shifts():
    found = register(SCENE, SCENE, np.zeros((0, 2)), refine="lsm")
    assert found.dx.shape == (0,) and found.covariance.shape == (0, 2, 2)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensed": SCENE[:-1]}, "Cut both to the area.*offset="),
        ({"reference": np.dstack([SCENE] * 3)}, "Take one channel of a colour image"),
        ({"sensed": np.dstack([SCENE] * 4)}, "Take one channel of a colour image"),
        ({"chip": 20}, "chip must be an odd number of pixels"),
        ({"radius": 0}, "radius must be a whole number, at least 1"),
        ({"radius": 1.5}, "radius must be a whole number"),
        ({"refine": "spline"}, "refine must be one of 'parabola', 'lsm'"),
        ({"points": [(1, 2, 3)]}, "points"),
        ({"points": [(np.nan, 2)]}, "points"),
        ({"threshold": 2}, "threshold must lie between"),
        ({"ratio": 0}, "ratio must be above 0"),
        ({"largest_sd": 0}, "largest_sd"),
        ({"smooth": 9}, "smooth must be 0, or from 0.3 to 3 px"),
        ({"offset": (1, 2, 3)}, "offset"),
        ({"nodata": np.nan}, "nodata"),
        ({"noise": (-1, 1)}, "noise"),
    ],
)
def test_bad_arguments_are_told_with_what_to_do(changes, message):
    good = {"reference": SCENE, "sensed": SCENE, "points": POINTS}
    with pytest.raises(ValueError, match=message):
        register(**good | changes)
