"""A photo of a user, from wherever it comes: a file, Pillow or an array."""

import io
import os
import stat
import warnings
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from pgm_lab import _validate
from pgm_lab._files import printable
from pgm_lab.datasets import GREY_OF_RGB

Photo = str | os.PathLike | Image.Image | ArrayLike

COLOURS = "refuse", "grey"
ORIENTATION = 0x0112  # the tag of EXIF that says how the camera was held
DEEP = "I", "F", "I;16", "I;16B", "I;16L"  # grey with more than 8 bits in Pillow


def read(
    photo: Photo, name: str = "photo", *, colour: str = "refuse"
) -> np.ndarray | np.ma.MaskedArray:
    """Read one grey photo from a file, from Pillow or from an array.

    Parameters
    ----------
    photo : str, path, PIL.Image.Image or array_like
        A file that Pillow opens: JPEG, PNG, TIFF and more. An array has (rows,
        columns), with the channels red, green and blue, perhaps alpha, in a third axis;
        it may be masked.
    name : str
        What messages call it.
    colour : {"refuse", "grey"}
        "grey" takes 0.299 R + 0.587 G + 0.114 B (Rec. 601), not rounded. Three channels
        that are all the same are grey already.

    Returns
    -------
    ndarray or MaskedArray (rows, columns)
        Grey values in their own type, 8 or 16 bit or float; of colours in float32. As
        the camera was held: the orientation that EXIF states is followed. Masked where
        a value is NaN or infinite, or transparent by more than half; an array without a
        mask if all pixels have data.

    Raises
    ------
    FileNotFoundError, OSError
        If the file cannot be read.
    ValueError
        If it is empty, damaged or no image, has too many pixels, or colours that
        nobody asked to turn into grey; or an array is not what is described here.

    Examples
    --------
    >>> rgb = np.zeros((20, 30, 3), np.uint8) + np.array([10, 20, 30], np.uint8)
    >>> print(read(rgb, colour="grey")[0, 0])
    18.15
    """
    _validate.text(name, "name")
    colour = _validate.choice(colour, "colour", COLOURS)
    if isinstance(photo, str | os.PathLike):
        name = f"{name}, {printable(photo)}"
        values = pixels(photo, name)
    elif isinstance(photo, Image.Image):
        values = _from_pillow(photo, name)
    else:
        values = _from_array(photo, name)
    return _grey(values, name, colour)


