"""Resection from three points in closed form: up to four solutions for each triple."""

from itertools import combinations

import numpy as np

from pgm_lab import rotation

# Share of their longest extent by which points must leave a line.
ON_A_LINE = 1e-6
# Distance from the dangerous cylinder, in radii, that counts as near.
NEAR = 0.02


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


def extents(points: np.ndarray) -> np.ndarray:
    """Length, width, (depth) of a set of points (n, 2) or (n, 3), in their unit."""
    return np.linalg.svd(points - points.mean(axis=0), compute_uv=False)


def on_a_line(points: np.ndarray) -> bool:
    """Whether points (n, 3) lie on one line, or at one place."""
    length, width, _ = extents(points)
    return width <= ON_A_LINE * length


def triples(points: np.ndarray) -> np.ndarray:
    """Triples (t, 3) of up to five points that lie far apart, none on a line."""
    far = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    while len(far) < min(5, len(points)):
        gap = np.linalg.norm(points[:, None] - points[far], axis=-1).min(axis=1)
        far.append(int(np.argmax(gap)))
    triples = np.array(list(combinations(far, 3)))
    a, b, c = np.moveaxis(points[triples], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1)
    return triples[area > ON_A_LINE * area.max()]


def near_cylinder(centre: np.ndarray, object_points: np.ndarray) -> bool:
    """Whether a centre is near the upright cylinders through all triples of points.

    Through three points goes a circle, and over it stands the dangerous cylinder: a
    camera on it can move a little without a change of the three angles it sees.
    """
    a, b, c = np.moveaxis(object_points[triples(object_points)], 1, 0)
    u, v = b - a, c - a
    axis = np.cross(u, v)
    square = np.sum(axis**2, axis=-1, keepdims=True)
    uu, vv = (np.sum(w**2, axis=-1, keepdims=True) for w in (u, v))
    to_middle = (uu * np.cross(v, axis) - vv * np.cross(u, axis)) / (2 * square)
    off_axis = np.cross(centre - a - to_middle, axis)
    distance = np.linalg.norm(off_axis, axis=-1) / np.sqrt(square[:, 0])
    radius = np.linalg.norm(to_middle, axis=-1)
    # The circle of points almost on a line is so large that everything is near it
    far = np.linalg.norm(centre - a, axis=-1)
    return bool(np.all(np.abs(distance - radius) < NEAR * np.minimum(radius, far)))


def _distance_ratios(
    vectors: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roots v = s3 / s1 (t, 4), cosines (3, t) of angles, squares (3, t) of sides."""
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
    """Roots (t, 4) of polynomials (t, 5), highest power first."""
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


def _fit(
    camera_points: np.ndarray, object_points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Rotate and shift triples (k, 3, 3) in the camera's frame onto object points."""
    centre_c = camera_points.mean(axis=1, keepdims=True)
    centre_o = object_points.mean(axis=1, keepdims=True)
    product = np.swapaxes(camera_points - centre_c, 1, 2) @ (object_points - centre_o)
    M, _ = rotation.best_fit(product)
    centres = centre_o[:, 0] - np.einsum("kji,kj->ki", M, centre_c[:, 0])
    return centres, M
