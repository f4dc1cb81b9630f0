"""Images without georeference, and the choice of how an image is written."""

import os
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from PIL import Image

from pgm_lab import _files
from pgm_lab.matching import photo
from pgm_lab.registration import _geotiff

if TYPE_CHECKING:
    from pgm_lab.registration.raster import Raster

# Tags of TIFF that make it a GeoTIFF: pixel scale, tie points, transformation, keys;
# and GDAL's own for no data.
GEO_TAGS = {33550, 33922, 34264, 34735, 42113}
CHANNELS = {2: "grey, alpha", 3: "red, green, blue", 4: "red, green, blue, alpha"}


def read(path: Path, name: str, band: int | None) -> dict:
    """Read the fields of a Raster from an image that is on no map."""
    if _tags(path) & GEO_TAGS:
        raise ImportError(
            f"{name}: this is a GeoTIFF, and its place on the map and its pixels"
            f" without data can only be read with rasterio: {_geotiff.INSTALL}"
        )
    values = photo.pixels(path, name)
    mask = np.zeros(values.shape[:2], bool)
    if values.ndim == 3:
        many = values.shape[2]
        if many == 4:
            mask = values[..., 3] == 0
        if band is None or band > many:
            described = ", ".join(
                f"{n} ({one})" for n, one in enumerate(CHANNELS[many].split(", "), 1)
            )
            raise ValueError(_geotiff.choose(name, many, described, band))
        values = np.ascontiguousarray(values[..., band - 1])
    elif band not in (None, 1):
        raise ValueError(_geotiff.choose(name, 1, "1 (grey)", band))
    return {"grey": photo.native(values), "mask": mask, "remark": _geotiff.NO_MAP}


def _tags(path: Path) -> set[int]:
    """Numbers of the tags of a TIFF; none of any other file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with Image.open(path) as image:
                return set(getattr(image, "tag_v2", ()))
    except Exception:  # whatever is wrong, reading the pixels says it
        return set()


def without_data(values: np.ndarray) -> np.ndarray:
    """Return where grey values are masked, NaN or infinite (rows, columns)."""
    mask, grey = np.ma.getmaskarray(values), np.ma.getdata(values)
    return mask | ~np.isfinite(grey) if grey.dtype.kind == "f" else mask


def write(path: str | os.PathLike, raster: "Raster", overwrite: bool) -> Path:
    """Write a Raster in the format that the name of the file says."""
    raster = replace(raster, grey=photo.native(raster.grey))
    file = _files.place(path)
    name, kind = _files.printable(file), file.suffix.lower()
    if kind not in (".tif", ".tiff", ".png"):
        raise ValueError(f"{name}: the name must end in .tif or .png")
    on_map = raster.transform is not None or raster.crs is not None
    special = on_map or bool(raster.mask.any())
    what = "a georeference" if on_map else "pixels without data"
    if kind == ".png" and special:
        raise ValueError(f"{name}: PNG cannot hold {what}; let the name end in .tif")
    if kind == ".png" and raster.grey.dtype not in (np.uint8, np.uint16):
        raise ValueError(
            f"{name}: PNG cannot hold {raster.grey.dtype}; let the name end in .tif"
        )
    if special and not _geotiff.installed():
        raise ImportError(
            f"{name}: to write {what}, rasterio is needed: {_geotiff.INSTALL}"
        )
    try:
        with _files.written_whole(file, overwrite=overwrite) as part:
            if kind != ".png" and _geotiff.installed():
                _geotiff.write(part, raster)
            else:
                _, coded = cv2.imencode(kind, raster.grey)
                part.write_bytes(coded.tobytes())
    except FileExistsError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise OSError(f"{name}: it cannot be written ({reason})") from None
    return file
