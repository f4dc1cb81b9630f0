"""A photo of a user as grey values: from a file, a Pillow image or an array."""

import contextlib
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike
from PIL import Image
from PIL.TiffImagePlugin import ImageFileDirectory_v2

from pgm_lab import _validate
from pgm_lab.io import files

Photo = str | os.PathLike | Image.Image | ArrayLike

COLOURS = "refuse", "grey"
# Rec. 601: how bright red, green and blue look; OpenCV and Pillow weight the same way.
GREY_OF_RGB = (0.299, 0.587, 0.114)
ORIENTATION = 0x0112  # the tag of EXIF that says how the camera was held
DEEP = "I", "F", "I;16", "I;16B", "I;16L"  # grey with more than 8 bits in Pillow
# Pillow opens many more, an EPS among them by having Ghostscript run the code in it.
FORMATS = "JPEG", "PNG", "TIFF", "JPEG2000", "BMP", "GIF", "WEBP", "PPM"
HEIC = b"heic", b"heix", b"hevc", b"hevx", b"heim", b"mif1", b"msf1"
CONVERT = "save it as JPEG, PNG or TIFF"
RGB_TIFF = (
    ". Pillow takes no TIFF whose bands are not marked as red, green and blue, or lie"
    " apart: mark them with gdal_translate -b 1 -b 2 -b 3 -co PHOTOMETRIC=RGB -co"
    " INTERLEAVE=PIXEL in.tif out.tif"
)
ALPHA = 0.9  # share of its values that are 0 or opaque; else a fourth band is infrared
NODATA = 42113  # the tag of GDAL
SUBFILE, SMALLER_OR_MASK = 0x00FE, 1 | 4  # the tag of TIFF that says what a page is


def read(
    photo: Photo, name: str = "photo", *, colour: str = "refuse"
) -> np.ndarray | np.ma.MaskedArray:
    """Read one grey photo from a file, a Pillow image or an array.

    Parameters
    ----------
    photo : str, path, PIL.Image.Image or array_like
        A file: JPEG, PNG, TIFF, JPEG 2000, WebP, BMP, PNM or GIF, by its content and
        not by its name; or an array (rows, columns), perhaps masked, with red, green,
        blue and perhaps alpha in a third axis.
    name : str
        What messages call it.
    colour : {"refuse", "grey"}
        "grey" takes 0.299 R + 0.587 G + 0.114 B (Rec. 601), not rounded. Three channels
        that are all the same are grey already.

    Returns
    -------
    ndarray or MaskedArray (rows, columns)
        Grey values in their own type, 8 or 16 bit or float; of colours in float32.
        Upright as EXIF states. Masked where a value is NaN, infinite, more than half
        transparent, or what a GeoTIFF states for no data, in all its channels; an array
        without a mask if all pixels have data. Infrared as fourth channel is left out.

    Raises
    ------
    FileNotFoundError, OSError
        If the file cannot be read.
    ValueError
        If it is empty, damaged or no image, has too many pixels or several pages, or
        colours without `colour`.

    Examples
    --------
    >>> rgb = np.zeros((20, 30, 3), np.uint8) + np.array([10, 20, 30], np.uint8)
    >>> print(read(rgb, colour="grey")[0, 0])
    18.15
    """
    _validate.text(name, "name")
    colour = _validate.choice(colour, "colour", COLOURS)
    mask: Any = np.ma.nomask
    if isinstance(photo, str | os.PathLike):
        name = f"{name}, {files.printable(photo)}"
        values, nodata = _of_file(photo, name)
        mask = _stated(nodata, values)
    elif isinstance(photo, Image.Image):
        values = _from_pillow(photo)
    else:
        mask = np.ma.getmask(photo)
        values = _validate.numeric(
            np.ma.getdata(photo) if np.any(mask) else photo, name
        )
    return _grey(values, mask, name, colour)


def pixels(path: str | os.PathLike, name: str, convert: str = CONVERT) -> np.ndarray:
    """Return the pixels of an image file, all channels, as the camera was held."""
    return _of_file(path, name, convert)[0]


def _of_file(
    path: str | os.PathLike, name: str, convert: str = CONVERT
) -> tuple[np.ndarray, str]:
    """The same pixels, and what a GeoTIFF states for no data, "" if nothing."""
    file = files.existing(path, name)
    with opened(file, name, convert) as image:
        nodata = str(getattr(image, "tag_v2", {}).get(NODATA, "")).strip(" \0")
        values = None if _several(image, file) else _from_pillow(image, file)
    if values is None:
        raise ValueError(several_pages(name))
    return values, nodata


