"""The epipole: the image of the other station, where all epipolar lines meet."""

from dataclasses import dataclass

import cv2
import numpy as np

from pgm_lab.camera import measured
from pgm_lab.camera.imaging import attitude
from pgm_lab.camera.photo import Photo
from pgm_lab.epipolar._base import base_of
from pgm_lab.epipolar.geometry import SAME


@dataclass(frozen=True, eq=False)
class Epipole:
    """Where the base pierces a photo: the image of the other station.

    Attributes
    ----------
    status : {"inside the photo", "outside the photo", "at infinity"}
        "at infinity": the base is parallel to the photo, as in the normal case, and all
        its epipolar lines are parallel.
    direction : ndarray (3,)
        Unit vector to the other station in the frame of the photo: x right, y up, z
        against the view. At infinity (direction[0], direction[1]) is that of all lines.
    ideal : ndarray (2,) or None
        (x, y) in mm, without lens and principal point; None at infinity. If the other
        station lies behind the photo (direction[2] > 0), the base pierces it extended
        backwards.
    pixel : ndarray (2,) or None
        (column, row), with lens; None unless it lies inside the photo: outside of it
        the distortion of the lens is not known.
    """

    status: str
    direction: np.ndarray
    ideal: np.ndarray | None
    pixel: np.ndarray | None


def epipole(left: Photo, right: Photo) -> tuple[Epipole, Epipole]:
    """Epipoles of both photos: where the base pierces them.

    Parameters
    ----------
    left, right : Photo

    Returns
    -------
    tuple of Epipole
        Of the left and of the right photo.

    Raises
    ------
    ValueError
        If an argument is no Photo, or both photos stand at the same place.

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
    base = base_of(left, right)
    base = base / np.linalg.norm(base)
    return _pierced(left, base), _pierced(right, -base)


def _pierced(photo: Photo, towards: np.ndarray) -> Epipole:
    """Epipole of a photo whose partner stands in this direction."""
    U = attitude(photo.exterior) @ towards
    if abs(U[2]) <= SAME:
        return Epipole("at infinity", U, None, None)
    xy = -photo.camera.c * U[:2] / U[2]
    edge = photo.ideal(photo.outline()).astype(np.float32)
    if cv2.pointPolygonTest(edge, tuple(xy.tolist()), False) < 0:
        return Epipole("outside the photo", U, xy, None)
    pixel = photo.to_pixel(measured(photo.camera, xy))
    return Epipole("inside the photo", U, xy, pixel)
