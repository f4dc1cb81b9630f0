"""Space resection: the exterior orientation of one photo from known object points."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import chi2, f

from pgm_lab import _validate, imaging, rotation
from pgm_lab.adjustment import Adjustment, adjust
from pgm_lab.camera import Camera
from pgm_lab.orientation import three_points
from pgm_lab.orientation.rays import image_vectors

# Share of their longest extent by which points must leave a line.
ON_A_LINE = 1e-6
# Inflation of a variance, in the camera's own frame, that tells a weak geometry.
WEAK = 1e6
# Distance from the dangerous cylinder, in radii, that counts as near.
NEAR = 0.02


@dataclass(frozen=True)
class Resection:
    """Result of `resect`.

    Attributes
    ----------
    exterior : ndarray (6,)
        (X0, Y0, Z0, omega, phi, kappa), in the unit of the object points and radians;
        NaN if there is none or no way to choose one.
    covariance : ndarray (6, 6)
        Its covariance, sigma0^2 Q.
    sigma0 : float
        Standard deviation of an image coordinate from the residuals, in mm; NaN for
        three points, which leave no redundancy.
    redundancy : int
        2 n - 6.
    residuals : ndarray (n, 2)
        v = computed - observed, in mm.
    standardized : ndarray (n, 2)
        Residuals over their standard deviations.
    redundancy_numbers : ndarray (n, 2)
        Share of each coordinate in the redundancy.
    solutions : ndarray (k, 6)
        All solutions that were found, the best first.
    status : str
        "converged"; "several solutions": another one fits as well; "near the dangerous
        cylinder" or "weak geometry": the points hardly determine it; "points on a
        line"; "gimbal lock": omega and kappa are not determined one by one; "no
        solution" in front of which the points lie; "diverged"; "too many iterations".
    """

    exterior: np.ndarray
    covariance: np.ndarray
    sigma0: float
    redundancy: int
    residuals: np.ndarray
    standardized: np.ndarray
    redundancy_numbers: np.ndarray
    solutions: np.ndarray
    status: str


def resect(
    camera: Camera,
    image_points: ArrayLike,
    object_points: ArrayLike,
    start: ArrayLike | None = None,
    sigma: float | None = None,
) -> Resection:
    """Find where a photo was taken from, and how the camera was turned.

    Without start values, triples of points are solved in closed form, and the adjustment
    starts from each of their solutions. Four points or more, in general position, give
    one answer with its precision; three give up to four answers.

    Parameters
    ----------
    camera : Camera
    image_points : array_like (n, 2)
        Measured image coordinates, in mm.
    object_points : array_like (n, 3)
        The same points in object space, without errors.
    start : array_like (6,), optional
        Approximate exterior orientation. The adjustment then starts from here, and of
        several solutions the one it leads to is taken.
    sigma : float, optional
        Standard deviation of an image coordinate, in mm, known beforehand.

    Returns
    -------
    Resection

    Raises
    ------
    ValueError
        If shapes do not fit, numbers are not finite, or there are fewer than three
        points.

    References
    ----------
    Muliawan 2013, section 2.8, (2.63) to (2.68).

    Examples
    --------
    >>> ground = [[0, 0, 0], [100, 0, 5], [100, 80, -5], [0, 80, 10], [50, 30, 0]]
    >>> camera = Camera(50.0)
    >>> from pgm_lab.camera import project
    >>> image = project(camera, (40, 30, 120, 0.1, -0.05, 1.5), ground)
    >>> found = resect(camera, image, ground)
    >>> found.status, found.exterior.round(6).tolist()
    ('converged', [40.0, 30.0, 120.0, 0.1, -0.05, 1.5])
    """
    image_points, object_points = _observations(image_points, object_points)
    n = len(image_points)
    if _on_a_line(object_points):
        return _nothing(n, "points on a line")
    if start is None:
        centres, M = _closed_form(camera, image_points, object_points)
    else:
        start = _validate.points(start, 6, "start").reshape(6)
        centres, M = start[None, :3], rotation.matrix(*start[3:])[None]
    if not len(centres):
        return _nothing(n, "no solution")
    found, exteriors, transform = _adjust_from(
        camera, image_points, object_points, centres, M, sigma
    )
    best = _best(camera, image_points, object_points, found, exteriors)
    ...


def _adjust_from(camera, image_points, object_points, centres, M, sigma):
    """Adjust from each start (k, 3), (k, 3, 3) at once.

    Each in a frame of its own, parallel to its camera with the origin amid the points:
    there all angles are small, so that no attitude is near the gimbal lock.
    """
    middle = object_points.mean(axis=0)
    local = np.einsum("kij,nj->kni", M, object_points - middle)
    first = np.concatenate(
        [np.einsum("kij,kj->ki", M, centres - middle), np.zeros((len(M), 3))], axis=1
    )

    def collinearity(x, local):
        v, _, blocks = imaging.misclosure(
            camera.interior, x[:, None], local, image_points, camera.lens, ("exterior",)
        )
        return v.reshape(len(x), -1), blocks["exterior"].reshape(len(x), -1, 6)

    found = adjust(
        collinearity,
        first,
        np.zeros(image_points.size),
        sigma0_prior=sigma,
        args=(local,),
    )
    return found, middle, local
