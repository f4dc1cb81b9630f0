"""Two photos in, conjugate points out, with the truth known."""

import cv2
import numpy as np
import pytest
from PIL import Image

from pgm_lab import datasets, lsm, matching, ncc, simulate
from pgm_lab._robust import SD_OF_MAD
from pgm_lab.matching import STATUSES, _starts, _wide
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


@pytest.mark.slow
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


@pytest.mark.parametrize("start", ["features", "wide"])
def test_the_same_photos_give_the_same_points(start):
    one = matching.match(*SMALL[:2], number=40, start=start)
    cv2.setRNGSeed(7)
    other = matching.match(*SMALL[:2], number=40, start=start)
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


# --- Photos from places far apart ---


def apart():
    """The motorcycle from two places, the right photo turned and scaled, and truth."""
    pair, there = datasets.motorcycle(), np.s_[100:400, 200:620]
    disparity = pair.disparity[there]
    _, _, H = scenes.warped(30.0, 0.9, size=disparity.shape)
    H = H @ [[1, 0, -180], [0, 1, 0], [0, 0, 1.0]]
    right = cv2.warpPerspective(
        pair.right[100:400].astype(np.float32), H, (460, 380), flags=cv2.INTER_CUBIC
    )

    def truth(points):
        column, row = np.rint(points).astype(int).T
        off = np.stack([200 - disparity[row, column], np.zeros(len(points))], axis=1)
        return scenes.apply(H, points + off)

    return pair.left[there], simulate.photograph(right, 1.0, 3), truth


@pytest.mark.slow
def test_features_of_photos_from_far_apart_are_themselves_matched():
    """Between many edges in depth, where the default finds far fewer."""
    left, right, truth = apart()
    found = whole(matching.match(left, right, number=150, start="wide"))
    off = found.points - truth(found.chosen)
    good = np.hypot(*off.T) < 1.5
    by_default = matching.match(left, right, number=150)
    assert good.sum() > 1.5 * by_default.accepted.sum()
    assert np.sum(np.hypot(*off.T) >= 1.5) < 0.1 * good.sum()
    sd = np.sqrt(found.covariance[:, [0, 1], [0, 1]])
    assert 0.8 < SD_OF_MAD * np.median(np.abs(off / sd)[good]) < 1.25


def bent(bend):
    """Two photos, columns of the second bent as on a hill, and a disc moved down."""
    grey = datasets.yellowstone().grey[:300, :400].astype(np.float32)
    row, column = np.mgrid[:300, :400]
    x = column + 5 + bend * (column - 200) ** 2  # what the right photo shows there
    y = row - 4 * (np.hypot(column - 100, row - 100) < 40)
    right = cv2.remap(
        grey, x.astype(np.float32), y.astype(np.float32), cv2.INTER_CUBIC, borderMode=1
    )
    return simulate.photograph(grey, 1.0, 1), simulate.photograph(right, 1.0, 2)


@pytest.mark.slow
@pytest.mark.parametrize(("bend", "typical"), [(1e-9, 0.002), (1.2e-3, 0.05)])
def test_the_sd_of_features_contains_what_a_curved_surface_does(bend, typical):
    found = matching.match(*bent(bend), number=400, start="wide")
    x = 200 + (np.sqrt(1 - 4 * bend * (205 - found.chosen[:, 0])) - 1) / (2 * bend)
    off = found.points - np.stack([x, found.chosen[:, 1]], axis=1)
    good = np.hypot(*off.T) < 1
    assert good.sum() > 200
    sd = np.sqrt(found.covariance[:, 0, 0])
    assert np.median(sd[good]) == pytest.approx(typical, rel=0.3)
    assert 0.5 < SD_OF_MAD * np.median(np.abs(off[:, 0] / sd)[good]) < 1.25


