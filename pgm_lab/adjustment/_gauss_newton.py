"""The iteration of `adjustment.adjust`: Gauss-Newton with line search, for a stack."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pgm_lab.adjustment import normal

SMALLEST_STEP = 2.0**-20
SUFFICIENT_DECREASE = 1e-4
ROUNDING = 100 * np.finfo(float).eps


@dataclass(frozen=True)
class Model:
    """Observation equations of m problems, weighted parameters among them.

    `weights` is (m, n) or, with correlated observations, (m, n, n). A single problem
    calls `function` and `constraints` without the leading axis.
    """

    function: Callable
    observations: np.ndarray
    weights: np.ndarray
    constraints: Callable | None
    weighted_parameters: bool
    args: tuple[np.ndarray, ...]
    single: bool

    def evaluate(self, x: np.ndarray, k) -> tuple[np.ndarray, ...]:
        """Residuals v, design matrix A, constraints c and C of the problems k at x."""
        computed, A = self._call(self.function, "function", x, k)
        if self.weighted_parameters:
            unit = np.broadcast_to(np.eye(x.shape[-1]), (*x.shape, x.shape[-1]))
            computed = np.concatenate([computed, x], axis=-1)
            A = np.concatenate([A, unit], axis=-2)
        if computed.shape[-1] != self.observations.shape[-1]:
            raise ValueError(
                f"function computes {computed.shape[-1]} values for"
                f" {self.observations.shape[-1]} observations"
            )
        v = computed - self.observations[k]
        if self.constraints is None:
            return v, A, v[:, :0], A[:, :0]
        return v, A, *self._call(self.constraints, "constraints", x, k)

    def _call(self, function, name, x, k) -> tuple[np.ndarray, np.ndarray]:
        if self.single:
            answer = function(x[0], *self.args)
        else:
            answer = function(x, *(arg[k] for arg in self.args))
        if not isinstance(answer, tuple | list) or len(answer) != 2:
            raise ValueError(
                f"{name} must return two arrays: values and their Jacobian"
            )
        values, jacobian = (np.asarray(part, dtype=float) for part in answer)
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
        # Where a derivative is missing, the value is of no use.
        whole = np.isfinite(jacobian).all(axis=(-2, -1))
        values = np.where(whole[..., None], values, np.nan)
        return values, np.broadcast_to(jacobian, shape)

    def weighted(self, matrix: np.ndarray, k) -> np.ndarray:
        """P times a matrix (k, n, u)."""
        P = self.weights[k]
        return P[..., None] * matrix if P.ndim == 2 else P @ matrix

    def redundancy(self, state: "State") -> np.ndarray:
        """Observations made, minus unknowns, plus constraints, of each problem."""
        P = self.weights
        P = P if P.ndim == 2 else np.diagonal(P, axis1=-2, axis2=-1)
        made = np.count_nonzero(P > 0, axis=-1)
        return made - state.x.shape[-1] + state.c.shape[-1]

    def objective(self, v: np.ndarray, k) -> np.ndarray:
        """Return v'Pv of each problem; not finite where a residual is not."""
        with np.errstate(invalid="ignore", over="ignore"):
            Pv = self.weighted(v[..., None], k)[..., 0]
            return np.einsum("mn,mn->m", v, Pv)


@dataclass
class State:
    """Where the problems of a stack are: changed in place, problem by problem."""

    x: np.ndarray
    v: np.ndarray
    A: np.ndarray
    c: np.ndarray
    C: np.ndarray

    @classmethod
    def at(cls, model: Model, x: np.ndarray, k: np.ndarray) -> "State":
        v, A, c, C = model.evaluate(x, k)
        return cls(x, v, A, c, C)

    def put(self, k: np.ndarray, other: "State") -> None:
        """Overwrite the problems k."""
        for name in ("x", "v", "A", "c", "C"):
            getattr(self, name)[k] = getattr(other, name)

    def part(self, k: np.ndarray) -> "State":
        """Copy of the problems k."""
        return State(self.x[k], self.v[k], self.A[k], self.c[k], self.C[k])


