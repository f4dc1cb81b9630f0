"""Parts of the tables of chapter 3, repeated.

The whole is made by ``python -m pgm_book.ch03.studies.precision``, ``pull_in`` and
``real``; this proves what the tables are cited for, and that the scripts still say what
the tables do.
"""

from itertools import islice

import numpy as np
import pytest

from pgm_book.ch03.studies import precision, pull_in, real
from pgm_book.common import results


def table(name):
    return results.rows("ch03", name)


def stored(name, row, columns, keys):
    """The row of a table that has the same keys as `row`, and that row by name."""
    named = dict(zip(columns, map(str, row), strict=True))
    (found,) = [t for t in table(name) if all(t[key] == named[key] for key in keys)]
    return found, named


def number(rows, column):
    return np.array([float(row[column]) for row in rows])


def modelled(rows):
    """Rows with noise where the adjustment has the right model."""
    return [
        row
        for row in rows
        if (float(row["sigma"]) > 0 or row["grey"] == "8 bit")
        and (row["gain_offset"] == "same" or row["h0_h1"] == "estimated")
    ]


def test_every_row_of_the_precision_has_a_thousand_points():
    rows = table("precision")
    assert tuple(rows[0]) == precision.COLUMNS
    assert len(rows) == 2 * 4 * 5 * 2
    assert number(rows, "points").min() >= 1000


def test_precision_is_near_the_bound():
    """The aims: soft texture and noise 1, sharp texture and noise 2."""
    for kind, sigma, aim in (("soft", "1.0", 1.03), ("sharp", "2.0", 1.25)):
        rows = [
            row
            for row in modelled(table("precision"))
            if row["texture"] == kind
            and row["sigma"] == sigma
            and row["contrast"] == "40.0"
        ]
        assert len(rows) == 6
        assert number(rows, "rms_over_bound").max() < aim


def test_predicted_standard_deviations_hold_where_the_model_does():
    rows = modelled(table("precision"))
    ratio = number([row for row in rows if row["sigma"] != "0.0"], "converged")
    assert np.all(ratio == 1)
    noisy = [row for row in rows if row["sigma"] != "0.0"]
    assert np.abs(number(noisy, "predicted_over_sampled_sd") - 1).max() < 0.06
    assert np.abs(number(noisy, "sigma0_over_expected") - 1).max() < 0.04


def test_two_radiometric_parameters_cost_nothing_and_leaving_them_out_much():
    rows = {tuple(row[k] for k in precision.KEYS): row for row in table("precision")}
    for kind in ("soft", "sharp"):
        case = kind, "40.0", "1.0", "float"
        rms = {key: float(rows[*case, *key]["rms_px"]) for key in precision.RADIOMETRY}
        assert rms["same", "estimated"] < 1.02 * rms["same", "left out"]
        assert rms["1.08 and 4", "left out"] > 2.5 * rms["1.08 and 4", "estimated"]


SOFT_AND_SHARP = pytest.mark.parametrize(
    "kind", [pytest.param("soft", marks=pytest.mark.slow), "sharp"]
)


@pytest.mark.slow
@SOFT_AND_SHARP
def test_the_script_still_says_what_the_table_of_precision_does(kind):
    """1100 points: the ratios are uncertain by 1.5 per cent; five times that."""
    rows = islice(precision.rows(kind, 40.0, few=1, many=1), 4)
    for row in rows:
        old, new = stored("precision", row, precision.COLUMNS, precision.KEYS)
        assert new["converged"] == old["converged"] == "1.0000"
        for column in ("rms_over_bound", "predicted_over_sampled_sd"):
            if old["sigma"] != "0.0":
                assert float(new[column]) == pytest.approx(float(old[column]), rel=0.08)


def test_a_match_arrives_from_three_pixels_away_and_less_often_from_five():
    rows = table("pull_in")
    assert tuple(rows[0]) == pull_in.PULL_IN
    assert len(rows) == 2 * 3 * 21
    at_21 = [row for row in rows if row["window"] == "21"]
    near = [row for row in at_21 if float(row["start_error_px"]) <= 3]
    assert number(near, "arrived").min() > 0.99
    assert number(near, "false").max() == 0
    far = [row for row in at_21 if float(row["start_error_px"]) == 5]
    assert number(far, "arrived").max() < 0.95
    assert number(at_21, "false").max() <= 0.002


@pytest.mark.slow
@SOFT_AND_SHARP
def test_the_script_still_says_what_the_table_of_pull_in_does(kind):
    """200 of the 1000 points: binomial, five standard deviations and one point."""
    keys = "texture", "window", "start_error_px"
    for row in pull_in.pull_in(kind, 21, (1.0, 3.0, 5.0), n=200):
        old, new = stored("pull_in", row, pull_in.PULL_IN, keys)
        for column in ("arrived", "false"):
            p = float(old[column])
            allowed = 5 * np.sqrt(p * (1 - p) / 200) + 0.006
            assert abs(float(new[column]) - p) < allowed


def test_precision_grows_with_the_window_as_the_bound_says():
    rows = table("windows")
    assert tuple(rows[0]) == pull_in.WINDOWS
    for kind in pull_in.TEXTURES:
        of_kind = [row for row in rows if row["texture"] == kind]
        assert number(of_kind, "window").tolist() == list(pull_in.SIZES)
        assert np.all(np.diff(number(of_kind, "bound_px")) < 0)
        large = [row for row in of_kind if int(row["window"]) >= 15]
        assert np.abs(number(large, "rms_over_bound") - 1).max() < 0.05


@pytest.mark.parametrize("size", [15, pytest.param(25, marks=pytest.mark.slow)])
def test_the_script_still_says_what_the_table_of_windows_does(size):
    """One texture of two, 890 points: five times the uncertainty of 1.7 per cent."""
    for row in pull_in.windows("sharp", (size,), seeds=1):
        keys = "texture", "window"
        old, new = stored("windows", row, pull_in.WINDOWS, keys)
        for column in ("rms_over_bound", "rms_px"):
            assert float(new[column]) == pytest.approx(float(old[column]), rel=0.085)


def test_real_images_are_matched_to_a_twentieth_of_a_pixel():
    rows = table("real")
    assert tuple(rows[0]) == real.COLUMNS
    at_21 = [r for r in rows if r["window"] == "21" and r["image"] == "orthophoto"]
    assert number(at_21, "rms").max() < 0.055
    assert number(at_21, "false").max() == 0


def test_the_script_still_says_what_the_table_of_real_images_does():
    """No chance here: interpolation differs a little between versions of OpenCV."""
    keys = "image", "factor", "shift_x", "shift_y", "window", "tolerance"
    for row in (
        *real.shrunk(4, (1, 0), windows=(21,)),
        *real.landsat(windows=(31,)),
    ):
        old, new = stored("real", row, real.COLUMNS, keys)
        for column in ("mean_x", "mean_y", "rms", "median_predicted_sd"):
            assert float(new[column]) == pytest.approx(float(old[column]), abs=2e-3)
        assert new["converged"] == old["converged"]
