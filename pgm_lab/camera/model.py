"""From an object point to its image: rotation, perspective and lens, with derivatives.

The camera looks along its negative z axis. With (U, V, W) = M (X - X0) an ideal camera
sees the point at x = -c U / W, y = -c V / W, and W is negative in front of it. The lens
moves the image by (dx, dy); x, y are reduced to the principal point, rho^2 = x^2 + y^2:

    dx = x (K1 rho^2 + K2 rho^4 + K3 rho^6) + P1 (rho^2 + 2 x^2) + 2 P2 x y
         + b1 x + b2 y
    dy = y (K1 rho^2 + K2 rho^4 + K3 rho^6) + P2 (rho^2 + 2 y^2) + 2 P1 x y

lens="backward" (Australis, Muliawan 2013): ideal = measured + d(measured)
lens="forward" (JAICOV, OpenCV):            measured = ideal + d(ideal)
In OpenCV y points down, and k_i = K_i c^(2i), p1 = -P2 c, p2 = P1 c.

Arguments that are not as described raise ValueError.
"""

import os
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import _document, imaging

PARAMETERS = tuple(_document.UNITS)  # c, x0, y0, K1, K2, K3, P1, P2, b1, b2
BLOCKS = ("interior", "exterior", "point")
LENSES = ("backward", "forward")


@dataclass(frozen=True)
class Camera:
    """Interior orientation of a camera and the distortion of its lens.

    Attributes
    ----------
    c : float
        Principal distance, positive, in mm.
    x0, y0 : float
        Principal point in the photo frame, in mm.
    K1, K2, K3 : float
        Radial distortion, in mm^-2, mm^-4, mm^-6.
    P1, P2 : float
        Decentring distortion, in mm^-1.
    b1, b2 : float
        Affinity and shear of the image axes, no unit.
    lens : {"backward", "forward"}
        "backward" corrects measured coordinates, "forward" displaces ideal ones.

    Examples
    --------
    >>> camera = Camera(35.0, x0=0.1, K1=-1e-4)
    >>> Camera(*camera.interior, lens=camera.lens) == camera
    True
    """

    c: float
    x0: float = 0.0
    y0: float = 0.0
    K1: float = 0.0
    K2: float = 0.0
    K3: float = 0.0
    P1: float = 0.0
    P2: float = 0.0
    b1: float = 0.0
    b2: float = 0.0
    lens: str = "backward"

    def __post_init__(self) -> None:
        for name in PARAMETERS:
            value = _validate.number(getattr(self, name), name)
            object.__setattr__(self, name, value)
        _validate.positive(self.c, "c", "mm")
        _validate.choice(self.lens, "lens", LENSES)

    @classmethod
    def read(cls, path: str | os.PathLike) -> "Camera":
        """Read a camera.json: `camera.files.read` gives its covariance and image too.

        Raises as that does.
        """
        return _document.read(path, cls).camera

    @property
    def interior(self) -> np.ndarray:
        """The ten parameters (10,) in the order of `PARAMETERS`."""
        return np.array([getattr(self, name) for name in PARAMETERS])


@dataclass(frozen=True)
class Collinearity:
    """Misclosure of the collinearity equations and its derivatives.

    Attributes
    ----------
    v : ndarray (..., 2)
        Computed minus observed, in mm.
    depth : ndarray (...)
        -W, the distance in front of the camera along its axis; negative behind it.
    interior, exterior, point : ndarray (..., 2, 10), (..., 2, 6), (..., 2, 3) or None
        Derivatives of v by the camera's `PARAMETERS`, by (X0, Y0, Z0, omega, phi,
        kappa) and by (X, Y, Z); None where they were not asked for.
    """

    v: np.ndarray
    depth: np.ndarray
    interior: np.ndarray | None = None
    exterior: np.ndarray | None = None
    point: np.ndarray | None = None


def project(camera: Camera, exterior: ArrayLike, points: ArrayLike) -> np.ndarray:
    """Measured image coordinates (..., 2) of object points, in mm, distortion included.

    Parameters
    ----------
    camera : Camera
    exterior : array_like (..., 6)
        (X0, Y0, Z0, omega, phi, kappa), in the unit of the points and radians.
    points : array_like (..., 3)
        Leading axes broadcast: (photos, 1, 6) and (n, 3) give (photos, n, 2).

    Raises
    ------
    ValueError
        If a point is not in front, or the lens has no solution.

    References
    ----------
    (M 2.18), (M 2.19), with the lens added.

    Examples
    --------
    >>> camera = Camera(50.0, x0=0.1)
    >>> project(camera, (0, 0, 1000, 0, 0, 0), [[0, 0, 0], [100, 20, 0]])
    array([[0.1, 0. ],
           [5.1, 1. ]])
    """
    _validate.instance(camera, Camera, "camera")
    exterior = _validate.points(exterior, 6, "exterior")
    points = _validate.points(points, 3, "points")
    _validate.broadcast(exterior=exterior, points=points)
    rays, _ = imaging.ray(exterior, points)
    _validate.refuse(
        rays[..., 2] >= 0,
        "points{} are not in front of the camera, which looks along its -z: check the"
        " exterior orientation (angles in radians), or leave these points out",
    )
    return measured(camera, imaging.perspective(camera.c, rays)[0])


