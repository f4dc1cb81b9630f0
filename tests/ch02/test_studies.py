"""A part of the study of window sizes in chapter 2, repeated.

The whole is made by ``python -m pgm_book.ch02.studies.windows``; this proves that the
script still says what the table does, not the times in it.
"""

import numpy as np
import pytest

from pgm_book.ch02.studies import windows
from pgm_book.common import results

TABLE = results.rows("ch02", "windows")


def column(name, scene, **where):
    chosen = [
        row
        for row in TABLE
        if row["scene"] == scene and all(row[k] == str(v) for k, v in where.items())
    ]
    return np.array([float(row[name]) for row in chosen])


def test_table_holds_all_sizes_of_all_scenes():
    assert tuple(TABLE[0]) == windows.COLUMNS
    sizes = len(windows.TEMPLATES) * len(windows.REACHES)
    for scene in windows.SCENES:
        assert len(column("success", scene)) == sizes
        assert np.all(column("points", scene) == windows.POINTS)


@pytest.mark.parametrize("scene", windows.SCENES)
def test_rows_repeat(scene):
    pair = windows.SCENES[scene](windows.POINTS)
    *shares, rms, predicted, _ = windows.row(pair, 9, 5)
    where = {"template": 9, "reach_px": 5}
    printed = [
        column(name, scene, **where)[0]
        for name in ("success", "matched", "wrong", "rms_px", "predicted_px")
    ]
    # Three points of a thousand may round otherwise in another version of a library
    np.testing.assert_allclose((*shares, rms, predicted), printed, atol=0.003)


def test_a_larger_template_is_more_precise_where_the_ground_is_flat():
    rms = column("rms_px", "orthophoto", reach_px=15)
    assert np.all(np.diff(rms) < 0) and rms[0] > 3 * rms[-1]


def test_a_larger_template_fails_more_often_where_it_spans_a_step_in_depth():
    success = column("success", "stereo pair", reach_px=15)
    assert np.all(np.diff(success[1:]) < 0)
    assert np.all(np.diff(column("wrong", "stereo pair", reach_px=15)) > 0)


def test_on_slopes_there_is_a_best_template():
    rms = column("rms_px", "texture", reach_px=15)
    assert list(windows.TEMPLATES)[rms.argmin()] == 15


def test_a_wider_search_finds_fewer_and_costs_more():
    for scene in windows.SCENES:
        for template in (5, 21):
            success = column("success", scene, template=template)
            assert np.all(np.diff(success) <= 0)
            time = column("time", scene, template=template)
            assert time[-1] > 4 * time[0]


def test_predicted_precision_is_of_the_order_of_the_error_and_never_above_it():
    """Parallax, slopes and mismatches are no part of the prediction."""
    for scene in windows.SCENES:
        ratio = column("predicted_px", scene) / column("rms_px", scene)
        assert np.all(ratio < 1) and np.all(ratio > 0.1)
