"""How far shifts are from a truth that is known, and how far they say they are."""

from functools import cache

import numpy as np
import pytest

from pgm_lab import datasets, matching, simulate
from pgm_lab.registration import register

LANDSAT = datasets.landsat().grey
FACTORS = pytest.param(2, marks=pytest.mark.slow), 3, 4


@cache
def pair(factor, shift, blur, seed, sigma=15.0):
    return simulate.ortho_pair(
        *(LANDSAT, shift, factor),
        **dict(blur=blur, gain=0.9, offset=300, sigma=sigma, seed=seed),
        dtype=np.uint16,
    )


def chips(image, kind, seed, n=50):
    """Picked by their texture, or taken at random."""
    if kind == "picked":
        return matching.pick(image, n, margin=20)
    rows, columns = image.shape
    random = np.random.default_rng(seed)
    x, y = random.integers(20, columns - 20, n), random.integers(20, rows - 20, n)
    return np.stack([x, y], axis=1)


@cache
def errors(factor, blur, kind, **how):
    """RMSE_T, largest mean and least share accepted over shifts and seeds."""
    rmse, mean, share = [], [], []
    shifts = (1, 1), (factor - 1, 1), (factor + 1, 2 * factor - 1), (-1, factor // 2)
    for seed, shift in enumerate(shifts):
        one = pair(factor, shift, blur, seed)
        points = chips(one.reference, kind, seed)
        found = register(one.reference, one.sensed, points, **how)
        error = np.stack([found.dx, found.dy], axis=1)[found.accepted] - one.shift
        rmse.append(np.sqrt(np.mean(np.sum(error**2, axis=1))))
        mean.append(np.abs(error.mean(axis=0)).max())
        share.append(found.accepted.mean())
    return max(rmse), max(mean), min(share)


@pytest.mark.parametrize("factor", FACTORS)
def test_without_alias_a_hundredth_of_a_pixel(factor):
    rmse, mean, share = errors(factor, 0.7, "picked", refine="lsm")
    assert rmse <= 0.012 and mean <= 0.004 and share >= 0.7


@pytest.mark.parametrize("kind", ["picked", "random"])
@pytest.mark.parametrize("factor", FACTORS)
def test_with_the_alias_three_hundredths(factor, kind):
    rmse, mean, share = errors(factor, 0.0, kind, refine="lsm")
    assert rmse <= 0.036 and mean <= 0.03 and share >= 0.7


@pytest.mark.parametrize("factor", FACTORS)
def test_random_chips_without_alias_lie_within_what_was_asked_for(factor):
    """Some of them are weak: what a chip may contribute is `largest_sd`."""
    wide = errors(factor, 0.7, "random", refine="lsm")
    tight = errors(factor, 0.7, "random", refine="lsm", largest_sd=0.02)
    assert wide[0] <= 0.025 and wide[2] >= 0.7
    assert tight[0] <= 0.015 and tight[1] <= 0.004 and tight[2] >= 0.7


@pytest.mark.parametrize("factor", [3, 4])
def test_the_alias_is_why_both_images_are_smoothed(factor):
    """It pulls towards whole pixels, twice as far as all errors that are left."""
    as_they_are = errors(factor, 0.0, "picked", refine="lsm", smooth=0)
    smoothed = errors(factor, 0.0, "picked", refine="lsm")
    assert as_they_are[0] > 2 * smoothed[0]
    assert as_they_are[1] > 3 * smoothed[1]


def test_smoothing_costs_little_where_there_is_no_alias():
    as_they_are = errors(4, 0.7, "picked", refine="lsm", smooth=0)
    smoothed = errors(4, 0.7, "picked", refine="lsm")
    assert smoothed[0] < 1.3 * as_they_are[0]


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize(("blur", "limit"), [(0.7, 0.06), (0.0, 0.13)])
def test_the_parabola_lies_between_whole_pixels_and_least_squares(blur, limit, factor):
    rmse, _, share = errors(factor, blur, "picked", refine="parabola")
    assert rmse <= limit and share >= 0.7
    assert errors(factor, blur, "picked", refine="lsm")[0] < rmse / 2
    assert rmse < errors(factor, blur, "picked")[0] / 2


@cache
def sampled(make, seeds=range(6), **how):
    """Errors of coordinates, predicted variances, squared distances over predicted."""
    errors, variances, squares = [], [], []
    for seed in seeds:
        reference, sensed, shift = make(seed)
        points = matching.pick(reference, 60, margin=20)
        found = register(reference, sensed, points, largest_sd=10.0, **how)
        k = found.accepted
        error = np.stack([found.dx, found.dy], axis=1)[k] - shift
        errors.append(error)
        variances.append(found.sd[k] ** 2)
        inverse = np.linalg.inv(found.covariance[k])
        squares.append(np.einsum("ni,nij,nj->n", error, inverse, error))
    error, variance = np.concatenate(errors), np.concatenate(variances)
    return (
        np.sqrt(np.mean(error**2) / np.mean(variance)),
        np.sqrt(np.mean(np.concatenate(squares)) / 2),
    )


def textures(finest, sigma):
    """Pairs of texture up to so many cycles a pixel, at random shifts."""

    def make(seed):
        shift = np.random.default_rng(seed).uniform(-2, 2, 2)
        texture = simulate.texture(finest, contrast=30.0, mean=500.0, seed=seed)
        affine = (shift[0], 1, 0, shift[1], 0, 1)
        both = simulate.texture_pair(
            texture, (200, 200), affine, gain=0.9, sigma=sigma, seed=seed
        )
        return *both, shift

    return make


def real(factor, blur, sigma):
    def make(seed):
        shift = np.random.default_rng(seed).integers(-5, 6, 2)
        one = pair(factor, tuple(map(int, shift)), blur, seed, sigma)
        return one.reference, one.sensed, one.shift

    return make


SCENES = [textures(0.1, 2.0), textures(0.2, 10.0), textures(0.35, 10.0)]
REAL = [real(2, 0.7, 15.0), real(4, 0.7, 60.0)]
SOME = [*SCENES, pytest.param(REAL[0], marks=pytest.mark.slow), REAL[1]]


@pytest.mark.parametrize("make", SOME)
def test_least_squares_matching_predicts_its_errors(make):
    """Within a tenth, a fifth on the real image; smoothed residuals are alike."""
    ratio, normalized = sampled(make, refine="lsm")
    near = 1.1 if make in SCENES else 1.2
    assert 1 / near < ratio < near and 1 / near < normalized < near


@pytest.mark.parametrize("make", [textures(0.2, 2.0), textures(0.35, 10.0)])
def test_so_it_does_without_smoothing(make):
    ratio, normalized = sampled(make, refine="lsm", smooth=0)
    assert 0.9 < ratio < 1.1 and 0.9 < normalized < 1.1


@pytest.mark.parametrize("make", SOME)
def test_the_parabola_predicts_its_errors(make):
    """Within 15 %, but for pixel locking in the finest texture, where it is a third."""
    ratio, normalized = sampled(make, refine="parabola")
    near = 1.35 if make is SCENES[2] else 1.15
    assert 1 / 1.15 < ratio < near and 1 / 1.15 < normalized < near


@pytest.mark.parametrize(
    "factor", [*(pytest.param(n, marks=pytest.mark.slow) for n in (2, 3)), 4]
)
def test_with_the_alias_the_prediction_is_up_to_a_fifth_too_small(factor):
    """The alias is no noise: part of it moves the window without a residual."""
    ratio, normalized = sampled(real(factor, 0.0, 15.0), refine="lsm")
    assert 0.9 < ratio < 1.25 and 0.9 < normalized < 1.3


def test_whole_pixels_are_predicted_as_rounded():
    ratio, normalized = sampled(textures(0.2, 2.0), range(40))
    assert 0.9 < ratio < 1.1 and 0.9 < normalized < 1.1
