"""Least squares adjustment in the Gauss-Markov model: one core for the whole workbook.

Observation equations ``l + v = f(x)`` with ``vᵀPv`` least; v = computed - observed. One
problem or a stack of thousands is the same call: leading axes count the problems.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import normal
from pgm_lab.adjustment.normal import (
    ROUNDING,
    SMALLEST_STEP,
    SUFFICIENT_DECREASE,
    RankDefect,
)
from pgm_lab.adjustment.result import Adjustment, History, residual_statistics


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
        Standard deviation of unit weight beforehand; 1 if the weights are 1/sigma^2 of
        trusted sigmas. It allows the global test, and standardises residuals to
        Baarda's w; without it they are Pope's tau, by the estimated sigma0.
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
        If shapes do not fit, weights are negative, covariances not positive definite,
        or values at the start not finite (in a stack: status "diverged").
    RankDefect
        If parameters are undetermined, which the message names, or constraints depend
        on each other (in a stack: status "singular").

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
    sigma0_prior = _validate.standard_deviation(sigma0_prior, "sigma0_prior")
    tolerance = _validate.positive_number(tolerance, "tolerance", "parameter's sd")
    start = _validate.finite(start, "start")
    if start.ndim == 0 or start.shape[-1] == 0:
        raise ValueError(
            f"start must have shape (..., u), u parameters; got {start.shape}"
        )
    *lead, u = start.shape
    names = normal.parameter_names(names, u)

    # Observation equations, the stack along one axis
    model = _model(
        function, start, observations, weights, covariance, constraints, args
    )
    if parameter_weights is not None:
        model = _with_parameters(model, start, parameter_weights, parameter_values)
    elif parameter_values is not None:
        raise ValueError("parameter_values need parameter_weights")
    state = State.at(model, np.array(start.reshape(math.prod(lead), u)))
    if model.single and not state.is_finite()[0]:
        raise ValueError(
            "function or constraints return values or derivatives that are not finite"
            " at the start values"
        )

    # Gauss-Newton iterations
    status, iterations, history = _iterate(
        model, state, sigma0_prior, line_search, tolerance, max_iterations
    )

    # Precision and reliability
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


# --- Observation equations ---


@dataclass(frozen=True)
class Model:
    """Observation equations l + v = f(x) of m problems, with weights P.

    `weights` is (m, n) or, with correlated observations, (m, n, n). A single problem
    calls `function` and `constraints` without the leading axis.
    """

    function: Callable
    constraints: Callable | None
    args: tuple[Any, ...]
    observations: np.ndarray
    weights: np.ndarray
    single: bool
    weighted_parameters: bool = False

    def part(self, k: np.ndarray) -> "Model":
        """Return the problems k alone."""
        if self.single:
            return self
        return replace(
            self,
            args=tuple(arg[k] for arg in self.args),
            observations=self.observations[k],
            weights=self.weights[k],
        )

    def equations(self, x: np.ndarray) -> tuple[np.ndarray, ...]:
        """Residuals v, design matrices A, constraints c and their Jacobians C at x."""
        computed, A = self._call(self.function, "function", x)
        if self.weighted_parameters:
            unit = np.broadcast_to(np.eye(x.shape[-1]), (*x.shape, x.shape[-1]))
            computed = np.concatenate([computed, x], axis=-1)
            A = np.concatenate([A, unit], axis=-2)
        if computed.shape[-1] != self.observations.shape[-1]:
            raise ValueError(
                f"function computes {computed.shape[-1]} values for"
                f" {self.observations.shape[-1]} observations"
            )
        v = computed - self.observations
        if self.constraints is None:
            return v, A, v[:, :0], A[:, :0]
        return v, A, *self._call(self.constraints, "constraints", x)

    def _call(
        self, function: Callable, name: str, x: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Values (m, n) and Jacobian (m, n, u) of a function of the caller."""
        answer = function(x[0] if self.single else x, *self.args)
        if not isinstance(answer, tuple | list) or len(answer) != 2:
            raise ValueError(
                f"{name} must return two arrays: values and their Jacobian"
            )
        values, jacobian = (_validate.real(part, name) for part in answer)
        values = np.atleast_1d(values)
        shape = (len(x), values.shape[-1], x.shape[-1])
        lead = () if self.single else shape[:1]
        try:
            values = np.broadcast_to(values, shape[:-1])
        except ValueError:
            raise ValueError(
                f"{name} must return values {(*lead, 'n')}; got shape {values.shape}"
            ) from None
        if jacobian.shape not in (shape[1:], (1, *shape[1:]), shape):
            raise ValueError(
                f"{name} must return a Jacobian {(*lead, *shape[1:])}, a row for each"
                f" value and a column for each parameter; got shape {jacobian.shape}"
            )
        # A value whose derivative is missing is of no use
        finite = np.isfinite(jacobian).all(axis=(-2, -1))
        values = np.where(finite[..., None], values, np.nan)
        return values, np.array(np.broadcast_to(jacobian, shape))

    def weighted(self, matrix: np.ndarray) -> np.ndarray:
        """P times a matrix (m, n, u)."""
        P = self.weights
        return P[..., None] * matrix if P.ndim == 2 else P @ matrix

    def objective(self, v: np.ndarray) -> np.ndarray:
        """vᵀPv of each problem; not finite where a residual is not."""
        with np.errstate(invalid="ignore", over="ignore"):
            return np.einsum("mn,mn->m", v, self.weighted(v[..., None])[..., 0])

    def redundancy(self, unknowns: int, constraints: int) -> np.ndarray:
        """Observations made, minus unknowns, plus constraints, of each problem."""
        P = self.weights
        diagonal = P if P.ndim == 2 else np.diagonal(P, axis1=-2, axis2=-1)
        return np.count_nonzero(diagonal > 0, axis=-1) - unknowns + constraints


