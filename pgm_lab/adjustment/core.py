"""Least squares adjustment in the Gauss-Markov model: one core for the whole workbook.

Observation equations ``l + v = f(x)`` with ``v'Pv`` least; v = computed - observed. One
problem or a stack of thousands is the same call: leading axes count the problems.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import _gauss_newton, normal
from pgm_lab.adjustment.normal import RankDefect
from pgm_lab.adjustment.result import (
    Adjustment,
    GlobalTest,
    History,
    residual_statistics,
)

__all__ = ["Adjustment", "GlobalTest", "History", "RankDefect", "adjust"]


def adjust(
    function: Callable,
    start: ArrayLike,
    observations: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    covariance: ArrayLike | None = None,
    sigma0_prior: float | None = None,
    parameter_weights: ArrayLike | None = None,
    parameter_values: ArrayLike | None = None,
    constraints: Callable | None = None,
    args: Sequence[ArrayLike] = (),
    names: Sequence[str] | None = None,
    line_search: bool = True,
    tolerance: float = 1e-6,
    max_iterations: int = 50,
) -> Adjustment:
    """Adjust observations by least squares, one problem or a stack of them.

    Each iteration solves the normal equations ``A'PA dx = -A'Pv``, column by column
    scaled, and halves the step until v'Pv falls. It ends when no parameter changes by
    more than `tolerance` of its standard deviation.

    Parameters
    ----------
    function : callable
        ``function(x, *args)`` returns the computed observations (..., n) and their
        Jacobian (..., n, u), or (n, u) for all problems alike. For a stack it is called
        with x (k, u) and args of the k problems that still iterate.
    start : array_like (..., u)
        Start values of the parameters; leading axes count the problems.
    observations : array_like (..., n)
        The observations l.
    weights : array_like (..., n), optional
        Weights P, 1 when missing; 0 for an observation that was not made.
    covariance : array_like (..., n, n), optional
        Instead of weights: covariance of the observations, then P is its inverse.
    sigma0_prior : float, optional
        Standard deviation of unit weight before the adjustment; 1 if the weights are
        1/sigma^2 of trusted sigmas. Without it there is no global test, and residuals
        are standardised by the estimated sigma0.
    parameter_weights : array_like (..., u), optional
        Weights of parameters that were observed too; 0 for free ones.
    parameter_values : array_like (..., u), optional
        Their observed values; the start values when missing.
    constraints : callable, optional
        ``constraints(x, *args)`` returns values c (..., k) that shall be zero and their
        Jacobian C (..., k, u). Inner constraints of a free network return zeros for c.
    args : sequence of array_like
        Further arguments of `function` with the leading axes of the stack.
    names : sequence of str, optional
        Names of the parameters, for messages.
    line_search : bool
        False takes full steps, to see why one does not.
    tolerance : float
        Change of a parameter, in its standard deviations, that is negligible.
    max_iterations : int
        Most iterations for a problem.

    Returns
    -------
    Adjustment

    Raises
    ------
    ValueError
        If shapes do not fit, numbers are not finite, weights are negative, covariances
        not positive definite, or a single problem computes values at the start that are
        not finite. In a stack such a problem gets the status "diverged".
    RankDefect
        If a single problem leaves parameters undetermined, as fewer observations than
        unknowns do, or its constraints depend on each other; the message names the
        parameters. In a stack such a problem gets the status "singular".

    References
    ----------
    Muliawan 2013, (2.68), whose e is -v, (2.69), (2.75), (2.76); Bani 2010, appendix B
    (6) to (8), without weights.

    Examples
    --------
    A distance measured three times, the last time twice as precisely:

    >>> def mean(x):
    ...     return np.full(3, x[0]), np.ones((3, 1))
    >>> found = adjust(mean, [0.0], [10.02, 10.06, 10.01], weights=[1, 1, 4])
    >>> f"{found.x[0]:.3f} +- {found.sd[0]:.3f}, redundancy {found.redundancy}"
    '10.020 +- 0.013, redundancy 2'
    >>> found.redundancy_numbers.round(3)
    array([0.833, 0.833, 0.333])
    """
    start = _validate.finite(start, "start")
    if start.ndim == 0 or start.shape[-1] == 0:
        raise ValueError(
            f"start must have shape (..., u), u parameters; got {start.shape}"
        )
    *lead, u = start.shape
    names = normal.parameter_names(names, u)
    sigma0_prior = _validate.standard_deviation(sigma0_prior, "sigma0_prior")
    tolerance = float(_validate.positive(tolerance, "tolerance", "sd of a parameter"))
    model = _model(
        function, start, observations, weights, covariance, constraints, args
    )
    if parameter_weights is not None:
        model = _with_parameters(model, start, parameter_weights, parameter_values)
    elif parameter_values is not None:
        raise ValueError("parameter_values need parameter_weights")
    x = start.reshape(math.prod(lead), u)
    state, status, iterations, history, redundancy = _gauss_newton.iterate(
        model, x, sigma0_prior, line_search, tolerance, max_iterations
    )
    if not lead and status[0] == "diverged" and not iterations[0]:
        raise ValueError(
            "function or constraints return values or derivatives that are not finite"
            " at the start values"
        )
    everything = np.arange(len(x))
    N = np.swapaxes(state.A, -1, -2) @ model.weighted(state.A, everything)
    _, Q, _, singular = normal.solve(N, np.zeros_like(x), state.C, state.c)
    singular &= status != "diverged"
    if not lead and singular[0]:
        raise RankDefect(normal.null_space(N[0], names, state.C[0]))
    status[singular] = "singular"
    phi = model.objective(state.v, everything)
    state.x[singular], state.v[singular], phi[singular] = np.nan, np.nan, np.nan
    phi[~np.isfinite(phi)] = np.nan
    sigma0 = np.sqrt(phi / np.where(redundancy > 0, redundancy, np.nan))
    share, w = residual_statistics(state.A, state.v, model.weights, Q)
    w = w / (sigma0_prior or np.where(sigma0 > 0, sigma0, np.inf)[:, None])
    n = state.v.shape[-1] - u * model.weighted_parameters
    v_parameters, share_parameters = np.zeros((2, *x.shape))
    if model.weighted_parameters:
        v_parameters, share_parameters = state.v[:, n:], share[:, n:]
    whole = dict(
        x=state.x,
        cofactor=Q,
        residuals=state.v[:, :n],
        sigma0=sigma0,
        redundancy=redundancy,
        redundancy_numbers=share[:, :n],
        standardized=w[:, :n],
        parameter_residuals=v_parameters,
        parameter_redundancy_numbers=share_parameters,
        status=status,
        iterations=iterations,
    )
    shaped = {
        name: values.reshape((*lead, *values.shape[1:]))[()]
        for name, values in whole.items()
    }
    history = History(*(part.reshape((len(part), *lead)) for part in history))
    return Adjustment(**shaped, sigma0_prior=sigma0_prior, names=names, history=history)


def _model(
    function, start, observations, weights, covariance, constraints, args
) -> _gauss_newton.Model:
    """Check what was handed over, and lay the leading axes into one."""
    lead = start.shape[:-1]
    observations = _validate.finite(observations, "observations")
    if observations.ndim == 0:
        raise ValueError("observations must have shape (..., n); got one number")
    n = observations.shape[-1]
    observations = _flat(observations, "observations", lead, n)
    if covariance is not None:
        if weights is not None:
            raise ValueError("give weights or covariance, not both")
        weights = _inverse_covariance(covariance, n)
        weights = _flat(weights, "covariance", lead, n, n)
    else:
        weights = _flat(1.0 if weights is None else weights, "weights", lead, n)
        if np.any(weights < 0):
            raise ValueError("weights must not be negative")
    if lead:
        args = tuple(_flat_argument(arg, lead) for arg in args)
    return _gauss_newton.Model(
        function, observations, weights, constraints, False, tuple(args), not lead
    )


def _flat(values, name, lead, *shape) -> np.ndarray:
    """Broadcast to all problems, and lay the leading axes into one."""
    values = _validate.finite(values, name)
    try:
        values = np.broadcast_to(values, (*lead, *shape))
    except ValueError:
        raise ValueError(
            f"{name} must have shape {shape}"
            + (f", or with a stack {(*lead, *shape)}" if lead else "")
            + f"; got {values.shape}"
        ) from None
    return values.reshape(math.prod(lead), *shape)


def _flat_argument(arg, lead) -> np.ndarray:
    arg = np.asarray(arg)
    if arg.shape[: len(lead)] != lead:
        raise ValueError(
            f"args must have the leading axes {lead} of the start values;"
            f" got shape {arg.shape}. What all problems share goes into function itself"
        )
    return arg.reshape(math.prod(lead), *arg.shape[len(lead) :])


def _inverse_covariance(covariance, n) -> np.ndarray:
    covariance = _validate.finite(covariance, "covariance")
    if covariance.shape[-2:] != (n, n):
        raise ValueError(
            f"covariance must have shape (..., {n}, {n}); got {covariance.shape}"
        )
    variance = np.diagonal(covariance, axis1=-2, axis2=-1)
    if np.any(variance <= 0):
        raise ValueError("covariance must have positive variances on its diagonal")
    sd = np.sqrt(variance)
    scale = sd[..., :, None] * sd[..., None, :]
    correlation = covariance / scale
    transposed = np.swapaxes(correlation, -1, -2)
    if np.any(np.abs(correlation - transposed) > 1e-10):
        raise ValueError("covariance must be symmetric")
    if np.any(np.linalg.eigvalsh(correlation)[..., 0] < 1 / normal.INFLATION_LIMIT):
        raise ValueError(
            "covariance must be positive definite; an observation that follows from"
            " others may not be counted twice"
        )
    return np.linalg.inv((correlation + transposed) / 2) / scale


def _with_parameters(model, start, weights, values) -> _gauss_newton.Model:
    """Append the weighted parameters to the observations."""
    u = start.shape[-1]
    lead = start.shape[:-1]
    values = _flat(start if values is None else values, "parameter_values", lead, u)
    weights = _flat(weights, "parameter_weights", lead, u)
    if np.any(weights < 0):
        raise ValueError("parameter_weights must not be negative")
    P = model.weights
    if P.ndim == 2:
        P = np.concatenate([P, weights], axis=1)
    else:
        n = P.shape[-1]
        P = np.pad(P, [(0, 0), (0, u), (0, u)])
        P[:, range(n, n + u), range(n, n + u)] = weights
    return replace(
        model,
        observations=np.concatenate([model.observations, values], axis=1),
        weights=P,
        weighted_parameters=True,
    )
