"""The adjustment core: one least squares, proven against others and by its own laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal as equal
from pytest import approx
from scipy.optimize import least_squares, minimize
from scipy.stats import chi2

from pgm_lab.adjustment import RankDefect, adjust

# Numbers that only rounding separates; design matrices here have condition below 1e3.
ROUNDING = {"rtol": 1e-9, "atol": 1e-11}
PARAMETERS = ("x", "cofactor", "sigma0", "redundancy")
OBSERVATIONS = ("residuals", "redundancy_numbers", "standardized")
ALL = (
    *PARAMETERS,
    *OBSERVATIONS,
    *("covariance", "correlation"),
    *("parameter_residuals", "parameter_redundancy_numbers"),
)


def linear(A):
    """Observation equations f(x) = A x."""
    return lambda x: (x @ A.T, A)


def distances(x, stations):
    """Distances of points (..., 2) from stations (..., n, 2), and their Jacobian."""
    difference = x[..., None, :] - stations
    distance = np.linalg.norm(difference, axis=-1)
    return distance, difference / distance[..., None]


def decay(x, t):
    """A exp(-b t), the textbook's curve on which plain Gauss-Newton can fail."""
    a, b = x[..., :1], x[..., 1:]
    e = np.exp(-b * t)
    return a * e, np.stack([e, -a * t * e], axis=-1)


