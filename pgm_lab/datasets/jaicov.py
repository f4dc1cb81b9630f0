"""A network that another program has adjusted, to compare with."""

from dataclasses import dataclass

import numpy as np

from pgm_lab.datasets.files import columns
from pgm_lab.datasets.sources import EXTERIOR, INTERIOR


@dataclass(frozen=True)
class Jaicov9x50:
    """Nine simulated photos of fifty targets, and their adjustment by JAICOV.

    A free network with inner constraints on all points, evaluated anew at the points of
    each iteration; all ten interior parameters; lens "forward". Exterior orientations
    are rows (X0, Y0, Z0, omega, phi, kappa) in mm and radians, interior ones
    (c, x0, y0, K1, K2, K3, P1, P2, b1, b2) in mm and its powers.

    Attributes
    ----------
    photo, point : ndarray (450,)
        Indices from 0 of the observations.
    xy, sigma : ndarray (450, 2)
        Photo coordinates and their standard deviations; mm.
    interior, exteriors, points : ndarray (10,), (9, 6), (50, 3)
        Start values.
    adjusted_interior, adjusted_exteriors, adjusted_points : ndarray
        What JAICOV found.
    interior_sd, exteriors_sd, points_sd : ndarray
        Its standard deviations, a posteriori.
    variance : float
        Its estimated variance of unit weight, sigma0^2.
    redundancy : int
        Observations - unknowns + constraints.
    """

    photo: np.ndarray
    point: np.ndarray
    xy: np.ndarray
    sigma: np.ndarray
    interior: np.ndarray
    exteriors: np.ndarray
    points: np.ndarray
    adjusted_interior: np.ndarray
    adjusted_exteriors: np.ndarray
    adjusted_points: np.ndarray
    interior_sd: np.ndarray
    exteriors_sd: np.ndarray
    points_sd: np.ndarray
    variance: float = 0.9487167938
    redundancy: int = 693


def jaicov_9x50() -> Jaicov9x50:
    """Load a network of nine photos that JAICOV, a program in Java, has adjusted.

    References
    ----------
    JAICOV, https://github.com/applied-geodesy/bundle-adjustment.

    Examples
    --------
    >>> network = jaicov_9x50()
    >>> network.xy.shape, network.points.shape
    ((450, 2), (50, 3))
    >>> print(f"c = {network.adjusted_interior[0]:.4f} mm")
    c = 34.9993 mm
    """
    name = "jaicov_9x50_{}.csv".format
    observed, points = name("image_points"), name("object_points")
    index = columns(observed, "photo", "point").astype(int) - 1
    xyz = ("X_mm", "Y_mm", "Z_mm")
    # the tables list the parameters, photos and points in their order
    interior = columns(name("interior"), "value", "sd").T
    return Jaicov9x50(
        photo=index[:, 0],
        point=index[:, 1],
        xy=columns(observed, "x_mm", "y_mm"),
        sigma=columns(observed, "sx_mm", "sy_mm"),
        interior=np.array([35.4] + [0.0] * (len(INTERIOR) - 1)),
        exteriors=columns(name("start_exterior"), *EXTERIOR),
        points=columns(name("start_object_points"), *xyz),
        adjusted_interior=interior[0],
        adjusted_exteriors=columns(name("exterior"), *EXTERIOR),
        adjusted_points=columns(points, *xyz),
        interior_sd=interior[1],
        exteriors_sd=columns(name("exterior"), *(f"sd_{axis}" for axis in EXTERIOR)),
        points_sd=columns(points, *(f"sd_{axis}" for axis in xyz)),
    )
