"""Pixels without data: masked, NaN or infinite. What touches them is named."""

import tracemalloc

import numpy as np
import pytest

from pgm_lab import lsm, simulate

AFFINE = (1.3, 1.01, 0.02, -0.8, -0.015, 0.99)
REACH = 10 + 8  # half a window of 21 pixels, and what a derivative at its edge rests on


@pytest.fixture(scope="module")
def pair():
    texture = simulate.texture(0.2, seed=4)
    return simulate.texture_pair(texture, (260, 250), AFFINE, sigma=1.0, dtype=np.uint8)


@pytest.fixture(scope="module")
def points():
    at = np.arange(32.0, 220, 9)
    return np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)


def transformed(points):
    T = np.reshape(AFFINE, (2, 3))
    return T[:, 0] + points @ T[:, 1:].T


def touching(points, hole, reach):
    """Whether the square around each point touches a pixel (column, row)."""
    return np.abs(np.rint(points) - hole).max(axis=1) <= reach


def holed(image, kind, holes):
    """The image with some pixels (column, row) that have no data."""
    column, row = np.transpose(holes)
    if kind in ("masked", "masked float"):
        mask = np.zeros(image.shape, bool)
        mask[row, column] = True
        grey = image.astype(float) if kind == "masked float" else image.copy()
        grey[row, column] = 0  # as a file has it where nothing was seen
        return np.ma.array(grey, mask=mask, fill_value=0)
    image = image.astype(np.float32)
    image[row, column] = {"nan": np.nan, "infinite": np.inf, "minus": -np.inf}[kind]
    return image


@pytest.fixture(scope="module")
def plain(pair, points):
    """The same matches where all pixels have data."""
    return lsm.match(*pair, points, np.rint(transformed(points)))


KINDS = "masked", "masked float", "nan", "infinite", "minus"


@pytest.mark.parametrize("kind", KINDS)
def test_templates_that_touch_no_data_are_named_and_the_rest_is_matched_as_without(
    pair, points, plain, kind
):
    left, right = pair
    start = np.rint(transformed(points))
    holes = [(100, 90), (170, 200)]
    assert plain.accepted.all()
    found = lsm.match(holed(left, kind, holes), right, points, start)
    touched = touching(points, holes[0], REACH) | touching(points, holes[1], REACH)
    assert set(found.status[touched]) == {"no data in the template"}
    assert np.isnan(found.points[touched]).all()
    assert found.accepted[~touched].all()
    np.testing.assert_allclose(
        found.points[~touched], plain.points[~touched], rtol=0, atol=1e-5
    )
    np.testing.assert_allclose(
        found.covariance[~touched], plain.covariance[~touched], rtol=1e-3, atol=1e-8
    )


@pytest.mark.parametrize("kind", KINDS)
def test_right_windows_that_touch_no_data_are_named_and_the_rest_is_matched_as_without(
    pair, points, plain, kind
):
    left, right = pair
    truth = transformed(points)
    start = np.rint(truth)
    hole = (100, 90)
    found = lsm.match(left, holed(right, kind, [hole]), points, start)
    named = found.status == "no data in the window"
    # A corner moves by half a pixel on the way, and interpolation takes one more
    assert named[touching(truth, hole, REACH - 1)].all()
    assert not named[~touching(truth, hole, REACH + 3)].any()
    assert np.all(named | found.accepted)
    assert np.isnan(found.points[named]).all()
    np.testing.assert_allclose(
        found.points[~named], plain.points[~named], rtol=0, atol=1e-5
    )


def test_a_window_that_comes_to_no_data_on_its_way_is_named(pair):
    left, right = pair
    truth = transformed([(100.0, 100.0)])
    bad = right.astype(float)
    bad[:, : int(truth[0, 0]) - 17] = np.nan
    found = lsm.match(left, bad, [(100, 100)], truth + (2.6, 0))
    assert found.status[0] == "no data in the window"
    assert found.iterations[0] > 1
    assert lsm.match(left, right, [(100, 100)], truth + (2.6, 0)).accepted[0]


def test_an_image_without_any_data_matches_nothing(pair):
    left, right = pair
    nothing = np.ma.masked_all(left.shape, np.uint8)
    at = [(100.0, 100.0)]
    assert lsm.match(nothing, right, at).status[0] == "no data in the template"
    assert lsm.match(left, nothing, at).status[0] == "no data in the window"
    empty = np.full(left.shape, np.nan)
    assert lsm.match(empty, right, at).status[0] == "no data in the template"
    assert lsm.match(left, empty, at).status[0] == "no data in the window"


@pytest.mark.parametrize("kind", [np.uint8, np.float32, np.float64, "masked"])
def test_memory_goes_by_points_and_not_by_pixels(pair, kind):
    """Ten points in 400 million pixels, most of which are never fetched."""
    masked = kind == "masked"
    size = 20_000
    images = []
    for part in pair:
        image = np.zeros((size, size), np.uint8 if masked else kind)
        image[9000:9260, 9000:9250] = part
        if masked:
            image = np.ma.array(image, mask=np.zeros((size, size), bool))
        images.append(image)
    points = np.random.default_rng(1).integers(40, 200, (10, 2)).astype(float)
    tracemalloc.start()
    try:
        found = lsm.match(*images, points + 9000, transformed(points) + 9000)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert found.accepted.all()
    assert peak < 5e6
