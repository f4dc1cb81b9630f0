"""Bundle adjustment: Gauss-Newton with line search on the reduced normal equations."""

from collections.abc import Iterable, Sequence

import numpy as np
import scipy

from pgm_lab import _validate
from pgm_lab.adjustment import normal
from pgm_lab.adjustment.normal import ROUNDING, SMALLEST_STEP, SUFFICIENT_DECREASE
from pgm_lab.adjustment.result import UNCONTROLLED, History
from pgm_lab.bundle import datum as datums
from pgm_lab.bundle import refuse
from pgm_lab.bundle.datum import Motions
from pgm_lab.bundle.equations import (
    Equations,
    Problem,
    State,
    by_photo,
    residuals_alone,
    shares,
    unwhiten,
)
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.reduced import Reduced, flat
from pgm_lab.bundle.result import Bundle, kept_unknowns, readable
from pgm_lab.camera import PARAMETERS


def adjust(
    network: Network,
    estimate: Sequence[str] = PARAMETERS,
    datum: str | None = None,
    *,
    sigma0_prior: float | None = None,
    line_search: bool = True,
    tolerance: float = 1e-6,
    max_iterations: int = 50,
    progress: bool = False,
) -> Bundle:
    """Adjust a network: cameras, exterior orientations and points together.

    Parameters
    ----------
    network : Network
        Observations, start values and datum points.
    estimate : sequence of str
        Interior parameters to estimate, from `camera.PARAMETERS`, for each camera; ()
        for none.
    datum : {"inner", "photos", "fixed", "none"}, optional
        "inner": inner constraints on the datum points (G of (M 2.95): seven, or six
        with scale bars), at the current points in each iteration. "photos": the same on
        the projection centres. "fixed": control points carry the datum. "none" only
        shows the rank defect. When missing: "fixed" if there are fixed or control
        points, else "inner".
    sigma0_prior : float, optional
        Standard deviation of unit weight beforehand; 1 if the sigmas of the network are
        trusted. Residuals become Baarda's w; without it Pope's tau.
    line_search : bool
        False takes full steps, to see why one does not.
    tolerance : float
        Change of an unknown, in its standard deviations, that is negligible.
    max_iterations : int
    progress : bool
        Show a progress bar.

    Returns
    -------
    Bundle

    Raises
    ------
    ValueError
        If an argument is wrong, a start value leads to values that are not finite, or
        c comes out negative, as that of a mirrored image does.
    RankDefect
        If the network does not determine all unknowns; the message names them.

    References
    ----------
    Muliawan 2013, (M 2.75) to (M 2.95); Brown 1976; Triggs et al. 2000.

    Examples
    --------
    >>> from pgm_lab import camera, datasets
    >>> data = datasets.muliawan2013()
    >>> start = camera.Camera(*data.interior), data.exteriors, data.object_points
    >>> network = Network(*start, data.photo, data.point, data.xy, data.sigma)
    >>> found = adjust(network)
    >>> print(f"sigma0 {found.sigma0:.3f}, redundancy {found.redundancy}")
    sigma0 0.349, redundancy 693
    >>> print(f"c = {found.cameras[0].c:.3f} mm +- {found.sd_interior[0]:.4f} mm")
    c = 34.581 mm +- 0.0143 mm
    """
    problem = Problem.of(network, estimate)
    datum = datums.choose(network, datum)
    sigma0_prior = _validate.standard_deviation(sigma0_prior, "sigma0_prior")
    line_search = _validate.flag(line_search, "line_search")
    progress = _validate.flag(progress, "progress")
    tolerance = _validate.positive_number(tolerance, "tolerance", "sd of an unknown")
    max_iterations = _validate.whole(max_iterations, "max_iterations", 1)

    # Is there enough to determine all unknowns, and the datum?
    state, U = problem.start, problem.rays.interior
    refuse.check_counts(network)
    refuse.check_attitudes(network, state.exteriors)
    move = datums.free_motions(network, state, U)
    refuse.check_datum(network, datum, move)
    datums.check_constraint(network, datum, move)
    redundancy = problem.redundancy(move.number)
    eq = problem.equations(state)
    phi = problem.objective(state, eq.v)
    if not np.isfinite(phi):
        raise ValueError(
            "at the start values an image coordinate cannot be computed: check the"
            " start values of cameras, exteriors and points"
        )

    status, objectives, steps, changes = "too many iterations", [phi], [], []
    for _ in _counted(max_iterations, progress):
        # Corrections of a Gauss-Newton step, in the datum
        reduced = Reduced.of(problem, state, eq)
        dx, dx_points, decrease = _corrections(problem, datum, state, reduced, move)
        sigma = sigma0_prior or np.sqrt(phi / max(redundancy, 1))
        changes.append(np.sqrt(decrease) / sigma if sigma > 0 else 0.0)

        # As much of the step as lowers vᵀPv
        rounding = _rounding(problem, state, reduced)
        slack = rounding * (2 * np.sqrt(phi) + rounding)
        step, there = _line_search(
            problem, state, phi, dx, dx_points, decrease, slack, line_search
        )
        steps.append(step)
        if there is None:
            status = "diverged"
            break
        state, eq, phi = there
        move = datums.free_motions(network, state, U)
        objectives.append(phi)
        if changes[-1] <= tolerance or decrease <= rounding**2:
            status = "converged"
            break
    else:
        reduced = Reduced.of(problem, state, eq)

    # Covariances, residuals and their tests
    history = History(*map(np.array, (objectives, steps, changes)))
    scale, factor = _factor(problem, state, reduced, move)
    inverse = scipy.linalg.lapack.dpotrs(factor, np.diag(scale), lower=True)[0]
    Q = inverse * scale[:, None]
    return _result(
        problem, datum, state, eq, reduced, Q, move, sigma0_prior, status, history
    )


