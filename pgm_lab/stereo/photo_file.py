"""Photos of a block: on disk until they are needed, and which of them form pairs."""

import hashlib
import json
import warnings
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import scipy

from pgm_lab import _validate, matching
from pgm_lab.camera import Camera
from pgm_lab.camera.files import of_photo
from pgm_lab.camera.photo import Photo
from pgm_lab.io import geotiff
from pgm_lab.io import photo as photos
from pgm_lab.io.files import existing, printable
from pgm_lab.stereo import slips

TURN = 2 * np.pi + 1e-6  # radians: larger angles are degrees


@dataclass(frozen=True, eq=False)
class PhotoFile:
    """Name of a photo with its orientation: what `camera.Photo` contains, unread.

    Attributes
    ----------
    path : str or Path
        A JPEG, TIFF or PNG, or an array as `np.save` writes it; colours become grey.
    camera : Camera, str or Path
        Interior orientation and lens, in mm; or the camera.json with them, which is
        read at once, and the photo must have the size of its image.
    exterior : sequence of 6 numbers
        (X0, Y0, Z0, omega, phi, kappa), angles in radians.
    pixel_size : float
        In mm; a camera.json states it.
    image_size : (columns, rows), optional
        Of the whole sensor, where the file contains a part of it.
    corner : (column, row)
        Where pixel (0, 0) of the file lies on the sensor.
    crs : str, optional
        Coordinate reference system of the exterior. When missing that of the file, if
        it is a GeoTIFF whose place on the map fits the station.
    """

    path: str | Path
    camera: Camera | str | Path
    exterior: tuple[float, ...]
    pixel_size: float | None = None
    image_size: tuple[int, int] | None = None
    corner: tuple[int, int] = (0, 0)
    crs: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if isinstance(self.camera, str | Path):
            size = self.image_size or self._shape()[::-1]
            name = f"photo, {printable(self.path)}"
            held = photos.orientation(self.path)
            camera, pixel = of_photo(self.camera, size, self.pixel_size, name, held)
            object.__setattr__(self, "camera", camera)
            object.__setattr__(self, "pixel_size", pixel)
        elif self.pixel_size is None:
            raise ValueError("pixel_size is missing: a camera.json states it, in mm")

    def read(self) -> Photo:
        """Read the photo, grey, as the camera was held (`matching.read`)."""
        if Path(self.path).suffix == ".npy":
            return replace(self._photo(self._array()), crs=self.crs)
        grey = matching.read(self.path, colour="grey")
        if isinstance(grey, np.ma.MaskedArray):
            grey = np.ma.filled(grey.astype(np.float32), np.nan)
        return replace(self._photo(grey), crs=self.system())

    def blank(self) -> Photo:
        """Return the photo without its grey values: only the file's header is read."""
        return self._photo(np.broadcast_to(np.uint8(0), self._shape()))

    def system(self) -> str | None:
        """Coordinate reference system of the exterior; None where it is not known."""
        if self.crs is not None:
            return self.crs
        placed = geotiff.place(existing(self.path, f"photo, {printable(self.path)}"))
        if placed is None:
            return None
        crs, transform, (rows, columns) = placed
        # On the map of its orientation, a photo lies less than its size off the station
        A, corner = transform[:, :2], transform[:, 2]
        pixel = np.linalg.solve(A, np.asarray(self.exterior[:2], float) - corner)
        off = pixel / (columns, rows) - 0.5
        return crs if np.all(np.abs(off) <= 1.5) else None

    def fingerprint(self) -> str:
        """Hash of the file's content and of the orientation, not of its name."""
        with existing(self.path, f"photo, {printable(self.path)}").open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()
        return fingerprint(
            content,
            asdict(_validate.instance(self.camera, Camera, "camera")),
            np.asarray(self.exterior, float).tolist(),
            self.pixel_size,
            self.image_size,
            self.corner,
        )

    def _shape(self) -> tuple[int, ...]:
        """Rows and columns, from the head of the file."""
        if Path(self.path).suffix == ".npy":
            return self._array().shape
        return photos.shape(self.path, f"photo, {printable(self.path)}")

    def _array(self) -> np.ndarray:
        """Array of an .npy, on disk until it is needed; one with objects is refused."""
        name = f"photo, {printable(self.path)}"
        file = existing(self.path, name)
        try:
            array = np.lib.format.open_memmap(file, mode="r")  # no pickle: it runs code
        except Exception as error:  # whatever its head makes the parser stumble over
            reason = " ".join(str(error).split())[:200]
            raise ValueError(
                f"{name}: this is no array of numbers as np.save writes it ({reason})"
            ) from None
        if array.ndim != 2 or not array.size:
            raise ValueError(f"{name}: its shape is {array.shape}, not (rows, columns)")
        return array

    def _photo(self, grey: np.ndarray) -> Photo:
        exterior = _validate.one_point(self.exterior, 6, "exterior")
        if np.any(np.abs(exterior[3:]) > TURN):
            angles = ", ".join(f"{angle:g}" for angle in exterior[3:])
            raise ValueError(
                f"photo, {printable(self.path)}: omega, phi, kappa = {angles} are more"
                " than a turn: radians are expected, not degrees or gon"
            )
        camera = _validate.instance(self.camera, Camera, "camera")
        size = _validate.number(self.pixel_size, "pixel_size")
        return Photo(grey, camera, exterior, size, self.image_size, self.corner)


