"""Bundle adjustment: Gauss-Newton with line search on the reduced normal equations."""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.linalg import lapack

from pgm_lab import _validate
from pgm_lab.adjustment import normal
from pgm_lab.adjustment.normal import ROUNDING, SMALLEST_STEP, SUFFICIENT_DECREASE
from pgm_lab.adjustment.result import History
from pgm_lab.bundle import refuse
from pgm_lab.bundle._assemble import assemble
from pgm_lab.bundle._coupling import flat
from pgm_lab.bundle._problem import Problem
from pgm_lab.bundle.datum import (
    Motions,
    check_constraint,
    constraint,
    free_motions,
)
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.rays import Equations, State
from pgm_lab.bundle.reduced import Reduced, points_alone, times_kept
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
        Interior parameters that are unknowns, from `camera.PARAMETERS`; () for none.
        The same for each camera; the others keep their values.
    datum : {"inner", "photos", "fixed", "none"}, optional
        "inner": inner constraints on the datum points (G of (M 2.95): seven, or six
        with scale bars), at the current points in each iteration. "photos": the same on
        the projection centres. "fixed": control points carry the datum. "none" only
        shows the rank defect. When missing: "fixed" if there are fixed or control
        points, else "inner".
    sigma0_prior : float, optional
        Standard deviation of unit weight before the adjustment; 1 if the sigmas of the
        network are trusted. Residuals are standardised by it (Baarda's w), and without
        it by the estimated sigma0 (Pope's tau).
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
    >>> from pgm_lab.bundle import published
    >>> found = adjust(published.network())
    >>> print(f"sigma0 {found.sigma0:.3f}, redundancy {found.redundancy}")
    sigma0 0.349, redundancy 693
    >>> print(f"c = {found.cameras[0].c:.3f} mm +- {found.sd_interior[0]:.4f} mm")
    c = 34.581 mm +- 0.0143 mm
    """
    problem = Problem.of(network, estimate, datum)
    sigma0_prior = _validate.standard_deviation(sigma0_prior, "sigma0_prior")
    line_search = _validate.flag(line_search, "line_search")
    progress = _validate.flag(progress, "progress")
    tolerance = _validate.positive_number(tolerance, "tolerance", "sd of an unknown")
    max_iterations = _validate.whole(max_iterations, "max_iterations", 1)
    state = problem.start
    refuse.check_counts(network)
    refuse.check_attitudes(network, state.exteriors)
    move = free_motions(network, state, problem.rays.interior)
    refuse.check_datum(network, problem.datum, move)
    check_constraint(network, problem.datum, move)
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
        reduced = problem.normal_equations(state, eq)
        dx, dx_points, decrease = _corrections(problem, state, reduced, move)
        sigma = sigma0_prior or np.sqrt(phi / max(redundancy, 1))
        changes.append(np.sqrt(decrease) / sigma if sigma > 0 else 0.0)
        rounding = _rounding(problem, state, reduced)
        slack = rounding * (2 * np.sqrt(phi) + rounding)
        step, found = _line_search(
            problem, state, phi, dx, dx_points, decrease, slack, line_search
        )
        steps.append(step)
        if found is None:
            status = "diverged"
            break
        state, eq, phi = found
        move = free_motions(network, state, problem.rays.interior)
        objectives.append(phi)
        if changes[-1] <= tolerance or decrease <= rounding**2:
            status = "converged"
            break
    else:
        reduced = problem.normal_equations(state, eq)
    history = History(*map(np.array, (objectives, steps, changes)))
    scale, factor = _factor(problem, state, reduced, move)
    Q = lapack.dpotrs(factor, np.diag(scale), lower=True)[0] * scale[:, None]
    return assemble(
        problem, state, eq, reduced, Q, move, phi, sigma0_prior, status, history
    )


def _corrections(
    problem: Problem, state: State, reduced: Reduced, move: Motions
) -> tuple[np.ndarray, np.ndarray, float]:
    """Gauss-Newton step of kept unknowns and points, and dx'N dx."""
    refuse.check_points(problem.network, reduced)
    scale, factor = _factor(problem, state, reduced, move)
    dx = scale * lapack.dpotrs(factor, scale * reduced.right, lower=True)[0]
    dx_points = points_alone(reduced)
    decrease = reduced.right @ dx + np.vdot(reduced.n_point, dx_points)
    dx_points = dx_points - times_kept(reduced, dx[:, None])[0]
    if move.number:
        R = constraint(problem.network, problem.datum, move)
        t = R.kept.T @ dx + flat(R.points) @ dx_points.ravel()
        dx = dx - move.kept @ t
        dx_points = dx_points - (t @ flat(move.points)).reshape(dx_points.shape)
    return dx, dx_points, max(float(decrease), 0.0)


def _factor(
    problem: Problem, state: State, reduced: Reduced, move: Motions
) -> tuple[np.ndarray, np.ndarray]:
    """Scale, and Cholesky factor of the scaled S, made regular along the free motions.

    S has no value for a motion; E Eᵀ gives it one, since the columns of E are the
    motions. The solution does not notice, and the inverse is one of the generalised
    ones: they differ only by motions, which the S-transformation takes away.
    """
    scale = 1 / np.sqrt(np.where(reduced.diagonal > 0, reduced.diagonal, 1.0))
    E = move.kept / scale[:, None]
    E /= np.sqrt(np.einsum("ud,ud->d", E, E))
    scaled = reduced.S * scale[:, None] * scale + E @ E.T
    factor, failed = lapack.dpotrf(scaled, lower=True)
    pivots = np.diagonal(factor) ** 2
    regular = not failed and pivots.min(initial=1.0) > 1 / normal.INFLATION_LIMIT
    if not regular:
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
    wanted: bool,
) -> tuple[float, tuple[State, Equations, float] | None]:
    """Halve the step until vᵀPv falls enough: the step, and what is there.

    It is 0, and there is nothing, if vᵀPv never falls.
    """
    step = 1.0
    while step >= SMALLEST_STEP:
        there = problem.moved(state, step * dx, step * dx_points)
        eq = problem.equations(there)
        after = problem.objective(there, eq.v)
        goal = phi - 2 * SUFFICIENT_DECREASE * step * decrease + slack
        if after <= goal or (not wanted and np.isfinite(after)):
            return step, (there, eq, after)
        if not wanted:
            break
        step /= 2
    return 0.0, None


def _counted(iterations: int, progress: bool) -> Iterable[int]:
    if not progress:
        return range(iterations)
    from tqdm.auto import tqdm

    bar = {"desc": "bundle adjustment", "unit": " iterations", "leave": False}
    return tqdm(range(iterations), delay=1.0, **bar)  # seconds; a short one needs none
