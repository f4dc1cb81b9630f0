"""What the lens does to an image: radial, decentring, affine; and how well it is known.

x, y are reduced to the principal point, in mm, and rho^2 = x^2 + y^2. The three parts
together are the displacement (dx, dy) of `pgm_lab.camera`, which says in which
direction it is applied: with lens "backward" it is a correction of what was measured.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.bundle.result import Bundle
from pgm_lab.camera import Camera

PARAMETERS_OF = {"radial": ("K1", "K2", "K3"), "decentring": ("P1", "P2")}


def radial(camera: Camera, image: ArrayLike) -> np.ndarray:
    """Radial displacement drho = K1 rho^3 + K2 rho^5 + K3 rho^7, away from the centre.

    Returns (dx, dy) = (x, y) drho / rho in mm of points (x, y) (..., 2) in mm.

    References
    ----------
    (M 2.46) to (M 2.50). As printed, (M 2.46) moves both axes by drho.

    Examples
    --------
    >>> radial(Camera(35.0, K1=1e-4), [3.0, 4.0])
    array([0.0075, 0.01  ])
    """
    xy = _validate.points(image, 2, "image")
    rho2 = np.sum(xy**2, axis=-1, keepdims=True)
    return xy * (camera.K1 * rho2 + camera.K2 * rho2**2 + camera.K3 * rho2**3)


def decentring(camera: Camera, image: ArrayLike) -> np.ndarray:
    """Displacement by lenses whose centres do not lie on one line.

    dx = P1 (rho^2 + 2 x^2) + 2 P2 x y and dy = P2 (rho^2 + 2 y^2) + 2 P1 x y.

    Returns (dx, dy) in mm of points (x, y) (..., 2) in mm.

    References
    ----------
    (M 2.52).

    Examples
    --------
    >>> decentring(Camera(35.0, P1=1e-4), [3.0, 4.0])
    array([0.0043, 0.0024])
    """
    x, y = np.moveaxis(_validate.points(image, 2, "image"), -1, 0)
    rho2, P1, P2 = x**2 + y**2, camera.P1, camera.P2
    dx = P1 * (rho2 + 2 * x**2) + 2 * P2 * x * y
    dy = P2 * (rho2 + 2 * y**2) + 2 * P1 * x * y
    return np.stack([dx, dy], axis=-1)


def affinity(camera: Camera, image: ArrayLike) -> np.ndarray:
    """Displacement by axes of unequal scale that are not square: dx = b1 x + b2 y.

    Returns (dx, 0) in mm of points (x, y) (..., 2) in mm.

    References
    ----------
    (M 2.54).

    Examples
    --------
    >>> affinity(Camera(35.0, b1=1e-3, b2=2e-3), [3.0, 4.0])
    array([0.011, 0.   ])
    """
    x, y = np.moveaxis(_validate.points(image, 2, "image"), -1, 0)
    return np.stack([camera.b1 * x + camera.b2 * y, np.zeros_like(x)], axis=-1)


def profile(
    result: Bundle, rho: ArrayLike, kind: str = "radial", camera: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Distortion at a radius, and its standard deviation from all covariances.

    Parameters
    ----------
    result : bundle.Bundle
    rho : array_like (n,)
        Distance from the principal point, in mm.
    kind : {"radial", "decentring"}
        K1 rho^3 + K2 rho^5 + K3 rho^7, or sqrt(P1^2 + P2^2) rho^2: the displacement
        at right angles to the axis of the decentring, three times on it.
    camera : int
        Index of the camera.

    Returns
    -------
    distortion, sd : ndarray (n,)
        In mm. What was not estimated counts as free of error.

    References
    ----------
    (M 2.47), (M 2.52); Brown 1971, "Close-range camera calibration", for the
    decentring.

    Examples
    --------
    >>> from pgm_lab import bundle, datasets
    >>> d = datasets.muliawan2013()
    >>> start = Camera(*d.interior), d.exteriors, d.object_points
    >>> network = bundle.Network(*start, d.photo, d.point, d.xy, d.sigma)
    >>> distortion, sd = profile(bundle.adjust(network), [10.0])
    >>> print(f"{1000 * distortion[0]:.1f} +- {1000 * sd[0]:.1f} micrometres")
    8.5 +- 1.1 micrometres
    """
    _validate.instance(result, Bundle, "result")
    camera = _validate.whole(camera, "camera", 0, len(result.cameras) - 1)
    names = PARAMETERS_OF[_validate.choice(kind, "kind", tuple(PARAMETERS_OF))]
    rho = _validate.of_shape(rho, (None,), "rho")[:, None]
    lens = result.cameras[camera]
    if kind == "radial":
        by_parameters = rho ** (3, 5, 7)
        distortion = by_parameters @ [lens.K1, lens.K2, lens.K3]
    else:
        P = np.array([lens.P1, lens.P2])
        size = np.hypot(*P)
        direction = P / size if size else np.zeros(2)
        by_parameters = rho**2 * direction
        distortion = size * rho[:, 0] ** 2
    place = places(result, camera)
    kept = [i for i, name in enumerate(names) if name in place]
    rows = [place[names[i]] for i in kept]
    J, C = by_parameters[:, kept], result.covariance_interior[np.ix_(rows, rows)]
    return distortion, np.sqrt(np.einsum("ni,ij,nj->n", J, C, J))


def places(result: Bundle, camera: int) -> dict[str, int]:
    """Row of each estimated interior parameter of a camera in the covariance."""
    return {
        one.parameter: i
        for i, one in enumerate(result.unknowns)
        if (one.kind, one.owner) == ("camera", camera + 1)
    }
