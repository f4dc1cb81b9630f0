"""Proofs of the verdicts on Harintaka 2020, the two ways of plotting: done again on a
simulated pair whose ground is known, by correlation and by a simulated operator."""

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

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
    assert unedited > 2  # metres of crowns
    assert automatic < unedited / 4 and by_hand < 0.3


def test_which_way_is_better_depends_on_the_ground_and_on_the_filter(
    pair, normal, surfaces
):
    """In the open the computer; in the wood the operator, unless a filter does well."""
    found = [list(map(rms, zone)) for zone in errors(pair, normal, surfaces)]
    hand, automatic, _ = found[0]
    assert automatic < hand / 2
    hand, automatic, unedited = found[2]
    assert unedited > 8 * hand and automatic < 1.5 * hand


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
        assert difference[0] == approx(difference[1], rel=0.03)


def test_matching_at_the_finest_level_alone_works_where_the_search_is_wide():
    pair = simulate.aerial_pair((240, 160))
    land, found = pair.landscape, {}
    normal = stereo.epipolar_pair(
        pair.left, pair.right, (land.dsm.min(), land.dsm.max())
    )
    for name, how in {
        "pyramid": {"levels": 6},
        "wide": {"levels": 1, "search": 45},
        "narrow": {"levels": 1, "search": 12},
    }.items():
        match = stereo.match_dense(normal, **how)
        xyz = stereo.intersect(normal, match).xyz
        off = xyz[:, 2] - land.at(land.dsm, xyz[:, 0], xyz[:, 1])
        found[name] = np.mean(match.status == 0), np.mean(np.abs(off) > 2)
    shares, wrong = zip(*found.values())
    assert shares[1] > 0.7 * shares[0] and shares[2] < 0.7 * shares[0]
    assert max(wrong[:2]) < 0.01
    # Places tried a pixel: 91 against 25 on the coarsest of three levels, then 7 and 7
    coarse_to_fine = 25 / 16 + 7 / 4 + 7
    assert 91 / coarse_to_fine == approx(8.8, abs=0.05)


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

    # With running sums a window of any size has four terms, and only the search costs
    total = np.pad(image, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    for n in (3, 7, 15):
        windows = np.lib.stride_tricks.sliding_window_view(image, (n, n))
        fast = total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n]
        close(fast, windows.sum(axis=(2, 3)), atol=1e-9)
