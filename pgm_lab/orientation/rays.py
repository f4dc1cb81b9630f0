"""Rays of image points in object space, and the point nearest to several of them."""

from collections.abc import Sequence

import numpy as np

from pgm_lab import rotation
from pgm_lab.camera import Camera, ideal


def image_vectors(cameras: Sequence[Camera], image_points: np.ndarray) -> np.ndarray:
    """Vectors (x, y, -c) from the perspective centre to the image points, of length 1.

    Parameters
    ----------
    cameras : sequence of Camera
        One for each photo.
    image_points : ndarray (photos, n, 2)
        Measured image coordinates, in mm.

    Returns
    -------
    ndarray (photos, n, 3)
        In the frames of the cameras.

    Examples
    --------
    >>> image_vectors([Camera(40.0)], np.array([[[30.0, 0.0]]]))
    array([[[ 0.6,  0. , -0.8]]])
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
    """Directions M'(x, y, -c) of the rays in object space, of length 1.

    Parameters
    ----------
    cameras : sequence of Camera
        One for each photo.
    exteriors : ndarray (photos, 6)
        (X0, Y0, Z0, omega, phi, kappa).
    image_points : ndarray (photos, n, 2)
        Measured image coordinates, in mm.

    Returns
    -------
    ndarray (photos, n, 3)

    References
    ----------
    (M 2.33) to (M 2.35); (H 2), with R = M'.

    Examples
    --------
    >>> rays([Camera(40.0)], np.zeros((1, 6)), np.array([[[30.0, 0.0]]]))
    array([[[ 0.6,  0. , -0.8]]])
    """
    return image_vectors(cameras, image_points) @ rotation.matrix(*exteriors.T[3:])


def nearest_point(
    centres: np.ndarray, directions: np.ndarray, seen: np.ndarray
) -> np.ndarray:
    """Points with the least sum of squared distances from their rays.

    The distance of X from the ray d through X0 is |(I - dd')(X - X0)|, linear in X.

    Parameters
    ----------
    centres : ndarray (photos, 3)
        Perspective centres X0.
    directions : ndarray (photos, n, 3)
        Directions d, of length 1.
    seen : ndarray (photos, n) of bool
        Which rays count; no point may have all its rays parallel.

    Returns
    -------
    ndarray (n, 3)

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
    """Angle of intersection: the largest between the first ray of a point and another.

    Parameters
    ----------
    directions : ndarray (photos, n, 3)
        Directions of length 1.
    seen : ndarray (photos, n) of bool
        Which rays count.

    Returns
    -------
    ndarray (n,)
        In radians.

    Examples
    --------
    >>> directions = np.array([[[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]]])
    >>> angle_between_rays(directions, np.full((2, 1), True)) / np.pi
    array([0.5])
    """
    first = np.argmax(seen, axis=0)[None, :, None]
    reference = np.take_along_axis(directions, first, axis=0)
    sine = np.linalg.norm(np.cross(reference, directions), axis=-1)
    angle = np.arctan2(sine, np.sum(reference * directions, axis=-1))
    return np.max(np.where(seen, angle, 0), axis=0)
