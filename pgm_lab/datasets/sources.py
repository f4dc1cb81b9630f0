"""The published tables of the sources, as printed, from the CSV files in ``data/``."""

from dataclasses import dataclass

import numpy as np

from pgm_lab.datasets.files import columns, rows

INTERIOR = ("c", "x0", "y0", "K1", "K2", "K3", "P1", "P2", "b1", "b2")
EXTERIOR = ("XL_mm", "YL_mm", "ZL_mm", "omega_rad", "phi_rad", "kappa_rad")


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


def bani2010() -> Bani2010:
    """Load the stereo pair of Bani 2010.

    Examples
    --------
    >>> bani2010().photo[0, 0]
    array([-4.98644,  2.56208])
    """
    pixels = columns("bani2010_pixel_points.csv", "xl_px", "yl_px", "xr_px", "yr_px")
    photo = columns("bani2010_photo_points.csv", "xl_mm", "yl_mm", "xr_mm", "yr_mm")
    number = columns("bani2010_pixel_points.csv", "point")[:, 0].astype(int)
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


def muliawan2013() -> Muliawan2013:
    """Load the calibration network of Muliawan 2013.

    Examples
    --------
    >>> network = muliawan2013()
    >>> network.xy.shape, network.exteriors.shape
    ((450, 2), (9, 6))
    """
    name = "muliawan2013_{}.csv".format
    observed = name("image_points")
    index = columns(observed, "photo", "point").astype(int) - 1
    xyz = ("X_mm", "Y_mm", "Z_mm")
    return Muliawan2013(
        photo=index[:, 0],
        point=index[:, 1],
        xy=columns(observed, "x_mm", "y_mm"),
        sigma=columns(observed, "sx_mm", "sy_mm"),
        interior=_interior(name("interior_approx")),
        exteriors=columns(name("exterior_approx"), *EXTERIOR),
        object_points=columns(name("object_points_approx"), *xyz),
        published_interior=_interior(name("published_interior")),
        published_exteriors=columns(name("published_exterior"), *EXTERIOR),
        published_exteriors_sd=columns(name("published_exterior_sd"), *EXTERIOR),
        published_object_points=columns(name("published_object_points"), *xyz),
        published_object_points_sd=columns(name("published_object_points_sd"), *xyz),
        published_exterior_differences=columns(
            name("published_exterior_difference"), *EXTERIOR
        ),
        published_object_point_differences=columns(
            name("published_object_points_difference"), *xyz
        ),
    )


def harintaka2020() -> Harintaka2020:
    """Load the flight data and Table 1 of Harintaka 2020.

    Examples
    --------
    >>> harintaka2020().flight["flying_height"]
    1000.0
    """
    flight = {
        row["quantity"]: float(row["printed"])
        for row in rows("harintaka2020_flight.csv")
    }
    table1 = columns(
        "harintaka2020_table1.csv", "test_points", "interactive_m", "automatic_m"
    )
    return Harintaka2020(flight, table1[:, 0].astype(int), table1[:, 1], table1[:, 2])


def _interior(name: str) -> np.ndarray:
    value = {row["parameter"]: float(row["value"]) for row in rows(name)}
    return np.array([value[parameter] for parameter in INTERIOR])
