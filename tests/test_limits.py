"""Each limit from both sides: what is just allowed, and what is not any more."""

import dataclasses
import importlib
import pkgutil

import numpy as np
import pytest

import pgm_lab
from pgm_lab import _validate, rotation
from pgm_lab.ncc import search_area
from tests.networks import real


def modules():
    names = [
        module.name for module in pkgutil.walk_packages(pgm_lab.__path__, "pgm_lab.")
    ]
    return [importlib.import_module(n) for n in names if not n.endswith("__main__")]


def test_whatever_holds_results_or_states_cannot_be_changed():
    found = {
        one
        for module in modules()
        for one in vars(module).values()
        if dataclasses.is_dataclass(one) and one.__module__.startswith("pgm_lab")
    }
    assert len(found) > 30
    assert [one for one in found if not one.__dataclass_params__.frozen] == []


ALMOST = rotation.matrix(0.3, -0.2, 0.9)


@pytest.mark.parametrize(
    "of",
    [
        rotation.angles,
        rotation.is_gimbal,
        rotation.to_tilt_azimuth_swing,
        rotation.to_quaternion,
        rotation.to_rodrigues,
        lambda M: rotation.angle_between(M, ALMOST),
        lambda M: rotation.angle_between(ALMOST, M),
    ],
)
def test_a_matrix_is_a_rotation_to_a_millionth(of):
    of(ALMOST * (1 + 0.4e-6))  # M M' is off by twice as much
    with pytest.raises(ValueError, match="is not a rotation"):
        of(ALMOST * (1 + 0.6e-6))


def with_covariance(change, scale=4e-6):
    network = real()
    C = np.tile(scale * np.array([[1.0, 0.5], [0.5, 1.0]]), (len(network.xy), 1, 1))
    C[7] += scale * np.array(change)
    return dataclasses.replace(network, sigma=None, covariance=C)


@pytest.mark.parametrize("scale", [1e-12, 4e-6, 1.0])
def test_a_covariance_is_symmetric_to_rounding(scale):
    with_covariance([[0, 1e-13], [0, 0]], scale)
    for more in (1e-11, 1e-6, 1e-2):
        with pytest.raises(ValueError, match=r"\[7\] is not symmetric"):
            with_covariance([[0, more], [0, 0]], scale)


def test_a_covariance_leaves_every_direction_an_error():
    with_covariance([[0, 0.4999], [0.4999, 0]])
    for more, why in ((0.5, "no error at all"), (0.5001, "not positive semi-definite")):
        with pytest.raises(ValueError, match=why):
            with_covariance([[0, more], [more, 0]])


def test_search_windows_beyond_the_edge_repeat_the_last_row_and_column():
    photo = np.random.default_rng(9).uniform(size=(12, 9))
    centres = np.array([[0, 0], [8, 11], [4, 6], [0, 11]])
    found, missing = search_area.windows(photo, centres, (7, 7))
    assert missing is None
    padded = np.pad(photo, 3, mode="edge")
    wanted = [padded[row : row + 7, column : column + 7] for column, row in centres]
    np.testing.assert_array_equal(found, wanted)


def test_a_hundred_million_numbers_are_the_most_of_an_array():
    assert _validate.whole(10**8, "n", 1) == 10**8
    with pytest.raises(ValueError, match="at most 100000000; got 100000001"):
        _validate.whole(10**8 + 1, "n", 1)
    _validate.size("shape", 10**4, 10**4)
    with pytest.raises(ValueError, match="10000 x 10001 numbers at once; the limit is"):
        _validate.size("shape", 10**4, 10**4 + 1)
