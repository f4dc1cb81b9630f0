"""Absolute orientation: from model to object space by scale, rotation and shift.

target = scale * rotation @ source + translation, seven parameters. The closed form is
the start of an adjustment, which then gives weights, residuals and covariances.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.adjustment import adjust
from pgm_lab.orientation import _common

# Width over length of a set of points below which it counts as a line: the variance of
# the rotation about it grows with 1/width^2, and normal equations hold 12 digits of
# that.
LINE = 1e-6

# Extent over size of coordinates below which points differ by their rounding alone.
SAME = 1e-12

# A mirrored fit must be this much better in vᵀPv to be taken for one. Points in a
# plane fit a mirror equally well, and errors then decide which fits a little better.
MIRROR = 30.0


@dataclass(frozen=True)
class Absolute:
    """Similarity transformation in space, with its precision.

    Attributes
    ----------
    parameters : ndarray (7,)
        (scale, omega, phi, kappa, TX, TY, TZ); angles in radians.
    rotation : ndarray (3, 3)
        ``rotation.matrix(omega, phi, kappa).T``.
    covariance : ndarray (7, 7)
        Of the parameters: from `sigma` if it was given, else from sigma0.
    residuals : ndarray (n, 3)
        v = computed - observed, in the unit of the target.
    standardized : ndarray (n, 3)
        Baarda's w with `sigma`, else Pope's tau; 0 where nothing controls them.
    sigma0 : float
        Standard deviation of unit weight; without `sigma` that of a target coordinate.
    redundancy : int
        3 n - 7.
    status : str
        "converged"; "gimbal lock": omega and kappa are not separable, their rows of
        `covariance` are NaN; "weak geometry": the points lie nearly on a line, the
        covariance is rough; or a status of `adjust`.
    centroid : ndarray (3,)
        Of the source, for `local_covariance`.
    local_covariance : ndarray (7, 7)
        Of scale, small rotations about the target's axes, and transformed centroid; it
        has no gimbal lock.
    """

    parameters: np.ndarray
    rotation: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    standardized: np.ndarray
    sigma0: float
    redundancy: int
    status: str
    centroid: np.ndarray
    local_covariance: np.ndarray

    @property
    def scale(self) -> float:
        """Length in the target of a unit of the source."""
        return float(self.parameters[0])

    @property
    def translation(self) -> np.ndarray:
        """(TX, TY, TZ), in the unit of the target."""
        return self.parameters[4:]

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (7,) of the parameters."""
        return np.sqrt(np.diagonal(self.covariance))

    def apply(self, points: ArrayLike) -> np.ndarray:
        """Transform points (..., 3) of the source into the target."""
        # About the centroid: far from the origin T is large and partly cancels
        local = _validate.points(points, 3, "points") - self.centroid
        about = self.translation + self.scale * self.rotation @ self.centroid
        return self.scale * local @ self.rotation.T + about

    def apply_covariance(self, points: ArrayLike) -> np.ndarray:
        """Covariance (..., 3, 3) of transformed points, by that of the parameters."""
        local = _validate.points(points, 3, "points") - self.centroid
        J = _jacobian(self.scale, self.scale * local @ self.rotation.T)
        return J @ self.local_covariance @ np.swapaxes(J, -1, -2)


