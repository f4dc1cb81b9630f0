"""An oriented photo: its frames, its parts, rays there and back, and bad input."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pgm_lab import camera, frames, orientation
from pgm_lab.camera import Camera, Photo

LENS = Camera(24.0, 0.05, -0.03, K1=-1.5e-4, K2=1.5e-7, P1=1e-5, P2=-8e-6)
EXTERIOR = (10.0, 20, 500, 0.05, -0.08, 1.2)
GREY = np.arange(40 * 60, dtype=np.uint8).reshape(40, 60)
POINTS = np.array([(12.0, 25, 3), (40, -30, 8), (-20, 50, 0)])
PIXELS = np.array([(0.0, 0.0), (59, 39), (12.25, 30.5)])


def whole(**change):
    given = dict(
        grey=np.zeros((2848, 4288), np.uint8),
        camera=LENS,
        exterior=EXTERIOR,
        pixel_size=5.49e-3,
    )
    return Photo(**(given | change))


def part(**change):
    return whole(grey=GREY, image_size=(4288, 2848), corner=(3000, 200), **change)


def test_pixels_are_those_of_frames_and_project():
    photo = whole()
    mm = camera.project(LENS, EXTERIOR, POINTS)
    expected = frames.photo_to_pixel(mm, (4288, 2848), 5.49e-3)
    np.testing.assert_allclose(photo.project(POINTS), expected, atol=1e-9)
    np.testing.assert_allclose(photo.to_photo(expected), mm, atol=1e-12)


def test_a_part_has_the_pixels_of_the_whole_less_its_corner():
    np.testing.assert_allclose(
        part().project(POINTS) + (3000, 200), whole().project(POINTS), atol=1e-9
    )
    np.testing.assert_allclose(
        part().rays(PIXELS), whole().rays(PIXELS + (3000, 200)), atol=1e-12
    )
    assert part().sensor == whole().sensor == (4288, 2848)


def test_rays_meet_the_points_that_are_projected():
    photo = whole()
    u = photo.rays(photo.project(POINTS))
    off = np.cross(u, POINTS - photo.exterior[:3])
    assert np.abs(off).max() < 1e-6
    # and are those that intersection of two photos uses
    other = whole(exterior=(80.0, 25, 505, -0.02, 0.03, 1.0))
    mm = [one.to_photo(one.project(POINTS)) for one in (photo, other)]
    found = orientation.intersect(LENS, [photo.exterior, other.exterior], mm)
    np.testing.assert_allclose(found.points, POINTS, atol=1e-6)


@given(st.floats(0, 4287), st.floats(0, 2847), st.sampled_from(("backward", "forward")))
def test_of_rays_undoes_rays(column, row, lens):
    photo = whole(camera=Camera(*LENS.interior, lens=lens))
    there = photo.rays((column, row))
    np.testing.assert_allclose(photo.of_rays(3 * there), (column, row), atol=1e-6)


@pytest.mark.parametrize("lens, K1", [("backward", -1e-3), ("forward", -4e-4)])
def test_seen_at_is_of_rays_where_there_is_an_answer_and_nan_elsewhere(lens, K1):
    # Backward nothing lies beyond an ideal 12.2 mm, forward it folds at 28.9 mm
    photo = whole(camera=Camera(24.0, K1=K1, lens=lens))
    inside = photo.rays([(2144.0, 1424), (100, 100), (4200, 2700)])
    np.testing.assert_allclose(photo.seen_at(inside), photo.of_rays(inside), atol=1e-6)
    level = whole(camera=photo.camera, exterior=(0, 0, 100, 0, 0, 0))
    outside = np.array([(30.0, 0, -24), (50, 0, -24), (0, 0, 1), (1, 1, 0)])
    assert np.isnan(level.seen_at(outside)).all()
    assert np.isfinite(level.seen_at((11.5, 0, -24))).all()


def test_without_lens_the_camera_without_lens_sees_the_same():
    plain = whole(camera=Camera(LENS.c, LENS.x0, LENS.y0))
    free = whole().without_lens(whole().project(POINTS))
    np.testing.assert_allclose(free, plain.project(POINTS), atol=1e-8)
    assert np.abs(free - whole().project(POINTS)).max() > 0.1


def test_outline_goes_once_around_the_edge_of_the_part():
    edge = part().outline(4)
    assert edge.shape == (16, 2)
    np.testing.assert_allclose(
        edge[::4], [(-0.5, -0.5), (59.5, -0.5), (59.5, 39.5), (-0.5, 39.5)]
    )
    x, y = edge.T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area == pytest.approx(60 * 40)


@pytest.mark.parametrize(
    "change, words",
    [
        ({"grey": np.zeros((4, 6, 3))}, r"grey.*colour image.*grey"),
        ({"image_size": (2848, 4288)}, "does not lie inside an image_size"),
        ({"corner": (0.5, 0)}, "corner must be a whole number"),
        ({"corner": (1, 0)}, "does not lie inside an image_size"),
    ],
)
def test_bad_input_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        whole(**change)


def test_directions_behind_the_camera_are_refused():
    with pytest.raises(ValueError, match=r"directions\[1\].*in front"):
        whole().of_rays([(0.0, 0, -1), (0, 0, 1)])