def _model(
    function: Callable,
    start: np.ndarray,
    observations: ArrayLike,
    weights: ArrayLike | None,
    covariance: ArrayLike | None,
    constraints: Callable | None,
    args: Sequence[ArrayLike],
) -> Model:
    """Validate the observations, and lay the leading axes into one."""
    lead = start.shape[:-1]
    observations = _validate.finite(observations, "observations")
    if observations.ndim == 0:
        raise ValueError("observations must have shape (..., n); got a single number")
    n = observations.shape[-1]
    observations = _flat(observations, "observations", lead, n)
    if covariance is None:
        P = _weights(1.0 if weights is None else weights, "weights", lead, n)
    elif weights is None:
        P = _flat(_inverse_covariance(covariance, n), "covariance", lead, n, n)
    else:
        raise ValueError("give weights or covariance, not both")
    args = tuple(args)
    if lead:
        args = tuple(_flat_argument(arg, lead) for arg in args)
    return Model(function, constraints, args, observations, P, single=not lead)


def _with_parameters(
    model: Model, start: np.ndarray, weights: ArrayLike, values: ArrayLike | None
) -> Model:
    """Append the weighted parameters to the observations, (M 2.71) to (M 2.74)."""
    lead, u = start.shape[:-1], start.shape[-1]
    values = start if values is None else values
    values = _flat(values, "parameter_values", lead, u)
    weights = _weights(weights, "parameter_weights", lead, u)
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


def _flat(
    values: ArrayLike, name: str, lead: tuple[int, ...], *shape: int
) -> np.ndarray:
    """Broadcast to all problems, and lay the leading axes into one."""
    array = _validate.finite(values, name)
    try:
        array = np.broadcast_to(array, (*lead, *shape))
    except ValueError:
        raise ValueError(
            f"{name} must have shape {shape}"
            + (f", or with a stack {(*lead, *shape)}" if lead else "")
            + f"; got {array.shape}"
        ) from None
    return array.reshape(math.prod(lead), *shape)


