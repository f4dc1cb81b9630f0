"""Space resection: the exterior orientation of one photo from known object points.

Triples of points are solved in closed form; an adjustment of all points starts from
each of their solutions.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.adjustment import Adjustment, adjust
from pgm_lab.camera import Camera, ideal, imaging
from pgm_lab.orientation import _common
from pgm_lab.orientation.rays import image_vectors

# Inflation of a variance, in the camera's own frame, above which the geometry is weak.
WEAK = 1e6
# Starts of the adjustment, at most; and the misfit (rad) of the rays beyond which one
# is dropped, unless the best start is not much better.
STARTS = 12
MAX_MISFIT = 1e-3
# vᵀv of two solutions differ by chance less than this quantile of their ratio.
LEVEL = 0.99
# Distance between two solutions, as a share of that to the points, that makes them one.
SAME = 1e-5
# Share of their longest extent by which points must leave a line.
ON_A_LINE = 1e-6
# The same where the adjustment fails, which then is the reason.
NEARLY_ON_A_LINE = 1e-3
# A mirrored image must fit this much better in vᵀv to be taken for one, if the
# residuals are larger than this share of the principal distance.
MIRROR = 30.0
LARGE = 1e-4
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
        Its covariance: from `sigma` if it was given, else from sigma0; NaN for omega
        and kappa in gimbal lock.
    sigma0 : float
        Standard deviation of an image coordinate from the residuals, in mm; NaN for
        three points, which have no redundancy.
    redundancy : int
        2 n - 6.
    residuals : ndarray (n, 2)
        v = computed - observed, in mm.
    standardized : ndarray (n, 2)
        Baarda's w with `sigma`, else Pope's tau.
    redundancy_numbers : ndarray (n, 2)
        Share of each coordinate in the redundancy.
    solutions : ndarray (k, 6)
        All solutions that were found, the best first.
    status : str
        "converged"; "several solutions": another one fits as well; "near the dangerous
        cylinder" or "weak geometry": the points hardly determine it; "points on a
        line", or too near to one; "gimbal lock": omega and kappa are not determined one
        by one; "no solution": none has all points in front of the camera; "diverged";
        "too many iterations".
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
    """Exterior orientation of a photo from known points.

    Without start values, triples of points are solved in closed form, and the
    adjustment starts from each of their solutions. Four points or more, in general
    position, give one answer with its precision; three give up to four answers, however
    often each of them was measured.

    Parameters
    ----------
    camera : Camera
    image_points : array_like (n, 2)
        Measured image coordinates, in mm.
    object_points : array_like (n, 3)
        The same points in object space, without errors.
    start : array_like (6,), optional
        Approximate exterior orientation: one more start of the adjustment, and of
        several solutions that fit equally well the one nearest to it is taken.
    sigma : float, optional
        Standard deviation of an image coordinate, in mm, known beforehand.

    Raises
    ------
    ValueError
        If there are fewer than three points, one is given twice with the same image
        coordinates, or the image is mirrored.

    Notes
    -----
    A mirrored image of points in one plane fits as well as the image itself, from the
    other side of the plane: a station below the ground points to a reversed x or y.

    References
    ----------
    Muliawan 2013, section 2.8: (M 2.63) to (M 2.68).

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
    _validate.instance(camera, Camera, "camera")
    sigma = _validate.standard_deviation(sigma)
    n = len(image_points)
    different = len(np.unique(object_points, axis=0))
    if _on_a_line(object_points):
        return _no_result(n, "points on a line")

    # Starts from triples of points, and the one that was given
    centres, M = _closed_form(camera, image_points, object_points)
    if start is not None:
        start = _validate.points(start, 6, "start")
        start = _validate.one_point(start.squeeze(), 6, "start")
        centres = np.concatenate([centres, start[None, :3]])
        M = np.concatenate([M, rotation.matrix(*start[3:])[None]])
    if not len(centres):
        return _no_result(n, "no solution")

    # Adjust all points from each start
    found, x = _adjusted(camera, image_points, object_points, centres, M, sigma)
    if not np.any(found.status == "converged"):
        return _no_result(n, _failure(found, centres, object_points))

    # From the frame of each start to object space
    back = np.swapaxes(M, 1, 2)
    M = rotation.matrix(*x[:, 3:].T) @ M
    centres = np.einsum("kij,kj->ki", back, x[:, :3]) + object_points.mean(axis=0)

    # Choose the best solution, and others that fit as well
    chosen = _chosen(found, centres, M, object_points, different)
    if not chosen:
        return _no_result(n, _failure(found, centres, object_points))
    if start is not None:
        chosen.sort(key=lambda k: np.linalg.norm(centres[k] - start[:3]))
    best, rotated = chosen[0], [_common.angles(M[k].T) for k in chosen]
    exteriors = np.array([[*centres[k], *t[0]] for k, t in zip(chosen, rotated)])
    status = _status(found, chosen, centres, object_points, different)
    _refuse_mirrored(camera, image_points, object_points, found, best)
    if different == 3 and len(chosen) > 1 and start is None:
        return replace(_no_result(n, status), solutions=exteriors)

    # Propagate its covariance from rotations to angles
    _, angles_by_rotation, locked = rotated[0]
    T = np.zeros((6, 6))
    T[:3, :3] = back[best]
    T[3:, 3:] = angles_by_rotation @ back[best] @ _common.axes(x[best, 3:])
    variance = found.sigma0[best] ** 2 if sigma is None else sigma**2
    return Resection(
        exterior=exteriors[0],
        covariance=variance * T @ found.cofactor[best] @ T.T,
        sigma0=float(found.sigma0[best]),
        redundancy=int(found.redundancy[best]),
        residuals=found.residuals[best].reshape(n, 2),
        standardized=found.standardized[best].reshape(n, 2),
        redundancy_numbers=found.redundancy_numbers[best].reshape(n, 2),
        solutions=exteriors,
        status="gimbal lock" if locked else status,
    )


