"""Result of a bundle adjustment: unknowns, covariances, residuals and tests."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pgm_lab.adjustment.outliers import residual_test
from pgm_lab.adjustment.result import History
from pgm_lab.bundle.equations import behind
from pgm_lab.bundle.network import Network
from pgm_lab.camera import PARAMETERS, Camera

EXTERIOR = ("X0", "Y0", "Z0", "omega", "phi", "kappa")


class Unknown(NamedTuple):
    """An unknown of the interior or exterior orientations: whose, and which.

    Attributes
    ----------
    kind : str
        "camera" or "photo".
    owner : object
        Number of the camera, from 1, or name of the photo.
    parameter : str
        Such as "c" or "omega".
    """

    kind: str
    owner: object
    parameter: str


@dataclass(frozen=True, eq=False)
class Bundle:
    """Adjusted network. Rays, photos and points in the order of the network.

    Covariances are a posteriori, sigma0^2 Q; without redundancy sigma0_prior takes the
    place of sigma0. Those of exteriors and points depend on the datum; sigma0, the
    residuals and all of the interior orientation do not.

    Attributes
    ----------
    network : Network
        As it was handed over, with the start values.
    estimate : tuple of str
        The interior parameters that were unknowns.
    datum : str
        "inner", "photos" or "fixed".
    cameras : tuple of Camera
    exteriors : ndarray (m, 6)
        (X0, Y0, Z0, omega, phi, kappa), object units and radians.
    points : ndarray (n, 3)
    sigma0 : float
        Standard deviation of unit weight, sqrt(vᵀPv / redundancy), no unit; NaN if the
        redundancy is 0.
    sigma0_prior : float or None
    redundancy : int
        Observations - unknowns + inner constraints.
    residuals : ndarray (k, 2)
        Computed - observed, in mm.
    redundancy_numbers : ndarray (k, 2)
        Share of each image coordinate in the redundancy.
    testable : ndarray (k, 2)
        (P Qvv P)_ii / P_ii; the redundancy number, unless x and y are correlated.
    standardized : ndarray (k, 2)
        Baarda's w if `sigma0_prior` was given, else Pope's tau (`residual_test`); 0
        where nothing controls them.
    control_residuals : ndarray (q, 3)
        Computed - given coordinates of the control points.
    control_redundancy_numbers, control_standardized : ndarray (q, 3)
        The same as for the image coordinates; 0 where a coordinate is held or free.
    scale_bar_residuals : ndarray (s,)
        Computed - given distances.
    scale_bar_redundancy_numbers, scale_bar_standardized : ndarray (s,)
        The same as for the image coordinates.
    check_differences : ndarray (c, 3)
        Computed - given coordinates of the check points.
    unknowns : tuple of Unknown
        The kept unknowns: interior, then exterior orientations.
    covariance : ndarray (u + 6 m, u + 6 m)
        Covariance of these; angles in radians.
    covariance_points : ndarray (n, 3, 3)
        0 for held coordinates.
    status : str
        "converged", "too many iterations", or "diverged": no step lowers vᵀPv.
    iterations : int
    history : pgm_lab.adjustment.History
        vᵀPv, step length, and a bound of the change of all unknowns, each iteration.
    """

    network: Network
    estimate: tuple[str, ...]
    datum: str
    cameras: tuple[Camera, ...]
    exteriors: np.ndarray
    points: np.ndarray
    sigma0: float
    sigma0_prior: float | None
    redundancy: int
    residuals: np.ndarray
    redundancy_numbers: np.ndarray
    testable: np.ndarray
    standardized: np.ndarray
    control_residuals: np.ndarray
    control_redundancy_numbers: np.ndarray
    control_standardized: np.ndarray
    scale_bar_residuals: np.ndarray
    scale_bar_redundancy_numbers: np.ndarray
    scale_bar_standardized: np.ndarray
    check_differences: np.ndarray
    unknowns: tuple[Unknown, ...]
    covariance: np.ndarray
    covariance_points: np.ndarray
    status: str
    iterations: int
    history: History

    @property
    def residual_test(self) -> str:
        """Which test `standardized` is for: "w" (Baarda) or "tau" (Pope)."""
        return residual_test(self.sigma0_prior)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the kept unknowns, such as "c" and "omega of photo 7"."""
        return readable(self.unknowns)

    @property
    def interior_names(self) -> tuple[str, ...]:
        """Names of the interior unknowns, such as "c" or "c of camera 2"."""
        return self.names[: self._u]

    @property
    def interior(self) -> np.ndarray:
        """Adjusted interior unknowns (u,), camera by camera."""
        values = np.array([camera.interior for camera in self.cameras])
        columns = [PARAMETERS.index(name) for name in self.estimate]
        return values[:, columns].ravel()

    @property
    def covariance_interior(self) -> np.ndarray:
        """Covariance (u, u) of the interior unknowns."""
        return self.covariance[: self._u, : self._u]

    @property
    def covariance_exteriors(self) -> np.ndarray:
        """Covariance (m, 6, 6) of each exterior orientation."""
        m = len(self.exteriors)
        blocks = self.covariance[self._u :, self._u :].reshape(m, 6, m, 6)
        return blocks[range(m), :, range(m)]

    @property
    def sd_interior(self) -> np.ndarray:
        """Standard deviations (u,)."""
        return np.sqrt(np.diagonal(self.covariance_interior))

    @property
    def sd_exteriors(self) -> np.ndarray:
        """Standard deviations (m, 6), object units and radians."""
        return np.sqrt(np.diagonal(self.covariance)[self._u :].reshape(-1, 6))

    @property
    def sd_points(self) -> np.ndarray:
        """Standard deviations (n, 3), object units."""
        return np.sqrt(np.diagonal(self.covariance_points, axis1=1, axis2=2))

    @property
    def correlation(self) -> np.ndarray:
        """Correlation matrix (u + 6 m, u + 6 m) of the kept unknowns."""
        sd = np.sqrt(np.diagonal(self.covariance))
        sd = np.where(sd > 0, sd, 1.0)
        return self.covariance / np.outer(sd, sd)

    @property
    def behind(self) -> np.ndarray:
        """Indices (b,) of rays whose point lies behind its photo."""
        return behind(self.network, self.exteriors, self.points)

    @property
    def _u(self) -> int:
        return len(self.estimate) * len(self.cameras)


def kept_unknowns(network: Network, estimate: Sequence[str]) -> tuple[Unknown, ...]:
    """Return the interior and exterior unknowns of a network, in their order."""
    cameras = range(1, len(network.cameras) + 1)
    interior = [Unknown("camera", i, name) for i in cameras for name in estimate]
    exterior = [
        Unknown("photo", photo, name)
        for photo in network.photo_names
        for name in EXTERIOR
    ]
    return (*interior, *exterior)


def readable(unknowns: Sequence[Unknown]) -> tuple[str, ...]:
    """Return names to be read; that of an only camera goes without saying."""
    cameras = {one.owner for one in unknowns if one.kind == "camera"}
    return tuple(
        one.parameter
        if one.kind == "camera" and len(cameras) == 1
        else f"{one.parameter} of {one.kind} {one.owner}"
        for one in unknowns
    )
