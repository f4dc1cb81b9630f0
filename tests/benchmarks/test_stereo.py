"""Times of dense matching beside OpenCV, in one run: `make benchmark`.

A million cells, disparities from -12 to 12 px. OpenCV's SGBM
searches 64 disparities in windows of 5 x 5, rounded to 1/16 px, without standard
deviations.
"""

import numpy as np
import pytest

from pgm_book.ch08.studies import matching as study
from pgm_lab import stereo

MILLION = "dense matching of a million cells"
SIZE = (1250, 800)
ROUNDS = 3


@pytest.fixture(scope="module")
def scene():
    return study.wide(*SIZE)


def is_right(disparity):
    error = (disparity - study.true_waves(*SIZE))[20:-20, 80:-80]
    assert np.mean(np.abs(error) < 0.5) > 0.98


@pytest.mark.benchmark(group=MILLION)
def test_dense_matching(benchmark, scene):
    is_right(benchmark.pedantic(stereo.match_rows, scene, rounds=ROUNDS).disparity)


@pytest.mark.benchmark(group=MILLION)
def test_dense_matching_sgbm(benchmark, scene):
    is_right(benchmark.pedantic(study.sgbm, (*scene, -32, 64), rounds=ROUNDS))
