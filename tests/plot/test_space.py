"""Drawings in space: the geometry behind them; how they look, a person must judge."""

import cv2
import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book.ch04 import figures as ch04_figures
from pgm_lab import plot, rotation
from pgm_lab.plot import _horizon

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


def below_horizon(exterior, form=plot.space.FORMAT, c=1.0, rows=75, columns=100):
    """How far the rays of pixels (rows, columns) point downwards; row 0 on top."""
    x = c * form[0] * ((np.arange(columns) + 0.5) / columns - 0.5)
    y = c * form[1] * (0.5 - (np.arange(rows) + 0.5) / rows)
    rays = np.stack([*np.meshgrid(x, y), np.full((rows, columns), -c)], axis=-1)
    turned = rays @ rotation.matrix(*exterior[3:])
    return -turned[..., 2] / np.linalg.norm(turned, axis=-1)


def pixels_of_photo(exterior, faces, rows=75, columns=100):
    """The photo as it is drawn, (rows, columns, 3), 8 bit, without names and axes."""
    figure = plt.figure(figsize=(columns / 10, rows / 10), dpi=10, layout="none")
    ax = figure.add_axes((0, 0, 1, 1))
    plot.space.draw_photo(ax, exterior, faces, ground=ch04_figures.GROUND)
    for added in (*ax.texts, *ax.lines, *ax.spines.values()):
        added.set_visible(False)
    figure.canvas.draw()
    grey = np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()
    plt.close(figure)
    return grey


ATTITUDES = [
    *[(omega, phi, 20) for omega in (-60, -25, 0, 40, 60) for phi in (-60, 0, 45)],
    *[(90, 0, 0), (75, 10, 100), (100, 0, 30), (150, 20, 0), (180, 0, 0)],
]


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_sky_is_seen_above_the_true_horizon_and_nowhere_else(attitude):
    """All settings of the sliders of chapter 4, and cameras that look up as well."""
    exterior = np.array([0, 0, 7, *np.radians(attitude)])
    village = ch04_figures.surroundings() + ch04_figures.village()
    photo = pixels_of_photo(exterior, village)
    down = below_horizon(exterior)
    sky = np.all(photo == (0xDC, 0xEB, 0xF5), axis=-1)
    # A pixel is a hundredth of c: nearer than two the line itself is drawn
    assert not sky[down > 0.02].any()
    assert sky[down < -0.02].all()


def test_directions_stand_on_the_horizon_where_opencv_has_them():
    exterior = np.array([3.0, -4.0, 7.0, *np.radians([80, 10, 5])])
    M = rotation.matrix(*exterior[3:])
    found = dict(_horizon.directions(M, c=2.0))
    assert {"N", "NE", "NW"} <= set(found) <= set(_horizon.DIRECTIONS) - {"S"}
    far = exterior[:3] + 1e7 * np.array([(0, 1, 0), (1, 1, 0)])
    expected = 2 * opencv(exterior, far)
    np.testing.assert_allclose([found["N"], found["NE"]], expected, atol=1e-6)
    assert found["NE"][0] > found["N"][0] > found["NW"][0]


def test_photo_names_the_directions_and_its_own_axes(fig):
    exterior = np.array([0.0, 0.0, 7.0, *np.radians([80, 0, 0])])
    ax = fig.add_subplot()
    plot.space.draw_photo(ax, exterior, ch04_figures.village(), ground="green")
    written = [text.get_text() for text in ax.texts if text.get_text()]
    assert written == ["N", "x", "y"]


def test_what_lies_on_the_ground_is_drawn_before_what_stands_on_it(fig):
    """A field as large as the country is nearer than a tree, by its middle."""
    field = 40.0 * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    tree = np.array([(20, 0, 0), (21, 0, 0), (20.5, 0, 3)])
    exterior = np.array([0.0, 0.0, 7.0, 1.2, 0.0, -1.4])
    for k, faces in enumerate(([(tree, "red"), (field, "green")],) * 2):
        ax = fig.add_subplot(1, 2, k + 1)
        ground = "green" if k else None
        plot.space.draw_photo(ax, exterior, faces, ground=ground)
        colors = ax.collections[-1].get_facecolors()
        assert np.argmax(colors[:, 0]) == (1 if k else 0)  # red
    ax = plot.space.space(fig)
    corners = plot.space.draw_faces(ax, [(tree, "red"), (field, "green")])
    assert [len(c._facecolor3d) for c in ax.collections] == [1, 1]
    assert ax.collections[0]._facecolor3d[0, 1] > 0 and len(corners) == 7


@pytest.mark.parametrize("height", [0.0, -1.0])
def test_a_camera_under_the_ground_is_refused(fig, height):
    exterior = np.array([0, 0, height, 0, 0, 0])
    with pytest.raises(ValueError, match="must stand above"):
        plot.space.draw_photo(fig.add_subplot(), exterior, [], ground="green")


def test_surroundings_lie_on_the_ground_and_leave_the_meadow_free():
    far = 12.0 * 12 + 6
    corners = []
    for polygon, _ in ch04_figures.surroundings():
        assert not polygon[:, 2].any()
        inside = np.abs(polygon[:, :2].mean(axis=0)) < 6
        assert not inside.all()
        corners.append(polygon)
    corners = np.concatenate(corners)
    np.testing.assert_array_equal(corners.min(axis=0)[:2], -far)
    np.testing.assert_array_equal(corners.max(axis=0)[:2], far)


def test_arrow_on_the_meadow_points_north_with_the_n_to_its_right():
    black = [p for p, color in ch04_figures.village() if color == plot.BLACK]
    arrow, *letter = black
    assert arrow[:, 1].argmax() == np.argmin(np.abs(arrow[:, 0] - arrow[:, 0].mean()))
    assert np.ptp(arrow[:, 1]) > 2 * np.ptp(arrow[:, 0])
    assert np.min(np.concatenate(letter)[:, 0]) > arrow[:, 0].max()
    diagonal = letter[-1]  # of an N it falls from left to right, of its mirror it rises
    slope = np.polyfit(diagonal[:, 0], diagonal[:, 1], 1)[0]
    assert slope < 0


def test_village_has_no_symmetry():
    corners = np.concatenate([polygon for polygon, _ in ch04_figures.village()])
    high = corners[corners[:, 2] > 0.5]
    for turned in (high * (-1, 1, 1), high * (1, -1, 1), high[:, [1, 0, 2]]):
        gap = np.linalg.norm(turned[:, None] - high[None], axis=-1).min(axis=1)
        assert gap.max() > 0.5