def problem(seed, n=9, u=3):
    """A linear problem with uneven weights and without symmetry."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, u))
    observations = A @ rng.normal(size=u) + 0.1 * rng.normal(size=n)
    return A, observations, rng.uniform(0.2, 5, n), rng


def spd(rng, n):
    """A covariance without zeros."""
    root = rng.normal(size=(n, n))
    return root @ root.T / n + 0.3 * np.eye(n)


def fields(found):
    """All numbers of a result that describe one problem."""
    return {name: getattr(found, name) for name in ALL}


def assert_same(found, other, names=ALL, **tolerance):
    for name in names:
        values = getattr(found, name), getattr(other, name)
        np.testing.assert_allclose(*values, **(tolerance or ROUNDING), err_msg=name)


def close(one, other, **tolerance):
    np.testing.assert_allclose(one, other, **(tolerance or ROUNDING))


STATIONS = np.array([[0.0, 0.0], [90.0, 10.0], [70.0, 80.0], [-20.0, 60.0]])
READINGS = np.array([58.31, 56.57, 44.74, 58.32])  # to a point near (50, 30), noisy


# --- Weights and the covariance of the observations ---


@given(st.integers(0, 2**32 - 1))
def test_weighted_linear_adjustment_is_numpys_least_squares(seed):
    A, observations, weights, rng = problem(seed)
    found = adjust(linear(A), rng.normal(size=3), observations, weights=weights)
    root = np.sqrt(weights)
    x, phi, *_ = np.linalg.lstsq(A * root[:, None], observations * root, rcond=None)
    tolerance = {"rtol": 1e-8, "atol": 1e-9}  # normal equations square the condition
    close(found.x, x, **tolerance)
    close(found.residuals, A @ x - observations, **tolerance)
    close(found.sigma0, np.sqrt(phi[0] / 6), **tolerance)
    assert found.status == "converged" and found.redundancy == 6


def test_covariance_does_what_whitening_does_and_what_weights_do():
    A, observations, weights, rng = problem(1)
    covariance = spd(rng, 9)
    found = adjust(linear(A), np.zeros(3), observations, covariance=covariance)
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    other = adjust(linear(white @ A), np.zeros(3), white @ observations)
    assert_same(found, other, (*PARAMETERS, "covariance"))
    close(white @ found.residuals, other.residuals)
    assert_same(
        adjust(linear(A), np.zeros(3), observations, covariance=np.diag(1 / weights)),
        adjust(linear(A), np.zeros(3), observations, weights=weights),
    )


def test_covariance_in_units_as_far_apart_as_metres_and_radians():
    A, L, _, rng = problem(4)
    units, C = np.geomspace(1e-9, 1e9, 9), spd(rng, 9)
    found = adjust(linear(A), np.zeros(3), L, covariance=C)
    scaled = {"observations": L * units, "covariance": C * units * units[:, None]}
    other = adjust(linear(A * units[:, None]), np.zeros(3), **scaled)
    assert_same(other, found, ("x", "standardized"))


def test_weight_zero_leaves_an_observation_out():
    A, observations, weights, _ = problem(6)
    weights[[2, 7]] = 0
    observations[2] = 1e6  # whatever it says
    found = adjust(linear(A), np.zeros(3), observations, weights=weights)
    k = np.flatnonzero(weights)
    other = adjust(linear(A[k]), np.zeros(3), observations[k], weights=weights[k])
    assert_same(found, other, PARAMETERS)
    for name in OBSERVATIONS:
        close(getattr(found, name)[k], getattr(other, name))
    assert not found.redundancy_numbers[[2, 7]].any()
    assert not found.standardized[[2, 7]].any()
    # the residual still tells how far off it is
    assert np.isclose(found.residuals[2], A[2] @ found.x - 1e6)


# --- Weighted parameters ---


@pytest.mark.parametrize("correlated", [False, True])
def test_weighted_parameters_are_further_observations(correlated):
    A, observations, weights, rng = problem(7)
    values, p = rng.normal(size=3), np.array([0.5, 0.0, 2.0])
    of_all = {"weights": np.append(weights, p)}
    options = {"weights": weights}
    if correlated:
        p[1] = 1.5
        whole = np.diag(np.append(np.ones(9), 1 / p))
        whole[:9, :9] = spd(rng, 9)
        of_all, options = {"covariance": whole}, {"covariance": whole[:9, :9]}
    options |= {"parameter_weights": p, "parameter_values": values}
    found = adjust(linear(A), np.zeros(3), observations, **options)
    both = np.vstack([A, np.eye(3)]), np.append(observations, values)
    other = adjust(linear(both[0]), np.zeros(3), both[1], **of_all)
    assert_same(found, other, PARAMETERS)
    assert found.redundancy == 9 + np.count_nonzero(p) - 3
    for name in ("residuals", "standardized"):
        close(getattr(found, name), getattr(other, name)[:9])
    close(found.parameter_residuals, other.residuals[9:])
    close(found.parameter_redundancy_numbers, other.redundancy_numbers[9:])


# --- Constraints ---


def test_linear_constraints_do_what_elimination_does():
    A, observations, weights, _ = problem(10, u=4)
    C, d = np.array([[1.0, 2.0, 0.0, -1.0], [0.0, 1.0, 1.0, 0.5]]), np.array([0.4, -1])
    options = {"weights": weights, "constraints": lambda x: (C @ x - d, C)}
    found = adjust(linear(A), np.zeros(4), observations, **options)
    # x = particular solution + null space of C times free parameters
    particular = np.linalg.lstsq(C, d, rcond=None)[0]
    free = np.linalg.svd(C)[2][2:].T
    reduced = observations - A @ particular
    other = adjust(linear(A @ free), np.zeros(2), reduced, weights=weights)
    close(found.x, particular + free @ other.x)
    close(found.cofactor, free @ other.cofactor @ free.T)
    assert_same(found, other, ("sigma0", *OBSERVATIONS))
    assert found.redundancy == other.redundancy == 9 - 4 + 2
    close(C @ found.x, d, atol=1e-12)


def on_circle(x, stations):
    """A constraint: the point lies 60 from the origin."""
    return x @ x[:, None] - 3600.0, 2 * x[None]


@pytest.mark.parametrize("start", [[50.0, 30.0], [10.0, 70.0], [5.0, 5.0]])
def test_nonlinear_constraint_gives_the_minimum_that_slsqp_finds(start):
    found = adjust(distances, start, READINGS, args=[STATIONS], constraints=on_circle)

    def phi(x):
        return np.sum((distances(x, STATIONS)[0] - READINGS) ** 2)

    circle = {"type": "eq", "fun": lambda x: on_circle(x, STATIONS)[0]}
    best = minimize(phi, [50, 30], method="SLSQP", constraints=circle, tol=1e-14)
    assert found.status == "converged"
    close(found.x, best.x, rtol=1e-6)  # what SLSQP reaches
    assert np.isclose(found.x @ found.x, 3600, rtol=1e-12)
    assert found.redundancy == 3
    assert np.isclose(found.redundancy_numbers.sum(), 3)
    # along the circle there is error, across it there is none
    across = found.x / 60
    assert abs(across @ found.cofactor @ across) < 1e-12


def test_a_constraint_that_only_changes_the_datum_is_closed_to_the_end():
    # Ratios leave the scale free; the constraint sets it, far from the start value. The
    # start fits the observations without error: vᵀPv does not tell what is missing.
    def ratio(x):
        one = np.array([[1 / x[1], -x[0] / x[1] ** 2]])
        return np.full(2, x[0] / x[1]), np.repeat(one, 2, axis=0)

    def length(x):
        return x @ x[:, None] - 100.0, 2 * x[None]

    found = adjust(ratio, [1.0, 2.0], [0.5, 0.5], constraints=length)
    close(found.x, np.sqrt(20) * np.array([1, 2]), rtol=1e-12)


def test_parameters_fixed_by_constraints_have_no_variance_and_no_correlation():
    A, observations, _, rng = problem(25, n=12, u=4)
    C = np.zeros((40, 2, 4))
    C[:, :, :2] = rng.normal(size=(40, 2, 2))  # two equations for the first two
    C[0, :, :2] = np.eye(2)  # exactly; the others but for rounding,
    C[1:9, 1, :2] = C[1:9, 0, :2] + [0, 3e-2]  # which these magnify: nearly parallel
    found = adjust(
        lambda x, C: linear(A)(x),
        np.zeros((40, 4)),
        observations,
        args=[C],
        constraints=lambda x, C: ((C @ x[..., None])[..., 0] - 1 / 3, C),
    )
    assert found.x[0, 1] == approx(1 / 3, rel=1e-14)
    equal(found.sd[:, :2], 0)
    equal(found.correlation[:, :2], 0)
    assert np.all(found.sd[:, 2:] > 0) and np.all(found.status == "converged")
    assert np.all(np.abs(found.correlation) <= 1 + 1e-12)
    assert not np.isnan(found.history.change).any()


def test_a_constraint_that_nothing_satisfies_does_not_converge():
    def impossible(x, stations):
        return x @ x[:, None] + 1, 2 * x[None]

    options = {"args": [STATIONS], "constraints": impossible}
    assert adjust(distances, [50.0, 30.0], READINGS, **options).status != "converged"


# --- Free networks ---

# Four bench marks, six height differences from point to point
LEVELLING = np.array(
    [
        [-1.0, 1, 0, 0],
        [0, -1, 1, 0],
        [0, 0, -1, 1],
        [1, 0, 0, -1],
        [-1, 0, 1, 0],
        [0, -1, 0, 1],
    ]
)
DIFFERENCES = np.array([1.203, -0.512, 2.118, -2.806, 0.694, 1.601])
LENGTHS = np.array([1.2, 0.8, 1.9, 1.1, 2.3, 1.6])  # km


def fixed(i, value=0.0):
    """A constraint: height i is known."""
    row = np.eye(4)[i : i + 1]
    return lambda x: (row @ x - value, row)


def inner(x):
    """Inner constraint: the heights do not shift as a whole."""
    return np.zeros(1), np.ones((1, 4))


def level(constraints, **options):
    options |= {"weights": 1 / LENGTHS, "constraints": constraints}
    return adjust(linear(LEVELLING), np.zeros(4), DIFFERENCES, **options)


@pytest.mark.parametrize("i", range(4))
def test_datum_of_a_levelling_net_changes_heights_but_nothing_observed(i):
    free, held = level(inner), level(fixed(i, 100.0))
    assert_same(free, held, (*OBSERVATIONS, "sigma0"))
    assert free.redundancy == held.redundancy == 3
    assert held.x[i] == approx(100, rel=1e-14)
    assert np.ptp(free.x - held.x) < 1e-11  # one shift for all
    assert np.trace(free.cofactor) < np.trace(held.cofactor) - 0.1
    N = LEVELLING.T @ np.diag(1 / LENGTHS) @ LEVELLING
    close(free.cofactor, np.linalg.pinv(N), atol=1e-12)


# --- The iteration ---


def arctangents(x):
    """Newton's method for arctan(x) = 0 runs away from |x| > 1.39."""
    scale = np.array([1.0, 1.1, 0.9])
    return np.arctan(scale * x), (scale / (1 + (scale * x) ** 2))[:, None]