def _weights(values: ArrayLike, name: str, lead: tuple[int, ...], n: int) -> np.ndarray:
    weights = _flat(values, name, lead, n)
    if np.any(weights < 0):
        raise ValueError(f"{name} must not be negative")
    return weights


def _flat_argument(arg: ArrayLike, lead: tuple[int, ...]) -> np.ndarray:
    arg = np.asarray(arg)
    if arg.shape[: len(lead)] != lead:
        raise ValueError(
            f"args must have the leading axes {lead} of the start values; got shape"
            f" {arg.shape}. Put what all problems share into the function itself"
        )
    return arg.reshape(math.prod(lead), *arg.shape[len(lead) :])


def _inverse_covariance(covariance: ArrayLike, n: int) -> np.ndarray:
    """P = C^-1, by the correlation matrix, so that units do not matter."""
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
            "covariance must be positive definite: an observation that follows from"
            " others must not be counted twice"
        )
    return np.linalg.inv((correlation + transposed) / 2) / scale


# --- Gauss-Newton iterations with line search ---


class State(NamedTuple):
    """Parameters and equations of a stack: changed in place, problem by problem."""

    x: np.ndarray
    v: np.ndarray
    A: np.ndarray
    c: np.ndarray
    C: np.ndarray
    phi: np.ndarray  # vᵀPv

    @classmethod
    def at(cls, model: Model, x: np.ndarray) -> "State":
        """Set up the equations at x."""
        v, A, c, C = model.equations(x)
        return cls(x, v, A, c, C, model.objective(v))

    def part(self, k: np.ndarray) -> "State":
        """Copy of the problems k."""
        return State(*(values[k] for values in self))

    def put(self, k: np.ndarray, other: "State") -> None:
        """Overwrite the problems k."""
        for values, new in zip(self, other, strict=True):
            values[k] = new

    def is_finite(self) -> np.ndarray:
        """Whether the values of each problem can be computed."""
        return np.isfinite(self.phi) & np.isfinite(self.c).all(axis=-1)

    def merit(self, penalty: np.ndarray) -> np.ndarray:
        """What the line search lowers: vᵀPv, with a penalty on open constraints."""
        return self.phi + penalty * np.abs(self.c).sum(axis=-1)


def _iterate(
    model: Model,
    state: State,
    sigma0_prior: float | None,
    line_search: bool,
    tolerance: float,
    max_iterations: int,
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, ...]]:
    """Iterate each problem to its end: statuses, iterations, columns of the history."""
    m, u = state.x.shape
    redundancy = model.redundancy(u, state.c.shape[-1])
    level = np.sqrt(model.objective(model.observations))
    search = _line_search if line_search else _full_step
    usable = state.is_finite()
    status = np.where(usable, "too many iterations", "diverged")
    iterations = np.zeros(m, int)
    objective = [state.phi.copy()]
    steps: list[np.ndarray] = []
    changes: list[np.ndarray] = []
    k = np.flatnonzero(usable)  # the problems that still iterate
    while len(k) and len(steps) < max_iterations:
        # Normal equations N = AᵀPA, n = -AᵀPv of (M 2.76), whose f is -v
        active, here = model.part(k), state.part(k)
        PA = active.weighted(here.A)
        N = np.swapaxes(here.A, -1, -2) @ PA
        n = -np.einsum("mnu,mn->mu", PA, here.v)
        dx, Q, correlates, singular = normal.solve(N, n, here.C, here.c)
        dx[singular], correlates[singular] = 0, 0  # they stay; `_cofactors` names them

        # Largest change of a parameter in its standard deviations
        sigma = sigma0_prior or np.sqrt(here.phi / np.maximum(redundancy[k], 1))
        change = _in_standard_deviations(dx, Q, sigma)

        # How much vᵀPv would fall, were f linear, and how well it is known: a fall
        # below `slack` cannot be seen
        decrease = np.einsum("mu,muw,mw->m", dx, N, dx)
        penalty = 4 * np.max(np.abs(correlates), axis=-1, initial=0)  # an exact one
        rounding = _rounding(here.x, N, level[k])
        closing = _closing_error(here.C, N, rounding)
        slack = rounding * (2 * np.sqrt(here.phi) + rounding)
        slack += penalty * closing.sum(axis=-1)
        there, step = search(active, here, dx, decrease, penalty, slack)
        step[singular] = 0

        # Without errors in the observations the standard deviations fall to zero: then
        # the end is reached when a step changes nothing above the rounding of numbers.
        # A step that only closes constraints, such as a change of datum, lowers no vᵀPv
        closed = np.all(np.abs(here.c) <= closing, axis=-1)
        converged = (change <= tolerance) | ((decrease <= rounding**2) & closed)
        moved = step > 0
        state.put(k[moved], there.part(moved))
        status[k[moved & converged]] = "converged"
        status[k[~moved & ~singular]] = "diverged"
        iterations[k] += 1
        objective.append(state.phi.copy())
        for history, values in ((steps, step), (changes, change)):
            history.append(np.zeros(m))
            history[-1][k] = values
        k = k[moved & ~converged]
    shape = (len(steps), m)
    columns = np.array(objective), np.reshape(steps, shape), np.reshape(changes, shape)
    return status, iterations, columns


