"""The exercise of case 4c: no hint gives the wrong elements away."""

import pytest

from pgm_book.ch04 import case_checks
from pgm_book.common.checks import CheckFailed
from tests.common.slips import unnamed

# Where (2.62) differs from (2.8) itself
UNTRANSPOSED = [(1, 2), (1, 3), (2, 1), (2, 2), (2, 3), (3, 1), (3, 2)]


def test_no_hint_gives_a_wrong_element_away():
    for answer in (..., [], 13, [(3, 1), (2, 2)], [(0, 2), (1, 1)], UNTRANSPOSED):
        with pytest.raises(CheckFailed) as failed:
            case_checks.wrong_elements(answer)
        for place in ("(1, 3)", "(2, 2)", "m13", "m22"):
            assert place not in str(failed.value)


def test_slip_in_the_wrong_elements_is_named():
    slips = [
        (..., "still empty"),
        ([(0, 2), (1, 1)], "count from 1"),
        ([(3, 1), (2, 2)], "row comes first"),
        ([(1, 2), (2, 3)], "cross in other elements"),
        ([(1, 3)], r"1 wrong element\(s\) not found, 0 right"),
        ([(1, 3), (2, 2), (3, 3)], r"0 wrong element\(s\) not found, 1 right"),
        (UNTRANSPOSED, "compare with the transpose"),
        ([(1, 3, 2)], r"must be a list of pairs such as \[\(3, 2\)\]"),
        ([], r"must be a list of pairs such as \[\(3, 2\)\]"),
        ((1, 3), "must be a list of pairs"),
        ([(1, 3), 2], "must be a list of pairs"),
        ("m13 and m22", "must be a list of pairs"),
        (13, "must be a list of pairs"),
        ([(1.5, 3), (2, 2)], r"1 wrong element\(s\) not found, 1 right"),
    ]
    assert unnamed(case_checks.wrong_elements, slips) == []


def test_right_answers_pass(capsys):
    case_checks.wrong_elements([(2, 2), (1, 3)])
    case_checks.wrong_elements([[1, 3], [2, 2]])
    assert capsys.readouterr().out.count("✓") == 2


def test_near_misses_do_not_pass():
    with pytest.raises(CheckFailed):
        case_checks.wrong_elements([(1 + 1e-6, 3), (2, 2)])
