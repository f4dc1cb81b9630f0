"""Chips of a reference image found in a sensed one by Pearson's correlation."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, lsm, ncc
from pgm_lab.registration.accuracy import Accuracy, accuracy


@dataclass(frozen=True, eq=False)
class Registration:
    """Where n chips of the reference image lie in the sensed one.

    Attributes
    ----------
    points : ndarray (n, 2)
        (column, row) in the reference image, in pixels.
    dx, dy : ndarray (n,)
        Shift, sensed minus reference, in pixels: of the highest peak, also where the
        status warns of it; NaN where nothing was compared.
    r : ndarray (n,)
        Correlation coefficient at the peak.
    second : ndarray (n,)
        At the second highest peak; -1 where there is no other.
    covariance : ndarray (n, 2, 2)
        Predicted, of the shift, in square pixels; NaN unless accepted.
    status : ndarray (n,) of str
        "accepted", or what went wrong first: the words of `matching.STATUSES`.
    """

    points: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    r: np.ndarray
    second: np.ndarray
    covariance: np.ndarray
    status: np.ndarray

    @property
    def accepted(self) -> np.ndarray:
        """Whether the status is "accepted": ndarray (n,) of bool."""
        return self.status == "accepted"

    @property
    def sd(self) -> np.ndarray:
        """Predicted standard deviation of a coordinate of the shift in pixels (n,)."""
        return np.sqrt(np.trace(self.covariance, axis1=1, axis2=2) / 2)

    @cached_property
    def accuracy(self) -> Accuracy:
        """Of the accepted shifts, in pixels."""
        return accuracy(self.dx[self.accepted], self.dy[self.accepted])

    @property
    def rmse_x(self) -> float:
        """Of the accepted shifts, in pixels (Br 2)."""
        return self.accuracy.rmse_x

    @property
    def rmse_y(self) -> float:
        """Of the accepted shifts, in pixels (Br 3)."""
        return self.accuracy.rmse_y

    @property
    def rmse_t(self) -> float:
        """Of the accepted shifts, in pixels (Br 4)."""
        return self.accuracy.rmse_t

    @property
    def ce90(self) -> float:
        """Radius that nine tenths of the accepted shifts do not exceed, in pixels."""
        return self.accuracy.ce90


def register(
    reference: ArrayLike,
    sensed: ArrayLike,
    points: ArrayLike,
    chip: int = 21,
    radius: int = 3,
    refine: str | None = None,
    *,
    threshold: float = 0.7,
    ratio: float = 0.9,
    offset: ArrayLike = (0.0, 0.0),
    noise: ArrayLike = (1.0, 1.0),
) -> Registration:
    """Find chips of the reference image in the sensed image, all in one call.

    A first version; see the issue.
    """
    points = _validate.point_list(points, "points")
    start = points + _validate.of_shape(offset, (2,), "offset")
    found = ncc.match(
        *(reference, sensed, points, start, chip, chip + 2 * radius, threshold, ratio),
        refine="parabola" if refine == "parabola" else None,
        noise=noise,
    )
    place, covariance, status = found.points, found.covariance, found.status.copy()
    if refine == "lsm":
        k = np.flatnonzero(found.accepted)
        fine = lsm.match(
            *(reference, sensed, points[k], found.points[k], chip),
            threshold=max(threshold, 0.0),
            noise=noise,
        )
        place, covariance = place.copy(), covariance.copy()
        good = fine.accepted
        place[k[good]], covariance[k] = fine.points[good], np.nan
        covariance[k[good]], status[k] = fine.covariance[good], fine.status
    dx, dy = (place - start).T
    return Registration(points, dx, dy, found.r, found.second, covariance, status)
