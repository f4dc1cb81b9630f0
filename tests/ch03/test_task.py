"""The task of chapter 3: what is off by one step is told so; a pair is asked for."""

import pytest

from pgm_book import task as book
from pgm_book.ch03 import task
from pgm_book.common.checks import CheckFailed


def test_what_is_off_by_the_same_is_no_match_in_a_wrong_place():
    _, truth = task.make(book._chance("3", "Ada", ""))
    positions, covariances = next(
        pair for words, pair in task.slips(truth).items() if "Q is not" in words
    )
    for wrong, words in ((positions + 0.5, "by the same"), (positions[::-1], "wrong")):
        assert words in task.hint(truth, (wrong, covariances), ["the worst position"])
    with pytest.raises(CheckFailed, match="must be a pair"):
        task.read(positions)