def test_line_search_converges_where_full_steps_run_away():
    arguments = arctangents, [3.0], [0.01, -0.02, 0.005]
    damped = adjust(*arguments)
    assert damped.status == "converged"
    assert damped.history.step[0] < 1 and damped.history.step[-1] == 1
    halved = np.log2(damped.history.step)
    equal(halved, np.round(halved))
    assert np.all(np.diff(damped.history.objective) <= 0)
    full = adjust(*arguments, line_search=False, max_iterations=3)
    assert full.status == "too many iterations" and abs(full.x[0]) > 1e3
    assert np.all(np.diff(full.history.objective) > 0)
    equal(full.history.step, 1)


@given(st.lists(st.floats(-9, 9), min_size=2, max_size=2), st.integers(0, 99))
def test_units_of_the_parameters_do_not_matter(decades, seed):
    units = 10.0 ** np.array(decades)
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 3, 8)
    readings = decay(np.array([5.0, 0.7]), t)[0] + 0.05 * rng.normal(size=8)

    def scaled(x):
        values, jacobian = decay(x * units, t)
        return values, jacobian * units

    plain = adjust(lambda x: decay(x, t), [4.0, 1.0], readings)
    other = adjust(scaled, [4.0, 1.0] / units, readings)
    assert plain.iterations == other.iterations
    close(other.x * units, plain.x, rtol=1e-9)
    close(other.sd * units, plain.sd, rtol=1e-9)
    close(other.residuals, plain.residuals, atol=1e-9)
    close(other.history.change, plain.history.change, atol=1e-6)


