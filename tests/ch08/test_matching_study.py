"""A part of the tables of dense matching, repeated, and what they are cited for."""

import numpy as np
import pytest

from pgm_book.ch08.studies import matching as study
from pgm_book.common import results
from pgm_lab import stereo
from tests.stereo.pairs import rms


def table(**keys):
    rows = results.rows("ch08", "matching")
    found = [r for r in rows if all(r[k] == str(v) for k, v in keys.items())]
    assert found
    return found


def one(**keys):
    (row,) = table(**keys)
    return row


def default(**keys):
    return dict(
        method="pgm_lab", window=7, threshold="0.80", levels=6, refine=True
    ) | keys  # fmt: skip


@pytest.fixture(scope="module")
def scenes():
    return study.aerial((240, 180))


@pytest.fixture(scope="module")
def aerial(scenes):
    left, right, truth, where = scenes["open"]
    return stereo.match_rows(left, right, method="ncc"), truth, where


def test_errors_on_open_ground_are_as_large_as_predicted(aerial):
    """1.2 times at most, without a single blunder, on 80 % of the cells."""
    match, truth, where = aerial
    error = (match.disparity - truth)[where]
    given = np.isfinite(error)
    assert given.mean() > 0.8
    assert np.abs(error[given]).max() < 1
    assert 0.8 < rms(error[given]) / rms(match.sd[where][given]) < 1.2
    assert abs(error[given].mean()) < 0.01


def test_least_squares_halves_nearly_the_error_of_correlation_on_open_ground(
    scenes, aerial
):
    match, truth, where = aerial
    left, right, *_ = scenes["open"]
    coarse = stereo.match_rows(left, right, method="ncc", refine=False)
    both = where & (match.status == 0) & (coarse.status == 0)
    errors = [rms((m.disparity - truth)[both]) for m in (match, coarse)]
    assert errors[0] < 0.75 * errors[1]


def test_what_the_right_photo_does_not_show_is_rejected(scenes, aerial):
    """Of hidden cells hardly any is matched."""
    match, truth, _ = aerial
    seen = scenes["open"][3] | scenes["objects"][3]
    hidden = scenes["hidden"][3]
    assert not (seen & hidden).any()
    assert (match.status[hidden] == 0).mean() < 0.05


@pytest.mark.slow
def test_the_row_of_the_motorcycle_is_the_stored_one():
    scenes = study.motorcycle()
    (row,) = study.rows(scenes, 7, (0.8,), 6, True)
    stored = one(**default(scene="motorcycle"))
    for name, value in zip(study.COLUMNS[6:], row[6:], strict=True):
        assert float(value) == pytest.approx(float(stored[name]), abs=0.003)


def test_beside_sgbm_fewer_cells_are_wrong_and_fewer_are_given():
    ours = one(**default(scene="motorcycle"))
    peer = one(scene="motorcycle", method="SGBM")
    assert float(ours["wrong"]) < 0.75 * float(peer["wrong"])
    assert float(ours["density"]) < float(peer["density"])
    assert float(ours["rmse"]) < 0.8 * float(peer["rmse"])


def test_on_open_ground_more_cells_are_given_and_errors_are_below_a_third_of_sgbm():
    ours = one(**default(scene="open"))
    peer = one(scene="open", method="SGBM")
    assert float(ours["density"]) > float(peer["density"])
    assert float(ours["rmse"]) < 0.33 * float(peer["rmse"])
    assert float(ours["rmse"]) < 1.2 * float(ours["predicted"])


@pytest.mark.parametrize("scene", ["objects", "motorcycle"])
def test_a_higher_threshold_has_fewer_wrong_and_loses_more(scene):
    rows = table(scene=scene, method="pgm_lab", window=7, levels=6, refine=True)
    rows.sort(key=lambda row: float(row["threshold"]))
    wrong, lost = ([float(row[k]) for row in rows] for k in ("wrong", "lost"))
    assert [row["threshold"] for row in rows] == [f"{t:.2f}" for t in study.THRESHOLDS]
    assert wrong == sorted(wrong, reverse=True)
    assert lost == sorted(lost)


def test_without_a_pyramid_the_search_is_too_short():
    alone = one(**default(scene="motorcycle", levels=1))
    assert float(alone["right"]) < 0.1


def test_time_and_memory_grow_with_the_cells_alone():
    """At most 10 times SGBM; 12 megapixels in less than 2 GB."""
    rows = results.rows("ch08", "matching_size")
    cells, memory, each, ratio = (
        np.array([float(row[name]) for row in rows])
        for name in ("million_cells", "bytes_a_cell", "us_a_cell", "ours_to_sgbm")
    )
    assert cells[-1] > 12
    assert (ratio <= 10).all()
    assert memory[-1] * cells[-1] < 2000
    assert np.all(np.diff(memory) < 0)
    assert each.max() < 1.5 * each.min()
