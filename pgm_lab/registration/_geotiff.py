"""GeoTIFF and what else GDAL reads, through rasterio where that is installed."""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pgm_lab.matching import photo

if TYPE_CHECKING:
    from pgm_lab.registration.raster import Raster

INSTALL = "pip install rasterio"
# libjpeg goes on with grey where a file was cut off; an error is better.
STRICT = {"GDAL_ERROR_ON_LIBJPEG_WARNING": True}
MOST = 10**9  # pixels of an image
NO_MAP = "no georeference: shifts are in pixels only"


def installed() -> bool:
    """Whether rasterio can be imported."""
    try:
        import rasterio  # noqa: F401
    except ImportError:
        return False
    return True


def read(path: Path, name: str, band: int | None) -> dict:
    """Read the fields of a Raster from a file."""
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    try:
        with warnings.catch_warnings(), rasterio.Env(**STRICT):
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with rasterio.open(path) as file:
                number = _band(file, name, band)
                if file.driver == "PNG":  # GDAL takes 0 for what was cut off
                    photo.pixels(path, name)
                if file.width * file.height > MOST:
                    raise ValueError(
                        f"{name}: {file.height} x {file.width} pixels are too many to"
                        " be read at once; cut out the part that both images show"
                    )
                grey = file.read(number)
                mask = file.read_masks(number) == 0
                return _fields(file, number, grey, mask, name)
    except RasterioError as error:
        cause = error.__cause__ or error
        reason = " ".join(str(cause).split())[:200].replace(str(path), "the file")
        raise ValueError(
            f"{name}: this is not an image that can be read, or it is damaged"
            f" ({reason}); copy or export it again"
        ) from None


def _band(file: Any, name: str, band: int | None) -> int:
    """Number of the band to read."""
    from rasterio.enums import ColorInterp

    what = [one.name for one in file.colorinterp]
    bands = [n for n in file.indexes if file.colorinterp[n - 1] != ColorInterp.alpha]
    if not file.count:
        raise ValueError(
            f"{name}: it has no bands of its own, but parts ("
            f"{', '.join(file.subdatasets)[:200]}); save one as GeoTIFF"
        )
    if band is None and len(bands) == 1:
        return bands[0]
    if band is not None and band in file.indexes:
        return band
    described = ", ".join(
        f"{n} ({file.descriptions[n - 1] or what[n - 1]})" for n in bands[:12]
    )
    raise ValueError(choose(name, len(bands), described, band))


def choose(name: str, many: int, described: str, band: int | None) -> str:
    """Return what to say of a file with several bands."""
    wrong = f", and no band {band}" if band is not None else ""
    more = ", ..." if many > 12 else ""
    return (
        f"{name}: it has {many} band{'s' * (many > 1)}, {described}{more}{wrong}; say"
        " which one to read: band=1, for example"
    )


def _fields(
    file: Any, number: int, grey: np.ndarray, mask: np.ndarray, name: str
) -> dict:
    if grey.dtype.kind == "c":
        raise ValueError(f"{name}: its values are complex numbers; take their modulus")
    transform = np.array(file.transform[:6]).reshape(2, 3)
    placed = not np.array_equal(transform, [[1, 0, 0], [0, 1, 0]])
    placed = placed and bool(np.linalg.det(transform[:, :2]))
    crs = file.crs.to_string() if placed and file.crs else None
    size, remark = _size(file.crs, transform) if placed else (None, NO_MAP)
    return {
        "grey": photo.native(grey),
        "mask": mask,
        "transform": transform if placed else None,
        "crs": crs,
        "pixel_size": size,
        "nodata": file.nodatavals[number - 1],
        "remark": remark,
    }


def _size(crs: Any, transform: np.ndarray) -> tuple[np.ndarray | None, str]:
    """Size of a pixel in metres, or why it is not known."""
    if not crs:
        return None, (
            "no coordinate reference system: the unit of the map is not known, and"
            " shifts are in pixels only"
        )
    if crs.is_geographic:
        return None, (
            "its map is in degrees, and a pixel has not the same size in metres"
            " everywhere; project both images first, for example with gdalwarp -t_srs"
            " EPSG:32648 -r cubic in.tif out.tif (the number is that of your UTM zone)"
        )
    try:
        metres = crs.linear_units_factor[1]
    except Exception:  # a local system may state no unit
        return None, (
            "its coordinate reference system states no unit: shifts are in pixels only"
        )
    return metres * np.hypot(*transform[:, :2]), ""


def same_crs(one: str | None, other: str | None) -> bool:
    """Whether two texts name the same coordinate reference system."""
    if one == other:
        return True
    if not (one and other and installed()):
        return False
    from rasterio.crs import CRS

    return CRS.from_user_input(one) == CRS.from_user_input(other)


def write(path: Path, raster: "Raster") -> None:
    """Write a GeoTIFF."""
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError
    from rasterio.transform import Affine

    rows, columns = raster.grey.shape
    profile = {
        "driver": "GTiff",
        "height": rows,
        "width": columns,
        "count": 1,
        "dtype": raster.grey.dtype.name,
        "BIGTIFF": "IF_SAFER",
    }
    if raster.transform is not None:
        profile |= {"transform": Affine(*np.ravel(raster.transform)), "crs": raster.crs}
    grey = raster.grey
    if raster.mask.any():
        profile["nodata"] = free = _free_value(raster)
        grey = np.where(raster.mask, grey.dtype.type(free), grey)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with rasterio.open(path, "w", **profile) as file:
                file.write(grey, 1)
    except RasterioError as error:
        raise OSError(" ".join(str(error.__cause__ or error).split())) from None


def _free_value(raster: "Raster") -> float:
    """A grey value that no pixel with data has, to stand for no data."""
    grey = raster.grey
    if grey.dtype.kind == "f":
        return np.nan
    limits = np.iinfo(grey.dtype)
    values = grey[~raster.mask]
    stated = [] if raster.nodata is None else [raster.nodata]
    for one in (*stated, 0, limits.max, limits.min):
        if limits.min <= one <= limits.max and not np.any(values == one):
            return one
    gaps = np.setdiff1d(np.arange(limits.min, limits.max + 1), values)
    if not len(gaps):
        raise ValueError(
            f"all grey values of {grey.dtype} are in use, and none is left to stand for"
            " no data: write the image in a wider type, grey.astype('float32')"
        )
    return int(gaps[0])
