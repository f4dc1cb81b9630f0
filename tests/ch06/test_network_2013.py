"""What the network of 2013 says of itself: the figures that chapter 6 is cited for.

Nine photos of fifty points (Muliawan 2013, Tables 4.1 to 4.12). No other program stands
behind these figures: they repeat what was found once, and each would change if the
adjustment, its covariance, its tests or the eleven defects did.
"""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_book.ch06 import defects, published
from pgm_book.common import results
from pgm_lab import bundle, datasets, orientation, rotation
from pgm_lab.camera import PARAMETERS, project
from tests.networks import real

FREE = np.inf  # 0 holds a coordinate of a control point, inf leaves it free


@pytest.fixture(scope="module")
def data():
    return datasets.muliawan2013()


@pytest.fixture(scope="module")
def network():
    return real()


@pytest.fixture(scope="module")
def found(network):
    return bundle.adjust(network)


def without(network, *left_out):
    """The adjustment with all parameters of the camera but these."""
    return bundle.adjust(network, [p for p in PARAMETERS if p not in left_out])


def rms(v):
    return np.sqrt(np.mean(np.square(v)))


# --- the camera


def test_terms_of_the_lens_cancel_and_the_curve_is_known_better_than_each(found):
    powers = 10.0 ** np.array([3, 5, 7])  # at 10 mm
    terms = 1000 * powers * np.array([found.interior[3:6], found.sd_interior[3:6]])
    close(terms, [(20.1, -33.0, 21.4), (3.3, 6.3, 4.0)], atol=0.05)
    curve, sd = bundle.lens.profile(found, [10.0])
    assert 1000 * curve[0] == approx(8.5, abs=0.05)
    assert 1000 * sd[0] == approx(1.1, abs=0.05)


def test_what_each_parameter_is_worth(network, found):
    """sigma0, and how far the points move in units of their sd, without it."""

    def move(one):
        return rms(one.points - found.points) / rms(found.sd_points)

    no_c, no_lens = without(network, "c"), without(network, *PARAMETERS[3:])
    no_p, no_b = without(network, "P1", "P2"), without(network, "b1", "b2")
    assert no_c.sigma0 == approx(0.519, abs=1e-3) and move(no_c) > 9
    assert no_lens.sigma0 == approx(0.400, abs=1e-3)
    assert no_p.sigma0 - found.sigma0 < 0.003 and move(no_p) < 0.2
    assert 0.8 < move(no_b) < 1.1


# --- the datum


def test_the_datum_decides_the_sd_of_points(data, network, found):
    held = [(0, 0, 0), (0, 0, 0), (FREE, 0, FREE)]
    control = [0, 9, 40], data.object_points[[0, 9, 40]], np.array(held)
    stations = bundle.adjust(network, datum="photos")
    seven = bundle.adjust(replace(network, control=control))
    sd = [1000 * rms(one.sd_points) for one in (found, stations, seven)]  # um
    close(sd, (10, 317, 20), rtol=0.06)


def test_adjusted_points_are_nearer_to_table_4_3_than_chance_allows(data, found):
    """Table 4.3 is a result of nearly these photos, not an independent measurement."""
    fit = orientation.absolute(found.points, data.object_points)
    apart = data.object_points - fit.apply(found.points)
    assert 1000 * rms(apart) == approx(3.34, abs=0.01)
    assert 1000 * rms(found.sd_points) == approx(10.0, abs=0.1)


# --- the residuals


def test_residuals_of_neighbours_are_alike_as_independent_errors_never_are(
    data, network, found
):
    nearest = np.empty(450, dtype=int)
    for i in range(9):  # the nearest point in each photo
        same = np.flatnonzero(data.photo == i)
        apart = np.linalg.norm(data.xy[same, None] - data.xy[same], axis=2)
        np.fill_diagonal(apart, np.inf)
        nearest[same] = same[apart.argmin(axis=1)]

    def alike(v):
        return np.sum(v * v[nearest]) / np.sum(v**2)

    rng, simulated = np.random.default_rng(450), []
    for _ in range(30):
        errors = rng.normal(0, found.sigma0 * data.sigma)
        again = replace(network, xy=data.xy + found.residuals + errors)
        simulated.append(alike(bundle.adjust(again).residuals))
    assert alike(found.residuals) == approx(0.205, abs=1e-3)
    # One run has an sd of 0.05; residuals of independent errors repel a little
    assert max(simulated) < 0.12 and np.mean(simulated) == approx(-0.08, abs=0.04)


