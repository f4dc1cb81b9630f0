"""The bundle adjustment against JAICOV, a program in Java that shares no code with it.

Both have the same network, start values, lens direction and inner constraints, which
follow the points from iteration to iteration, so that even the datum is the same. It
stops when its corrections are small: 1e-6 of a standard deviation is what it leaves.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close

from pgm_lab import bundle
from pgm_lab.camera import Camera
from tests.networks import jaicov_9x50

DATA = jaicov_9x50()


def adjusted(lens):
    network = bundle.Network(
        Camera(*DATA.interior, lens=lens),
        *(DATA.exteriors, DATA.points, DATA.photo, DATA.point, DATA.xy, DATA.sigma),
    )
    return bundle.adjust(network)


@pytest.fixture(scope="module")
def ours():
    return adjusted("forward")


def test_redundancy_and_variance_of_unit_weight(ours):
    assert ours.status == "converged"
    assert ours.redundancy == DATA.redundancy == 693
    close(ours.sigma0**2, DATA.variance, rtol=1e-9)  # 10 digits


@pytest.mark.parametrize("which", ["interior", "exteriors", "points"])
def test_parameters_to_a_millionth_of_their_standard_deviation(ours, which):
    found = ours.cameras[0].interior if which == "interior" else getattr(ours, which)
    expected, sd = getattr(DATA, f"adjusted_{which}"), getattr(DATA, f"{which}_sd")
    assert np.abs((found - expected) / sd).max() < 1e-6


@pytest.mark.parametrize("which", ["interior", "exteriors", "points"])
def test_standard_deviations_to_eight_digits(ours, which):
    expected = getattr(DATA, f"{which}_sd")
    close(getattr(ours, f"sd_{which}"), expected, rtol=1e-8)


def test_with_the_other_lens_direction_the_camera_is_another_one():
    # or the comparison would say nothing about the lens
    found = adjusted("backward").cameras[0].interior
    difference = (found - DATA.adjusted_interior) / DATA.interior_sd
    assert abs(difference[3]) > 10  # K1 has the opposite sign
