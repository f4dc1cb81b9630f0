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

    Parameters
    ----------
    session : Session
    path : str or path
        A file of comma-separated values: point, photo, x, y, sx, sy in mm. The left
        photo is 1, the right one 2. `bundle.read` and `bundle.Network.of` take it; the
        rows of `observations` also have the covariances.
    overwrite : bool
        Whether a file of this name may be replaced.

    Raises
    ------
    ValueError
        If no point was kept yet.
    FileExistsError
        If the file is there already.
    OSError
        If it cannot be written; an old one stays.
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

    The files have no place for the correlations of x and y; `network` has them.

    Parameters
    ----------
    session : Session
        Oriented, with the same camera for both photos.
    folder : str or path
        Where interior.txt, exterior.txt, points.txt and image.txt shall stand.
    overwrite : bool
        Whether files of these names may be replaced.

    Returns
    -------
    tuple of pathlib.Path
        The four files, in the order of `bundle.read`.

    Raises
    ------
    ValueError
        As `network`, or if the photos have two cameras.
    FileExistsError
        If a file is there already.
    OSError
        If a file cannot be written.
    """
    overwrite = _validate.flag(overwrite, "overwrite")
    whole = network(session)
    plain = bundle.Network(
        whole.cameras, whole.exteriors, whole.points, whole.photo, whole.point,
        whole.xy, whole.sigma, whole.camera,
        photo_names=whole.photo_names, point_names=whole.point_names,
    )  # fmt: skip
    return bundle.write(plain, folder, overwrite=overwrite)
