"""Two photos in, conjugate points out, with the truth known."""

import cv2
import numpy as np
import pytest
from PIL import Image

from pgm_lab import datasets, lsm, matching, ncc, simulate
from pgm_lab.matching import STATUSES, _starts
from tests.matching import scenes

LEFT, RIGHT, H = scenes.warped()
SMALL = scenes.warped(size=(280, 360))


def errors(found, H=H):
    """Distance (n,) of the points from their truth."""
    return np.hypot(*(found.points - scenes.apply(H, found.chosen)).T)


def whole(found):
    """Nothing that was accepted lacks a number, and nothing else has one."""
    good = found.accepted
    for values in (found.points, found.covariance, found.shape):
        values = values.reshape(len(good), -1)
        assert np.all(np.isfinite(values[good])) and np.all(np.isnan(values[~good]))
    judged = good | (found.status == "parts disagree")
    np.testing.assert_array_equal(np.isfinite(found.quality), judged)
    assert set(found.status) <= set(STATUSES)
    assert np.all(np.isfinite(found.r[good]))
    return found


def test_an_ordinary_pair_is_matched_turned_by_10_degrees_and_scaled_by_1_2():
    found = whole(matching.match(LEFT, RIGHT))
    e = errors(found)
    assert len(found.chosen) == 200
    assert np.sum(e <= 1) >= 190  # asked are 150
    assert np.sum(e > 1) <= 1  # asked are 5
    assert np.nanmedian(e) < 0.03
    sd = np.sqrt(found.covariance[:, [0, 1], [0, 1]])
    off = (found.points - scenes.apply(H, found.chosen)) / sd
    assert 0.8 < np.sqrt(np.nanmean(np.clip(off, -5, 5) ** 2)) < 1.5
    # Derivatives of the transformation, by differences
    J = [(scenes.apply(H, found.chosen + d) - scenes.apply(H, found.chosen - d)) / 0.2
         for d in ([0.1, 0], [0, 0.1])]  # fmt: skip
    assert np.nanmax(abs(found.shape - np.stack(J, axis=-1))) < 0.1
    assert found.left_size == found.right_size == (700, 500)


def test_the_same_photos_give_the_same_points():
    one = matching.match(*SMALL[:2], number=40)
    cv2.setRNGSeed(7)
    other = matching.match(*SMALL[:2], number=40)
    for name, values in vars(one).items():
        np.testing.assert_array_equal(values, getattr(other, name))


@pytest.mark.parametrize(
    "angle", [pytest.param(90.0, marks=pytest.mark.slow), 180.0, -37.0]
)
def test_any_turn_is_found_by_features(angle):
    left, right, H = scenes.warped(angle, 0.8, size=(300, 400))
    found = whole(matching.match(left, right, number=60))
    e = errors(found, H)
    assert np.sum(e <= 1) >= 55 and not np.any(e > 1)


def test_a_pyramid_that_leads_astray_is_refused(monkeypatch):
    grey = datasets.yellowstone().grey[:400, :500]
    noisy = simulate.photograph(np.roll(grey, 9).astype(float), 9.0, 1)
    with pytest.raises(ValueError, match="only 0 of 200 points of the pyramid"):
        matching.match(grey, noisy, start="pyramid", threshold=1.0)
    some = lambda p, q, _: (np.arange(len(p)) % 5 > 0, None)  # noqa: E731
    monkeypatch.setattr(_starts, "fitting", some)
    with pytest.raises(ValueError, match="of the pyramid fit together"):
        matching.match(grey[:, :-9], grey[:, 9:], start="pyramid")


@pytest.mark.parametrize("shift", [(230, -110), (0, 0)])
def test_a_large_shift_is_found_by_the_pyramid(shift):
    grey = datasets.yellowstone().grey
    column, row = np.array([300, 200]) - shift
    left = grey[200:700, 300:1000]
    right = np.ascontiguousarray(grey[row : row + 500, column : column + 700])
    found = whole(matching.match(left, right, number=80, start="pyramid"))
    assert np.mean(found.accepted) > 0.95
    assert np.nanmax(np.abs(found.points - found.chosen - shift)) < 0.01


