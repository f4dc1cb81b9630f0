"""Networks in space: the geometry behind the drawings."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mpl_toolkits.mplot3d import proj3d
from scipy.spatial.transform import Rotation

from pgm_book.ch06 import figures as ch06_figures
from pgm_lab import _rounding, bundle, datasets, plot
from pgm_lab.plot import space

NETWORK = datasets.muliawan2013()
EXTERIORS, POINTS = NETWORK.exteriors, NETWORK.object_points
POSITIONS = np.concatenate([EXTERIORS[:, :3], POINTS])


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def covariances(n=50):
    root = np.random.default_rng(1).normal(scale=0.01, size=(n, 3, 3))
    return root @ root.swapaxes(1, 2)


def test_motions_are_the_derivatives_of_similarity_transformations():
    points, centre, h = POINTS[:5], np.array([10.0, -20.0, 5.0]), 1e-6
    found = bundle.motions(points, centre)
    for axis in range(3):
        unit = np.eye(3)[axis]
        np.testing.assert_array_equal(found[axis], np.tile(unit, (5, 1)))
        there, back = (
            Rotation.from_rotvec(sign * h * unit).apply(points - centre)
            for sign in (1, -1)
        )
        # Central differences: h^2 in the model, eps / h of 2000 mm in the rounding
        np.testing.assert_allclose(found[3 + axis], (there - back) / (2 * h), atol=1e-5)
    np.testing.assert_allclose(found[6], points - centre)


def test_each_of_the_seven_panels_shows_its_motion():
    fig = ch06_figures.seven_motions(EXTERIORS, POINTS)
    names = [text.get_text() for text in fig.texts[:7]]
    assert tuple(names) == ch06_figures.MOTIONS
    middle = (EXTERIORS[:, :3].mean(axis=0) + POINTS.mean(axis=0)) / 2
    expected = bundle.motions(POSITIONS, middle)
    longest = 0.24 * np.ptp(POSITIONS, axis=0).max()
    *panels, axes = fig.axes
    assert [text.get_text() for text in axes.texts] == ["X", "Y", "Z"]
    for ax, motion in zip(panels, expected, strict=True):
        assert (ax.elev, ax.azim) == (axes.elev, axes.azim)
        # The arrows of the cameras were drawn last, from the tip, the heads afterwards
        tips, tails = np.array(
            [s[:2] for s in ax.collections[-1]._segments3d[:9]]
        ).swapaxes(0, 1)
        shafts = tips - tails
        np.testing.assert_allclose(tails, EXTERIORS[:, :3], atol=1e-9)
        scale = longest / np.linalg.norm(motion, axis=1).max()
        np.testing.assert_allclose(shafts, scale * motion[:9], atol=1e-9 * longest)


@given(arrays(float, (3, 3), elements=st.floats(-2, 2)), st.floats(0.1, 100))
def test_ellipsoids_are_one_standard_deviation_in_every_direction(root, factor):
    C = root @ root.T + 1e-3 * np.eye(3)
    centre = np.array([1.0, 2.0, 3.0])
    (mesh,) = ch06_figures.ellipsoids(centre[None], C[None], factor)
    d = (mesh - centre).reshape(-1, 3) / factor
    mahalanobis = np.einsum("ni,ij,nj->n", d, np.linalg.inv(C), d)
    # The inverse loses as many digits as the condition number has, at most five
    np.testing.assert_allclose(mahalanobis, 1, rtol=1e-8)
    # The mesh reaches the extreme in each axis up to the width of its cells, 15 degrees
    extent = np.abs(d).max(axis=0) / np.sqrt(np.diag(C))
    assert np.all((extent > 0.97) & (extent < 1 + 1e-9))


def test_exaggeration_stands_in_the_title_and_is_a_round_number():
    C = covariances()
    fig = ch06_figures.network_3d(EXTERIORS, POINTS, C)
    title = fig.get_suptitle()
    head = "9 photos, 50 points; standard ellipsoids "
    assert title.startswith(head)
    factor = float(title.removeprefix(head).split()[0].replace(",", ""))
    assert factor == _rounding.round_number(factor)
    longest = factor * np.sqrt(np.linalg.eigvalsh(C).max())
    assert 0.02 < longest / np.ptp(POSITIONS, axis=0).max() <= 0.06


def vertices(faces):
    """Corners (n, 3) of polygons, under the names of older and newer Matplotlib."""
    if hasattr(faces, "_faces"):
        return np.reshape(faces._faces, (-1, 3))
    return faces._vec[:3].T


def test_given_exaggeration_is_drawn():
    C = covariances()
    fig = ch06_figures.network_3d(EXTERIORS, POINTS, C, factor=300)
    assert "300 times too large" in fig.get_suptitle()
    faces = next(c for c in fig.axes[0].collections if len(c.get_facecolor()) > 1000)
    corners = vertices(faces).reshape(len(POINTS), -1, 3)
    half = np.ptp(corners, axis=1) / 2
    expected = 300 * np.sqrt(C[:, [0, 1, 2], [0, 1, 2]])
    np.testing.assert_allclose(half, expected, rtol=0.03)  # the width of the cells


def test_cameras_at_one_place_share_a_label():
    fig = ch06_figures.network_3d(EXTERIORS, POINTS)
    names = {text.get_text().strip() for text in fig.axes[0].texts}
    assert {"1, 2", "3, 4, 5", "6", "7", "8, 9", "500 mm"} <= names
    assert fig.get_suptitle() == "9 photos, 50 points"
    fig = ch06_figures.network_3d(EXTERIORS, POINTS, names=False, unit="m")
    assert {text.get_text().strip() for text in fig.axes[0].texts} == {
        "X", "Y", "Z", "500 m"
    }  # fmt: skip


def test_length_of_the_drawn_axes_is_the_one_stated():
    (ax,) = ch06_figures.network_3d(EXTERIORS, POINTS).axes
    axes = next(
        np.array(c._segments3d)
        for c in ax.collections
        if hasattr(c, "_segments3d") and len(c._segments3d) == 3
    )
    np.testing.assert_allclose(axes[:, 1] - axes[:, 0], 500 * np.eye(3), atol=1e-9)


def test_points_alone_can_be_drawn():
    fig = ch06_figures.network_3d(np.empty((0, 6)), POINTS, covariances())
    assert fig.get_suptitle().startswith("50 points; standard ellipsoids")


def test_covariances_must_fit_the_points():
    with pytest.raises(ValueError, match=r"covariance_points must have shape \(50, 3"):
        ch06_figures.network_3d(EXTERIORS, POINTS, covariances(49))


def test_screen_directions_are_those_of_the_drawing():
    view = (20.0, 35.0)
    ax = plt.figure().add_subplot(projection="3d")
    ax.set_proj_type("ortho")
    ax.view_init(*view)
    ax.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-1, 1))
    ax.set_box_aspect((1, 1, 1))
    steps = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    x, y, _ = proj3d.proj_transform(*steps.T, ax.get_proj())
    seen = np.array([x[1:] - x[0], y[1:] - y[0]])
    expected = space.screen(view)
    scale = np.linalg.norm(seen[0]) / np.linalg.norm(expected[0])
    np.testing.assert_allclose(seen, scale * expected, atol=1e-12)


def test_object_is_seen_openly_and_the_network_across():
    right, up = space.screen(space.best_view(EXTERIORS[:, :3], POINTS))
    # The targets lie on a wall: seen edge-on, one extent would vanish
    extents = np.linalg.svd((POINTS - POINTS.mean(axis=0)) @ np.array([right, up]).T)[1]
    assert extents[1] > 0.25 * extents[0]
    apart = (POINTS.mean(axis=0) - EXTERIORS[:, :3].mean(axis=0)) @ right
    assert abs(apart) > 0.5 * np.ptp(POSITIONS[:, 1])


def test_a_network_along_any_direction_lies_across_the_picture():
    turn = np.radians(40)
    along = np.array([np.cos(turn), np.sin(turn), 0])
    rng = np.random.default_rng(1)
    centres = rng.normal(size=(5, 3))
    points = 30 * along + rng.normal(size=(20, 3))
    right, _ = space.screen(space.best_view(centres, points))
    # 35 degrees off, so that depth shows
    assert abs(right @ along) == pytest.approx(np.cos(np.radians(35)), abs=0.05)


@pytest.mark.parametrize("view", [(16, 35), (80, -100), (0, 0)])
def test_drawing_fills_its_place_in_the_figure(view):
    fig = plt.figure(figsize=(9, 5), layout="none")
    ax = fig.add_subplot(projection="3d")
    ax.set_proj_type("ortho")
    ax.view_init(*view)
    where = np.array([0.2, 0.1, 0.7, 0.5])
    space.fill(ax, POSITIONS, where)
    fig.canvas.draw()
    x, y, _ = proj3d.proj_transform(*POSITIONS.T, ax.get_proj())
    seen = ax.transData.transform(np.column_stack([x, y])) / (900, 500)
    low, high = seen.min(axis=0), seen.max(axis=0)
    np.testing.assert_allclose((low + high) / 2, where[:2] + where[2:] / 2, atol=1e-6)
    assert np.max((high - low) / where[2:]) == pytest.approx(1, abs=1e-6)


def test_cameras_are_red_and_points_blue():
    fig = ch06_figures.seven_motions(EXTERIORS, POINTS)
    words = {text.get_text(): text.get_color() for text in fig.texts[7:]}
    assert words == {"cameras": plot.RED, "points": plot.BLUE}
