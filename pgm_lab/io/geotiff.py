"""Images with their place on the map: GeoTIFF where rasterio is installed.

Without rasterio, images without a georeference can still be read and written.
"""

import glob
import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.io import files, photo

INSTALL = "pip install rasterio"
MAX_PIXELS = 10**9  # of an image
MAX_RATIO = 1000  # pixels a byte of a file, above 65 million: the rest is empty
NO_MAP = "no georeference: shifts are in pixels only"
CONVERT = (
    "convert what is neither GeoTIFF, JPEG 2000, PNG nor JPEG, for example with"
    " gdal_translate -of GTiff"
)

# By the first bytes of a file: a virtual raster named .tif must not lead elsewhere.
_DRIVERS = {
    b"II*\0": "GTiff",
    b"MM\0*": "GTiff",
    b"II+\0": "GTiff",
    b"MM\0+": "GTiff",
    b"\x89PNG": "PNG",
    b"\xff\xd8\xff": "JPEG",
    b"\0\0\0\x0cjP": "JP2OpenJPEG",
    b"\xff\x4f\xff\x51": "JP2OpenJPEG",
}
TIFF = tuple(magic for magic, driver in _DRIVERS.items() if driver == "GTiff")
# libjpeg goes on with grey where a file was cut off; an error is better. Files beside
# the image are looked for by name, not in a list of its folder.
_STRICT = {
    "GDAL_ERROR_ON_LIBJPEG_WARNING": True,
    "GDAL_DISABLE_READDIR_ON_OPEN": "TRUE",
    "GDAL_CACHEMAX": 64,  # MB: each block is read once
}
_ALONE = {"GDAL_DISABLE_READDIR_ON_OPEN": "EMPTY_DIR"}  # no file beside the image
# Tags of TIFF that make it a GeoTIFF: pixel scale, tie points, transformation, keys;
# and GDAL's own for no data.
_GEO_TAGS = {33550, 33922, 34264, 34735, photo.NODATA}
_CHANNELS = "red", "green", "blue", "alpha"


