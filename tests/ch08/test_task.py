"""The task of chapter 8: what no slip explains is still said as far as it is known."""

import numpy as np
import pytest

from pgm_book import task
from pgm_book.ch08 import task as lesson


@pytest.fixture
def truth(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    return task.start(8, "Ada")._truth


def hint(truth, found):
    """The hint to what is wrong in an answer."""
    wrong = [part.name for part in lesson.judge(truth, found) if not part.holds]
    return lesson.hint(truth, found, wrong)


def test_disparities_that_were_searched_elsewhere_are_recognised(truth):
    Z0, Z = truth.photos[0].exterior[2], truth.ground[:, 2]
    found = np.linspace(-60, 30, 40) + 0.5  # px
    heights = Z0 + (Z - Z0) * truth.disparity / found
    said = hint(truth, truth.answer | {"Z": heights})
    assert "not from 100 to 168 px" in said


def test_a_few_wrong_heights_are_no_slip_of_all_nor_of_their_precision(truth):
    Z, sd = truth.answer.values()
    some = {"Z": Z + 2 * (np.arange(40) < 8)}
    assert hint(truth, truth.answer | some).startswith("Show both normal images")
    assert hint(truth, truth.answer | {"sd": 1.5 * sd}).startswith("The heights hold.")


@pytest.mark.parametrize(
    ("factor", "holds"), [(1.19, True), (1.2, True), (1.21, False)]
)
def test_what_is_printed_of_a_factor_agrees_with_what_is_said_of_it(
    truth, factor, holds
):
    answer = truth.answer | {"sd": factor * truth.answer["sd"]}
    _, part = lesson.judge(truth, answer)
    assert part.holds == holds and f": {factor} (1.2 allowed)" in str(part)
