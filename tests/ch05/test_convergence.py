"""A part of the convergence table of chapter 5, repeated.

The whole is made by ``python -m pgm_book.ch05.studies.convergence``; this does not
prove its 1000 cases, only that the script still says what the table does.
"""

import numpy as np
import pytest

from pgm_book.ch05.studies import convergence
from pgm_book.common import results

TABLE = results.rows("ch05", "convergence")


def rate(row):
    return int(row["converged"]) / int(row["cases"])


def test_table_has_a_thousand_cases_in_each_row_and_250_of_relative_orientation():
    assert tuple(TABLE[0]) == convergence.COLUMNS
    for row in TABLE:
        few = row["problem"] == "relative orientation"
        assert row["cases"] == ("250" if few else "1000")
    kinds = {(row["problem"], row["points"], row["object"]) for row in TABLE}
    assert len(kinds) == 12


def test_resection_and_intersection_miss_no_more_often_than_they_name_ambiguity():
    """Not proven: that the misses are the ambiguous cases (four of these five are)."""
    ours = [row for row in TABLE if row["method"] in ("resect", "intersect")]
    assert len(ours) == 14
    for row in ours:
        missed = int(row["cases"]) - int(row["converged"])
        assert missed <= int(row["several_solutions"]), row


def test_relative_orientation_finds_the_true_model():
    ours = [row for row in TABLE if row["method"] == "relative"]
    assert len(ours) == 8
    assert min(rate(row) for row in ours) > 0.98


def test_line_search_converges_more_often_than_full_steps():
    def rates(method):
        return np.array([rate(row) for row in TABLE if row["method"] == method])

    alone = rates("adjustment with line search alone")
    assert np.all(alone >= rates("adjustment with full steps"))
    assert alone.min() > 0.95


@pytest.mark.parametrize(
    ("problem", "arguments"),
    [
        (convergence.resection, (6, False)),
        (convergence.intersection, (2,)),
        pytest.param(
            *(convergence.relative_orientation, (10, True)), marks=pytest.mark.slow
        ),
    ],
)
def test_the_script_still_says_what_the_table_does(problem, arguments):
    """Thirty cases: no rate may differ from that of a thousand by more than chance."""
    for row in problem(*arguments, 30):
        named = dict(zip(convergence.COLUMNS, map(str, row), strict=True))
        keys = ("problem", "points", "object", "start", "method")
        (stored,) = [t for t in TABLE if all(t[key] == named[key] for key in keys)]
        p = rate(stored)
        # Once in ten thousand by the binomial distribution, at least one case
        allowed = max(1, 4 * np.sqrt(30 * p * (1 - p)))
        assert abs(int(named["converged"]) - 30 * p) <= allowed
