"""The limits of the warnings, and what figures choose: planted on both sides."""

import re
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.stats import chi2

from pgm_lab import bundle
from pgm_lab.report import _figures, _findings, _words
from tests.networks import real


@pytest.fixture(scope="module")
def good():
    """A result with nothing to warn of."""
    result = bundle.adjust(real())
    return replace(
        result,
        sigma0=1.0,
        standardized=np.zeros_like(result.standardized),
        covariance=np.diag(np.full(len(result.names), 1e-30)),
    )


def titles(result):
    return [finding.title for finding in _findings.findings(result)]


@pytest.mark.parametrize("r, warned", [(0.099, True), (0.101, False)])
def test_below_a_tenth_a_ray_is_hardly_controlled(good, r, warned):
    numbers = good.redundancy_numbers.copy()
    numbers[7, 1] = r
    found = titles(replace(good, redundancy_numbers=numbers))
    assert found == ["Hardly controlled observations"] * warned


@pytest.mark.parametrize("times, warned", [(3.05, True), (2.95, False)])
def test_three_times_the_usual_uncertainty_is_a_weak_photo(good, times, warned):
    """The projection centre of the third photo, in all three directions."""
    covariance = good.covariance.copy()
    centre = 10 + 6 * 2 + np.arange(3)
    covariance[centre, centre] *= times**2
    weak = replace(good, covariance=covariance)
    assert list(_findings.weak_photos(weak)) == [2] * warned
    assert titles(weak) == ["Weak photos"] * warned


@pytest.mark.parametrize("prior", [None, 0.2])
@pytest.mark.parametrize(
    "below, warned", [(0.024, True), (0.026, False), (0.974, False), (0.976, True)]
)
def test_sigma0_is_warned_of_in_five_of_a_hundred_cases(good, prior, below, warned):
    """2.5 on either side: sigma0 with so much probability below it."""
    sigma0 = np.sqrt(chi2.ppf(below, good.redundancy) / good.redundancy)
    found = replace(good, sigma0=(prior or 1.0) * sigma0, sigma0_prior=prior)
    assert titles(found) == ["Stated standard deviations"] * warned


@pytest.mark.parametrize("number, chance", [(3, True), (4, False)])
def test_three_of_900_are_chance_and_four_are_not(good, number, chance):
    """One in a thousand: more than three of 900 happen once in 75 networks."""
    w = good.standardized.copy()
    w[:number, 0] = 3.4
    ((_, words),) = _findings.findings(replace(good, standardized=w))
    assert "where chance alone gives about 0.9" in words
    assert ("no more than chance" in words) == chance


@pytest.mark.parametrize(
    "sigma, free",
    [((0, 0, 0), False), ((0, 0, 1), True), ((0, np.inf, 0), True), ((1, 1, 1), True)],
)
def test_a_point_with_two_rays_is_free_unless_all_of_it_is_held(good, sigma, free):
    network = good.network
    others = np.flatnonzero((network.point == 3) & (network.photo > 1))
    kept = np.delete(np.arange(len(network.xy)), others)
    control = [3], network.points[[3]], [sigma]
    found = replace(
        good,
        network=replace(network.without(others), control=control),
        residuals=good.residuals[kept],
        standardized=good.standardized[kept],
        redundancy_numbers=good.redundancy_numbers[kept],
        control_standardized=np.zeros((1, 3)),
    )
    assert titles(found) == ["Points with two rays"] * free
    several = replace(found, network=replace(found.network, control=None, fixed=[3]))
    assert titles(replace(several, control_standardized=np.zeros((0, 3)))) == []


def test_only_weighted_coordinates_count_as_observations(good):
    """Of nine one is held, one free: neither is an observation; one unknown less."""
    sigma = np.full((3, 3), 0.05)
    sigma[0, 0], sigma[1, 1] = 0, np.inf
    control = [0, 9, 30], good.network.points[[0, 9, 30]], sigma
    # 900 + 7 against 10 + 54 + 149 unknowns
    result = replace(
        good, network=replace(good.network, control=control), redundancy=694
    )
    said = _words.summary(result)
    assert "900 image coordinates and 7 control coordinates for 213 unknowns" in said
    assert "inner constraint" not in said


