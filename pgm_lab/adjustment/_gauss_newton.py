"""The iteration of `adjustment.adjust`: Gauss-Newton with line search, for a stack."""

from typing import NamedTuple

import numpy as np

from pgm_lab.adjustment import normal
from pgm_lab.adjustment._model import Model
from pgm_lab.adjustment.normal import ROUNDING, SMALLEST_STEP, SUFFICIENT_DECREASE


class State(NamedTuple):
    """Where the problems of a stack are: changed in place, problem by problem."""

    x: np.ndarray
    v: np.ndarray
    A: np.ndarray
    c: np.ndarray
    C: np.ndarray
    phi: np.ndarray  # vᵀPv

    @classmethod
    def at(cls, model: Model, x: np.ndarray) -> "State":
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
        return np.isfinite(self.phi) & np.isfinite(self.c).all(axis=-1)

    def merit(self, penalty: np.ndarray) -> np.ndarray:
        """What the line search lowers: vᵀPv, with a penalty on open constraints."""
        return self.phi + penalty * np.abs(self.c).sum(axis=-1)


def iterate(
    model: Model,
    state: State,
    sigma0_prior: float | None,
    line_search: bool,
    tolerance: float,
    max_iterations: int,
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, ...]]:
    """Move each problem until it converges, or cannot go on.

    Returns the statuses, the numbers of iterations and the columns of the history.
    """
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
        active, here = model.part(k), state.part(k)
        N, n = _normal_equations(active, here)
        dx, Q, correlates, singular = normal.solve(N, n, here.C, here.c)
        # The singular ones stay where they are: `adjust` finds them there
        dx[singular], correlates[singular] = 0, 0
        sigma = sigma0_prior or np.sqrt(here.phi / np.maximum(redundancy[k], 1))
        change = _in_standard_deviations(dx, Q, sigma)

        decrease = np.einsum("mu,muw,mw->m", dx, N, dx)  # of vᵀPv, were f linear
        # An exact penalty: heavy enough that a step towards the constraints pays
        penalty = 4 * np.max(np.abs(correlates), axis=-1, initial=0)
        rounding = _rounding(here.x, N, level[k])
        closing = _closing_error(here.C, N, rounding)
        # How well the merit is known: a decrease below that cannot be seen
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
        steps.append(_whole(m, k, step))
        changes.append(_whole(m, k, change))
        k = k[moved & ~converged]
    shape = (len(steps), m)
    history = np.array(objective), np.reshape(steps, shape), np.reshape(changes, shape)
    return status, iterations, history


def _normal_equations(model: Model, state: State) -> tuple[np.ndarray, np.ndarray]:
    """N = AᵀPA and n = -AᵀPv of (M 2.76), whose f is -v."""
    PA = model.weighted(state.A)
    N = np.swapaxes(state.A, -1, -2) @ PA
    return N, -np.einsum("mnu,mn->mu", PA, state.v)


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


def _whole(m: int, k: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values of all m problems: 0 but for the problems k."""
    whole = np.zeros(m)
    whole[k] = values
    return whole
