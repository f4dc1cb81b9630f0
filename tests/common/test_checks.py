"""Feedback machinery: plain words for what is unfinished, wrong, or nearly right."""

import numpy as np
import pytest

from pgm_book.ch01 import checks as chapter1
from pgm_book.ch06 import checks as chapter6
from pgm_book.chA1 import checks as chapterA1
from pgm_book.common import checks
from pgm_book.common.checks import CheckFailed
from tests.common.slips import unnamed


def stop(*arguments):
    raise ZeroDivisionError("oops")


def change(pixels, size, px):
    pixels += 1
    return pixels


def test_unfinished_function_gets_a_plain_message():
    slips = [
        (lambda *a: None, "returns nothing yet"),
        (lambda *a: ..., "returns nothing yet"),
        (..., "is not a function yet"),
        (lambda *a: "text", "must return numbers, not str"),
        (lambda *a: [1.0, 2.0], r"must return shape \(4, 2\) here; got \(2,\)"),
        (lambda p, *a: p.T, "use np.column_stack"),
        (lambda *a: (...).ravel(), "a part is still `...`. Your turn!"),
        (stop, "stopped with ZeroDivisionError: oops"),
        (change, "changes its input"),
        (lambda *a: step(*a), "step, which is not defined.*Your turn!"),  # noqa: F821
    ]
    assert unnamed(chapter1.pixel_to_photo, slips) == []


def test_axes_of_length_one_and_text_of_a_number_make_no_difference():
    for answer, shape in (([[1.0, 2.0]], (2,)), ([3.0], ()), (np.ones((5, 1)), (5,))):
        found = checks.call(lambda answer=answer: answer, shape=shape)
        assert found.shape == shape and found.size == np.size(answer)
        assert checks.numbers("mine", answer, shape).shape == shape
    assert checks.numbers("photo", "2") == 2
    for answer, shape in ((np.ones((1, 3)), (2,)), (np.ones((3, 2)), (2, 3))):
        with pytest.raises(CheckFailed, match="must return shape"):
            checks.call(lambda answer=answer: answer, shape=shape)
    with pytest.raises(CheckFailed, match=r"shape \(5,\) here; got \(5, 1\)"):
        checks.call(lambda: np.ones((5, 1)), shape=(5,), column=False)


def test_near_is_relative_to_the_largest_number_and_at_least_to_one():
    assert checks.near(1000.0 + 9e-7, 1000.0) and not checks.near(1000.0 + 2e-6, 1000)
    assert checks.near(9e-10, 0.0) and not checks.near(2e-9, 0.0)


def test_a_hint_that_asks_ends_in_its_question_mark():
    for hint, end in (("which way is up?", "up?"), ("y is up", "up.")):
        with pytest.raises(CheckFailed) as failed:
            checks.report("y", [("y points up", False, hint)])
        assert str(failed.value).endswith(end)


@pytest.mark.parametrize(
    ("check", "before"),
    [
        (chapterA1.adjust, "the exercise before this one"),
        (chapter6.adjust, "exercises 6.1 to 6.3"),
    ],
)
def test_who_left_an_exercise_out_hears_which(check, before):
    with pytest.raises(CheckFailed, match=f"that it uses: do {before} first"):
        check(lambda *arguments: 1.0 - None)


@pytest.mark.parametrize("dtype", [np.float32, np.float16])
def test_single_precision_is_named_and_taken_only_where_it_will_do(dtype):
    def half(x):
        return dtype(x) / dtype(2)

    with pytest.raises(CheckFailed, match="single precision: work with float64"):
        checks.call(half, 1.5, shape=())
    assert checks.call(half, 1.5, shape=(), single=True) == 0.75


def test_notebook_shows_the_message_without_a_traceback():
    assert CheckFailed("so and so")._render_traceback_() == ["✗ so and so"]


def test_who_grades_learns_of_each_property_whether_it_holds():
    properties = [("a", True, ""), ("b", np.bool_(False), "not b"), ("c", None, "no c")]
    with pytest.raises(CheckFailed, match="^abc: not b.$") as failed:
        checks.report("abc", properties)
    assert failed.value.properties == (("a", True), ("b", False), ("c", None))
    assert CheckFailed("another").properties == ()


def test_a_property_that_was_not_tried_neither_holds_nor_fails(capsys):
    checks.report("ac", [("a", True, ""), ("c", None, "no c")])
    assert capsys.readouterr().out == "✓ ac: a.\n"


def test_a_secret_changes_what_is_drawn_and_what_is_fixed_until_it_ends():
    def drawn():
        fixed = checks.varied(5, 20.0, lambda rng: rng.uniform())
        return (checks.chance(5).uniform(), fixed, *checks.shaken(6, (1.0, 2.0)))

    before = drawn()
    assert before[0] == np.random.default_rng(5).uniform() and before[1:] == (20, 1, 2)
    with checks.hidden(1):
        one = drawn()
        assert one == drawn()
        with checks.hidden(2):
            other = drawn()
        assert one == drawn()
    assert drawn() == before
    assert len({*before, *one, *other}) == 10  # under a secret both are one stream
