"""Quality against known truth: simulated steps in depth, and a stereo pair.

The limit was chosen on the stereo pair of this file;
`python -m pgm_book.common.real_pairs` confirms it on others.
"""

import cv2
import numpy as np
import pytest

from pgm_lab import datasets, lsm, ncc, simulate
from pgm_lab.matching._quality import RECOMMENDED, quality

SHAPE = (200, 300)
STEP = 5  # px between the disparities of the two surfaces


def two_surfaces(seed: int, strip: int = 40):
    """Left and right image of strips in front of a background, and the disparities."""
    shift = (STEP, 1, 0, 0, 0, 1)
    strong, weak = (
        simulate.texture(0.25, contrast=contrast, seed=seed + i)
        for i, contrast in enumerate((40, 10))
    )
    front = simulate.texture_pair(strong, SHAPE, shift)
    back, _ = simulate.texture_pair(weak, SHAPE, shift)
    rng, columns = np.random.default_rng(seed), np.indices(SHAPE)[1]
    left, right = (
        np.where((columns - moved) % (2 * strip) < strip, grey, back)
        + rng.normal(0, 2, SHAPE)
        for grey, moved in zip(front, (0, STEP), strict=True)
    )
    return left, right, np.where(columns % (2 * strip) < strip, STEP, 0)


def matched(left, right, points, start, search):
    """Points that correlation and least squares accept, and their quality."""
    near = ncc.match(left, right, points, start, search=search)
    points, start = points[near.accepted], near.points[near.accepted]
    found = lsm.match(left, right, points, start)
    q = quality(left, right, points, found)
    k = found.accepted
    assert np.isnan(q[~k]).all() and (q[k] >= 0).all() and (q[k] <= 1).all()
    return points[k], found.points[k], q[k]


def shares(found, truth, q):
    """Wrong among all, wrong among those kept, kept."""
    wrong, keep = np.hypot(*(found - truth).T) > 1, q >= RECOMMENDED
    return wrong.mean(), wrong[keep].mean(), keep.mean()


def beside_steps(seed: int):
    left, right, disparity = two_surfaces(seed)
    x, y = np.meshgrid(np.arange(30, 270, 7.0), np.arange(20, 180, 13.0))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    points, found, q = matched(left, right, points, points + (STEP / 2, 0), 41)
    column, row = points.astype(int).T
    return found, points + np.stack([disparity[row, column], 0 * column], axis=1), q


@pytest.mark.parametrize(
    "seeds", [[1], pytest.param([1, 2, 3], marks=pytest.mark.slow)]
)
def test_at_steps_in_depth_quality_tells_which_matches_are_wrong(seeds):
    some = [beside_steps(seed) for seed in seeds]
    wrong, wrong_kept, kept = shares(*map(np.concatenate, zip(*some, strict=True)))
    assert wrong > 0.15  # the strip with more contrast draws windows beside it
    assert wrong_kept <= 0.05 and kept >= 0.6


def test_on_one_surface_nearly_all_is_kept_also_when_it_is_turned_and_scaled():
    a, b = 1.1 * np.cos(0.2), 1.1 * np.sin(0.2)
    affine = (20, a, -b, -20, b, a)
    texture = simulate.texture(0.25, seed=5)
    left, right = simulate.texture_pair(texture, SHAPE, affine, sigma=2)
    x, y = np.meshgrid(np.arange(60, 240, 12.0), np.arange(50, 150, 12.0))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    T = np.reshape(affine, (2, 3))
    truth = points @ T[:, 1:].T + T[:, 0]
    found = lsm.match(left, right, points, truth + 0.4, shape=T[:, 1:])
    q = quality(left, right, points, found)
    assert found.accepted.mean() > 0.95
    assert (q[found.accepted] >= RECOMMENDED).mean() > 0.95


@pytest.fixture(scope="module")
def motorcycle():
    """Matches on the stereo pair, where texture is best in each of many cells."""
    pair = datasets.motorcycle()
    texture = cv2.cornerMinEigenVal(pair.left.astype(np.float32), 21)
    size, points = 24, []
    for row in range(30, 450, size):
        for column in range(30, 690, size):
            cell = texture[row : row + size, column : column + size]
            y, x = np.unravel_index(cell.argmax(), cell.shape)
            if cell[y, x] > np.median(texture):
                points.append((column + x, row + y))
    column, row = np.transpose(points)
    disparity = pair.disparity[row, column]
    known = np.isfinite(disparity)
    points = np.array(points, float)[known]
    truth = points - np.stack([disparity[known], np.zeros(known.sum())], axis=1)
    at, found, q = matched(pair.left, pair.right, points, points - (40, 0), (25, 101))
    order = {tuple(p): t for p, t in zip(points, truth, strict=True)}
    return found, np.array([order[tuple(p)] for p in at]), q


@pytest.mark.slow
def test_a_stereo_pair_has_at_most_5_per_cent_wrong_and_60_kept(motorcycle):
    wrong, wrong_kept, kept = shares(*motorcycle)
    assert wrong > 0.15  # there is something to tell
    assert wrong_kept <= 0.05 and kept >= 0.6


@pytest.mark.slow
def test_the_higher_the_quality_the_fewer_are_wrong(motorcycle):
    found, truth, q = motorcycle
    wrong = np.hypot(*(found - truth).T) > 1
    low, middle, high = (
        wrong[(q >= a) & (q < b)].mean() for a, b in ((0, 0.1), (0.1, 0.6), (0.6, 1))
    )
    assert low > middle > 5 * high


def test_points_that_were_not_matched_have_no_quality():
    texture = simulate.texture(seed=1)
    left, right = simulate.texture_pair(texture, (60, 60), (3, 1, 0, 2, 0, 1))
    points = [(2, 30), (30, 30)]
    found = lsm.match(left, right, points, [(5, 32), (33, 32)])
    q = quality(left, right, points, found)
    assert np.isnan(q[0]) and q[1] > 0.99
    nothing = lsm.match(left, right, points[:1])
    assert np.isnan(quality(left, right, points[:1], nothing)).all()
    with pytest.raises(ValueError, match="points must have shape"):
        quality(left, right, points[:1], found)
