"""Relative orientation: two photos of the same points give a model without a scale.

The left photo stands at the origin with zero angles, bx is fixed, and five unknowns
remain: by, bz, omega, phi, kappa of the right photo.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.adjustment import Adjustment, RankDefect
from pgm_lab.camera import Camera, ideal
from pgm_lab.orientation import _model, _search, _turns
from pgm_lab.orientation.three_points import extents

# Rays that a rotation alone brings together this well (over c) have no parallax at all.
NO_PARALLAX = 1e-9

# Width over length of a set of image points below which they count as a line.
LINE = 1e-9

# Cosine between base and x axis below which bx may be too small to hold the scale.
ACROSS = 1e-2

# The base is lost in the noise if a rotation alone leaves less than so many sigma.
NO_BASE = 3.0


@dataclass(frozen=True)
class Relative:
    """Result of `relative`, in the unit of the base and in radians.

    Attributes
    ----------
    exterior : ndarray (6,)
        (bx, by, bz, omega, phi, kappa) of the right photo.
    covariance : ndarray (6, 6)
        Its covariance, zero for bx: from `sigma` if it was given, else from sigma0.
    points : ndarray (n, 3)
        Model points, where the corrected rays meet; NaN unless their `point_status` is
        "intersected".
    points_covariance : ndarray (n, 3, 3)
        Covariance of each point, from its own image coordinates and the orientation.
    residuals : ndarray (2, n, 2)
        v = computed - observed in the left and the right photo, in mm; of image
        coordinates freed from principal point and lens distortion.
    standardized : ndarray (n,)
        Residuals over their standard deviations (Baarda's w with `sigma`, else Pope's
        tau): one for a point, because its four coordinates are controlled by one
        condition. 0 where nothing controls them.
    sigma0 : float
        Standard deviation of an image coordinate from the residuals, in mm; NaN with
        five points, which have no redundancy.
    redundancy : int
        n - 5.
    status : str
        "converged"; "no redundancy": five points, nothing is controlled; "several
        solutions": another model fits as well, see `solutions` (a `sigma` helps to tell
        them apart, and points outside of one plane); "no base": a rotation
        alone fits as well; "weak geometry": a direction is uncertain by more than 0.1
        rad; "gimbal lock": omega and kappa are not told apart, their covariance is NaN;
        "points behind a camera": see `point_status`; or what the adjustment reports.
    point_status : ndarray (n,) of str
        "intersected", "behind a camera", "parallel rays".
    solutions : ndarray (k, 6)
        Exteriors of all models that fit equally well, of which the first is `exterior`:
        the best one or, if `start` was given, the one most like it.
    """

    exterior: np.ndarray
    covariance: np.ndarray
    points: np.ndarray
    points_covariance: np.ndarray
    residuals: np.ndarray
    standardized: np.ndarray
    sigma0: float
    redundancy: int
    status: str
    point_status: np.ndarray
    solutions: np.ndarray

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (6,) of the exterior; 0 for bx."""
        return np.sqrt(np.diagonal(self.covariance))