def ideal(camera: Camera, measured: ArrayLike) -> np.ndarray:
    """Ideal coordinates (..., 2): measured ones without principal point and distortion.

    With the result (x, y) the ray of the point is (x, y, -c) in the camera's frame.

    Parameters
    ----------
    camera : Camera
    measured : array_like (..., 2)
        In mm.

    Raises
    ------
    ValueError
        If a point lies so far out that the distortion of the lens turns back.

    References
    ----------
    (M 2.51), where K has the opposite sign; (M 2.89) has this one.

    Examples
    --------
    >>> ideal(Camera(35.0, x0=0.5, K1=1e-4), [10.5, 0.0])
    array([10.1,  0. ])
    """
    _validate.instance(camera, Camera, "camera")
    reduced = _validate.points(measured, 2, "measured") - camera.interior[1:3]
    if camera.lens == "backward":
        return _displaced(camera, reduced, "measured")
    return _undistort(camera, reduced, "measured")


def measured(camera: Camera, ideal: ArrayLike) -> np.ndarray:
    """Measured coordinates (..., 2) of ideal ones: the inverse of `ideal`.

    In mm. ValueError so far out that the distortion of the lens turns back.

    Examples
    --------
    >>> measured(Camera(35.0, x0=0.5, K1=1e-4), [10.1, 0.0])
    array([10.5,  0. ])
    """
    _validate.instance(camera, Camera, "camera")
    image = _validate.points(ideal, 2, "ideal")
    if camera.lens == "backward":
        image = _undistort(camera, image, "ideal")
    else:
        image = _displaced(camera, image, "ideal")
    return image + camera.interior[1:3]


def collinearity(
    camera: Camera | np.ndarray,
    exterior: ArrayLike,
    points: ArrayLike,
    measured: ArrayLike,
    wrt: Collection[str] = BLOCKS,
    lens: str = "backward",
) -> Collinearity:
    """Misclosure of the collinearity equations, and its derivatives.

    lens "backward": v = p - (m + d(m)) with m = measured - (x0, y0);
    lens "forward": v = (x0, y0) + p + d(p) - measured;
    p is the projected point and d the distortion. Points behind the camera are not
    refused: they have a negative depth.

    Parameters
    ----------
    camera : Camera or ndarray (..., 10)
        One camera; or interior parameters that broadcast, with `lens`.
    exterior : array_like (..., 6)
        (X0, Y0, Z0, omega, phi, kappa). Hand over (photos, 1, 6) with points (n, 3)
        and measured (photos, n, 2): then each rotation is computed once.
    points : array_like (..., 3)
    measured : array_like (..., 2)
        Image coordinates as measured, in mm.
    wrt : collection of str
        The derivatives wanted: "interior", "exterior", "point". Fewer are faster.
    lens : {"backward", "forward"}
        Lens direction of an array of interior parameters; a Camera has its own.

    References
    ----------
    (M 2.20) to (M 2.29) and (B 5), (B 5a), (B 5b), with J and K for observed -
    computed; (M 2.55) for the derivatives by x0, y0, c.

    Examples
    --------
    >>> camera, exterior = Camera(50.0), (0, 0, 1000, 0, 0, 0)
    >>> result = collinearity(camera, exterior, (100, 20, 0), (5.001, 1.0))
    >>> print(result.v.round(6), result.depth)
    [-0.001  0.   ] 1000.0
    >>> result.point.round(4)
    array([[0.05 , 0.   , 0.005],
           [0.   , 0.05 , 0.001]])
    """
    exterior = _validate.points(exterior, 6, "exterior")
    points = _validate.points(points, 3, "points")
    measured = _validate.points(measured, 2, "measured")
    _validate.choice(lens, "lens", LENSES)
    if isinstance(camera, Camera):
        interior, lens = camera.interior, camera.lens
    else:
        interior = _validate.points(camera, 10, "camera")
    named = {"exterior": exterior, "points": points, "measured": measured}
    _validate.broadcast(camera=interior, **named)
    wrt = (wrt,) if isinstance(wrt, str) else tuple(_validate.several(wrt, "wrt"))
    for name in wrt:
        _validate.choice(name, "wrt", BLOCKS)
    v, depth, by = imaging.misclosure(interior, exterior, points, measured, lens, wrt)
    return Collinearity(v, depth, **by)


def _displaced(camera: Camera, image: np.ndarray, name: str) -> np.ndarray:
    lens = camera.interior[3:]
    _validate.refuse(
        imaging.beyond_fold(lens, image),
        f"{name}{{}} lie beyond the fold of the lens: so far from the principal point"
        " its distortion turns back; check K1 ... b2 and the unit (mm)",
    )
    return image + imaging.distortion(lens, image)


def _undistort(camera: Camera, image: np.ndarray, name: str) -> np.ndarray:
    x, solved = imaging.undistort(camera.interior[3:], image)
    _validate.refuse(
        ~solved,
        f"{name}{{}}: the lens displaces no point to here. So far from the principal"
        " point its distortion turns back; check K1 ... b2 and the unit (mm)",
    )
    return x
