"""Times of a registration beside OpenCV, in one run: `make benchmark`.

100,000 chips of 21 px, radius 3, whole pixels, in one call; OpenCV's bare loop finds
the highest value and its place: no second peak, no covariance, no status.
"""

import cv2
import numpy as np
import pytest

from pgm_lab import datasets
from pgm_lab.registration import register

CHIPS = "100,000 chips, 21 px, radius 3"
ROUNDS = 3
SHIFT = (-1, 2)


def scene(n=100_000):
    reference = datasets.landsat().grey
    sensed = np.roll(reference, SHIFT[::-1], axis=(0, 1))
    return reference, sensed, np.random.default_rng(1).integers(14, 1186, (n, 2))


@pytest.mark.benchmark(group=CHIPS)
def test_register(benchmark):
    found = benchmark.pedantic(register, scene(), rounds=ROUNDS)
    assert found.accepted.mean() > 0.97
    np.testing.assert_array_equal(np.stack([found.dx, found.dy], 1), [SHIFT] * 100_000)


@pytest.mark.benchmark(group=CHIPS)
def test_register_opencv(benchmark):
    reference, sensed, points = scene()

    def loop():
        left, right = reference.astype(np.float32), sensed.astype(np.float32)
        found = np.empty(points.shape)
        for i, (x, y) in enumerate(points):
            r = cv2.matchTemplate(
                right[y - 13 : y + 14, x - 13 : x + 14],
                left[y - 10 : y + 11, x - 10 : x + 11],
                cv2.TM_CCOEFF_NORMED,
            )
            column, row = cv2.minMaxLoc(r)[3]
            found[i] = column - 3, row - 3
        return found

    found = benchmark.pedantic(loop, rounds=ROUNDS)
    np.testing.assert_array_equal(found, [SHIFT] * 100_000)
