"""Points on a grid, with texture in both images, or from a file; and their offset."""

import numpy as np
import pytest
import scipy

from pgm_lab.datasets import landsat
from pgm_lab.registration import (
    Raster,
    common_grid,
    grid,
    offset,
    pick,
    read,
    read_points,
    register,
)
from tests.io import rasters
from tests.io.rasters import NOWHERE, UTM, on_map

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


def test_a_grid_leaves_room_for_chip_and_radius():
    assert grid((27, 27), 5, 13).tolist() == [[13, 13]]
    with pytest.raises(ValueError, match="26 x 90 pixels has none that are 13 px"):
        grid((26, 90), 5, 13)
    found = register(GREY, GREY, grid(GREY.shape, 15, 13), chip=21, radius=3)
    assert not np.any(np.char.find(found.status, "leaves") >= 0)


@pytest.mark.parametrize("chip, radius", [(21, 4), (11, 16)])
@pytest.mark.parametrize("offset", [(0, 0), (-40, 25), (60.4, -30.4)])
@pytest.mark.parametrize("kind", ["masked", "nan"])
def test_points_are_picked_where_both_images_have_data(offset, chip, radius, kind):
    hole = np.zeros((200, 300), bool)
    hole[80:120, 100:150] = True
    sensed = np.ma.array(GREY[:200, :300], mask=hole)
    if kind == "nan":
        sensed = sensed.astype(float).filled(np.nan)
    reference = np.ma.array(GREY, mask=False)
    reference[:, :60] = np.ma.masked
    points = pick(reference, 200, chip, radius, sensed=sensed, offset=offset)
    assert len(points) > 50
    assert points[:, 0].min() >= 60 + chip // 2
    reach = chip // 2 + radius
    alone = pick(GREY, 200, chip, radius)
    assert min(alone.min(), (np.array(GREY.shape[::-1]) - 1 - alone).min()) >= reach
    steps = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).T
    around = np.round(points + offset)[:, None] + steps
    x, y = np.moveaxis(around, -1, 0).astype(int)
    assert x.min() >= 0 and y.min() >= 0 and x.max() < 300 and y.max() < 200
    assert not hole[y, x].any()
    assert pick(GREY, 50, sensed=GREY, offset=(1000, 0)).shape == (0, 2)
    for pair, name in (
        ((GREY[:9, :9], None), "image"),
        ((GREY, GREY[:1, :1]), "sensed"),
    ):
        with pytest.raises(
            ValueError, match=f"{name} must have at least {chip} x {chip}"
        ):
            pick(pair[0], 9, chip, radius, sensed=pair[1])


def test_offset_of_two_images_on_one_map(tmp_path):
    """The same point of the map, through both files."""
    moved = UTM + [[0, 0, 63.0], [0, 0, -30]]
    one = read(rasters.saved(tmp_path / "a.tif"))
    other = read(rasters.saved(tmp_path / "b.tif", rasters.GREY[:15], transform=moved))
    found = offset(one, other)
    assert found == pytest.approx((-10.5, -5))
    there = other.pixels(one.map((12.0, 7.0)))
    assert there == pytest.approx(found + (12, 7), abs=1e-6)


def test_offset_is_zero_without_georeference_and_on_the_same_grid():
    """Also under another name of the map, and with other last digits."""
    nowhere = Raster(rasters.GREY, NOWHERE)
    assert np.array_equal(offset(nowhere, nowhere), (0, 0))
    close = on_map(transform=UTM * (1 + 1e-12))
    assert offset(on_map(), close) == pytest.approx(0, abs=1e-3)
    rasterio = pytest.importorskip("rasterio")
    text = rasterio.CRS.from_epsg(32748).to_wkt()
    assert np.array_equal(offset(on_map(), on_map(crs=text)), (0, 0))


