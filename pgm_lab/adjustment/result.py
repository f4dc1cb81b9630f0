"""Result of an adjustment: residuals, covariance, redundancy, tests."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from pgm_lab import _validate
from pgm_lab.adjustment import outliers

# An observation with a smaller share in the redundancy is controlled by no other.
UNCONTROLLED = 1e-9


@dataclass(frozen=True)
class History:
    """What happened in each iteration, along the first axis.

    Attributes
    ----------
    objective : ndarray (iterations + 1, ...)
        vᵀPv at the start and after each iteration.
    step : ndarray (iterations, ...)
        Step length: 1 for a full Gauss-Newton step, 0 when the problem had stopped.
    change : ndarray (iterations, ...)
        Largest change of a parameter, in units of its standard deviation.
    """

    objective: np.ndarray
    step: np.ndarray
    change: np.ndarray


@dataclass(frozen=True)
class GlobalTest:
    """Test of sigma0 against its value before the adjustment.

    Attributes
    ----------
    statistic : ndarray (...)
        redundancy * sigma0^2 / sigma0_prior^2.
    lower, upper : ndarray (...)
        Limits of what is accepted.
    accepted : ndarray (...) of bool
        Whether the statistic lies within them.
    """

    statistic: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    accepted: np.ndarray


@dataclass(frozen=True)
class Adjustment:
    """Result of an adjustment; leading axes as those of the start values.

    Attributes
    ----------
    x : ndarray (..., u)
        Adjusted parameters.
    cofactor : ndarray (..., u, u)
        Cofactor matrix Q of the parameters.
    residuals : ndarray (..., n)
        v = computed - observed.
    sigma0 : ndarray (...)
        Standard deviation of unit weight, sqrt(vᵀPv / redundancy); NaN if the
        redundancy is 0.
    redundancy : ndarray (...) of int
        Observations and weighted parameters, minus unknowns, plus constraints.
    redundancy_numbers : ndarray (..., n)
        Share of each observation in the redundancy; 0 where the weight is 0.
    standardized : ndarray (..., n)
        Baarda's w if `sigma0_prior` was given, else Pope's tau (`residual_test`); 0
        where nothing controls the observation.
    parameter_residuals, parameter_redundancy_numbers : ndarray (..., u)
        The same for the weighted parameters; 0 for free ones.
    status : ndarray (...) of str
        "converged"; "too many iterations"; "diverged": no step lowers vᵀPv, or values
        are not finite; "singular": the normal matrix (then results are NaN).
    iterations : ndarray (...) of int
        Number of iterations.
    sigma0_prior : float or None
        Standard deviation of unit weight before the adjustment.
    names : sequence of str
        Names of the parameters.
    history : History
        Objective, step length and change of each iteration.
    """

    x: np.ndarray
    cofactor: np.ndarray
    residuals: np.ndarray
    sigma0: np.ndarray
    redundancy: np.ndarray
    redundancy_numbers: np.ndarray
    standardized: np.ndarray
    parameter_residuals: np.ndarray
    parameter_redundancy_numbers: np.ndarray
    status: np.ndarray
    iterations: np.ndarray
    sigma0_prior: float | None
    names: Sequence[str]
    history: History

    @property
    def residual_test(self) -> str:
        """Which test `standardized` is for: "w" (Baarda) or "tau" (Pope)."""
        return outliers.residual_test(self.sigma0_prior)

    @property
    def covariance(self) -> np.ndarray:
        """Covariance (..., u, u): sigma0^2 Q, without redundancy sigma0_prior^2 Q."""
        prior = np.nan if self.sigma0_prior is None else self.sigma0_prior
        sigma0 = np.where(self.redundancy > 0, self.sigma0, prior)
        return sigma0[..., None, None] ** 2 * self.cofactor

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (..., u) of the parameters."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))

    @property
    def correlation(self) -> np.ndarray:
        """Correlation matrix (..., u, u) of the parameters."""
        sd = np.sqrt(np.diagonal(self.cofactor, axis1=-2, axis2=-1))
        sd = np.where(sd > 0, sd, 1.0)
        return self.cofactor / (sd[..., :, None] * sd[..., None, :])

    def global_test(self, alpha: float = 0.05) -> GlobalTest:
        """Test whether sigma0 agrees with its value before the adjustment.

        The statistic redundancy * sigma0^2 / sigma0_prior^2 follows chi-square when the
        model and the weights are right. A right model is rejected with probability
        alpha.

        Raises
        ------
        ValueError
            If sigma0_prior was not given, or there is no redundancy.
        """
        alpha = _validate.probability(alpha, "alpha")
        if self.sigma0_prior is None:
            raise ValueError(
                "the global test needs sigma0_prior, which adjust() was not given"
            )
        if np.any(self.redundancy == 0):
            raise ValueError("without redundancy there is nothing to test")
        statistic = self.redundancy * (self.sigma0 / self.sigma0_prior) ** 2
        lower = scipy.special.chdtri(self.redundancy, 1 - alpha / 2)
        upper = scipy.special.chdtri(self.redundancy, alpha / 2)
        return GlobalTest(
            statistic, lower, upper, (lower <= statistic) & (statistic <= upper)
        )


def residual_statistics(
    A: np.ndarray, v: np.ndarray, P: np.ndarray, Q: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Redundancy numbers and standardised residuals (m, n) of a stack of problems.

    From design matrices A (m, n, u), residuals v, weights P (m, n) or (m, n, n), and
    cofactors Q of the parameters. The redundancy numbers are the diagonal of
    Qvv P = 1 - A Q Aᵀ P; the residuals are Pv over the roots of the diagonal of
    P Qvv P, for sigma0 = 1: v / sigma_v when the weights are a diagonal.

    References
    ----------
    Baarda 1968, the test of one observation at a time; Foerstner and Wrobel 2016,
    section 4.6, for correlated observations.
    """
    AQ = A @ Q
    if P.ndim == 2:
        PA, Pv, diagonal = P[..., None] * A, P * v, P
        PAQ = P[..., None] * AQ
    else:
        PA, Pv, PAQ = P @ A, np.einsum("mij,mj->mi", P, v), P @ AQ
        diagonal = np.diagonal(P, axis1=-2, axis2=-1)
    made = diagonal > 0
    share = np.where(made, 1 - np.einsum("mnu,mnu->mn", AQ, PA), 0)
    variance = diagonal - np.einsum("mnu,mnu->mn", PAQ, PA)
    controlled = made & (variance > UNCONTROLLED * diagonal)
    with np.errstate(divide="ignore", invalid="ignore"):
        return share, np.where(controlled, Pv / np.sqrt(variance), 0)
