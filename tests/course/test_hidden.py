"""Exercises on hidden inputs: who knows how passes, who knows the notebook does not."""

import itertools

import cv2
import numpy as np
import pytest

from pgm_book.ch02 import checks as chapter2
from pgm_book.common import checks
from tests.course import exercises
from tests.course.test_rubric import ALL, SOME, STEMS, earned

QUICK = [stem for stem in STEMS if stem[:2] in ("02", "04")]


def functions(stem):
    return [one for one in exercises.of(stem) if callable(one.solution)]


def losses(stem, secrets):
    """Exercises, secrets and properties of which the book's solution lacks one."""
    lost = []
    for one, secret in itertools.product(functions(stem), secrets):
        with checks.hidden(secret):
            told = one.properties(one.solution)
        lost += [(one.name, secret, text) for text, holds in told if not holds]
        assert told
    return lost


@pytest.mark.parametrize("stem", QUICK)
def test_the_solution_passes_whatever_the_secret(stem):
    assert losses(stem, range(2)) == []


def test_a_map_in_single_precision_passes_whatever_the_secret():
    def by_opencv(template, search):
        single = search.astype(np.float32), template.astype(np.float32)
        return cv2.matchTemplate(*single, cv2.TM_CCOEFF_NORMED)

    for secret in range(100):
        with checks.hidden(secret):
            chapter2.correlation_map(by_opencv)


@pytest.mark.slow
@pytest.mark.parametrize("stem", SOME)
def test_the_solution_passes_whatever_the_secret_of_many(stem):
    assert losses(stem, range(2, 32 if ALL else 5)) == []


def seen_by(one):
    """Arguments and answers of the calls by which a notebook checks an exercise."""
    seen = []

    def watched(*arguments):
        answer = one.solution(*arguments)
        seen.append((known(arguments), answer))
        return answer

    one.properties(watched)
    return seen


def known(arguments):
    """Arguments as a key of a table."""
    return repr(
        [one if callable(one) else np.asarray(one).tolist() for one in arguments]
    )


@pytest.mark.slow
@pytest.mark.parametrize("stem", SOME)
def test_a_table_of_the_notebook_s_answers_fails(stem):
    paid = []
    for one in functions(stem):
        seen = seen_by(one)
        table = dict(seen)
        again = itertools.cycle([answer for _, answer in seen])

        def looked_up(*arguments, table=table, first=seen[0][1]):
            return table.get(known(arguments), first)

        def repeated(*arguments, again=again):
            return next(again)

        # What is repeated in its order keeps proportions: twice the GSD, twice as high
        for cheat, most in ((looked_up, 3), (repeated, 6.5)):
            with checks.hidden(5), np.errstate(all="ignore"):
                points = earned(one, cheat)
            if points > most:
                paid.append((one.name, cheat.__name__, points))
    assert paid == []
