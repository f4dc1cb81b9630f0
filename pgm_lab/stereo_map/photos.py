"""The reader's own two photos: grey values from a file, the camera from its EXIF."""

import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from pgm_lab import _validate, matching
from pgm_lab.camera import Camera
from pgm_lab.camera.files import of_photo
from pgm_lab.camera.photo import Photo
from pgm_lab.io.files import printable
from pgm_lab.io.photo import ORIENTATION, opened, orientation
from pgm_lab.io.photo import Photo as Source

FOCAL, FOCAL_35MM = 0x920A, 0xA405
PER_UNIT, UNIT = 0xA20E, 0xA210  # pixels a unit across the sensor, and the unit
MM_OF_UNIT = {2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}  # 1 is "no unit"
EXIF = 0x8769
DIAGONAL_35MM = 43.2666  # mm, of 36 x 24

WANTED = (
    "give camera=Camera(c), the principal distance in mm, and pixel_size, the size of"
    " a pixel on the sensor in mm; or camera='camera.json' of a calibration"
)


def read_photo(
    photo: Source | Photo,
    name: str = "photo",
    *,
    camera: Camera | str | os.PathLike | None = None,
    pixel_size: float | None = None,
    exterior: ArrayLike | None = None,
) -> Photo:
    """Read a photo with its camera; what is not given is taken from EXIF.

    Parameters
    ----------
    photo : str, path, PIL.Image.Image, array_like or Photo
        As for `matching.read`; colours become grey. A `Photo` is taken as it is.
    name : str
        What messages call it.
    camera : Camera, str or path, optional
        In mm, or the camera.json with it, which has the pixel size too. From EXIF comes
        c alone, without principal point and lens.
    pixel_size : float, optional
        In mm.
    exterior : array_like (6,), optional
        (X0, Y0, Z0, omega, phi, kappa); zero when missing.

    Raises
    ------
    ValueError
        If the photo is none, or its camera is neither given nor in EXIF.
    FileNotFoundError, OSError
        If the file cannot be read.
    """
    _validate.text(name, "name")
    if isinstance(photo, Photo):
        if camera is not None or pixel_size is not None or exterior is not None:
            raise ValueError(
                f"{name} is a Photo, which has camera, pixel_size and exterior already:"
                " give the grey values or a file with them"
            )
        return photo
    grey = matching.read(photo, name, colour="grey")
    if camera is not None:
        held = 1  # as it lies on the sensor
        if isinstance(photo, str | os.PathLike):
            held = orientation(photo)
        elif isinstance(photo, Image.Image):
            held = photo.getexif().get(ORIENTATION, 1)
        camera, pixel_size = of_photo(camera, grey.shape[::-1], pixel_size, name, held)
    if camera is None or pixel_size is None:
        c, size = exif_camera(photo, grey.shape[::-1])
        camera = camera or (None if c is None else Camera(c))
        pixel_size = size if pixel_size is None else pixel_size
    if camera is None or pixel_size is None:
        raise ValueError(f"{name} does not say in EXIF which camera took it: {WANTED}")
    size = _validate.positive_number(pixel_size, "pixel_size", "mm")
    place = np.zeros(6) if exterior is None else exterior
    return Photo(grey, camera, _validate.one_point(place, 6, "exterior"), size)


def exif_camera(
    photo: Source, image_size: Sequence[int]
) -> tuple[float | None, float | None]:
    """Principal distance and pixel size in mm that EXIF states; None where it does not.

    c is the focal length: a start, good to some per cent. The pixel size is from the
    resolution of the focal plane, or from the focal length equivalent to 35 mm film.
    Arrays have no EXIF. image_size: (columns, rows). Raises as `read_photo`.
    """
    columns, rows = _validate.image_size(image_size)
    if isinstance(photo, str | os.PathLike):
        with opened(photo, f"photo, {printable(photo)}") as image:
            tags = image.getexif().get_ifd(EXIF)
    elif isinstance(photo, Image.Image):
        tags = photo.getexif().get_ifd(EXIF)
    else:
        return None, None
    c = _number(tags.get(FOCAL))
    resolution, like_35mm = _number(tags.get(PER_UNIT)), _number(tags.get(FOCAL_35MM))
    unit = MM_OF_UNIT.get(tags.get(UNIT, 2))
    if resolution and unit:
        return c, unit / resolution
    if c and like_35mm:
        return c, DIAGONAL_35MM * c / like_35mm / float(np.hypot(columns, rows))
    return c, None


def _number(value: Any) -> float | None:
    """A tag as a positive number, or None."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return number if 0 < number < np.inf else None