def test_reliability_of_the_photos(found):
    """Smallest blunder found (um), best and worst; its largest influence (sd)."""
    trust = bundle.reliability(found)
    internal = 1000 * trust.internal.min(), 1000 * trust.internal.max()
    close([*internal, trust.external.max()], (1.524, 2.379, 5.422), rtol=1e-3)


def test_snooping_moves_k3_by_three_sd_and_the_curve_by_less_than_its_own(network):
    snooped = bundle.snoop(network)
    before, after = snooped.before, snooped.result
    moves = (after.interior - before.interior) / before.sd_interior
    assert moves[5] == approx(-2.8, abs=0.05)
    assert moves[0] == approx(-0.43, abs=0.02)
    r = np.linspace(0, 10, 201)
    (curve, _), (cleaned, sd) = (bundle.lens.profile(b, r) for b in (before, after))
    assert 1000 * np.abs(cleaned - curve).max() < 1.0
    assert np.all(np.abs(cleaned - curve) <= 1.96 * sd)


# --- the choice of photos


@pytest.fixture(scope="module")
def precision(found):
    """First three standard deviations (c, x0, y0) in um, with sigma0 of the photos."""

    def of(exteriors, points, estimate=PARAMETERS):
        m, n = len(exteriors), len(points)
        photo, point = np.repeat(np.arange(m), n), np.tile(np.arange(n), m)
        camera = found.cameras[0]
        xy = project(camera, exteriors[photo], points[point])
        net = bundle.Network(camera, exteriors, points, photo, point, xy)
        one = bundle.adjust(net, estimate)
        return 1000 * one.sd_interior[:3] * found.sigma0 / one.sigma0

    return of


def test_two_places_leave_c_to_the_relief_or_to_a_third_place(found, precision):
    P, taken = found.points, found.exteriors
    middle = P.mean(axis=0)
    across, _, normal = np.linalg.svd(P - middle)[2]
    relief = 50 * np.sin((P - middle) @ across / 60)[:, None] * normal
    assert precision(taken[[0, 1, 7, 8]], P)[0] == approx(996, abs=10)
    deep = precision(taken[[0, 1, 7, 8]], P + relief)[0]
    six = precision(taken[[0, 1, 2, 3, 7, 8]], P)[0]
    close((deep, six), (102, 21.3), rtol=0.02)
    view = -np.array([rotation.matrix(*a[3:])[2] for a in taken[[1, 7]]])
    assert np.degrees(np.arccos(view[0] @ view[1])) == approx(56.4, abs=0.2)


def test_parallel_axes_determine_the_principal_point_once_c_is_held(found, precision):
    P, taken = found.points, found.exteriors
    middle = P.mean(axis=0)
    across, _, normal = np.linalg.svd(P - middle)[2]
    normal = normal * np.sign(normal @ (middle - taken[2, :3]))
    axes = np.array([across, np.cross(-normal, across), -normal])
    grid = np.stack(np.meshgrid([-300, 0, 300], [-300, 0, 300]), -1).reshape(-1, 2)
    stations = middle - 1450 * normal + grid @ axes[:2]
    turns = np.array([0, 1, 2, 3, 0, 1, 2, 3, 0]) * np.pi / 2
    parallel = np.array(
        [
            np.append(X, rotation.angles(rotation.matrix(0, 0, turn) @ axes))
            for X, turn in zip(stations, turns)
        ]
    )
    with pytest.raises(bundle.NetworkDefect, match="c"):
        precision(parallel, P)
    x0, y0 = precision(parallel, P, [name for name in PARAMETERS if name != "c"])[:2]
    close((x0, y0), (2.74, 3.74), rtol=0.02)


# --- control that is wrong


