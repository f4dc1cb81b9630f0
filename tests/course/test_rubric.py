"""The rubric: what is worth points in the exercises, and what is not."""

import csv
import importlib
import os
from collections import defaultdict
from importlib import resources

import numpy as np
import pytest

from pgm_book.common import checks
from pgm_book.course import grade
from tests.course import exercises, trivial

with (resources.files("pgm_book.course") / "rubric.csv").open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(file))
POINTS: dict[tuple[str, str], dict[str, float]] = defaultdict(dict)
for row in ROWS:
    here = POINTS[row["lesson"], row["exercise"]]
    here[row["property"]] = float(row["points"])
ALL_OF_IT = {"photo", "fourth"}  # whose other arguments are the reader's as well
STEMS = exercises.stems()
ALL = os.environ.get("PGM_LAB_LARGEST_SAMPLES")  # in test-all
SOME = [stem for stem in STEMS if ALL or stem[:2] not in ("06", "09")]  # the quicker


def earned(exercise, answer) -> float:
    points = POINTS[exercise.lesson, exercise.name]
    return sum(points[text] for text, holds in exercise.properties(answer) if holds)


def test_an_exercise_is_worth_ten_points_and_a_task_twenty():
    assert len(ROWS) == sum(map(len, POINTS.values()))  # no row twice
    for (_, exercise), points in POINTS.items():
        assert sum(points.values()) == (20 if exercise == "task" else 10)
        assert min(points.values()) >= 0


def test_each_exercise_and_each_task_has_its_rows():
    found = {(one.lesson, one.name) for one in grade.exercises()}
    books = grade.notebooks().items()
    asked = {(n, one.name) for n, book in books for one in grade.asked_in(book)}
    assert (
        set(POINTS) == found == asked - {("0", "point")}
    )  # it shows how a check works


@pytest.mark.slow
@pytest.mark.parametrize("stem", STEMS)
def test_rows_are_what_the_check_names_and_the_solution_earns_all(stem):
    for one in exercises.of(stem):
        told = one.properties(one.solution)
        assert [text for text, _ in told] == list(POINTS[one.lesson, one.name])
        assert earned(one, one.solution) == 10


def tried(one, answer, secret) -> float:
    """Points that an answer earns under a secret."""
    alone = exercises.replaced(one, answer) if one.name in ALL_OF_IT else one
    with checks.hidden(secret), np.errstate(all="ignore"):
        return earned(alone, answer)


def paid_for_nothing(stem, secret):
    """Trivial answers that earn points under a secret."""
    paid = []
    for one in exercises.of(stem):
        of = trivial.functions if callable(one.solution) else trivial.values
        for name, answer in of(one.solution):
            if points := tried(one, answer, secret):
                paid.append((one.lesson, one.name, name, points))
    return paid


@pytest.mark.slow
@pytest.mark.parametrize("stem", SOME)
def test_who_does_nothing_earns_nothing(stem):
    for secret in range(7, 12 if ALL else 8):
        assert paid_for_nothing(stem, secret) == []


@pytest.mark.slow
@pytest.mark.parametrize("chapter", ["1", "2", "3", "4"])
def test_a_slip_costs_points(chapter):
    slips = importlib.import_module(f"tests.ch0{chapter}.test_checks").SLIPS
    paid = []
    for stem in STEMS:
        for one in exercises.of(stem) if exercises.number(stem)[0] == chapter else ():
            for answer, hint in slips.get(one.check, ()):
                if (points := tried(one, answer, 7)) >= 10:
                    paid.append((one.name, hint, points))
    assert paid == []
