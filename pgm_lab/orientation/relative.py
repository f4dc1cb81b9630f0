"""Relative orientation: two photos of the same points give a model without a scale.

The left photo stands at the origin with zero angles, bx is fixed, and five unknowns
remain: by, bz, omega, phi, kappa of the right photo.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.adjustment import Adjustment, RankDefect, adjust
from pgm_lab.camera import Camera, ideal, imaging
from pgm_lab.orientation import _common, coplanarity
from pgm_lab.orientation.rays import nearest_factors

NAMES = ("by", "bz", "rotation about X", "rotation about Y", "rotation about Z")

# --- Limits of the geometry ---

# Misfit of rays after a rotation alone (over c) below which there is no parallax.
NO_PARALLAX = 1e-9
# Width over length of a set of image points below which they count as a line.
LINE = 1e-9
# Cosine between base and x axis below which bx may be too small to hold the scale, and
# below which it is.
ACROSS = 1e-2
ALL_ACROSS = 1e-3
# The base is lost in the noise if a rotation alone leaves less than this many sigma.
NO_BASE = 3.0

# --- The search for models ---

# Grid of rotations: tilts of the right photo (degrees) and the number of directions of
# each, with this number of swings about the axis.
TILTS = {0: 1, 35: 6, 70: 10, 105: 10}
SWINGS = 8
# A given start is tried as it is, and rotated by this angle (rad) about each axis.
AROUND_START = 0.4
# Number of points of the search; iterations of its three steps, and the models that
# they keep. Five or six points (FEW) have many solutions, and all are wanted.
POINTS = 12
ITERATIONS = (8, 15, 10)
FEW = 6
KEPT = (100, 12, 6)
KEPT_OF_FEW = (216, 30, 20)
# Models whose residuals after the first step are a larger part of the principal
# distance are dropped, unless the best one has such residuals.
MAX_MISFIT = 2e-3
MAX_MISFIT_OF_FEW = 0.1
# Models are the same when rotation and base direction differ by less (rad).
SAME_MODEL = 1e-3
# vᵀPv of two models differ by chance less than this quantile of their ratio.
LEVEL = 0.999
# The base has the wrong sign if models with all points behind both cameras fit this
# many times better: points in a plane have such models too, which may fit a little
# better.
WRONG_SIGN = 100
# Residuals below this part of the principal distance are rounding.
ROUNDING = 1e-9

Models = tuple[np.ndarray, np.ndarray]  # base (..., 3) and rotation (..., 3, 3)
Rays = tuple[np.ndarray, np.ndarray]  # (x, y, -c), (n, 3), of the left and right photo


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
        Baarda's w with `sigma`, else Pope's tau: one a point, whose four coordinates
        one condition controls; 0 where nothing does.
    sigma0 : float
        Standard deviation of an image coordinate from the residuals, in mm; NaN with
        five points, which have no redundancy.
    redundancy : int
        n - 5.
    status : str
        "converged"; "no redundancy": five points; "several solutions": another model
        fits as well (a `sigma` helps, and points outside of one plane); "no base": a
        rotation alone fits as well; "weak geometry": a direction is uncertain by more
        than 0.1 rad; "gimbal lock": omega and kappa are not separable, their covariance
        is NaN; "points behind a camera": see `point_status`; or a status of `adjust`.
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

    Raises
    ------
    ValueError
        If there are fewer than five points, one is given twice, they lie on a line or
        have no parallax, the base has the wrong sign, or the points do not determine
        the five unknowns.

    Notes
    -----
    The conditions A v + B d = -F of (M 2.37) are adjusted without approximation, see
    `coplanarity.distances`. Of points in one plane the base and its opposite may both
    have a model in front of the cameras: the status is "several solutions", and the
    sign of `base` may decide.

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
    rays = _rays(camera_left, camera_right, left_points, right_points)
    bx = 1.0 if base is None else _validate.number(base, "base")
    if bx == 0:
        raise ValueError("base must not be 0: it fixes bx, and with it the scale")
    sigma = _validate.standard_deviation(sigma)
    rotation_alone = _rotation_alone(rays)

    # Search for all models, adjust the best one
    near = None if start is None else _start(bx, start, both_signs=base is None)
    models = _search(bx, rays, near)
    if base is None:
        models = _in_front(models, rays)
    bases, rotations = _best(models, rays, sigma, near)
    solutions = [[*b, *_common.angles(R)[0]] for b, R in zip(bases, rotations)]
    result, (b, R) = _adjusted((bases[0], rotations[0]), rays, sigma)

    # Its points and its precision
    model = _intersected((b, R), rays)
    noise = result.sigma0 if sigma is None else sigma
    Q = _cofactor(result)
    angles, by_rotation, locked = _common.angles(R)
    to_exterior = np.zeros((6, 5))
    to_exterior[1:3, :2], to_exterior[3:, 2:] = np.eye(2), by_rotation
    point_status = np.where(model.in_front, "intersected", "behind a camera")
    point_status[model.parallel] = "parallel rays"
    met = point_status == "intersected"
    points_covariance = noise**2 * _points_cofactor((b, R), rays, Q)
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


# --- Arguments ---


def _rays(
    camera_left: Camera,
    camera_right: Camera,
    left_points: ArrayLike,
    right_points: ArrayLike,
) -> Rays:
    """Rays of both photos, if they can determine a model."""
    _validate.instance(camera_left, Camera, "camera_left")
    _validate.instance(camera_right, Camera, "camera_right")
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
    sizes = (_common.extents(rays[:, :2]) for rays in (left, right))
    if all(width <= LINE * length for length, width in sizes):
        raise ValueError(
            "left_points and right_points lie on lines (or at one place): the photo can"
            " rotate about such a line. Add points off the line"
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


def _rotation_alone(rays: Rays) -> float:
    """Root mean square in mm of what a rotation without a base leaves unexplained."""
    u1, u2 = (u / np.linalg.norm(u, axis=1, keepdims=True) for u in rays)
    R, _ = rotation.best_fit(u1.T @ u2)
    c = -rays[0][0, 2]
    rms = c * np.sqrt(np.sum((u1 - u2 @ R.T) ** 2) / (2 * len(u1) - 3))
    if rms <= NO_PARALLAX * c:
        raise ValueError(
            "left_points and right_points differ by a rotation only (or not at all):"
            " without a base there is no parallax and no model. The same photo twice?"
        )
    return rms


def _start(bx: float, start: ArrayLike, both_signs: bool) -> Models:
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


# --- One model: its adjustment, its points and their precision ---


def _fit(
    models: Models, rays: Rays, sigma: float | None = None, max_iterations: int = 50
) -> tuple[Adjustment, Models]:
    """Adjust (by, bz) and the rotation of one model or of a stack; all have one bx."""
    base, R = models
    bx = base.flat[0]
    # Counted from c instead of zero, because the adjustment takes the size of the
    # observations for that of the numbers which were rounded
    c = -rays[0][0, 2]
    start = np.concatenate([base[..., 1:], np.zeros_like(base)], axis=-1)

    def model(x, R0):
        # Small rotations of the start: unlike angles they have no gimbal lock
        rotated = rotation.matrix(*np.moveaxis(x[..., 2:], -1, 0))
        b = np.concatenate([np.full((*x.shape[:-1], 1), bx), x[..., :2]], axis=-1)
        return b, np.swapaxes(rotated, -1, -2) @ R0

    def distances(x, R0):
        b, rotated = model(x, R0)
        found = coplanarity.distances(b, rotated, *rays)
        by_rotation = found.by_rotation @ _common.axes(x[..., 2:])
        A = np.concatenate([found.by_base[..., 1:], by_rotation], axis=-1)
        return c + found.distance, A

    result = adjust(
        distances,
        start,
        np.full(len(rays[0]), c),
        sigma0_prior=sigma,
        args=(R,),
        names=NAMES,
        max_iterations=max_iterations,
    )
    finite = np.isfinite(result.x).all(axis=-1, keepdims=True)
    return result, model(np.where(finite, result.x, start), R)


def _adjusted(
    models: Models, rays: Rays, sigma: float | None
) -> tuple[Adjustment, Models]:
    """Adjust the chosen model to all points, which may not determine it."""
    try:
        return _fit(models, rays, sigma)
    except RankDefect as defect:
        base = models[0]
        if abs(base[0]) > ACROSS * np.linalg.norm(base):
            raise
        raise ValueError(
            "the base is at right angles to the x axis of the left photo, so that bx"
            " cannot set the scale. Rotate the image coordinates of the left photo by"
            " 90 degrees, (x, y) to (y, -x), if the base lies along its y axis"
        ) from defect


def _cofactor(result: Adjustment) -> np.ndarray:
    """Cofactors (5, 5) of by, bz and small rotations after the adjustment."""
    to_turns = np.eye(5)
    to_turns[2:, 2:] = _common.axes(result.x[2:])
    return to_turns @ result.cofactor @ to_turns.T


@dataclass(frozen=True)
class _Model:
    """Points (..., n, 3) of a model, and on which side of the cameras they lie."""

    conditions: coplanarity.Coplanarity
    points: np.ndarray
    in_front: np.ndarray
    behind_both: np.ndarray
    parallel: np.ndarray


def _intersected(models: Models, rays: Rays) -> _Model:
    """Intersect the corrected rays, which meet."""
    base, R = models
    found = coplanarity.distances(base, R, *rays)
    u1 = coplanarity.corrected(rays[0], found.left)
    u2 = coplanarity.corrected(rays[1], found.right) @ np.swapaxes(R, -1, -2)
    factors, parallel = nearest_factors(base[..., None, :], u1, u2)
    in_front = np.all(factors > 0, axis=-1)
    behind_both = np.all(factors < 0, axis=-1)
    return _Model(found, factors[..., :1] * u1, in_front, behind_both, parallel)


def _points_cofactor(models: Models, rays: Rays, Q: np.ndarray) -> np.ndarray:
    """Cofactors (n, 3, 3) of the points from those (5, 5) of the orientation."""
    # The collinearity equations of all points have the same solution; there one point
    # is N_pp^-1 + N_pp^-1 N_pe Q N_ep N_pp^-1
    base, R = models
    points = _intersected(models, rays).points
    away = points - base
    by_left = imaging.perspective(-rays[0][0, 2], points)[2]
    by_right = imaging.perspective(-rays[1][0, 2], away @ R)[2] @ R.T
    # A rotation psi of the photo moves the point, seen from it, by -psi x away
    by_rotation = by_right @ _common.cross_matrix(away)
    by_orientation = np.concatenate([-by_right[..., 1:], by_rotation], axis=-1)
    across = np.swapaxes(by_right, -1, -2)
    N = np.swapaxes(by_left, -1, -2) @ by_left + across @ by_right
    with np.errstate(invalid="ignore"):  # NaN of rays that are parallel
        N[np.linalg.det(N) == 0] = np.nan  # nearly so: the distance is not known
    N_inverse = np.linalg.inv(N)
    G = N_inverse @ across @ by_orientation
    return N_inverse + G @ Q @ np.swapaxes(G, -1, -2)


def _weak(base: np.ndarray, covariance: np.ndarray) -> bool:
    """Whether the rotation, or the direction of the base, is very uncertain."""
    length = np.linalg.norm(base)
    across = (np.eye(3) - np.outer(base, base) / length**2)[:, 1:] / length
    directions = (covariance[2:, 2:], across @ covariance[:2, :2] @ across.T)
    return any(np.trace(part) > _common.WEAK**2 for part in directions)


# --- Models from no start, and which of them fit ---


def _search(bx: float, rays: Rays, near: Models | None = None) -> Models:
    """Models (k) that fit, from a grid of rotations (around `near`)."""
    # Adjusted to a few points at once, then the best of the different models to all
    few = len(rays[0]) <= FEW
    first, second, last = KEPT_OF_FEW if few else KEPT
    chosen = _spread(rays[0], POINTS)
    some = rays[0][chosen], rays[1][chosen]

    # Start from the rotations whose best bases fit least badly
    R = _rotation_grid() if near is None else _around(near[1][0])
    base = _base_for(R, some, bx)
    if near is not None:
        given = [np.broadcast_to(one, base.shape) for one in near[0]]
        R = np.concatenate([R] * (1 + len(given)))
        base = np.concatenate([base, *given])
    misfit = coplanarity.distances(base, R, *some).distance
    start = np.argsort(np.sum(misfit**2, axis=-1))[:first]

    # Adjust roughly, and keep what may still come near the best one
    result, models = _fit((base[start], R[start]), some, max_iterations=ITERATIONS[0])
    misfit = np.sum(result.residuals**2, axis=-1)
    largest = (MAX_MISFIT_OF_FEW if few else MAX_MISFIT) * some[0][0, 2]
    limit = len(some[0]) * largest**2
    kept = misfit <= max(1e4 * np.nanmin(misfit, initial=np.inf), limit)
    models = _first_that_differ(models, kept, misfit, some, second)

    # Adjust on, to some points and to all
    models = _converged(models, some, ITERATIONS[1], last)
    if len(rays[0]) > len(some[0]):
        models = _converged(models, rays, ITERATIONS[2], last)
    return models


def _converged(models: Models, rays: Rays, iterations: int, count: int) -> Models:
    """Adjust, and keep what has converged or fits better without."""
    result, models = _fit(models, rays, max_iterations=iterations)
    misfit = np.sum(result.residuals**2, axis=-1)
    kept = result.status == "converged"
    # In weak geometry the best one may be slow
    kept |= misfit < np.min(misfit[kept], initial=np.inf)
    return _first_that_differ(models, kept, misfit, rays, count)


def _first_that_differ(
    models: Models, kept: np.ndarray, misfit: np.ndarray, rays: Rays, count: int
) -> Models:
    """The first `count` models that differ, with the points on one side if possible."""
    base, R = models[0][kept], models[1][kept]
    if not len(base):
        raise ValueError(
            "no model was found: the points do not determine the five unknowns. Are"
            " they spread over the common area, and in the same order in both photos?"
        )
    model = _intersected((base, R), rays)
    # In front of both cameras or, if the base has the wrong sign, behind both
    one_side = np.mean(model.in_front | model.behind_both, axis=-1) > 0.5
    order = np.lexsort((misfit[kept], ~one_side))

    # Leave out what repeats a model before it
    b = base / np.linalg.norm(base, axis=-1, keepdims=True)
    apart = np.linalg.norm(b[:, None] - b, axis=-1)
    apart = apart + np.linalg.norm(R[:, None] - R, axis=(-2, -1))
    same = (apart < SAME_MODEL)[np.ix_(order, order)]
    first = order[~np.any(np.tril(same, -1), axis=1)][:count]
    return base[first], R[first]


def _in_front(models: Models, rays: Rays) -> Models:
    """Reverse the base of models whose points lie behind both cameras."""
    # The base and its opposite fit equally well: only the side of the points differs
    base, R = models
    model = _intersected(models, rays)
    behind = np.sum(model.behind_both, axis=-1) > np.sum(model.in_front, axis=-1)
    return np.where(behind[:, None], -base, base), R


def _best(
    models: Models, rays: Rays, sigma: float | None, near: Models | None = None
) -> Models:
    """Models that fit equally well, the best first, or the one most like `near`."""
    base, R = models
    model = _intersected(models, rays)
    misfit = np.sum(model.conditions.distance**2, axis=-1)
    front = np.mean(model.in_front, axis=-1)
    behind = np.mean(model.behind_both, axis=-1)
    upright, upside_down = front > 0.5, behind > 0.5
    plausible = upright | upside_down
    if not plausible.any():
        best = [np.argmin(misfit)]
        return base[best], R[best]
    least = np.min(misfit[upright], initial=np.inf)
    if least > WRONG_SIGN * _limit(misfit[plausible].min(), rays, sigma):
        raise ValueError(
            f"base = {base[0, 0]:g} has the wrong sign: the points would lie behind"
            f" both cameras. Write base = {-base[0, 0]:g}, or leave base out to have"
            " its sign found"
        )
    fits = upright & (misfit <= _limit(least, rays, sigma))
    along = np.abs(base[:, 0]) > ALL_ACROSS * np.linalg.norm(base, axis=1)
    if np.any(fits & along):
        fits &= along
    fits &= front == front[fits].max()
    if near is not None:
        misfit = np.linalg.norm(R - near[1][0], axis=(-2, -1))
    order = np.lexsort((misfit, ~fits))[: np.count_nonzero(fits)]
    return base[order], R[order]


def _limit(least: float, rays: Rays, sigma: float | None) -> float:
    """Sum of squares up to which a model fits as well as the best one."""
    n, c = len(rays[0]), rays[0][0, 2]
    if n > 5:
        least = _common.largest_objective(least, n - 5, sigma, LEVEL)
    return least + n * (ROUNDING * c) ** 2


def _spread(left: np.ndarray, count: int) -> np.ndarray:
    """Indices of some points, in all directions from the middle of the photo."""
    from_middle = left[:, :2] - left[:, :2].mean(axis=0)
    order = np.argsort(np.arctan2(from_middle[:, 1], from_middle[:, 0]))
    count = min(count, len(left))
    return order[np.linspace(0, len(left) - 1, count).round().astype(int)]


def _rotation_grid() -> np.ndarray:
    """Rotations (k, 3, 3), image to object, some 40 degrees apart."""
    tilt = np.radians(np.repeat(list(TILTS), list(TILTS.values())))
    azimuth = np.concatenate(
        [np.arange(k) * 2 * np.pi / k + 0.1 for k in TILTS.values()]
    )
    swing = np.arange(SWINGS) * 2 * np.pi / SWINGS
    M = rotation.from_tilt_azimuth_swing(
        tilt[:, None], azimuth[:, None], swing + azimuth[:, None]
    )
    return np.swapaxes(M.reshape(-1, 3, 3), -1, -2)


def _around(R: np.ndarray) -> np.ndarray:
    """R (3, 3) and R rotated about each axis either way, (7, 3, 3)."""
    rotations = AROUND_START * np.concatenate([np.zeros((1, 3)), np.eye(3), -np.eye(3)])
    return rotation.matrix(*rotations.T) @ R


def _base_for(R: np.ndarray, rays: Rays, bx: float) -> np.ndarray:
    """For each rotation the base most nearly at right angles to all u' x u''."""
    u1, u2 = (u / np.linalg.norm(u, axis=-1, keepdims=True) for u in rays)
    n = np.cross(u1, u2 @ np.swapaxes(R, -1, -2))
    b = np.linalg.eigh(np.swapaxes(n, -1, -2) @ n)[1][..., 0]
    along = np.where(np.abs(b[..., :1]) < 0.1, np.copysign(0.1, b[..., :1]), b[..., :1])
    return bx * np.concatenate([np.ones_like(along), b[..., 1:] / along], axis=-1)