@given(st.integers(-9, 9))
def test_unit_of_weight_does_not_matter(decade):
    arguments, factor = (distances, [40.0, 40.0], READINGS), 10.0**decade
    plain = adjust(*arguments, args=[STATIONS])
    other = adjust(*arguments, args=[STATIONS], weights=factor * np.ones(4))
    assert plain.iterations == other.iterations
    assert_same(other, plain, ("x", "covariance", "standardized"), rtol=1e-9)
    close(other.sigma0, plain.sigma0 * factor**0.5, rtol=1e-9)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-8])
def test_iteration_ends_with_the_first_change_below_the_tolerance_in_sd(tolerance):
    start = np.array([20.0, 70.0])
    found = adjust(distances, start, READINGS, args=[STATIONS], tolerance=tolerance)
    history = found.history
    assert history.change[-1] <= tolerance < history.change[-2]
    exact = adjust(distances, start, READINGS, args=[STATIONS], tolerance=1e-12)
    assert np.all(np.abs(found.x - exact.x) <= tolerance * exact.sd)
    # and the history tells what happened in each iteration
    assert history.objective.shape == (found.iterations + 1,)
    assert history.step.shape == history.change.shape == (found.iterations,)
    before = distances(start, STATIONS)[0] - READINGS
    assert np.isclose(history.objective[0], before @ before)
    assert np.isclose(history.objective[-1], found.residuals @ found.residuals)