def _observations(
    image_points: ArrayLike, object_points: ArrayLike
) -> tuple[np.ndarray, np.ndarray]:
    image_points = _validate.points(image_points, 2, "image_points")
    object_points = _validate.points(object_points, 3, "object_points")
    if image_points.ndim != 2 or object_points.shape != (len(image_points), 3):
        raise ValueError(
            "image_points (n, 2) and object_points (n, 3) must be of the same points;"
            f" got shapes {image_points.shape} and {object_points.shape}"
        )
    _, first = np.unique(
        np.hstack([image_points, object_points]), axis=0, return_index=True
    )
    if len(again := np.setdiff1d(np.arange(len(image_points)), first)):
        raise ValueError(
            f"point {again[0]} is given twice, and would control itself: leave one out"
        )
    if len(image_points) < 3:
        raise ValueError(
            f"{len(image_points)} points do not fix six unknowns: three give several"
            " solutions, four or more give one"
        )
    return image_points, object_points


def _no_result(n: int, status: str) -> Resection:
    nan = np.full((max(n, 6), 6), np.nan)
    v = nan[:n, :2]
    none = nan[:0]
    return Resection(nan[0], nan[:6], np.nan, 2 * n - 6, v, v, v, none, status)


def _closed_form(
    camera: Camera, image_points: np.ndarray, object_points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Starts (k, 3), (k, 3, 3) from triples of well spread points, the best dozen."""
    vectors = image_vectors([camera], image_points[None])[0]
    triples = _triples(object_points)
    centres, M = three_points(vectors[triples], object_points[triples])
    rays = np.einsum("kij,knj->kni", M, object_points - centres[:, None])
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    misfit = np.sum((rays - vectors) ** 2, axis=(1, 2))
    best = np.argsort(misfit)[:STARTS]
    limit = np.maximum(1e4 * misfit[best[:1]], len(vectors) * MAX_MISFIT**2)
    best = best[misfit[best] <= limit]
    return centres[best], M[best]


def _adjusted(
    camera: Camera,
    image_points: np.ndarray,
    object_points: np.ndarray,
    centres: np.ndarray,
    M: np.ndarray,
    sigma: float | None,
) -> tuple[Adjustment, np.ndarray]:
    """Adjust from each start (k, 3), (k, 3, 3) at once: parameters (k, 6)."""
    # Each in a frame of its own, parallel to its camera with the origin amid the
    # points: there all angles are small, far from the gimbal lock
    middle = object_points.mean(axis=0)
    local = np.einsum("kij,nj->kni", M, object_points - middle)
    first = np.zeros((len(M), 6))
    first[:, :3] = np.einsum("kij,kj->ki", M, centres - middle)

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
    return found, np.where(np.isfinite(found.x), found.x, first)


def _chosen(
    found: Adjustment,
    centres: np.ndarray,
    M: np.ndarray,
    object_points: np.ndarray,
    different: int,
) -> list[int]:
    """Solutions with all points in front: the best, then others that fit as well."""
    depth = -np.einsum("kj,knj->kn", M[:, 2], object_points - centres[:, None])
    possible = (found.status == "converged") & np.all(depth > 0, axis=1)
    v = found.residuals
    squares = np.where(possible, np.einsum("kn,kn->k", v, v), np.inf)
    order = np.argsort(squares)[: np.count_nonzero(possible)]
    if not len(order):
        return []
    limit = np.inf  # of three points each fits
    if different > 3:
        redundancy = int(found.redundancy[0])
        least = squares[order[0]]
        limit = _common.largest_objective(least, redundancy, found.sigma0_prior, LEVEL)
    distance = np.linalg.norm(depth, axis=1)
    chosen: list[int] = []
    for k in order:
        moved = np.linalg.norm(centres[k] - centres[chosen], axis=-1) / distance[k]
        if np.all(moved > SAME) and (not chosen or squares[k] <= limit):
            chosen.append(int(k))
    return chosen


def _refuse_mirrored(
    camera: Camera,
    image_points: np.ndarray,
    object_points: np.ndarray,
    found: Adjustment,
    best: int,
) -> None:
    """Refuse an image that fits much better with one axis reversed."""
    squares, r = np.sum(found.residuals[best] ** 2), int(found.redundancy[best])
    if not r or squares <= r * (LARGE * camera.c) ** 2:
        return
    reversed_x = ideal(camera, image_points) * (-1, 1)
    plain = Camera(camera.c)
    centres, M = _closed_form(plain, reversed_x, object_points)
    other, _ = _adjusted(plain, reversed_x, object_points, centres, M, None)
    least = np.min(np.sum(other.residuals**2, axis=1), initial=np.inf)
    least = max(least, 1e-12 * squares)
    # By chance the ratio of two sums may be large where the redundancy is small
    if squares > least * max(MIRROR, scipy.special.fdtri(r, r, _common.KNOWN)):
        raise ValueError(
            "image_points are a mirror image: with one axis reversed they fit"
            f" {np.sqrt(squares / least):.0f} times better. Does x point to the left,"
            " or y down, as rows of pixels do?"
        )


def _status(
    found: Adjustment,
    chosen: list[int],
    centres: np.ndarray,
    object_points: np.ndarray,
    different: int,
) -> str:
    # Diagonal of the inverse correlation matrix: how far the other unknowns inflate
    # each variance
    inflation = np.diag(np.linalg.inv(found.correlation[chosen[0]]))
    weak = inflation.max() > WEAK
    look = centres if different == 3 else centres[chosen[:1]]
    near = any(_near_cylinder(centre, object_points) for centre in look)
    if near and (weak or different == 3):
        return "near the dangerous cylinder"
    if len(chosen) > 1:
        return "several solutions"
    return "weak geometry" if weak else "converged"


def _failure(found: Adjustment, centres: np.ndarray, object_points: np.ndarray) -> str:
    """Name why no start led to a solution with all points in front."""
    length, width, _ = _common.extents(object_points)
    if width < NEARLY_ON_A_LINE * length:
        return "points on a line"
    if any(_near_cylinder(centre, object_points) for centre in centres):
        return "near the dangerous cylinder"
    status = str(found.status[0])
    return {"converged": "no solution", "singular": "weak geometry"}.get(status, status)


# --- Closed form: three points ---


def three_points(
    vectors: np.ndarray, object_points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (k, 3) and rotations M (k, 3, 3) from which three points look as they do.

    Of t triples: unit vectors (t, 3, 3) to the image points, one a row, in the frame of
    the camera, and object points (t, 3, 3). Each triple has up to four solutions.

    The distances s1, s2 = u s1 and s3 = v s1 obey three laws of cosines; without s1 and
    u an equation of degree four in v remains (Grunert 1841). Roots that noise has made
    a little complex count with their real part: double roots, at the dangerous
    cylinder.

    References
    ----------
    Haralick, Lee, Ottenberg and Nolle 1994, "Review and analysis of solutions of the
    three point perspective pose estimation problem", section 2.1 (Grunert).
    """
    v, cosines, sides = _distance_ratios(vectors, object_points)
    triple, root = np.nonzero(np.isfinite(v) & (v > 0))
    v = v[triple, root]
    cos_a, cos_b, cos_c = cosines[:, triple]
    a2, b2, c2 = sides[:, triple]
    q = (a2 - c2) / b2
    u = (q - 1) * v**2 - 2 * q * cos_b * v + 1 + q
    with np.errstate(divide="ignore", invalid="ignore"):
        u = u / (2 * (cos_c - v * cos_a))
        s1 = np.sqrt(b2 / (1 + v**2 - 2 * v * cos_b))
    good = np.isfinite(u) & (u > 0) & np.isfinite(s1)
    s1, u, v, triple = s1[good], u[good], v[good], triple[good]
    distances = np.stack([s1, u * s1, v * s1], axis=-1)
    return _fit(distances[..., None] * vectors[triple], object_points[triple])


def _distance_ratios(
    vectors: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots v = s3 / s1 (t, 4), cosines (3, t) of angles, squares (3, t) of sides."""
    opposite = [(1, 2), (0, 2), (0, 1)]
    cosines = np.array([np.sum(vectors[:, i] * vectors[:, j], -1) for i, j in opposite])
    a2, b2, c2 = sides = np.array(
        [np.sum((points[:, i] - points[:, j]) ** 2, axis=-1) for i, j in opposite]
    )
    cos_a, cos_b, cos_c = cosines
    q, r = (a2 - c2) / b2, (a2 + c2) / b2
    A4 = (q - 1) ** 2 - 4 * c2 / b2 * cos_a**2
    A3 = 4 * (
        q * (1 - q) * cos_b - (1 - r) * cos_a * cos_c + 2 * c2 / b2 * cos_a**2 * cos_b
    )
    A2 = 2 * (
        q**2
        - 1
        + 2 * q**2 * cos_b**2
        + 2 * (b2 - c2) / b2 * cos_a**2
        - 4 * r * cos_a * cos_b * cos_c
        + 2 * (b2 - a2) / b2 * cos_c**2
    )
    A1 = 4 * (
        -q * (1 + q) * cos_b + 2 * a2 / b2 * cos_c**2 * cos_b - (1 - r) * cos_a * cos_c
    )
    A0 = (1 + q) ** 2 - 4 * a2 / b2 * cos_c**2
    roots = _roots(np.stack([A4, A3, A2, A1, A0], axis=-1))
    real = np.abs(roots.imag) < 0.1 * np.abs(roots)
    return np.where(real, roots.real, np.nan), cosines, sides


def _roots(polynomials: np.ndarray) -> np.ndarray:
    """Roots (t, 4) of polynomials (t, 5), highest power first."""
    largest = np.abs(polynomials).max(axis=-1)
    leading = polynomials[:, 0]
    # A vanishing leading coefficient sends one root to infinity: nudge it, the other
    # roots hardly notice, and the adjustment that follows corrects them
    tiny = 1e-14 * largest
    leading = np.where(np.abs(leading) < tiny, tiny, leading)
    companion = np.zeros((len(polynomials), 4, 4))
    companion[:, 0] = -polynomials[:, 1:] / leading[:, None]
    companion[:, [1, 2, 3], [0, 1, 2]] = 1
    return np.linalg.eigvals(companion).astype(complex)


def _fit(
    camera_points: np.ndarray, object_points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rotate and shift triples (k, 3, 3) in the camera's frame onto object points."""
    centre_c = camera_points.mean(axis=1, keepdims=True)
    centre_o = object_points.mean(axis=1, keepdims=True)
    product = np.swapaxes(camera_points - centre_c, 1, 2) @ (object_points - centre_o)
    M, _ = rotation.best_fit(product)
    centres = centre_o[:, 0] - np.einsum("kji,kj->ki", M, centre_c[:, 0])
    return centres, M


# --- Where the points and the camera lie ---


def _on_a_line(points: np.ndarray) -> bool:
    """Whether points (n, 3) lie on one line, or at one place."""
    length, width, _ = _common.extents(points)
    return width <= ON_A_LINE * length


def _triples(points: np.ndarray) -> np.ndarray:
    """Triples (t, 3) of up to five points that lie far apart, none on a line."""
    far = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    while len(far) < min(5, len(points)):
        gap = np.linalg.norm(points[:, None] - points[far], axis=-1).min(axis=1)
        far.append(int(np.argmax(gap)))
    triples = np.array(list(combinations(far, 3)))
    a, b, c = np.moveaxis(points[triples], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1)
    return triples[area > ON_A_LINE * area.max()]


def _near_cylinder(centre: np.ndarray, object_points: np.ndarray) -> bool:
    """Whether a centre is near the dangerous cylinder of any three points."""
    # A camera on the cylinder over their circle can move a little without a change of
    # the three angles it sees
    a, b, c = np.moveaxis(object_points[_triples(object_points)], 1, 0)
    u, v = b - a, c - a
    axis = np.cross(u, v)
    square = np.sum(axis**2, axis=-1, keepdims=True)
    uu, vv = (np.sum(w**2, axis=-1, keepdims=True) for w in (u, v))
    to_middle = (uu * np.cross(v, axis) - vv * np.cross(u, axis)) / (2 * square)
    off_axis = np.cross(centre - a - to_middle, axis)
    distance = np.linalg.norm(off_axis, axis=-1) / np.sqrt(square[:, 0])
    radius = np.linalg.norm(to_middle, axis=-1)
    # The circle of points almost on a line is so large that everything is near it
    far = np.linalg.norm(centre - a, axis=-1)
    return bool(np.all(np.abs(distance - radius) < NEAR * np.minimum(radius, far)))
