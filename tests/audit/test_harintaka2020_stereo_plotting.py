"""Proofs of the verdicts on Harintaka 2020, both methods of plotting: done again on a
simulated pair whose ground is known, by correlation and by a simulated operator."""

import functools

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from pytest import approx

from pgm_lab import simulate, stereo

WORTH = 0.583  # m of height for a pixel of parallax
CELL = 0.5  # m

pair = functools.cache(lambda: simulate.aerial_pair((480, 240)))


def land():
    return pair().landscape


@pytest.fixture(scope="module")
def normal():
    span = land().dsm.min(), land().dsm.max()
    return stereo.epipolar_pair(pair().left, pair().right, span)


@pytest.fixture(scope="module")
def points(normal):
    return stereo.intersect(normal, stereo.match_dense(normal, method="ncc")).xyz


def operator(every=8.0, setting=0.5, seed=8):
    """One place of bare ground in every square of 8 m, the mark set to half a pixel."""
    rng, ground = np.random.default_rng(seed), pair().ground[0].reshape(-1, 3)
    above = ground[:, 2] - land().at(land().dtm, ground[:, 0], ground[:, 1])
    bare = rng.permutation(ground[(above < 0.1) & ~pair().hidden[0].ravel()])
    _, first = np.unique(bare[:, :2] // every, axis=0, return_index=True)
    up = np.outer(rng.normal(0, setting * WORTH, len(first)), (0, 0, 1))
    return bare[first] + up


@pytest.fixture(scope="module")
def errors(normal, points):
    """Errors of height in each zone, with a base too long by (m): of the operator, of
    the computer, and the computer's before filtering."""
    box = (*points[:, :2].min(axis=0), *points[:, :2].max(axis=0))
    whole = {"extent": box, "largest_gap": np.inf}
    dsm = stereo.surface(points, CELL, **whole)
    by_hand = stereo.surface(operator(), CELL, **whole)
    surfaces = by_hand, stereo.filter_terrain(dsm), dsm
    known = np.all([np.isfinite(one.z) for one in surfaces], axis=0)
    rows, columns = np.nonzero(known)
    X, Y = dsm.corner[0] + dsm.cell * columns, dsm.corner[1] - dsm.cell * rows

    def of(longer=0.0):
        found, zone = [], land().zone(X)
        for one in surfaces:
            # A longer base enlarges the model about the left station
            model = np.stack([X, Y, one.z[known]], -1) - normal.stations[0]
            P = normal.stations[0] + model * (1 + longer / normal.base)
            found.append(P[:, 2] - land().at(land().dtm, P[:, 0], P[:, 1]))
        return [[e[zone == k] for e in found] for k in range(3)]

    return of


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def test_correlation_gives_the_surface_and_not_the_ground(points):
    at = points[:, 0], points[:, 1]
    top, ground = land().at(land().dsm, *at), land().at(land().dtm, *at)
    tall = top - ground > 4
    assert tall.sum() > 1000 and (~tall).sum() > 1000
    off_top = np.abs(points[tall, 2] - top[tall])
    off_ground = np.abs(points[tall, 2] - ground[tall])
    assert np.mean(off_top < off_ground) > 0.95
    assert np.median(off_top) < 0.7 and np.median(off_ground) > 4
    # It takes both, for their grey values. An operator who is told to take bare ground
    # takes nothing else
    chosen = operator(setting=0.0)
    at = chosen[:, 0], chosen[:, 1]
    assert np.abs(chosen[:, 2] - land().at(land().dtm, *at)).max() < 0.1


def test_an_operator_sets_the_parallax_and_matching_computes_it(normal):
    match = stereo.match_dense(normal, method="ncc")
    rows, columns = np.nonzero(match.status == 0)
    d = match.disparity[rows, columns]
    found, moved = (normal.object_points(columns, rows, d + by) for by in (0, 1))
    assert np.median(moved[:, 2] - found[:, 2]) == approx(WORTH, abs=0.03)
    # Computed: on open ground the disparity with which both rays meet the truth
    bare = land().at(land().kind, found[:, 0], found[:, 1], 0) == 0
    off = found[bare, 2] - land().at(land().dsm, found[bare, 0], found[bare, 1])
    assert np.median(np.abs(off)) < 0.1 * WORTH


def test_a_window_of_even_size_gives_the_disparity_half_a_pixel_away():
    """A right image in which the disparity grows by a tenth from column to column, and
    is zero at the column that is meant; windows begin half their size before it."""
    rng = np.random.default_rng(11)
    tried = np.arange(-0.2, 0.2, 0.01)
    for size, expected in {3: 0, 5: 0, 7: 0, 4: -0.05, 6: -0.05}.items():
        window, found = np.arange(size) - size // 2, []
        for _ in range(200):
            pace, phase = rng.uniform((0.2, 0), (0.8, 6.3), (size, 5, 2)).T[..., None]
            at = np.concatenate([window[None], (window - tried[:, None]) / 0.9])
            grey = np.cos(pace[..., None] * at + phase[..., None]).sum(axis=0)
            grey = np.moveaxis(grey, 1, 0).reshape(len(at), -1)
            found.append(tried[np.corrcoef(grey)[0, 1:].argmax()])
        assert np.mean(found) == approx(expected, abs=0.01)


def test_which_method_is_better_depends_on_the_ground_and_on_the_filter(errors):
    """In the open the computer; in the wood the operator, unless a filter does well."""
    (hand, automatic, _), _, wood = [list(map(rms, zone)) for zone in errors()]
    assert automatic < hand / 2
    hand, automatic, unedited = wood
    assert hand < 0.3 and unedited > 2  # metres of crowns
    assert unedited > 8 * hand and automatic < 1.5 * hand
    assert automatic < unedited / 4


def test_a_common_error_makes_six_numbers_alike_and_leaves_the_differences(errors):
    alone, common = errors(0.0), errors(0.55)
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
        match = stereo.match_dense(normal, method="ncc", **how)
        xyz = stereo.intersect(normal, match).xyz
        off = xyz[:, 2] - land.at(land.dsm, xyz[:, 0], xyz[:, 1])
        found[name] = np.mean(match.status == 0), np.mean(np.abs(off) > 2)
    shares, wrong = zip(*found.values())
    assert shares[1] > 0.7 * shares[0] and shares[2] < 0.7 * shares[0]
    assert max(wrong[:2]) < 0.01
    # Positions tried for a pixel: of three levels 25 on the coarsest, then 7 and 7
    tried = (2 * np.array([45, 12, 3, 3]) + 1) / (1, 16, 4, 1)
    assert tried[0] / tried[1:].sum() == approx(8.8, abs=0.05)


def multiplications(image, window, search, lines):
    """Those of a correlation by definition at a place, counted one by one."""
    counted, half, places = 0, window // 2, 0
    rows, columns = image.shape
    for r in range(half + lines, rows - half - lines):
        for c in range(half + search, columns - half - search):
            places += 1
            for dr, dc in np.ndindex(2 * lines + 1, 2 * search + 1):
                row, column = r + dr - lines - half, c + dc - search - half
                counted += image[row : row + window, column : column + window].size
    return counted / places


def test_operations_grow_with_the_places_searched_and_with_the_window():
    image = np.random.default_rng(1).normal(size=(30, 60))
    # Twice the search along a line: twice the places. Along rows and columns, as the
    # method describes it: the square of the places
    for window, search, lines, count in (
        (3, 2, 0, 5 * 9),
        (3, 5, 0, 11 * 9),
        (7, 2, 0, 5 * 49),
        (3, 2, 2, 25 * 9),
    ):
        assert multiplications(image, window, search, lines) == count
    # With running sums a window of any size has four terms, and only the search costs
    total = np.pad(image, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    for n in (3, 7, 15):
        windows = np.lib.stride_tricks.sliding_window_view(image, (n, n))
        fast = total[n:, n:] - total[:-n, n:] - total[n:, :-n] + total[:-n, :-n]
        close(fast, windows.sum(axis=(2, 3)), atol=1e-9)
