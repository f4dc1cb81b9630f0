"""Windows are followed as far as they may go, and bad arguments are named."""

import numpy as np
import pytest

from pgm_lab import lsm
from pgm_lab.lsm import _iteration


def window(column=30.0, row=20.0, affine=(1.0, 0.0, 0.0, 1.0)):
    a1, a2, b1, b2 = affine
    return np.array([[[column, a1, a2], [row, b1, b2]]])


@pytest.mark.parametrize(
    ("affine", "lost"),
    [
        ((1.99, 0, 0, 2.0), False),
        ((2.01, 0, 0, 2.0), True),
        ((0.51, 0, 0, 0.5), False),
        ((0.49, 0, 0, 0.5), True),
        ((-1.0, 0, 0, 1.0), True),
        ((1.0, 1.9, 0, 1.0), False),
        ((1.0, 2.1, 0, 1.0), True),
    ],
)
def test_a_window_is_lost_four_times_as_large_or_small_mirrored_or_stretched(
    affine, lost
):
    assert _iteration._lost(window(affine=affine), window()[:, :, 0], 10)[0] == lost


@pytest.mark.parametrize(
    ("off", "status"), [(5.0, "accepted"), (12.0, "diverged"), (13.0, "diverged")]
)
def test_a_match_may_lie_half_a_window_from_its_start_to_each_side(off, status):
    y, x = np.mgrid[:120, :120.0]
    hill = np.exp(-((x - 60) ** 2 + (y - 60) ** 2) / (2 * 30**2))
    photo = 100 * hill + 60 * np.exp(-((x - 75) ** 2 + (y - 50) ** 2) / (2 * 20**2))
    start = 60 + off * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    found = lsm.match(photo, photo, np.full((4, 2), 60.0), start, template=21)
    assert found.status.tolist() == 4 * [status]
