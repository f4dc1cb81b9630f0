"""Points that are picked have texture, keep their distance and fill the photo."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from pgm_lab import datasets, image, lsm
from pgm_lab.matching import interest, pick

GREY = datasets.yellowstone().grey[:500, :700]


def texture(grey, points, template):
    """The smaller eigenvalue of the gradient matrix, point by point."""
    gx, gy = image.gradient(grey)
    found = []
    for point in points:
        x, y = (image.cut(g, point, template).ravel() for g in (gx, gy))
        found.append(np.linalg.eigvalsh(np.array([[x @ x, x @ y], [x @ y, y @ y]]))[0])
    return np.array(found)


def test_points_have_more_texture_than_those_of_a_lattice():
    points = pick(GREY, 150)
    assert points.shape == (150, 2) and np.all(points == np.round(points))
    lattice = np.stack(np.meshgrid(np.arange(20, 680, 20), np.arange(20, 480, 20)), -1)
    other = texture(GREY, lattice.reshape(-1, 2), 21)
    found = texture(GREY, points, 21)
    assert np.median(found) > np.quantile(other, 0.8)
    assert found.min() > np.quantile(other, 0.05)
    order = np.argsort(-found)
    rank = np.empty(150)
    rank[order] = np.arange(150)
    assert np.corrcoef(rank, np.arange(150))[0, 1] > 0.9  # the best come first


def test_points_are_spread_over_the_photo():
    points = pick(GREY, 150)
    step = np.sqrt(GREY.size / 150)
    nearest = cKDTree(points).query(points, 2)[0][:, 1]
    assert nearest.min() >= step / 5
    whole = np.all(points < np.array((700, 500)) // (2 * step) * (2 * step), axis=1)
    cells = {tuple(one) for one in (points[whole] // (2 * step)).astype(int)}
    assert len(cells) == 7 * 5  # all that are four times the room of a point


def test_what_is_picked_can_be_matched_precisely():
    """Noise of 2 grey values moves no point by more than a tenth of a pixel."""
    rng = np.random.default_rng(2)
    noisy = GREY + rng.normal(0, 2, GREY.shape)
    found = lsm.match(GREY, noisy, pick(GREY, 100, 21))
    assert np.mean(found.accepted) > 0.97
    assert np.nanmedian(np.sqrt(found.covariance[:, [0, 1], [0, 1]])) < 0.05


@pytest.mark.parametrize("margin", [None, 40])
def test_templates_stay_in_the_photo_and_out_of_the_margin(margin):
    points = pick(GREY, 400, 15, margin=margin)
    least = 7 if margin is None else margin
    assert points.min() >= least
    assert np.all(points <= np.array([699, 499]) - least)
    assert points.min(axis=0).max() < least + 25  # but all that is left is used


def test_no_template_touches_what_has_no_data():
    mask = np.zeros(GREY.shape, bool)
    mask[:, 300:420] = True
    mask[250, 100] = True
    holes = np.where(mask, np.nan, GREY)
    masked = np.ma.array(GREY, mask=mask)
    points = pick(masked, 200)
    np.testing.assert_array_equal(points, pick(holes, 200))
    assert len(points) > 150
    status = lsm.match(masked, masked, points).status
    assert not {"no data in the template", "no data in the window"} & set(status)
    np.testing.assert_array_equal(pick(np.ma.array(GREY), 50), pick(GREY, 50))


def test_flat_and_lined_parts_have_no_points():
    grey = np.full((300, 300), 80, np.uint8)
    grey[:, 200:] = np.arange(300)[:, None] % 16  # lines: the same along the rows
    grey[40:120, 40:120] = GREY[:80, :80]
    points = pick(grey, 30)
    assert 0 < len(points) <= 30
    inside = np.all((points > 28) & (points < 132), axis=1)
    corner = points[~inside]  # where the lines end at the flat part
    assert np.all(abs(corner[:, 0] - 200) <= 12)
    assert len(pick(np.zeros((50, 60)), 10)) == 0


def test_tiles_change_nothing(monkeypatch):
    expected = pick(GREY, 100)
    monkeypatch.setattr(interest, "TILE", 1)
    np.testing.assert_array_equal(pick(GREY, 100), expected)


@given(
    st.tuples(st.integers(5, 40), st.integers(5, 40)),
    st.integers(1, 60),
    st.sampled_from([3, 5]),
    st.integers(0, 9),
)
def test_any_photo_gives_points_in_it(size, number, template, seed):
    grey = np.random.default_rng(seed).integers(0, 256, size, dtype=np.uint8)
    points = pick(grey, number, template)
    half = template // 2
    assert 0 < len(points) <= number
    assert np.all((points >= half) & (points <= np.array(size[::-1]) - 1 - half))
    assert len(np.unique(points, axis=0)) == len(points)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((GREY[:9], 5, 21), "image must have at least 21 x 21 pixels"),
        ((np.full((30, 30), np.nan), 5), "image has no data"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        pick(*arguments)
