"""The task of chapter 8: what no slip explains is still said as far as it is known."""

import contextlib

import numpy as np
import pytest

from pgm_book import task
from pgm_book.ch08 import task as lesson


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    with contextlib.chdir(tmp_path_factory.mktemp("Ada")):
        return task.start(8, "Ada")._truth


def hint(truth, found):
    """The hint to what is wrong in an answer."""
    wrong = [part.name for part in lesson.judge(truth, found) if not part.holds]
    return lesson.hint(truth, found, wrong)


def test_a_few_wrong_heights_are_no_slip_of_all_nor_of_their_precision(truth):
    Z, sd = truth.answer.values()
    some = {"Z": Z + 2 * (np.arange(40) < 8)}
    assert hint(truth, truth.answer | some).startswith("Does the search go")
    assert hint(truth, truth.answer | {"sd": 1.5 * sd}).startswith("The heights hold.")


def test_four_values_of_each_may_be_off_and_five_may_not(truth):
    sd = truth.answer["sd"]
    for many in (4, 5):
        changed = sd * np.where(np.arange(40) < many, 3, 1)
        parts = lesson.judge(truth, truth.answer | {"sd": changed})
        assert [part.off for part in parts] == [0, many]
        assert parts[1].holds == (many == 4)


def test_a_depth_for_all_is_refused_and_the_sd_of_the_depth_is_not(truth):
    depth = -truth.model[:, 2]
    of_depth = depth / truth.disparity * lesson.SIGMA
    assert lesson.judge(truth, truth.answer | {"sd": of_depth})[1].holds
    for one in (of_depth[0], of_depth.mean(), np.median(of_depth)):
        alike = truth.answer | {"sd": np.full(40, one)}
        assert "by each depth" in hint(truth, alike)