def test_start_values_and_shapes_of_ones_own_are_taken():
    points = np.array([(300.0, 200), (350.25, 260), (420, 300)])
    start = scenes.apply(H, points) + [2, -3]
    shape = H[:2, :2]
    found = whole(matching.match(LEFT, RIGHT, points, start=start, shape=shape))
    assert np.all(errors(found) < 0.1)
    without = matching.match(LEFT, RIGHT, points, start=start)
    assert np.all(found.r > without.r - 1e-3) and not without.accepted.all()
    np.testing.assert_array_equal(found.chosen, points)


def test_real_photos_from_two_places_are_matched():
    """With edges in depth, where what is left after the limit for quality is right."""
    pair = datasets.motorcycle()
    found = whole(matching.match(pair.left, pair.right))
    column, row = np.rint(found.chosen).astype(int).T
    truth = found.chosen[:, 0] - pair.disparity[row, column]
    known = np.isfinite(truth) & found.accepted
    off = np.abs(found.points[:, 0] - truth)[known]
    assert known.sum() > 80
    assert np.mean(off > 1) <= 0.05
    assert np.median(off) < 0.2  # the truth is good to 0.1, and windows are not planes
    assert np.median(np.abs(found.points - found.chosen)[known, 1]) < 0.15


def test_photos_of_different_things_are_refused():
    grey = datasets.yellowstone().grey
    with pytest.raises(ValueError, match="fit together.*do both show the same"):
        matching.match(grey[:400, :400], datasets.motorcycle().left)
    with pytest.raises(ValueError, match="of the pyramid fit together"):
        matching.match(grey[:400, :400], grey[900:1300, 900:1300], start="pyramid")
    with pytest.raises(ValueError, match="left shows no texture"):
        matching.match(np.zeros((90, 90)), np.ones((90, 90)))


def test_files_and_images_of_pillow_are_matched_as_arrays_are(tmp_path):
    points = [(150, 100), (190, 130)]
    expected = matching.match(*SMALL[:2], points)
    left, right = (
        Image.fromarray(np.asarray(one).round().astype(np.uint8)) for one in SMALL[:2]
    )
    left.save(tmp_path / "left.png")
    right.convert("RGB").save(tmp_path / "right.png")
    found = matching.match(tmp_path / "left.png", tmp_path / "right.png", points)
    np.testing.assert_allclose(found.points, expected.points, atol=0.05)
    again = matching.match(left, str(tmp_path / "right.png"), points)
    np.testing.assert_array_equal(again.points, found.points)


def test_16_bits_give_the_same_as_8():
    left, right = (np.asarray(one).round().astype(np.uint8) for one in SMALL[:2])
    found = matching.match(left, right, number=50)
    deep = matching.match(left * np.uint16(257), right * np.uint16(257), number=50)
    np.testing.assert_array_equal(deep.chosen, found.chosen)
    assert np.sum(deep.accepted & found.accepted) >= 49
    assert np.nanmax(np.abs(deep.points - found.points)) < 0.01


def test_points_are_picked_where_both_photos_show_them():
    right = RIGHT[:, :350]
    found = matching.match(LEFT, right, number=60)
    there = scenes.apply(H, found.chosen)
    assert len(there) == 60 and np.all(there[:, 0] < 350) and np.all(there > 0)


