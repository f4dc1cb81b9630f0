"""Ortho images with their place on the map: GeoTIFF where rasterio is installed."""

import os
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._files import printable
from pgm_lab.matching import photo
from pgm_lab.registration import _geotiff, _plain


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
        What is not known of its place on the map, and what to do.
    """

    grey: np.ndarray = field(repr=False)
    mask: np.ndarray = field(repr=False)
    transform: np.ndarray | None = None
    crs: str | None = None
    pixel_size: np.ndarray | None = None
    nodata: float | None = None
    path: str | None = None
    remark: str = ""

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
        """Return map coordinates.

        Parameters
        ----------
        pixels : array_like (..., 2)
            (column, row), whole numbers at pixel centres.

        Returns
        -------
        ndarray (..., 2)
            (x, y) in the unit of the coordinate reference system.

        Raises
        ------
        ValueError
            If there is no georeference, or pixels are not (..., 2) or not finite.
        """
        A, corner = self.affine()
        return (_validate.points(pixels, 2, "pixels") + 0.5) @ A.T + corner

    def pixels(self, map_points: ArrayLike) -> np.ndarray:
        """Return pixel coordinates.

        Parameters
        ----------
        map_points : array_like (..., 2)
            (x, y) in the unit of the coordinate reference system.

        Returns
        -------
        ndarray (..., 2)
            (column, row), whole numbers at pixel centres; not rounded.

        Raises
        ------
        ValueError
            If there is no georeference, or map_points are not (..., 2) or not finite.
        """
        A, corner = self.affine()
        points = _validate.points(map_points, 2, "map_points")
        return (points - corner) @ np.linalg.inv(A).T - 0.5

    def with_values(self, values: ArrayLike) -> Self:
        """Return other pixels in the same place.

        Parameters
        ----------
        values : array_like (rows, columns)
            Grey values in this image's grid; masked or NaN where there are none.

        Returns
        -------
        Raster

        Raises
        ------
        ValueError
            If they have another shape.
        """
        values = _validate.grey_image(values, "values")
        if values.shape != self.grey.shape:
            raise ValueError(
                f"values must have this image's shape {self.grey.shape}; got"
                f" {values.shape}"
            )
        mask = _plain.without_data(values)
        return replace(self, grey=np.ma.getdata(values), mask=mask, path=None)

    def affine(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the 2 x 2 matrix from pixels to the map, and the first corner (2,).

        Raises
        ------
        ValueError
            If there is no georeference.
        """
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
        GeoTIFF and whatever else GDAL reads, if rasterio is installed
        (the extra geo, or
        ``pip install rasterio``); else an image without georeference, such as PNG.
    band : int, optional
        Number of the band, from 1; not needed if there is one only.
    nodata : float, optional
        Grey value of no data; else as the file states it.

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
        If it is no image, is damaged, has no data, or several bands and none is chosen.

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
    name = f"image, {printable(path)}"
    file = photo.regular(path, name)
    if band is not None:
        band = _validate.whole(band, "band", 1)
    if nodata is not None:
        nodata = float(_validate.real(nodata, "nodata").reshape(()))
    if _geotiff.installed():
        found = _geotiff.read(file, name, band)
    else:
        found = _plain.read(file, name, band)
    grey, mask = found["grey"], found["mask"]
    if nodata is not None:
        mask, found["nodata"] = grey == nodata, nodata
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
        The file. It is there whole or not at all.

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
    overwrite = _validate.flag(overwrite, "overwrite")
    return _plain.write(path, raster, overwrite)
