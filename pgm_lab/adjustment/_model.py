"""Observation equations of `adjustment.adjust`: checked, the stack along one axis."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import normal

Lead = tuple[int, ...]


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
        """Values (m, n) and Jacobian (m, n, u) of what the caller handed over."""
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
        whole = np.isfinite(jacobian).all(axis=(-2, -1))
        values = np.where(whole[..., None], values, np.nan)
        return values, np.array(np.broadcast_to(jacobian, shape))

    def weighted(self, matrix: np.ndarray) -> np.ndarray:
        """P times a matrix (m, n, u)."""
        P = self.weights
        return P[..., None] * matrix if P.ndim == 2 else P @ matrix

    def objective(self, v: np.ndarray) -> np.ndarray:
        """Return vᵀPv of each problem; not finite where a residual is not."""
        with np.errstate(invalid="ignore", over="ignore"):
            return np.einsum("mn,mn->m", v, self.weighted(v[..., None])[..., 0])

    def redundancy(self, unknowns: int, constraints: int) -> np.ndarray:
        """Observations made, minus unknowns, plus constraints, of each problem."""
        P = self.weights
        diagonal = P if P.ndim == 2 else np.diagonal(P, axis1=-2, axis2=-1)
        return np.count_nonzero(diagonal > 0, axis=-1) - unknowns + constraints


def model(
    function: Callable,
    start: np.ndarray,
    observations: ArrayLike,
    weights: ArrayLike | None,
    covariance: ArrayLike | None,
    constraints: Callable | None,
    args: Sequence[ArrayLike],
) -> Model:
    """Check what was handed over, and lay the leading axes into one."""
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
    args = tuple(_validate.several(args, "args"))
    for arg in args:
        _validate.real(arg, "args")
    args = tuple(_flat_argument(arg, lead) if lead else arg for arg in args)
    return Model(function, constraints, args, observations, P, single=not lead)


def with_parameters(
    model: Model, start: np.ndarray, weights: ArrayLike, values: ArrayLike | None
) -> Model:
    """Append the weighted parameters to the observations."""
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


def _flat(values: ArrayLike, name: str, lead: Lead, *shape: int) -> np.ndarray:
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


def _weights(values: ArrayLike, name: str, lead: Lead, n: int) -> np.ndarray:
    weights = _flat(values, name, lead, n)
    if np.any(weights < 0):
        raise ValueError(f"{name} must not be negative")
    return weights


def _flat_argument(arg: ArrayLike, lead: Lead) -> np.ndarray:
    arg = np.asarray(arg)
    if arg.shape[: len(lead)] != lead:
        raise ValueError(
            f"args must have the leading axes {lead} of the start values; got shape"
            f" {arg.shape}. Put what all problems share into the function itself"
        )
    return arg.reshape(math.prod(lead), *arg.shape[len(lead) :])


def _inverse_covariance(covariance: ArrayLike, n: int) -> np.ndarray:
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
