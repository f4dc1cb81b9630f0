"""Points and surfaces in files that other programs read: CSV, LAS and GeoTIFF."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from pgm_lab import _validate
from pgm_lab.io import files as _files
from pgm_lab.stereo.grid import SOURCES, Surface
from pgm_lab.stereo.heights import Points
from pgm_lab.stereo.terrain import ORIGINS, Terrain

FINEST = 1e-4  # m: a LAS file holds whole multiples of it, or of more if it must
LARGEST = 2e9  # of which it holds so many


def save_points(
    points: Points, path: str | os.PathLike, *, overwrite: bool = False
) -> Path:
    """Save object points with their standard deviations and correlations.

    Parameters
    ----------
    points : Points
    path : str or path
        Name of the file, by whose end it is written: .csv, .las, or .laz, its
        compressed form. LAS holds places to 0.1 mm, and sd_X, sd_Y, sd_Z and r as
        further dimensions of its points.
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
        If it needs laspy, which is not installed.
    OSError
        If it cannot be written.
    ValueError
        If an argument is not what is described here, or there are no points.

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
    writers = {".csv": _points_csv, ".las": _las, ".laz": _laz}
    return _write(path, points, writers, overwrite)


def save_surface(
    surface: Surface | Terrain,
    path: str | os.PathLike,
    *,
    overwrite: bool = False,
    crs: str | None = None,
) -> Path:
    """Save a surface or a terrain, with the layer that says where its heights are from.

    Parameters
    ----------
    surface : Surface or Terrain
    path : str or path
        Name of the file, by whose end it is written: .tif, a GeoTIFF with heights in
        band 1 (float32, NaN for none) and `source` or `origin` in band 2; or .csv, a
        row for each cell that has a height.
    overwrite : bool
        Whether a file of this name may be replaced.
    crs : str, optional
        Coordinate reference system of a GeoTIFF: "EPSG:32748", for example.

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
        If an argument is not what is described here, or `crs` is not known.

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
    if crs is not None:
        _validate.text(crs, "crs")
        if isinstance(path, str | os.PathLike) and str(path).lower().endswith(".csv"):
            raise ValueError("crs: a .csv has no place for it; save as .tif")

    def tif(surface: Surface | Terrain, part: Path) -> None:
        _tif(surface, part, crs)

    return _write(path, surface, {".csv": _surface_csv, ".tif": tif}, overwrite)


def _write(
    path: str | os.PathLike, what: object, writers: dict[str, Callable], overwrite: bool
) -> Path:
    """Write with the writer that the end of the name asks for."""
    overwrite = _validate.flag(overwrite, "overwrite")
    if not isinstance(path, str | os.PathLike):
        raise ValueError(
            f"path must be the name of a file; got {_validate.shown(path)}"
        )
    end = Path(path).suffix.lower().replace(".tiff", ".tif")
    if end not in writers:
        raise ValueError(
            f"path must end in {' or '.join(writers)}; got"
            f" {_files.printable(path):.200}"
        )
    _need(end)
    file = _files.place(path)
    with _files.written_whole(file, overwrite=overwrite) as part:
        writers[end](what, part)
    return file


def _need(end: str) -> None:
    """Raise ImportError if a library is missing for files of this kind."""
    if end == ".tif":
        try:
            import rasterio  # noqa: F401
        except ImportError:
            raise ImportError(
                "a GeoTIFF is written by rasterio: pip install rasterio"
            ) from None
    if end in (".las", ".laz"):
        try:
            import laspy
        except ImportError:
            raise ImportError(f"{end} is written by laspy: pip install laspy") from None
        if end == ".laz" and not laspy.LazBackend.detect_available():
            raise ImportError(
                ".laz is compressed by lazrs: pip install lazrs, or write .las"
            )


def _points_csv(points: Points, part: Path) -> None:
    names = ("X", "Y", "Z", "sd_X", "sd_Y", "sd_Z", "r", "column", "row")
    columns = (points.xyz, points.sd, points.r[:, None], points.cells)
    _csv(part, names, np.hstack(columns))


def _surface_csv(surface: Surface | Terrain, part: Path) -> None:
    name, layer, _ = _layer(surface)
    rows, columns = np.nonzero(np.isfinite(surface.z))
    x = surface.corner[0] + surface.cell * columns
    y = surface.corner[1] - surface.cell * rows
    values = (x, y, surface.z[rows, columns], layer[rows, columns])
    _csv(part, ("X", "Y", "Z", name), np.stack(values, -1))


def _csv(part: Path, names: tuple[str, ...], values: np.ndarray) -> None:
    np.savetxt(
        part, values, "%.11g", ",", header=",".join(names), comments="", encoding="utf8"
    )


def _las(points: Points, part: Path, compress: bool = False) -> None:
    import laspy

    header = laspy.LasHeader(point_format=6, version="1.4")
    header.offsets = np.floor(points.xyz.mean(0))
    reach = np.abs(points.xyz - header.offsets).max(0)
    powers = np.ceil(np.log10(np.maximum(reach, 1e-9) / LARGEST))
    header.scales = np.maximum(FINEST, 10.0**powers)
    more = dict(zip(("sd_X", "sd_Y", "sd_Z"), points.sd.T)) | {"r": points.r}
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.float32) for name in more])
    las = laspy.LasData(header)
    las.x, las.y, las.z = points.xyz.T
    for name, values in more.items():
        las[name] = values.astype(np.float32)
    with part.open("xb") as file:
        las.write(file, do_compress=compress)


def _laz(points: Points, part: Path) -> None:
    _las(points, part, compress=True)


def _layer(surface: Surface | Terrain) -> tuple[str, np.ndarray, tuple[str, ...]]:
    """Name, numbers and their meaning, of the layer on where heights are from."""
    if isinstance(surface, Surface):
        return "source", surface.source, SOURCES
    return "origin", surface.origin, ORIGINS


def _tif(surface: Surface | Terrain, part: Path, crs: str | None) -> None:
    import rasterio
    from rasterio.errors import CRSError, RasterioError
    from rasterio.transform import Affine

    cell, (x, y) = surface.cell, surface.corner
    name, layer, meanings = _layer(surface)
    rows, columns = surface.z.shape
    profile = {
        "driver": "GTiff",
        "height": rows,
        "width": columns,
        "count": 2,
        "dtype": "float32",
        "nodata": np.nan,
        "compress": "deflate",
        "BIGTIFF": "IF_SAFER",
        # of the outer corner of the first cell
        "transform": Affine(cell, 0, x - cell / 2, 0, -cell, y + cell / 2),
    }
    try:
        if crs is not None:
            profile["crs"] = rasterio.CRS.from_user_input(crs)
        with rasterio.open(part, "w", **profile) as file:
            file.write(surface.z.astype(np.float32), 1)
            file.write(layer.astype(np.float32), 2)
            file.descriptions = ("height", name)
            meaning = ", ".join(f"{k} {one}" for k, one in enumerate(meanings))
            file.update_tags(2, meaning=meaning)
    except CRSError:
        raise ValueError(
            f"crs {crs!r:.60} is not known; give it as 'EPSG:32748', for example"
        ) from None
    except RasterioError as error:
        raise OSError(" ".join(str(error.__cause__ or error).split())) from None
