"""Aerial photos: truth by other means than the ray-caster."""

import cv2
import numpy as np
import pytest

from pgm_lab.camera import Camera
from pgm_lab.simulate import aerial_block, aerial_pair, landscape
from pgm_lab.simulate.aerial import (
    GSD,
    PIXEL,
    SENSOR,
    Surface,
    _frame,
    render,
)

PART = (240, 180)


@pytest.fixture(scope="module")
def pair():
    return aerial_pair(PART)


def pixels(part):
    return np.stack(np.meshgrid(np.arange(part[0]), np.arange(part[1])), -1)


def test_ground_lies_on_the_surface_and_projects_back_to_its_pixels(pair):
    land = pair.landscape
    for photo, ground in zip((pair.left, pair.right), pair.ground, strict=True):
        error = photo.project(ground) - pixels(PART)
        assert np.abs(error).max() < 1e-6  # px
        X, Y, Z = np.moveaxis(ground, -1, 0)
        assert np.abs(land.at(land.dsm, X, Y) - Z).max() <= 1.01e-4  # m


def taken(land, camera, exterior, corner, part):
    """One photo without noise, and the ground that it shows."""
    frame = _frame(camera, np.array(exterior), tuple(corner))
    return next(render(land, Surface(land.dsm), [frame], part, 0, 0))


def marched(land, photo, ground):
    """How far the surface is above the rays from points to the station, at most.

    By steps of a third of a cell sideways: slow, and without any block or false
    position. It begins a twentieth of a cell away, as the point is on the surface.
    """
    station = photo.exterior[:3]
    way = station - ground
    length = np.hypot(way[..., 0], way[..., 1])
    highest = np.full(length.shape, -np.inf)
    rise = land.dsm.max() - ground[..., 2].min()
    reach = (rise / way[..., 2] * length).max()
    near = np.array([0.05, 0.1, 0.2, 0.3])
    distances = np.concatenate([near, np.arange(0.5, reach / land.cell, 1 / 3)])
    for far in distances * land.cell:
        point = ground + way * (far / length)[..., None]
        over = land.at(land.dsm, point[..., 0], point[..., 1]) - point[..., 2]
        np.maximum(highest, over, out=highest)
    return highest


def test_nothing_stands_between_a_point_and_the_photo_that_shows_it(pair):
    """Marching finds no surface above the rays, or no more than a corner of a cell."""
    for photo, ground in zip((pair.left, pair.right), pair.ground, strict=True):
        over = marched(pair.landscape, photo, ground[::3])
        assert (over < 1e-3).mean() > 0.9995
        assert over.max() < 0.1


def test_hidden_is_what_marching_to_the_other_station_finds(pair):
    for k, other in enumerate((pair.right, pair.left)):
        ground = pair.ground[k][::3]  # every third row
        over = marched(pair.landscape, other, ground)
        at = other.project(ground)
        inside = ((at >= 0) & (at <= np.array(PART) - 1)).all(-1)
        found = pair.hidden[k][::3]
        assert found[~inside].all()
        assert 0.02 < found[inside].mean() < 0.2
        assert found[inside & (over > 0.1)].mean() > 0.999
        assert found[inside & (over < 1e-3)].mean() < 0.001


def test_photo_of_level_ground_is_a_perspective_of_the_orthophoto():
    """OpenCV warps the ground's grey values by four points: no ray is cast."""
    camera = Camera(24.0)
    land = landscape((-70, -60, 70, 60), relief=0, buildings=0, trees=0)
    exterior = [3.0, -2.0, 1000.0, 0.02, -0.015, 0.3]
    part, corner = (200, 150), (2044, 1349)
    photo, ground = taken(land, camera, exterior, corner, part)
    assert np.abs(ground[..., 2]).max() < 1e-4
    corners = np.array([(-30, -20, 0), (30, -20, 0), (30, 20, 0), (-30, 20, 0)], float)
    there = photo.project(corners).astype(np.float32)
    here = np.stack(
        [corners[:, 0] - land.corner[0], land.corner[1] - corners[:, 1]], -1
    )
    by = cv2.getPerspectiveTransform((here / land.cell).astype(np.float32), there)
    smooth = cv2.GaussianBlur(land.grey, (0, 0), 0.4 * PIXEL / 24 * 1000 / land.cell)
    expected = cv2.warpPerspective(smooth, by, part, flags=cv2.INTER_CUBIC)
    expected = cv2.GaussianBlur(expected, (0, 0), 0.35)
    r2 = ((pixels(part) + corner - (np.array(SENSOR) - 1) / 2) ** 2).sum(-1)
    r2 = r2 * (PIXEL / 24) ** 2
    expected *= 1 - 0.6 * r2 + 0.2 * r2**2
    inner = np.s_[20:-20, 20:-20]
    difference = photo.grey[inner] - expected[inner]
    assert difference.std() < 0.6  # rounding to whole grey values has 0.29
    assert abs(difference.mean()) < 0.05


