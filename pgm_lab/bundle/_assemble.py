"""From the solution of the normal equations to the result of a bundle adjustment."""

import numpy as np

from pgm_lab.adjustment.result import UNCONTROLLED, History
from pgm_lab.bundle import _correlated
from pgm_lab.bundle._problem import Problem
from pgm_lab.bundle.covariance import bars_redundancy, cofactors
from pgm_lab.bundle.datum import Motions, constraint
from pgm_lab.bundle.rays import Equations, State
from pgm_lab.bundle.reduced import Reduced
from pgm_lab.bundle.refuse import cameras
from pgm_lab.bundle.result import Bundle, kept_unknowns


def assemble(
    problem: Problem,
    state: State,
    eq: Equations,
    reduced: Reduced,
    Q: np.ndarray,
    move: Motions,
    phi: float,
    sigma0_prior: float | None,
    status: str,
    history: History,
) -> Bundle:
    """Covariances, tests, and everything in the order of the network.

    Parameters
    ----------
    Q : ndarray (U + 6 m, U + 6 m)
        Generalised inverse of S.
    move : Motions
        The motions that the observations leave free.
    phi : float
        vᵀPv.
    """
    network, rays = problem.network, problem.rays
    R = constraint(network, problem.datum, move) if move.number else None
    found = cofactors(rays, eq, reduced, Q, move, R)
    held = network.held.T
    found.points[held[:, None] | held[None]] = 0

    redundancy = problem.redundancy(move.number)
    sigma0 = np.sqrt(phi / redundancy) if redundancy else np.nan
    variance = (sigma0 if redundancy else sigma0_prior or np.nan) ** 2
    unit = sigma0_prior or sigma0 or np.inf
    back = np.argsort(rays.order)
    v, share, testable = eq.v, 1 - found.rays, 1 - found.rays
    if rays.rho is not None and found.across is not None:
        v = _correlated.coloured(v, rays.rho)
        share, testable = _correlated.shares(found.rays, found.across, rays.rho)
    v = (v / rays.per_sigma)[:, back].T
    share, testable = (np.ascontiguousarray(a[:, back].T) for a in (share, testable))
    v_alone = _correlated.alone(v, network.sigma, network.correlation)
    v_control = _differences(state.points, network.control)
    sigma_control, share_control = _of_control(network.control, found.points)
    bars = network.scale_bars
    of_bars = problem.bars(state)
    v_bars = np.zeros(0) if of_bars is None else of_bars[1]
    share_bars = bars_redundancy(reduced, Q, bars[:, 3])
    if not redundancy:  # no observation is controlled: what is not 0 is rounding
        share, testable, share_control, share_bars = (
            np.zeros_like(one) for one in (share, testable, share_control, share_bars)
        )
    return Bundle(
        network=network,
        estimate=problem.estimate,
        datum=problem.datum,
        cameras=cameras(network, state, status),
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
        scale_bar_standardized=_standardized(v_bars, bars[:, 3] * unit, share_bars),
        check_differences=_differences(state.points, network.check),
        unknowns=kept_unknowns(network, problem.estimate),
        covariance=variance * found.kept,
        covariance_points=variance * np.moveaxis(found.points, -1, 0),
        status=status,
        iterations=len(history.step),
        history=history,
    )


def _of_control(
    control: tuple | None, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sigma of control coordinates (q, 3), inf if held, and their redundancy numbers.

    `points` (3, 3, n) are the cofactors of the points.
    """
    if control is None:
        return np.zeros((0, 3)), np.zeros((0, 3))
    index, _, sigma = control
    sigma = np.where(sigma > 0, sigma, np.inf)
    cofactor = np.einsum("iin->ni", points)[index]
    return sigma, np.where(np.isfinite(sigma), 1 - cofactor / sigma**2, 0)


def _standardized(v: np.ndarray, sigma: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Residuals over their standard deviations; 0 where nothing controls them."""
    controlled = share > UNCONTROLLED
    return np.where(
        controlled, v / (sigma * np.sqrt(np.where(controlled, share, 1))), 0
    )


def _differences(points: np.ndarray, given: tuple | None) -> np.ndarray:
    """Computed - given coordinates."""
    return np.zeros((0, 3)) if given is None else points[given[0]] - given[1]
