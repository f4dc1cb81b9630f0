"""The adjustment of a network as the textbook has it: all unknowns in one matrix.

In the order of (M 2.90) they are the exterior orientations, the interior parameters,
the points; seven multipliers follow, one for each inner constraint (M 2.94). A network
of 9 photos and 50 points has a matrix with 221 rows. `bundle.adjust` solves the same
equations with the points eliminated, and is for measuring.
"""

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.camera import BLOCKS, imaging

# (omega, phi, kappa, X0, Y0, Z0), the order of (M 2.87); the same indices lead back
ANGLES_FIRST = [3, 4, 5, 0, 1, 2]


def derivatives(
    interior: np.ndarray,
    exteriors: np.ndarray,
    points: np.ndarray,
    photo: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    lens: str = "backward",
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Misclosure of each ray, and its derivatives by the unknowns it depends on.

    Parameters
    ----------
    interior : ndarray (10,) or (m, 10)
        `camera.PARAMETERS` of all photos, or of each.
    exteriors, points : ndarray (m, 6), (n, 3)
        (X0, Y0, Z0, omega, phi, kappa) and (X, Y, Z).
    photo, point : ndarray (k,) of int
        Photo and point of each ray.
    xy : ndarray (k, 2)
        As measured, in mm.
    lens : {"backward", "forward"}

    Returns
    -------
    v : ndarray (k, 2)
        Computed - observed, in mm: -f of (M 2.86).
    A1, A3, A2 : ndarray (k, 2, 6), (k, 2, 10), (k, 2, 3)
        By (omega, phi, kappa, X0, Y0, Z0), by `camera.PARAMETERS`, by (X, Y, Z).

    References
    ----------
    Muliawan 2013, (M 2.81) to (M 2.89); (M 2.84) and (M 2.89) are corrected.
    """
    exteriors = _validate.of_shape(exteriors, (None, 6), "exteriors")
    points = _validate.of_shape(points, (None, 3), "points")
    photo = _validate.indices(photo, len(exteriors), "photo")
    point = _validate.indices(point, len(points), "point", len(photo))
    xy = _validate.of_shape(xy, (len(photo), 2), "xy")
    interior = _validate.points(interior, 10, "interior")
    interior = interior if interior.ndim == 1 else interior[photo]
    v, _, by = imaging.misclosure(
        interior, exteriors[photo], points[point], xy, lens, BLOCKS
    )
    return v, by["exterior"][..., ANGLES_FIRST], by["interior"], by["point"]


def design(
    A1: np.ndarray,
    A3: np.ndarray,
    A2: np.ndarray,
    photo: np.ndarray,
    point: np.ndarray,
    m: int,
    n: int,
    camera: ArrayLike = 0,
) -> np.ndarray:
    """Design matrix A of v + A1 d1 + A2 d2 + A3 d3 = f, two rows a ray.

    Parameters
    ----------
    A1, A3, A2 : ndarray (k, 2, 6), (k, 2, u), (k, 2, 3)
        Of each ray, as from `derivatives`.
    photo, point : ndarray (k,) of int
        Photo and point of each ray.
    m, n : int
        Numbers of photos and points.
    camera : array_like (m,) of int
        The camera of each photo, if there are several.

    Returns
    -------
    ndarray (2 k, 6 m + u + 3 n)
        Columns of the photos, the camera, the points; u for each of several cameras.

    References
    ----------
    Muliawan 2013, (M 2.78).

    Examples
    --------
    >>> A1, A3, A2 = np.ones((3, 2, 6)), np.ones((3, 2, 10)), np.ones((3, 2, 3))
    >>> A = design(A1, A3, A2, np.array([0, 0, 1]), np.array([0, 1, 1]), 2, 2)
    >>> A.shape, int(A.sum())
    ((6, 28), 114)
    """
    A1 = _validate.of_shape(A1, (None, 2, 6), "A1")
    A3 = _validate.of_shape(A3, (len(A1), 2, None), "A3")
    A2 = _validate.of_shape(A2, (len(A1), 2, 3), "A2")
    photo = _validate.indices(photo, m, "photo", len(A1))
    point = _validate.indices(point, n, "point", len(A1))
    camera = np.broadcast_to(camera, m)
    k, u, cameras = len(photo), A3.shape[-1], camera.max() + 1
    A = np.zeros((k, 2, 6 * m + u * cameras + 3 * n))
    for block, first in (
        (A1, 6 * photo),
        (A3, 6 * m + u * camera[photo]),
        (A2, 6 * m + u * cameras + 3 * point),
    ):
        columns = first[:, None, None] + np.arange(block.shape[-1])
        np.put_along_axis(A, columns, block, axis=-1)
    return A.reshape(2 * k, -1)


def normal_matrix(A: np.ndarray, sigma: ArrayLike) -> np.ndarray:
    """Normal matrix AᵀPA with P = 1 / sigma^2; singular without a datum.

    A is (2 k, u), sigma the standard deviation of each row, in mm, or of all.

    References
    ----------
    Muliawan 2013, (M 2.90), with the blocks (M 2.91) and (M 2.93); (M 2.70).
    """
    sigma = _validate.positive(sigma, "sigma", "mm")
    weighted = A / np.broadcast_to(sigma, len(A))[:, None]
    return weighted.T @ weighted


def G(points: np.ndarray) -> np.ndarray:
    """Shifts, rotations and scale of the points about the origin: inner constraints.

    A network moved along a column of G, its cameras with it, has the same images.

    (3 n, 7) of points (n, 3): three shifts, three rotations about X, Y, Z, the scale.

    References
    ----------
    Muliawan 2013, (M 2.95).

    Examples
    --------
    >>> G(np.array([[1.0, 2.0, 3.0]]))
    array([[ 1.,  0.,  0.,  0.,  3., -2.,  1.],
           [ 0.,  1.,  0., -3.,  0.,  1.,  2.],
           [ 0.,  0.,  1.,  2., -1.,  0.,  3.]])
    """
    points = _validate.of_shape(points, (None, 3), "points")
    X, Y, Z = points.T
    rows = np.zeros((len(points), 3, 7))
    rows[:, 0, 0] = rows[:, 1, 1] = rows[:, 2, 2] = 1
    rows[:, 0, 4], rows[:, 0, 5], rows[:, 0, 6] = Z, -Y, X
    rows[:, 1, 3], rows[:, 1, 5], rows[:, 1, 6] = -Z, X, Y
    rows[:, 2, 3], rows[:, 2, 4], rows[:, 2, 6] = Y, -X, Z
    return rows.reshape(-1, 7) + 0.0  # no zero printed as -0


def bordered(N: np.ndarray, G: np.ndarray) -> np.ndarray:
    """Border N (u, u) by inner constraints G (3 n, 7) on its last unknowns, the points.

    The matrix (u + 7, u + 7) is regular, if nothing but the datum is missing.

    References
    ----------
    Muliawan 2013, (M 2.94).
    """
    border = np.zeros((len(N), G.shape[1]))
    border[-len(G) :] = G
    return np.block([[N, border], [border.T, np.zeros((G.shape[1],) * 2)]])


def scaled(N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bring a bordered N to columns of one size: the matrix N s sᵀ, and s.

    The unknowns get ones on the diagonal, the columns of G the length one.
    """
    s = np.ones(len(N))
    s[:-7] = 1 / np.sqrt(np.diagonal(N)[:-7])
    s[-7:] = 1 / np.linalg.norm(s[:-7, None] * N[:-7, -7:], axis=0)
    return N * s * s[:, None], s


def inverse(N: np.ndarray) -> np.ndarray:
    """Invert a bordered N, scaled first: its upper left block holds the cofactors."""
    balanced, s = scaled(N)
    try:
        return np.linalg.inv(balanced) * s * s[:, None]
    except np.linalg.LinAlgError:
        raise ValueError("N is singular: it leaves an unknown undetermined") from None


def solve(N: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corrections of the unknowns and their cofactors from a bordered N.

    Parameters
    ----------
    N : ndarray (u + 7, u + 7)
        As from `bordered`.
    t : ndarray (u,)
        Right-hand side -AᵀPv.

    Returns
    -------
    delta : ndarray (u,)
        To be added to the unknowns, (M 2.79).
    Q : ndarray (u, u)
        Cofactors; covariances are sigma0^2 Q, (M 2.92).

    References
    ----------
    Muliawan 2013, (M 2.79), (M 2.92), (M 2.94).
    """
    Q = inverse(N)[:-7, :-7]
    return Q @ t, Q
