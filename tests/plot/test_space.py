"""Drawings in space: the geometry behind them; how they look, a person must judge."""

import cv2
import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpl_toolkits.mplot3d import proj3d

from pgm_book.ch04 import figures as meadow
from pgm_lab import datasets, plot, rotation
from pgm_lab.plot import space

EXTERIOR = np.array([1.0, -2.0, 7.0, 0.3, -0.2, 0.8])
FORM = (1.2, 0.8)
SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
pytestmark = pytest.mark.usefixtures("closed")


@pytest.fixture
def ax():
    return plt.figure().add_subplot()


@pytest.fixture
def in_space():
    return space.space(plt.figure())


def opencv(exterior, points):
    """Image coordinates in units of c, y up, by OpenCV's camera."""
    M = np.diag([1.0, -1.0, -1.0]) @ rotation.matrix(*exterior[3:])
    points = np.asarray(points, dtype=float).reshape(-1, 1, 3)
    rvec = cv2.Rodrigues(M)[0]
    found = cv2.projectPoints(points, rvec, -M @ exterior[:3], np.eye(3), None)[0]
    return found[:, 0] * (1, -1)


def vertices(faces):
    """Corners (n, 3) of polygons, under the names of older and newer Matplotlib."""
    if hasattr(faces, "_faces"):
        return np.ma.getdata(faces._faces).reshape(-1, 3)
    return faces._vec[:3].T


# --- Cameras in space ---


def test_corners_of_the_frustum_are_imaged_at_the_corners_of_the_photo():
    corners = space.frustum(EXTERIOR, size=2.5, form=FORM)
    expected = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)]
    np.testing.assert_allclose(opencv(EXTERIOR, corners), expected, atol=1e-12)
    depth = (EXTERIOR[:3] - corners) @ rotation.matrix(*EXTERIOR[3:])[2]
    np.testing.assert_allclose(depth, 2.5)


# --- What a camera sees ---


def test_photo_shows_polygons_where_opencv_does_and_the_near_one_last(ax):
    near, far = SQUARE + (0, 0, 3), SQUARE
    space.draw_photo(ax, EXTERIOR, [(near, "red"), (far, "blue")])
    first, last = (path.vertices[:4] for path in ax.collections[0].get_paths())
    np.testing.assert_allclose(first, opencv(EXTERIOR, far), atol=1e-12)
    np.testing.assert_allclose(last, opencv(EXTERIOR, near), atol=1e-12)


def below_horizon(exterior, rows=75, columns=100):
    """How far the rays of pixels (rows, columns) point downwards; row 0 on top."""
    x = space.FORMAT[0] * ((np.arange(columns) + 0.5) / columns - 0.5)
    y = space.FORMAT[1] * (0.5 - (np.arange(rows) + 0.5) / rows)
    rays = np.stack([*np.meshgrid(x, y), np.full((rows, columns), -1)], axis=-1)
    turned = rays @ rotation.matrix(*exterior[3:])
    return -turned[..., 2] / np.linalg.norm(turned, axis=-1)


def pixels_of_photo(exterior, faces, rows=75, columns=100):
    """The photo as it is drawn, (rows, columns, 3), 8 bit, without names and axes."""
    figure = plt.figure(figsize=(columns / 10, rows / 10), dpi=10, layout="none")
    ax = figure.add_axes((0, 0, 1, 1))
    space.draw_photo(ax, exterior, faces, ground=meadow.GROUND)
    for added in (*ax.texts, *ax.lines, *ax.spines.values()):
        added.set_visible(False)
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[..., :3].copy()


ATTITUDES = [
    *[(omega, phi, 20) for omega in (-60, 0, 40) for phi in (-60, 45)],
    *[(90, 0, 0), (100, 0, 30), (180, 0, 0)],
]


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_sky_is_seen_above_the_true_horizon_and_nowhere_else(attitude):
    """Settings of the sliders of chapter 4, and cameras that look up as well."""
    exterior = np.array([0, 0, 7, *np.radians(attitude)])
    photo = pixels_of_photo(exterior, meadow.surroundings() + meadow.village())
    down = below_horizon(exterior)
    sky = np.all(photo == (0xDC, 0xEB, 0xF5), axis=-1)
    # A pixel is a hundredth of c: nearer than two the line itself is drawn
    assert not sky[down > 0.02].any()
    assert sky[down < -0.02].all()


def test_directions_stand_on_the_horizon_where_opencv_has_them(ax):
    exterior = np.array([3.0, -4.0, 7.0, *np.radians([80, 10, 5])])
    M = rotation.matrix(*exterior[3:])
    found = dict(space.directions(M, c=2.0))
    assert {"N", "NE", "NW"} <= set(found) <= set(space.DIRECTIONS) - {"S"}
    far = exterior[:3] + 1e7 * np.array([(0, 1, 0), (1, 1, 0)])
    expected = 2 * opencv(exterior, far)
    np.testing.assert_allclose([found["N"], found["NE"]], expected, atol=1e-6)
    assert found["NE"][0] > found["N"][0] > found["NW"][0]
    level = np.array([0.0, 0.0, 7.0, *np.radians([80, 0, 0])])
    space.draw_photo(ax, level, [], ground="green")
    assert [t.get_text() for t in ax.texts if t.get_text()] == ["N", "x", "y"]


