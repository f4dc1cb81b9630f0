"""Points and surfaces in files that other programs read: CSV, LAS and GeoTIFF."""

import os
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files, geotiff
from pgm_lab.io.text import LARGEST
from pgm_lab.stereo.grid import SOURCES, Surface
from pgm_lab.stereo.heights import Points
from pgm_lab.stereo.terrain import ORIGINS, Terrain

LAS_STEP = 1e-4  # m: unit of the whole numbers of a LAS file, or more if it must be
LAS_RANGE = 2e9  # the largest of these numbers
Writers = dict[str, Callable[[Any, Path, str | None], None]]  # by suffix


def save_points(
    points: Points,
    path: str | os.PathLike,
    *,
    overwrite: bool = False,
    crs: str | None = None,
) -> Path:
    """Save object points with their standard deviations and correlations.

    Parameters
    ----------
    points : Points
    path : str or path
        Its suffix gives the format: .csv, .las, or .laz, its compressed form. LAS
        stores coordinates to 0.1 mm, and sd_X, sd_Y, sd_Z and r as further dimensions.
    overwrite : bool
        Whether a file of this name may be replaced.
    crs : str, optional
        Coordinate reference system of LAS: "EPSG:32748", for example. When missing that
        of the points, where it is known; a .csv stores none.

    Returns
    -------
    Path
        The file, written atomically.

    Raises
    ------
    ImportError
        If it needs laspy, or rasterio for `crs`, which is not installed.
    OSError
        If the file exists already, or cannot be written.
    ValueError
        If an argument is not as described here, `crs` is not known or counts in
        degrees, there are no points, or coordinates are NaN, infinite or above 1e30.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> one = Points(np.ones((1, 3)), np.ones((1, 3)), np.ones(1), np.ones((1, 2), int))
    >>> with TemporaryDirectory() as folder:
    ...     print(save_points(one, Path(folder, "a.csv")).read_text(), end="")
    X,Y,Z,sd_X,sd_Y,sd_Z,r,column,row
    1,1,1,1,1,1,1,1,1
    """
    _validate.instance(points, Points, "points")
    if not len(points.xyz):
        raise ValueError("there are no points to save")
    known = np.abs(points.xyz) <= LARGEST
    _validate.refuse(
        ~known.all(-1), "points.xyz{} are NaN, infinite or above 1e30: leave them out"
    )
    compressed = partial(_las, compress=True)
    writers: Writers = {".csv": _points_csv, ".las": _las, ".laz": compressed}
    return _save(path, points, writers, overwrite, crs)


def save_surface(
    surface: Surface | Terrain,
    path: str | os.PathLike,
    *,
    overwrite: bool = False,
    crs: str | None = None,
) -> Path:
    """Save a surface or a terrain, with the layer that gives the source of its heights.

    Parameters
    ----------
    surface : Surface or Terrain
    path : str or path
        Its suffix gives the format: .tif, a GeoTIFF with heights in band 1 (float32,
        NaN for none) and `source` or `origin` in band 2; or .csv, a row for each cell
        that has a height.
    overwrite : bool
        Whether a file of this name may be replaced.
    crs : str, optional
        Coordinate reference system of a GeoTIFF: "EPSG:32748", for example. When
        missing that of the surface, where it is known; a .csv stores none.

    Returns
    -------
    Path
        The file, written atomically.

    Raises
    ------
    ImportError
        If it needs rasterio, which is not installed.
    OSError
        If the file exists already, or cannot be written.
    ValueError
        If an argument is not as described here, or `crs` is not known or in degrees.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> z = np.array([[5.0, np.nan]])
    >>> flat = Surface(z, (10.0, 20.0), 0.5, np.isfinite(z))
    >>> with TemporaryDirectory() as folder:
    ...     print(save_surface(flat, Path(folder, "a.csv")).read_text(), end="")
    X,Y,Z,source
    10,20,5,0
    """
    if not isinstance(surface, Surface | Terrain):
        raise ValueError(
            "surface must be a Surface or a Terrain; got"
            f" {_validate.shown(type(surface).__name__)}"
        )
    writers: Writers = {".csv": _surface_csv, ".tif": _surface_tif}
    return _save(path, surface, writers, overwrite, crs)


