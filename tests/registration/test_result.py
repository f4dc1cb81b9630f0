"""The result of a registration: its sums, its table, and what it says of nothing."""

import csv
import io

import numpy as np
import pytest

from pgm_lab import datasets, matching
from pgm_lab.registration import accuracy, register

SCENE = datasets.landsat().grey
HERE, ELSEWHERE = SCENE[:400, :400], SCENE[600:1000, 700:1100]
POINTS = np.array([(x, y) for x in range(20, 381, 40) for y in range(20, 381, 40)])
SUMS = ("accuracy", "rmse_x", "rmse_y", "rmse_t", "ce90")


def found():
    return register(HERE, np.roll(HERE, (1, -2), axis=(0, 1)), [(3, 9), *POINTS])


def test_the_sums_are_those_of_the_accepted_shifts():
    one = found()
    assert 50 < one.accepted.sum() < len(one.points)
    dx, dy = one.dx[one.accepted], one.dy[one.accepted]
    assert one.accuracy == accuracy(dx, dy) and one.accuracy.n == len(dx)
    assert one.rmse_x == np.sqrt(np.mean(dx**2))  # (Br 2)
    assert one.rmse_y == np.sqrt(np.mean(dy**2))  # (Br 3)
    assert one.rmse_t == np.hypot(one.rmse_x, one.rmse_y)  # (Br 4)
    assert one.ce90 == np.quantile(np.hypot(dx, dy), 0.9)
    C = one.covariance
    np.testing.assert_allclose(one.sd**2, (C[:, 0, 0] + C[:, 1, 1]) / 2)


@pytest.mark.parametrize("refine", [None, "parabola", "lsm"])
@pytest.mark.parametrize("radius", [3, 10])
def test_of_two_different_places_nothing_is_accepted(refine, radius):
    one = register(HERE, ELSEWHERE, POINTS, radius=radius, refine=refine)
    assert not one.accepted.any()
    for name in SUMS:
        with pytest.raises(ValueError, match="none of 100 chips is accepted") as error:
            getattr(one, name)
        words = str(error.value)
        for status in set(one.status):
            assert f"{np.sum(one.status == status)} {status}" in words
        most = max(set(one.status), key=list(one.status).count)
        assert matching.STATUSES[most][1] in words and "larger than the radius" in words


def test_without_points_the_sums_say_so():
    one = register(HERE, HERE, np.zeros((0, 2)))
    with pytest.raises(ValueError, match="there are no chips.*Give points"):
        one.rmse_t  # noqa: B018


def test_the_table_is_read_again_as_it_was(tmp_path):
    one = found()
    one.save(tmp_path / "new" / "shifts.csv")
    text = (tmp_path / "new" / "shifts.csv").read_text(encoding="utf-8")
    assert text == one.csv()
    head, *rows = csv.reader(io.StringIO(text))
    assert all(len(row) == len(head) for row in rows) and len(rows) == len(one.points)
    assert head[3] == "shift of the column (px; sensed minus reference)"
    numbers = np.array([[float(v) if v else np.nan for v in row[:-1]] for row in rows])
    np.testing.assert_array_equal(numbers[:, 0], np.arange(len(rows)))
    np.testing.assert_array_equal(numbers[:, 1:3], one.points)
    columns = one.dx, one.dy, one.r, one.second
    np.testing.assert_array_equal(numbers[:, 3:7], np.stack(columns, axis=1))
    entries = one.covariance[:, [0, 0, 1], [0, 1, 1]]
    np.testing.assert_array_equal(numbers[:, 7:10], entries)
    assert [row[-1] for row in rows] == list(one.status)


def test_a_table_is_not_overwritten_unasked(tmp_path):
    path = tmp_path / "shifts.csv"
    path.write_text("mine")
    with pytest.raises(FileExistsError):
        found().save(path)
    with pytest.raises(ValueError, match="overwrite"):
        found().save(path, overwrite="yes")
    assert path.read_text() == "mine"
    found().save(path, overwrite=True)
    assert path.read_text() == found().csv()
    with pytest.raises(ValueError, match="path must be the name of a file"):
        found().save(3)
