"""The task of chapter 1: natural spellings pass, and what is no answer is refused."""

import pytest

from pgm_book import task
from pgm_book.ch01 import task as lesson
from pgm_book.common.checks import CheckFailed


@pytest.fixture
def truth(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    return task.start(1, "Ada")._truth


@pytest.mark.parametrize("axes", ["Right, Down", "right down", ("right", "down")])
@pytest.mark.parametrize("origin", ["upper left", "Top left"])
def test_natural_spellings_pass(truth, axes, origin):
    half = 0.5 if truth.answer["half_pixel"] else 0
    result = truth.answer | {"axes": axes, "origin": origin, "half_pixel": half}
    assert all(part.holds for part in lesson.judge(truth, result))


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("axes", "north, east", "two words such as 'right, up'"),
        ("origin", "the corner", "one of upper left, lower left, centre"),
        ("half_pixel", "perhaps", "True or False"),
        ("photo", [[1, 2]], r"\(20, 2\): x, y in mm"),
    ],
)
def test_what_is_no_answer_is_refused_in_words(truth, key, value, words):
    with pytest.raises(CheckFailed, match=words):
        lesson.judge(truth, truth.answer | {key: value})


def test_a_background_that_is_left_in_is_named_whatever_the_window(truth):
    pull = 0.3 * (truth.plan - truth.answer["photo"])
    result = truth.answer | {"photo": truth.answer["photo"] + pull}
    assert lesson.hint(truth, result) == lesson.PULL