@pytest.mark.parametrize(
    "other, message",
    [
        (Raster(rasters.GREY, NOWHERE), "one image has no georeference and the ref"),
        (on_map(crs="EPSG:32747"), "different coordinate.*EPSG:32748 and EPSG:32747"),
        (on_map(crs=None), "different.*EPSG:32748 and none.*-a_srs"),
        (
            on_map(transform=UTM * [[1.001, 1, 1], [1, 1, 1]]),
            "6 x 6 and 6.006 x 6 map units.*common_grid brings both",
        ),
        (on_map(transform=UTM + [[0, 0, 180], [0, 0, 0]]), "no part of the map"),
    ],
)
def test_images_whose_grids_do_not_fit(other, message):
    with pytest.raises(ValueError, match=message):
        offset(on_map(), other)


@pytest.mark.parametrize(
    ("crs", "size", "pixel"), [("EPSG:32722", 20.0, 30), ("EPSG:3857", 50.0, 45)]
)
def test_two_maps_and_pixel_sizes_come_onto_the_coarser_grid(crs, size, pixel):
    """A scene that lies 37 m east and 22 m south, on the map of another projection."""
    warp = pytest.importorskip("rasterio.warp")
    corner, moved = np.array([740_000.0, 7_180_000.0]), np.array([37.0, -22.0])
    scene = scipy.ndimage.gaussian_filter(landsat().grey[:400, :400] * 1.0, 1.0)
    one = Raster(
        scene, scene < 0, np.array([[30, 0, corner[0]], [0, -30, corner[1]]]),
        "EPSG:32721", np.array([30.0, 30.0]),
    )  # fmt: skip
    first = np.ravel(
        warp.transform("EPSG:32721", crs, *corner[:, None] + [[500], [-500]])
    )
    transform = np.array([[size, 0, first[0]], [0, -size, first[1]]])
    row, column = np.indices((round(10_000 / size),) * 2) + 0.5
    x, y = first[0] + size * column.ravel(), first[1] - size * row.ravel()
    there = np.column_stack(warp.transform(crs, "EPSG:32721", x, y)) - moved
    at = one.pixels(there).T[::-1]
    grey = scipy.ndimage.map_coordinates(scene, at, order=5).reshape(row.shape)
    other = Raster(grey, ~np.isfinite(grey), transform, crs)
    reference, sensed = common_grid(one, other)
    assert reference.crs == sensed.crs == "EPSG:32721"
    assert reference.pixel_size == pytest.approx(pixel, abs=0.4)
    assert np.array_equal(offset(reference, sensed), (0, 0))
    images = reference.values, sensed.values
    found = register(*images, pick(images[0], 40, sensed=images[1]), refine="lsm")
    shift = np.array([found.accuracy.median_x, -found.accuracy.median_y])
    assert found.accepted.sum() > 25
    np.testing.assert_allclose(shift * reference.pixel_size, moved, atol=0.3)
    assert common_grid(reference, sensed) == (reference, sensed)


def test_images_without_a_common_map_are_refused():
    for other, message in (
        (on_map(crs=None), "-a_srs"),
        (Raster(rasters.GREY, NOWHERE), "no georeference"),
        (on_map(crs="EPSG:32722"), "no part of the map|cannot|transform"),
    ):
        with pytest.raises(ValueError, match=message):
            common_grid(on_map(), other)


def test_points_in_map_coordinates(tmp_path):
    pixels = np.array([(3.0, 4), (10.25, 7.5)])
    path = tmp_path / "points.csv"
    np.savetxt(path, on_map().map(pixels), delimiter=",")
    assert read_points(path, on_map()) == pytest.approx(pixels, abs=1e-6)
    np.savetxt(path, pixels, delimiter=",")
    assert np.array_equal(read_points(path), pixels)
    with pytest.raises(ValueError, match="no georeference"):
        read_points(path, Raster(rasters.GREY, NOWHERE))


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "points.csv: the file holds no numbers"),
        ("1,2,3\n", r"points.csv, line 1: 3 column\(s\), where points have 2"),
        ("1.5,2\n1.5,x\n", "points.csv, line 2: 'x' is not a number"),
    ],
)
def test_tables_that_are_no_points(tmp_path, text, message):
    path = tmp_path / "points.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_points(path)
