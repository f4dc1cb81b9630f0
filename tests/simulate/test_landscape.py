"""The landscape: what stands where, in which light, and which heights are true."""

import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from pgm_lab.simulate import landscape
from pgm_lab.simulate.landscape import (
    AZIMUTH,
    BUILDING,
    ELEVATION,
    OPEN,
    TREE,
    _shadow,
)

BOX = (-60.0, -40.0, 60.0, 40.0)


@pytest.fixture(scope="module")
def land():
    return landscape(BOX, cell=0.2)


def test_ground_has_the_relief_asked_for_and_its_corner_and_size(land):
    assert land.dtm.min() == 0
    assert land.dtm.max() == pytest.approx(40)
    assert land.dsm.shape == (400, 600)
    assert land.corner == pytest.approx((-59.9, 39.9))


def test_objects_stand_on_the_ground_and_open_ground_is_bare(land):
    higher = land.dsm - land.dtm
    assert np.abs(higher[land.kind == OPEN]).max() == 0
    assert higher[land.kind == BUILDING].min() > 2
    assert higher[land.kind == TREE].min() >= 0.5 - 1e-4
    assert higher.max() < 25


def test_open_mixed_and_wooded_ground_lie_side_by_side(land):
    X = land.corner[0] + land.cell * np.arange(land.kind.shape[1])
    zone = land.zone(X)
    assert list(zone[[0, 300, 599]]) == [0, 1, 2]
    trees = [(land.kind[:, zone == k] == TREE).mean() for k in range(3)]
    assert trees[0] < 0.06 < trees[1] < 0.25 < 0.4 < trees[2] < 0.8


def test_so_many_trees_and_houses_as_asked_for():
    bare = landscape(BOX, cell=0.5, buildings=0, trees=0)
    assert not bare.kind.any()
    assert (bare.dsm == bare.dtm).all()
    one = landscape(BOX, cell=0.25, buildings=0, trees=1)
    n, _ = cv2.connectedComponents(one.kind)
    assert n == 2


def test_heights_between_the_cells_are_bilinear_as_scipy_has_them(land):
    rng = np.random.default_rng(1)
    X, Y = rng.uniform(-59.8, 59.8, 500), rng.uniform(-39.8, 39.8, 500)
    at = [(39.9 - Y) / 0.2, (X + 59.9) / 0.2]
    expected = map_coordinates(land.dsm.astype(float), at, order=1)
    np.testing.assert_allclose(land.at(land.dsm, X, Y), expected, atol=2e-5)
    nearest = land.at(land.kind, X, Y, cv2.INTER_NEAREST)
    np.testing.assert_array_equal(nearest, land.kind[tuple(np.rint(at).astype(int))])


def test_shadow_of_a_pole_falls_away_from_the_sun_as_long_as_it_is_high():
    dsm = np.zeros((120, 120), np.float32)
    dsm[60:63, 60:63] = 10
    dark = _shadow(dsm, 0.25) > 0.1
    rows, columns = np.nonzero(dark)
    end = np.argmax(np.hypot(rows - 61, columns - 61))
    right, up = (columns[end] - 61) * 0.25, (61 - rows[end]) * 0.25
    assert np.hypot(right, up) == pytest.approx(10 / np.tan(ELEVATION), abs=0.8)
    assert np.arctan2(-right, -up) % (2 * np.pi) == pytest.approx(AZIMUTH, abs=0.08)
