"""Two photos and the points that were measured in them; nothing of it draws.

A session is never changed: each step returns a new one, which keeps the one before it.
"""

import os
from dataclasses import dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import Camera
from pgm_lab.camera.photo import Photo
from pgm_lab.io.photo import Photo as Source
from pgm_lab.orientation import Relative
from pgm_lab.stereo_map.photos import read_photo

LEFT, RIGHT = 1, 2  # names of the photos, in files and networks
TEMPLATE = 21  # pixels, as in 2010
THRESHOLD = 0.7  # smallest correlation, as in 2010
ACCEPTED = "accepted"
MIN_LEVEL = 40  # pixels across the coarsest level of a pyramid, at least
WORDS = {
    ACCEPTED: "Found.",
    "outside": "The click is outside of the photo.",
    "template leaves the image": "Too near to the edge of the left photo: its window"
    " would leave the photo.",
    "window leaves the image": "The point is predicted outside of the right photo.",
    "flat template": "All grey values around the click are equal: nothing to match.",
    "flat window": "The right photo has no texture there.",
    "below threshold": "Nothing in the right photo is similar enough (r below"
    f" {THRESHOLD}): the point may be hidden there, or lie elsewhere. A click in the"
    " right photo says where to look.",
    "ambiguous": "Two places look nearly the same. A click in the right photo says"
    " where to look.",
    "left-right check failed": "Matching back from the right photo leads"
    " elsewhere: one of the photos may not show the point.",
    "peak on the border of the search": "The best position lies on the border of the"
    " search. A click in the right photo says where to look.",
    "peak on the edge of the image": "The match lies on the edge of the right photo.",
    "position not determined": "The texture is a line: along it the match is not"
    " determined. Take a corner or a spot.",
    "off the epipolar line": "The match lies off the epipolar line: it is wrong, or the"
    " orientation is.",
}


def _nan(*shape: int, repr: bool = True) -> Any:
    return field(default_factory=lambda: np.full(shape, np.nan), repr=repr)


def _empty(*shape: int) -> Any:
    return field(default_factory=lambda: np.zeros(shape), repr=False)


