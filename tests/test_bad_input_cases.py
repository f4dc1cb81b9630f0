"""Single cases of bad input that the systematic test does not make."""

import numpy as np
import pytest

from pgm_book.ch04 import checks as chapter4
from pgm_book.common import checks
from pgm_lab import bundle, lsm, ncc, simulate
from tests.good_arguments import GREY, fresh, in_network


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int16, np.int64])
def test_a_small_integer_type_does_not_overflow(kind):
    points = [(20.0, 20.0)]
    small = lsm.match(GREY, GREY, points, points, kind(21))
    usual = lsm.match(GREY, GREY, points, points, 21)
    assert small.redundancy == usual.redundancy == 21**2 - 8
    image = simulate.photograph([300.0], 0.0, seed=1, bits=kind(8))
    assert image.tolist() == [255.0]
    found = ncc.match(GREY, GREY, points, template=kind(11), search=kind(21))
    np.testing.assert_allclose(found.points, points, atol=1e-9)


@pytest.mark.parametrize("name", ["sigma", "scale_bars", "exteriors", "points", "xy"])
def test_a_network_keeps_no_array_of_the_caller(name):
    given = fresh(in_network())
    given["sigma"] = np.full((len(given["xy"]), 2), 0.002)
    network = bundle.Network(**given)
    before = getattr(network, name).copy()
    given[name][:] += 1
    np.testing.assert_array_equal(getattr(network, name), before)


def test_a_network_keeps_no_control_sigma_and_no_covariance_of_the_caller():
    given = fresh(in_network())
    index, coordinates, sigma = given["control"]
    covariance = np.tile(np.eye(2) * 1e-6, (len(given["xy"]), 1, 1))
    given |= {"sigma": None, "covariance": covariance}
    network = bundle.Network(**given)
    for array in (index, coordinates, sigma, covariance):
        array += 1
    np.testing.assert_array_equal(network.control[0], index - 1)
    np.testing.assert_array_equal(network.control[1], coordinates - 1)
    np.testing.assert_array_equal(network.control[2], sigma - 1)
    np.testing.assert_allclose(network.covariance, covariance - 1, atol=1e-12)


def test_a_network_cannot_be_changed_through_one_sigma_for_all():
    sigma = np.array([0.001, 0.002])
    network = bundle.Network(**in_network() | {"sigma": sigma})
    sigma[:] = 9
    np.testing.assert_array_equal(network.sigma[0], [0.001, 0.002])


def test_a_function_that_returns_NaN_is_told_so():
    def rotation_matrix(omega, phi, kappa):
        return np.full((3, 3), np.nan)

    with pytest.raises(
        checks.CheckFailed, match="rotation_matrix must return finite numbers"
    ):
        chapter4.rotation_matrix(rotation_matrix)


def test_masked_numbers_are_refused_only_where_something_is_masked():
    image = np.ma.masked_array(GREY)
    points = [(20.0, 20.0)]
    found = ncc.match(image, image, points, template=11, search=21)
    assert found.status.tolist() == ["accepted"]
    image[3, 3] = np.ma.masked
    with pytest.raises(ValueError, match="search has masked values"):
        ncc.correlation_map(GREY[:5, :5], image)
