"""The choices of parameters of chapter 5, a part of them repeated.

The whole is made by ``python -m pgm_book.ch05.studies.parameters``.
"""

import numpy as np
import pytest

from pgm_book.ch05.studies import parameters as study
from pgm_book.common import results

TABLE = results.rows("ch05", "parameters")


def test_table_has_all_choices_and_the_five_best_of_each():
    assert tuple(TABLE[0]) == study.COLUMNS
    counts = {(r["out_of"], r["number"]): int(r["choices"]) for r in TABLE}
    assert list(counts.values()) == [26, 325, 2600, 861, 11480]
    for row in TABLE:
        assert int(row["settled"]) > 0.99 * int(row["choices"])
    assert [row["rank"] for row in TABLE] == list("12345") * 5


def test_misclosure_has_its_derivatives():
    x, points, h = np.zeros((1, 42)), study.START[None], 1e-6
    _, A, B = study.misclosure(x, points)
    for k in range(42):
        e = h * np.eye(42)[k]
        high, low = (study.misclosure(x + s * e, points)[0] for s in (1, -1))
        np.testing.assert_allclose(A[..., k], (high - low) / (2 * h), 1e-6, atol=1e-6)
    for k in range(3):
        e = h * np.eye(3)[k]
        high, low = (study.misclosure(x, points + s * e)[0] for s in (1, -1))
        np.testing.assert_allclose(B[..., k], (high - low) / (2 * h), 1e-6, atol=1e-6)


SIZES = (26, 1), (26, 2), pytest.param((42, 2), marks=pytest.mark.slow)


@pytest.mark.parametrize("size", SIZES)
def test_script_still_says_what_the_table_does(size):
    rows = [tuple(map(str, row)) for row in study.rows(*size)]
    stored = [r for r in TABLE if (int(r["out_of"]), int(r["number"])) == size]
    for row, kept in zip(rows, stored, strict=True):
        row = dict(zip(study.COLUMNS, row, strict=True))
        # Equal choices, such as Z0 of either photo, may change places
        assert float(row["sigma0_px"]) == pytest.approx(float(kept["sigma0_px"]), 2e-3)
        assert {k: row[k] for k in ("choices", "rank")} == {
            k: kept[k] for k in ("choices", "rank")
        }