@dataclass(frozen=True, eq=False)
class Raster:
    """An image on the map.

    Attributes
    ----------
    grey : ndarray (rows, columns)
        Grey values of one band, in the type of the file.
    mask : ndarray (rows, columns) of bool
        Where there is no data.
    transform : ndarray (2, 3) or None
        As GeoTIFF counts, from the outer corner of the first pixel: takes (column +
        0.5, row + 0.5, 1) of a pixel's centre to (x, y) on the map. None without a
        georeference.
    crs : str or None
        Coordinate reference system: "EPSG:32648", or its text where it has no number.
    pixel_size : ndarray (2,) or None
        (across, down) on the ground in metres; None where it is not known, or not the
        same everywhere.
    nodata : float or None
        Grey value that the file states for no data.
    path : str or None
        File it was read from.
    remark : str
        What is not known of its place on the map.
    beside : str
        Files beside the image that place it on the map, or move it there: a world file
        (.tfw, .pgw), .tab or .aux.xml.
    """

    grey: np.ndarray = field(repr=False)
    mask: np.ndarray = field(repr=False)
    transform: np.ndarray | None = None
    crs: str | None = None
    pixel_size: np.ndarray | None = None
    nodata: float | None = None
    path: str | None = None
    remark: str = ""
    beside: str = ""

    def __post_init__(self) -> None:
        """Refuse parts that do not fit together."""
        grey = _validate.grey_image(self.grey, "grey")
        if np.shape(self.mask) != grey.shape or np.asarray(self.mask).dtype != bool:
            raise ValueError(
                f"mask must be True or False for each pixel, {grey.shape}; got shape"
                f" {np.shape(self.mask)}"
            )
        if self.transform is not None:
            _validate.of_shape(self.transform, (2, 3), "transform")

    @property
    def values(self) -> np.ndarray | np.ma.MaskedArray:
        """Grey values, masked where there is no data, as `register` takes them."""
        return np.ma.array(self.grey, mask=self.mask) if self.mask.any() else self.grey

    def map(self, pixels: ArrayLike) -> np.ndarray:
        """Map coordinates (..., 2), (x, y), of pixels (column, row)."""
        A, corner = self.affine()
        return (_validate.points(pixels, 2, "pixels") + 0.5) @ A.T + corner

    def pixels(self, map_points: ArrayLike) -> np.ndarray:
        """Pixels (..., 2), (column, row), of map points (x, y)."""
        A, corner = self.affine()
        points = _validate.points(map_points, 2, "map_points")
        return (points - corner) @ np.linalg.inv(A).T - 0.5

    def with_values(self, values: ArrayLike) -> Self:
        """Other values (rows, columns) in the same place; no data if masked or NaN."""
        values = _validate.grey_image(values, "values")
        if values.shape != self.grey.shape:
            raise ValueError(
                f"values must have this image's shape {self.grey.shape}; got"
                f" {values.shape}"
            )
        mask = without_data(values)
        return replace(self, grey=np.ma.getdata(values), mask=mask, path=None)

    def affine(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the 2 x 2 matrix from pixels to the map, and the first corner (2,)."""
        if self.transform is None:
            raise ValueError(
                f"{self.path or 'this image'} has no georeference, so that its pixels"
                " have no place on the map"
            )
        return self.transform[:, :2], self.transform[:, 2]


def read(
    path: str | os.PathLike, band: int | None = None, *, nodata: float | None = None
) -> Raster:
    """Read one band of an ortho image.

    Parameters
    ----------
    path : str or path
        GeoTIFF or JPEG 2000, if rasterio is installed (``pip install rasterio``); or an
        image without georeference, such as PNG or JPEG. The content decides. Without a
        place on the map it is turned upright as EXIF states, as photos are; with one it
        stays as it is stored, since the place counts stored pixels.
    band : int, optional
        Number of the band, from 1; not needed if there is one only.
    nodata : float, optional
        Grey value of no data, in place of the one that the file states; a mask that it
        has stays.

    Returns
    -------
    Raster

    Raises
    ------
    OSError
        If the file is missing or cannot be read.
    ImportError
        If it is a GeoTIFF and rasterio is not installed.
    ValueError
        If it is no image, is damaged, has no data, several pages, numbers of a palette
        for colours, or several bands and none is chosen.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from pgm_lab.datasets import landsat
    >>> image = landsat().grey[:200, :300]
    >>> with TemporaryDirectory() as folder:
    ...     name = Path(folder, "red.png")
    ...     file = write(name, Raster(image, np.zeros(image.shape, bool)))
    ...     found = read(file)
    >>> found.grey.dtype, found.remark
    (dtype('uint16'), 'no georeference: shifts are in pixels only')
    """
    name = f"image, {files.printable(path)}"
    file = files.existing(path, name)
    if band is not None:
        band = _validate.whole(band, "band", 1)
    if nodata is not None:
        nodata = _validate.number(nodata, "nodata")
    head = files.content(file, name, 8)
    driver = next((d for magic, d in _DRIVERS.items() if head.startswith(magic)), None)
    if driver and installed():
        found = _read_gdal(file, driver, name, band)
    else:
        found = _read_plain(file, name, band)
    grey, mask = found["grey"], found["mask"]
    if nodata is not None:
        # In place of the value that the file states, beside its mask or alpha
        declared = mask & (grey != found.get("nodata"))
        mask, found["nodata"] = declared | (grey == nodata), nodata
    if grey.dtype.kind == "f":
        mask = mask | ~np.isfinite(grey)
    if mask.all():
        raise ValueError(f"{name}: there is no data in it, all pixels are marked so")
    return Raster(**(found | {"mask": mask, "path": str(file)}))


def write(path: str | os.PathLike, raster: Raster, *, overwrite: bool = False) -> Path:
    """Write an image with its place on the map.

    Parameters
    ----------
    path : str or path
        Name of the file: .tif, or .png for 8 or 16 bits without georeference and
        without pixels that have no data.
    raster : Raster
        What to write.
    overwrite : bool
        Whether a file of this name may be replaced.

    Returns
    -------
    Path
        The file, written atomically.

    Raises
    ------
    FileExistsError
        If the file is there already.
    ImportError
        If it needs rasterio, which is not installed.
    OSError
        If it cannot be written.
    ValueError
        If the file cannot hold the image: its message says which can.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> image = np.arange(12, dtype=np.uint8).reshape(3, 4)
    >>> with TemporaryDirectory() as folder:
    ...     file = write(Path(folder, "a.tif"), Raster(image, image > 99))
    ...     bool(np.all(read(file).grey == image))
    True
    """
    _validate.instance(raster, Raster, "raster")
    raster = replace(raster, grey=photo.native(raster.grey))
    name, kind = files.printable(path), Path(path).suffix.lower()
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
    if special and not installed():
        raise ImportError(f"{name}: to write {what}, rasterio is needed: {INSTALL}")
    try:
        with files.atomic(path, overwrite=overwrite) as part:
            if kind == ".png" or not installed():
                _, coded = cv2.imencode(kind, raster.grey)
                part.write_bytes(coded.tobytes())
            else:
                grey, nodata = raster.grey, None
                if raster.mask.any():
                    nodata = _free_value(raster)
                    grey = np.where(raster.mask, grey.dtype.type(nodata), grey)
                write_bands(
                    part, grey[None], raster.transform, raster.crs, nodata=nodata
                )
    except FileExistsError:
        raise
    except OSError as error:
        reason = error.strerror or error
        raise OSError(f"{name}: it cannot be written ({reason})") from None
    return files.place(path)


def installed() -> bool:
    """Whether rasterio can be imported."""
    try:
        import rasterio  # noqa: F401
    except ImportError:
        return False
    return True


def wkt(crs: str) -> str:
    """Well-known text of a coordinate reference system, of the kind that LAS holds."""
    if not installed():
        raise ImportError(f"a coordinate reference system needs rasterio: {INSTALL}")
    return system(crs).to_wkt()


def system(crs: str) -> Any:
    """Coordinate reference system of a text; refused if it is not known."""
    from rasterio.crs import CRS
    from rasterio.errors import CRSError

    try:
        return CRS.from_user_input(crs)
    except CRSError:
        raise ValueError(
            f"crs {crs!r:.60} is not known; give it as 'EPSG:32748', for example"
        ) from None


def place(path: str | os.PathLike) -> tuple[str, np.ndarray, tuple[int, int]] | None:
    """System, transform (2, 3) and shape of a GeoTIFF; None where it names no system.

    Only the header is read, and no file beside it.
    """
    with Path(path).open("rb") as file:
        tiff = file.read(4) in TIFF
    if not (tiff and installed()):
        return None
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    try:
        with warnings.catch_warnings(), rasterio.Env(**_ALONE):
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            name = Path(path).absolute()
            with rasterio.open(name, driver="GTiff", sharing=False) as found:
                transform = np.array(found.transform[:6]).reshape(2, 3)
                if not found.crs or not np.linalg.det(transform[:, :2]):
                    return None
                return found.crs.to_string(), transform, found.shape
    except RasterioError:
        return None


def without_data(values: np.ndarray) -> np.ndarray:
    """Return where grey values are masked, NaN or infinite (rows, columns)."""
    mask, grey = np.ma.getmaskarray(values), np.ma.getdata(values)
    return mask | ~np.isfinite(grey) if grey.dtype.kind == "f" else mask


def same_crs(one: str | None, other: str | None) -> bool:
    """Whether two texts name the same coordinate reference system."""
    if one == other:
        return True
    if not (one and other and installed()):
        return False
    return system(one) == system(other)


def write_bands(
    path: Path,
    bands: np.ndarray,
    transform: ArrayLike | None = None,
    crs: str | None = None,
    *,
    nodata: float | None = None,
    names: Sequence[str] = (),
    tags: Mapping[int, Mapping[str, str]] | None = None,
    **options: str,
) -> None:
    """Write a GeoTIFF in place; for an atomic one, give it a temporary name.

    `bands` are (bands, rows, columns), `transform` (2, 3) is that of a `Raster`, from
    the outer corner of the first pixel, `names` are descriptions of the bands, `tags`
    further words on a band by its number from 1, `options` creation options of GDAL.
    Raises an OSError if it cannot be written, a ValueError if `crs` is not known.
    """
    if not installed():
        raise ImportError(f"a GeoTIFF is written by rasterio: {INSTALL}")
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    count, rows, columns = bands.shape
    profile = {"driver": "GTiff", "height": rows, "width": columns, "count": count}
    profile |= {"dtype": bands.dtype.name, "nodata": nodata, "BIGTIFF": "IF_SAFER"}
    if transform is not None:
        affine = rasterio.Affine(*np.ravel(transform))
        profile |= {"transform": affine, "crs": None if crs is None else system(crs)}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with rasterio.open(path, "w", **profile, **options) as file:
                file.write(bands)
                for number, name in enumerate(names, 1):
                    file.set_band_description(number, name)
                for number, words in (tags or {}).items():
                    file.update_tags(number, **words)
    except RasterioError as error:
        raise OSError(" ".join(str(error.__cause__ or error).split())) from None


# --- Reading by rasterio ---


def _read_gdal(path: Path, driver: str, name: str, band: int | None) -> dict[str, Any]:
    """Read the fields of a Raster with one driver of GDAL."""
    import rasterio
    from rasterio._err import CPLE_BaseError
    from rasterio.enums import MaskFlags
    from rasterio.errors import NotGeoreferencedWarning, RasterioError

    place = path.absolute()  # or a name may be GDAL's syntax for another file
    _refuse_odd(place)
    try:
        with warnings.catch_warnings(), rasterio.Env(**_STRICT):
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with rasterio.open(place, driver=driver, sharing=False) as file:
                number = _band(file, name, band)
                if file.subdatasets:
                    raise ValueError(photo.several_pages(name))
                if driver == "PNG":  # GDAL takes 0 for what was cut off
                    photo.pixels(path, name)
                if file.width * file.height > MAX_PIXELS:
                    raise ValueError(
                        f"{name}: {file.height} x {file.width} pixels are too many to"
                        " be read at once; cut out the part that both images show"
                    )
                if file.width * file.height > MAX_RATIO * max(
                    path.stat().st_size, 2**16
                ):
                    raise ValueError(
                        f"{name}: it says that it has {file.height} x {file.width}"
                        " pixels, but is far too short for them: it is damaged, or"
                        " nearly all of it is empty"
                    )
                grey = file.read(number)
                mask = np.broadcast_to(np.False_, grey.shape)
                flags = file.mask_flag_enums[number - 1]
                if flags == [MaskFlags.nodata] and grey.dtype.kind in "iu":
                    mask = grey == file.nodatavals[number - 1]  # GDAL would read again
                elif MaskFlags.all_valid not in flags:
                    mask = file.read_masks(number) == 0
                found = _fields(file, number, grey, mask, name)
                with (
                    rasterio.Env(**_ALONE),
                    rasterio.open(place, driver=driver, sharing=False) as alone,
                ):
                    if (alone.transform, alone.crs) != (file.transform, file.crs):
                        found["beside"] = _beside(file)
    except (RasterioError, CPLE_BaseError, UnicodeDecodeError) as error:
        cause = error.__cause__ or error
        reason = " ".join(str(cause).split())[:200].replace(str(place), "the file")
        raise ValueError(
            f"{name}: this is not an image that can be read, or it is damaged"
            f" ({reason}); copy or export it again"
        ) from None
    if found["transform"] is None and (turned := photo.orientation(path)) > 1:
        found |= {key: photo.upright(found[key], turned) for key in ("grey", "mask")}
    return found


def _refuse_odd(path: Path) -> None:
    """Refuse what GDAL would wait for beside the image, or follow elsewhere."""
    mask = f"{path.name}.msk".lower()  # opened by any driver, that of VRT among them
    for beside in path.parent.glob(f"{glob.escape(path.stem)}*"):
        name = f"beside the image, {files.printable(beside)}"
        if beside.exists() and not beside.is_dir():
            files.existing(beside, name, empty=True)  # no pipe
        if beside.name.lower() != mask:
            continue
        if not files.content(beside, name, 4).startswith(TIFF):
            raise ValueError(
                f"{name}: it marks pixels without data, and is no TIFF; remove it, or"
                " convert it with gdal_translate -of GTiff"
            )


def _beside(file: Any) -> str:
    """Names of the files beside an image that may place it on the map."""
    names = [Path(one).name for one in file.files[1:]]
    kept = (one for one in names if not one.lower().endswith((".msk", ".ovr")))
    return files.printable(", ".join(sorted(kept)))


def _band(file: Any, name: str, band: int | None) -> int:
    """Number of the band to read."""
    from rasterio.enums import ColorInterp

    what, descriptions = file.colorinterp, file.descriptions  # each asks all bands
    bands = [n for n, one in enumerate(what, 1) if one != ColorInterp.alpha]
    if band is None and len(bands) == 1:
        return bands[0]
    if band is not None and band in file.indexes:
        return band
    named = [f"{n} ({descriptions[n - 1] or what[n - 1].name})" for n in bands]
    raise _choose(name, named, band)


def _choose(name: str, bands: Sequence[str], band: int | None) -> ValueError:
    """Error for a file with several bands, or without the chosen one."""
    many = len(bands)
    more = ", ..." if many > 12 else ""
    wrong = f", and no band {band}" if band is not None else ""
    return ValueError(
        f"{name}: it has {many} band{'s' * (many > 1)}, {', '.join(bands[:12])}{more}"
        f"{wrong}; say which one to read: band=1, for example"
    )


def _fields(
    file: Any, number: int, grey: np.ndarray, mask: np.ndarray, name: str
) -> dict[str, Any]:
    """Fields of a Raster from an open file and what was read of it."""
    if grey.dtype.kind == "c":
        raise ValueError(f"{name}: its values are complex numbers; take their modulus")
    if file.colorinterp[number - 1].name == "palette" and any(
        colour[:3] != (k, k, k) for k, colour in file.colormap(number).items()
    ):
        raise ValueError(
            f"{name}: its values are numbers of colours in a palette, not grey values;"
            " convert it with gdal_translate -expand rgb, or -expand gray"
        )
    transform = np.array(file.transform[:6]).reshape(2, 3)
    placed = not np.array_equal(transform, [[1, 0, 0], [0, 1, 0]])
    placed = placed and bool(np.linalg.det(transform[:, :2]))
    size, remark = _size(file.crs, transform) if placed else (None, NO_MAP)
    return {
        "grey": photo.native(grey),
        "mask": mask,
        "transform": transform if placed else None,
        "crs": file.crs.to_string() if placed and file.crs else None,
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


# --- Reading without rasterio ---


def _read_plain(path: Path, name: str, band: int | None) -> dict[str, Any]:
    """Read the fields of a Raster from an image without a georeference."""
    if _tags(path) & _GEO_TAGS:
        raise ImportError(
            f"{name}: this is a GeoTIFF, and its place on the map and its pixels"
            f" without data can only be read with rasterio: {INSTALL}"
        )
    values = photo.pixels(path, name, CONVERT)
    mask = np.zeros(values.shape[:2], bool)
    if values.ndim == 3:
        channels = _CHANNELS[: values.shape[2]]
        if "alpha" in channels:
            mask = values[..., -1] == 0
        if band is None or band > len(channels):
            named = [f"{n} ({channel})" for n, channel in enumerate(channels, 1)]
            raise _choose(name, named, band)
        values = np.ascontiguousarray(values[..., band - 1])
    elif band not in (None, 1):
        raise _choose(name, ["1 (grey)"], band)
    return {"grey": photo.native(values), "mask": mask, "remark": NO_MAP}


def _tags(path: Path) -> set[int]:
    """Numbers of the tags of a TIFF; none of any other file."""
    try:
        with photo.opened(path, "") as image:
            return set(getattr(image, "tag_v2", ()))
    except (ValueError, OSError):  # reading the pixels says what is wrong
        return set()


# --- Writing ---


def _free_value(raster: Raster) -> float:
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
