"""Measures of errors, by hand and against their definition."""

import numpy as np
import pytest
from scipy import stats

from pgm_lab import stereo


def test_by_hand():
    found = stereo.quality([1.0, 2.5, np.nan, 3.0], [0.0, 2.0, 5.0, 3.0])
    assert found.n == 3 and found.completeness == 0.75
    assert found.mean == pytest.approx(0.5)
    assert found.rmse == pytest.approx(np.sqrt(1.25 / 3))
    assert found.nmad == pytest.approx(1.4826 * 0.5)


def test_nmad_is_the_standard_deviation_of_normal_errors_and_ignores_blunders():
    e = np.random.default_rng(1).normal(0.1, 0.3, 40_000)
    found = stereo.quality(e, np.zeros_like(e))
    assert found.nmad == pytest.approx(0.3, rel=0.02)
    share = np.diff(stats.norm(0.1, 0.3).cdf([-found.le95, found.le95]))
    assert share == pytest.approx(0.95, abs=0.005)
    e[:400] = 100
    spoilt = stereo.quality(e, np.zeros_like(e))
    assert spoilt.nmad == pytest.approx(0.3, rel=0.03) and spoilt.rmse > 9


def test_only_what_is_asked_for_and_known_counts():
    truth = np.array([[0.0, np.nan], [0.0, 0.0]])
    found = stereo.quality(np.ones((2, 2)), truth, [[True, True], [False, True]])
    assert found.n == 2 and found.completeness == 1


def test_no_height_at_all():
    found = stereo.quality([np.nan, np.nan], [1.0, 2.0])
    assert found.n == 0 and found.completeness == 0 and np.isnan(found.rmse)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1.0, 2.0], [1.0]), "one shape"),
        (([1.0, np.inf], [1.0, 2.0]), "infinite"),
        (([1.0], [1.0], [0.5]), "True or False"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(ValueError, match=message):
        stereo.quality(*arguments)
