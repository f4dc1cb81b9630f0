"""Which photos of a block make pairs, told from their orientations."""

from collections.abc import Sequence

import cv2
import numpy as np
import scipy

from pgm_lab import _validate
from pgm_lab.camera.photo import Photo
from pgm_lab.stereo.photo_file import PhotoFile, photo_list


def neighbours(
    photos: Sequence[Photo | PhotoFile],
    *,
    ground: float,
    least: float = 0.5,
    most: float = 0.95,
) -> np.ndarray:
    """Pairs of photos that share enough of the ground.

    With 60 % overlap along the strips and 30 % across, these are each photo and the
    next of its strip. Photos nearly from the same place make no pair: their base is too
    short for heights.

    Parameters
    ----------
    photos : sequence of Photo or PhotoFile
        In any order; no grey value is looked at.
    ground : float
        Z of a level plane that stands for the ground, in m.
    least, most : float
        Share of the smaller footprint that the other covers, from 0 to 1.

    Returns
    -------
    ndarray (n, 2) of int
        Indices of left and right photo, the smaller one first, in order.

    Raises
    ------
    ValueError
        If a photo looks above the horizon, or stands below the ground.

    Examples
    --------
    >>> from pgm_lab.camera import Camera, Photo
    >>> strip = [
    ...     Photo(np.zeros((80, 100)), Camera(20.0), (x, 0, 1000, 0, 0, 0), 0.2)
    ...     for x in (0, 400, 800)
    ... ]
    >>> neighbours(strip, ground=0.0)
    array([[0, 1],
           [1, 2]])
    """
    ground = _validate.number(ground, "ground")
    least, most = _validate.number(least, "least"), _validate.number(most, "most")
    if not 0 <= least < most <= 1:
        raise ValueError(
            "least and most must be shares with 0 <= least < most <= 1; got"
            f" {least:g} and {most:g}"
        )
    prints = [_footprint(p, ground, k) for k, p in enumerate(photo_list(photos))]
    if len(prints) < 2:
        return np.zeros((0, 2), int)
    middles = np.array([corners.mean(0) for corners in prints])
    radius = [np.linalg.norm(p - m, axis=1).max() for p, m in zip(prints, middles)]
    near = scipy.spatial.KDTree(middles).query_pairs(
        2 * max(radius), output_type="ndarray"
    )
    chosen = [k for k in near if least <= _share(*(prints[i] for i in k)) <= most]
    return np.array(sorted(map(tuple, chosen)), int).reshape(-1, 2)


def _footprint(photo, ground, k):
    """Corners (4, 2) of a photo on level ground, in order around it."""
    if isinstance(photo, PhotoFile):
        photo = photo.blank()
    rows, columns = photo.grey.shape
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * (columns - 1, rows - 1)
    rays = photo.rays(corners)
    station = np.asarray(photo.exterior, float)[:3]
    if station[2] <= ground or np.any(rays[:, 2] >= 0):
        raise ValueError(
            f"photos[{k}] does not look down on the ground at {ground:g} m; is its"
            " orientation right?"
        )
    scale = (ground - station[2]) / rays[:, 2]
    return station[:2] + scale[:, None] * rays[:, :2]


def _share(one, other):
    """Area that two footprints have in common, by the smaller one."""
    low = one.mean(0)  # OpenCV counts in float32
    one, other = ((p - low).astype(np.float32) for p in (one, other))
    common, _ = cv2.intersectConvexConvex(one, other)
    return common / min(cv2.contourArea(one), cv2.contourArea(other))
