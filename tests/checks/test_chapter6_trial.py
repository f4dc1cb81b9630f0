"""Exercise feedback of chapter 6, exercises 6.4 to 6.6: each slip is named."""

from itertools import combinations

import numpy as np
import pytest

from pgm_lab import bundle, datasets
from pgm_lab.checks import CheckFailed
from pgm_lab.checks import chapter6_trial as trial

ARC = 79.46  # µm: 0.007946 at 10 mm


def right(N):
    return N / np.sqrt(np.outer(np.diag(N), np.diag(N)))


def fails(check, *answer):
    with pytest.raises(CheckFailed) as caught:
        check(*answer)
    return str(caught.value)


def test_right_answers_pass(capsys):
    trial.largest_difference(2, "kappa", "rad", ARC)
    trial.largest_difference(np.int64(2), "kappa", "radians", np.float64(79.5))
    trial.unit_diagonal(right)
    trial.unit_diagonal(lambda N: N / np.diag(N) ** 0.5 / np.diag(N)[:, None] ** 0.5)
    trial.five_photos([1, 4, 6, 7, 8])
    trial.five_photos((9, 7, 6, 4, 2))
    assert capsys.readouterr().out.count("✓") == 6


def test_the_number_is_that_of_the_table():
    data = datasets.muliawan2013()
    difference = data.published_exteriors - data.exteriors
    assert abs(difference[1, 5]) == np.abs(difference).max()
    # Table 4.19 prints six decimals
    assert 1e4 * np.abs(difference).max() == pytest.approx(ARC, abs=0.01)


@pytest.mark.parametrize(
    ("photo", "unknown", "unit", "moved", "part"),
    [
        (1, "kappa", "rad", ARC, "another photo"),
        (2, "omega", "rad", ARC, "another photo"),
        (2, "kappa", "mm", ARC, "not the unit"),
        (2, "kappa", "deg", ARC, "not the unit"),
        (2, "kappa", "", ARC, "Your turn"),
        (2, "kappa", "rad", 0.0, "Your turn"),
        (2, "kappa", "rad", "79", "not a number"),
        (2, "kappa", "rad", np.nan, "not a number"),
        (2, "kappa", "rad", -ARC, "negative"),
        (2, "kappa", "rad", ARC / 1000, "in mm"),
        (2, "kappa", "rad", ARC * np.pi / 180, "taken for degrees"),
        (2, "kappa", "rad", ARC * 180 / np.pi, "converted to degrees"),
        (2, "kappa", "rad", ARC / 10, "at 1 mm"),
        (2, "kappa", "rad", ARC / 1e4, "the angle itself"),
        (2, "kappa", "rad", ARC + 4, "not the arc"),
    ],
)
def test_each_slip_with_the_largest_difference_is_named(
    photo, unknown, unit, moved, part
):
    message = fails(trial.largest_difference, photo, unknown, unit, moved)
    assert part in message and "79" not in message


@pytest.mark.parametrize(
    ("function", "part"),
    [
        (lambda N: N / np.sqrt(np.diag(N))[:, None], "rows are scaled"),
        (lambda N: N / np.sqrt(np.diag(N)), "columns are scaled"),
        (lambda N: N / np.outer(np.diag(N), np.diag(N)), "without the root"),
        (lambda N: N / np.diag(N)[:, None], "each row"),
        (lambda N: N / np.diag(N), "each column"),
        (lambda N: N * np.sqrt(np.outer(np.diag(N), np.diag(N))), "multiplies"),
        (lambda N: N / np.abs(N).max(), "one number"),
        (lambda N: np.eye(len(N)), "lost"),
        (lambda N: right(N) ** 2, "beside the diagonal"),
        (lambda N: np.triu(right(N)), "not symmetric"),
        (lambda N: 2 * right(N), "not 1"),
        (lambda N: N[0], "shape"),
        (lambda N: None, "Your turn"),
        (..., "Your turn"),
    ],
)
def test_each_slip_with_the_diagonal_is_named(function, part):
    assert part in fails(trial.unit_diagonal, function)


def in_place(N):
    s = np.sqrt(np.diag(N))
    N /= np.outer(s, s)
    return N


def test_a_scaling_in_place_is_refused():
    assert "changes its input" in fails(trial.unit_diagonal, in_place)


@pytest.mark.parametrize(
    ("photos", "part"),
    [
        ([1, 2, 3, 4, 5], "Your turn"),
        ([1, 4, 6, 7], "five different"),
        ([1, 4, 6, 7, 7], "five different"),
        ([0, 4, 6, 7, 8], "five different"),
        ([1, 4, 6, 7, 10], "five different"),
        ("photo", "five numbers"),
        (5, "five numbers"),
        ([3, 4, 5, 8, 9], "standard deviation"),
        ([2, 5, 6, 7, 9], "how is the camera rolled"),  # from all five places
        ([1, 3, 5, 8, 9], "standard deviation"),
    ],
)
def test_each_slip_with_the_photos_is_named(photos, part):
    assert part in fails(trial.five_photos, photos)


def test_the_best_five_are_as_good_as_the_check_believes():
    # Every tenth of the 126 choices, and the best one: none beats it
    choices = [c for c in combinations(range(1, 10), 5)][::10] + [(1, 4, 6, 7, 8)]
    sd = []
    for chosen in choices:
        one = bundle.adjust(trial.network_of(chosen))
        sd.append(348.98e-3 * 1000 * one.sd_interior[0] / one.sigma0)
    assert sd[-1] == min(sd) == pytest.approx(trial._BEST, rel=0.02)


def test_scaling_does_not_depend_on_units():
    A = np.random.default_rng(1).normal(size=(9, 4))
    N, u = A.T @ A, np.array([1.0, 1e6, 1e-9, 3.0])
    np.testing.assert_allclose(trial.rescaled(N * np.outer(u, u)), trial.rescaled(N))
