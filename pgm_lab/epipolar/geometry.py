"""Epipolar plane, line and epipole, from the coplanarity condition.

A point P, seen by two photos, lies in one plane with both stations O' and O'': the
epipolar plane. It holds the base b = O'' - O' and both rays, so that (M 2.31)

    b . (u' x u'') = 0.

Rays in the frames of their photos are x' = (x', y', -c'), with ideal x' and y', and in
object space u' = M'ᵀ x', u'' = M''ᵀ x''. As b . (u' x u'') = -u' . (b x u''), this is

    x'ᵀ E x'' = 0   with   E = -M' [b]x M''ᵀ,

the essential matrix of `essential`. For a given x' the vector n'' = Eᵀ x', which is
M'' (b x u'), is the normal of the epipolar plane in the frame of the right photo, and
n'' . x'' = 0 is the equation of a straight line, the epipolar line:

    n1 x'' + n2 y'' - c'' n3 = 0.

All epipolar planes hold the base; so all lines of a photo pass through the point where
the base pierces it, its epipole: E e'' = 0 and Eᵀ e' = 0.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.epipolar._base import base_of, refuse_others

# Sine of an angle below which two directions count as the same
SAME = 1e-9


def plane(left: Photo, right: Photo, pixels: ArrayLike) -> np.ndarray:
    """Unit normals of the epipolar planes of points in the left photo.

    Parameters
    ----------
    left, right : Photo
    pixels : array_like (..., 2)
        (column, row) in the left photo, with lens.

    Returns
    -------
    ndarray (..., 3)
        n in object space: n . (X - O') = 0 for each point X of the plane.

    Raises
    ------
    ValueError
        If an argument is not what is described here, both photos stand at the same
        place, or a ray runs along the base: any plane through the base holds it.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(24.0), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> plane(left, right, [(40.0, 19.5)]) + 0.0  # in the middle row: upright
    array([[0., 1., 0.]])
    """
    base = base_of(left, right)
    u = left.rays(pixels)
    normal = np.cross(base, u)
    size = np.linalg.norm(normal, axis=-1)
    message = (
        "pixels{} look along the base, at the epipole: every plane through both"
        " stations holds this ray. Leave such points out"
    )
    along = size <= SAME * np.linalg.norm(base) * np.linalg.norm(u, axis=-1)
    _validate.refuse(along, message)
    return normal / size[..., None]


def line(left: Photo, right: Photo, pixels: ArrayLike) -> np.ndarray:
    """Epipolar lines, in the right photo, of points in the left one.

    Parameters
    ----------
    left, right : Photo
    pixels : array_like (..., 2)
        (column, row) in the left photo, with lens.

    Returns
    -------
    ndarray (..., 3)
        (a, b, d) with a x + b y + d = 0 and a² + b² = 1; x, y are ideal coordinates in
        the right photo, in mm. Of any other point a x + b y + d is the distance.

    Raises
    ------
    ValueError
        As `plane`, and if an epipolar plane is parallel to the right photo, which then
        shows nothing of it.

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
    a, b, w = np.moveaxis(
        plane(left, right, pixels) @ attitude(right.exterior).T, -1, 0
    )
    slope = np.hypot(a, b)
    message = (
        "the epipolar planes of pixels{} are parallel to the right photo, which shows"
        " nothing of them. Leave such points out"
    )
    _validate.refuse(slope <= SAME, message)
    return np.stack([a, b, -right.camera.c * w], -1) / slope[..., None]


def distance(
    left: Photo, right: Photo, left_pixels: ArrayLike, right_pixels: ArrayLike
) -> np.ndarray:
    """Distances of points in the right photo from the epipolar lines of left ones.

    Parameters
    ----------
    left, right : Photo
    left_pixels, right_pixels : array_like (..., 2)
        (column, row) of the same points, with lens.

    Returns
    -------
    ndarray (...)
        In pixels of the right photo, at right angles to the line, with a sign.

    Raises
    ------
    ValueError
        As `line`, or if the points do not pair up.

    Examples
    --------
    >>> from pgm_lab.camera import Camera
    >>> left, right = (
    ...     Photo(np.zeros((40, 60)), Camera(24.0), (X, 0, 100, 0, 0, 0), 0.005)
    ...     for X in (0, 30)
    ... )
    >>> distance(left, right, (40.0, 9.5), (12.0, 9.0)).round(6)
    np.float64(0.5)
    """
    refuse_others(left, right)
    one = _validate.points(left_pixels, 2, "left_pixels")
    other = _validate.points(right_pixels, 2, "right_pixels")
    _validate.broadcast(left_pixels=one, right_pixels=other)
    lines, xy = line(left, right, one), right.ideal(other)
    off = lines[..., 0] * xy[..., 0] + lines[..., 1] * xy[..., 1] + lines[..., 2]
    return off / right.pixel_size


def curve(
    left: Photo,
    right: Photo,
    pixel: ArrayLike,
    heights: ArrayLike | None = None,
    *,
    depths: ArrayLike | None = None,
) -> np.ndarray:
    """Pixels in the right photo of one left pixel, were it at these heights or depths.

    Without lens distortion they lie on a straight line; with it, on a curve.

    Parameters
    ----------
    left, right : Photo
    pixel : array_like (2,)
        (column, row) in the left photo, with lens.
    heights : array_like (k,), optional
        Z of object space. Either these or depths.
    depths : array_like (k,), optional
        Distances from the left station along the axis of its camera, in the unit of the
        base: for photos with relative orientation only.

    Returns
    -------
    ndarray (k, 2)
        (column, row), with lens; they may lie outside the photo.

    Raises
    ------
    ValueError
        If an argument is not what is described here, the ray does not reach a height
        going forwards, a point is not in front of the right photo, or so far outside
        that its lens has no solution.

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
    base_of(left, right)
    u = left.rays(_validate.one_point(pixel, 2, "pixel"))
    X0 = left.exterior[:3]
    if heights is None and depths is not None:
        reach = _validate.of_shape(depths, (None,), "depths") / left.camera.c
        _validate.refuse(reach <= 0, "depths{} are not in front of the left photo")
    elif heights is not None and depths is None:
        rise = _validate.of_shape(heights, (None,), "heights") - X0[2]
        message = "the ray of pixel does not reach heights{}: it leads away from there"
        _validate.refuse(rise * u[2] <= 0, message)
        reach = rise / u[2]
    else:
        raise ValueError("either heights or depths say how far along the ray; give one")
    return right.project(X0 + reach[:, None] * u)