@pytest.mark.parametrize("offset", [0.0, 1e7])
def test_what_rounding_leaves_is_not_iterated_away(offset):
    # Without errors sigma0 and all sd end as rounding, 1e-9 m for coordinates of 1e7 m
    start, _, stations, rng = stack(300)
    start, stations = start + offset, stations + offset
    truth = start + rng.normal(scale=5, size=start.shape)
    exact = distances(truth, stations)[0]
    found = adjust(distances, start, exact, args=[stations])
    assert np.all(found.status == "converged") and found.iterations.max() < 12
    close(found.x, truth, atol=1e-13 * (100 + offset))


# --- Agreement with scipy ---


@pytest.mark.parametrize("seed", range(5))
def test_nonlinear_fit_agrees_with_scipy(seed):
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(0, 4, 12))
    truth = rng.uniform([2, 0.2], [8, 1.5])
    sigma = rng.uniform(0.02, 0.2, 12)
    readings = decay(truth, t)[0] + sigma * rng.normal(size=12)
    options = {"weights": sigma**-2.0, "tolerance": 1e-10}
    found = adjust(lambda x: decay(x, t), 1.3 * truth, readings, **options)
    other = least_squares(
        lambda x: (decay(x, t)[0] - readings) / sigma,
        1.3 * truth,
        jac=lambda x: decay(x, t)[1] / sigma[:, None],
        **dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15),
    )
    # where vᵀPv is flat to rounding, 1e-16, lies within 1e-8 of a standard deviation
    assert np.all(np.abs(found.x - other.x) < 1e-7 * found.sd)
    close(found.residuals, other.fun * sigma, atol=1e-8)
    close(found.cofactor, np.linalg.inv(other.jac.T @ other.jac), rtol=1e-6)
    assert np.isclose(found.sigma0, np.sqrt(2 * other.cost / 10), rtol=1e-10)


# --- Redundancy numbers and standardised residuals ---


@given(st.integers(0, 2**32 - 1), *[st.booleans()] * 4)
def test_redundancy_numbers_add_up_to_the_redundancy(
    seed, correlated, zeros, weighted, constrained
):
    A, observations, weights, rng = problem(seed, n=8, u=3)
    options, made = {}, 8
    if correlated:
        options["covariance"] = spd(rng, 8)
    else:
        if zeros:
            weights[rng.choice(8, 2, replace=False)] = 0
            made = 6
        options["weights"] = weights
    if weighted:
        options["parameter_weights"] = [0.7, 0.0, 3.0]
    if constrained:
        C = rng.normal(size=(1, 3))
        options["constraints"] = lambda x: (C @ x - 1, C)
    found = adjust(linear(A), np.zeros(3), observations, **options)
    assert found.redundancy == made - 3 + 2 * weighted + constrained
    total = found.redundancy_numbers.sum() + found.parameter_redundancy_numbers.sum()
    assert total == approx(found.redundancy, abs=1e-8)
    if not correlated:
        assert np.all(found.redundancy_numbers > -1e-12)
        assert np.all(found.redundancy_numbers < 1 + 1e-12)


@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("prior", [None, 0.3])
def test_residuals_are_standardised_by_their_own_covariance(correlated, prior):
    A, observations, weights, rng = problem(16)
    C = spd(rng, 9) if correlated else np.diag(1 / weights)
    options = {"covariance": C} if correlated else {"weights": weights}
    found = adjust(linear(A), np.zeros(3), observations, sigma0_prior=prior, **options)
    P = np.linalg.inv(C)
    Q = np.linalg.inv(A.T @ P @ A)
    Qvv = C - A @ Q @ A.T
    close(found.redundancy_numbers, np.diag(Qvv @ P))
    w = P @ found.residuals / np.sqrt(np.diag(P @ Qvv @ P))
    close(found.standardized, w / (prior or found.sigma0))
    # covariance and correlation follow from the cofactors
    sd = np.sqrt(np.diag(Q))
    close(found.cofactor, Q)
    close(found.covariance, found.sigma0**2 * Q)
    close(found.sd, found.sigma0 * sd)
    close(found.correlation, Q / np.outer(sd, sd))