def _stated(nodata: str, values: np.ndarray) -> Any:
    """Where pixels have, in all channels, what was stated for no data."""
    try:
        none = values == float(nodata)
    except ValueError:  # it states nothing
        return np.ma.nomask
    if values.ndim == 3:
        none[:] = none[..., :3].all(axis=2, keepdims=True)
    return none


def several_pages(name: str) -> str:
    """Say that a file has several pages or frames."""
    return (
        f"{name}: this file holds several pictures, pages or frames, and does not say"
        " which one is meant; save that one as a file of its own"
    )


@contextlib.contextmanager
def opened(
    path: str | os.PathLike, name: str, convert: str = CONVERT
) -> Iterator[Image.Image]:
    """Open an image file, its pixels unread; what goes wrong with it names it."""
    file = files.existing(path, name)
    head = files.content(file, name, 12)  # or the system says why not
    formats = (*FORMATS, *_of_phone(head, name, convert))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large photos, and odd EXIF
            # By its name, Pillow would map a TIFF into memory, and turn it twice
            with file.open("rb") as stream, Image.open(stream, "r", formats) as image:
                yield image
    except Image.DecompressionBombError:
        raise ValueError(
            f"{name}: the image has too many pixels to be read at once; cut out the"
            " part that both photos show"
        ) from None
    except Image.UnidentifiedImageError:
        if head.startswith((b"II", b"MM")):
            convert += RGB_TIFF  # a raw photo begins like a TIFF
        raise ValueError(
            f"{name}: this is not an image that can be read; {convert}"
        ) from None
    except Exception as error:  # the decoders raise whatever they stumble over
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(
            f"{name}: the image is damaged ({reason}); copy or export it again"
        ) from None


def _of_phone(head: bytes, name: str, convert: str) -> tuple[str, ...]:
    """Have Pillow read HEIC if that is what a file begins with, else nothing."""
    if head[4:8] != b"ftyp" or head[8:12] not in HEIC:
        return ()
    try:
        import pillow_heif
    except ImportError:
        raise ValueError(
            f"{name}: this is a HEIC photo, as phones take them; with pillow-heif"
            f" (pip install pillow-heif) it can be read; or {convert} (iPhone: under"
            " Settings, Camera, Formats, Most Compatible)"
        ) from None
    pillow_heif.register_heif_opener()
    return ("HEIF",)


def shape(path: str | os.PathLike, name: str) -> tuple[int, int]:
    """Return (rows, columns) as the camera was held, from the head of the file."""
    with opened(path, name) as image:
        columns, rows = image.size
        if tags := getattr(
            image, "tag_v2", None
        ):  # a TIFF states its upright size already
            columns, rows = tags[256], tags[257]
        sideways = image.getexif().get(ORIENTATION) in (5, 6, 7, 8)
        return (columns, rows) if sideways else (rows, columns)


def orientation(path: str | os.PathLike) -> int:
    """How the camera was held, as EXIF counts; 1, upright, where it does not say."""
    try:
        with opened(path, "") as image:
            held = image.getexif().get(ORIENTATION)
            held = image.info.get("original_orientation") or held  # of HEIC
    except (ValueError, OSError):  # reading the pixels says it
        return 1
    return held if isinstance(held, int) else 1  # it may be a text


def native(values: np.ndarray) -> np.ndarray:
    """Return numbers in the byte order of this machine, in a type that OpenCV takes."""
    kind, size = values.dtype.kind, values.dtype.itemsize
    if kind == "b":
        return values.astype(np.uint8)
    if kind == "f" and size < 4:
        return values.astype(np.float32)
    if (kind, size) in (("u", 1), ("u", 2), ("i", 2), ("f", 4)):
        return values.astype(values.dtype.newbyteorder("="), copy=False)
    with np.errstate(over="ignore"):  # infinity is masked
        return values.astype(float, copy=False)


# --- Pixels from Pillow ---


