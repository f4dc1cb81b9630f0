"""From how far the program of lesson 3 finds home, as its text says."""

import numpy as np
import pytest

from pgm_book.program import lsm as textbook
from pgm_lab import simulate


def arrived(cutoff, distance, textures=12):
    """Share of starts at a distance (px), in random directions, that end within 0.1 px.

    Windows of 21 pixels, noise of one grey value, no shift: the truth is (40, 40).
    """
    found = []
    for seed in range(textures):
        left, right = simulate.texture_pair(
            simulate.texture(cutoff, seed=seed), (80, 80), (0, 1, 0, 0, 0, 1), sigma=1.0
        )
        turns = np.random.default_rng(seed).uniform(0, 2 * np.pi, 4)
        for x, y in 40 + distance * np.column_stack([np.cos(turns), np.sin(turns)]):
            try:
                trail, _, _ = textbook.match(
                    left, right, (40, 40), [x, 1, 0, y, 0, 1, 0, 1], 21
                )
            except ValueError:
                found.append(False)
            else:
                found.append(np.hypot(*(trail[-1, [0, 3]] - 40)) < 0.1)
    return np.mean(found)


@pytest.mark.parametrize(
    ("cutoff", "safe", "half_wave"),
    [(0.2, 1.7, 2.5), pytest.param(0.4, 1, 1.25, marks=pytest.mark.slow)],
)
def test_safe_from_near_and_lost_from_half_the_shortest_wave(cutoff, safe, half_wave):
    assert arrived(cutoff, safe) == 1
    assert arrived(cutoff, half_wave) < 0.4