@pytest.mark.parametrize("correlated", [False, True])
def test_squared_w_is_what_an_own_error_of_the_observation_takes_from_v_P_v(correlated):
    A, observations, weights, rng = problem(17)
    options = {"covariance": spd(rng, 9)} if correlated else {"weights": weights}
    found = adjust(linear(A), np.zeros(3), observations, sigma0_prior=1, **options)
    for i in range(9):
        with_error = np.column_stack([A, np.eye(9)[i]])
        other = adjust(linear(with_error), np.zeros(4), observations, **options)
        drop = 6 * found.sigma0**2 - 5 * other.sigma0**2
        assert found.standardized[i] ** 2 == approx(drop, rel=1e-8)
        # an observation that is too large has a negative v and a positive error
        assert np.sign(found.standardized[i]) == -np.sign(other.x[3])


def test_without_redundancy_there_is_no_sigma0_and_the_prior_takes_its_place():
    A = np.array([[1.0, 2.0], [3.0, -1.0]])
    bare = adjust(linear(A), [0, 0], [1.0, 2.0])
    assert bare.redundancy == 0 and bare.status == "converged"
    assert np.isnan(bare.sigma0) and np.isnan(bare.sd).all()
    equal(bare.standardized, 0)
    known = adjust(linear(A), [0, 0], [1.0, 2.0], sigma0_prior=0.1)
    close(known.covariance, 0.01 * np.linalg.inv(A.T @ A))
    with pytest.raises(ValueError, match="without redundancy"):
        known.global_test()


@pytest.mark.parametrize(("factor", "accepted"), [(1, True), (4, False), (0.2, False)])
def test_global_test_compares_sigma0_with_its_prior(factor, accepted):
    A, observations, weights, _ = problem(19)
    arguments = linear(A), np.zeros(3), observations
    plain = adjust(*arguments, weights=weights)
    prior = plain.sigma0 / factor
    found = adjust(*arguments, weights=weights, sigma0_prior=prior)
    test = found.global_test(alpha=0.1)
    assert test.statistic == approx(6 * factor**2)
    assert test.lower == approx(chi2.ppf(0.05, 6))
    assert test.upper == approx(chi2.ppf(0.95, 6))
    assert test.accepted == accepted
    with pytest.raises(ValueError, match="needs sigma0_prior"):
        plain.global_test()


# --- What cannot be determined ---


def test_parameters_that_are_not_determined_are_named_and_no_others():
    with pytest.raises(RankDefect, match=r"rank 3 of 4.* A, B, C, D\.") as failed:
        level(None, names=["A", "B", "C", "D"])
    assert failed.value.null_space.defect == 1
    assert "UTM" not in str(failed.value)  # a missing datum has another cause
    A, observations, _, _ = problem(20, u=4)
    A[:, 1] = 0
    with pytest.raises(RankDefect, match="do not determine K3. Add"):
        adjust(linear(A), np.zeros(4), observations, names=["c", "K3", "x0", "y0"])
    A, observations, _, _ = problem(21, u=4)
    A[:, 3] = -2e-6 * A[:, 0]  # in other units, too
    with pytest.raises(RankDefect) as failed:
        adjust(linear(A), np.zeros(4), observations, names=list("abcd"))
    assert failed.value.null_space.names == ("a", "d")
    assert failed.value.null_space.parallel == ("a", "d")


def test_a_weight_on_the_parameter_cures_a_defect_and_a_useless_constraint_does_not():
    found = level(None, parameter_weights=[1.0, 0, 0, 0])
    close(found.residuals, level(fixed(0)).residuals, atol=1e-12)
    assert found.redundancy == 3
    assert found.parameter_redundancy_numbers[0] == approx(0, abs=1e-9)
    row = np.array([[1.0, -1.0, 0.0, 0.0]])
    with pytest.raises(RankDefect, match="x1, x2, x3, x4"):
        level(lambda x: (row @ x - 1.2, row))


