"""Drawings in space: the geometry behind them; how they look, a person must judge."""

import cv2
import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_lab import plot, rotation

EXTERIOR = np.array([1.0, -2.0, 7.0, 0.3, -0.2, 0.8])


@pytest.fixture
def fig():
    figure = plt.figure()
    yield figure
    plt.close(figure)


def opencv(exterior, points):
    """Image coordinates in units of c, y up, by OpenCV's camera."""
    M = np.diag([1.0, -1.0, -1.0]) @ rotation.matrix(*exterior[3:])
    points = np.asarray(points, dtype=float).reshape(-1, 1, 3)
    rvec = cv2.Rodrigues(M)[0]
    found = cv2.projectPoints(points, rvec, -M @ exterior[:3], np.eye(3), None)[0]
    return found[:, 0] * (1, -1)


def test_corners_of_the_frustum_are_imaged_at_the_corners_of_the_photo():
    corners = plot.space.frustum(EXTERIOR, size=2.5, form=(1.2, 0.8))
    expected = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)]
    np.testing.assert_allclose(opencv(EXTERIOR, corners), expected, atol=1e-12)
    depth = (EXTERIOR[:3] - corners) @ rotation.matrix(*EXTERIOR[3:])[2]
    np.testing.assert_allclose(depth, 2.5)


def test_camera_is_drawn_where_it_stands_with_its_axes(fig):
    drawn = plot.space.draw_camera(plot.space.space(fig), EXTERIOR, size=2.0, name="A")
    np.testing.assert_array_equal(drawn[0], EXTERIOR[:3])
    np.testing.assert_array_equal(drawn[1:5], plot.space.frustum(EXTERIOR, 2.0))
    axes = (drawn[5:] - EXTERIOR[:3]) / 1.6
    np.testing.assert_allclose(axes, rotation.matrix(*EXTERIOR[3:]), atol=1e-14)
    assert [text.get_text() for text in fig.axes[0].texts] == ["x", "y", "z", "A"]


def test_photo_shows_polygons_where_opencv_does_and_the_near_one_last(fig):
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    near, far = square + (0, 0, 3), square
    ax = fig.add_subplot()
    plot.space.draw_photo(ax, EXTERIOR, [(near, "red"), (far, "blue")])
    first, last = (path.vertices[:4] for path in ax.collections[0].get_paths())
    np.testing.assert_allclose(first, opencv(EXTERIOR, far), atol=1e-12)
    np.testing.assert_allclose(last, opencv(EXTERIOR, near), atol=1e-12)


def test_of_a_polygon_that_reaches_behind_the_camera_the_front_part_is_seen(fig):
    down = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    strip = np.array([(1, 0, -2), (1, 0, 2), (1, 1, 2), (1, 1, -2)], dtype=float)
    ax = fig.add_subplot()
    plot.space.draw_photo(ax, down, [(strip, "red"), (strip + (0, 0, 9), "blue")])
    (path,) = ax.collections[0].get_paths()  # the blue one lies behind
    expected = [(0.5, 0.0), (1000.0, 0.0), (1000.0, 1000.0), (0.5, 0.5)]
    np.testing.assert_allclose(path.vertices[:4], expected, rtol=1e-9)


def test_nothing_in_front_of_the_camera_gives_an_empty_photo(fig):
    ax = fig.add_subplot()
    behind = np.array([(0, 0, 1), (1, 0, 1), (1, 1, 1)], dtype=float)
    plot.space.draw_photo(ax, np.zeros(6), [(behind, "red")])
    assert not ax.collections[0].get_paths()


def test_fit_shows_all_points_with_one_scale(fig):
    ax = plot.space.space(fig)
    points = np.array([(-1, 0, 2), (3, 8, 2.5)])
    plot.space.fit(ax, points)
    limits = [ax.get_xlim(), ax.get_ylim(), ax.get_zlim()]
    np.testing.assert_allclose(limits, points.T)
    aspect = np.array(ax._box_aspect)
    np.testing.assert_allclose(aspect / aspect[0], (1, 2, 0.125))


def test_village_has_no_symmetry():
    corners = np.concatenate([polygon for polygon, _ in plot.space.village()])
    high = corners[corners[:, 2] > 0.5]
    for turned in (high * (-1, 1, 1), high * (1, -1, 1), high[:, [1, 0, 2]]):
        gap = np.linalg.norm(turned[:, None] - high[None], axis=-1).min(axis=1)
        assert gap.max() > 0.5
