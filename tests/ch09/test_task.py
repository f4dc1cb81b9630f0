"""The task of chapter 9: its tolerance follows from the noise; forms of answers."""

import numpy as np
import pytest

from pgm_book import task as book
from pgm_book.ch09 import task
from pgm_book.common.checks import CheckFailed

NAMES = [f"reader {k}" for k in range(12)]


def truth_of(name):
    return task.make(book._chance("9", name, ""))[1]


@pytest.mark.slow
def test_an_answer_is_off_by_one_standard_deviation_and_a_flat_board_by_more():
    off = []
    for name in NAMES:
        truth = truth_of(name)
        solved = truth.given(*truth.best)
        parts = task.judge(truth, solved)
        assert all(part.holds for part in parts), name
        off += [parts[0].off, parts[2].off]
        assert not task.judge(truth, solved | {"c": truth.flat["c"]})[0].holds, name
        assert np.all((truth.cupboard > 0) & (truth.cupboard < task.SIZE * 2))
    # 24 numbers: a standard deviation of 0.29
    assert abs(np.mean(np.square(off)) - 1) < 0.9


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ({"c": 1000, "sd": 0.3}, "must be a dict"),
        ({"c": 1000, "sd": 0.3, "PQ": "long"}, "one number in metres"),
    ],
)
def test_another_form_hears_what_is_wanted(answer, said):
    with pytest.raises(CheckFailed, match=said):
        task.read(answer)
