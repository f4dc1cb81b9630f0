"""Rays of image points in object space, and what two or more of them have in common."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, rotation
from pgm_lab.camera import Camera, ideal

COMPONENTS = {"xyz": (0, 1, 2), "xy": (0, 1), "xz": (0, 2)}

# Sine of the angle between two rays below which they count as parallel.
PARALLEL = 1e-12


def image_vectors(cameras: Sequence[Camera], image_points: np.ndarray) -> np.ndarray:
    """Unit vectors (photos, n, 3) along (x, y, -c), in the frames of the cameras.

    Of measured image points (photos, n, 2) in mm; one camera a photo.
    """
    vectors = np.empty((*image_points.shape[:-1], 3))
    for camera in dict.fromkeys(cameras):
        photos = [i for i, one in enumerate(cameras) if one == camera]
        vectors[photos, ..., :2] = ideal(camera, image_points[photos])
        vectors[photos, ..., 2] = -camera.c
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def rays(
    cameras: Sequence[Camera], exteriors: np.ndarray, image_points: np.ndarray
) -> np.ndarray:
    """Directions M'(x, y, -c) (photos, n, 3) of the rays in object space, of length 1.

    Of `image_vectors` and exteriors (photos, 6): (M 2.33) to (M 2.35); (H 2), with
    R = M'.

    Examples
    --------
    >>> rays([Camera(40.0)], np.zeros((1, 6)), np.array([[[30.0, 0.0]]]))
    array([[[ 0.6,  0. , -0.8]]])
    """
    return image_vectors(cameras, image_points) @ rotation.matrix(*exteriors.T[3:])


def nearest_point(
    centres: np.ndarray, directions: np.ndarray, seen: np.ndarray
) -> np.ndarray:
    """Points (n, 3) with the least sum of squared distances from their rays.

    The distance of X from the ray d through X0 is |(I - dd')(X - X0)|, linear in X.
    Perspective centres X0 (photos, 3) and directions d (photos, n, 3) of length 1;
    `seen` (photos, n) tells which rays count. No point may have all its rays parallel.

    Examples
    --------
    >>> centres = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 1.0]])
    >>> directions = np.array([[[0.0, 0.0, 1.0]], [[-0.8, 0.0, 0.6]]])
    >>> nearest_point(centres, directions, np.full((2, 1), True)).round(6)
    array([[0., 0., 4.]])
    """
    count = seen.sum(axis=0)[:, None, None]
    used = directions * seen[..., None]
    normal = count * np.eye(3) - np.einsum("pni,pnj->nij", used, used)
    along = np.einsum("pni,pi->pn", used, centres)
    right = seen.T @ centres - np.einsum("pn,pni->ni", along, used)
    return np.linalg.solve(normal, right[..., None])[..., 0]


def angle_between_rays(directions: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Angles of intersection (n,), in radians, of directions (photos, n, 3).

    The largest between the first ray of a point that counts and another.
    """
    first = np.argmax(seen, axis=0)[None, :, None]
    reference = np.take_along_axis(directions, first, axis=0)
    sine = np.linalg.norm(np.cross(reference, directions), axis=-1)
    angle = np.arctan2(sine, np.sum(reference * directions, axis=-1))
    return np.max(np.where(seen, angle, 0), axis=0)


def scale_factors(
    left_exterior: ArrayLike,
    right_exterior: ArrayLike,
    left_rays: ArrayLike,
    right_rays: ArrayLike,
    components: str = "xyz",
) -> np.ndarray:
    """Scale factors (..., 2) of two rays: how far along them their point lies.

    The factors fulfil lambda' u' - lambda'' u'' = b, three equations with the base b
    and the rays u in object space. With errors the answer depends on those that are
    solved.

    Parameters
    ----------
    left_exterior, right_exterior : array_like (..., 6)
        (X0, Y0, Z0, omega, phi, kappa) of the photos.
    left_rays, right_rays : array_like (..., 3)
        Rays (x, y, -c) in the frames of the photos; x and y reduced to the principal
        point and free of distortion (`camera.ideal`).
    components : {"xyz", "xy", "xz"}
        "xyz": all, by least squares, where the rays come closest. "xy": those of (H 4),
        (H 5); near rays without a y component (base along x) they are 0/0, and a small
        y parallax moves the point far. "xz": weak only where rays cross at small
        angles.

    Returns
    -------
    ndarray (..., 2)
        lambda' and lambda'': positive in front of the camera. The point on the left
        ray is X0 + lambda' R (x, y, -c), with R = M'.

    Raises
    ------
    ValueError
        If some rays are parallel in the components used.

    References
    ----------
    (H 2) to (H 5); his R rotates the image into object space.

    Examples
    --------
    >>> left, right = (0, 0, 100, 0, 0, 0), (60, 0, 100, 0, 0, 0)
    >>> scale_factors(left, right, (10, 5, -50), (-20, 5, -50))
    array([2., 2.])
    """
    arrays = {
        "left_exterior": _validate.points(left_exterior, 6, "left_exterior"),
        "right_exterior": _validate.points(right_exterior, 6, "right_exterior"),
        "left_rays": _validate.points(left_rays, 3, "left_rays"),
        "right_rays": _validate.points(right_rays, 3, "right_rays"),
    }
    _validate.broadcast(**arrays)
    _validate.choice(components, "components", tuple(COMPONENTS))
    left, right, left_rays, right_rays = arrays.values()
    used = list(COMPONENTS[components])
    b = (right[..., :3] - left[..., :3])[..., used]
    u1, u2 = (
        _turned(*pair)[..., used] for pair in ((left, left_rays), (right, right_rays))
    )
    factors, parallel = nearest_factors(b, u1, u2)
    _validate.refuse(
        parallel,
        f"the rays{{}} are parallel in the components {components!r}: the factors are"
        " 0/0 or infinite. Leave these points out"
        + ("" if components == "xyz" else ", or take components 'xyz'"),
    )
    return factors


def nearest_factors(
    b: np.ndarray, u1: np.ndarray, u2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Least squares solution of lambda' u1 - lambda'' u2 = b, and where none is."""
    # With two components it is Cramer's rule
    if b.shape[-1] == 2:
        normal = u1[..., 0] * u2[..., 1] - u1[..., 1] * u2[..., 0]
        first = b[..., 0] * u2[..., 1] - b[..., 1] * u2[..., 0]
        second = b[..., 0] * u1[..., 1] - b[..., 1] * u1[..., 0]
        sine = np.abs(normal)
    else:
        # Crossed with the other ray, and projected on the normal of both
        n = np.cross(u1, u2)
        first = np.sum(np.cross(b, u2) * n, axis=-1)
        second = np.sum(np.cross(b, u1) * n, axis=-1)
        normal = np.sum(n * n, axis=-1)
        sine = np.sqrt(normal)
    lengths = np.linalg.norm(u1, axis=-1) * np.linalg.norm(u2, axis=-1)
    parallel = sine <= PARALLEL * lengths
    normal = np.where(parallel, np.nan, normal)
    return np.stack([first / normal, second / normal], axis=-1), parallel


def _turned(exterior: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Rays in object space: M' times (x, y, -c)."""
    M = rotation.matrix(*np.moveaxis(exterior[..., 3:], -1, 0))
    return np.einsum("...ji,...j->...i", M, rays)