# --- The iteration ---


def _corrections(
    problem: Problem, datum: str, state: State, reduced: Reduced, move: Motions
) -> tuple[np.ndarray, np.ndarray, float]:
    """Gauss-Newton step of kept unknowns and points, and dx'N dx."""
    refuse.check_points(problem.network, reduced)
    scale, factor = _factor(problem, state, reduced, move)
    right = scale * reduced.right
    dx = scale * scipy.linalg.lapack.dpotrs(factor, right, lower=True)[0]
    dx_points = reduced.points_alone()
    decrease = reduced.right @ dx + np.vdot(reduced.n_point, dx_points)
    dx_points = dx_points - reduced.times_kept(dx[:, None])[0]
    if move.number:  # into the datum: R times the corrections is 0
        R = datums.constraint(problem.network, datum, move)
        t = R.kept.T @ dx + flat(R.points) @ dx_points.ravel()
        dx = dx - move.kept @ t
        dx_points = dx_points - (t @ flat(move.points)).reshape(dx_points.shape)
    return dx, dx_points, max(float(decrease), 0.0)


def _factor(
    problem: Problem, state: State, reduced: Reduced, move: Motions
) -> tuple[np.ndarray, np.ndarray]:
    """Scale, and Cholesky factor of the scaled S, made regular along motions."""
    # S has no value for a motion; E Eᵀ gives it one, since the columns of E are the
    # motions. The solution does not notice, and the inverse is a generalised one: such
    # differ only by motions, which the S-transformation takes away
    scale = 1 / np.sqrt(np.where(reduced.diagonal > 0, reduced.diagonal, 1.0))
    E = move.kept / scale[:, None]
    E /= np.sqrt(np.einsum("ud,ud->d", E, E))
    scaled = reduced.S * scale[:, None] * scale + E @ E.T
    factor, failed = scipy.linalg.lapack.dpotrf(scaled, lower=True)
    pivots = np.diagonal(factor) ** 2
    if failed or not pivots.min(initial=1.0) > 1 / normal.INFLATION_LIMIT:
        refuse.check_attitudes(problem.network, state.exteriors)
        unknowns = kept_unknowns(problem.network, problem.estimate)
        refuse.refuse_kept(scaled, readable(unknowns))
    return scale, factor


def _rounding(problem: Problem, state: State, reduced: Reduced) -> float:
    """What the rounding of numbers does to v over sigma."""
    kept = np.concatenate(
        [state.interior[:, problem.estimated].ravel(), state.exteriors.ravel()]
    )
    size = np.sqrt(reduced.diagonal) * np.abs(kept)
    points = np.sqrt(reduced.V_diagonal) * np.abs(state.points.T) * ~problem.held
    return ROUNDING * float(problem.rays.level + max(size.max(), points.max(initial=0)))


def _line_search(
    problem: Problem,
    state: State,
    phi: float,
    dx: np.ndarray,
    dx_points: np.ndarray,
    decrease: float,
    slack: float,
    line_search: bool,
) -> tuple[float, tuple[State, Equations, float] | None]:
    """Halve the step until vᵀPv falls enough: the step (or 0), and what is there."""
    # Without line search the full step is taken, wherever it leads
    step = 1.0
    while step >= SMALLEST_STEP:
        there = problem.moved(state, step * dx, step * dx_points)
        eq = problem.equations(there)
        after = problem.objective(there, eq.v)
        goal = phi - 2 * SUFFICIENT_DECREASE * step * decrease + slack
        if after <= goal or (not line_search and np.isfinite(after)):
            return step, (there, eq, after)
        if not line_search:
            break
        step /= 2
    return 0.0, None


def _counted(iterations: int, progress: bool) -> Iterable[int]:
    if not progress:
        return range(iterations)
    from tqdm.auto import tqdm

    bar = {"desc": "bundle adjustment", "unit": " iterations", "leave": False}
    return tqdm(range(iterations), delay=1.0, **bar)  # seconds; a short one needs none


# --- Precision and reliability ---


