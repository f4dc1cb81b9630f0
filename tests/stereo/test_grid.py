"""Gridding: exact on a plane, nothing invented, clear limits."""

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator

from pgm_lab import stereo
from pgm_lab.stereo.grid import SOURCES


def plane(x, y):
    return 0.3 * x - 0.2 * y + 5


def scattered(n=3000, size=(30.0, 20.0), seed=1):
    xy = np.random.default_rng(seed).random((n, 2)) * size
    return np.column_stack([xy, plane(*xy.T)])


def inner(surface):
    """Cells whose middles lie well inside the hull."""
    return (slice(1, -1), slice(1, -1)), surface.z[1:-1, 1:-1]


def test_plane_is_met_exactly_by_any_number_of_points_a_cell():
    for cell in (0.3, 1.0, 4.0):
        surface = stereo.surface(scattered(), cell)
        where, z = inner(surface)
        X, Y = surface.grid()
        assert np.allclose(z, plane(X, Y)[where], atol=1e-9)


def test_one_point_a_cell_is_the_linear_interpolation_of_all_points():
    rng = np.random.default_rng(3)
    columns, rows = np.meshgrid(np.arange(20), np.arange(12))
    xy = np.stack([columns, rows], -1).reshape(-1, 2) + rng.uniform(
        0.01, 0.99, (240, 2)
    )
    points = np.column_stack([xy, rng.normal(0, 1, 240)])
    surface = stereo.surface(points, 1.0, extent=(0, 0, 20, 12))
    X, Y = surface.grid()
    expected = LinearNDInterpolator(points[:, :2], points[:, 2])(X, Y)
    inside = np.isfinite(expected)
    assert inside.mean() > 0.8 and (surface.n == 1).all()
    assert np.allclose(surface.z[inside], expected[inside], atol=1e-9)


def test_rows_fall_and_the_corner_is_the_middle_of_the_first_cell():
    surface = stereo.surface(scattered(), 0.5, extent=(0, 0, 30, 20))
    assert surface.z.shape == (40, 60) and surface.corner == (0.25, 19.75)
    X, Y = surface.grid()
    assert (X[0, 0], Y[0, 0]) == surface.corner
    assert (X[-1, -1], Y[-1, -1]) == (29.75, 0.25)


def test_median_of_a_cell_does_not_follow_a_blunder():
    points = scattered()
    points[np.arange(0, 3000, 60), 2] += 50
    surface = stereo.surface(points, 2.0)  # some twenty points a cell
    X, Y = surface.grid()
    where, z = inner(surface)
    assert np.abs(z - plane(X, Y)[where]).max() < 0.5


def test_the_point_of_median_height_stands_for_its_cell():
    x, y = np.meshgrid(np.arange(5) + 0.5, np.arange(4) + 0.5)
    centres = np.stack([x, y, plane(x, y)], -1).reshape(-1, 3)
    columns = [centres + (0, 0, dz) for dz in (-5.0, 0.0, 0.2, 30.0)]
    surface = stereo.surface(np.concatenate(columns), 1.0, extent=(0, 0, 5, 4))
    assert np.allclose(surface.z, plane(*surface.grid()) + 0.1)


def test_nothing_is_invented_outside_the_hull():
    points = scattered()
    triangle = points[points[:, 0] / 30 + points[:, 1] / 20 < 1]
    surface = stereo.surface(triangle, 0.5, extent=(0, 0, 30, 20))
    X, Y = surface.grid()
    beyond = X / 30 + Y / 20 > 1.05
    assert np.isnan(surface.z[beyond]).all()
    assert (surface.source[beyond] == SOURCES.index("outside the points")).all()
    assert np.isfinite(surface.z[X / 30 + Y / 20 < 0.9]).mean() > 0.99


def test_gap_wider_than_the_largest_stays_empty_and_a_smaller_one_is_filled():
    points = scattered()
    pond = np.hypot(points[:, 0] - 15, points[:, 1] - 10) < 4
    for largest, filled in ((None, True), (12.0, True), (3.0, False)):
        surface = stereo.surface(points[~pond], 0.5, largest_gap=largest)
        X, Y = surface.grid()
        middle = np.hypot(X - 15, Y - 10) < 1.5
        assert np.isfinite(surface.z[middle]).all() == filled
        name = "interpolated" if filled else "gap too wide"
        assert (surface.source[middle] == SOURCES.index(name)).all()


def test_number_and_spread_of_the_points_in_each_cell():
    heights = [1.0, 2, 4, 7, 7, 9]
    places = [(0.5, 0.5), (0.4, 0.5), (0.6, 0.6), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5)]
    surface = stereo.surface(
        np.column_stack([places, heights]), 1.0, extent=(0, 0, 2, 2)
    )
    assert np.array_equal(surface.n, [(1, 1), (3, 1)])
    assert surface.sd[1, 0] == pytest.approx(np.std([1, 2, 4], ddof=1))
    assert np.isnan(surface.sd[0, 0]) and surface.measured.all()


def test_point_on_the_edge_belongs_to_the_last_cell():
    points = [(0.0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]
    surface = stereo.surface(points, 1.0)
    assert np.array_equal(surface.n, [(1, 1), (1, 1)])


def test_large_coordinates_do_not_lose_decimals():
    east, north = 4.3e5, 9.1e6
    z = stereo.surface(
        scattered() + (east, north, 0), 1.0, extent=(east, north, east + 30, north + 20)
    ).z
    near = stereo.surface(scattered(), 1.0, extent=(0, 0, 30, 20)).z
    assert np.allclose(z, near, atol=1e-6)


def test_duplicates_and_rows_with_nan_change_nothing():
    points = scattered(300)
    more = np.concatenate([points, points, [(np.nan, 1, 1), (3, 3, np.nan)]])
    one, other = stereo.surface(points, 0.5), stereo.surface(more, 0.5)
    assert np.array_equal(one.z, other.z, equal_nan=True)


@pytest.mark.parametrize(
    ("points", "cell", "message"),
    [
        ([(0.0, 0, 0), (1, 1, 1)], 0.1, "three points or more; got 2"),
        ([(0.0, 0, 0), (1, 1, 1), (2, 2, 5), (3, 3, 1)], 0.1, "on one line"),
        ([(0.0, 0, 0), (1, 0, 1), (0, 1, 5)], 10.0, "take smaller cells"),
        ([(0.0, 0, 0), (1, 0, 1), (0, 1, 5)], 1e-5, "larger cells or a smaller extent"),
        ([(0.0, 0), (1, 0), (0, 1)], 0.1, "shape"),
        ([(0.0, 0, 0), (1, np.inf, 1), (0, 1, 5)], 0.1, "infinite"),
    ],
)
def test_what_no_surface_can_be_made_of(points, cell, message):
    with pytest.raises(ValueError, match=message):
        stereo.surface(points, cell)


def test_extent_in_the_wrong_order_is_refused():
    with pytest.raises(ValueError, match="X least, Y least"):
        stereo.surface(scattered(10), 1.0, extent=(30, 0, 0, 20))