def relative(
    camera_left: Camera,
    camera_right: Camera,
    left_points: ArrayLike,
    right_points: ArrayLike,
    *,
    base: float | None = None,
    start: ArrayLike | None = None,
    sigma: float | None = None,
) -> Relative:
    """Orient the right photo relative to the left one.

    Parameters
    ----------
    camera_left, camera_right : Camera
    left_points, right_points : array_like (n, 2)
        Measured image coordinates of the same points in mm; five or more.
    base : float, optional
        bx, in the unit of the model: positive if the right station lies on the positive
        x side of the left photo. When missing, 1 or -1: with the points in front.
    start : array_like (5,), optional
        Rough values of by, bz (in the unit of the base), omega, phi, kappa: 30 degrees
        and half the base off will do. The search without them takes ten times as long.
    sigma : float, optional
        Standard deviation of an image coordinate in mm, known beforehand; it holds for
        coordinates freed from lens distortion.

    Returns
    -------
    Relative

    Raises
    ------
    ValueError
        If shapes do not fit, numbers are not finite, there are fewer than five points,
        a point is given twice, they lie on a line or have no parallax, the given base
        has the wrong sign, or the points do not determine the five unknowns.

    Notes
    -----
    The coplanarity conditions A v + B d = -F of (M 2.37) are adjusted without a detour
    or an approximation: see `coplanarity.distances`.

    Of points in one plane the base and its opposite may both have a model in front of
    the cameras: the status is "several solutions", and the sign of `base` may decide.

    References
    ----------
    (M 2.30) to (M 2.45); Wolf and Dewitt 2000, "Elements of Photogrammetry", 3rd ed.,
    for the same result by collinearity.

    Examples
    --------
    >>> camera = Camera(50.0)
    >>> left = [[0, 0], [20, 2], [1, 18], [19, 21], [2, -19], [21, -18]]
    >>> right = [[-20, 0], [0, 2.04], [-17, 18], [1, 21], [-19, -19], [2, -18]]
    >>> found = relative(camera, camera, left, right, base=60.0)
    >>> print(found.status, found.redundancy, f"{found.sigma0:.3f} mm")
    converged 1 0.013 mm
    >>> exchanged = relative(camera, camera, right, left)
    >>> print(f"bx = {exchanged.exterior[0]:g}")
    bx = -1
    """
    _validate.instance(camera_left, Camera, "camera_left")
    _validate.instance(camera_right, Camera, "camera_right")
    left, right = _rays(camera_left, camera_right, left_points, right_points)
    bx = 1.0 if base is None else _validate.number(base, "base")
    if bx == 0:
        raise ValueError("base must not be 0: it fixes bx, and with it the scale")
    sigma = _validate.standard_deviation(sigma)
    rotation_alone = _rotation_alone(left, right)
    near = None if start is None else _start(bx, start, both_signs=base is None)
    models = _search.models(bx, left, right, near)
    if base is None:
        models = _search.in_front(*models, left, right)
    bases, rotations = _search.best(*models, left, right, sigma, near)
    solutions = [[*b, *_turns.angles(R)[0]] for b, R in zip(bases, rotations)]

    result, b, R = _fitted(bases[0], rotations[0], left, right, sigma)
    model = _model.intersect(b, R, left, right)
    noise = result.sigma0 if sigma is None else sigma
    Q = _model.cofactor(result)
    angles, by_turns, locked = _turns.angles(R)
    to_exterior = np.zeros((6, 5))
    to_exterior[1:3, :2], to_exterior[3:, 2:] = np.eye(2), by_turns

    point_status = np.where(model.in_front, "intersected", "behind a camera")
    point_status[model.parallel] = "parallel rays"
    met = point_status == "intersected"
    points_covariance = noise**2 * _model.points_cofactor(b, R, left, right, Q)
    warnings = {
        "no base": rotation_alone < NO_BASE * noise,
        str(result.status): result.status != "converged",
        "several solutions": len(solutions) > 1,
        "weak geometry": _weak(b, noise**2 * Q),
        "points behind a camera": not np.all(met),
        "gimbal lock": locked,
        "no redundancy": result.redundancy == 0,
    }
    return Relative(
        exterior=np.concatenate([b, angles]),
        covariance=noise**2 * to_exterior @ Q @ to_exterior.T,
        points=np.where(met[:, None], model.points, np.nan),
        points_covariance=np.where(met[:, None, None], points_covariance, np.nan),
        residuals=np.stack([model.conditions.left, model.conditions.right]),
        standardized=result.standardized,
        sigma0=float(result.sigma0),
        redundancy=int(result.redundancy),
        status=next((name for name, true in warnings.items() if true), "converged"),
        point_status=point_status,
        solutions=np.array(solutions),
    )


