"""Data snooping: find blunders by their residuals, one at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pgm_lab import _validate
from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.equations import residuals_alone
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.refuse import NetworkDefect
from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle
from pgm_lab.bundle.solve import adjust
from pgm_lab.camera import PARAMETERS


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
        Its standardised residuals when it was removed: Baarda's w or Pope's tau, as
        `residual_test` of the result says.
    error : ndarray (2,)
        Estimated error of the measurement, -v / r, in mm; if x and y are correlated,
        that of each as if the other had none, -(Pv)_i / (P Qvv P)_ii.
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
        Limit of the standardised residuals of the result, for the same test.
    stopped : str
        "no residual above the limit", or why there still are some.
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
    """Find blunders: remove the ray with the largest residual, adjust, test again.

    One ray at a time, because a blunder also distorts the residuals of good rays.

    Parameters
    ----------
    network, estimate, datum, progress
        As in `adjust`.
    alpha : float
        Probability of a false alarm in each test: `critical_value`.
    most : int
        Most rays to remove.
    sigma0_prior : float, optional
        1 tests by Baarda's w: the sigmas of the network are trusted. When missing, by
        Pope's tau; then sigma0 falls with each ray removed, and the next stands out
        more.

    Returns
    -------
    Snooping

    Raises
    ------
    ValueError, RankDefect
        As `adjust`.

    References
    ----------
    Baarda 1968 for w, Pope 1976 for tau.

    Examples
    --------
    Measured to a third of a micrometre, stated as one: w finds nothing, tau eight rays.

    >>> from pgm_lab import camera, datasets
    >>> data = datasets.muliawan2013()
    >>> start = camera.Camera(*data.interior), data.exteriors, data.object_points
    >>> network = Network(*start, data.photo, data.point, data.xy, data.sigma)
    >>> len(snoop(network, sigma0_prior=1.0).removed), len(snoop(network).removed)
    (0, 8)
    """
    _validate.instance(network, Network, "network")
    alpha = _validate.probability(alpha, "alpha")
    most = _validate.whole(most, "most", 0)
    rays = np.arange(len(network.xy))
    removed: list[Blunder] = []

    def solve(these: Network) -> Bundle:
        return adjust(
            these, estimate, datum, sigma0_prior=sigma0_prior, progress=progress
        )

    before = result = solve(network)
    while (stopped := _reason_to_stop(result, alpha)) is None:
        if len(removed) == most:
            stopped = "limit of blunders reached"
            break
        # The ray with the largest residual, no other instead: it distorts the others
        worst = int(np.argmax(np.abs(result.standardized).max(axis=1)))

        # Adjust again without it
        try:
            after = solve(result.network.without([worst]))
        except NetworkDefect as defect:
            stopped = _needed(result, worst, alpha, defect)
            break
        removed.append(_blunder(result, worst, int(rays[worst])))
        rays, result = np.delete(rays, worst), after
    return Snooping(
        before, result, tuple(removed), critical_value(result, alpha), stopped
    )


def _needed(result: Bundle, row: int, alpha: float, defect: NetworkDefect) -> str:
    """Which ray cannot be removed, and how many residuals stay too large."""
    network = result.network
    photo = network.photo_names[network.photo[row]]
    point = network.point_names[network.point[row]]
    large = np.abs(result.standardized).max(axis=1) > critical_value(result, alpha)
    return (
        f"point {point} in photo {photo} has the largest residual of {large.sum()}"
        f" above the limit, but it cannot be removed: {defect}"
    )


def _reason_to_stop(result: Bundle, alpha: float) -> str | None:
    """Why no ray is to be removed, or None."""
    if result.status != "converged":
        return f"the adjustment ended with the status {result.status!r}"
    rays, control, bars = (
        np.abs(w).max(initial=0)
        for w in (
            result.standardized,
            result.control_standardized,
            result.scale_bar_standardized,
        )
    )
    if max(rays, control, bars) <= critical_value(result, alpha):
        return "no residual above the limit"
    if max(control, bars) <= rays:
        return None
    if bars >= control:
        number = np.argmax(np.abs(result.scale_bar_standardized)) + 1
        what = f"scale bar {number}"
    else:
        assert result.network.control is not None  # one of them has a residual
        row = np.argmax(np.abs(result.control_standardized).max(axis=1))
        point = result.network.control[0][row]
        what = f"control point {result.network.point_names[point]}"
    return (
        f"{what} has the largest residual: correct it or leave it out first, since it"
        " distorts those of good rays"
    )


def _blunder(result: Bundle, row: int, ray: int) -> Blunder:
    network = result.network
    r = result.testable[row]
    v = residuals_alone(result.residuals, network.sigma, network.correlation)[row]
    controlled = r > UNCONTROLLED
    error = np.where(controlled, -v / np.where(controlled, r, 1), 0.0)
    return Blunder(
        ray,
        network.photo_names[network.photo[row]],
        network.point_names[network.point[row]],
        network.xy[row],
        result.standardized[row],
        error,
        result.sigma0,
    )