def test_ray_meets_a_wall_where_geometry_says():
    """A step of 10 m between two cells, seen from aside: roof, wall, ground."""
    z = np.zeros((3, 100), np.float32)
    z[:, 50:] = 10
    right = np.full(400, -0.5)  # one cell to the left for 2 m up
    column = np.linspace(30, 70, 400)
    still = np.zeros(400)
    Z = Surface(z).meet(np.array([still + 1, still, column, right]))
    met = column + Z * right
    ground, roof = met < 49, met > 50
    assert np.abs(Z[ground]).max() < 1e-4
    np.testing.assert_allclose(Z[roof], 10, atol=1e-4)
    # a ray that is at column x at height 0 is at x - 5 at height 10
    np.testing.assert_array_equal(ground, column < 49)
    np.testing.assert_array_equal(roof, column > 55)
    wall = ~ground & ~roof
    np.testing.assert_allclose(Z[wall], (met[wall] - 49) * 10, atol=1.1e-4)


def test_a_pixel_is_as_large_as_the_flight_says(pair):
    """0.229 m at 1000 m; the photos fly so high above the middle of the relief."""
    assert pytest.approx(0.22875) == GSD
    plain = aerial_pair((60, 40), relief=0, buildings=0, trees=0, camera=Camera(24.0))
    step = np.linalg.norm(np.diff(plain.ground[0], axis=1), axis=-1)
    assert np.median(step) == pytest.approx(1.02 * GSD, rel=0.02)
    base = np.diff([p.exterior[:3] for p in (pair.left, pair.right)], axis=0)
    assert np.linalg.norm(base) == pytest.approx(0.4 * 4288 * GSD, rel=1e-4)


def test_noise_has_the_standard_deviation_asked_for_in_each_photo_its_own():
    part = (60, 40)
    clean, noisy = (aerial_pair(part, sigma=s) for s in (0, 3))
    noise = [
        getattr(noisy, side).grey.astype(float) - getattr(clean, side).grey
        for side in ("left", "right")
    ]
    for one in noise:
        assert one.std() == pytest.approx(np.sqrt(9 + 1 / 6), rel=0.06)  # two roundings
    assert abs(np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]) < 0.06


def test_photos_of_a_block_overlap_as_asked():
    part = (120, 90)
    photos, land = aerial_block(2, 3, part, overlap=0.6, sidelap=0.3, cell=0.3)
    assert len(photos) == 6
    middle = np.array([p.exterior[:2] for p in photos]).reshape(2, 3, 2)
    along = np.diff(middle[..., 0], axis=1) / (part[0] * GSD)
    across = -np.diff(middle[..., 1], axis=0) / (part[1] * GSD)
    np.testing.assert_allclose(1 - along, 0.6, atol=0.02)
    np.testing.assert_allclose(1 - across, 0.3, atol=0.02)
    for photo in photos:
        assert photo.grey.shape == (90, 120)
        corners = photo.project([(*photo.exterior[:2], 20.0)])
        assert np.abs(corners - np.array(part) / 2).max() < 20
        rays = photo.rays(pixels(part).reshape(-1, 2))
        X = photo.exterior[0] - photo.exterior[2] / rays[:, 2] * rays[:, 0]
        assert land.corner[0] < X.min()
        assert X.max() < land.corner[0] + land.cell * land.dsm.shape[1]
