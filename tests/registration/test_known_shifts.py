"""How far shifts are from a truth that is known, and how far they say they are."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from pgm_lab import datasets, matching, simulate
from pgm_lab.registration import register
from pgm_lab.registration.chips import _factor

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


SLOW = pytest.mark.slow


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


@pytest.mark.parametrize(
    ("blur", "kind", "how", "limit", "limit_of_mean"),
    [
        (0.7, "picked", {}, 0.012, 0.004),
        # with the alias
        pytest.param(0.0, "picked", {}, 0.036, 0.03, marks=SLOW),
        pytest.param(0.0, "random", {}, 0.036, 0.03, marks=SLOW),
        # some of them are weak
        pytest.param(0.7, "random", {}, 0.025, 1.0, marks=SLOW),
        # its limit
        pytest.param(0.7, "random", {"largest_sd": 0.02}, 0.015, 0.004, marks=SLOW),
    ],
)
@pytest.mark.parametrize("factor", FACTORS)
def test_a_hundredth_of_a_pixel_and_three_with_the_alias(
    factor, blur, kind, how, limit, limit_of_mean
):
    rmse, mean, share = errors(factor, blur, kind, refine="lsm", **how)
    assert rmse <= limit and mean <= limit_of_mean and share >= 0.7


@pytest.mark.slow
@pytest.mark.parametrize("factor", [3, 4])
def test_the_alias_is_why_both_images_are_smoothed(factor):
    """It pulls towards whole pixels, twice as far as all errors that are left."""
    as_they_are = errors(factor, 0.0, "picked", refine="lsm", smooth=0)
    smoothed = errors(factor, 0.0, "picked", refine="lsm")
    assert as_they_are[0] > 2 * smoothed[0]
    assert as_they_are[1] > 3 * smoothed[1]
    # And costs little where there is none
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


FINE = textures(0.35, 10.0)
LSM, NOT_SMOOTHED = {"refine": "lsm"}, {"refine": "lsm", "smooth": 0}
PARABOLA, WHOLE = {"refine": "parabola"}, {"seeds": range(40)}
PREDICTED = [  # with limits of both ratios
    pytest.param(textures(0.1, 2.0), LSM, 0.91, 1.1, 1.1, marks=SLOW),
    (FINE, LSM, 0.91, 1.1, 1.1),
    pytest.param(real(2, 0.7, 15.0), LSM, 0.83, 1.2, 1.2, marks=SLOW),
    pytest.param(real(4, 0.7, 60.0), LSM, 0.83, 1.2, 1.2, marks=SLOW),
    pytest.param(FINE, NOT_SMOOTHED, 0.9, 1.1, 1.1, marks=SLOW),
    pytest.param(textures(0.2, 10.0), PARABOLA, 0.87, 1.15, 1.15, marks=SLOW),
    (FINE, PARABOLA, 0.87, 1.35, 1.35),  # pixel locking
    (real(4, 0.7, 60.0), PARABOLA, 0.87, 1.15, 1.15),
    # The alias is no noise: part of it moves the window without a residual
    pytest.param(real(2, 0.0, 15.0), LSM, 0.9, 1.25, 1.3, marks=SLOW),
    pytest.param(real(4, 0.0, 15.0), LSM, 0.9, 1.25, 1.3, marks=SLOW),
    (textures(0.2, 2.0), WHOLE, 0.9, 1.1, 1.1),  # rounded
]


@pytest.mark.parametrize(("make", "how", "low", "high", "high_normalized"), PREDICTED)
def test_errors_are_as_large_as_predicted(make, how, low, high, high_normalized):
    """Within a tenth; a fifth on a real image, and with its alias up to 1.3."""
    ratio, normalized = sampled(make, **how)
    assert low < ratio < high and low < normalized < high_normalized


@pytest.mark.parametrize(
    ("errors", "predicted", "low", "high"),
    [
        (1.0, 1.0, 1.0, 1.0),  # no more than chance
        (2.0, 1.0, 1.8, 2.2),
        (1.0, 3.0, 0.3, 0.37),
        # Five times too large of every other chip: 0.50. By the median it would be 0.38
        (1.0, np.array([1.0, 5.0]), 0.45, 0.55),
        # One of five is a blunder: 1.45. By the mean square it would be 9
        (np.array([20.0, 1, 1, 1, 1]), 1.0, 1.3, 1.6),
    ],
)
def test_the_factor_is_that_of_the_errors_beside(errors, predicted, low, high):
    random = np.random.default_rng(1)
    points = 100.0 * random.permutation(1000).reshape(-1, 1) * [1.0, 0.0]

    def match(at, start):
        """Of 200 chips, eight beside each: their errors and what is predicted."""
        e, sd = (np.resize(np.repeat(v, 8), len(at)) for v in (errors, predicted))
        off = 0.01 * e[:, None] * random.normal(size=at.shape)
        covariance = (0.01 * sd[:, None, None]) ** 2 * np.eye(2)
        return SimpleNamespace(points=start + off, covariance=covariance)

    assert low <= _factor(match, points, points + 1.5, 21) <= high


def test_chips_that_overlap_do_not_make_a_factor_surer():
    """The same points again say nothing new of how far chips are off."""
    reference, sensed, _ = textures(0.1, 2.0)(0)
    points = np.tile(matching.pick(reference, 60, margin=20), (3, 1))
    assert register(reference, sensed, points, refine="lsm").factor == 1.0
