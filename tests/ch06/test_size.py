"""A part of the table of times and memory of chapter 6, repeated, and what it claims.

The whole is made by pgm_book/ch06/studies/size.py. Times are not repeated here: they
depend on the machine, and on what else it has to do.
"""

import numpy as np
import pytest

from pgm_book.ch06.studies import network as networks
from pgm_book.ch06.studies import size as study
from pgm_book.common import results
from pgm_lab import bundle
from pgm_lab.bundle import reduced

ROWS = results.rows("ch06", "size")


def column(name):
    return np.array([float(row[name]) for row in ROWS])


def test_the_table_has_the_sizes_of_the_script():
    assert tuple(ROWS[0]) == study.COLUMNS
    found = [(int(row["photos"]), int(row["points"])) for row in ROWS]
    assert found == [size[:2] for size in study.SIZES]


@pytest.mark.parametrize("which", [0, 1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_row_repeats(which):
    *size, _ = study.SIZES[which]
    rays, iterations, _, peak = study.ours(*size, runs=1)
    assert rays == int(ROWS[which]["rays"])
    assert iterations == int(ROWS[which]["iterations"])
    # other versions of numpy hold a little more or less at a time
    assert float(peak) < 1.5 * float(ROWS[which]["peak_mb"])


def test_large_networks_take_no_more_time_than_the_peer():
    """Both with Gauss-Newton steps alike, to what another load of the machine does."""
    large = column("rays") > 25_000
    assert large.sum() == 3
    assert np.all(
        column("colmap_gauss_newton_s")[large] > 0.9 * column("seconds")[large]
    )
    assert np.all(column("colmap_default_s")[large] > 3 * column("seconds")[large])


def test_time_and_memory_grow_with_the_rays_not_faster():
    large = column("rays") > 10_000
    for cost in (column("seconds")[large], column("peak_mb")[large]):
        per_ray = cost / column("rays")[large]
        assert per_ray[-1] < 1.5 * per_ray[0]


@pytest.mark.parametrize("at_once", [1, 7, 10**6])
def test_pairs_of_rays_in_portions_give_the_same(at_once, monkeypatch):
    """A portion may end amid the pairs of a ray, or of two photos."""
    network = networks.network(6, 20, 3.5, False)
    monkeypatch.setattr(reduced, "WHOLE", 0)
    whole = bundle.adjust(network, networks.ESTIMATE)
    monkeypatch.setattr(reduced, "PAIRS_AT_ONCE", at_once)
    found = bundle.adjust(network, networks.ESTIMATE)
    np.testing.assert_allclose(found.points, whole.points, atol=1e-7)
    np.testing.assert_allclose(found.covariance, whole.covariance, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.sd_points, whole.sd_points, rtol=1e-6)
    np.testing.assert_allclose(
        found.redundancy_numbers, whole.redundancy_numbers, atol=1e-8
    )