@dataclass(frozen=True, eq=False)
class Measurement:
    """A point that was clicked in the left photo; NaN or empty what was not found.

    Attributes
    ----------
    name : int
        Its number on the list; 0 before it is kept.
    left : ndarray (2,)
        (column, row) in the left photo, in pixels.
    right : ndarray (2,)
        The match in the right photo, by least squares.
    correlated : ndarray (2,)
        The match by correlation, from which least squares began.
    r, r_fine : float
        Correlation at the highest peak, and after least squares matching.
    covariance : ndarray (2, 2)
        Of `right`, in square pixels, with what a window of twice the width adds.
    shape : ndarray (2, 2)
        ((a1, a2), (b1, b2)) of (B 2.8), (B 2.9), from left to right.
    template : ndarray (h, w)
        Grey values of the left window.
    window : ndarray (H, W)
        Grey values of the right photo that were searched.
    corner : ndarray (2,)
        (column, row) in the right photo of the first pixel of `window`.
    map : ndarray (H - h + 1, W - w + 1)
        Correlation at each place of the template in `window`.
    curve : ndarray (k, 2)
        Epipolar curve in the right photo, in pixels.
    start, reason : ndarray (2,), str
        Where the search in the right photo began, and why there.
    photo : ndarray (2, 2)
        (x, y) in mm in the left and in the right photo.
    photo_covariance : ndarray (2, 2, 2)
        Their covariances in mm^2: each photo has half the noise of the match.
    xyz : ndarray (3,)
        Object coordinates.
    xyz_covariance : ndarray (3, 3)
        Their covariance; the orientation is taken as free of errors.
    y_parallax : float
        Distance of `right` from the epipolar curve, in pixels.
    status : str
        "accepted"; a status of `ncc.Match`; "least squares: " and one of `lsm.Match`;
        "off the epipolar line"; "intersection: " and one of `orientation.Intersection`.
    """

    left: np.ndarray
    name: int = 0
    right: np.ndarray = _nan(2)
    correlated: np.ndarray = _nan(2)
    r: float = np.nan
    r_fine: float = np.nan
    covariance: np.ndarray = _nan(2, 2)
    shape: np.ndarray = field(default_factory=lambda: np.eye(2), repr=False)
    template: np.ndarray = _empty(0, 0)
    window: np.ndarray = _empty(0, 0)
    corner: np.ndarray = _nan(2)
    map: np.ndarray = _empty(0, 0)
    curve: np.ndarray = _empty(0, 2)
    start: np.ndarray = _nan(2)
    reason: str = ""
    photo: np.ndarray = _nan(2, 2)
    photo_covariance: np.ndarray = _nan(2, 2, 2, repr=False)
    xyz: np.ndarray = _nan(3)
    xyz_covariance: np.ndarray = _nan(3, 3, repr=False)
    y_parallax: float = np.nan
    status: str = "outside"

    @property
    def accepted(self) -> bool:
        """Whether the point was found."""
        return self.status == ACCEPTED

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations (3,) of X, Y, Z."""
        return np.sqrt(np.diagonal(self.xyz_covariance))

    @property
    def photo_sd(self) -> np.ndarray:
        """Standard deviations (2, 2) of x and y in mm, left and right."""
        return np.sqrt(np.diagonal(self.photo_covariance, axis1=1, axis2=2))

    @property
    def why(self) -> str:
        """The status in a plain sentence."""
        return WORDS.get(self.status, f"{self.status[:1].upper()}{self.status[1:]}.")


@dataclass(frozen=True, eq=False)
class Session:
    """Two photos, how they are oriented, and the points so far.

    Attributes
    ----------
    left, right : Photo
        Not oriented yet, their exterior orientations are zero.
    space : {"none", "model", "object"}
        What object coordinates are in: none; the model, whose base in x is 1, or -1 to
        the left; the unit of the given orientation or control points.
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
    camera: Camera | str | os.PathLike | None = None,
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
    camera : Camera, str or path, optional
        Of both photos, in mm, or the camera.json with it, which has the pixel size too.
        When missing, c is taken from EXIF: a start, without principal point and lens.
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
    >>> from pgm_lab import simulate, stereo_map
    >>> pair = simulate.aerial_pair((240, 180))
    >>> session = open_pair(pair.left, pair.right)
    >>> point = stereo_map.measure(session, (100, 80))
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
    stations = [np.asarray(one.exterior, float) for one in pair]
    oriented = any(station.any() for station in stations)
    if oriented and np.array_equal(stations[0][:3], stations[1][:3]):
        raise ValueError(
            "both photos stand at the same place: without a base no rays intersect"
        )
    return Session(
        pair[0],
        pair[1],
        "object" if oriented else "none",
        heights=None if heights is None else (low, high),
        template=template,
        levels=(_levels(pair[0].grey), _levels(pair[1].grey)),
    )


def _levels(grey: np.ndarray) -> list[np.ndarray]:
    """The photo and its halves, of its type; pixel p of level k is at 2**k p in it."""
    # Where a pixel has no data stands the median of the others. (`image.pyramid` has
    # floats: eight times the memory of a photo of 8 bits.)
    first = np.ma.masked_invalid(grey, copy=False)
    mask = np.ma.getmaskarray(first) if np.ma.is_masked(first) else None
    image = np.asarray(first.data)
    if image.dtype not in (np.uint8, np.uint16, np.float32):  # what OpenCV halves fast
        image = image.astype(np.float32)
    if mask is not None:
        image = np.where(mask, np.median(image[~mask]), image).astype(image.dtype)
    found = [image]
    while min(found[-1].shape) >= 2 * MIN_LEVEL:
        found.append(cv2.pyrDown(found[-1]))
    return found


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