def test_a_point_has_the_first_thing_that_went_wrong():
    left, right = np.array(LEFT), np.array(LEFT[:, 20:])
    left[200:260, 200:260] = 70
    right[300:400, 300:400] = 255
    left = np.ma.array(left, mask=np.zeros(left.shape, bool))
    right = np.ma.array(right, mask=np.zeros(right.shape, bool))
    left.mask[410, 60:80] = True
    right.mask[400:480, 450:600] = True
    known = {
        (3, 3): "template leaves the image",
        (230, 230): "flat template",
        (70, 400): "no data in the template",
        (540, 440): "no data in the window",
        (370, 350): "flat window",
        (29, 150): "peak on the edge of the image",  # its window would begin at -1
        (510, 389): "peak on the edge of the image",  # without data, that is
        (1, 150): "template leaves the image",
        (11, 150): "window leaves the image",
        (600, 100): "accepted",
    }
    points = np.array(list(known))
    found = whole(matching.match(left, right, points, start=points - [20, 0]))
    assert dict(zip(known, found.status.tolist())) == known
    away = matching.match(left, right, [(600, 100)], start=[(563, 100)])
    assert away.status[0] == "peak on the border of the search"
    assert away.r[0] < 1 and np.isnan(away.points).all()


def test_masked_pixels_cost_only_the_points_whose_windows_touch_them():
    left, right, H = scenes.warped(size=(400, 560))
    mask = np.zeros(right.shape, bool)
    mask[100:300, 250:400] = True
    holes = np.where(mask, np.nan, right)
    found = whole(matching.match(left, np.ma.array(right, mask=mask), number=100))
    e, there = errors(found, H), scenes.apply(H, found.chosen)
    column, row = np.rint(there).astype(int).T
    assert not np.any(found.accepted & mask[row, column]) and not np.any(e > 1)
    # 28 px: how far a corner of the turned window lies from its middle, and some more
    clear = np.all(abs(there - [324.5, 199.5]) > 0, axis=1)
    outside = np.any(abs(there - [324.5, 199.5]) > np.array([75, 100]) + 28, axis=1)
    assert clear.any() and np.mean(found.accepted[outside]) > 0.97
    again = matching.match(left, holes, number=100)
    np.testing.assert_array_equal(again.points, found.points)
    masked = np.ma.array(left, mask=mask)
    found = whole(matching.match(masked, right, number=40))
    assert np.mean(found.accepted) > 0.95
    column, row = found.chosen.astype(int).T
    assert not mask[row, column].any()


def test_a_limit_for_quality_rejects_what_is_below_it():
    every = matching.match(*SMALL[:2], number=50, least_quality=0)
    limit = float(np.nanmedian(every.quality))
    some = whole(matching.match(*SMALL[:2], number=50, least_quality=limit))
    rejected = every.accepted & ~some.accepted
    assert rejected.sum() >= 20
    assert np.all(some.status[rejected] == "parts disagree")
    assert np.all(some.quality[rejected] < limit)
    assert np.all(some.quality[some.accepted] >= limit)


@pytest.mark.parametrize("module", [ncc, lsm])
def test_each_status_of_the_steps_is_explained(module):
    """The words of the docstrings, which the rooms below keep to."""
    said = module.Match.__doc__.partition("status :")[2]
    words = {part for part in said.replace("\n        ", " ").split('"')[1::2]}
    assert words and words <= set(STATUSES)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"left": "missing.png"}, "left, missing.png: there is no such file"),
        ({"right": np.zeros((20, 20))}, "right must have at least 21 x 21"),
        ({"start": [(1, 2)]}, r"start must have shape \(2, 2\)"),
        ({"points": None, "start": [(1, 2)]}, "points"),
        ({"shape": np.eye(2)}, "shape"),
        ({"start": [(1, 2)] * 2, "shape": 99 * np.eye(2)}, "shape must scale by"),
        ({"search": 21}, "search must be"),
        ({"template": 4}, "template must be an odd number"),
        ({"least_quality": 1.5}, "least_quality must"),
        ({"number": 0, "points": None}, "number must be"),
    ],
)
def test_bad_arguments_are_named(changes, message):
    good = dict(left=SMALL[0], right=SMALL[1], points=[(150, 100), (190, 130)])
    with pytest.raises((ValueError, OSError), match=message):
        matching.match(**(good | changes))
