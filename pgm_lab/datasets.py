"""The data behind the workbook: source tables, images, the ledger.

Every file lies in ``data/``; ``data/README.md`` says where it comes from and under
which licence. Files that were measured elsewhere are checked against their SHA-256
when they are loaded, so that a damaged table cannot pass for a published one.
"""

import csv
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import skimage.data

from pgm_lab.io.photo import GREY_OF_RGB

__all__ = [
    "EXTERIOR",
    "INTERIOR",
    "Bani2010",
    "Chequerboard",
    "Harintaka2020",
    "Muliawan2013",
    "Orthophoto",
    "StereoPair",
    "bani2010",
    "bani2010_intersection",
    "chequerboard",
    "folder",
    "harintaka2020",
    "landsat",
    "landsat_pair",
    "motorcycle",
    "muliawan2013",
    "path",
    "rows",
    "yellowstone",
]

INTERIOR = ("c", "x0", "y0", "K1", "K2", "K3", "P1", "P2", "b1", "b2")
EXTERIOR = ("XL_mm", "YL_mm", "ZL_mm", "omega_rad", "phi_rad", "kappa_rad")
XYZ = ("X_mm", "Y_mm", "Z_mm")


# --- Files: found, undamaged, and read ---


def folder() -> Path:
    """Folder with the data: in the installed package, else ``data/`` of the clone."""
    package = Path(__file__).resolve().parent
    for place in (package / "data", package.parent / "data"):
        if place.is_dir():
            return place
    raise FileNotFoundError(
        f"the data folder {place} is missing: install pgm_lab again or, to work from a"
        " clone of its repository, install it there with pip install -e ."
    )


def path(name: str | Path) -> Path:
    """Path of a data file that exists and, if it has a checksum, is undamaged.

    Parameters
    ----------
    name : str or Path
        In the data folder, for example "bani2010_photo_points.csv"; or a full path.

    Raises
    ------
    FileNotFoundError
        If the file is missing; the message says how to get it back.
    ValueError
        If its checksum differs.

    Examples
    --------
    >>> path("chapters.csv").name
    'chapters.csv'
    """
    found = folder() / name
    if not found.exists():
        raise FileNotFoundError(f"{_shown(name)} is missing. {_restore(name)}")
    expected = checksums().get(str(name))
    if expected and hashlib.sha256(found.read_bytes()).hexdigest() != expected:
        raise ValueError(
            f"{_shown(name)} is damaged: its SHA-256 is not the one in data/SHA256SUMS."
            f" {_restore(name)}"
        )
    return found


def rows(name: str | Path) -> list[dict[str, str]]:
    """Rows of a CSV file, or of a folder of them, as dictionaries.

    Parameters
    ----------
    name : str or Path
        As of `path`; or a folder such as "audit", for all its CSV files by name.

    Raises
    ------
    FileNotFoundError, ValueError
        As `path`, and if a row has a wrong length.

    Examples
    --------
    >>> sorted({row["verdict"] for row in rows("audit")})
    ['corrected', 'not derivable', 'reproduced']
    """
    file = path(name)
    if file.is_dir():
        return [row for one in sorted(file.glob("*.csv")) for row in rows(one)]
    with file.open(encoding="utf-8", newline="") as lines:
        found = list(csv.DictReader(lines, strict=True))
    for number, row in enumerate(found, start=2):
        if None in row or None in row.values():
            raise ValueError(
                f"{_shown(name)} is damaged: the number of fields in row {number}"
                f" differs from that of the header. {_restore(name)}"
            )
    return found


def checksums() -> dict[str, str]:
    """SHA-256 by name of the files that were measured elsewhere."""
    lines = (folder() / "SHA256SUMS").read_text(encoding="utf-8").splitlines()
    return {name: digest for digest, name in (line.split() for line in lines)}


def _shown(name: str | Path) -> str:
    return str(name) if Path(name).is_absolute() else f"data/{name}"


def _restore(name: str | Path) -> str:
    return f"Restore it with git checkout -- {_shown(name)}, or install pgm_lab again"


def _columns(name: str, *names: str) -> np.ndarray:
    """Columns (rows, columns) of a CSV file, as numbers."""
    return np.array([[float(row[column]) for column in names] for row in rows(name)])


def _grey(name: str) -> np.ndarray:
    """Grey values of an image, in its own number of bits."""
    # imdecode, since imread cannot open paths with accents on Windows
    coded = np.frombuffer(path(name).read_bytes(), dtype=np.uint8)
    return np.asarray(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED))


# --- The published tables of the sources, as printed ---


