"""The task of chapter 4: its tolerance follows from the rounding; forms of answers."""

import numpy as np

from pgm_book import task as book
from pgm_book.ch04 import task
from pgm_lab import rotation


def truth_and_answer(name):
    _, truth = task.make(book._chance(4, name, ""))
    return truth, task._asked(truth.c, truth.M(truth.written))


def test_the_rounding_leaves_one_standard_deviation_and_never_three():
    squares = []
    for k in range(200):
        truth, answer = truth_and_answer(f"reader {k}")
        assert all(part.holds for part in task.judge(truth, answer))
        turned = answer["M"] - truth.answer["M"]
        squares.append(
            [
                np.mean(np.sum(turned**2, axis=(1, 2))) / (6 * task.SD**2),
                np.mean(((answer["row"] - truth.answer["row"]) / truth.sd) ** 2),
            ]
        )
    # 1200 photos, three roundings in each matrix and two in each row
    assert np.allclose(np.mean(squares, axis=0), 1, atol=0.1)


def test_other_angles_of_the_same_attitude_pass():
    truth, answer = truth_and_answer("Ada")
    angles = answer["angles"] + np.array([360, 0, 0])
    parts = task.judge(truth, answer | {"angles": angles})
    assert all(part.holds for part in parts)


def test_one_wrong_photo_fails_and_what_is_right_is_said():
    truth, answer = truth_and_answer("Ada")
    row = answer["row"] + np.array([0, 0, 0, 5, 0, 0])
    parts = task.judge(truth, answer | {"row": row})
    assert [part.holds for part in parts] == [True, True, False]
    said = task.hint(truth, answer | {"row": row}, ["row"])
    assert said.startswith("The angles are right")


def test_what_was_rounded_or_lost_its_quadrant_is_named():
    truth, answer = truth_and_answer("Ada")
    half = answer["angles"].copy()
    half[2, 0] -= 180
    for change, words in [
        ({"row": np.round(answer["row"])}, "last digits"),
        ({"angles": np.round(answer["angles"], 1)}, "last digits"),
        ({"angles": half}, "half a turn off"),
        ({"angles": answer["angles"] + 7}, "M is right"),
        ({"angles": answer["angles"] + 7, "M": 0.9 * answer["M"]}, "test each factor"),
        ({"angles": np.degrees(rotation.angles(answer["M"].swapaxes(1, 2)))}, "M is r"),
    ]:
        assert words in task.hint(truth, answer | change, list(change))
