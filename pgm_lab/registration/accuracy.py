"""Summary of shifts: RMSE, circular error, and robust measures."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._robust import nmad

# Normal errors of x and y, with mean 0 and sigma each, have RMSE_T = sqrt(2) sigma and
# are longer than R with probability exp(-R^2 / (2 sigma^2)): 0.1 at sigma sqrt(2 ln 10)
CE90_OF_RMSE = np.sqrt(np.log(10))  # 1.5174


@dataclass(frozen=True)
class Accuracy:
    """Statistics of n shifts between two images, in the unit of the shifts.

    Attributes
    ----------
    n : int
        Number of shifts.
    mean_x, mean_y : float
        Mean shift.
    sd_x, sd_y : float
        Standard deviation of a shift about the mean; NaN for one shift alone.
    sd_mean_x, sd_mean_y : float
        Standard deviation of the mean; NaN for one shift alone.
    rmse_x, rmse_y, rmse_t : float
        Root mean squares of the shifts, and of both together (Br 2-4), means included.
    sd_rmse_t : float
        Standard deviation of RMSE_T; NaN for one shift alone.
    ce90 : float
        Circular error: the 0.9 quantile of the lengths.
    ce90_normal : float
        The same for normal shifts of zero mean, equal in x and y: 1.5174 RMSE_T.
    median_x, median_y : float
        Median shift.
    spread_x, spread_y : float
        Robust standard deviation: 1.4826 times the median absolute deviation.
    shifts : ndarray (n, 2)
        The shifts (dx, dy) themselves.
    """

    n: int
    mean_x: float
    mean_y: float
    sd_x: float
    sd_y: float
    sd_mean_x: float
    sd_mean_y: float
    rmse_x: float
    rmse_y: float
    rmse_t: float
    sd_rmse_t: float
    ce90: float
    ce90_normal: float
    median_x: float
    median_y: float
    spread_x: float
    spread_y: float
    shifts: np.ndarray = field(repr=False, compare=False)

    def times(self, pixel_size: ArrayLike) -> "Accuracy":
        """Return the same in metres; `pixel_size` is one number or (across, down).

        Examples
        --------
        >>> f"{accuracy([0.0, 2], [1.0, 1]).times(6).rmse_t:.2f} m"
        '10.39 m'
        """
        size = _validate.pair(pixel_size, "pixel_size", "m")
        return accuracy(*(self.shifts * size).T)


def accuracy(dx: ArrayLike, dy: ArrayLike) -> Accuracy:
    """Summarize shifts by their means, root mean squares and quantiles.

    Parameters
    ----------
    dx, dy : array_like (n,)
        Shifts, sensed minus reference, in pixels or metres; at least one.

    Returns
    -------
    Accuracy
        In the same unit.

    Notes
    -----
    For independent shifts, RMSE_T^2 is the mean of n squared lengths q, so that
    sd(RMSE_T) = sd(q) / (2 RMSE_T sqrt(n)), whatever their distribution.

    References
    ----------
    Brahmantara 2015, (Br 2) to (Br 4); Greenwalt and Shultz 1962, the circular error.

    Examples
    --------
    >>> found = accuracy([0.1, -0.1, 0.3, 0.1], [0.0, 0.2, 0.0, -0.2])
    >>> f"{found.mean_x:.2f} +- {found.sd_mean_x:.2f}, RMSE_T {found.rmse_t:.3f}"
    '0.10 +- 0.08, RMSE_T 0.224'
    """
    dx, dy = _validate.finite(dx, "dx"), _validate.finite(dy, "dy")
    if dx.ndim != 1 or dx.shape != dy.shape or not len(dx):
        raise ValueError(
            "dx and dy must be two lists of the same length, with at least one shift;"
            f" got shapes {dx.shape} and {dy.shape}"
        )
    shifts = np.stack([dx, dy], axis=1)
    n = len(shifts)
    rmse = np.sqrt(np.mean(shifts**2, axis=0))  # (Br 2), (Br 3)
    rmse_t = float(np.hypot(*rmse))  # (Br 4)
    length = np.hypot(*shifts.T)
    sd, sd_of_square = np.full(2, np.nan), np.nan
    if n > 1:
        sd = shifts.std(axis=0, ddof=1)
        sd_of_square = np.std(length**2, ddof=1)
    sd_rmse_t = sd_of_square / (2 * rmse_t * np.sqrt(n)) if rmse_t else 0 * sd_of_square
    of_both = {"mean": shifts.mean(axis=0), "sd": sd, "sd_mean": sd / np.sqrt(n)}
    of_both |= {"rmse": rmse, "median": np.median(shifts, axis=0)}
    of_both["spread"] = nmad(shifts, axis=0)
    numbers: dict[str, Any] = {
        f"{name}_{axis}": float(value)
        for name, pair in of_both.items()
        for axis, value in zip("xy", pair)
    }
    return Accuracy(
        n=n,
        rmse_t=rmse_t,
        sd_rmse_t=float(sd_rmse_t),
        ce90=float(np.quantile(length, 0.9)),
        ce90_normal=float(CE90_OF_RMSE * rmse_t),
        shifts=shifts,
        **numbers,
    )
