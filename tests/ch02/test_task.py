"""The task of chapter 2: a search that believes every high r fails it."""

import numpy as np
import pytest

from pgm_book import task
from pgm_book.ch02 import task as lesson
from pgm_lab import ncc


@pytest.fixture(autouse=True)
def elsewhere(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)


def highest(truth):
    """Return the place of the highest r, and this r, for each of the thirty points."""
    middle = np.median(truth.there - truth.points, axis=0)
    starts = truth.points + np.rint(middle - (9, 0))  # crowns move farther left
    found = ncc.match(
        truth.left, truth.right, truth.points, starts, 21, 59, threshold=-1, ratio=1
    )
    return found.points, found.r


def fails_by_a_threshold_alone(name):
    truth = task.start(2, name)._truth
    points, r = highest(truth)
    for threshold in (0.6, 0.7, 0.8, 0.9):
        result = np.where((r >= threshold)[:, None], points, np.nan)
        (part,) = lesson.judge(truth, lesson.read(result))
        assert not part.holds, (name, threshold, part)


def test_a_threshold_of_r_alone_fails():
    fails_by_a_threshold_alone("Ada")


@pytest.mark.slow
@pytest.mark.parametrize("k", range(20))
def test_a_threshold_of_r_alone_fails_for_twenty_names(k):
    fails_by_a_threshold_alone(f"reader {k}")
