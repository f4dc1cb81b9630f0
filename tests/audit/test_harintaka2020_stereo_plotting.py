"""Proofs of the verdicts on Harintaka 2020, the two ways of plotting: done again on a
simulated pair whose ground is known, by correlation and by a simulated operator."""

import numpy as np
import pytest

from pgm_lab import simulate, stereo

WORTH = 0.583  # m of height for a pixel of parallax
CELL = 0.5  # m
ZONES = ("open", "mixed", "wood")


@pytest.fixture(scope="module")
def pair():
    return simulate.aerial_pair((480, 240))


@pytest.fixture(scope="module")
def normal(pair):
    dsm = pair.landscape.dsm
    return stereo.epipolar_pair(pair.left, pair.right, (dsm.min(), dsm.max()))


@pytest.fixture(scope="module")
def points(normal):
    return stereo.intersect(normal, stereo.match_dense(normal)).xyz


@pytest.fixture(scope="module")
def surfaces(pair, points):
    """Of the operator, of the computer, and the computer's before filtering."""
    extent = (*points[:, :2].min(axis=0), *points[:, :2].max(axis=0))
    dsm = stereo.surface(points, CELL, extent=extent)
    by_hand = stereo.surface(operator(pair), CELL, extent=extent)
    return by_hand, stereo.filter_terrain(dsm), dsm


def operator(pair, every=8.0, setting=0.5, seed=8):
    """One place of bare ground in every square of 8 m, the mark set to half a pixel."""
    rng = np.random.default_rng(seed)
    land, ground = pair.landscape, pair.ground[0].reshape(-1, 3)
    above = ground[:, 2] - land.at(land.dtm, ground[:, 0], ground[:, 1])
    bare = rng.permutation(ground[(above < 0.1) & ~pair.hidden[0].ravel()])
    _, first = np.unique(bare[:, :2] // every, axis=0, return_index=True)
    up = np.outer(rng.normal(0, setting * WORTH, len(first)), (0, 0, 1))
    return bare[first] + up


def errors(pair, normal, surfaces, longer=0.0):
    """Errors of height of all surfaces in each zone, with a base too long by (m)."""
    land, first = pair.landscape, surfaces[2]
    known = np.all([np.isfinite(one.z) for one in surfaces], axis=0)
    rows, columns = np.nonzero(known)
    X = first.corner[0] + first.cell * columns
    Y = first.corner[1] - first.cell * rows
    found, zone = [], land.zone(X)
    for one in surfaces:
        # A longer base enlarges the model about the left station
        model = np.stack([X, Y, one.z[known]], -1) - normal.stations[0]
        P = normal.stations[0] + model * (1 + longer / normal.base)
        found.append(P[:, 2] - land.at(land.dtm, P[:, 0], P[:, 1]))
    return [[e[zone == k] for e in found] for k in range(3)]


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def test_correlation_gives_the_surface_and_not_the_ground(pair, points):
    land = pair.landscape
    at = points[:, 0], points[:, 1]
    top, ground = land.at(land.dsm, *at), land.at(land.dtm, *at)
    tall = top - ground > 4
    assert tall.sum() > 1000
    off_top = np.abs(points[tall, 2] - top[tall])
    off_ground = np.abs(points[tall, 2] - ground[tall])
    assert np.mean(off_top < off_ground) > 0.95
    assert np.median(off_top) < 0.7 and np.median(off_ground) > 4


def test_where_trees_stand_the_automatic_surface_needs_filtering(
    pair, normal, surfaces
):
    by_hand, automatic, unedited = map(rms, errors(pair, normal, surfaces)[2])
    assert unedited > 4 * automatic  # metres of crowns
    assert automatic > 1.4 * by_hand  # and filtering does not mend all of it


def test_in_open_ground_the_computer_is_better_and_in_the_wood_the_operator(
    pair, normal, surfaces
):
    found = errors(pair, normal, surfaces)
    factor = [rms(automatic) / rms(hand) for hand, automatic, _ in found]
    assert factor[0] < 0.8 and factor[2] > 1.4


def test_a_common_error_makes_six_numbers_alike_and_leaves_the_differences(
    pair, normal, surfaces
):
    alone, common = (errors(pair, normal, surfaces, b) for b in (0.0, 0.55))
    six = np.array([[rms(e) for e in zone[:2]] for zone in common])
    assert np.all(np.abs(six - 1.42) < 0.16)
    before = np.array([[rms(e) for e in zone[:2]] for zone in alone])
    assert before.max() / before.min() > 3
    for one, other in zip(alone, common):
        difference = [np.std(zone[1] - zone[0]) for zone in (one, other)]
        assert difference[0] == pytest.approx(difference[1], rel=0.03)


def test_matching_at_the_finest_level_alone_works_where_the_search_is_wide(
    pair, normal
):
    land, found = pair.landscape, {}
    for name, how in {
        "pyramid": {"levels": 6},
        "wide": {"levels": 1, "search": 60},
        "narrow": {"levels": 1, "search": 12},
    }.items():
        match = stereo.match_dense(normal, **how)
        xyz = stereo.intersect(normal, match).xyz
        off = xyz[:, 2] - land.at(land.dsm, xyz[:, 0], xyz[:, 1])
        found[name] = np.mean(match.status == 0), np.mean(np.abs(off) > 2)
    shares, wrong = zip(*found.values())
    assert shares[1] > 0.85 * shares[0] > shares[2] * 1.3
    assert wrong[1] > 1.5 * wrong[0]  # more places, more that look alike
    # Correlations a pixel: 121 against 25 on a coarse level and 7 on each finer one
    coarse_to_fine = sum(7 / 4**level for level in range(2)) + 25 / 4**2
    assert 121 / coarse_to_fine == pytest.approx(11.7, abs=0.1)


def multiplications(left, right, window, search, lines):
    """Those of a correlation by definition, counted one by one; lines to each side."""
    counted, half = 0, window // 2
    rows, columns = left.shape
    for r in range(half + lines, rows - half - lines):
        for c in range(half + search, columns - half - search):
            for dr in range(-lines, lines + 1):
                for dc in range(-search, search + 1):
                    target = left[r - half : r + half + 1, c - half : c + half + 1]
                    place = slice(c + dc - half, c + dc + half + 1)
                    other = right[r + dr - half : r + dr + half + 1, place]
                    counted += (target * other).size
    return counted


def test_operations_grow_with_the_places_searched_and_with_the_window():
    image = np.random.default_rng(1).normal(size=(30, 60))
    few = multiplications(image, image, 3, 2, 0)
    places = (30 - 2) * (60 - 2 - 4)
    assert few == places * 5 * 9
    # Twice the search along a line: twice the places, less what the borders take
    twice = multiplications(image, image, 3, 5, 0) / ((30 - 2) * (60 - 2 - 10))
    assert twice == 11 * 9
    wider = multiplications(image, image, 7, 2, 0) / ((30 - 6) * (60 - 6 - 4))
    assert wider == 5 * 49
    # Along rows and columns, as the method describes it: the square of the places
    square = multiplications(image, image, 3, 2, 2) / ((30 - 2 - 4) * (60 - 2 - 4))
    assert square == 25 * 9


def test_running_sums_make_the_window_free_and_the_search_not():
    """Sums over windows from sums over all that comes before: four terms a window."""
    image = np.random.default_rng(2).normal(size=(40, 50))
    total = np.pad(image, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    for n in (3, 7, 15):
        windows = np.lib.stride_tricks.sliding_window_view(image, (n, n))
        fast = total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n]
        np.testing.assert_allclose(fast, windows.sum(axis=(2, 3)), atol=1e-9)
