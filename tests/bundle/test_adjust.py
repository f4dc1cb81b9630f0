"""The bundle adjustment: equal to the dense core, to another start, in any datum."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose as close
from numpy.testing import assert_array_equal as equal
from pytest import approx

from pgm_lab import bundle, rotation, simulate
from pgm_lab.camera import PARAMETERS, Camera
from tests.networks import G, dense, moved, real, small

SOME = ("c", "x0", "y0", "K1")


def assert_equal_to_dense(network, found, core, values, kept, of_sd=1e-9):
    """Values to 1e-9 of their standard deviations, covariances to 1e-9 relative."""
    interior, exteriors, points = values
    u = len(found.interior_names)
    columns = [PARAMETERS.index(name) for name in found.estimate]
    sd = np.concatenate([found.sd_interior, found.sd_exteriors.ravel()])
    ours = np.concatenate([found.interior, found.exteriors.ravel()])
    theirs = np.concatenate([interior[:, columns].ravel(), exteriors.ravel()])
    assert np.abs((ours - theirs) / sd).max() < of_sd
    free = found.sd_points > 0
    assert np.abs((found.points - points)[free] / found.sd_points[free]).max() < of_sd

    k = found.residuals.size
    size = u + exteriors.size
    close(found.sigma0, core.sigma0, rtol=1e-9)
    assert found.redundancy == core.redundancy
    relative = np.outer(sd, sd)
    difference = found.covariance - core.covariance[:size, :size]
    assert np.abs(difference / relative).max() < 1e-9
    whole = np.zeros((len(kept), len(kept)))
    whole[np.ix_(kept, kept)] = core.covariance
    n = len(points)
    blocks = whole[size:, size:].reshape(n, 3, n, 3)[range(n), :, range(n)]
    scale = np.trace(found.covariance_points, axis1=1, axis2=2)[:, None, None]
    difference = found.covariance_points - blocks
    assert np.abs(difference / np.where(scale > 0, scale, 1)).max() < 1e-9
    for name in ("residuals", "redundancy_numbers", "standardized"):
        ours, theirs = getattr(found, name).ravel(), getattr(core, name)[:k]
        close(ours, theirs, rtol=0, atol=1e-9 * np.ptp(theirs))


def adjust(*args):
    """Iterate until only rounding changes: two iterations stop at the same place."""
    return bundle.adjust(*args, tolerance=1e-9)


def inner(datum_points=slice(None), motions=7):
    def rows(exteriors, points):
        chosen = np.zeros((motions, *points.shape))
        chosen[:, datum_points] = G(points)[:motions, datum_points]
        return np.zeros((motions, *exteriors.shape)), chosen

    return rows


def on_photos(motions=7):
    def rows(exteriors, points):
        of_exteriors = np.zeros((motions, *exteriors.shape))
        of_exteriors[..., :3] = G(exteriors[:, :3])[:motions]
        return of_exteriors, np.zeros((motions, *points.shape))

    return rows


def bars(network, sigma, *ends):
    truth = small(sigma=1e-9).points
    rows = [(a, b, np.linalg.norm(truth[a] - truth[b]) + 0.3, sigma) for a, b in ends]
    return replace(network, scale_bars=rows)


ENDS = (0, 5), (5, 9), (2, 3)
# network, estimate, datum, inner constraints of the dense core
CASES = {
    "backward lens": (small(), SOME, None, inner()),
    "forward lens, all ten": (
        small("forward", photos=8, points=20), PARAMETERS, None, inner(),
    ),
    "rays missing": (small(skip=20), SOME, None, inner()),
    "two cameras": (small("forward", cameras=2, skip=7), SOME, None, inner()),
    "three cameras": (small(photos=9, cameras=3, skip=5), SOME, None, inner()),
    "no interior": (small(), (), None, inner()),
    "datum points": (
        replace(small(), datum_points=[1, 4, 5, 9]), SOME, None, inner([1, 4, 5, 9]),
    ),
    "photos": (small(cameras=2), SOME, "photos", on_photos()),
    "a bar": (bars(small(), 0.2, (0, 5)), SOME, None, inner(motions=6)),
    "bars": (bars(small(cameras=2), 0.2, *ENDS), SOME, None, inner(motions=6)),
    "bars, photos": (bars(small(), 0.2, *ENDS), SOME, "photos", on_photos(6)),
    "fixed": (replace(small(), fixed=[0, 4, 7]), SOME, None, None),
    "bars, fixed": (
        replace(bars(small(), 0.05, (0, 5), (2, 3)), fixed=[0, 4, 7]), SOME, None, None,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_every_datum_equals_the_dense_core_to_1e_9(case):
    network, estimate, datum, constraint = CASES[case]
    found = adjust(network, estimate, datum)
    free = None if constraint else ~network.held
    core = dense(network, estimate, constraint, free=free)
    assert found.status == "converged"
    assert_equal_to_dense(network, found, *core)
    for name in ("residuals", "redundancy_numbers", "standardized"):
        ours = getattr(found, f"scale_bar_{name}")
        theirs = getattr(core[0], name)[network.xy.size :]
        close(ours, theirs, atol=1e-8)
    held = network.held
    assert np.all(found.sd_points[held] == 0)
    equal(found.points[held], network.points[held])


def test_weighted_control_equals_the_dense_core_with_weighted_parameters():
    network = small()
    sigma = np.array([[5, 5, np.inf], [1, 20, 3], [9, 9, 9], [np.inf, 9, 4]]) / 100
    index = np.array([2, 5, 8, 11])
    given_points = network.points[index] + 0.4
    network = replace(network, control=(index, given_points, sigma))
    found = adjust(network, SOME)
    u, m = 4, len(network.exteriors)
    weights = np.zeros(u + 6 * m + network.points.size)
    at = np.zeros(weights.shape)
    place = u + 6 * m + 3 * index[:, None] + np.arange(3)
    weights[place], at[place] = sigma**-2.0, given_points
    core, values, kept = dense(
        network, SOME, parameter_weights=weights, parameter_values=at
    )
    assert_equal_to_dense(network, found, core, values, kept)
    v = core.parameter_residuals[place]
    measured = np.isfinite(sigma)
    close(found.control_residuals[measured], v[measured], atol=1e-9)


def test_the_shares_of_rays_control_and_scale_bars_add_up_to_the_redundancy():
    network = small()
    index, sigma = [0, 3, 6], np.full((3, 3), 0.2)
    sigma[0, 2] = np.inf
    network = replace(network, control=(index, network.points[index], sigma))
    network = bars(network, 0.05, (1, 4), (2, 8))
    found = bundle.adjust(network, SOME)
    of_control = found.control_redundancy_numbers
    assert np.all((of_control > 0) == np.isfinite(sigma))
    shares = found.redundancy_numbers, of_control, found.scale_bar_redundancy_numbers
    assert sum(map(np.sum, shares)) == approx(found.redundancy)


def test_control_with_sigma_0_holds_single_coordinates():
    network = small()
    sigma = [[0, 0, 0], [0, np.inf, 0], [np.inf, np.inf, 0], [np.inf, 0, np.inf]]
    index = [0, 3, 6, 9]
    coordinates = network.points[index] + 1.0
    network = replace(network, control=(index, coordinates, sigma))
    found = adjust(network, SOME)
    held = np.equal(sigma, 0)
    equal(found.points[index][held], coordinates[held])
    start = replace(network, points=np.where(network.held, 0, network.points))
    start.points[index] = np.where(held, coordinates, network.points[index])
    core = dense(start, SOME, free=~network.held)
    assert_equal_to_dense(network, found, *core)


def test_sigma0_camera_and_residuals_are_the_same_in_every_datum():
    network = real()
    some = np.array([3, 17, 40])
    coordinates = network.points[some]
    minimal = [[0, 0, 0], [0, 0, 0], [0, np.inf, np.inf]]
    weighted = [[0.1] * 3, [0.2] * 3, [0.1, np.inf, np.inf]]
    distance = np.linalg.norm(coordinates[0] - coordinates[1])
    datums = [
        (replace(network, datum_points=range(0, 50, 5)), "inner"),
        (network, "photos"),
        (replace(network, scale_bars=[(3, 17, distance, 0.1)]), "inner"),
        (replace(network, control=(some, coordinates, minimal)), "fixed"),
        (replace(network, control=(some, coordinates, weighted)), "fixed"),
    ]
    reference = bundle.adjust(network)
    for other, datum in datums:
        found = bundle.adjust(other, datum=datum)
        assert found.redundancy == reference.redundancy == 693
        close(found.sigma0, reference.sigma0, rtol=1e-9)
        difference = (found.interior - reference.interior) / reference.sd_interior
        assert np.abs(difference).max() < 1e-7
        ratio = found.covariance_interior / reference.covariance_interior
        close(ratio, 1, atol=1e-7)
        for name in ("residuals", "redundancy_numbers", "standardized"):
            close(getattr(found, name), getattr(reference, name), atol=1e-7)
        total = np.trace(found.covariance_points, axis1=1, axis2=2).sum()
        least = np.trace(reference.covariance_points, axis1=1, axis2=2).sum()
        # inner constraints on all points leave the least sum of variances
        assert total > least * 1.01


@pytest.mark.parametrize("lens", ["backward", "forward"])
def test_other_start_values_lead_to_the_same_solution_to_1e_8(lens):
    network = real()
    camera = Camera(network.cameras[0].c, lens=lens)
    reference = bundle.adjust(replace(network, cameras=camera))
    rng = np.random.default_rng(5)
    for c in (20.0, 60.0):
        off = rng.normal(size=network.exteriors.shape) * [60, 60, 60, 0.05, 0.05, 0.05]
        start = replace(
            network,
            cameras=Camera(c, lens=lens),
            exteriors=network.exteriors + off,
            points=network.points + 10 * rng.normal(size=network.points.shape),
        )
        found = bundle.adjust(start)
        assert found.status == "converged"
        assert abs(found.sigma0 / reference.sigma0 - 1) < 1e-8
        close(found.interior, reference.interior, atol=1e-8)
        close(found.residuals, reference.residuals, atol=1e-8)


@settings(max_examples=10)
@given(
    st.tuples(*[st.floats(-0.7, 0.7)] * 3),
    st.floats(0.1, 50),
    st.tuples(*[st.floats(-1e4, 1e4)] * 3),
)
def test_another_object_frame_changes_neither_sigma0_nor_camera(angles, scale, shift):
    network = small()
    there = moved(network, scale, rotation.matrix(*angles), np.array(shift))
    found, reference = bundle.adjust(there, SOME), bundle.adjust(network, SOME)
    close(found.sigma0, reference.sigma0, rtol=1e-8)
    close(found.interior, reference.interior, atol=1e-8)
    close(found.residuals, reference.residuals, atol=1e-9)
    size = np.sqrt(np.trace(reference.covariance_points, axis1=1, axis2=2))
    there = np.sqrt(np.trace(found.covariance_points, axis1=1, axis2=2))
    close(there, scale * size, rtol=1e-6)


@pytest.mark.parametrize("lens", ["backward", "forward"])
def test_without_errors_the_truth_comes_back(lens):
    network = small(lens, photos=8, points=20, sigma=1e-12)
    found = bundle.adjust(replace(network, sigma=0.001))
    truth = {"c": 30.0, "x0": 0.1, "y0": -0.2, "K1": 3e-5, "P2": -2e-5, "b1": 2e-4}
    assert found.status == "converged"
    assert found.sigma0 < 1e-8
    for name, value in truth.items():
        assert getattr(found.cameras[0], name) == approx(value, abs=1e-9)


def test_check_points_are_compared_and_change_nothing():
    network = replace(small(), fixed=[0, 4, 7])
    known = network.points[[1, 2]]
    checked = bundle.adjust(replace(network, check=([1, 2], known)), SOME)
    found = bundle.adjust(network, SOME)
    equal(checked.points, found.points)
    close(checked.check_differences, found.points[[1, 2]] - known)


KNOWN = small().points[[0, 3, 6]]
HELD = [[0, 0, 0], [0, 0.1, 0], [0, 0.1, np.inf]]
PATHS = {name: case[:3] for name, case in CASES.items() if name != "a bar"} | {
    "real": (real(), PARAMETERS, None),
    "weighted": (replace(small(), control=([0, 3, 6], KNOWN + 0.4, 0.1)), SOME, None),
    "held": (replace(small(), control=([0, 3, 6], KNOWN, HELD)), SOME, None),
}


@pytest.mark.parametrize("name", PATHS)
def test_a_whole_matrix_and_blocks_of_the_rays_give_the_same(name, monkeypatch):
    network, estimate, datum = PATHS[name]
    whole = bundle.adjust(network, estimate, datum)
    monkeypatch.setattr("pgm_lab.bundle.reduced.WHOLE", 0)
    by_rays = bundle.adjust(network, estimate, datum)
    # what no datum touches, to 1e-11 of the largest
    for what in (
        *("sigma0", "residuals", "redundancy_numbers", "standardized"),
        *("control_residuals", "scale_bar_residuals", "scale_bar_standardized"),
    ):
        ours, theirs = getattr(whole, what), getattr(by_rays, what)
        size = np.max(np.abs(ours), initial=0)
        atol = 5e-11 if what == "standardized" else 1e-11
        close(theirs, ours, rtol=0, atol=atol * size, err_msg=what)
    # unknowns and covariances to 2e-10 of their standard deviations: the scaled normal
    # matrix has eigenvalues down to 2e-6, which make more of its rounding
    sd = np.sqrt(np.diagonal(whole.covariance))
    there, here = (np.append(one.interior, one.exteriors) for one in (by_rays, whole))
    variance = np.trace(whole.covariance_points, axis1=1, axis2=2)[:, None, None]
    variance = np.where(variance > 0, variance, 1)
    for difference in (
        (there - here) / sd,
        (by_rays.covariance - whole.covariance) / np.outer(sd, sd),
        (by_rays.covariance_points - whole.covariance_points) / variance,
        (by_rays.points - whole.points) / np.sqrt(variance[..., 0]),
    ):
        assert np.abs(difference).max() < 2e-10


def test_history_says_what_happened_and_full_steps_can_be_asked_for():
    network = small()
    found = bundle.adjust(network, SOME)
    assert len(found.history.objective) == found.iterations + 1
    assert np.all(np.diff(found.history.objective) < 1e-9)
    assert found.history.change[-1] <= 1e-6
    full = bundle.adjust(network, SOME, line_search=False)
    assert np.all(full.history.step == 1)
    close(full.interior, found.interior, atol=1e-9)
    few = bundle.adjust(network, SOME, max_iterations=1)
    assert few.status == "too many iterations"


def test_the_line_search_shortens_a_step_that_would_make_it_worse():
    network, rng = small(), np.random.default_rng(14)
    found = bundle.adjust(network, SOME)
    far = [simulate.rough(one, rng, 35, 0.3) for one in found.exteriors]
    network = replace(network, exteriors=far)
    searched, full = (
        bundle.adjust(network, SOME, line_search=wanted) for wanted in (True, False)
    )
    assert searched.history.step.min() < 1
    assert np.all(np.diff(searched.history.objective) < 1e-9)
    assert np.diff(full.history.objective).max() > 0
    close(searched.interior, found.interior, atol=1e-6)


def test_unknowns_are_told_by_owner_and_parameter_in_the_order_of_the_covariance():
    found = bundle.adjust(small(cameras=2), ("c", "K1"))
    cameras = [("camera", i, name) for i in (1, 2) for name in ("c", "K1")]
    assert found.unknowns[:4] == tuple(cameras)
    assert len(found.unknowns) == len(found.covariance) == 4 + 6 * 6
    i = found.unknowns.index(bundle.Unknown("photo", 3, "phi"))
    assert found.names[i] == "phi of photo 3" and found.names[2] == "c of camera 2"
    assert found.covariance[i, i] == np.diagonal(found.covariance_exteriors[2])[4]
    # The name of an only camera goes without saying
    found = bundle.adjust(small(), ("c", "K1"))
    assert found.interior_names == ("c", "K1") and found.names[2] == "X0 of photo 1"
    assert bundle.adjust(small(), ()).names[0] == "X0 of photo 1"
