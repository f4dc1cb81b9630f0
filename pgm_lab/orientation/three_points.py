"""Resection from three points in closed form: up to four solutions for each triple."""

import numpy as np


def solutions(
    vectors: np.ndarray, object_points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Perspective centres and rotations from which three points look as they do.

    Parameters
    ----------
    vectors : ndarray (t, 3, 3)
        For each of t triples, the unit vectors to its three image points, one a row, in
        the frame of the camera.
    object_points : ndarray (t, 3, 3)
        Its three object points, one a row.

    Returns
    -------
    centres : ndarray (k, 3)
        Perspective centres of all solutions of all triples, in object space.
    rotations : ndarray (k, 3, 3)
        Rotations M from object space into image space.

    Notes
    -----
    The three distances s1, s2 = u s1 and s3 = v s1 obey three laws of cosines.
    Eliminating s1 and u leaves an equation of degree four in v (Grunert 1841). Roots
    that noise has made a little complex count with their real part: they belong to
    double roots, at the dangerous cylinder.

    References
    ----------
    Haralick, Lee, Ottenberg and Nolle 1994, "Review and analysis of solutions of the
    three point perspective pose estimation problem", section 2.1 (Grunert).

    Examples
    --------
    >>> corners = np.array([[[-1.0, -1, 0], [1, -1, 0], [0, 1.5, 0]]])
    >>> rays = corners - [0.2, 0.1, 4.0]
    >>> rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    >>> centres, rotations = solutions(rays, corners)
    >>> bool(np.isclose(centres, [0.2, 0.1, 4.0]).all(axis=1).any())
    True
    """
    v, cosines, sides = _distance_ratios(vectors, object_points)
    triple, root = np.nonzero(np.isfinite(v) & (v > 0))
    v = v[triple, root]
    cos_a, cos_b, cos_c = cosines[:, triple]
    a2, b2, c2 = sides[:, triple]
    q = (a2 - c2) / b2
    u = (q - 1) * v**2 - 2 * q * cos_b * v + 1 + q
    with np.errstate(divide="ignore", invalid="ignore"):
        u = u / (2 * (cos_c - v * cos_a))
        s1 = np.sqrt(b2 / (1 + v**2 - 2 * v * cos_b))
    good = np.isfinite(u) & (u > 0) & np.isfinite(s1)
    s1, u, v, triple = s1[good], u[good], v[good], triple[good]
    distances = np.stack([s1, u * s1, v * s1], axis=-1)
    return _fit(distances[..., None] * vectors[triple], object_points[triple])


def _distance_ratios(vectors, points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots v = s3 / s1 (t, 4), cosines of the angles and squares of the sides (3, t)."""
    opposite = [(1, 2), (0, 2), (0, 1)]
    cosines = np.array([np.sum(vectors[:, i] * vectors[:, j], -1) for i, j in opposite])
    a2, b2, c2 = sides = np.array(
        [np.sum((points[:, i] - points[:, j]) ** 2, axis=-1) for i, j in opposite]
    )
    cos_a, cos_b, cos_c = cosines
    q, r = (a2 - c2) / b2, (a2 + c2) / b2
    A4 = (q - 1) ** 2 - 4 * c2 / b2 * cos_a**2
    A3 = 4 * (
        q * (1 - q) * cos_b - (1 - r) * cos_a * cos_c + 2 * c2 / b2 * cos_a**2 * cos_b
    )
    A2 = 2 * (
        q**2
        - 1
        + 2 * q**2 * cos_b**2
        + 2 * (b2 - c2) / b2 * cos_a**2
        - 4 * r * cos_a * cos_b * cos_c
        + 2 * (b2 - a2) / b2 * cos_c**2
    )
    A1 = 4 * (
        -q * (1 + q) * cos_b + 2 * a2 / b2 * cos_c**2 * cos_b - (1 - r) * cos_a * cos_c
    )
    A0 = (1 + q) ** 2 - 4 * a2 / b2 * cos_c**2
    roots = _roots(np.stack([A4, A3, A2, A1, A0], axis=-1))
    real = np.abs(roots.imag) < 0.1 * np.abs(roots)
    return np.where(real, roots.real, np.nan), cosines, sides


def _roots(polynomials: np.ndarray) -> np.ndarray:
    """Roots (t, 4) of polynomials (t, 5), highest power first, by companion matrices."""
    largest = np.abs(polynomials).max(axis=-1)
    leading = polynomials[:, 0]
    # A vanishing leading coefficient sends one root to infinity: nudge it, the other
    # roots hardly notice, and the adjustment that follows corrects them
    tiny = 1e-14 * largest
    leading = np.where(np.abs(leading) < tiny, tiny, leading)
    companion = np.zeros((len(polynomials), 4, 4))
    companion[:, 0] = -polynomials[:, 1:] / leading[:, None]
    companion[:, [1, 2, 3], [0, 1, 2]] = 1
    return np.linalg.eigvals(companion).astype(complex)


def _fit(camera_points, object_points) -> tuple[np.ndarray, np.ndarray]:
    """Rotate and shift triples (k, 3, 3) in the camera's frame onto object points."""
    centre_c = camera_points.mean(axis=1, keepdims=True)
    centre_o = object_points.mean(axis=1, keepdims=True)
    product = np.swapaxes(camera_points - centre_c, 1, 2) @ (object_points - centre_o)
    U, _, Vt = np.linalg.svd(product)
    U[..., -1] *= np.linalg.det(U @ Vt)[:, None]
    M = U @ Vt
    centres = centre_o[:, 0] - np.einsum("kji,kj->ki", M, centre_c[:, 0])
    return centres, M