def pixels(path: str | os.PathLike, name: str) -> np.ndarray:
    """Return the pixels of an image file, all channels, as the camera was held."""
    data = _bytes(path, name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large photos, and odd EXIF
            with Image.open(io.BytesIO(data)) as image:
                return _from_pillow(image, name, data)
    except Image.DecompressionBombError:
        raise ValueError(
            f"{name}: the image has too many pixels to be read at once; cut out the"
            " part that both photos show"
        ) from None
    except Image.UnidentifiedImageError:
        raise ValueError(
            f"{name}: this is not an image that can be read; save it as JPEG, PNG or"
            " TIFF"
        ) from None
    except Exception as error:  # the decoders raise whatever they stumble over
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(
            f"{name}: the image is damaged ({reason}); copy or export it again"
        ) from None


def regular(path: str | os.PathLike, name: str) -> Path:
    """Return the path of a file that is there, is no folder, and is not empty."""
    if not isinstance(path, str | os.PathLike) or not str(path).strip():
        raise ValueError(f"{name}: this must be the name of a file; got {path!r:.60}")
    try:
        state = os.stat(path)
    except FileNotFoundError:
        raise FileNotFoundError(f"{name}: there is no such file") from None
    except (OSError, ValueError) as error:  # no permission, a name with a null in it
        raise _unreadable(error, name) from None
    if stat.S_ISDIR(state.st_mode):
        raise IsADirectoryError(f"{name}: this is a folder, not a photo")
    if not stat.S_ISREG(state.st_mode):
        raise OSError(f"{name}: this is a pipe or a device; save the photo as a file")
    if not state.st_size:
        raise ValueError(f"{name}: the file is empty; copy it again")
    return Path(path)


def _bytes(path: str | os.PathLike, name: str) -> bytes:
    """Content of a file that holds something."""
    file = regular(path, name)
    try:
        return file.read_bytes()
    except OSError as error:
        raise _unreadable(error, name) from None


def _unreadable(error: OSError | ValueError, name: str) -> OSError:
    reason = getattr(error, "strerror", None) or error
    return OSError(f"{name}: it cannot be read ({reason})")


def _from_pillow(image: Image.Image, name: str, data: bytes = b"") -> np.ndarray:
    """Pixels of an image of Pillow, which came from `data`, as the camera was held."""
    sixteen = any("16" in str(tile[3]) for tile in getattr(image, "tile", ()))
    image.load()  # whatever is damaged raises here
    values = _values(image)
    if sixteen and image.mode not in DEEP and data:  # colours, cut to 8 bits by Pillow
        values = _deep_colours(data, values)
    return _upright(values, image.getexif().get(ORIENTATION, 1))


def _values(image: Image.Image) -> np.ndarray:
    """Pixels of an image of Pillow: (rows, columns), with channels if it has several.

    Grey with alpha comes as red, green, blue and alpha, as OpenCV reads it too.
    """
    if image.mode in DEEP:
        return np.asarray(image)
    clear = "transparency" in image.info or image.mode in ("LA", "La", "PA", "RGBa")
    if clear or image.mode == "RGBA":
        return np.asarray(image.convert("RGBA"))
    if image.mode in ("1", "L"):
        return np.asarray(image.convert("L"))
    return np.asarray(image.convert("RGB"))


def _deep_colours(data: bytes, values: np.ndarray) -> np.ndarray:
    """Pixels with 16 bits, where OpenCV can read them; else `values`, with 8."""
    try:
        coded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return values
    if coded is None or coded.dtype != np.uint16 or coded.shape != values.shape:
        return values
    return coded[..., [2, 1, 0, 3][: coded.shape[2]]]  # from blue, green, red


def _upright(values: np.ndarray, orientation: int) -> np.ndarray:
    """Pixels as the camera was held, from one of the eight orientations of EXIF."""
    if orientation in (5, 6, 7, 8):
        values = np.swapaxes(values, 0, 1)
    if orientation in (3, 4, 7, 8):
        values = values[::-1]
    if orientation in (2, 3, 6, 7):
        values = values[:, ::-1]
    return np.ascontiguousarray(values)


def _from_array(photo: Any, name: str) -> np.ndarray:
    """An array of real numbers, masked where it was."""
    mask = np.ma.getmask(photo) if isinstance(photo, np.ma.MaskedArray) else False
    values = _validate.numeric(
        np.ma.getdata(photo) if mask is not False else photo, name
    )
    return np.ma.array(values, mask=mask) if np.any(mask) else values


def _grey(values: np.ndarray, name: str, colour: str) -> np.ndarray:
    """One grey value a pixel, masked where there is none."""
    mask: Any = np.ma.getmask(values)
    values = np.ma.getdata(values)
    if (
        values.ndim not in (2, 3)
        or values.ndim == 3
        and values.shape[2] not in (1, 3, 4)
    ):
        raise ValueError(
            f"{name} must be a photo: a file, an image of Pillow, or an array (rows,"
            f" columns) or (rows, columns, 3); got shape {values.shape}"
        )
    if not values.size:
        raise ValueError(f"{name} has no pixels: its shape is {values.shape}")
    values = native(values)
    if values.ndim == 3:
        mask = mask.any(axis=2) if np.ndim(mask) else mask
        if values.shape[2] == 4:
            mask = mask | (values[..., 3] < _opaque(values) / 2)
        values = _one_channel(values, name, colour)
    if values.dtype.kind == "f":
        mask = mask | ~np.isfinite(values)
    if np.all(mask):
        raise ValueError(f"{name} has no data: all pixels are masked, NaN or infinite")
    return np.ma.array(values, mask=mask) if np.any(mask) else values


def native(values: np.ndarray) -> np.ndarray:
    """Return numbers in the order of this machine, in a type that OpenCV takes too."""
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "b":
        return values.astype(np.uint8)
    if kind == "f" and size < 4:
        return values.astype(np.float32)
    if (kind, size) in (("u", 1), ("u", 2), ("i", 2), ("f", 4)):
        return values.astype(values.dtype.newbyteorder("="), copy=False)
    with np.errstate(over="ignore"):  # infinity is masked
        return values.astype(float, copy=False)


def _opaque(values: np.ndarray) -> float:
    """Alpha of a pixel that hides all behind it."""
    return float(np.iinfo(values.dtype).max) if values.dtype.kind in "iu" else 1.0


def _one_channel(values: np.ndarray, name: str, colour: str) -> np.ndarray:
    """Grey values of red, green and blue."""
    first = values[..., 0]
    if all(
        np.array_equal(first, values[..., i]) for i in range(1, min(3, values.shape[2]))
    ):
        return np.ascontiguousarray(first)
    if colour == "refuse":
        raise ValueError(
            f"{name} has colours, and matching compares grey values:"
            ' colour="grey" turns it into 0.299 R + 0.587 G + 0.114 B; or hand over one'
            " channel"
        )
    wide = np.float64 if values.dtype == np.float64 else np.float32
    grey = np.zeros(values.shape[:2], wide)
    for weight, channel in zip(GREY_OF_RGB, np.moveaxis(values, 2, 0)):
        grey += wide(weight) * channel
    return grey
