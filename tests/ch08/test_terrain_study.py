"""A part of the table of surface and terrain, repeated, and what it is cited for."""

import math

import pytest

from pgm_book.ch08.studies import terrain as study
from pgm_book.common import results

CLEAR = "open, 2 m from objects"


def table(part=study.PART):
    name = "x".join(map(str, part))
    return {
        (row["product"], row["zone"], row["kind"]): row
        for row in results.rows("ch08", "terrain")
        if row["part"] == name
    }


def value(product, kind, column="rmse", zone="all"):
    return float(table()[product, zone, kind][column])


@pytest.mark.slow
def test_small_part_repeats():
    stored = table(study.SAMPLE)
    found = [dict(zip(study.COLUMNS, row)) for row in study.rows(study.SAMPLE)]
    assert len(found) == len(stored)
    for row in found:
        old = stored[row["product"], row["zone"], row["kind"]]
        assert int(old["cells"]) == pytest.approx(row["cells"], rel=0.01)
        # A match at the threshold may fall to either side on another machine; where few
        # are matched, among crowns and houses, that moves what lies between them
        rel = 0.1 if row["kind"] == CLEAR else 0.2
        for column in ("completeness", "nmad"):
            assert float(old[column]) == pytest.approx(
                float(row[column]), rel=rel, abs=0.01
            )


def test_open_ground_is_as_good_as_predicted():
    for zone in ("open", "mixed", "all"):
        rmse = value("surface, measured cells", CLEAR, zone=zone)
        predicted = value("surface, measured cells", CLEAR, "predicted", zone)
        assert rmse <= 1.2 * predicted


@pytest.mark.parametrize("kind", ["building", "tree"])
def test_terrain_under_objects_is_good_to_two_decimetres_and_the_noise(kind):
    noise = value("surface, measured cells", CLEAR)
    assert value("terrain of the true surface", kind) <= 0.20
    assert value("terrain", kind) <= math.hypot(0.20, noise)
    for plain in ("opening 40 m", "opening 20 m"):
        assert value(plain, kind) > 2 * value("terrain", kind)
