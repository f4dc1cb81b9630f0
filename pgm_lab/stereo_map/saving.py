"""The points of a session as image observations, as a file and as a network."""

import os
from pathlib import Path

import numpy as np

from pgm_lab import _validate, bundle
from pgm_lab.observations import Observations
from pgm_lab.stereo_map.session import LEFT, RIGHT, Session


def observations(session: Session) -> Observations:
    """Return the points on the list as observations in the photos 1 and 2.

    Examples
    --------
    >>> from pgm_lab import simulate, stereo_map
    >>> pair = simulate.aerial_pair((240, 180))
    >>> session = stereo_map.open_pair(pair.left, pair.right)
    >>> session = stereo_map.add(session, stereo_map.measure(session, (100, 80)))
    >>> print(observations(session))
    photo 1: 1 points
    photo 2: 1 points
    """
    _validate.instance(session, Session, "session")
    points = session.points
    if not points:
        raise ValueError("no point was kept yet: measure some, and keep them")
    names = tuple(point.name for point in points)
    return Observations(
        (LEFT,) * len(points) + (RIGHT,) * len(points),
        names * 2,
        np.concatenate([[p.photo[k] for p in points] for k in (0, 1)]),
        np.concatenate([[p.photo_covariance[k] for p in points] for k in (0, 1)]),
        {},
    )


def save(session: Session, path: str | os.PathLike, *, overwrite: bool = False) -> None:
    """Save the points on the list: the table of image coordinates of `bundle.read`.

    Comma-separated: point, photo, x, y, sx, sy in mm; the left photo is 1, the right
    one 2. `bundle.read` and `bundle.Network.of` take it; the rows of `observations`
    also have the covariances.

    Raises
    ------
    ValueError
        If no point was kept yet.
    FileExistsError, OSError
        If the file is there already and `overwrite` is False, or cannot be written: an
        old one stays.
    """
    observations(session).save(path, overwrite=overwrite)


def network(session: Session) -> bundle.Network:
    """Return the two photos and their points as a network, ready to be adjusted.

    Raises
    ------
    ValueError
        If the photos are not oriented, or no point was kept yet.
    """
    seen = observations(session)
    if session.space == "none":
        raise ValueError("the photos are not oriented yet: orient them first")
    cameras = {LEFT: session.left.camera, RIGHT: session.right.camera}
    photos = {LEFT: session.left.exterior, RIGHT: session.right.exterior}
    points = {point.name: point.xyz for point in session.points}
    if cameras[LEFT] == cameras[RIGHT]:
        return bundle.Network.of(cameras[LEFT], photos, points, seen.rows)
    of_photo = {name: name for name in photos}
    return bundle.Network.of(cameras, photos, points, seen.rows, camera=of_photo)


def save_network(
    session: Session, folder: str | os.PathLike, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Save photos and points as the four files that `bundle.read` takes.

    They are interior.txt, exterior.txt, points.txt and image.txt of a folder, returned
    in the order of `bundle.read`. Correlations of x and y have no place in them;
    `network` has them.

    Raises
    ------
    ValueError
        As `network`, or if the photos have two cameras.
    FileExistsError, OSError
        If a file is there already and `overwrite` is False, or cannot be written.
    """
    whole = network(session)
    plain = bundle.Network(
        whole.cameras, whole.exteriors, whole.points, whole.photo, whole.point,
        whole.xy, whole.sigma, whole.camera,
        photo_names=whole.photo_names, point_names=whole.point_names,
    )  # fmt: skip
    return bundle.write(plain, folder, overwrite=overwrite)
