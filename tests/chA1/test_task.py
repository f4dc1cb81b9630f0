"""The task of appendix A1: natural containers pass, and each net has one suspect."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pgm_book import task
from pgm_book.chA1 import task as lesson
from pgm_book.common.checks import CheckFailed
from tests import lesson_program


@pytest.fixture
def mine(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_pgm.py").touch()  # the data go beside it
    return task.start("A1", "Ada")


def test_natural_containers_and_rounded_numbers_pass(mine):
    right = mine._truth.answer
    heights = list(right["heights"].round(3))
    line = tuple(right["line"][::-1])
    result = {"heights": heights, "sd": list(right["sd"].round(1)), "line": line}
    parts = mine.judged(result | {"size": round(right["size"])})
    assert all(part.holds for part in parts)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("heights", [1, 2], "six numbers, for B, C"),
        ("line", "the third", "two letters such as 'CD'"),
        ("size", "large", "one number, in mm"),
    ],
)
def test_what_is_no_answer_is_refused_in_words(mine, key, value, words):
    with pytest.raises(CheckFailed, match=words):
        mine.judged(mine._truth.answer | {key: value})


def test_heights_in_millimetres_are_named_whatever_the_noise(mine):
    truth = mine._truth
    heights = 1000 * truth.adjusted(truth.p, truth.good)[0]["heights"]
    assert "in metres" in mine.explained(truth.answer | {"heights": heights})


@pytest.mark.slow
def test_the_wrong_reading_stands_out_in_every_net():
    for seed in range(100):
        _, truth = lesson.make(np.random.RandomState(seed))
        v, _, w = truth.tested(truth.p > 0)
        assert np.argmax(w) == truth.bad and w.max() > 4
        assert np.sort(w)[-2] < 0.75 * w.max()  # rounding cannot choose another
        assert truth.tested(truth.good)[2].max() < 3.29  # without it none is suspected
        assert np.argmax(np.abs(v)) != truth.bad  # the largest residual is no answer
        assert np.argmax(np.abs(v) / truth.sigma) != truth.bad


@pytest.mark.slow
def test_the_program_of_the_exercises_passes_for_a_hundred_names(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(task.plot, "show", lambda figure, *_, **__: plt.close(figure))
    with lesson_program.of("A1") as solve:
        for k in range(100):
            solve(task.start("A1", f"student {k}"))  # hand_in raises where it fails
