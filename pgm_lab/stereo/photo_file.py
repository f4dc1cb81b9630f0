"""A photo that stays on the disk until somebody needs its grey values."""

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pgm_lab import _validate, matching
from pgm_lab.camera import Camera
from pgm_lab.camera.photo import Photo
from pgm_lab.io import photo as photos


@dataclass(frozen=True, eq=False)
class PhotoFile:
    """Name of a photo with its orientation: what `camera.Photo` holds, unread.

    Attributes
    ----------
    path : str or Path
        A JPEG, TIFF or PNG, or an array as `np.save` writes it; colours become grey.
    camera : Camera
        Interior orientation and lens, in mm.
    exterior : sequence of 6 numbers
        (X0, Y0, Z0, omega, phi, kappa).
    pixel_size : float
        In mm.
    image_size : (columns, rows), optional
        Of the whole sensor, where the file holds a part of it.
    corner : (column, row)
        Where pixel (0, 0) of the file lies on the sensor.
    """

    path: str | Path
    camera: Camera
    exterior: tuple[float, ...]
    pixel_size: float
    image_size: tuple[int, int] | None = None
    corner: tuple[int, int] = (0, 0)

    def read(self) -> Photo:
        """Read the photo, grey, as the camera was held (`matching.read`).

        Raises
        ------
        FileNotFoundError, OSError
            If the file cannot be read.
        ValueError
            If it is no photo.
        """
        if Path(self.path).suffix == ".npy":
            return self._photo(np.load(self.path, mmap_mode="r"))
        grey = matching.read(self.path, colour="grey")
        if isinstance(grey, np.ma.MaskedArray):
            grey = np.ma.filled(grey.astype(np.float32), np.nan)
        return self._photo(grey)

    def blank(self) -> Photo:
        """Give the photo without its grey values: only the head of the file is read."""
        if Path(self.path).suffix == ".npy":
            shape = np.load(self.path, mmap_mode="r").shape
        else:
            shape = photos.shape(self.path, "photo")
        return self._photo(np.broadcast_to(np.uint8(0), shape))

    def fingerprint(self) -> str:
        """Hash of the file's content and of the orientation, not of its name."""
        with Path(self.path).open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()
        return fingerprint(
            content,
            asdict(self.camera),
            np.asarray(self.exterior, float).tolist(),
            self.pixel_size,
            self.image_size,
            self.corner,
        )

    def _photo(self, grey: np.ndarray) -> Photo:
        exterior = np.asarray(self.exterior, float)
        return Photo(
            grey, self.camera, exterior, self.pixel_size, self.image_size, self.corner
        )


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
