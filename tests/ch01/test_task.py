"""The task of chapter 1: natural spellings pass, and what is no answer is refused."""

import numpy as np
import pytest

from pgm_book import task
from pgm_book.ch01 import task as lesson
from pgm_book.common.checks import CheckFailed


@pytest.fixture
def mine(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_pgm.py").touch()  # the data go beside it
    return task.start(1, "Ada")


@pytest.fixture
def right(mine):
    return mine._truth.answer


@pytest.mark.parametrize("axes", ["Right, Down", "right down", ("right", "down")])
def test_natural_spellings_pass(mine, right, axes):
    result = right | {"axes": axes, "zero": tuple(right["zero"])}
    assert all(part.holds for part in mine.judged(result))


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("axes", "north, east", "two words such as 'right, up'"),
        ("zero", "upper left", "column, row of the program's zero, two numbers"),
        ("photo", [[1, 2]], r"\(20, 2\): x, y in mm"),
    ],
)
def test_what_is_no_answer_is_refused_in_words(mine, right, key, value, words):
    with pytest.raises(CheckFailed, match=words):
        mine.judged(right | {key: value})


@pytest.mark.parametrize("share", [0.7, -0.3])  # a background left in, one too large
def test_a_wrong_background_is_named_before_what_it_spoils(mine, right, share):
    pull = share * (mine._truth.plan - right["photo"])
    result = {**right, "photo": right["photo"] + pull, "zero": right["zero"] + 0.5}
    spoiled = result | {"pixel_size": 1.001 * right["pixel_size"]}
    assert "empty background" in mine.explained(spoiled)


def test_what_happened_to_all_photo_coordinates_is_named(mine, right):
    photo, half = right["photo"], right["pixel_size"] / 2
    assert "order of plan.csv" in mine.explained(right | {"photo": photo[::-1]})
    assert "same amount" in mine.explained(right | {"photo": photo + (-half, half)})
    assert "wanted in mm" in mine.explained(right | {"photo": 1000 * photo})


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
    wrong = [part.name for part in lesson.judge(truth, result) if not part.holds]
    assert lesson.hint(truth, result, wrong).startswith("Clicks are good")
