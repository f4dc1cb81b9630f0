"""The method in loops agrees with `register`, and with what is known."""

import numpy as np
import pytest

from pgm_book.program.registration import (
    best_shift,
    chip_shifts,
    peak_of_parabola,
    rmse,
)
from pgm_lab import datasets, registration, simulate

SCENE = datasets.landsat().grey[400:900, 200:700]
PAIR = simulate.ortho_pair(SCENE, (5, -3), 4, gain=0.9, offset=500, sigma=15, seed=1)
POINTS = registration.pick(PAIR.reference, 8)


def test_every_whole_pixel_and_every_r_is_that_of_register():
    found = registration.register(PAIR.reference, PAIR.sensed, POINTS)
    for k, point in enumerate(POINTS):
        dx, dy, r = best_shift(PAIR.reference, PAIR.sensed, point)
        assert (dx, dy) == (found.dx[k], found.dy[k])
        assert np.isclose(r.max(), found.r[k], atol=1e-9)
        assert r[dy + 3, dx + 3] == r.max()


def test_the_shift_is_sensed_minus_reference_columns_before_rows():
    sensed = SCENE[3:, :-2]  # moved by 3 rows up; and 2 columns lost on the right
    assert best_shift(SCENE, sensed, (60, 70))[:2] == (0, -3)
    assert best_shift(SCENE, SCENE[:, 2:], (60, 70))[:2] == (-2, 0)


def test_chip_and_radius_are_those_asked_for():
    *_, r = best_shift(PAIR.reference, PAIR.sensed, POINTS[0], 11, 2)
    wide = best_shift(PAIR.reference, PAIR.sensed, POINTS[0], 11, 3)[2]
    assert r.shape == (5, 5) and np.allclose(r, wide[1:-1, 1:-1])


@pytest.mark.parametrize("top", [-0.4, 0.0, 0.3])
def test_the_peak_of_an_exact_parabola_is_found(top):
    r = [0.9 - 0.1 * (t - top) ** 2 for t in (-1, 0, 1)]
    assert np.isclose(peak_of_parabola(*r), top)


@pytest.mark.parametrize("r", [(0.5, 0.5, 0.5), (0.9, 0.5, 0.9), (0.1, 0.2, 0.3)])
def test_three_values_that_are_no_hill_are_refused(r):
    with pytest.raises(ValueError, match="r_middle must be higher"):
        peak_of_parabola(*r)


def test_rmse_is_that_of_accuracy():
    dx, dy = np.random.default_rng(4).normal(1, 2, (2, 50))
    summed = registration.accuracy(dx, dy)
    wanted = summed.rmse_x, summed.rmse_y, summed.rmse_t
    assert np.allclose(rmse(dx, dy), wanted)


def test_parabolas_come_nearer_to_the_truth_than_whole_pixels():
    found = chip_shifts(PAIR.reference, PAIR.sensed, POINTS)
    error = np.hypot(*(found - PAIR.shift).T)
    assert np.median(error) < 0.2 < np.hypot(0.25, 0.25)


def test_a_peak_on_the_border_of_the_search_gives_no_shift():
    for sensed in (SCENE[3:], SCENE[:, 3:], SCENE[4:]):
        found = chip_shifts(SCENE, sensed, [(60, 70)])
        assert np.isnan(found).all()
