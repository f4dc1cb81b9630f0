"""Least squares adjustment in the Gauss-Markov model: one core for the whole workbook.

Observation equations ``l + v = f(x)`` with ``vᵀPv`` least; v = computed - observed. One
problem or a stack of thousands is the same call: leading axes count the problems.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import _model, normal
from pgm_lab.adjustment._gauss_newton import State, iterate
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

    Each iteration solves the normal equations ``AᵀPA dx = -AᵀPv``, column by column
    scaled, and halves the step until vᵀPv falls. It ends when no parameter changes by
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
        1/sigma^2 of trusted sigmas. Residuals are standardised by it (Baarda's w).
        Without it there is no global test, and residuals are standardised by the
        estimated sigma0 (Pope's tau).
    parameter_weights : array_like (..., u), optional
        Weights of parameters that were observed too; 0 for free ones.
    parameter_values : array_like (..., u), optional
        Their observed values; the start values when missing.
    constraints : callable, optional
        ``constraints(x, *args)`` returns values c (..., k) that are to be 0, and their
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
    (M 2.68), whose e is -v; (M 2.69) to (M 2.76), with weights of parameters as in
    (M 2.71) to (M 2.74); (B 2.14a) to (B 2.14e); (B 6) to (B 8), without weights.

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
    _validate.function(function, "function")
    if constraints is not None:
        _validate.function(constraints, "constraints")
    line_search = _validate.flag(line_search, "line_search")
    max_iterations = _validate.whole(max_iterations, "max_iterations", 1)
    start = _validate.finite(start, "start")
    if start.ndim == 0 or start.shape[-1] == 0:
        raise ValueError(
            f"start must have shape (..., u), u parameters; got {start.shape}"
        )
    *lead, u = start.shape
    names = normal.parameter_names(names, u)
    sigma0_prior = _validate.standard_deviation(sigma0_prior, "sigma0_prior")
    tolerance = _validate.positive_number(tolerance, "tolerance", "parameter's sd")
    model = _model.model(
        function, start, observations, weights, covariance, constraints, args
    )
    if parameter_weights is not None:
        model = _model.with_parameters(
            model, start, parameter_weights, parameter_values
        )
    elif parameter_values is not None:
        raise ValueError("parameter_values need parameter_weights")
    state = State.at(model, np.array(start.reshape(math.prod(lead), u)))
    if model.single and not state.is_finite()[0]:
        raise ValueError(
            "function or constraints return values or derivatives that are not finite"
            " at the start values"
        )
    status, iterations, history = iterate(
        model, state, sigma0_prior, line_search, tolerance, max_iterations
    )
    Q = _cofactors(model, state, status, names)
    numbers = _numbers(model, state, Q, sigma0_prior)
    numbers |= {"status": status, "iterations": iterations}
    return Adjustment(
        **{
            name: values.reshape((*lead, *values.shape[1:]))[()]
            for name, values in numbers.items()
        },
        sigma0_prior=sigma0_prior,
        names=names,
        history=History(*(part.reshape((len(part), *lead)) for part in history)),
    )


def _cofactors(
    model: _model.Model, state: State, status: np.ndarray, names: Sequence[str]
) -> np.ndarray:
    """Cofactors Q of the parameters; a singular problem gets its status, and NaN."""
    N = np.swapaxes(state.A, -1, -2) @ model.weighted(state.A)
    _, Q, _, singular = normal.solve(N, np.zeros_like(state.x), state.C, state.c)
    singular &= status != "diverged"
    if model.single and singular[0]:
        raise RankDefect(normal.null_space(N[0], names, state.C[0]))
    status[singular] = "singular"
    for values in (state.x, state.v, state.phi):
        values[singular] = np.nan
    return Q


def _numbers(
    model: _model.Model, state: State, Q: np.ndarray, sigma0_prior: float | None
) -> dict[str, np.ndarray]:
    """What the adjustment says of its parameters and observations, by name."""
    m, u = state.x.shape
    redundancy = model.redundancy(u, state.c.shape[-1])
    phi = np.where(np.isfinite(state.phi), state.phi, np.nan)
    sigma0 = np.sqrt(phi / np.where(redundancy > 0, redundancy, np.nan))
    share, w = residual_statistics(state.A, state.v, model.weights, Q)
    w = w / (sigma0_prior or np.where(sigma0 > 0, sigma0, np.inf)[:, None])
    n = state.v.shape[-1] - u * model.weighted_parameters
    v_parameters, share_parameters = np.zeros((2, m, u))
    if model.weighted_parameters:
        v_parameters, share_parameters = state.v[:, n:], share[:, n:]
    return {
        "x": state.x,
        "cofactor": Q,
        "residuals": state.v[:, :n],
        "sigma0": sigma0,
        "redundancy": redundancy,
        "redundancy_numbers": share[:, :n],
        "standardized": w[:, :n],
        "parameter_residuals": v_parameters,
        "parameter_redundancy_numbers": share_parameters,
    }