def test_sigma0_notices_a_wrong_control_point_late_or_never(data, network, found):
    """Seven coordinates held: sigma0 stays. Four points held: beyond 1 um at 0.7 mm."""
    P, corners = found.points, np.array([0, 9, 30, 39])
    others = np.setdiff1d(np.arange(50), corners)
    truth = project(found.cameras[0], found.exteriors[data.photo], P[data.point])
    xy = truth + np.random.default_rng(3).normal(0, found.sigma0 * 0.001, truth.shape)
    real = {"cameras": found.cameras, "exteriors": found.exteriors, "points": P}
    seven = np.full((4, 3), FREE)
    seven[:2], seven[2, 1] = 0, 0

    def adjusted(sigma, wrong):
        given = P[corners] + np.outer(np.arange(4) == 0, (wrong, 0, 0))
        one = bundle.adjust(
            replace(network, **real, xy=xy, control=(corners, given, sigma))
        )
        error = rms((one.points - P)[others])
        return one.sigma0, rms(one.sd_points[others]), error, one.residuals

    good, bad = adjusted(seven, 0), adjusted(seven, 1.0)
    assert bad[0] == approx(good[0], abs=1e-6)
    close(bad[3], good[3], rtol=0, atol=1e-7)
    assert bad[2] > 10 * bad[1]
    four = [adjusted(0.0, wrong) for wrong in (0, 0.5, 1.0)]
    assert four[0][0] < 0.4 and 0.6 < four[1][0] < 0.85 and 1.3 < four[2][0] < 1.6
    assert all(error > 5 * sd for _, sd, error, _ in four[1:])


def test_what_the_table_of_control_is_cited_for():
    """Error of one control point 1 mm, sigma of the images given as 0.35 um."""
    rows = results.rows("ch06", "control")
    of = {r["control"]: r for r in rows if float(r["error_mm"]) == 1}
    fixed, seven = of["four points fixed"], of["seven coordinates fixed"]
    assert float(fixed["sigma0"]) > 2.5 and float(fixed["largest_w"]) > 15
    assert float(seven["largest_w"]) < 4
    free = of["free, then transformed"]
    ratio = float(free["points_error_mm"]) / float(free["points_sd_mm"])
    assert abs(ratio - 1) < 0.2


# --- the order of the file of 2013


def test_the_published_angles_follow_from_the_first_fifty_lines(data):
    """Eleven defects reproduce them in the order by point; what comes after line 50 may
    stand in any order, and other orders are 6 to 210 mrad off.
    """
    *began, photo, point, xy = defects.network("point")
    rng = np.random.default_rng(1)

    def off(lines):
        run = defects.adjust(
            *began, photo[lines], point[lines], xy[lines], defects.PROGRAM
        )
        return 1000 * np.abs(run.exteriors[-1] - data.published_exteriors)[:, 3:].max()

    assert np.array_equal(photo[:9], range(9)) and np.all(point[:9] == 0)
    assert len(set(point[:50])) == 6
    as_it_was, tail = np.arange(450), np.r_[:50, 50 + rng.permutation(400)]
    assert off(as_it_was) < 0.01 and off(tail) < 0.01  # half of a printed digit
    others = np.lexsort((-photo, point)), np.lexsort((point, photo))
    for lines in (*others, rng.permutation(450)):
        assert 5.5 < off(lines) < 210


def test_which_defects_make_the_accuracies_a_thousand_times_too_small(data):
    """Median of 150 coordinates: 1000 from the residuals left unweighted, less 40 by
    which the fit is worse; Table 4.18 is then read ten places too early.
    """
    by_point = defects.network("point")
    program = defects.adjust(*by_point, defects.PROGRAM)
    pinv = defects.adjust(*defects.network(), ("pinv",))
    worse = 1000 * program.sigma0 / pinv.sigma0
    assert 1000 * program.sigma0 == approx(374, abs=1)
    assert worse == approx(40, abs=0.5)
    assert np.median(program.sd_points) == approx(6.2e-8 / 1000 * worse, rel=0.05)
    assert 2e-9 < np.median(data.published_object_points_sd) < 3e-9


# --- the network of the tables


def test_the_published_network_is_that_of_the_tables(data):
    whole, some = published.network(), published.network([7, 1, 4, 4])
    equal(whole.xy, data.xy)
    equal(whole.sigma, data.sigma)
    assert some.photo_names == (1, 4, 7)
    equal(some.exteriors, data.exteriors[[0, 3, 6]])
    equal(some.xy, data.xy[np.isin(data.photo, [0, 3, 6])])


@pytest.mark.parametrize("photos", [[0, 1, 2], [1, 2, 10]])
def test_a_photo_that_does_not_exist_is_refused(photos):
    with pytest.raises(ValueError, match="photos must be numbers from 1 to 9"):
        published.network(photos)
