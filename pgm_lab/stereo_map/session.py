"""Two photos and the points that were measured in them; nothing of it draws.

A session is never changed: each step returns a new one, which knows the one before it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import Camera
from pgm_lab.camera.photo import Photo
from pgm_lab.io.photo import Photo as Source
from pgm_lab.orientation import Relative, absolute, relative
from pgm_lab.stereo_map import _control
from pgm_lab.stereo_map._levels import levels
from pgm_lab.stereo_map._measure import measured, positioned
from pgm_lab.stereo_map._measurement import Measurement
from pgm_lab.stereo_map.photos import read_photo

LEFT, RIGHT = 1, 2  # names of the photos, in files and networks
SPACES = ("none", "model", "object")
TEMPLATE = 21  # pixels, as in 2010
FEWEST = 5  # points that orient two photos
USABLE = ("converged", "no redundancy", "several solutions", "weak geometry",
          "gimbal lock")  # fmt: skip


@dataclass(frozen=True, eq=False)
class Session:
    """Two photos, how they are oriented, and the points so far.

    Attributes
    ----------
    left, right : Photo
        Not oriented yet, their exterior orientations are zero.
    space : {"none", "model", "object"}
        What object coordinates are in: there are none; units of the model, in which the
        base in x is 1, or -1 to the left; the unit of the given orientation or control
        points.
    points : tuple of Measurement
        Those that were kept, in their order.
    heights : (low, high) or None
        Between which Z the object lies, in object space.
    template : int
        Width of the template in pixels.
    relative : Relative or None
        Of the last relative orientation, whose points are those named in `oriented_by`.
    oriented_by : tuple of int
        Names of the points that oriented the photos.
    before : Session or None
        The session before the last step.
    levels : tuple of two lists of ndarray
        Each photo at its own size, at half of it, and so on.
    """

    left: Photo
    right: Photo
    space: str = "none"
    points: tuple[Measurement, ...] = ()
    heights: tuple[float, float] | None = None
    template: int = TEMPLATE
    relative: Relative | None = None
    oriented_by: tuple[int, ...] = ()
    before: "Session | None" = field(default=None, repr=False)
    levels: tuple[list[np.ndarray], list[np.ndarray]] = field(
        default=([], []), repr=False
    )

    @property
    def photos(self) -> tuple[Photo, Photo]:
        """The left and the right photo."""
        return self.left, self.right

    @property
    def unit(self) -> str:
        """What lengths in object space are counted in, in words."""
        return "model units" if self.space == "model" else "object units"


def open_pair(
    left: Source | Photo,
    right: Source | Photo,
    *,
    camera: Camera | None = None,
    pixel_size: float | None = None,
    exteriors: ArrayLike | None = None,
    heights: ArrayLike | None = None,
    template: int = TEMPLATE,
) -> Session:
    """Open two photos of the same object.

    Parameters
    ----------
    left, right : str, path, PIL.Image.Image, array_like or Photo
        Files that Pillow opens, as for `matching.read`; colours become grey. A `Photo`
        has its camera and its orientation already.
    camera : Camera, optional
        Of both photos, in mm. When missing, c is taken from EXIF: a start, without
        principal point and lens.
    pixel_size : float, optional
        In mm; from EXIF when missing.
    exteriors : array_like (2, 6), optional
        (X0, Y0, Z0, omega, phi, kappa) of both, if they are known.
    heights : (low, high), optional
        Between which Z the object lies: the search is then shorter.
    template : int
        Width of the template in pixels, odd.

    Returns
    -------
    Session

    Raises
    ------
    ValueError
        If something is not what is described here, or no camera is known.
    FileNotFoundError, OSError
        If a file cannot be read.

    Examples
    --------
    >>> from pgm_lab import simulate
    >>> pair = simulate.aerial_pair((240, 180))
    >>> session = open_pair(pair.left, pair.right)
    >>> point = measure(session, (100, 80))
    >>> print(point.status, session.space)
    accepted object
    """
    template = _validate.window(template, "template", 5)
    if heights is not None:
        low, high = _validate.of_shape(heights, (2,), "heights").tolist()
        if not low < high:
            raise ValueError(f"heights must be (low, high); got {low:g}, {high:g}")
    known: list[np.ndarray | None] = [None, None]
    if exteriors is not None:
        known = list(_validate.of_shape(exteriors, (2, 6), "exteriors"))
    pair = [
        read_photo(photo, name, camera=camera, pixel_size=pixel_size, exterior=exterior)
        for photo, name, exterior in zip((left, right), ("left", "right"), known)
    ]
    for one, name in zip(pair, ("left", "right")):
        _validate.grey_image(one.grey, name, template + 2)
    places = [np.asarray(one.exterior, float) for one in pair]
    oriented = any(place.any() for place in places)
    if oriented and np.array_equal(places[0][:3], places[1][:3]):
        raise ValueError(
            "both photos stand at the same place: without a base, no point meets"
        )
    return Session(
        pair[0],
        pair[1],
        "object" if oriented else "none",
        heights=None if heights is None else (low, high),
        template=template,
        levels=(levels(pair[0].grey), levels(pair[1].grey)),
    )


def measure(
    session: Session,
    pixel: ArrayLike,
    near: ArrayLike | None = None,
    *,
    reach: float = 25.0,
) -> Measurement:
    """Find a point of the left photo in the right one, and in object space.

    The search is along the epipolar curve once the photos are oriented; before that
    around the place that the points so far predict, or in the whole photo without any.

    Parameters
    ----------
    session : Session
    pixel : array_like (2,)
        (column, row) in the left photo.
    near : array_like (2,), optional
        About where it is in the right photo, as a click there says.
    reach : float
        How far from `near` it may be, in pixels.

    Returns
    -------
    Measurement
        Its `status` says whether it was found, or why not.

    Raises
    ------
    ValueError
        If a pixel is not one point of two numbers.
    """
    _validate.instance(session, Session, "session")
    pixel = _validate.one_point(pixel, 2, "pixel")
    if near is not None:
        near = _validate.one_point(near, 2, "near")
    reach = _validate.positive_number(reach, "reach", "px")
    return measured(session, pixel, near, reach)


def add(session: Session, point: Measurement) -> Session:
    """Keep a point: return the session with it, under the next free number.

    Raises
    ------
    ValueError
        If the point was not found, or is on the list already.
    """
    _validate.instance(session, Session, "session")
    _validate.instance(point, Measurement, "point")
    if not point.accepted:
        raise ValueError(f"only a point that was found is kept; this one: {point.why}")
    for other in session.points:
        if np.array_equal(other.left, point.left):
            raise ValueError(f"this is point {other.name}, which is on the list")
    name = max((other.name for other in session.points), default=0) + 1
    points = (*session.points, replace(point, name=name))
    return replace(session, points=points, before=session)


def undo(session: Session) -> Session:
    """Take back the last step: a point that was kept, or an orientation.

    Raises
    ------
    ValueError
        If there is nothing to take back.
    """
    _validate.instance(session, Session, "session")
    if session.before is None:
        raise ValueError("there is nothing to take back")
    return session.before


def orient(session: Session, control: Mapping[int, ArrayLike] | None = None) -> Session:
    """Orient the photos by the points on the list.

    Parameters
    ----------
    session : Session
        With five points or more; six control each other, and a dozen spread over the
        photos are good.
    control : mapping {number of a point: (X, Y, Z)}, optional
        Three or more points that are known in object space. Without them coordinates
        are those of a model: its origin is the left station, its axes are those of the
        left photo, its unit is the base in x.

    Returns
    -------
    Session
        Oriented; each point has object coordinates and its `y_parallax`.

    Raises
    ------
    ValueError
        If there are too few points, or they do not determine the orientation.
    """
    _validate.instance(session, Session, "session")
    if len(session.points) < FEWEST:
        raise ValueError(
            f"{FEWEST} points or more orient two photos, better ten; there are"
            f" {len(session.points)}"
        )
    known = _control.points([point.name for point in session.points], control)
    xy = np.array([point.photo for point in session.points])
    variances = np.array([point.photo_covariance for point in session.points])
    sigma = float(np.sqrt(np.mean(variances[..., [0, 1], [0, 1]])))
    cameras = session.left.camera, session.right.camera
    found = relative(*cameras, xy[:, 0], xy[:, 1], sigma=sigma)
    if found.status not in USABLE:
        raise ValueError(
            f"the points give no orientation: {found.status}. Were the photos taken"
            " from two places, and are all points right?"
        )
    exteriors = np.array([np.zeros(6), found.exterior])
    if known:
        rows = [k for k, point in enumerate(session.points) if point.name in known]
        ground = np.array([known[session.points[k].name] for k in rows])
        exteriors = _control.carried(exteriors, absolute(found.points[rows], ground))
    left, right = (
        replace(photo, exterior=exterior)
        for photo, exterior in zip(session.photos, exteriors)
    )
    oriented = replace(
        session,
        left=left,
        right=right,
        space="object" if known else "model",
        relative=found,
        oriented_by=tuple(point.name for point in session.points),
        before=session,
    )
    points = tuple(positioned(oriented, point) for point in session.points)
    return replace(oriented, points=points)