def absolute(
    source: ArrayLike, target: ArrayLike, sigma: ArrayLike | None = None
) -> Absolute:
    """Fit scale, rotation and translation from source points to target points.

    Parameters
    ----------
    source : array_like (n, 3)
        Points of the model, taken as free of errors.
    target : array_like (n, 3)
        The same points in object space.
    sigma : array_like, optional
        Standard deviations of the target's coordinates: one number, one a point (n,),
        or one a coordinate (n, 3). Equal and unknown when missing.

    Raises
    ------
    ValueError
        If there are fewer than three points, all lie at one place or on one line, or
        the target is the source's mirror image.

    Notes
    -----
    If source and target have errors of equal size in all directions, the estimate is
    the same; `sigma` is then sqrt(sigma_target^2 + scale^2 sigma_source^2).

    References
    ----------
    Horn 1987, "Closed-form solution of absolute orientation using unit quaternions",
    JOSA A 4(4); Umeyama 1991 (`rotation.best_fit`) for the start; Wolf and Dewitt 2000,
    "Elements of Photogrammetry", 3rd ed., for the adjustment.

    Examples
    --------
    >>> source = np.array([[0, 0, 0], [4, 0, 0], [0, 3, 0], [0, 0, 1.0]])
    >>> target = 2 * source + [100, 200, 300] + 0.01 * np.eye(4, 3)
    >>> found = absolute(source, target)
    >>> print(f"{found.scale:.4f} +- {found.sd[0]:.4f}, redundancy {found.redundancy}")
    1.9990 +- 0.0008, redundancy 5
    >>> found.apply([1.0, 1.0, 1.0]).round(2)
    array([102., 202., 302.])
    """
    source, target, sigma = _checked(source, target, sigma)
    weights = np.ones_like(target) if sigma is None else sigma**-2.0
    centroid, start, R0 = _closed_form(source, target, weights)
    local = (source - centroid) @ R0.T

    def transformed(x):
        # Small rotations of the closed form: unlike its angles they have no gimbal lock
        rotated = x[0] * local @ rotation.matrix(*x[1:4])
        J = _jacobian(x[0], rotated)
        J[..., 1:4] = J[..., 1:4] @ _common.axes(x[1:4])
        return (rotated + x[4:]).ravel(), J.reshape(-1, 7)

    # Adjust scale, rotation and the shift of the centroid
    rotations = (f"rotation about {axis}" for axis in "XYZ")
    names = ("scale", *rotations, "TX", "TY", "TZ")
    result = adjust(
        transformed,
        start,
        target.ravel(),
        weights=weights.ravel(),
        sigma0_prior=None if sigma is None else 1.0,
        names=names,
    )
    scale, about = result.x[0], result.x[4:]
    R = rotation.matrix(*result.x[1:4]).T @ R0
    L = np.eye(7)
    L[1:4, 1:4] = _common.axes(result.x[1:4])
    variance = result.sigma0**2 if sigma is None else 1.0
    local_covariance = variance * L @ result.cofactor @ L.T

    # From small rotations to angles, and from the centroid to the origin
    angles, by_rotation, locked = _common.angles(R)
    K = np.eye(7)
    K[1:4, 1:4] = by_rotation
    K[4:] = _jacobian(scale, -scale * R @ centroid)
    weak = np.linalg.eigvalsh(local_covariance[1:4, 1:4])[-1] > _common.WEAK**2
    status = "gimbal lock" if locked else "weak geometry" if weak else "converged"
    return Absolute(
        parameters=np.array([scale, *angles, *(about - scale * R @ centroid)]),
        rotation=R,
        covariance=K @ local_covariance @ K.T,
        residuals=result.residuals.reshape(-1, 3),
        standardized=result.standardized.reshape(-1, 3),
        sigma0=float(result.sigma0),
        redundancy=int(result.redundancy),
        status=status if result.status == "converged" else str(result.status),
        centroid=centroid,
        local_covariance=local_covariance,
    )


def _checked(
    source: ArrayLike, target: ArrayLike, sigma: ArrayLike | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    source = _validate.points(source, 3, "source")
    target = _validate.points(target, 3, "target")
    if source.ndim != 2 or source.shape != target.shape:
        raise ValueError(
            "source and target must have the same shape (n, 3); got"
            f" {source.shape} and {target.shape}"
        )
    if len(source) < 3:
        raise ValueError(
            f"source has {len(source)} point(s): seven parameters need three or more"
        )
    for name, points in (("source", source), ("target", target)):
        length, width, _ = _common.extents(points)
        if length <= SAME * np.abs(points).max():
            raise ValueError(
                f"{name}: all points lie at one place, which fixes neither scale nor"
                " rotation"
            )
        if width <= LINE * length:
            raise ValueError(
                f"{name}: all points lie on one line, and the rotation about it is"
                " free. Add a point off the line"
            )
    if sigma is None:
        return source, target, None
    sigma = _validate.positive(sigma, "sigma", "unit of target")
    if sigma.shape not in ((), (len(source),), source.shape):
        raise ValueError(
            f"sigma must be one number or have shape ({len(source)},) or"
            f" {source.shape}; got shape {sigma.shape}"
        )
    if sigma.ndim == 1:
        sigma = sigma[:, None]
    return source, target, np.broadcast_to(sigma, source.shape)


def _closed_form(
    source: np.ndarray, target: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centroid of the source, start values (7,) and their rotation."""
    # Exact if each point has one weight in all directions
    p = 1 / (1 / weights).mean(axis=1)
    centroid, about = (
        np.average(points, axis=0, weights=p) for points in (source, target)
    )
    s, t = source - centroid, target - about
    R, D = rotation.best_fit((p[:, None] * t).T @ s)
    source_squares, target_squares = (p @ (points**2).sum(axis=1) for points in (s, t))
    scale = D.sum() / source_squares
    if D[2] < 0:
        # vᵀPv of the best rotation and of the best reflection
        rotated, mirrored = (
            target_squares - np.array([D.sum(), np.abs(D).sum()]) ** 2 / source_squares
        )
        mirrored = max(mirrored, 1e-12 * target_squares)
        if rotated > MIRROR * mirrored:
            raise ValueError(
                "target is a mirror image of source: with one axis reversed it"
                f" fits {np.sqrt(rotated / mirrored):.0f} times better. Is y or z"
                " counted in the opposite direction in one of them?"
            )
    if D[1] + D[2] <= 1e-12 * D[0]:
        raise ValueError(
            "source and target do not fit together: several rotations are equally bad."
            " Are the points in the same order?"
        )
    return centroid, np.array([scale, 0, 0, 0, *about]), R


def _jacobian(scale: float, y: np.ndarray) -> np.ndarray:
    """Derivatives (..., 3, 7) of scale R p + shift by scale, small rotations, shift."""
    J = np.zeros((*y.shape, 7))
    J[..., 0] = y / scale
    J[..., 1:4] = -_common.cross_matrix(y)
    J[..., 4:] = np.eye(3)
    return J
