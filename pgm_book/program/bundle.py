"""Bundle adjustment in some thirty lines, as lesson 6 writes it: to be read.

`pgm_lab.bundle` does the same for any network and datum, and says what went wrong.
"""

from collections.abc import Sequence

import numpy as np

from pgm_book.program.camera import derivatives, project

Blocks = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]

MAX_ITERATIONS = 20
UNDETERMINED = (
    "the rays of photo, point and xy do not determine all unknowns: a point needs two"
    " rays, a camera several photos from different sides"
)


def without_lens(xy: np.ndarray, camera: Sequence | np.ndarray) -> np.ndarray:
    """Image points corrected for lens distortion, from the principal point.

    Parameters
    ----------
    xy : array_like (n, 2)
        Measured image points, mm.
    camera : array_like (10,)
        c, x0, y0 (mm), K1, K2, K3, P1, P2, b1, b2.

    Returns
    -------
    ndarray (n, 2)
        Ideal image points in mm: reduced to the principal point and corrected.

    References
    ----------
    Muliawan 2013, (M 2.89), with the signs of the Australis program.

    Examples
    --------
    >>> without_lens([[10.0, 0]], [35, 0, 0, 1e-5, 0, 0, 0, 0, 0, 0])
    array([[10.01,  0.  ]])
    """
    xy = np.asarray(xy, float)
    _, x0, y0, K1, K2, K3, P1, P2, b1, b2 = camera
    x, y = xy[:, 0] - x0, xy[:, 1] - y0
    rho2 = x**2 + y**2
    radial = K1 * rho2 + K2 * rho2**2 + K3 * rho2**3
    dx = x * radial + P1 * (rho2 + 2 * x**2) + 2 * P2 * x * y + b1 * x + b2 * y
    dy = y * radial + P2 * (rho2 + 2 * y**2) + 2 * P1 * x * y
    return np.column_stack([x + dx, y + dy])


