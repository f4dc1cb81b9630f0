"""Space intersection: object points from two or more oriented photos."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import adjust
from pgm_lab.camera import Camera, imaging
from pgm_lab.orientation.rays import angle_between_rays, nearest_point, rays

# Sine of the angle between rays below which they count as parallel.
PARALLEL = 1e-8


@dataclass(frozen=True)
class Intersection:
    """Result of `intersect`; n stands for the axes of the points, which may be none.

    Attributes
    ----------
    points : ndarray (n, 3)
        Object points; NaN where the status is not "intersected".
    covariance : ndarray (n, 3, 3)
        From `sigma`, else from the sigma0 of all points together.
    sigma0 : ndarray (n,)
        Standard deviation of an image coordinate from this point's residuals, in mm.
    redundancy : ndarray (n,) of int
        Two for each ray, minus three.
    residuals : ndarray (photos, n, 2)
        v = computed - observed, in mm; NaN where the photo does not show the point.
    standardized : ndarray (photos, n, 2)
        Baarda's w with `sigma`, else Pope's tau by the sigma0 of the point; 0 where
        nothing controls them.
    angle : ndarray (n,)
        Angle of intersection in radians: the largest between the first ray and another.
    status : ndarray (n,) of str
        "intersected", "one ray" (or none), "no base" (all rays from one place),
        "parallel rays", "behind a camera", "diverged", "too many iterations".
    """

    points: np.ndarray
    covariance: np.ndarray
    sigma0: np.ndarray
    redundancy: np.ndarray
    residuals: np.ndarray
    standardized: np.ndarray
    angle: np.ndarray
    status: np.ndarray


def intersect(
    cameras: Camera | Sequence[Camera],
    exteriors: ArrayLike,
    image_points: ArrayLike,
    *,
    seen: ArrayLike | None = None,
    sigma: float | None = None,
) -> Intersection:
    """Intersect the rays of each point, and adjust it to its image points.

    No start values are needed: the point nearest to all rays is one.

    Parameters
    ----------
    cameras : Camera, or one for each photo
        All with the same lens direction.
    exteriors : array_like (photos, 6)
        (X0, Y0, Z0, omega, phi, kappa) of each photo, held fixed.
    image_points : array_like (photos, n, 2)
        Measured image coordinates in mm; (photos, 2) for a single point.
    seen : array_like (photos, n) of bool, optional
        Which photo shows which point; all when missing. `image_points` of the others
        are ignored.
    sigma : float, optional
        Standard deviation of an image coordinate, in mm, known beforehand.

    Raises
    ------
    ValueError
        If there are fewer than two photos, two are the same, or all stand at one place.

    References
    ----------
    Bani 2010, appendix B: (B 1) to (B 7); Muliawan 2013, section 2.9; (H 3).

    Examples
    --------
    >>> camera = Camera(50.0)
    >>> photos = [(0, 0, 110, 0, 0, 0), (60, 0, 110, 0, 0, 0)]
    >>> found = intersect(camera, photos, [[10.0, 5.0], [-20.0, 5.0]], sigma=0.005)
    >>> found.points.round(6)
    array([20., 10., 10.])
    >>> np.sqrt(np.diag(found.covariance)).round(4)
    array([0.0075, 0.0075, 0.0236])
    """
    exteriors = _validate.points(exteriors, 6, "exteriors")
    sigma = _validate.standard_deviation(sigma)
    image_points, seen = _observations(exteriors, image_points, seen)
    p, *lead, _ = image_points.shape
    photos = _cameras(cameras, p)
    _refuse_same_photos(exteriors, image_points)
    image, seen = image_points.reshape(p, -1, 2), seen.reshape(p, -1)

    # Rays, which meet in `good` points
    directions = rays(photos, exteriors, image)
    angle = angle_between_rays(directions, seen)
    status = _first_look(exteriors, seen, directions)
    good = np.flatnonzero(status == "intersected")
    start = nearest_point(exteriors[:, :3], directions[:, good], seen[:, good])

    # Adjust each point to its image points
    interior = np.array([camera.interior for camera in photos])
    image, seen = image.swapaxes(0, 1), seen.T
    # Observed v is zero; counted from c it tells the adjustment what rounding is, also
    # for a point in the origin that is imaged in the principal point
    c = photos[0].c

    def collinearity(x, image):
        v, _, blocks = imaging.misclosure(
            interior, exteriors, x[:, None], image, photos[0].lens, ("point",)
        )
        computed = c + v.reshape(len(x), 2 * p)
        return computed, blocks["point"].reshape(len(x), 2 * p, 3)

    found = adjust(
        collinearity,
        start,
        np.full(2 * p, c),
        weights=np.repeat(seen, 2, axis=1)[good].astype(float),
        sigma0_prior=sigma,
        args=(image[good],),
    )

    # Name what failed
    status[good] = found.status
    status[status == "converged"] = "intersected"
    status[status == "singular"] = "parallel rays"
    _, depth, _ = imaging.misclosure(
        interior, exteriors, found.x[:, None], image[good], photos[0].lens, ()
    )
    status[good[np.any((depth <= 0) & seen[good], axis=1)]] = "behind a camera"
    ok = status[good] == "intersected"

    # Without sigma the variance of unit weight comes from all points together
    r = found.redundancy[ok]
    variance = np.sum(r * found.sigma0[ok] ** 2) / max(np.sum(r), 1)
    variance = variance if sigma is None else sigma**2

    def whole(values, *shape, where=True):
        """Values of the points that are intersected among NaN of the others."""
        filled = np.full((len(image), *values.shape[1:]), np.nan)
        filled[good[ok]] = values[ok]
        return np.where(where, filled, np.nan).reshape((*lead, *shape))[()]

    def by_photo(values):
        values = whole(values.reshape(-1, p, 2), p, 2, where=seen[..., None])
        return np.moveaxis(values, -2, 0)

    return Intersection(
        points=whole(found.x, 3),
        covariance=whole(variance * found.cofactor, 3, 3),
        sigma0=whole(found.sigma0),
        redundancy=(2 * seen.sum(axis=1) - 3).reshape(lead)[()],
        residuals=by_photo(found.residuals),
        standardized=by_photo(found.standardized),
        angle=angle.reshape(lead)[()],
        status=status.reshape(lead)[()],
    )


def _observations(
    exteriors: np.ndarray, image_points: ArrayLike, seen: ArrayLike | None
) -> tuple[np.ndarray, np.ndarray]:
    """Image points, zero where not seen, and which photo sees which point."""
    image_points = _validate.real(image_points, "image_points")
    p = len(exteriors)
    if exteriors.ndim != 2 or p < 2:
        raise ValueError(
            "exteriors must have shape (photos, 6) with two photos or more: a point"
            f" needs two rays; got shape {exteriors.shape}"
        )
    shape = image_points.shape
    if image_points.ndim < 2 or (shape[0], shape[-1]) != (p, 2):
        raise ValueError(
            f"image_points must have shape ({p}, n, 2), photo by photo; got"
            f" {image_points.shape}"
        )
    if seen is None:
        return _validate.finite(image_points, "image_points"), np.ones(
            image_points.shape[:-1], bool
        )
    _validate.real(seen, "seen")
    seen = np.asarray(seen)
    if seen.dtype != bool or seen.shape != image_points.shape[:-1]:
        raise ValueError(
            f"seen must be True or False in shape {image_points.shape[:-1]}; got"
            f" {seen.dtype} in shape {seen.shape}"
        )
    image_points = np.where(seen[..., None], image_points, 0.0)
    return _validate.finite(image_points, "image_points"), seen


def _cameras(cameras: Camera | Sequence[Camera], p: int) -> list[Camera]:
    if isinstance(cameras, Camera):
        photos = [cameras] * p
    else:
        photos = _validate.several(cameras, "cameras", Camera)
    if len(photos) != p:
        raise ValueError(f"{len(photos)} cameras for {p} photos: one for each, or one")
    if len({camera.lens for camera in photos}) > 1:
        raise ValueError("the cameras must have the same lens direction")
    return photos


def _refuse_same_photos(exteriors: np.ndarray, image_points: np.ndarray) -> None:
    same = np.all(exteriors[:, None] == exteriors, axis=-1)
    for i, j in np.argwhere(np.triu(same, k=1)):
        if np.array_equal(image_points[i], image_points[j]):
            raise ValueError(
                f"photos {i} and {j} are the same, with the same image points: counted"
                " twice, a photo seems to control itself. Leave one out"
            )
    if np.all(exteriors[:, :3] == exteriors[0, :3]):
        raise ValueError(
            "all photos were taken from one place: without a base there is no point"
        )


def _first_look(
    exteriors: np.ndarray, seen: np.ndarray, directions: np.ndarray
) -> np.ndarray:
    """Statuses known before a point is computed."""
    first = np.argmax(seen, axis=0)
    elsewhere = np.any(exteriors[:, None, :3] != exteriors[first, :3], axis=-1)
    status = np.full(len(first), "intersected", dtype="<U19")
    # The sine, since antiparallel rays, too, meet only at infinity; of all rays, since
    # a third one may tell where
    reference = np.take_along_axis(directions, first[None, :, None], axis=0)
    sine = np.linalg.norm(np.cross(reference, directions), axis=-1)
    status[np.max(np.where(seen, sine, 0), axis=0) < PARALLEL] = "parallel rays"
    status[~np.any(seen & elsewhere, axis=0)] = "no base"
    status[seen.sum(axis=0) < 2] = "one ray"
    return status