def test_what_its_witnesses_deny_is_no_match_of_a_feature():
    left, right = bent(1e-9)
    p = np.array([(150.0, 180), (200, 120), (250, 200), (100, 105)] * 5)
    p[4:] += np.random.default_rng(1).uniform(-9, 9, (16, 2))
    q = p + [-5, 0]
    q[1] += [2.5, 0]  # a descriptor beside the match
    q[3] += [0, 4]  # a line beside it: the disc moved down
    right[190:211, 262:266] = np.nan  # so near that only small windows are without it
    rows = np.array([[0, 0, 0], [0, 0, -1.0], [0, 1, 0]])
    field = _starts.Field(p, q, 1.5, rows)
    found, _ = _wide.match(left, right, field, np.arange(4), 21, 0.7, 1.0, 0.5)
    assert list(found.status) == ["accepted", "diverged", "accepted", "diverged"]
    np.testing.assert_allclose(found.points[[0, 2]], p[[0, 2]] - [5, 0], atol=0.1)


def test_each_witness_counts_by_what_it_may_be_wrong():
    one = np.ones((2, 1))
    x, shape = np.array([[[0, 0.0]], [[0.5, 0]]]), np.tile(np.eye(2), (2, 1, 1, 1))
    tried = _wide.Tried(x, shape, shape, one, one, 0.5 * one)
    lines = np.array([[2.0, 0, 12]])  # 6 px away
    off = _wide._witnesses(tried, np.array([[0, 4.5]]), lines, 1.5, 0.5)
    np.testing.assert_allclose(off[:, 0, 1, 0], [2, 1, 3, 4])
    off = _wide._witnesses(tried, x[0], None, 1.5, None)
    np.testing.assert_allclose(off[:, 0, :, 0].max(axis=0), [np.inf, 2])  # not its own


def test_a_feature_has_the_window_that_most_others_confirm(monkeypatch):
    """Two wide ones agree, but three narrow ones elsewhere are more."""
    places = {21: 0.0, 15: 0.1, 11: 1.0, 9: 1.1, 7: 1.05}

    def found(left, right, points, start, shape, width, threshold):
        x, one = points + [places[width], 0], np.ones(len(points))
        C = np.tile(np.eye(2) / width**2, (len(points), 1, 1))
        status = np.full(len(x), "accepted", "<U40")
        return _wide.Tried(x, C, shape, one, status, 0 * one)

    monkeypatch.setattr(_wide, "_both_ways", found)
    p = np.random.default_rng(1).uniform(0, 99, (20, 2))
    field, k = _starts.Field(p, p), np.arange(4)
    tried, quality = _wide.match(None, None, field, k, 21, 0.7, 1.0, 0.5)
    np.testing.assert_allclose(tried.points, p[:4] + [1.0, 0])
    np.testing.assert_allclose(quality, 1 / (1 + (1 / 1.5) ** 2))
    places |= {15: 0.5, 11: 5.0, 7: 9.0}
    tried, quality = _wide.match(None, None, field, k, 21, 0.7, 1.0, 0.5)
    assert set(tried.status) == {"parts disagree"} and np.isnan(tried.points).all()
    np.testing.assert_allclose(quality, 1 / (1 + 2**2))


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
    with pytest.raises(ValueError, match="left shows no texture"):
        matching.match(np.zeros((90, 90)), np.ones((90, 90)))
    with pytest.raises(ValueError, match="a mirror image of the other"):
        matching.match(grey[:400, :400], grey[:400, 400::-1])


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


@pytest.mark.slow
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


@pytest.mark.slow
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
    outside = np.any(abs(there - [324.5, 199.5]) > np.array([75, 100]) + 28, axis=1)
    assert np.mean(found.accepted[outside]) > 0.97
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
        ({"start": "wide"}, "leave points out"),
        ({"start": "wide", "points": None, "template": 5}, "template must be"),
        ({"least_quality": 1.5}, "least_quality must"),
        ({"number": 0, "points": None}, "number must be"),
    ],
)
def test_bad_arguments_are_named(changes, message):
    good = dict(left=SMALL[0], right=SMALL[1], points=[(150, 100), (190, 130)])
    with pytest.raises((ValueError, OSError), match=message):
        matching.match(**(good | changes))
