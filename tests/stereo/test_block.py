"""A block of photos: the same to the last bit by whatever hands, and after any stop."""

import dataclasses
import re

import numpy as np
import pytest

from pgm_lab import stereo
from pgm_lab.camera import Camera, Photo
from pgm_lab.io import geotiff
from pgm_lab.stereo import block as module
from tests.stereo import blocks
from tests.stereo.blocks import HEIGHTS, NUMBERS, PAIRS, content, replaced


@pytest.fixture(scope="module")
def block():
    return blocks.strip()


@pytest.fixture(scope="module")
def photos(block, tmp_path_factory):
    return blocks.saved(block[0], tmp_path_factory.mktemp("photos"))


@pytest.fixture(scope="module")
def serial(photos, tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    return plot(photos, folder), content(folder)


@pytest.fixture
def empty(tmp_path):
    folder = tmp_path / "block"
    folder.mkdir()
    return folder


def plot(photos, folder, pairs=PAIRS, **more):
    return stereo.plot_block(photos, pairs, folder, **(NUMBERS | {"workers": 1} | more))


def statuses(block):
    return [pair.status for pair in block.pairs]


def test_the_surface_is_the_landscape(block, serial):
    """Where two photos of a pair see it, and as well as 0.3 px of parallax allow."""
    s, (photos, land) = serial[0].surface, block
    X, Y = s.grid()
    truth = land.at(land.dsm, X, Y)
    points = np.stack([X, Y, truth], -1).reshape(-1, 3)
    seen = []
    for photo in photos:  # half a window from the edge
        px, size = photo.project(points), np.array(photo.grey.shape[::-1])
        seen.append(((px > 4) & (px < size - 5)).all(1))
    both = np.any([seen[i] & seen[j] for i, j in PAIRS], axis=0).reshape(X.shape)
    found = stereo.quality(s.z, truth, both)
    base = np.linalg.norm(photos[1].exterior[:3] - photos[0].exterior[:3])
    assert found.nmad < 0.3 * (1000 / base) * (1000 / 24 * 5.49e-3)
    assert found.completeness > 0.95
    assert HEIGHTS[0] <= np.nanmin(s.z) and np.nanmax(s.z) <= HEIGHTS[1]


def test_processes_write_the_same_bytes_though_one_is_killed(
    photos, serial, empty, tmp_path
):
    deadly = replaced(photos, 2, blocks.Deadly, tmp_path)
    found = plot(deadly, empty, workers=2)
    assert content(empty) == serial[1]
    np.testing.assert_array_equal(found.surface.z, serial[0].surface.z)
    np.testing.assert_array_equal(found.surface.measured, serial[0].surface.measured)
    assert [p.points for p in found.pairs] == [p.points for p in serial[0].pairs]
    assert sorted(p.attempts for p in found.pairs) == [1, 1, 2]


def test_photos_in_memory_give_the_same_pairs_and_are_known_again(block, serial, empty):
    plot(block[0], empty)
    found = {k: v for k, v in content(empty).items() if not k.startswith("photos")}
    assert found == serial[1]
    assert statuses(plot(block[0], empty)) == ["found"] * 3


def test_after_a_stop_only_what_is_missing_is_plotted(photos, serial, empty, tmp_path):
    counted = replaced(photos, 1, blocks.Counted, tmp_path)
    plot(counted, empty)
    (empty / "pair_00000_00001.npz").unlink()
    whole = (empty / "pair_00002_00003.npz").read_bytes()
    (empty / "pair_00002_00003.npz").write_bytes(whole[:-50])  # a disk lost its power
    (tmp_path / "log.txt").unlink()
    assert statuses(plot(counted, empty)) == ["plotted", "found", "plotted"]
    assert (tmp_path / "log.txt").read_text().split() == ["1.npy"]
    assert content(empty) == serial[1]


def test_a_stop_by_hand_loses_nothing_that_was_plotted(
    photos, serial, empty, monkeypatch
):
    plot_pair = module.plot_pair

    def stopped(task):
        if task.pair >= (1, 2):
            raise KeyboardInterrupt
        return plot_pair(task)

    monkeypatch.setattr(module, "plot_pair", stopped)
    with pytest.raises(KeyboardInterrupt):
        plot(photos, empty)
    monkeypatch.undo()
    assert statuses(plot(photos, empty)) == ["found", "plotted", "plotted"]
    assert content(empty) == serial[1]


def test_a_pair_that_failed_is_tried_again(photos, serial, empty, tmp_path):
    failing = replaced(photos, 2, blocks.Failing, tmp_path, times=2)
    found = plot(failing, empty, retries=2)
    assert [p.attempts for p in found.pairs] == [1, 2, 2]
    assert content(empty) == serial[1]


@pytest.mark.parametrize(
    "kind, workers, attempts, reason",
    [
        (blocks.Failing, 1, 2, "RuntimeError: a disk was asleep"),
        pytest.param(
            blocks.Deadly,
            2,
            2,
            "BrokenProcessPool: its process died",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_pair_that_cannot_be_plotted_is_named_and_the_rest_goes_on(
    photos, serial, empty, tmp_path, kind, workers, attempts, reason
):
    bad = replaced(photos, 3, kind, tmp_path, times=99)
    found = plot(bad, empty, workers=workers)
    (pair,) = found.failed
    assert (pair.left, pair.right, pair.attempts) == (2, 3, attempts)
    assert pair.reason.startswith(reason)
    assert not pair.file.exists() and len(found.files) == 4
    for name in ("pair_00000_00001.npz", "pair_00001_00002.npz"):
        assert content(empty)[name] == serial[1][name]


def test_a_full_disk_stops_the_run(photos, empty, tmp_path):
    with pytest.raises(OSError, match="disk is full.*make room"):
        plot(replaced(photos, 1, blocks.Full, tmp_path), empty)


@pytest.mark.parametrize("damage", ['{"cell": 1.', "[1]", "\0"])
def test_a_damaged_list_is_said_and_written_anew_only_when_told(photos, empty, damage):
    plot(photos, empty, PAIRS[:1])
    whole = content(empty)
    (empty / "block.json").write_text(damage)
    with pytest.raises(FileExistsError, match="block.json is damaged: let overwrite"):
        plot(photos, empty, PAIRS[:1])
    assert (empty / "block.json").read_text() == damage
    assert plot(photos, empty, PAIRS[:1], overwrite=True).pairs[0].status == "found"
    assert content(empty) == whole


@pytest.mark.parametrize(
    "changed",
    [
        {"cell": 2.0},
        {"heights": (-4.0, 65.0)},
        {"matching": {"window": 9}},
        {"largest_gap": 9.0},
    ],
)
def test_a_folder_of_other_numbers_is_refused_until_told(photos, empty, changed):
    plot(photos, empty, PAIRS[:1])
    (name,) = changed
    with pytest.raises(FileExistsError, match=f"another block: {name} was .* and is "):
        plot(photos, empty, PAIRS[:1], **changed)
    found = plot(photos, empty, PAIRS[:1], overwrite=True, **changed)
    assert statuses(found) == ["plotted"]


def test_more_pairs_may_come_later_but_no_other_orientation_until_told(
    photos, serial, empty
):
    plot(photos, empty, PAIRS[:2])
    assert statuses(plot(photos, empty)) == ["found", "found", "plotted"]
    assert content(empty) == serial[1]
    moved = (*photos[3].exterior[:2], 1021.0, *photos[3].exterior[3:])
    other = [*photos[:3], dataclasses.replace(photos[3], exterior=moved)]
    with pytest.raises(FileExistsError, match=r"photos\[3\] is another"):
        plot(other, empty)
    found = plot(other, empty, overwrite=True)
    assert statuses(found) == ["found", "found", "plotted"]


def test_a_folder_of_other_things_is_refused(photos, empty):
    (empty / "letter.txt").write_text("dear")
    with pytest.raises(FileExistsError, match="other files in it, not a block"):
        plot(photos, empty)


@pytest.mark.parametrize("how", ["mean", "median"])
def test_the_size_of_the_tiles_changes_nothing(serial, tmp_path, monkeypatch, how):
    files = [p.file for p in serial[0].pairs]
    whole = module.merge(files, 1.0, tmp_path, how)
    monkeypatch.setattr(module, "TILE", 7)
    tiled = module.merge(files, 1.0, tmp_path, how)
    np.testing.assert_array_equal(whole.z, tiled.z)
    np.testing.assert_array_equal(whole.measured, tiled.measured)


def test_where_pairs_overlap_measured_heights_are_weighted(tmp_path):
    """Four surfaces of two cells, by hand."""
    surfaces = [
        ([[1.0, 2.0]], [[1, 0]], (0, 0)),
        ([[4.0, np.nan]], [[3, 0]], (0, 0)),
        ([[6.0, 10.0]], [[0, 4]], (1, 0)),
        ([[np.nan, 99.0]], [[0, 0]], (1, 0)),
    ]
    files = [tmp_path / f"{k}.npz" for k in range(4)]
    for file, (z, weight, first) in zip(files, surfaces):
        layers = {"z": np.float32(z), "weight": np.float32(weight)}
        np.savez(file, box=np.array([*first, 2, 1]), **layers)
    mean = module.merge(files, 0.5, tmp_path, "mean")
    # cell 0: (1 + 3 * 4) / 4; cell 1: nowhere measured, so 2 and 6; cell 2: 10 alone
    np.testing.assert_allclose(mean.z, [[3.25, 4, 10]])
    assert mean.measured.tolist() == [[True, False, True]]
    assert mean.corner == (0.25, -0.25)
    median = module.merge(files, 0.5, tmp_path, "median")
    np.testing.assert_allclose(median.z, [[2.5, 4, 10]])


@pytest.mark.parametrize(
    "turn, heights, words",
    [
        (0.003, HEIGHTS, "orientation is wrong. .* omega corrected by -0.17"),
        (0.0, (15, 20), "matched points lie between 15 and 20 m: are these the"),
    ],
)
def test_a_pair_whose_heights_are_in_doubt_says_so_each_time(
    photos, empty, turn, heights, words
):
    turned = dataclasses.replace(
        photos[1], exterior=np.array(photos[1].exterior) + [0, 0, 0, turn, 0, 0]
    )
    for status in ("plotted", "found"):
        with pytest.warns(UserWarning, match=r"1 of 1 .* in doubt; .* \(0, 1\): "):
            found = plot([photos[0], turned], empty, [(0, 1)], heights=heights)
        assert found.pairs[0].status == status
        assert re.search(words, found.pairs[0].remark)


def test_neighbours_are_those_that_overlap_enough(block, photos):
    for given in (block[0], photos):  # of files no grey value is read
        assert stereo.neighbours(given, ground=20).tolist() == [[0, 1], [1, 2], [2, 3]]
    more = stereo.neighbours(block[0], ground=20, least=0.15)
    assert more.tolist() == [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]]


def test_overlap_is_a_share_of_the_smaller_footprint():
    """From twice the height: four times the ground, and most of the other's."""
    low, high = (
        Photo(np.zeros((80, 100)), Camera(20.0), (X, 0, Z, 0, 0, 0), 0.2)
        for X, Z in ((0, 500), (300, 1000))
    )
    # 100 x 0.2 mm at 1 : 25 000 are 500 m, of which 450 m lie below the other photo
    assert stereo.neighbours([low, high], ground=0, least=0.85).tolist() == [[0, 1]]


def test_the_system_of_a_geotiff_is_taken_over_where_it_fits_the_station(
    tmp_path, block, photos, empty
):
    pytest.importorskip("rasterio")

    def placed(k, east=0.0):
        """Photo k in a file with its place on the map, in pixels of 0.25 m."""
        grey, (X0, Y0) = block[0][k].grey, photos[k].exterior[:2]
        rows, columns = grey.shape
        corner = X0 + east - columns / 8, Y0 + rows / 8
        transform = [[0.25, 0, corner[0]], [0, -0.25, corner[1]]]
        raster = geotiff.Raster(grey, grey < 0, transform, "EPSG:32748")
        path = geotiff.write(tmp_path / f"{k}_{east:g}.tif", raster)
        return dataclasses.replace(photos[k], path=path)

    files = [placed(0), placed(1)]
    assert photos[0].read().crs is None
    assert placed(0, east=5000.0).read().crs is None  # it is on another map
    assert dataclasses.replace(photos[0], crs="EPSG:32633").read().crs == "EPSG:32633"
    pair = stereo.epipolar_pair(*(file.read() for file in files), HEIGHTS)
    points = stereo.intersect(pair, stereo.match_dense(pair))
    assert points.crs == stereo.surface(points, 1.0).crs == "EPSG:32748"
    assert plot(files, empty, [(0, 1)]).surface.crs == "EPSG:32748"
    other = dataclasses.replace(photos[1], crs="EPSG:32633")
    pair = stereo.epipolar_pair(files[0].read(), other.read(), HEIGHTS)
    assert pair.crs is None  # they do not agree


def test_how_wide_gaps_are_filled_is_passed_on(photos, serial, empty):
    found = plot(photos, empty, PAIRS[:1], largest_gap=0.1).surface
    assert found.largest_gap == 0.1
    assert found.filled < 0.5 * serial[0].surface.filled


@pytest.mark.parametrize(
    "changed, error, words",
    [
        ({"pairs": []}, ValueError, "pairs is empty"),
        ({"pairs": [(0, 0)]}, ValueError, "paired with itself"),
        ({"pairs": [(0, 1), (0, 1)]}, ValueError, "same pair more than once"),
        ({"folder": "no/such"}, FileNotFoundError, "is not a folder: make it first"),
        ({"heights": (60, 0)}, ValueError, "low < high"),
        ({"heights": (300, 400)}, ValueError, r"none of the 1 .* 0 of \d+ matched"),
        ({"workers": 0}, ValueError, "workers must be a whole number, at least 1"),
        ({"merging": "sum"}, ValueError, "merging must be one of"),
        ({"photos": [1, 2]}, ValueError, "photos must be a sequence of camera.Photo"),
        ({"matching": {"widow": 9}}, ValueError, "^matching: .* argument 'widow'"),
        ({"matching": {"window": 8}}, ValueError, "^matching: window must be an odd"),
    ],
)
def test_bad_arguments_are_named(photos, empty, changed, error, words):
    with pytest.raises(error, match=words):
        plot(**({"photos": photos, "folder": empty, "pairs": [(0, 1)]} | changed))