def fingerprint(*parts: object) -> str:
    """Hash of texts, numbers, lists and dictionaries."""
    text = json.dumps(parts, sort_keys=True, default=lambda number: number.item())
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def photo_list(photos: Any) -> list:
    """Photos in a list, if they are photos."""
    given = _validate.several(photos, "photos")
    if not all(isinstance(one, Photo | PhotoFile) for one in given):
        raise ValueError(
            "photos must be a sequence of camera.Photo or stereo.PhotoFile; got"
            f" {_validate.shown(photos)}"
        )
    return given


# --- Which of them form pairs ---


def neighbours(
    photos: Sequence[Photo | PhotoFile],
    *,
    ground: float,
    least: float = 0.5,
    most: float = 0.95,
) -> np.ndarray:
    """Pairs of photos that share enough of the ground.

    With 60 % overlap along the strips and 30 % across, these are each photo and the
    next of its strip. Photos with nearly the same station are not paired: their base is
    too short for heights.

    Parameters
    ----------
    photos : sequence of Photo or PhotoFile
        In any order; grey values are not read.
    ground : float
        Z of a level plane that represents the ground, in m.
    least, most : float
        Share of the smaller footprint that the other covers, from 0 to 1.

    Returns
    -------
    ndarray (n, 2) of int
        Indices of left and right photo, the smaller one first, in order. A warning says
        so if there are none, and how near to it some are.

    Raises
    ------
    ValueError
        If a photo looks above the horizon, or its station is below the ground.

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
    given = photo_list(photos)
    try:
        prints = [_footprint(photo, ground, k) for k, photo in enumerate(given)]
    except ValueError as error:
        raise ValueError(f"{error} {_slip(given, ground)}".rstrip()) from None
    if len(prints) < 2:
        return np.zeros((0, 2), int)

    # Only photos whose circles overlap are compared
    middles = np.array([corners.mean(0) for corners in prints])
    radius = [np.linalg.norm(p - m, axis=1).max() for p, m in zip(prints, middles)]
    tree = scipy.spatial.KDTree(middles)
    near = tree.query_pairs(2 * max(radius), output_type="ndarray")
    near = near[np.lexsort(near.T[::-1])].reshape(-1, 2)
    shares = np.array([_share(prints[i], prints[j]) for i, j in near])
    chosen = near[(least <= shares) & (shares <= most)]
    if not len(chosen):
        words = "none share any"
        if len(near):
            best = np.argmin(np.abs(shares - shares.clip(least, most)))
            i, j = near[best]
            other = "smaller least" if shares[best] < least else "greater most"
            words = f"photos {i} and {j} share {100 * shares[best]:.0f} % (a {other})"
        warnings.warn(
            f"no two photos share {100 * least:g} to {100 * most:g} % of the ground at"
            f" {ground:g} m: {words}. {_slip(given, ground)}".rstrip(),
            stacklevel=2,
        )
    return chosen.astype(int)


def _footprint(photo: Photo | PhotoFile, ground: float, k: int) -> np.ndarray:
    """Corners (4, 2) of a photo on level ground, in order around it."""
    if isinstance(photo, PhotoFile):
        photo = photo.blank()
    rows, columns = photo.grey.shape
    corners = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * (columns - 1, rows - 1)
    rays = photo.rays(corners)
    station = np.asarray(photo.exterior, float)[:3]
    if station[2] <= ground or np.any(rays[:, 2] >= 0):
        raise ValueError(
            f"photos[{k}], at {station[2]:g} m, does not look down on the ground at"
            f" {ground:g} m; is its orientation right?"
        )
    scale = (ground - station[2]) / rays[:, 2]
    return station[:2] + scale[:, None] * rays[:, :2]


def _slip(photos: list, ground: float) -> str:
    """What is probably wrong with the photos: only the two nearest are read."""
    stations = np.array([np.asarray(photo.exterior, float)[:3] for photo in photos])
    if len(stations) < 2:
        return ""
    distance, which = scipy.spatial.KDTree(stations).query(stations, 2)
    left, right = (photos[k] for k in np.sort(which[np.argmin(distance[:, 1])]))
    try:
        left, right = (
            photo.read() if isinstance(photo, PhotoFile) else photo
            for photo in (left, right)
        )
        return slips.likely((left, right), "heights", np.array([ground, ground]))
    except (ValueError, OSError):  # what cannot be read is said when it is needed
        return ""


def _share(one: np.ndarray, other: np.ndarray) -> float:
    """Common area of two footprints, divided by that of the smaller one."""
    low = one.mean(0)  # OpenCV computes in float32
    one, other = ((p - low).astype(np.float32) for p in (one, other))
    common, _ = cv2.intersectConvexConvex(one, other)
    return common / min(cv2.contourArea(one), cv2.contourArea(other))