@pytest.mark.parametrize("height", [0.0, -1.0])
def test_a_camera_under_the_ground_is_refused(ax, height):
    with pytest.raises(ValueError, match="must be above"):
        space.draw_photo(ax, [0, 0, height, 0, 0, 0], [], ground="green")


# --- A pixel on the ground ---


@pytest.fixture
def pixel(monkeypatch):
    """At 100 m, above a coarser picture of the ground, which is quicker to draw."""
    lay_out = space._lay_out
    monkeypatch.setattr(
        space, "_lay_out", lambda *a, **k: lay_out(*a, **k | {"pixels": 16})
    )
    return plot.pixel_on_ground(datasets.yellowstone(), height=100.0).axes[0]


def test_the_pixel_its_ground_and_the_perspective_centre_are_on_one_ray(pixel):
    image, below = (vertices(polygon)[:4] for polygon in pixel.collections[2:4])
    np.testing.assert_allclose(below[:, 2], 0, atol=1e-9)
    rays, to_ground = image - (0, 0, 100), below - (0, 0, 100)
    scale = rays[:, 2:] / to_ground[:, 2:]
    np.testing.assert_allclose(rays, scale * to_ground, atol=1e-9)


# --- How a network is looked at ---


@pytest.fixture(scope="module")
def network():
    data = datasets.muliawan2013()
    return data.exteriors[:, :3], data.object_points


def across_and_up(view):
    """Directions (2, 3) to the right and upwards, as Matplotlib projects them."""
    ax = plt.figure().add_subplot(projection="3d")
    ax.set_proj_type("ortho")
    ax.view_init(*view)
    ax.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    ax.set_box_aspect((1, 1, 1))
    steps = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    x, y, _ = proj3d.proj_transform(*steps.T, ax.get_proj())
    seen = np.array([x[1:] - x[0], y[1:] - y[0]])
    return seen / np.linalg.norm(seen, axis=1, keepdims=True)


def test_object_is_seen_openly_and_the_network_across(network):
    centres, points = network
    right, up = across_and_up(space.best_view(centres, points))
    # The targets lie on a wall: seen edge-on, one extent would vanish
    extents = np.linalg.svd((points - points.mean(axis=0)) @ np.array([right, up]).T)[1]
    assert extents[1] > 0.25 * extents[0]
    apart = (points.mean(axis=0) - centres.mean(axis=0)) @ right
    assert abs(apart) > 0.5 * np.ptp(np.concatenate(network)[:, 1])


@pytest.mark.parametrize("view", [(16, 35), (80, -100)])
def test_drawing_fills_its_place_in_the_figure(view, network, closed):
    positions = np.concatenate(network)
    fig = plt.figure(figsize=(9, 5), layout="none")
    ax = fig.add_subplot(projection="3d")
    ax.set_proj_type("ortho")
    ax.view_init(*view)
    where = np.array([0.2, 0.1, 0.7, 0.5])
    space.fill(ax, positions, where)
    fig.canvas.draw()
    x, y, _ = proj3d.proj_transform(*positions.T, ax.get_proj())
    seen = ax.transData.transform(np.column_stack([x, y])) / (900, 500)
    low, high = seen.min(axis=0), seen.max(axis=0)
    np.testing.assert_allclose((low + high) / 2, where[:2] + where[2:] / 2, atol=1e-6)
    assert np.max((high - low) / where[2:]) == pytest.approx(1, abs=1e-6)


def test_a_camera_is_its_image_plane_four_rays_from_the_centre_and_its_axes(in_space):
    drawn = space.draw_camera(in_space, EXTERIOR, size=2.0, form=FORM, name="A")
    corners = space.frustum(EXTERIOR, 2.0, FORM)
    np.testing.assert_array_equal(drawn[0], EXTERIOR[:3])
    np.testing.assert_array_equal(drawn[1:5], corners)
    axes = (drawn[5:] - EXTERIOR[:3]) / 1.6
    np.testing.assert_allclose(axes, rotation.matrix(*EXTERIOR[3:]), atol=1e-14)
    assert [text.get_text() for text in in_space.texts] == ["x", "y", "z", "A"]
    rays, plane = in_space.collections[:2]
    np.testing.assert_allclose(vertices(plane)[:4], corners)
    segments = np.array(rays._segments3d)
    np.testing.assert_allclose(segments[:, 0], np.tile(EXTERIOR[:3], (4, 1)))
    np.testing.assert_allclose(segments[:, 1], corners)


def test_what_lies_on_the_ground_is_drawn_before_what_stands_on_it(in_space):
    """A field as large as the country is nearer than a tree, by its middle."""
    field = 40.0 * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    tree = np.array([(20, 0, 0), (21, 0, 0), (20.5, 0, 3)])
    exterior = np.array([0.0, 0.0, 7.0, 1.2, 0.0, -1.4])
    faces = [(tree, "red"), (field, "green")]
    for ground, red in ((None, 0), ("green", 1)):
        ax = plt.figure().add_subplot()
        space.draw_photo(ax, exterior, faces, ground=ground)
        assert np.argmax(ax.collections[-1].get_facecolors()[:, 0]) == red
    corners = space.draw_faces(in_space, faces)
    assert [len(c._facecolor3d) for c in in_space.collections] == [1, 1]
    assert in_space.collections[0]._facecolor3d[0, 1] > 0 and len(corners) == 7
