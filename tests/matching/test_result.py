"""A table of matches holds all of them; the bundle reads what becomes of them."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import bundle, frames, matching, observations
from pgm_lab.camera import Camera
from tests.matching import scenes

LEFT, RIGHT, H = scenes.warped(size=(300, 360))
SIZE = (360, 300)


@pytest.fixture(scope="module")
def found():
    points = [(180.25, 150), (3, 3), (200, 120.5), (150, 130)]
    return matching.match(LEFT, RIGHT, points)


def test_the_table_holds_every_number_and_what_became_of_each_point(found, tmp_path):
    path = tmp_path / "new folder" / "found.csv"
    found.save(path)
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["point"] for row in rows] == ["0", "1", "2", "3"]
    assert [row["status"] for row in rows] == found.status.tolist()
    assert rows[1]["right column"] == rows[1]["quality"] == ""
    numbers = {
        "left column": found.chosen[:, 0],
        "left row": found.chosen[:, 1],
        "right column": found.points[:, 0],
        "right row": found.points[:, 1],
        "variance column": found.covariance[:, 0, 0],
        "covariance": found.covariance[:, 0, 1],
        "variance row": found.covariance[:, 1, 1],
        "r": found.r,
        "quality": found.quality,
    }
    assert set(numbers) | {"point", "status"} == set(rows[0])
    for name, values in numbers.items():
        read = [float(row[name] or "nan") for row in rows]
        np.testing.assert_array_equal(read, values)


def test_covariances_are_shared_between_the_photos_through_the_shape(found):
    seen = observations.from_matches(found.chosen, {"B": found}, SIZE, 0.01, left="A")
    n = int(found.accepted.sum())
    assert seen.photo == ("A",) * n + ("B",) * n and seen.point == (0, 2, 3) * 2
    good = found.accepted
    xy, C = frames.pixel_to_photo(
        found.points[good], SIZE, 0.01, covariance=found.covariance[good]
    )
    np.testing.assert_allclose(seen.xy[n:], xy)
    mirror = np.diag([1, -1])  # y of a photo goes up
    J = mirror @ found.shape[good] @ mirror
    whole = seen.covariance[n:] + J @ seen.covariance[:n] @ J.swapaxes(1, 2)
    np.testing.assert_allclose(whole, C, rtol=1e-9)
    assert not np.allclose(found.shape[good], np.eye(2), atol=0.1)


def test_the_bundle_reads_the_saved_observations(found, tmp_path):
    seen = observations.from_matches(
        found.chosen, {2: found}, SIZE, 0.01, left=1, points=[10, 11, 12, 13]
    )
    seen.save(tmp_path / "image.csv")
    interior, exterior, points = (
        tmp_path / name for name in ("interior.txt", "exterior.txt", "points.txt")
    )
    interior.write_text("5 0 0 0 0 0 0 0 0 0")
    exterior.write_text("1 0 0 0 0 0 50\n2 0 0 0 10 0 50")
    points.write_text("10 0 0 0\n12 1 0 0\n13 0 1 0")
    read = bundle.read(interior, exterior, points, tmp_path / "image.csv")
    np.testing.assert_array_equal(read.xy, seen.xy)
    sigma = np.sqrt(seen.covariance[:, [0, 1], [0, 1]])
    np.testing.assert_array_equal(read.sigma, sigma)
    assert [read.point_names[i] for i in read.point] == list(seen.point)
    assert [read.photo_names[i] for i in read.photo] == list(seen.photo)
    network = bundle.Network.of(
        Camera(5.0),
        {1: (0, 0, 50, 0, 0, 0), 2: (10, 0, 50, 0, 0, 0)},
        {10: (0, 0, 0), 12: (1, 0, 0), 13: (0, 1, 0)},
        seen.rows,
    )
    np.testing.assert_array_equal(network.xy, read.xy)
    np.testing.assert_array_equal(network.covariance, seen.covariance)


def test_names_that_are_no_numbers_cannot_be_saved(found, tmp_path):
    seen = observations.from_matches(found.chosen, {"B": found}, SIZE, 0.01, left="A")
    with pytest.raises(ValueError, match="names of photos must be whole numbers.*'A'"):
        seen.save(tmp_path / "image.csv")
    seen = observations.from_matches(found.chosen, {"01": found}, SIZE, 0.01, left=1)
    with pytest.raises(ValueError, match="names of photos 1 and '01' are the same"):
        seen.save(tmp_path / "image.csv")
    assert not list(tmp_path.iterdir())


def test_matches_of_other_points_or_sizes_are_refused(found):
    def of(chosen=found.chosen, match=found, size=SIZE):
        return observations.from_matches(chosen, {"B": match}, size, 0.01, left="A")

    with pytest.raises(ValueError, match="has other points than left_points"):
        of(chosen=found.chosen + 1)
    with pytest.raises(ValueError, match=r"with photos of \(360, 300\) and \(360, 300"):
        of(size=(300, 360))
    with pytest.raises(ValueError, match="all photos must have the same size"):
        of(match=replace(found, right_size=(50, 60)))