def test_strong_but_honest_correlation_is_not_called_a_defect():
    t = np.linspace(1000, 1001, 8)  # a line far from its origin, correlation -1 + 5e-8
    A = np.column_stack([np.ones(8), t])
    found = adjust(linear(A), [0, 0], 2 + 3 * t)
    assert found.status == "converged"
    assert -1 < found.correlation[0, 1] < -1 + 1e-6
    close(found.x, [2, 3], atol=1e-4)  # condition of N about 1e13


# --- Stacks ---


def stack(k=12, seed=5):
    """Points in a quadrilateral of four stations each, all different."""
    rng = np.random.default_rng(seed)
    stations = STATIONS + rng.normal(scale=8, size=(k, 4, 2))
    truth = rng.uniform(20, 50, size=(k, 2))
    readings = distances(truth, stations)[0] + rng.normal(scale=0.3, size=(k, 4))
    return truth + rng.normal(scale=8, size=(k, 2)), readings, stations, rng


def on_line(x, stations):
    """A constraint: x - y = 3."""
    value = x[..., :1] - x[..., 1:] - 3
    return value, np.broadcast_to([[1.0, -1.0]], (*value.shape, 2))


@pytest.mark.parametrize("kind", ["plain", "weights", "covariance", "all"])
def test_a_stack_equals_a_loop(kind):
    start, readings, stations, rng = stack()
    shared, options = {}, {}
    if kind == "weights":
        shared["weights"] = rng.uniform(0.5, 2, (12, 4))
    if kind in ("covariance", "all"):
        shared["covariance"] = np.array([spd(rng, 4) for _ in start])
    if kind == "all":
        shared["parameter_weights"] = rng.uniform(0, 1, (12, 2))
        shared["parameter_values"] = start + 1
        options["constraints"] = on_line
    found = adjust(distances, start, readings, args=[stations], **shared, **options)
    assert np.ptp(found.iterations) > 0  # they do not all stop together
    for i in range(12):
        own = {name: values[i] for name, values in shared.items()} | options
        alone = adjust(distances, start[i], readings[i], args=[stations[i]], **own)
        for name, values in fields(found).items():
            values = values[i], getattr(alone, name)
            close(*values, rtol=1e-12, atol=1e-12, err_msg=name)
        count = alone.iterations
        assert (found.status[i], found.iterations[i]) == (alone.status, count)
        objective = found.history.objective[: count + 1, i]
        close(objective, alone.history.objective, rtol=1e-12)
        equal(found.history.step[:count, i], alone.history.step)
        assert not found.history.step[count:, i].any()
        assert not found.history.change[count:, i].any()


def test_what_all_problems_share_need_not_be_repeated():
    start, readings, _, _ = stack(5)
    one = adjust(
        lambda x: distances(x, STATIONS), start, readings[0], weights=[1, 2, 3, 4]
    )
    whole = {"weights": np.tile([1, 2, 3, 4], (5, 1))}
    whole["args"] = [np.tile(STATIONS, (5, 1, 1))]
    other = adjust(distances, start, np.tile(readings[0], (5, 1)), **whole)
    assert_same(one, other, rtol=0, atol=0)
    A, observations, _, _ = problem(22)  # a Jacobian and values without leading axes
    shared = adjust(linear(A), np.zeros((5, 3)), observations)
    alone = adjust(linear(A), np.zeros(3), observations)
    close(shared.x, np.tile(alone.x, (5, 1)))