def misclosure(unknowns: np.ndarray, points: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Computed minus observed image points (n, 2) of one photo, in mm.

    Parameters
    ----------
    unknowns : array_like (19,)
        Camera (10), exterior orientation (6), and a shift (3) of all points.
    points : array_like (n, 3)
        Object points.
    xy : array_like (n, 2)
        Measured image points, mm.

    References
    ----------
    Muliawan 2013, (M 2.20), (M 2.21) and (M 2.78).
    """
    camera, exterior, shift = np.split(np.asarray(unknowns, float), [10, 16])
    return project(exterior, points + shift, camera[0]) - without_lens(xy, camera)


def blocks(
    photo: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    sigma: float,
    camera: np.ndarray,
    exteriors: np.ndarray,
    points: np.ndarray,
) -> Blocks:
    """Blocks of the normal equations of all rays.

    Parameters
    ----------
    photo, point : array_like (k,) of int
        Photo and point of each ray, from 0.
    xy : array_like (k, 2)
        Image points, mm.
    sigma : float
        Standard deviation of an image coordinate, mm.
    camera, exteriors, points : array_like (10,), (m, 6), (n, 3)
        Current values.

    Returns
    -------
    K : ndarray (q, q)
        Camera and photos, q = 10 + 6 m.
    E : ndarray (n, q, 3)
        The coupling of these with each point.
    V : ndarray (n, 3, 3)
        The points.
    f, g : ndarray (q,), (n, 3)
        Right-hand sides, of camera and photos and of the points.
    v : ndarray (k, 2)
        Computed minus observed, divided by sigma.

    References
    ----------
    Muliawan 2013, (M 2.90), the points last instead of the camera.
    """
    photo, point, xy = np.asarray(photo), np.asarray(point), np.asarray(xy, float)
    points = np.asarray(points, float)
    q, n = 10 + 6 * len(exteriors), len(points)
    K, E, V = np.zeros((q, q)), np.zeros((n, q, 3)), np.zeros((n, 3, 3))
    f, g, v = np.zeros(q), np.zeros((n, 3)), np.zeros(xy.shape)
    for i, exterior in enumerate(exteriors):
        rays, own = photo == i, np.r_[:10, 10 + 6 * i : 16 + 6 * i]
        j = point[rays]

        def ray(
            u: np.ndarray, j: np.ndarray = j, rays: np.ndarray = rays
        ) -> np.ndarray:
            return misclosure(u, points[j], xy[rays]) / sigma

        at = np.concatenate([camera, exterior, np.zeros(3)])
        v[rays] = ray(at)
        A, B = np.split(derivatives(ray, at).reshape(-1, 2, 19), [16], axis=2)
        K[np.ix_(own, own)] += np.sum(A.swapaxes(1, 2) @ A, axis=0)
        f[own] += np.einsum("nij,ni->j", A, v[rays])
        np.add.at(E, np.ix_(j, own), A.swapaxes(1, 2) @ B)
        np.add.at(V, j, B.swapaxes(1, 2) @ B)
        np.add.at(g, j, np.einsum("nij,ni->nj", B, v[rays]))
    return K, E, V, f, g, v


def reduced(K: np.ndarray, E: np.ndarray, V: np.ndarray) -> np.ndarray:
    """Normal equations (q, q) of camera and photos after elimination of the points.

    `K` (q, q), `E` (n, q, 3) and `V` (n, 3, 3) are those of `blocks`.

    Examples
    --------
    >>> reduced([[5.0]], [[[1.0, 0, 0]]], [np.eye(3)])
    array([[4.]])
    """
    E = np.asarray(E, float)
    return K - np.sum(E @ _inverse(V) @ E.swapaxes(1, 2), axis=0)


def adjust(
    photo: np.ndarray,
    point: np.ndarray,
    xy: np.ndarray,
    sigma: float,
    camera: np.ndarray,
    exteriors: np.ndarray,
    points: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """Adjust camera, photos and points together; photo 0 and one coordinate are held.

    Parameters
    ----------
    photo, point, xy, sigma, camera, exteriors, points
        As for `blocks`, the last three as start values.

    Returns
    -------
    camera : ndarray (10,)
        Adjusted.
    C : ndarray (10, 10)
        Its covariance.
    sigma0 : float
        Of the residuals divided by `sigma`.
    points : ndarray (n, 3)
        Adjusted, in the datum of the first photo.

    Raises
    ------
    ValueError
        If the rays do not determine the camera, or the iteration does not converge.

    References
    ----------
    Muliawan 2013, (M 2.69) to (M 2.93), with another datum.
    """
    camera, exteriors = np.asarray(camera, float), np.asarray(exteriors, float)
    ground = np.asarray(points, float)
    # Datum: the first photo, and the coordinate of a station farthest from it
    away = np.abs(exteriors[:, :3] - exteriors[:1, :3])
    held = [*range(10, 16), 10 + 6 * (away.argmax() // 3) + away.argmax() % 3]
    free = np.setdiff1d(np.arange(10 + 6 * len(exteriors)), held)
    redundancy = np.size(xy) - len(free) - ground.size
    if redundancy < 1:
        raise ValueError("as many unknowns as observations, or more: add rays")
    for _ in range(MAX_ITERATIONS):
        K, E, V, f, g, v = blocks(photo, point, xy, sigma, camera, exteriors, ground)
        # Eliminate the points; unit diagonals bring all numbers to a similar size
        back = _inverse(V)
        S = reduced(K, E, V)[np.ix_(free, free)]
        s = f - np.einsum("nqa,nab,nb->q", E, back, g)
        if not np.all(np.diag(S) > 0):
            raise ValueError(UNDETERMINED)
        size = np.sqrt(np.diag(S))
        Q = _inverse(S / np.outer(size, size)) / np.outer(size, size)
        if not np.all(np.diag(Q) > 0):
            raise ValueError(UNDETERMINED)
        # Step of camera and photos, then of the points
        step = np.zeros(len(K))
        step[free] = -Q @ s[free]
        camera, exteriors = camera + step[:10], exteriors + step[10:].reshape(-1, 6)
        rest = g + np.einsum("nqa,q->na", E, step)
        ground = ground - np.einsum("nab,nb->na", back, rest)
        if np.all(np.abs(step[free]) < 1e-3 * np.sqrt(np.diag(Q))):
            sigma0 = float(np.sqrt(np.sum(v**2) / redundancy))
            return camera, sigma0**2 * Q[:10, :10], sigma0, ground
    raise ValueError(
        f"not converged after {MAX_ITERATIONS} iterations: better start values may help"
    )


def _inverse(matrices: np.ndarray) -> np.ndarray:
    """The inverse, or an error that says why there is none."""
    try:
        return np.linalg.inv(matrices)
    except np.linalg.LinAlgError:
        raise ValueError(UNDETERMINED) from None