def _result(
    problem: Problem,
    datum: str,
    state: State,
    eq: Equations,
    reduced: Reduced,
    Q: np.ndarray,
    move: Motions,
    sigma0_prior: float | None,
    status: str,
    history: History,
) -> Bundle:
    """Results in the order of the network; Q is a generalised inverse of S."""
    network, rays = problem.network, problem.rays
    redundancy, phi = problem.redundancy(move.number), history.objective[-1]
    sigma0 = np.sqrt(phi / redundancy) if redundancy else np.nan
    variance = (sigma0 if redundancy else sigma0_prior or np.nan) ** 2
    unit = sigma0_prior or sigma0 or np.inf

    # Image coordinates: residuals, redundancy numbers, testable shares
    of_points, QZ = reduced.cofactors(rays, Q)
    H = _of_rays(problem, eq, eq.A, Q, of_points, QZ)
    v, share, testable = eq.v, 1 - H, 1 - H
    if rays.rho is not None:
        across = _of_rays(problem, eq, eq.A[:, ::-1], Q, of_points, QZ).mean(axis=0)
        v = unwhiten(v, rays.rho)
        share, testable = shares(H, across, rays.rho)
    back = np.argsort(rays.order)
    v = (v / rays.per_sigma)[:, back].T
    share, testable = (np.ascontiguousarray(a[:, back].T) for a in (share, testable))
    v_alone = residuals_alone(v, network.sigma, network.correlation)

    # Cofactors in the datum
    of_kept = Q
    if move.number:
        R = datums.constraint(network, datum, move)
        of_kept, of_points = datums.s_transformation(reduced, Q, of_points, move, R)
    of_points[problem.held[:, None] | problem.held[None]] = 0

    # Control points, scale bars, check points
    v_control = _differences(state.points, network.control)
    sigma_control = share_control = np.zeros((0, 3))
    if network.control is not None:
        index, _, sigma = network.control
        sigma_control = np.where(sigma > 0, sigma, np.inf)
        cofactor = np.einsum("iin->ni", of_points)[index]
        free = np.isfinite(sigma_control)
        share_control = np.where(free, 1 - cofactor / sigma_control**2, 0)
    sigma_bars, v_bars, share_bars = network.scale_bars[:, 3], np.zeros(0), np.zeros(0)
    if (of_bars := problem.bars(state)) is not None and reduced.bars is not None:
        # 1 - (B Q Bᵀ) / sigma^2, where K^-1 = sigma^2 + B V^-1 Bᵀ
        v_bars, K, F = of_bars[1], reduced.bars.K, reduced.bars.F
        share_bars = sigma_bars**2 * np.diagonal(K - K @ F.T @ Q @ F @ K)
    if not redundancy:  # no observation is controlled: what is not 0 is rounding
        share, testable, share_control, share_bars = (
            np.zeros_like(one) for one in (share, testable, share_control, share_bars)
        )
    return Bundle(
        network=network,
        estimate=problem.estimate,
        datum=datum,
        cameras=refuse.cameras(network, state, status),
        exteriors=state.exteriors,
        points=state.points,
        sigma0=float(sigma0),
        sigma0_prior=sigma0_prior,
        redundancy=redundancy,
        residuals=v,
        redundancy_numbers=share,
        testable=testable,
        standardized=_standardized(v_alone, network.sigma_alone * unit, testable),
        control_residuals=v_control,
        control_redundancy_numbers=share_control,
        control_standardized=_standardized(
            v_control, sigma_control * unit, share_control
        ),
        scale_bar_residuals=v_bars,
        scale_bar_redundancy_numbers=share_bars,
        scale_bar_standardized=_standardized(v_bars, sigma_bars * unit, share_bars),
        check_differences=_differences(state.points, network.check),
        unknowns=kept_unknowns(network, problem.estimate),
        covariance=variance * of_kept,
        covariance_points=variance * np.moveaxis(of_points, -1, 0),
        status=status,
        iterations=len(history.step),
        history=history,
    )


def _of_rays(
    problem: Problem,
    eq: Equations,
    B: np.ndarray,
    Q: np.ndarray,
    points: np.ndarray,
    QZ: np.ndarray,
) -> np.ndarray:
    """Diagonal (2, k) of A Q Bᵀ for equations B, such as A, of the rays; any datum."""
    rays = problem.rays
    of_points = points.take(rays.point, axis=-1)
    by_point = np.einsum("irk,ijk->jrk", eq.point, of_points)
    by_point -= 2 * np.einsum("ark,ajk->jrk", eq.camera, QZ)
    found = np.einsum("jrk,jrk->rk", by_point, B[-3:])
    own = Q.take(rays.in_N)
    for photos, some in rays.stacks:
        QA = own[photos] @ by_photo(eq.camera[..., some], photos)
        A = by_photo(B[:-4, :, some], photos)
        AQA = np.einsum("pac,pac->pc", A, QA).reshape(len(A), 2, -1)
        found[:, some] += AQA.swapaxes(0, 1).reshape(2, -1)
    return found


def _standardized(v: np.ndarray, sigma: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Residuals over their standard deviations; 0 where nothing controls them."""
    controlled = share > UNCONTROLLED
    return np.where(
        controlled, v / (sigma * np.sqrt(np.where(controlled, share, 1))), 0
    )


def _differences(points: np.ndarray, given: tuple | None) -> np.ndarray:
    """Computed - given coordinates."""
    return np.zeros((0, 3)) if given is None else points[given[0]] - given[1]