def test_every_problem_of_a_stack_gets_its_own_status():
    def model(x, a, b):
        # arctan(a x) + b y: b = 0 leaves y free; a = nan is no number
        first, second = x[..., :1], x[..., 1:]
        values = np.concatenate([np.arctan(a * first), b * second], axis=-1)
        values = np.concatenate([values, values], axis=-1)
        J = np.zeros((len(x), 4, 2))
        J[:, ::2, 0], J[:, 1::2, 1] = a / (1 + (a * first) ** 2), b
        return values, J

    start = np.array([[0.5, 0], [0.5, 0], [1.0, 0], [3.0, 0]])
    a = np.array([[1.0], [1.0], [np.nan], [1.0]])
    b = np.array([[1.0], [0.0], [1.0], [1.0]])
    observations = [0.1, 2.0, 0.12, 2.1]
    found = adjust(model, start, observations, args=[a, b], max_iterations=4)
    expected = ["converged", "singular", "diverged", "too many iterations"]
    assert list(found.status) == expected
    alone = adjust(model, start[:1], observations, args=[a[:1], b[:1]])
    equal(found.x[0], alone.x[0])
    equal(found.cofactor[0], alone.cofactor[0])
    assert np.isnan(found.x[1]).all() and np.isnan(found.sd[1]).all()
    assert np.isnan(found.residuals[1]).all() and np.isnan(found.sigma0[1])
    assert np.isnan(found.sigma0[2]) and found.iterations[2] == 0
    assert np.isfinite(found.sigma0[3]) and found.iterations[3] == 4


def test_a_wrong_jacobian_is_called_divergence():
    def wrong(x):
        values, jacobian = distances(x, STATIONS)
        return values, -jacobian

    found = adjust(wrong, [20.0, 70.0], READINGS)
    assert found.status == "diverged"
    equal(found.x, [20, 70])  # left where it was
    assert found.history.step[-1] == 0
    assert found.history.objective[-1] == found.history.objective[0]


def test_a_step_to_where_nothing_is_defined_is_shortened():
    def logarithm(x):  # the full step from 5 goes below zero
        with np.errstate(invalid="ignore"):
            return np.full(3, np.log(x[0])), np.full((3, 1), 1 / x[0])

    found = adjust(logarithm, [5.0], [0.01, -0.01, 0.0])
    assert found.status == "converged" and found.history.step[0] < 1
    assert found.x[0] == approx(1, abs=1e-6)
    full = adjust(logarithm, [5.0], [0.01, -0.01, 0.0], line_search=False)
    assert full.status == "diverged"


# --- Bad input ---


A, L = problem(23)[:2]
GOOD = {"function": linear(A), "start": np.zeros(3), "observations": L}
NAN = np.array([np.nan, *L[1:]])
EYE = np.eye(9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"start": [np.nan, 0, 0]}, r"start\[0\] is not a finite number"),
        ({"observations": L[:8]}, "function computes 9 values for 8 observations"),
        ({"weights": [1, 2]}, r"weights must have shape \(9,\); got \(2,\)"),
        ({"weights": -np.ones(9)}, "weights must not be negative"),
        ({"weights": 1.0, "covariance": EYE}, "weights or covariance, not both"),
        ({"covariance": np.eye(8)}, r"covariance must have shape \(..., 9, 9\)"),
        ({"covariance": EYE + np.eye(9, k=1)}, "covariance must be symmetric"),
        ({"covariance": 3 * EYE - 1}, "covariance must be positive definite"),
        ({"covariance": -EYE}, "covariance must have positive variances"),
        ({"parameter_values": [1, 2, 3]}, "parameter_values need parameter_weights"),
        ({"names": ["a", "b"]}, "names has 2 entries for 3 parameters"),
        ({"function": lambda x: A @ x}, "function must return two arrays"),
        ({"function": lambda x: (A @ x, A.T)}, r"must return a Jacobian \(9, 3"),
        ({"function": lambda x: (NAN, A)}, "not finite at the start values"),
    ],
)
def test_bad_input_is_named(change, message):
    with pytest.raises(ValueError, match=message):
        adjust(**(GOOD | change))


def test_fewer_observations_than_unknowns_are_refused():
    with pytest.raises(ValueError, match="rank 2 of 3"):
        adjust(linear(A[:2]), np.zeros(3), L[:2], weights=1.0)
    with pytest.raises(ValueError, match="rank 2 of 3"):  # also by zero weights
        adjust(linear(A), np.zeros(3), L, weights=[1, 0, 0, 0, 1, 0, 0, 0, 0])
    found = adjust(linear(A[:2]), np.zeros((4, 3)), L[:2])
    assert set(found.status) == {"singular"}