@dataclass(frozen=True)
class Bani2010:
    """Ten points in a stereo pair (Bani 2010, Tables 4.1 and 4.2, appendix B).

    Attributes
    ----------
    point : ndarray (10,)
        Point numbers.
    pixels : ndarray (2, 10, 2)
        Table 4.1 as printed: photo (left, right), point, (x, y); px.
    photo : ndarray (2, 10, 2)
        Table 4.2 as printed; mm.
    image_size : tuple
        (columns, rows) of a photo; px.
    sensor_size : tuple
        (width, height) of the sensor; mm.
    listing_pixel_size : float
        The one pixel size that the program listing uses for x and y; mm.
    """

    point: np.ndarray
    pixels: np.ndarray
    photo: np.ndarray
    image_size: tuple[int, int] = (1936, 1296)
    sensor_size: tuple[float, float] = (23.6, 15.8)
    listing_pixel_size: float = 0.01219


def bani2010() -> Bani2010:
    """Load the stereo pair of Bani 2010.

    Examples
    --------
    >>> bani2010().photo[0, 0]
    array([-4.98644,  2.56208])
    """
    pixels = _columns("bani2010_pixel_points.csv", "xl_px", "yl_px", "xr_px", "yr_px")
    photo = _columns("bani2010_photo_points.csv", "xl_mm", "yl_mm", "xr_mm", "yr_mm")
    number = _columns("bani2010_pixel_points.csv", "point")[:, 0].astype(int)
    # (point, left x y right x y) -> (photo, point, xy)
    return Bani2010(
        number,
        pixels.reshape(-1, 2, 2).swapaxes(0, 1),
        photo.reshape(-1, 2, 2).swapaxes(0, 1),
    )


def bani2010_intersection() -> dict[str, np.ndarray]:
    """Load the matrices of the space intersection of Bani 2010 (appendix B), by name.

    Examples
    --------
    >>> float(bani2010_intersection()["S0"][0, 0])
    1.51554975
    """
    values: dict[str, list[float]] = {}
    rows_of = {}
    for row in rows("bani2010_intersection.csv"):
        values.setdefault(row["quantity"], []).append(float(row["value"]))
        rows_of[row["quantity"]] = int(row["row"])
    return {name: np.reshape(v, (rows_of[name], -1)) for name, v in values.items()}


@dataclass(frozen=True)
class Muliawan2013:
    """Nine convergent photos of fifty targets (Muliawan 2013, chapter IV).

    Exterior orientations are rows (X0, Y0, Z0, omega, phi, kappa) in mm and radians,
    interior ones (c, x0, y0, K1, K2, K3, P1, P2, b1, b2) in mm and its powers.

    Attributes
    ----------
    photo, point : ndarray (450,)
        Indices from 0 of the observations; the source's numbers are one more.
    xy, sigma : ndarray (450, 2)
        Tables 4.4 to 4.12: photo coordinates and their standard deviations; mm.
    interior, exteriors, object_points : ndarray (10,), (9, 6), (50, 3)
        Tables 4.1 to 4.3: approximate values.
    published_interior : ndarray (10,)
        Table 4.14.
    published_exteriors, published_exteriors_sd : ndarray (9, 6)
        Tables 4.15 and 4.16.
    published_object_points, published_object_points_sd : ndarray (50, 3)
        Tables 4.17 and 4.18.
    published_exterior_differences : ndarray (9, 6)
        Table 4.19: approximate values less results.
    published_object_point_differences : ndarray (50, 3)
        Table 4.20: the same of the object points.
    """

    photo: np.ndarray
    point: np.ndarray
    xy: np.ndarray
    sigma: np.ndarray
    interior: np.ndarray
    exteriors: np.ndarray
    object_points: np.ndarray
    published_interior: np.ndarray
    published_exteriors: np.ndarray
    published_exteriors_sd: np.ndarray
    published_object_points: np.ndarray
    published_object_points_sd: np.ndarray
    published_exterior_differences: np.ndarray
    published_object_point_differences: np.ndarray


def muliawan2013() -> Muliawan2013:
    """Load the calibration network of Muliawan 2013.

    Examples
    --------
    >>> network = muliawan2013()
    >>> network.xy.shape, network.exteriors.shape
    ((450, 2), (9, 6))
    """
    name = "muliawan2013_{}.csv".format

    def interior(table: str) -> np.ndarray:
        value = {row["parameter"]: float(row["value"]) for row in rows(name(table))}
        return np.array([value[parameter] for parameter in INTERIOR])

    return Muliawan2013(
        *_image_points(name("image_points")),
        interior=interior("interior_approx"),
        exteriors=_columns(name("exterior_approx"), *EXTERIOR),
        object_points=_columns(name("object_points_approx"), *XYZ),
        published_interior=interior("published_interior"),
        published_exteriors=_columns(name("published_exterior"), *EXTERIOR),
        published_exteriors_sd=_columns(name("published_exterior_sd"), *EXTERIOR),
        published_object_points=_columns(name("published_object_points"), *XYZ),
        published_object_points_sd=_columns(name("published_object_points_sd"), *XYZ),
        published_exterior_differences=_columns(
            name("published_exterior_difference"), *EXTERIOR
        ),
        published_object_point_differences=_columns(
            name("published_object_points_difference"), *XYZ
        ),
    )


