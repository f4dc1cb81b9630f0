"""Rays that look like blunders, and what kind of blunder it may be."""

import numpy as np

from pgm_lab.adjustment.result import UNCONTROLLED
from pgm_lab.bundle.reliability import critical_value
from pgm_lab.bundle.result import Bundle

GROSS = 1.5  # times the limit of |w|
SPOILT = 2.0  # times the stated standard deviation: what is judged by sigma0 is not
MOST = 50  # suspects that are compared with each other
ALIKE = 0.5  # largest part of a distance by which an error may miss it


def ray(result: Bundle, k: int) -> str:
    """Name a ray by the ids of its point and photo."""
    network = result.network
    point = network.point_names[network.point[k]]
    return f"point {point} in photo {network.photo_names[network.photo[k]]}"


def suspected(result: Bundle) -> np.ndarray:
    """Rays with a standardised residual above its limit, the largest first."""
    largest = np.max(np.abs(result.standardized), axis=1, initial=0)
    suspects = np.flatnonzero(largest > critical_value(result))
    return suspects[np.argsort(-largest[suspects], kind="stable")]


def suspected_control(result: Bundle) -> list[tuple[str, float]]:
    """Control coordinates and scale bars above the limit, with w, the largest first."""
    network, critical = result.network, critical_value(result)
    names, found = network.point_names, []
    w = result.control_standardized
    for row, axis in np.argwhere(np.abs(w) > critical):
        point = names[network.control[0][row]]
        found.append((f"{'XYZ'[axis]} of control point {point}", float(w[row, axis])))
    w = result.scale_bar_standardized
    for bar in np.flatnonzero(np.abs(w) > critical):
        a, b = network.scale_bars[bar, :2].astype(int)
        found.append((f"the scale bar {names[a]} to {names[b]}", float(w[bar])))
    return sorted(found, key=lambda one: -abs(one[1]))


def control_first(result: Bundle) -> bool:
    """Whether a control coordinate or a scale bar has the largest residual of all."""
    suspects = suspected_control(result)
    rays = np.max(np.abs(result.standardized), initial=0)
    return bool(suspects) and abs(suspects[0][1]) > rays


def gross(result: Bundle) -> bool:
    """Whether a blunder makes sigma0 so large that nothing can be judged by it."""
    stated = result.sigma0_prior or 1.0
    if not result.sigma0 > SPOILT * stated:
        return False
    w = result.standardized, result.control_standardized, result.scale_bar_standardized
    largest = max(np.max(np.abs(one), initial=0) for one in w)
    if result.sigma0_prior is not None:  # beside the others, not beside the stated sd
        largest *= stated / result.sigma0
    return bool(largest > GROSS * critical_value(result))


def interchanged(result: Bundle) -> list[tuple[int, int]]:
    """Pairs of suspected rays of one photo, each measured where the other should be.

    The estimated error -v / r of one is then the difference of the coordinates, that
    of the other its opposite.
    """
    network, rays = result.network, suspected(result)[:MOST]
    r = result.redundancy_numbers[rays]
    error = -result.residuals[rays] / np.where(r > UNCONTROLLED, r, np.inf)
    a, b = np.triu_indices(len(rays), 1)
    difference = network.xy[rays[a]] - network.xy[rays[b]]
    miss = np.hypot(*(np.array([error[a], -error[b]]) - difference).transpose(2, 0, 1))
    pair = np.all(miss < ALIKE * np.hypot(*difference.T), axis=0)
    pair &= network.photo[rays[a]] == network.photo[rays[b]]
    return [(int(i), int(j)) for i, j in zip(rays[a[pair]], rays[b[pair]])]
