"""Epipolar geometry of two oriented photos, from the coplanarity condition.

A point P, seen by two photos, lies in one plane with both stations O' and O'': the
epipolar plane. It contains the base b = O'' - O' and both rays, so that (M 2.31)

    b . (u' x u'') = 0.

Rays in the frames of their photos are x' = (x', y', -c'), with ideal x' and y', and in
object space u' = M'ᵀ x', u'' = M''ᵀ x''. For a given x' the vector n'' = M'' (b x u')
is the normal of the epipolar plane in the frame of the right photo, and n'' . x'' = 0
is the equation of a straight line, the epipolar line:

    n1 x'' + n2 y'' - c'' n3 = 0.

All epipolar planes contain the base; so all lines of a photo pass through the point
where the base pierces it, its epipole.

Photos with the same station have no epipolar geometry; they, and any other argument
that is not as described, raise ValueError. Pixels are (column, row), with lens
distortion.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import Photo, measured
from pgm_lab.camera.imaging import attitude

__all__ = [
    "Epipole",
    "curve",
    "epipole",
    "line",
    "plane",
]

# Sine of an angle below which two directions count as the same
SAME = 1e-9


# --- Plane, line and curve ---


def plane(left: Photo, right: Photo, pixels: ArrayLike) -> np.ndarray:
    """Unit normals of the epipolar planes of points in the left photo.

    Parameters
    ----------
    left, right : Photo
    pixels : array_like (..., 2)
        In the left photo.

    Returns
    -------
    ndarray (..., 3)
        n in object space: n . (X - O') = 0 for each point X of the plane.

    Raises
    ------
    ValueError
        If a ray runs along the base: any plane through the base contains it.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(24.0), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> plane(left, right, [(40.0, 19.5)]) + 0.0  # in the middle row: vertical
    array([[0., 1., 0.]])
    """
    base = _base_of(left, right)
    u = left.rays(pixels)
    normal = np.cross(base, u)
    size = np.linalg.norm(normal, axis=-1)
    _validate.refuse(
        size <= SAME * np.linalg.norm(base) * np.linalg.norm(u, axis=-1),
        "pixels{} look along the base, at the epipole: every plane through both"
        " stations contains this ray. Leave such points out",
    )
    return normal / size[..., None]


def line(left: Photo, right: Photo, pixels: ArrayLike) -> np.ndarray:
    """Epipolar lines, in the right photo, of points in the left one.

    Parameters
    ----------
    left, right : Photo
    pixels : array_like (..., 2)
        In the left photo.

    Returns
    -------
    ndarray (..., 3)
        (a, b, d) with a x + b y + d = 0 and a² + b² = 1; x, y are ideal coordinates in
        the right photo, in mm. For any other point, a x + b y + d is its distance.

    Raises
    ------
    ValueError
        As `plane`, and if an epipolar plane is parallel to the right photo.

    References
    ----------
    Bani 2010, II.1.2.1: intersection of epipolar plane and image plane.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(24.0), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> line(left, right, [(40.0, 9.5)]).round(3) + 0.0  # y = 0.05 mm, as on the left
    array([[ 0.  ,  1.  , -0.05]])
    """
    normal = plane(left, right, pixels) @ attitude(right.exterior).T
    a, b, w = np.moveaxis(normal, -1, 0)
    slope = np.hypot(a, b)
    _validate.refuse(
        slope <= SAME,
        "the epipolar planes of pixels{} are parallel to the right photo, which shows"
        " nothing of them. Leave such points out",
    )
    return np.stack([a, b, -right.camera.c * w], -1) / slope[..., None]


def curve(
    left: Photo,
    right: Photo,
    pixel: ArrayLike,
    heights: ArrayLike,
) -> np.ndarray:
    """Pixels (k, 2) in the right photo of one left pixel, at these heights.

    Without lens distortion they lie on a straight line; with it, on a curve.
    They may lie outside the photo.

    Parameters
    ----------
    left, right : Photo
    pixel : array_like (2,)
        In the left photo.
    heights : array_like (k,)
        Z of object space.

    Raises
    ------
    ValueError
        If the ray does not reach a height, or a point is not in front of the right
        photo or too far outside for its lens.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(0.3), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> curve(left, right, (40.0, 9.5), heights=[0.0, 10.0])
    array([[22. ,  9.5],
           [20. ,  9.5]])
    """
    _base_of(left, right)
    u = left.rays(_validate.one_point(pixel, 2, "pixel"))
    X0 = left.exterior[:3]
    rise = _validate.of_shape(heights, (None,), "heights") - X0[2]
    message = "the ray of pixel does not reach heights{}: it leads away from there"
    _validate.refuse(rise * u[2] <= 0, message)
    return right.project(X0 + (rise / u[2])[:, None] * u)


# --- Epipoles ---


@dataclass(frozen=True, eq=False)
class Epipole:
    """Where the base pierces a photo: the image of the other station.

    Attributes
    ----------
    status : {"inside the photo", "outside the photo", "at infinity"}
        "at infinity": the base is parallel to the photo, as in the normal case.
    direction : ndarray (3,)
        Unit vector to the other station in the frame of the photo: x right, y up, z
        against the view. At infinity (direction[0], direction[1]) is that of all lines.
    ideal : ndarray (2,) or None
        (x, y) in mm from the principal point, corrected for distortion; None at
        infinity.
    pixel : ndarray (2,) or None
        (column, row), with lens distortion; None unless it lies inside the photo.
    """

    status: str
    direction: np.ndarray
    ideal: np.ndarray | None
    pixel: np.ndarray | None


def epipole(left: Photo, right: Photo) -> tuple[Epipole, Epipole]:
    """Epipoles of the left and of the right photo: where the base pierces them.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(24.0), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> epipole(left, right)[0].status
    'at infinity'
    """
    base = _base_of(left, right)
    base = base / np.linalg.norm(base)
    return _pierced(left, base), _pierced(right, -base)


def _pierced(photo: Photo, towards: np.ndarray) -> Epipole:
    """Epipole of a photo whose partner lies in this direction."""
    U = attitude(photo.exterior) @ towards
    if abs(U[2]) <= SAME:
        return Epipole("at infinity", U, None, None)
    xy = -photo.camera.c * U[:2] / U[2]
    edge = photo.ideal(photo.outline()).astype(np.float32)
    if cv2.pointPolygonTest(edge, tuple(xy.tolist()), False) < 0:
        return Epipole("outside the photo", U, xy, None)
    pixel = photo.to_pixel(measured(photo.camera, xy))
    return Epipole("inside the photo", U, xy, pixel)


# --- The base ---


def _base_of(left: Photo, right: Photo) -> np.ndarray:
    """Base vector from the left to the right station."""
    _validate.instance(left, Photo, "left")
    _validate.instance(right, Photo, "right")
    stations = left.exterior[:3], right.exterior[:3]
    base = stations[1] - stations[0]
    if np.linalg.norm(base) <= 1e-12 * np.abs(stations).max():
        raise ValueError(
            "both photos have the same station: without a base there is no epipolar"
            " plane. Was the same photo, or the same exterior orientation, given twice?"
        )
    return base