def _image_points(
    name: str,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Photo, point, xy and sigma of the observations of a network."""
    photo, point = _columns(name, "photo", "point").astype(int).T - 1
    xy, sigma = _columns(name, "x_mm", "y_mm"), _columns(name, "sx_mm", "sy_mm")
    return photo, point, xy, sigma


@dataclass(frozen=True)
class Harintaka2020:
    """Flight and height accuracy of an aerial block (Harintaka 2020).

    Attributes
    ----------
    flight : dict
        Printed value by quantity, in the units of ``harintaka2020_flight.csv``.
    test_points : ndarray (3,)
        Table 1: number of test points at each location.
    interactive, automatic : ndarray (3,)
        Table 1: mean vertical accuracy; m.
    camera_pixel_size : float
        Pixel of the Nikon D2X after its maker; mm. Not printed in the source.
    camera_image_size : tuple
        (columns, rows) of the Nikon D2X after its maker; px. Not printed in the source.
    """

    flight: dict[str, float]
    test_points: np.ndarray
    interactive: np.ndarray
    automatic: np.ndarray
    camera_pixel_size: float = 0.00549
    camera_image_size: tuple[int, int] = (4288, 2848)


def harintaka2020() -> Harintaka2020:
    """Load the flight data and Table 1 of Harintaka 2020.

    Examples
    --------
    >>> harintaka2020().flight["flying_height"]
    1000.0
    """
    printed = rows("harintaka2020_flight.csv")
    flight = {row["quantity"]: float(row["printed"]) for row in printed}
    table1 = _columns(
        "harintaka2020_table1.csv", "test_points", "interactive_m", "automatic_m"
    )
    return Harintaka2020(flight, table1[:, 0].astype(int), table1[:, 1], table1[:, 2])


# --- Real images ---


@dataclass(frozen=True)
class Orthophoto:
    """A grey orthophoto.

    Attributes
    ----------
    grey : ndarray (rows, columns)
        Grey values as stored.
    gsd : float
        Ground sampling distance; m.
    """

    grey: np.ndarray = field(repr=False)
    gsd: float


def yellowstone() -> Orthophoto:
    """Load a real aerial orthophoto, 1536 x 1536, 8 bit, 0.1 m (NEON, Yellowstone).

    Examples
    --------
    >>> yellowstone().grey.shape
    (1536, 1536)
    """
    return Orthophoto(_grey("neon_yellowstone_ortho_10cm_gray.png"), gsd=0.1)


def landsat() -> Orthophoto:
    """Load a satellite image of Itaipu, 1200 x 1200, 16 bit, 30 m (Landsat 8, red).

    City, fields, forest and water at Ciudad del Este, 18 May 2020.

    Examples
    --------
    >>> landsat().grey.shape, landsat().grey.dtype
    ((1200, 1200), dtype('uint16'))
    """
    return Orthophoto(_grey("landsat8_itaipu_red_30m.png"), gsd=30.0)


def landsat_pair() -> tuple[Orthophoto, Orthophoto]:
    """Load the same ground, 600 x 1000, from two scenes of one pass of Landsat 8.

    The scenes of rows 077 and 078 were resampled each by itself; a correct registration
    finds no shift.

    Examples
    --------
    >>> one, other = landsat_pair()
    >>> one.grey.shape == other.grey.shape == (600, 1000)
    True
    """
    name = "landsat8_itaipu_red_30m_row{}.png".format
    return Orthophoto(_grey(name("077")), 30.0), Orthophoto(_grey(name("078")), 30.0)


@dataclass(frozen=True)
class Chequerboard:
    """Photos of a chequerboard, and its inner corners as they were measured in them.

    Attributes
    ----------
    photos : tuple of Path
        The photos, JPEG.
    pixels : ndarray (photos, corners, 2)
        (column, row) of each corner, px; NaN where it was not measured. They are
        counted row by row, from the corner at the top left of the board.
    image_size : (int, int)
        Columns and rows of a photo.
    corners : (int, int)
        Inner corners in a row and in a column of the board.
    """

    photos: tuple[Path, ...] = field(repr=False)
    pixels: np.ndarray = field(repr=False)
    image_size: tuple[int, int]
    corners: tuple[int, int]


def chequerboard(camera: str) -> Chequerboard:
    """Load OpenCV's sample photos of a board, of the left or of the right camera.

    Two cameras of a rig took thirteen photos each, all pairs at the same time. The
    corners are those of ``pgm_lab.calibration.measure``, to 0.001 px.

    Parameters
    ----------
    camera : {"left", "right"}

    Examples
    --------
    >>> left = chequerboard("left")
    >>> left.pixels.shape, left.photos[0].name
    ((13, 54, 2), 'left01.jpg')
    """
    if camera not in ("left", "right"):
        raise ValueError(f"camera must be 'left' or 'right'; got {camera!r}")
    measured = [r for r in rows("chequerboard_corners.csv") if r["camera"] == camera]
    pixels = [
        [float(r[name] or "nan") for name in ("column_px", "row_px")] for r in measured
    ]
    numbers = list(dict.fromkeys(r["photo"] for r in measured))
    photos = tuple(path(f"chequerboard/{camera}{n}.jpg") for n in numbers)
    return Chequerboard(
        photos, np.reshape(pixels, (len(photos), -1, 2)), (640, 480), (9, 6)
    )


@dataclass(frozen=True)
class StereoPair:
    """Two rectified images, with the truth that was measured by other means.

    A point at (column x, row y) of the left image lies at (x - d, y) of the right one,
    d being the disparity at (x, y). Its distance in front of the cameras is
    focal_length * baseline / (d + doffs).

    Attributes
    ----------
    left, right : ndarray (rows, columns)
        Grey values, float64.
    disparity : ndarray (rows, columns)
        Disparity d of every pixel of the left image; px; NaN where it is unknown. Known
        does not mean seen: the right image may hide the point, or end before it.
    focal_length : float
        In px.
    baseline : float
        Distance of the two perspective centres; mm.
    doffs : float
        Principal point of the right image less that of the left one, in x; px.
    """

    left: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)
    disparity: np.ndarray = field(repr=False)
    focal_length: float
    baseline: float
    doffs: float

    def known(
        self, columns: Iterable[int], rows: Iterable[int]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Points of a grid in the left image whose disparity is known.

        Returns
        -------
        points : ndarray (n, 2) of int
            (column, row), row by row.
        disparity : ndarray (n,)
            In px: a point lies so much farther left in the right image.

        Examples
        --------
        >>> points, disparity = motorcycle().known(range(80, 720, 20), [318])
        >>> print(points[10], disparity[10].round(1))
        [300 318] 46.2
        """
        x, y = np.meshgrid(list(columns), list(rows))
        kept = np.isfinite(self.disparity[y, x])
        return np.column_stack([x[kept], y[kept]]), self.disparity[y, x][kept]


def motorcycle() -> StereoPair:
    """Load the stereo pair 'Motorcycle', 500 x 741, with its true disparities.

    From the Middlebury stereo benchmark of 2014, reduced to a quarter, as scikit-image
    has it. Grey is 0.299 R + 0.587 G + 0.114 B (Rec. 601), 0 to 255, not rounded.
    Disparities from structured light; at edges the reduction has mixed near and far.

    Raises
    ------
    FileNotFoundError
        If the files are missing from scikit-image, or damaged.

    Notes
    -----
    Least squares matching along the rows, in 11 x 11 windows with texture and
    disparities within 1 px, differs by -0.08 px (median, sd 0.08 px): the truth judges
    a matcher to a tenth of a pixel, not to a hundredth.

    References
    ----------
    D. Scharstein, H. Hirschmüller, Y. Kitajima, G. Krathwohl, N. Nešić, X. Wang and
    P. Westling (2014), High-resolution stereo datasets with subpixel-accurate ground
    truth, German Conference on Pattern Recognition. The calibration is the one in the
    documentation of ``skimage.data.stereo_motorcycle``.

    Examples
    --------
    >>> pair = motorcycle()
    >>> pair.left.shape == pair.right.shape == pair.disparity.shape == (500, 741)
    True
    >>> near = np.nanmax(pair.disparity)
    >>> print(f"{1e-3 * pair.focal_length * pair.baseline / (near + pair.doffs):.2f} m")
    2.11 m
    """
    try:
        left, right, disparity = skimage.data.stereo_motorcycle()
    except (OSError, ImportError) as error:
        raise FileNotFoundError(
            "the stereo pair 'motorcycle' that comes with scikit-image is missing or"
            " damaged. Restore it with pip install --force-reinstall --no-deps"
            " scikit-image"
        ) from error
    disparity = disparity.astype(float)
    disparity[~np.isfinite(disparity)] = np.nan
    return StereoPair(
        left @ np.array(GREY_OF_RGB),
        right @ np.array(GREY_OF_RGB),
        disparity,
        focal_length=994.978,
        baseline=193.001,
        doffs=31.086,
    )
