"""The task of chapter 4: its tolerance follows from the rounding; forms of answers."""

import numpy as np
import pytest

from pgm_book import task as book
from pgm_book.ch04 import task
from pgm_book.common.checks import CheckFailed


def truth_and_answer(name):
    _, truth = task.make(book._chance(4, name, ""))
    M = truth.M(truth.written)
    return truth, {
        "angles": np.degrees(task.rotation.angles(M)),
        "M": M,
        "row": truth.row(M),
    }


def test_the_rounding_leaves_one_standard_deviation_and_never_three():
    squares = []
    for k in range(200):
        truth, answer = truth_and_answer(f"reader {k}")
        assert all(part.holds for part in task.judge(truth, answer))
        turned = answer["M"] - truth.M(truth.drone)
        squares.append(
            [
                np.mean(np.sum(turned**2, axis=(1, 2))) / (6 * task.SD**2),
                np.mean(
                    ((answer["row"] - truth.row(truth.M(truth.drone))) / truth.sd) ** 2
                ),
            ]
        )
    # 1200 photos, three roundings in each matrix and two in each row
    assert np.allclose(np.mean(squares, axis=0), 1, atol=0.1)


def test_lists_and_a_tuple_pass_and_other_angles_of_the_same_attitude():
    truth, answer = truth_and_answer("Ada")
    angles = answer["angles"] + np.array([360, 0, 0])
    for one in (
        {name: value.tolist() for name, value in answer.items()},
        tuple(answer.values()),
        answer | {"angles": angles},
    ):
        assert all(part.holds for part in task.judge(truth, one))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda a: a["angles"], 'a dict with "angles"'),
        (lambda a: a | {"row": a["row"][:3]}, "the row of the horizon in each photo"),
        (lambda a: a | {"M": a["M"][0]}, r"one M \(3, 3\) a photo"),
    ],
)
def test_another_form_hears_what_is_wanted(wrong, said):
    truth, answer = truth_and_answer("Ada")
    with pytest.raises(CheckFailed, match=said):
        task.judge(truth, wrong(answer))


def test_one_wrong_photo_fails_and_what_is_right_is_said():
    truth, answer = truth_and_answer("Ada")
    row = answer["row"] + np.array([0, 0, 0, 5, 0, 0])
    parts = task.judge(truth, answer | {"row": row})
    assert [part.holds for part in parts] == [True, True, False]
    assert task.hint(truth, answer | {"row": row}).startswith("M is right")


def test_a_row_of_whole_pixels_hears_that_its_fraction_is_wanted():
    truth, answer = truth_and_answer("Ada")
    whole = answer | {"row": answer["row"].round()}
    assert not task.judge(truth, whole)[2].holds
    assert "with its fraction" in task.hint(truth, whole)
