"""The task of chapter 5: its tolerance follows from the noise."""

import numpy as np
import pytest

from pgm_book import task as book
from pgm_book.ch05 import task
from pgm_book.program.orientation import relative
from pgm_lab import orientation
from pgm_lab.camera import Camera

NAMES = [f"reader {k}" for k in range(25)]


def truth_of(name):
    _, truth = task.make(book._chance(5, name, ""))
    return truth


def solved(truth):
    left, right = truth.image
    exterior = relative(left, right, truth.c)
    distance = task._length(task._model(truth.image, truth.c, exterior), truth.bar)
    return {"exterior": exterior, "distance": distance, "sd": truth.sd}


@pytest.mark.slow
def test_an_answer_is_off_by_one_standard_deviation_and_never_by_three():
    off = []
    for name in NAMES:
        truth = truth_of(name)
        parts = task.judge(truth, solved(truth))
        assert all(part.holds for part in parts), name
        off.append([part.off for part in parts[1:3]])
    # 125 numbers, and 25: standard deviations of 0.13 and 0.28; boxes without weights
    assert np.all(np.abs(np.mean(np.square(off), axis=0) - 1) < (0.45, 0.85))


def test_the_precision_is_that_of_an_adjustment_of_all_image_coordinates():
    truth = truth_of("Ada")
    left, right = truth.image
    camera = Camera(truth.c)
    found = orientation.relative(camera, camera, left, right, sigma=task.SIGMA)
    assert np.allclose(found.sd[1:], np.sqrt(np.diag(truth.Q)), rtol=0.05)


def test_hints_for_what_is_no_slip_blame_no_right_part():
    truth = truth_of("Ada")
    good = solved(truth)
    moved = good["exterior"] + [0, 0.1, 0, 0, 0, 0]
    for part, words in (
        ({"exterior": 3.7 * good["exterior"]}, "X0 of the right photo is 1"),
        ({"exterior": moved, "distance": 1.0}, "Are the boxes flat"),
        ({"distance": good["distance"] * 1.1}, "The exterior is right"),
        ({"sd": good["sd"] * 1.14}, "a thousand runs"),
    ):
        answer = good | part
        wrong = [one.name for one in task.judge(truth, answer) if not one.holds]
        assert words in task.hint(truth, answer, wrong)