def _in_standard_deviations(
    dx: np.ndarray, Q: np.ndarray, sigma: float | np.ndarray
) -> np.ndarray:
    """Largest component of dx over its standard deviation; 0 where nothing moves."""
    sd = np.sqrt(np.abs(np.diagonal(Q, axis1=-2, axis2=-1))) * np.expand_dims(sigma, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.max(np.where(dx != 0, np.abs(dx) / sd, 0), axis=-1)


def _rounding(x: np.ndarray, N: np.ndarray, level: np.ndarray) -> np.ndarray:
    """What the rounding of numbers does to v over sigma: observations, parameters."""
    size = np.sqrt(np.diagonal(N, axis1=-2, axis2=-1)) * np.abs(x)
    return ROUNDING * (level + size.max(axis=-1))


def _closing_error(C: np.ndarray, N: np.ndarray, rounding: np.ndarray) -> np.ndarray:
    """Misclosures of the constraints (m, k) that the rounding of numbers explains."""
    error = rounding[:, None] * normal.column_scale(N)
    return np.einsum("mku,mu->mk", np.abs(C), error)


def _line_search(
    model: Model,
    here: State,
    dx: np.ndarray,
    decrease: np.ndarray,
    penalty: np.ndarray,
    slack: np.ndarray,
) -> tuple[State, np.ndarray]:
    """Halve each step until the merit falls enough; 0 for the one where none does."""
    step = np.ones(len(dx))
    there = State.at(model, here.x + dx)
    before = here.merit(penalty)

    def too_high() -> np.ndarray:
        goal = before - 2 * SUFFICIENT_DECREASE * step * decrease + slack
        return ~(there.merit(penalty) <= goal)

    while np.any(long := too_high() & (step > SMALLEST_STEP)):
        step[long] /= 2
        x = here.x[long] + step[long, None] * dx[long]
        there.put(long, State.at(model.part(long), x))
    return there, np.where(too_high(), 0, step)


def _full_step(
    model: Model, here: State, dx: np.ndarray, *_: np.ndarray
) -> tuple[State, np.ndarray]:
    """Step 1 wherever it leads, unless there is nothing to compute there."""
    there = State.at(model, here.x + dx)
    return there, there.is_finite().astype(float)


# --- Precision and reliability ---


def _cofactors(
    model: Model, state: State, status: np.ndarray, names: Sequence[str]
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
    model: Model, state: State, Q: np.ndarray, sigma0_prior: float | None
) -> dict[str, np.ndarray]:
    """Parameters, sigma0, residuals and their tests, as `Adjustment` names them."""
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
