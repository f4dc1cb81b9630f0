"""Coplanarity: the base and the two rays of a point lie in one plane.

F = b . (u' x u''), with the base b from the left to the right station and the rays
u' = (x', y', -c') and u'' = R (x'', y'', -c''). The left photo stands at the origin
with zero angles; R is the rotation of the right one, image to object.

All functions take stacks of models: bases (..., 3) and rotations (..., 3, 3).
"""

from dataclasses import dataclass

import numpy as np

from pgm_lab.orientation._common import cross_matrix

# Each step shrinks the error of a foot point by |v| / c or faster: eight leave nothing
# of residuals of a hundredth of the image.
FOOT_STEPS = 8


@dataclass(frozen=True)
class Coplanarity:
    """Distance of observed image points from coplanarity, for stacks (...) of models.

    Attributes
    ----------
    distance : ndarray (..., n)
        Signed distance of (x', y', x'', y'') from the surface F = 0, in mm: what the
        smallest corrections that make the rays meet amount to.
    left, right : ndarray (..., n, 2)
        These corrections v', v''.
    by_base, by_rotation : ndarray (..., n, 3)
        Derivatives of the distance by the base and by small rotations of the right
        photo.
    """

    distance: np.ndarray
    left: np.ndarray
    right: np.ndarray
    by_base: np.ndarray
    by_rotation: np.ndarray


def condition(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray
) -> np.ndarray:
    """F (..., n) of (M 2.31), the determinant of base and rays, for rays (n, 3).

    Zero where they are coplanar: (M 2.30) to (M 2.35).

    Examples
    --------
    >>> left, right = np.array([[10.0, 5.0, -50.0]]), np.array([[-20.0, 5.0, -50.0]])
    >>> condition(np.array([60.0, 0.0, 0.0]), np.eye(3), left, right)
    array([0.])
    """
    return np.einsum("ni,...ij,nj->...n", left, _essential(base, R), right)


def by_image(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of F by (x', y') and by (x'', y''), (..., n, 2): A in (M 2.37).

    F is linear in each ray. By x'' it is the determinant of the base, the left ray and
    (m11, m12, m13) of the right photo, and so on: (M 2.36), (M 2.38) to (M 2.40).

    Examples
    --------
    >>> left, right = np.array([[10.0, 5.0, -50.0]]), np.array([[-20.0, 5.0, -50.0]])
    >>> by_image(np.array([60.0, 0.0, 0.0]), np.eye(3), left, right)[1]
    array([[   0., 3000.]])
    """
    E = _essential(base, R)
    by_left = right @ np.swapaxes(E, -1, -2)
    by_right = left @ E
    return by_left[..., :2], by_right[..., :2]


def by_orientation(
    base: np.ndarray, u1: np.ndarray, u2: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of F by base and small rotations of the right photo: B in (M 2.37).

    For rays u' and u'' (..., n, 3) in object space: u' x u'' by the base. A small
    rotation psi moves u'' by psi x u'' and so F by psi . (u'' x (b x u')). Omega
    rotates about X at any attitude, phi and kappa about `_common.axes`:
    (M 2.36), (M 2.41) to (M 2.45).

    Examples
    --------
    >>> u1, u2 = np.array([[10.0, 5.0, -50.0]]), np.array([[-20.0, 5.0, -50.0]])
    >>> by_orientation(np.array([60.0, 0.0, 0.0]), u1, u2)[0]
    array([[   0., 1500.,  150.]])
    """
    b = np.broadcast_to(base[..., None, :], u1.shape)
    return np.cross(u1, u2), np.cross(u2, np.cross(b, u1))


def distances(
    base: np.ndarray, R: np.ndarray, left: np.ndarray, right: np.ndarray
) -> Coplanarity:
    """Distance of each pair of image points from the surface of coplanar ones.

    The least corrections v under F(l + v) = 0 are parallel to the gradient of F in l +
    v. A parameter p moves the surface there by dF/dp / |dF/dl|, the derivative of the
    distance: to adjust the distances is to adjust the conditions (M 2.37), which need
    -F on the right. Iteration to the foot point: Lindstrom 2010, "Triangulation made
    easy".

    Examples
    --------
    >>> left, right = np.array([[10.0, 5.0, -50.0]]), np.array([[-20.0, 5.2, -50.0]])
    >>> found = distances(np.array([60.0, 0.0, 0.0]), np.eye(3), left, right)
    >>> found.left[:, 1].round(6), found.right[:, 1].round(6)
    (array([0.1]), array([-0.1]))
    """
    F = condition(base, R, left, right)
    g1, g2 = by_image(base, R, left, right)
    bend = _essential(base, R)[..., :2, :2]  # second derivatives by x', y' and x'', y''

    # Iterate to the foot point l - t n, n being the gradient there
    n1, n2 = g1, g2
    t = _way_to_surface(F, g1, g2, n1, n2, bend)
    for _ in range(FOOT_STEPS):
        T, last = t[..., None], t
        n1, n2 = g1 - T * (n2 @ np.swapaxes(bend, -1, -2)), g2 - T * (n1 @ bend)
        t = _way_to_surface(F, g1, g2, n1, n2, bend)
        if np.array_equal(t, last):
            break  # further steps would change nothing

    # Distance, and its derivatives at the foot point
    slope = np.sqrt(np.sum(n1**2, axis=-1) + np.sum(n2**2, axis=-1))
    v1, v2 = -t[..., None] * n1, -t[..., None] * n2
    u1 = corrected(left, v1)
    u2 = corrected(right, v2) @ np.swapaxes(R, -1, -2)
    by_base, by_rotation = by_orientation(base, u1, u2)
    per_slope = np.where(slope > 0, slope, np.inf)[..., None]
    return Coplanarity(t * slope, v1, v2, by_base / per_slope, by_rotation / per_slope)


def corrected(rays: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Add the corrections v (..., n, 2) to x and y of rays (n, 3)."""
    corrected = np.array(np.broadcast_to(rays, (*v.shape[:-1], 3)))
    corrected[..., :2] += v
    return corrected


def _essential(base: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Matrix E with F = u' . E u'' for rays in the frames of their photos."""
    return -cross_matrix(base) @ R


def _way_to_surface(
    F: np.ndarray,
    g1: np.ndarray,
    g2: np.ndarray,
    n1: np.ndarray,
    n2: np.ndarray,
    bend: np.ndarray,
) -> np.ndarray:
    """The t nearest to zero with F(l - t n) = 0, which is quadratic in t."""
    slope = np.sum(g1 * n1, axis=-1) + np.sum(g2 * n2, axis=-1)
    curvature = np.sum((n1 @ bend) * n2, axis=-1)
    root = np.sqrt(np.maximum(slope**2 - 4 * F * curvature, 0))
    divisor = slope + root
    return 2 * F / np.where(divisor > 0, divisor, np.inf)