def _rays(
    camera_left: Camera,
    camera_right: Camera,
    left_points: ArrayLike,
    right_points: ArrayLike,
) -> tuple[np.ndarray, np.ndarray]:
    """Rays (n, 3) in the frames of both photos."""
    left, right = (
        np.insert(ideal(camera, _image_points(points, name)), 2, -camera.c, axis=1)
        for camera, points, name in (
            (camera_left, left_points, "left_points"),
            (camera_right, right_points, "right_points"),
        )
    )
    if left.shape != right.shape:
        raise ValueError(
            f"left_points, right_points must pair up; got {len(left)} and {len(right)}"
        )
    sizes = (extents(rays[:, :2]) for rays in (left, right))
    if all(width <= LINE * length for length, width in sizes):
        raise ValueError(
            "left_points and right_points lie on lines (or at one place): the photo can"
            " turn about such a line. Add points off the line"
        )
    _, first = np.unique(np.hstack([left, right]), axis=0, return_index=True)
    if len(again := np.setdiff1d(np.arange(len(left)), first)):
        raise ValueError(
            f"point {again[0]} is given twice, and would control itself: leave one out"
        )
    return left, right


def _image_points(points: ArrayLike, name: str) -> np.ndarray:
    points = _validate.points(points, 2, name)
    if points.ndim != 2 or len(points) < 5 or not np.ptp(points, axis=0).any():
        raise ValueError(
            f"{name} must have shape (n, 2) with five or more points, not all at one"
            f" place; got {points.shape}"
        )
    return points


def _rotation_alone(left: np.ndarray, right: np.ndarray) -> float:
    """Root mean square in mm of what a rotation without a base leaves unexplained."""
    u1, u2 = (
        rays / np.linalg.norm(rays, axis=1, keepdims=True) for rays in (left, right)
    )
    R, _ = rotation.best_fit(u1.T @ u2)
    c = -left[0, 2]
    rms = c * np.sqrt(np.sum((u1 - u2 @ R.T) ** 2) / (2 * len(left) - 3))
    if rms <= NO_PARALLAX * c:
        raise ValueError(
            "left_points and right_points differ by a rotation only (or not at all):"
            " without a base there is no parallax and no model. The same photo twice?"
        )
    return rms


def _start(bx: float, start: ArrayLike, both_signs: bool) -> _search.Models:
    """Bases (1, 3) or (2, 3) and rotation (1, 3, 3) of rough values."""
    start = _validate.finite(start, "start")
    if start.shape != (5,):
        raise ValueError(
            "start must be (by, bz, omega, phi, kappa), five numbers in the unit of the"
            f" base and radians; got shape {start.shape}"
        )
    by, bz = start[:2]
    # All models of the search have the same bx: (-bx, by, bz) stands in it reversed
    bases = [(bx, by, bz), (bx, -by, -bz)][: 1 + both_signs]
    return np.array(bases), rotation.matrix(*start[2:]).T[None]


def _fitted(
    b: np.ndarray,
    R: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    sigma: float | None,
) -> tuple[Adjustment, np.ndarray, np.ndarray]:
    """The adjusted model; the points may not determine it."""
    try:
        return _model.fit(b, R, left, right, sigma)
    except RankDefect as defect:
        if abs(b[0]) > ACROSS * np.linalg.norm(b):
            raise
        raise ValueError(
            "the base is at right angles to the x axis of the left photo, so that bx"
            " cannot set the scale. Turn the image coordinates of the left photo by 90"
            " degrees, (x, y) to (y, -x), if the base lies along its y axis"
        ) from defect


def _weak(base: np.ndarray, covariance: np.ndarray) -> bool:
    """Whether a turn, or the direction of the base, is uncertain by a large angle."""
    length = np.linalg.norm(base)
    across = (np.eye(3) - np.outer(base, base) / length**2)[:, 1:] / length
    directions = (covariance[2:, 2:], across @ covariance[:2, :2] @ across.T)
    return any(np.trace(part) > _turns.WEAK**2 for part in directions)
