"""Chips whose ground changed between the two images, named so; and no others."""

import numpy as np
import pytest

from pgm_lab import datasets, simulate
from pgm_lab.registration import register

LANDSAT = datasets.landsat().grey
SIDE = 31  # px, of a field that is replaced: a chip with the radius, and two to spare


def fields(factor, seed, share=0.3, shift=(1, 2), blur=0.0, sigma=15.0):
    """A pair, points on a grid, and which of them stand on replaced ground.

    What stands there instead is ground from elsewhere in the same image.
    """
    pair = simulate.ortho_pair(
        LANDSAT, shift, factor, blur=blur, gain=0.9, offset=300, sigma=sigma, seed=seed
    )
    rows, columns = pair.sensed.shape
    x, y = np.meshgrid(np.arange(20, columns - 20, 34), np.arange(20, rows - 20, 34))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    random = np.random.default_rng(seed)
    changed = random.random(len(points)) < share
    elsewhere = np.roll(pair.sensed, (rows // 2, columns // 3), axis=(0, 1))
    sensed, half = pair.sensed.copy(), SIDE // 2
    for x, y in points[changed]:
        part = np.s_[y - half : y + half + 1, x - half : x + half + 1]
        sensed[part] = elsewhere[part]
    return pair.reference, sensed, points, changed


@pytest.mark.parametrize("refine", [None, "lsm"])
@pytest.mark.parametrize(("factor", "least"), [(2, 0.6), (3, 0.7), (4, 0.8)])
def test_most_changed_chips_are_named_and_hardly_any_other(refine, factor, least):
    """Those that are not lie where one of the two grounds has too little texture.

    Measured with two seeds: see the assertions; nothing replaced is ever accepted.
    """
    named, wrongly, accepted = [], [], []
    for seed in (1, 2):
        reference, sensed, points, changed = fields(factor, seed)
        found = register(reference, sensed, points, refine=refine)
        named.append((found.status == "changed")[changed])
        wrongly.append((found.status == "changed")[~changed])
        accepted.append(found.accepted[changed])
    assert np.mean(np.concatenate(named)) >= least
    assert np.mean(np.concatenate(wrongly)) <= 0.01
    assert not np.any(np.concatenate(accepted))


@pytest.mark.parametrize("sigma", [15.0, 150.0, 400.0])
def test_noise_is_no_change(sigma):
    """Weak texture sinks in it, and is then below the threshold."""
    found = register(*fields(3, 3, share=0.0, sigma=sigma)[:3])
    assert 0 < found.accepted.sum()
    assert np.mean(found.status == "changed") <= 0.01


def test_a_flat_cloud_cannot_be_told_from_weak_texture():
    """By its definition: textured in both images."""
    reference, sensed, points, _ = fields(4, 1, share=0.0)
    sensed[100:200, 100:200] = 9000
    found = register(reference, sensed, points)
    under = np.all((points > 116) & (points < 184), axis=1)
    assert under.sum() >= 2
    assert set(found.status[under]) == {"flat window"}


def test_where_nothing_is_accepted_nobody_knows_what_is_usual():
    found = register(LANDSAT[:400, :400], LANDSAT[600:1000, 600:1000], [(50, 60)] * 9)
    assert "changed" not in found.status


def test_images_that_agree_to_the_last_digit_have_no_change():
    """Where neighbours reach r = 1, a rounding error is not one."""
    sensed = np.roll(LANDSAT.astype(float), (1, 1), axis=(0, 1))
    points = fields(3, 1)[2]
    found = register(LANDSAT, 1.1 * sensed + 0.3, points)
    assert "changed" not in found.status and np.all(found.r > 0.999)


def test_a_change_that_leaves_half_of_the_chip_is_left_to_r():
    """And to the predicted precision: it is matched by something."""
    reference, sensed, points, changed = fields(3, 1)
    found = register(reference, sensed, points, threshold=0.3)
    assert np.all(found.r[found.status == "changed"] < np.sqrt(0.5))


def test_what_moved_farther_than_the_radius_is_named_too():
    """As all that is matched by nothing within it; the docstring says so."""
    reference, sensed, points, _ = fields(4, 1, share=0.0, blur=0.7)
    moved, half = sensed.copy(), 20
    one = int(np.argmin(np.abs(points - 150).sum(axis=1)))
    x, y = points[one]
    moved[y - half : y + half, x - half : x + half] = sensed[
        y - half : y + half, x - half - 9 : x + half - 9
    ]
    found = register(reference, moved, points)
    before = register(reference, sensed, points)
    assert before.status[one] == "accepted" and found.status[one] == "changed"