def iterate(
    model: Model,
    x: np.ndarray,
    sigma0_prior: float | None,
    line_search: bool,
    tolerance: float,
    max_iterations: int,
) -> tuple[State, np.ndarray, np.ndarray, tuple[np.ndarray, ...], np.ndarray]:
    """Iterate each problem at x (m, u) until it converges or gets another status.

    Returns the final state, statuses, numbers of iterations, the columns of the history
    and the redundancies.
    """
    m = len(x)
    k = np.arange(m)
    state = State.at(model, x, k).part(k)
    redundancy = model.redundancy(state)
    phi = model.objective(state.v, k)
    level = np.sqrt(model.objective(model.observations, k))
    usable = np.isfinite(phi) & np.isfinite(state.c).all(axis=-1)
    status = np.where(usable, "too many iterations", "diverged")
    iterations = np.zeros(m, int)
    objectives, steps, changes = [phi.copy()], [], []
    k = k[usable]
    while len(k) and iterations.max() < max_iterations:
        here = state.part(k)
        PA = model.weighted(here.A, k)
        N = np.swapaxes(here.A, -1, -2) @ PA
        n = -np.einsum("mnu,mn->mu", PA, here.v)
        dx, Q, correlates, singular = normal.solve(N, n, here.C, here.c)
        # They stop here; `adjust` finds them again, and those that end in a singularity
        dx[singular], Q[singular], correlates[singular] = 0, 0, 0
        decrease = np.einsum("mu,muw,mw->m", dx, N, dx)
        sigma = sigma0_prior or np.sqrt(phi[k] / np.maximum(redundancy[k], 1))
        change = _in_standard_deviations(dx, Q, sigma)
        # Without errors in the observations the standard deviations fall to zero: then
        # the end is reached when a step changes nothing above the rounding of numbers.
        size = np.sqrt(np.diagonal(N, axis1=-2, axis2=-1)) * np.abs(here.x)
        rounding = ROUNDING * (level[k] + size.max(axis=-1))
        closing = _closing_error(here, N, rounding)
        # An exact penalty: heavy enough that a step towards the constraints pays.
        penalty = 4 * np.max(np.abs(correlates), axis=-1, initial=0)
        # How well v'Pv is known: a decrease below that cannot be seen
        slack = rounding * (2 * np.sqrt(phi[k]) + rounding)
        slack += penalty * closing.sum(axis=-1)
        there, step, found = _line_search(
            model, k, here, dx, decrease, penalty, slack, line_search
        )
        # A step that only closes constraints, such as a change of datum, lowers no v'Pv
        closed = np.all(np.abs(here.c) <= closing, axis=-1)
        converged = (change <= tolerance) | ((decrease <= rounding**2) & closed)
        move = found & ~singular
        state.put(k[move], there.part(move))
        phi[k] = np.where(move, model.objective(there.v, k), phi[k])
        status[k[move & converged]] = "converged"
        status[k[~found & ~singular]] = "diverged"
        iterations[k] += 1
        objectives.append(phi.copy())
        steps.append(_scatter(m, k, step * move))
        changes.append(_scatter(m, k, change))
        k = k[move & ~converged]
    shape = (len(steps), m)
    history = (
        np.array(objectives),
        np.reshape(steps, shape),
        np.reshape(changes, shape),
    )
    return state, status, iterations, history, redundancy


def _in_standard_deviations(dx, Q, sigma) -> np.ndarray:
    """Largest component of dx over its standard deviation; 0 where nothing moves."""
    sd = np.sqrt(np.abs(np.diagonal(Q, axis1=-2, axis2=-1))) * np.expand_dims(sigma, -1)
    moved = dx != 0
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.max(np.where(moved, np.abs(dx) / sd, 0), axis=-1)


def _closing_error(state, N, rounding) -> np.ndarray:
    """Misclosures of the constraints (m, k) that the rounding of numbers explains."""
    error = rounding[:, None] * normal.column_scale(N)
    return np.einsum("mku,mu->mk", np.abs(state.C), error)


def _line_search(model, k, here, dx, decrease, penalty, slack, wanted):
    """Halve the step of each problem until v'Pv, with its constraints, falls enough."""

    def merit(state, k, penalty):
        return model.objective(state.v, k) + penalty * np.abs(state.c).sum(axis=-1)

    step = np.ones(len(k))
    there = State.at(model, here.x + dx, k).part(np.arange(len(k)))
    before, after = merit(here, k, penalty), merit(there, k, penalty)

    def too_high():
        goal = before - 2 * SUFFICIENT_DECREASE * step * decrease + slack
        return ~(after <= goal) if wanted else ~np.isfinite(after)

    while wanted and np.any(high := too_high() & (step > SMALLEST_STEP)):
        step[high] /= 2
        x = here.x[high] + step[high, None] * dx[high]
        shorter = State.at(model, x, k[high])
        there.put(high, shorter)
        after[high] = merit(shorter, k[high], penalty[high])
    return there, step, ~too_high()


def _scatter(m, k, values) -> np.ndarray:
    whole = np.zeros(m)
    whole[k] = values
    return whole