def _several(image: Image.Image, path: Path) -> bool:
    """Whether there are several pictures; thumbnails, pyramids and masks are none."""
    if image.format == "MPO":  # of a phone: the first is the photo
        return False
    if image.format != "TIFF":
        return getattr(image, "is_animated", False)
    pictures, seen = 0, set()
    with path.open("rb") as file:
        head = file.read(8)
        page = ImageFileDirectory_v2(head + file.read(8 * (43 in head[2:4])))
        while page.next and page.next not in seen:
            seen.add(page.next)
            file.seek(page.next)
            page.load(file)
            pictures += not page.get(SUBFILE, 0) & SMALLER_OR_MASK
    return pictures > 1


def _from_pillow(image: Image.Image, path: Path | None = None) -> np.ndarray:
    """Pixels of a Pillow image, which came from a file, as the camera was held."""
    sixteen = any("16" in str(tile[3]) for tile in getattr(image, "tile", ()))
    image.load()  # whatever is damaged raises here
    values = _channels(image)
    if sixteen and image.mode not in DEEP and path:  # colours, cut to 8 bits by Pillow
        values = _deep_colours(path, values)
    return upright(values, image.getexif().get(ORIENTATION, 1))


def _channels(image: Image.Image) -> np.ndarray:
    """Pixels (rows, columns), or with 3 or 4 channels; grey with alpha has 4, too."""
    if image.mode in DEEP:
        return np.asarray(image)
    clear = "transparency" in image.info or image.mode in ("LA", "La", "PA", "RGBa")
    if clear or image.mode == "RGBA":
        return np.asarray(image.convert("RGBA"))
    return np.asarray(image.convert("L" if image.mode in ("1", "L") else "RGB"))


def _deep_colours(path: Path, values: np.ndarray) -> np.ndarray:
    """Pixels with 16 bits, where OpenCV can read them; else `values`, with 8."""
    data = files.content(path, str(path), 4 * values.size + 2**20)  # not what follows
    try:
        coded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return values
    if coded is None or coded.dtype != np.uint16 or coded.shape != values.shape:
        return values
    return coded[..., [2, 1, 0, 3][: coded.shape[2]]]  # from blue, green, red


def upright(values: np.ndarray, orientation: int) -> np.ndarray:
    """Pixels as the camera was held, from one of the eight orientations of EXIF."""
    if orientation in (5, 6, 7, 8):
        values = np.swapaxes(values, 0, 1)
    if orientation in (3, 4, 7, 8):
        values = values[::-1]
    if orientation in (2, 3, 6, 7):
        values = values[:, ::-1]
    return np.ascontiguousarray(values)


# --- From channels to grey values ---


def _grey(values: np.ndarray, mask: Any, name: str, colour: str) -> np.ndarray:
    """One grey value a pixel, masked where there is none."""
    deep = values.ndim == 3
    if values.ndim not in (2, 3) or deep and values.shape[2] not in (1, 3, 4):
        raise ValueError(
            f"{name} must be a photo: a file, a Pillow image, or an array (rows,"
            f" columns) or (rows, columns, 3); got shape {values.shape}"
        )
    if not values.size:
        raise ValueError(f"{name} has no pixels: its shape is {values.shape}")
    values = native(values)
    if deep:
        mask = mask.any(axis=2) if np.ndim(mask) else mask
        if values.shape[2] == 4:
            whole = values.dtype.kind in "iu"
            opaque = float(np.iinfo(values.dtype).max) if whole else 1.0
            alpha = values[..., 3]
            if np.mean((alpha == 0) | (alpha == opaque)) >= ALPHA:
                mask = mask | (alpha < opaque / 2)
        values = _one_channel(values, name, colour)
    if values.dtype.kind == "f":
        mask = mask | ~np.isfinite(values)
    if np.all(mask):
        raise ValueError(f"{name} has no data: all pixels are masked, NaN or infinite")
    return np.ma.array(values, mask=mask) if np.any(mask) else values


def _one_channel(values: np.ndarray, name: str, colour: str) -> np.ndarray:
    """Grey values of red, green and blue."""
    first, *others = np.moveaxis(values[..., :3], 2, 0)
    if all(np.array_equal(first, other) for other in others):
        return np.ascontiguousarray(first)
    if colour == "refuse":
        raise ValueError(
            f"{name} has colours, and matching compares grey values:"
            ' colour="grey" turns it into 0.299 R + 0.587 G + 0.114 B; or hand over one'
            " channel"
        )
    wide = np.float64 if values.dtype == np.float64 else np.float32
    grey = np.zeros(values.shape[:2], wide)
    for weight, channel in zip(GREY_OF_RGB, (first, *others)):
        grey += wide(weight) * channel
    return grey
