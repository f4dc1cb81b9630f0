"""Points on a grid, and where texture is good in what both images show."""

import numpy as np
import pytest

from pgm_lab import matching
from pgm_lab.datasets import landsat
from pgm_lab.registration import grid, pick, register

GREY = landsat().grey[:260, :320]


def margins(points, shape):
    """Least distance of the points from the four edges."""
    rows, columns = shape
    x, y = points.T
    return x.min(), columns - 1 - x.max(), y.min(), rows - 1 - y.max()


@pytest.mark.parametrize("shape", [(100, 160), (101, 161), (57, 400)])
@pytest.mark.parametrize("step, margin", [(10, 0), (7, 13), (50, 28), (1000, 20)])
def test_a_grid_is_square_and_in_the_middle(shape, step, margin):
    points = grid(shape, step, margin)
    left, right, top, bottom = margins(points, shape)
    assert min(left, right, top, bottom) >= margin
    assert abs(left - right) <= 1 and abs(top - bottom) <= 1
    assert max(left, right, top, bottom) < margin + step
    for axis in (0, 1):
        values = np.unique(points[:, axis])
        assert np.all(np.diff(values) == step)
    assert len(points) == len(np.unique(points, axis=0))
    assert np.all(points == np.round(points))


def test_an_image_with_no_room_for_a_grid():
    assert grid((27, 27), 5, 13).tolist() == [[13, 13]]
    with pytest.raises(ValueError, match="26 x 90 pixels has none that are 13 px"):
        grid((26, 90), 5, 13)


def test_a_grid_leaves_room_for_chip_and_radius():
    found = register(GREY, GREY, grid(GREY.shape, 15, 13), chip=21, radius=3)
    assert not np.any(np.char.find(found.status, "leaves") >= 0)


@pytest.mark.parametrize("chip, radius", [(21, 3), (11, 8)])
def test_picked_points_leave_room_for_chip_and_radius(chip, radius):
    points = pick(GREY, 300, chip, radius)
    assert len(points) == 300
    assert min(margins(points, GREY.shape)) >= chip // 2 + radius
    expected = matching.pick(GREY, 300, chip, margin=chip // 2 + radius)
    assert np.array_equal(points, expected)


def in_sensed(points, offset, shape):
    x, y = (points + offset).T
    return (x >= 0) & (y >= 0) & (x < shape[1]) & (y < shape[0])


@pytest.mark.parametrize("chip, radius", [(21, 4), (11, 16)])
@pytest.mark.parametrize("offset", [(0, 0), (-40, 25), (60.4, -30.4)])
def test_points_are_picked_where_both_images_have_data(offset, chip, radius):
    sensed = np.ma.array(GREY[:200, :300].copy(), mask=False)
    sensed[80:120, 100:150] = np.ma.masked
    points = pick(GREY, 200, chip, radius, sensed=sensed, offset=offset)
    assert len(points) > 50
    reach = chip // 2 + radius
    steps = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).T
    around = np.round(points + offset)[:, None] + steps
    assert in_sensed(around.reshape(-1, 2), 0, sensed.shape).all()
    x, y = np.moveaxis(around, -1, 0).astype(int)
    assert not sensed.mask[y, x].any()


def test_masks_of_the_reference_and_nan_of_the_sensed_image_count_too():
    reference = np.ma.array(GREY, mask=False)
    reference[:, :100] = np.ma.masked
    sensed = GREY.astype(float)
    sensed[150:] = np.nan
    points = pick(reference, 50, sensed=sensed)
    assert len(points) > 10
    assert points[:, 0].min() >= 110 and points[:, 1].max() < 150 - 13


def test_images_with_nothing_in_common_give_no_points():
    assert pick(GREY, 50, sensed=GREY, offset=(1000, 0)).shape == (0, 2)
    assert pick(GREY, 50, sensed=GREY, offset=(1e300, -1e300)).shape == (0, 2)
