"""Proofs of the verdicts on Bani 2010, the rotation matrix of appendix B: (2), (3)."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_lab import datasets, rotation

ATTITUDES = [(0.3, 0.4, 0.5), (1.0, 0.7, 1.1), (2.5, -1.2, -2.0)]


def matrix_3(omega, phi, kappa):
    """(3) as printed."""
    co, cp, ck = np.cos((omega, phi, kappa))
    so, sp, sk = np.sin((omega, phi, kappa))
    return np.array(
        [
            [cp * ck, so * ck + co * sk, -co * sp * ck + so * sk],
            [-cp * sk, -so * sp * sk + co * ck, co * sp * sk + so * ck],
            [sp, -so * cp, co * cp],
        ]
    )


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_eight_elements_of_3_are_those_of_muliawan_2_8(attitude):
    wrong = np.abs(matrix_3(*attitude) - rotation.matrix(*attitude)) > 1e-12
    equal(np.argwhere(wrong), [(0, 1)])


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_m12_of_3_needs_sin_phi_to_be_orthogonal(attitude):
    omega, phi, kappa = attitude
    M = matrix_3(*attitude)
    assert rotation.defect(M) > 0.2
    M[0, 1] = np.sin(omega) * np.sin(phi) * np.cos(kappa)
    M[0, 1] += np.cos(omega) * np.sin(kappa)
    assert rotation.defect(M) < 1e-15
    assert np.linalg.det(M) == approx(1)


def test_printed_m_left_was_not_computed_by_3_as_printed():
    # Appendix B prints m12 = -0.00052 for the left photo: the formula with sin(phi),
    # its angles taken as degrees (see chapter 5). Without it m12 would be ten
    # times larger.
    printed = datasets.bani2010_intersection()
    attitude, m12 = np.radians(printed["exterior"][0, 3:]), printed["M_left"][0, 1]
    assert rotation.matrix(*attitude)[0, 1] == approx(m12, abs=5.1e-6)
    assert matrix_3(*attitude)[0, 1] == approx(0.00525, abs=5.1e-6)