def _save(
    path: str | os.PathLike,
    what: Any,
    writers: Writers,
    overwrite: bool,
    crs: str | None,
) -> Path:
    """Write with the writer of the suffix."""
    suffix = files.local(path, "path").suffix.lower().replace(".tiff", ".tif")
    if suffix not in writers:
        raise ValueError(
            f"path must end in {' or '.join(writers)}; got"
            f" {files.printable(Path(path))}"
        )
    if crs is not None:
        _validate.text(crs, "crs")
        if suffix == ".csv":
            raise ValueError(f"crs: a .csv cannot store it; save as {list(writers)[1]}")
    crs = None if suffix == ".csv" else _metric(crs, what.crs)
    file = files.place(path)
    with files.atomic(file, overwrite=overwrite) as part:
        writers[suffix](what, part, crs)
    return file


def _metric(asked: str | None, known: str | None) -> str | None:
    """Coordinate reference system to write; one that cannot be right is said."""
    crs = known if asked is None else asked
    if crs and geotiff.installed() and geotiff.system(crs).is_geographic:
        raise ValueError(
            f"crs {crs!r:.60} counts in degrees, and X and Y are metres: name the map"
            " of the stations, such as 'EPSG:32748'"
        )
    if known is not None and not geotiff.same_crs(crs, known):
        warnings.warn(
            f"crs={crs!r:.60} is written, but the photos name {known!r:.60}, and saving"
            " transforms nothing: without crs= the file names theirs",
            stacklevel=4,
        )
    return crs


def _points_csv(points: Points, path: Path, _: str | None) -> None:
    names = ("X", "Y", "Z", "sd_X", "sd_Y", "sd_Z", "r", "column", "row")
    columns = (points.xyz, points.sd, points.r[:, None], points.cells)
    _csv(path, names, np.hstack(columns))


def _surface_csv(surface: Surface | Terrain, path: Path, _: str | None) -> None:
    name, layer = _layer(surface)[:2]
    rows, columns = np.nonzero(np.isfinite(surface.z))
    x = surface.corner[0] + surface.cell * columns
    y = surface.corner[1] - surface.cell * rows
    values = (x, y, surface.z[rows, columns], layer[rows, columns])
    _csv(path, ("X", "Y", "Z", name), np.stack(values, -1))


def _csv(path: Path, names: tuple[str, ...], values: np.ndarray) -> None:
    np.savetxt(
        path, values, "%.11g", ",", header=",".join(names), comments="", encoding="utf8"
    )


def _las(points: Points, path: Path, crs: str | None, compress: bool = False) -> None:
    try:
        import laspy
    except ImportError:
        raise ImportError("writing LAS files needs laspy: pip install laspy") from None
    if compress and not laspy.LazBackend.detect_available():
        raise ImportError("writing .laz needs lazrs: pip install lazrs, or write .las")
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.offsets = np.floor(points.xyz.mean(0))
    reach = np.abs(points.xyz - header.offsets).max(0)
    powers = np.ceil(np.log10(np.maximum(reach, 1e-9) / LAS_RANGE))
    header.scales = np.maximum(LAS_STEP, 10.0**powers)
    more = dict(zip(("sd_X", "sd_Y", "sd_Z"), points.sd.T)) | {"r": points.r}
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.float32) for name in more])
    if crs is not None:
        text = laspy.vlrs.known.WktCoordinateSystemVlr(geotiff.wkt(crs))
        header.vlrs.append(text)
        header.global_encoding.wkt = True
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.xyz.T
    for name, values in more.items():
        las[name] = values.astype(np.float32)
    with path.open("xb") as file:
        las.write(file, do_compress=compress)


def _layer(surface: Surface | Terrain) -> tuple[str, np.ndarray, tuple[str, ...]]:
    """Name, numbers and meanings of the layer that gives the source of heights."""
    if isinstance(surface, Surface):
        return "source", surface.source, SOURCES
    return "origin", surface.origin, ORIGINS


def _surface_tif(surface: Surface | Terrain, path: Path, crs: str | None) -> None:
    cell, (x, y) = surface.cell, surface.corner
    name, layer, meanings = _layer(surface)
    meaning = ", ".join(f"{k} {one}" for k, one in enumerate(meanings))
    geotiff.write_bands(
        path,
        np.stack([surface.z.astype(np.float32), layer.astype(np.float32)]),
        # For the outer corner of the first cell
        [[cell, 0, x - cell / 2], [0, -cell, y + cell / 2]],
        crs,
        nodata=np.nan,
        names=("height", name),
        tags={2: {"meaning": meaning}},
        compress="deflate",
    )
