"""Data snooping: find blunders by their residuals, one at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pgm_lab import _validate
from pgm_lab.bundle._rank import NetworkDefect
from pgm_lab.bundle._solve import adjust
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle
from pgm_lab.camera import PARAMETERS
from pgm_lab.quality import UNCONTROLLED


@dataclass(frozen=True)
class Blunder:
    """A ray that data snooping has removed.

    Attributes
    ----------
    ray : int
        Its index in the network.
    photo, point : object
        Names of its photo and its point.
    xy : ndarray (2,)
        As measured, in mm.
    standardized : ndarray (2,)
        Its standardised residuals when it was removed.
    error : ndarray (2,)
        Estimated error of the measurement, -v / r, in mm.
    sigma0 : float
        Standard deviation of unit weight with the ray; without it, see the next one.
    """

    ray: int
    photo: object
    point: object
    xy: np.ndarray
    standardized: np.ndarray
    error: np.ndarray
    sigma0: float


@dataclass(frozen=True)
class Snooping:
    """What data snooping found.

    Attributes
    ----------
    before, result : Bundle
        With all rays, and without those removed.
    removed : tuple of Blunder
        In the order in which they were removed.
    critical : float
        Limit of the standardised residuals, for the result.
    stopped : str
        "no residual above the limit"; "limit of blunders reached"; or what the network
        would not determine without the next ray.
    """

    before: Bundle
    result: Bundle
    removed: tuple[Blunder, ...]
    critical: float
    stopped: str


def snoop(
    network: Network,
    estimate: Sequence[str] = PARAMETERS,
    datum: str | None = None,
    *,
    alpha: float = 0.001,
    most: int = 20,
    sigma0_prior: float | None = None,
    progress: bool = False,
) -> Snooping:
    """Find blunders: remove the ray with the largest residual, adjust, look again.

    One ray at a time, because a blunder also spoils the residuals of good rays.

    Parameters
    ----------
    network, estimate, datum, sigma0_prior, progress
        As in `adjust`.
    alpha : float
        Probability of a false alarm in each test: `critical_value`.
    most : int
        Most rays to remove.

    Returns
    -------
    Snooping

    Raises
    ------
    ValueError, RankDefect
        As `adjust`.

    References
    ----------
    Baarda 1968.
    """
    most = _validate.whole(most, "most", 0)
    rays, removed = np.arange(len(network.xy)), []

    def solve(these):
        return adjust(
            these, estimate, datum, sigma0_prior=sigma0_prior, progress=progress
        )

    before = result = solve(network)
    stopped = "no residual above the limit"
    while (worst := _worst(result)) is not None:
        if np.abs(result.standardized[worst]).max() <= critical_value(result, alpha):
            break
        if len(removed) == most:
            stopped = "limit of blunders reached"
            break
        blunder = _blunder(result, worst, int(rays[worst]))
        try:
            result = solve(result.network.without([worst]))
        except NetworkDefect as defect:
            stopped = str(defect)
            break
        rays = np.delete(rays, worst)
        removed.append(blunder)
    return Snooping(
        before, result, tuple(removed), critical_value(result, alpha), stopped
    )


def _worst(result: Bundle) -> int | None:
    """The ray with the largest standardised residual, unless all are zero."""
    largest = np.abs(result.standardized).max(axis=1)
    return int(np.argmax(largest)) if largest.max() > 0 else None


def _blunder(result: Bundle, row: int, ray: int) -> Blunder:
    network = result.network
    r = result.redundancy_numbers[row]
    controlled = r > UNCONTROLLED
    error = np.where(
        controlled, -result.residuals[row] / np.where(controlled, r, 1), 0.0
    )
    return Blunder(
        ray,
        network.photo_names[network.photo[row]],
        network.point_names[network.point[row]],
        network.xy[row],
        result.standardized[row],
        error,
        result.sigma0,
    )
