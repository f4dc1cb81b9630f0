"""Small pairs with known truth."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from pgm_lab import simulate, stereo_map


@pytest.fixture(scope="session")
def pair():
    """A part of both aerial photos."""
    return simulate.aerial_pair((420, 300))


@pytest.fixture(scope="session")
def oriented(pair):
    return stereo_map.open_pair(pair.left, pair.right)


@pytest.fixture(scope="session")
def bare():
    """Photos of a wide angle and of bare ground, as good points to orient."""
    lens = replace(simulate.aerial.CAMERA, c=8.0, K1=0.0, K2=0.0, P1=0.0, P2=0.0)
    return simulate.aerial_pair(
        (480, 340), camera=lens, cell=0.5, buildings=0, trees=0, overlap=0.7
    )


@pytest.fixture(scope="session")
def unknown(bare):
    """The same, not oriented, with 14 points."""
    nothing = np.zeros(6)
    session = stereo_map.open_pair(
        replace(bare.left, exterior=nothing), replace(bare.right, exterior=nothing)
    )
    for pixel in itertools.product(range(30, 480, 70), range(30, 340, 46)):
        point = stereo_map.measure(session, pixel)
        if point.accepted and len(session.points) < 14:
            session = stereo_map.add(session, point)
    return session


def true_ground(pair, point):
    """Object point that the left photo shows at a whole pixel."""
    column, row = point.left.astype(int)
    return pair.ground[0][row, column]
