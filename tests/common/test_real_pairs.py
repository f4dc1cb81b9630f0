"""The made pairs of `pgm_book.common.real_pairs`: is what they call the truth true?"""

import cv2
import numpy as np
import pytest

from pgm_book.common.real_pairs import pairs
from pgm_book.common.real_pairs.rows import grid, picked
from pgm_lab import simulate

SHIFTS = np.linspace(-0.5, 0.5, 5)  # px


def best_shift(left, right, truth, points):
    """Of shifts of the right photo from the truth, the one that is most like the left.

    `truth` takes left points (n, 2) to right ones.
    """
    row, column = np.indices((21, 21)) - 10
    around = points[:, None] + np.stack([column, row], axis=-1).reshape(-1, 2)
    there = truth(around.reshape(-1, 2)).reshape(around.shape).astype(np.float32)
    x, y = around.astype(int).transpose(2, 0, 1)
    grey = left[y, x].astype(float)

    def alike(shift):
        u, v = np.moveaxis(there + np.float32(shift), -1, 0)
        other = cv2.remap(right.astype(np.float32), u, v, cv2.INTER_CUBIC)
        return np.mean(
            [np.corrcoef(a, b)[0, 1] for a, b in zip(grey, other, strict=True)]
        )

    rs = np.array([[alike((dx, dy)) for dx in SHIFTS] for dy in SHIFTS])
    i, j = np.unravel_index(rs.argmax(), rs.shape)
    return SHIFTS[j], SHIFTS[i]


@pytest.fixture(scope="module")
def subject():
    return simulate.texture_pair(
        simulate.texture(0.2, seed=3), (240, 260), (0, 1, 0, 0, 0, 1), dtype=np.uint8
    )[0]


@pytest.mark.parametrize(("degrees", "scale"), [(0, 1), (10, 1.2), (15, 0.85)])
def test_a_photo_taken_again_lies_where_its_homography_says(subject, degrees, scale):
    pair = pairs.rephotographed("texture", subject, degrees, scale)
    points = picked(pair.left, 400, margin=60)
    assert len(points) > 10
    assert best_shift(pair.left, pair.right, pair.truth, points) == (0, 0)


@pytest.mark.slow
def test_cards_lie_where_their_disparities_say():
    pair = pairs.things(many=12)
    points = grid(pair.left, 5000)
    column, row = points.astype(int).T
    window = np.ones((23, 23))
    step = cv2.dilate(pair.disparity, window) - cv2.erode(pair.disparity, window)
    flat = step[row, column] < 2  # the window sees one card, or the gravel
    near = pair.disparity[row, column] > 16
    for k in (flat & near, flat & ~near):
        assert k.sum() >= 5
        assert best_shift(pair.left, pair.right, pair.truth, points[k][:30]) == (0, 0)
