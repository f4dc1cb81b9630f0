"""Gridding: exact on a plane, nothing invented, clear limits."""

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from pgm_lab import stereo
from pgm_lab.stereo.grid import SOURCES

ALL = (0, 0, 30, 20)


def plane(x, y):
    return 0.3 * x - 0.2 * y + 5


def scattered(n=3000, seed=1):
    xy = np.random.default_rng(seed).random((n, 2)) * ALL[2:]
    return np.column_stack([xy, plane(*xy.T)])


def largest_error(surface):
    """Of cells whose middles lie well inside the hull."""
    return np.abs(surface.z - plane(*surface.grid()))[1:-1, 1:-1].max()


def test_a_plane_is_met_exactly_by_any_number_of_points_a_cell_and_far_away():
    for cell in (0.3, 1.0, 4.0):
        whole = stereo.surface(scattered(), cell, largest_gap=np.inf)
        assert largest_error(whole) < 1e-9
    away = np.array([4.3e5, 9.1e6])
    far = stereo.surface(
        scattered() + (*away, 0), 1.0, extent=(*away, *(away + (30, 20)))
    )
    near = stereo.surface(scattered(), 1.0, extent=ALL)
    assert np.allclose(far.z, near.z, atol=1e-6)


def test_one_point_a_cell_is_the_linear_interpolation_of_all_points():
    rng = np.random.default_rng(3)
    columns, rows = np.meshgrid(np.arange(20), np.arange(12))
    cells = np.stack([columns, rows], -1).reshape(-1, 2)
    xy = cells + rng.uniform(0.01, 0.99, (240, 2))
    points = np.column_stack([xy, rng.normal(0, 1, 240)])
    surface = stereo.surface(points, 1.0, extent=(0, 0, 20, 12))
    expected = LinearNDInterpolator(points[:, :2], points[:, 2])(*surface.grid())
    inside = np.isfinite(expected)
    assert inside.mean() > 0.8 and (surface.n == 1).all()
    assert np.allclose(surface.z[inside], expected[inside], atol=1e-9)


def test_rows_fall_and_the_corner_is_the_middle_of_the_first_cell():
    surface = stereo.surface(scattered(), 0.5, extent=ALL)
    assert surface.z.shape == (40, 60) and surface.corner == (0.25, 19.75)
    X, Y = surface.grid()
    assert (X[0, 0], Y[0, 0]) == surface.corner
    assert (X[-1, -1], Y[-1, -1]) == (29.75, 0.25)


def test_the_point_of_median_height_stands_for_its_cell_and_a_blunder_does_not():
    x, y = np.meshgrid(np.arange(5) + 0.5, np.arange(4) + 0.5)
    centres = np.stack([x, y, plane(x, y)], -1).reshape(-1, 3)
    columns = [centres + (0, 0, dz) for dz in (-5.0, 0.0, 0.2, 30.0)]
    surface = stereo.surface(np.concatenate(columns), 1.0, extent=(0, 0, 5, 4))
    assert np.allclose(surface.z, plane(*surface.grid()) + 0.1)
    points = scattered()
    points[::60, 2] += 50
    assert largest_error(stereo.surface(points, 2.0)) < 0.5  # some 20 points a cell


def test_nothing_is_invented_outside_the_hull():
    points = scattered()
    triangle = points[points[:, 0] / 30 + points[:, 1] / 20 < 1]
    surface = stereo.surface(triangle, 0.5, extent=ALL, largest_gap=np.inf)
    X, Y = surface.grid()
    beyond = X / 30 + Y / 20 > 1.05
    assert np.isnan(surface.z[beyond]).all()
    assert (surface.source[beyond] == SOURCES.index("outside the points")).all()
    assert np.isfinite(surface.z[X / 30 + Y / 20 < 0.9]).mean() > 0.99


def test_gap_wider_than_the_largest_stays_empty_and_a_smaller_one_is_filled():
    points = scattered()
    pond = np.hypot(points[:, 0] - 15, points[:, 1] - 10) < 4
    for largest, name in (
        (np.inf, "interpolated"), (12.0, "interpolated"), (3.0, "gap too wide"),
    ):  # fmt: skip
        surface = stereo.surface(points[~pond], 0.5, largest_gap=largest)
        X, Y = surface.grid()
        middle = np.hypot(X - 15, Y - 10) < 1.5
        assert (surface.source[middle] == SOURCES.index(name)).all()
        assert np.isfinite(surface.z[middle]).all() == (name == "interpolated")


