"""The points of a board in a photo: detected, then measured with their covariance."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from pgm_lab import _validate
from pgm_lab.calibration import corners
from pgm_lab.calibration.board import Board
from pgm_lab.calibration.detect import detect
from pgm_lab.io import photo as photos
from pgm_lab.io.files import printable

# EXIF: how to turn a photo back to how the sensor saw it
TURNED_BACK = {6: 8, 8: 6}
ENDINGS = (".jpg", ".jpeg", ".png", ".tif", ".tiff", ".heic", ".heif", ".webp", ".bmp")
MAKE, MODEL, MORE = 0x010F, 0x0110, 0x8769
FOCAL, FOCAL_35 = 0x920A, 0xA405
DIAGONAL_35 = float(np.hypot(36, 24))  # mm, what focal lengths are compared on
# What is not measured by its edges gets its accuracy from the residuals of its photo
UNKNOWN_SD = 0.02  # px
# A window keeps so far from the next edge, of which the blur would come in (px)
CLEAR = 1.5


@dataclass(frozen=True, eq=False)
class Measured:
    """The points of a board in one photo, as the sensor saw it.

    Attributes
    ----------
    name : str
    image_size : (columns, rows)
        Of the sensor: of a photo that EXIF turns before it is shown, unturned.
    ids : ndarray (k,) of int
        Numbers of the board's points.
    pixels : ndarray (k, 2)
        (column, row).
    covariance : ndarray (k, 2, 2)
        In square pixels, from the grey values.
    blur : float
        Standard deviation of the blur across an edge, the median, in pixels; NaN where
        nothing was measured.
    words : str
        Why the photo cannot be used; empty if it can.
    model : (str or None, str or None)
        Maker and model of the camera, from EXIF.
    focal, focal_35 : float or None
        Focal length in mm, and that of the same field of view on 36 x 24 mm, from EXIF.
    """

    name: str
    image_size: tuple[int, int]
    ids: np.ndarray
    pixels: np.ndarray
    covariance: np.ndarray
    blur: float
    words: str = ""
    model: tuple[str | None, str | None] = (None, None)
    focal: float | None = None
    focal_35: float | None = None


def measure(
    photo: str | os.PathLike | np.ndarray, board: Board, name: str = ""
) -> Measured:
    """Measure the points of a board in a photo.

    Parameters
    ----------
    photo : str, path or array_like (rows, columns)
        JPEG, PNG, TIFF and others, or grey values.
    board : Board
    name : str
        For reports; that of the file when missing.

    Returns
    -------
    Measured
        What is wrong with the photo stands in its `words`.

    Raises
    ------
    FileNotFoundError, OSError
        If the file cannot be read.
    ValueError
        If it is no photo.
    """
    _validate.instance(board, Board, "board")
    grey = np.ma.filled(photos.read(photo, colour="grey"), 0)
    exif = {}
    if isinstance(photo, str | os.PathLike):
        name = name or printable(Path(photo).name)
        held = photos.orientation(photo)
        grey = photos.upright(grey, TURNED_BACK.get(held, held))
        exif = _exif(photo)
    size = grey.shape[1], grey.shape[0]
    ids, near, words = detect(grey, board)
    if words:
        nothing = np.zeros((0, 2)), np.zeros((0, 2, 2)), np.nan
        return Measured(name, size, np.zeros(0, int), *nothing, words, **exif)
    if board.kind in ("charuco", "chequerboard"):
        found = corners.refine(grey, near, _radius(board, ids, near))
        good = found.status == "measured"
        pixels, covariance = found.pixels[good], found.covariance[good]
        blur = float(np.median(found.blur[good])) if good.any() else np.nan
        ids = ids[good]
    else:
        pixels, blur = near, np.nan
        if "circles" in board.kind:
            pixels = near - _eccentricity(board, ids, near)
        covariance = np.broadcast_to(UNKNOWN_SD**2 * np.eye(2), (len(ids), 2, 2))
    return Measured(name, size, ids, pixels, covariance, blur, "", **exif)


def pixel_size(photos: Sequence[Measured]) -> float | None:
    """Size of a pixel in mm by the focal lengths in EXIF; None where they are missing.

    A lens of the focal length f sees what f35 would see on 36 mm x 24 mm, so the
    sensor's diagonal is f / f35 of that. To some per cent: f35 is a whole number.
    """
    for one in photos:
        if one.focal and one.focal_35:
            diagonal = DIAGONAL_35 * one.focal / one.focal_35
            return float(diagonal / np.hypot(*one.image_size))
    return None


def _radius(board: Board, ids: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Radius (k,) in pixels around corners in which only their own edges are seen."""
    # The board around each corner is imaged by a homography: its squares' sides there
    flat = np.column_stack([board.points[ids, :2], np.ones(len(ids))])
    H = cv2.findHomography(board.points[ids, :2], near)[0]
    h = flat @ H.T
    # d(column, row) / d(X, Y) of the homography, (k, 2, 2)
    J = (H[:2, :2] - (h[:, :2] / h[:, 2:])[:, :, None] * H[2, :2]) / h[:, 2, None, None]
    side = board.square * J
    area = np.abs(np.linalg.det(side))
    # To the next edge of a square, or to the corner of a marker within one
    radius = area / np.linalg.norm(side, axis=1).max(axis=1)
    if board.marker:
        gap = (1 - board.marker / board.square) / 2
        diagonals = side @ np.array([[1, 1], [1, -1]]).T
        radius = np.minimum(radius, gap * np.linalg.norm(diagonals, axis=1).min(axis=1))
    return radius - CLEAR


def _eccentricity(board: Board, ids: np.ndarray, near: np.ndarray) -> np.ndarray:
    """How far (k, 2) the centre of each ellipse is from the image of its circle's.

    The dual conic of a circle around (X, Y) is T diag(r^2, r^2, -1) T' with its shift
    T; a homography H makes it H T ... T' H', whose last column is the ellipse's centre.
    """
    H = cv2.findHomography(board.points[ids, :2], near)[0]
    T = np.tile(np.eye(3), (len(ids), 1, 1))
    T[:, :2, 2] = board.points[ids, :2]
    r = (board.marker or 0.0) / 2
    dual = H @ T @ np.diag([r**2, r**2, -1.0]) @ T.swapaxes(1, 2) @ H.T
    centre = H @ T[:, :, 2:]
    return dual[:, :2, 2] / dual[:, 2:, 2] - centre[:, :2, 0] / centre[:, 2:, 0]


def _exif(path: str | os.PathLike) -> dict:
    """What EXIF says of the camera: `model`, `focal` and `focal_35`."""
    with photos.opened(path, "") as image:
        head = image.getexif()
        more = head.get_ifd(MORE)

    def text(tag: int) -> str | None:
        value = head.get(tag)
        return value.strip("\0 ") or None if isinstance(value, str) else None

    def number(tag: int) -> float | None:
        try:
            value = float(more[tag])
        except (KeyError, TypeError, ValueError, ZeroDivisionError):
            return None
        return value if np.isfinite(value) and value > 0 else None

    model = text(MAKE), text(MODEL)
    return {"model": model, "focal": number(FOCAL), "focal_35": number(FOCAL_35)}
