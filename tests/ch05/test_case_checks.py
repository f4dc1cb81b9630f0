"""Exercise feedback of the case of chapter 5: right answers pass, slips are named."""

from pathlib import Path

import nbformat
import numpy as np
import pytest

from pgm_book.ch05 import case_checks as chapter5c
from pgm_book.common.checks import CheckFailed
from tests.common.slips import unnamed

NOTEBOOKS = Path(__file__).parents[2] / "notebooks"


def test_right_answers_pass(capsys):
    chapter5c.misprints(["b13", "b22", "b23", "b26"])
    chapter5c.misprints({"B_13", "b22 ", "b26", "b23"})
    assert capsys.readouterr().out.count("✓") == 2


@pytest.mark.parametrize(
    "answer",
    [
        np.array(["b13", "b22", "b23", "b26"]),
        np.array([["b13"], ["b22"], ["b23"], ["b26"]]),
        np.array(["b13", "b22", "b23", "b26"], dtype=object),
        ("b13", "b22", "b23", "b26"),
        frozenset({"b13", "b22", "b23", "b26"}),
        {"b13": 1, "b22": 2, "b23": 3, "b26": 4}.keys(),
        "b13, b22, b23, b26",
        "b13 b22 b23 b26",
    ],
)
def test_misprints_may_stand_in_any_container(answer, capsys):
    chapter5c.misprints(answer)
    assert "✓ misprinted" in capsys.readouterr().out


def test_slip_in_the_misprints_is_named():
    slips = [
        ([], "still empty"),
        (..., "still empty"),
        ("b13", "3 more deviate"),
        ("", "still empty"),
        (None, "still empty"),
        (np.array([]), "still empty"),
        (np.array(["b13", "b22", "b23"]), "1 more deviate"),
        (np.array([True, False]), "no coefficient false, true: write the names"),
        (["b13", "b22"], "2 more deviate"),
        (["b13", "b22", "b23", "b25", "b26"], "1 of your coefficients agree"),
        (["b17"], "no coefficient b17"),
        ([13, 22], 'no coefficient 13, 22: write the names like "b11"'),
    ]
    assert unnamed(chapter5c.misprints, slips) == []


def test_misprints_are_not_given_away():
    with pytest.raises(CheckFailed) as failed:
        chapter5c.misprints(["b11"])
    assert not any(name in str(failed.value) for name in ("b13", "b22", "b23", "b26"))


def test_what_stands_before_the_exercise_does_not_answer_it():
    lesson = nbformat.read(NOTEBOOKS / "05_intersection.ipynb", as_version=4).cells
    case = nbformat.read(NOTEBOOKS / "05_case_a_validation.ipynb", as_version=4).cells
    check = next(i for i, c in enumerate(case) if "chapter5c.misprints(" in c.source)
    before = [c.source for c in [*lesson, *case[:check]]]
    shown = " ".join(before).replace("{", "").replace("}", "").lower()
    for name in ("b13", "b_13", "b22", "b_22", "b23", "b_23", "four of", "b26", "b_26"):
        assert name not in shown, name