@pytest.mark.parametrize("times, marked", [(3.2, 0), (3.4, 1)])
def test_a_mean_residual_beyond_3_3_of_its_sd_is_marked(good, times, marked):
    """15 cells of 30 rays, whose residuals of one length cancel but in one cell.

    The mean of 30 residuals has the sd of all divided by the root of 30.
    """
    ray = np.arange(450)
    cell = ray // 30
    xy = np.stack([2.0 * (cell % 5) + 0.1, 2.0 * (cell // 5) + 0.1], axis=1)
    v = 1e-3 * np.stack([1 - 2 * (ray % 2)] * 2, axis=1)
    # the biased ones take part in the mean square, (14 * 30 * 2 + 30 b^2) / 900
    v[cell == 7] = 1e-3 * np.sqrt(840 * times**2 / (27000 - 30 * times**2)), 0
    shown = replace(good, residuals=v, network=replace(good.network, xy=xy))
    figure, words = _figures.mean_residuals(shown)
    plt.close(figure)
    assert "in 15 cells" in words
    assert int(re.search(r"(\d+) are longer", words)[1]) == marked


def precision(result):
    ((figure, words),) = _figures.precision(result)
    plt.close(figure)
    return words


def test_the_largest_semi_axis_tells_how_precise_a_point_is(good):
    """Ellipsoids of 1, 2 and 4 units turned about; the last point is twice as bad."""
    rng = np.random.default_rng(2)
    axes, _ = np.linalg.qr(rng.normal(size=(50, 3, 3)))
    covariance = axes @ np.diag([1.0, 4.0, 16.0]) @ axes.swapaxes(1, 2)
    covariance[-1] *= 4
    words = precision(replace(good, covariance_points=covariance))
    assert "from 4 to 8 object units" in words
    assert "The least precise are 50" in words


@pytest.mark.parametrize("plane", ["XY", "XZ", "YZ"])
def test_points_are_drawn_in_the_plane_in_which_they_spread(good, plane):
    size = [100.0 if axis in plane else 10.0 for axis in "XYZ"]
    points = np.random.default_rng(3).normal(size=(50, 3)) * size
    words = precision(replace(good, points=points))
    assert f"in the {plane} plane" in words


def test_snooping_shows_sigma0_with_each_ray_that_it_took_out():
    network = real()
    found = bundle.snoop(network, most=2)
    assert len(found.removed) == 2
    first, second = found.removed
    assert first.sigma0 == bundle.adjust(network).sigma0
    again = bundle.adjust(network.without([first.ray]))
    assert second.sigma0 == pytest.approx(again.sigma0, rel=1e-9)


PAIRS = {
    "Within the camera: c with x0 (0.950)": [(0, 1)],
    "Between camera and photos: 2 pairs, led by": [(0, 10), (2, 17)],
    "Between photos: one pair, led by": [(12, 20)],
}


@pytest.mark.parametrize("shown", [[0], [1], [2], [0, 1], [1, 2], [0, 1, 2]])
def test_each_kind_of_correlation_is_told_and_no_other(good, shown):
    """Of parameters of the camera, of these and photos, and of photos alone."""
    covariance = good.covariance.copy()
    for k in shown:
        for i, j in list(PAIRS.values())[k]:
            covariance[i, j] = covariance[j, i] = 0.95e-30
    ((title, words),) = _findings.findings(replace(good, covariance=covariance))
    assert title == "Correlations above 0.9"
    for k, (head, pairs) in enumerate(PAIRS.items()):
        assert (head in words) == (k in shown)
        if k in shown:
            one, other = (good.names[i] for i in pairs[0])
            assert f"{one} with {other} (0.950)" in words
