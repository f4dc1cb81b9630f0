"""The task of chapter 1: natural spellings pass, and what is no answer is refused."""

import numpy as np
import pytest

from pgm_book import task
from pgm_book.ch01 import task as lesson
from pgm_book.common.checks import CheckFailed


@pytest.fixture
def truth(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    return task.start(1, "Ada")._truth


@pytest.mark.parametrize("axes", ["Right, Down", "right down", ("right", "down")])
def test_natural_spellings_pass(truth, axes):
    result = truth.answer | {"axes": axes, "zero": tuple(truth.answer["zero"])}
    assert all(part.holds for part in lesson.judge(truth, result))


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("axes", "north, east", "two words such as 'right, up'"),
        ("zero", "upper left", "column, row of the program's zero, two numbers"),
        ("photo", [[1, 2]], r"\(20, 2\): x, y in mm"),
    ],
)
def test_what_is_no_answer_is_refused_in_words(truth, key, value, words):
    with pytest.raises(CheckFailed, match=words):
        lesson.judge(truth, truth.answer | {key: value})


@pytest.mark.parametrize("share", [0.7, -0.3])  # a background left in, one too large
def test_a_wrong_background_is_named_before_what_it_spoils(truth, share):
    right = truth.answer
    pull = share * (truth.plan - right["photo"])
    result = {**right, "photo": right["photo"] + pull, "zero": right["zero"] + 0.5}
    spoiled = result | {"pixel_size": 1.001 * right["pixel_size"]}
    assert lesson.hint(truth, spoiled) == lesson.PULL


def test_targets_in_another_order_are_named(truth):
    result = truth.answer | {"photo": truth.answer["photo"][::-1]}
    assert "order of plan.csv" in lesson.hint(truth, result)


@pytest.mark.parametrize("seed", range(20))
def test_lines_through_the_clicks_are_not_exact_enough(seed):
    files, truth = lesson.make(np.random.RandomState(seed))
    rows = files["program.csv"].splitlines()
    clicks_and_own = np.loadtxt(rows, delimiter=",", skiprows=1)
    own = clicks_and_own[:, 2:]
    if truth.answer["axes"].startswith("down"):
        own = own[:, ::-1]
    fits = [np.polyfit(a, b, 1)[0] for a, b in zip(clicks_and_own[:, :2].T, own.T)]
    result = truth.answer | {"pixel_size": np.mean(np.abs(fits))}
    assert not all(part.holds for part in lesson.judge(truth, result))
    assert lesson.hint(truth, result) == lesson.CLICKED