@pytest.mark.parametrize("cell", [0.25, 1.0, 2.0])
@pytest.mark.parametrize("density", [1, 4])
def test_gaps_of_four_spacings_are_filled_whatever_the_cell(cell, density):
    """Points at random; a brook is narrower than four spacings, a river wider."""
    x, y = np.random.default_rng(5).random((2, density * 2400)) * [[60], [40]]
    gap = max(4 / np.sqrt(density), 2 * cell)
    narrow = np.abs(x - 20) < 0.25 * gap
    wide = np.abs(x - 40) < 0.65 * gap + 2 * cell
    points = np.column_stack([x, y, plane(x, y)])[~narrow & ~wide]
    surface = stereo.surface(points, cell, extent=(0, 0, 60, 40))
    assert surface.largest_gap == pytest.approx(gap, rel=0.3)
    rim = max(round(gap / cell), 2)  # where the triangles are long
    assert np.isfinite(surface.z[rim:-rim, round(20 / cell)]).all()
    assert np.isnan(surface.z[:, round(40 / cell)]).all()


def test_what_lies_beyond_a_wide_gap_or_a_bay_moves_no_height_on_this_side():
    points = scattered()
    x, y = points[:, 0], points[:, 1]
    points[:, 2] = np.where(x < 15, 10.0, 50.0)
    lake = (np.abs(x - 15) < 5) & (y > 6) | (x > 12) & (y < 6)
    surface = stereo.surface(points[~lake], 0.5, extent=ALL)
    known = np.isfinite(surface.z)
    assert np.isin(surface.z[known].round(9), (10.0, 50.0)).all()
    assert known.mean() > 0.5


def test_a_tile_is_a_part_of_the_whole_also_where_a_gap_crosses_its_edge():
    points = scattered(900)
    points = points[np.abs(points[:, 0] - 15) > 0.8]  # a river, and the edge is in it
    whole = stereo.surface(points, 0.25, extent=ALL, largest_gap=3.0)
    tile = stereo.surface(points, 0.25, extent=(0, 0, 15, 20), largest_gap=3.0)
    assert np.allclose(tile.z, whole.z[:, :60], equal_nan=True)
    assert 0 < np.isnan(whole.z).mean() < 0.5


def test_the_share_that_is_filled_is_said():
    z = np.array([[1.0, 2, 3, np.nan], [4, 5, 6, 7]])
    measured = np.array([[True, False, True, False], [True] * 4])
    for gap, words in (
        (None, "interpolated"), (3.0, "in gaps of up to 3 m"),
        (np.inf, "in gaps of any width"),
    ):  # fmt: skip
        surface = stereo.Surface(z, (0, 0), 1.0, measured, largest_gap=gap)
        assert surface.filled == pytest.approx(1 / 7)
        assert surface.message.startswith("88% of the cells have a height; 14% of")
        assert surface.message.endswith(words)


def test_number_and_spread_of_the_points_in_each_cell():
    heights = [1.0, 2, 4, 7, 7, 9]
    places = [(0.5, 0.5), (0.4, 0.5), (0.6, 0.6), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5)]
    points = np.column_stack([places, heights])
    surface = stereo.surface(points, 1.0, extent=(0, 0, 2, 2))
    assert np.array_equal(surface.n, [(1, 1), (3, 1)])
    assert surface.sd[1, 0] == pytest.approx(np.std([1, 2, 4], ddof=1))
    assert np.isnan(surface.sd[0, 0]) and surface.measured.all()
    corners = [(0.0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]  # in the last cells
    assert np.array_equal(stereo.surface(corners, 1.0).n, [(1, 1), (1, 1)])


def test_duplicates_and_rows_with_nan_change_nothing():
    points = scattered(300)
    more = np.concatenate([points, points, [(np.nan, 1, 1), (3, 3, np.nan)]])
    one, other = (stereo.surface(p, 0.5, largest_gap=2.0) for p in (points, more))
    assert np.array_equal(one.z, other.z, equal_nan=True)


THREE = [(0.0, 0, 0), (1, 0, 1), (0, 1, 5)]


@pytest.mark.parametrize(
    ("points", "how", "message"),
    [
        (THREE[:2], {"cell": 0.1}, "three points or more; got 2"),
        ([(k, k, k**2) for k in range(4)], {"cell": 0.1}, "on one line"),
        (THREE, {"cell": 10.0}, "take smaller cells"),
        (THREE, {"cell": 1e-5}, "larger cells or a smaller extent"),
        (THREE, {"cell": 1.0, "extent": (30, 0, 0, 20)}, "X least, Y least"),
    ],
)
def test_what_no_surface_can_be_made_of(points, how, message):
    with pytest.raises(ValueError, match=message):
        stereo.surface(points, **how)
