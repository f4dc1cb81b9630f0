"""Reliability of the observations, and tests of residuals and parameters."""

from dataclasses import dataclass

import numpy as np
import scipy

from pgm_lab import _validate
from pgm_lab.adjustment.outliers import critical_tau, critical_w
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.result import Bundle
from pgm_lab.camera import PARAMETERS, imaging


@dataclass(frozen=True)
class Reliability:
    """Reliability of the image coordinates (k, 2).

    Attributes
    ----------
    internal : ndarray (k, 2)
        Smallest error that the test of the residual finds, in mm; inf where nothing
        controls the coordinate.
    external : ndarray (k, 2)
        What such an error does if it stays: no unknown, and no function of the unknowns
        moves by more than this many standard deviations.
    """

    internal: np.ndarray
    external: np.ndarray


@dataclass(frozen=True)
class Significance:
    """Whether an interior parameter differs from zero.

    Attributes
    ----------
    name : str
    value, sd : float
        In mm and its powers.
    t : float
        value / sd.
    p : float
        Probability of a larger |t| if the parameter were zero.
    significant : bool
    effect : float
        Largest displacement of a measured point by it, in mm.
    """

    name: str
    value: float
    sd: float
    t: float
    p: float
    significant: bool
    effect: float


def reliability(result: Bundle, delta0: float = 4.13) -> Reliability:
    """Internal and external reliability of each image coordinate.

    Parameters
    ----------
    result : Bundle
    delta0 : float
        Non-centrality of Baarda's w: 4.13 for power 80 per cent and alpha 0.001.

    Returns
    -------
    Reliability
        By the stated sigma0, else the estimated one. With a small redundancy Pope's tau
        finds only much larger errors, since they enlarge sigma0 too.

    References
    ----------
    Baarda 1968, "A testing procedure for use in geodetic networks"; Foerstner 1985.
    """
    _validate.instance(result, Bundle, "result")
    delta0 = _validate.positive_number(delta0, "delta0", "no unit")
    r = result.testable
    controlled = r > UNCONTROLLED
    r = np.where(controlled, r, 1.0)
    sigma = result.network.sigma_alone * (result.sigma0_prior or result.sigma0)
    return Reliability(
        np.where(controlled, delta0 * sigma / np.sqrt(r), np.inf),
        np.where(controlled, delta0 * np.sqrt(np.maximum(1 - r, 0) / r), np.inf),
    )


def critical_value(result: Bundle, alpha: float = 0.001) -> float:
    """Limit that a standardised residual exceeds by chance with probability alpha.

    `adjustment.critical_w` with sigma0_prior, else `adjustment.critical_tau`, which is
    inf if the redundancy is below 2. `result.residual_test` says which it is.
    """
    _validate.instance(result, Bundle, "result")
    if result.residual_test == "w":
        return critical_w(alpha)
    return float(critical_tau(result.redundancy, alpha))


def correlations(result: Bundle, limit: float = 0.9) -> list[tuple[str, str, float]]:
    """Pairs of interior and exterior unknowns with a correlation above a limit.

    (name, name, correlation), the largest first. Those between exterior orientations
    depend on the datum.
    """
    limit = _validate.number(limit, "limit")
    _validate.instance(result, Bundle, "result")
    r = np.triu(result.correlation, 1)
    rows, columns = np.nonzero(np.abs(r) > limit)
    order = np.argsort(-np.abs(r[rows, columns]), kind="stable")
    names = result.names
    return [
        (names[i], names[j], float(r[i, j]))
        for i, j in zip(rows[order], columns[order])
    ]


def significance(result: Bundle, alpha: float = 0.05) -> list[Significance]:
    """Test each interior parameter but c against zero.

    alpha, between 0 and 1, is the probability to call a zero parameter significant.

    References
    ----------
    Fraser 1997, "Digital camera self-calibration".
    """
    _validate.instance(result, Bundle, "result")
    alpha = _validate.probability(alpha, "alpha")
    found = []
    u = len(result.estimate)
    # without redundancy the standard deviations come from sigma0_prior, known exactly
    redundancy = result.redundancy or np.inf
    for i, name in enumerate(result.interior_names):
        parameter, camera = result.estimate[i % u], i // u
        if parameter == "c":
            continue
        value, sd = float(result.interior[i]), float(result.sd_interior[i])
        t = value / sd if sd > 0 else np.copysign(np.inf, value)
        p = float(2 * scipy.special.stdtr(redundancy, -abs(t)))
        effect = _effect(result, parameter, camera)
        found.append(Significance(name, value, sd, t, p, p < alpha, effect))
    return found


def _effect(result: Bundle, parameter: str, camera: int) -> float:
    """Largest displacement of a measured point by one parameter of a camera."""
    value = getattr(result.cameras[camera], parameter)
    if parameter in ("x0", "y0"):
        return abs(value)
    network = result.network
    own = network.camera[network.photo] == camera
    centre = result.cameras[camera].interior[1:3]
    by_lens = imaging.distortion_by_lens(network.xy[own] - centre)
    column = by_lens[..., PARAMETERS.index(parameter) - 3]
    return float(np.linalg.norm(value * column, axis=-1).max(initial=0))
