"""Coplanarity: the base and the two rays of a point lie in one plane.

F = b . (u' x u''), with the base b from the left to the right station and the rays
u' = (x', y', -c') and u'' = R (x'', y'', -c''). The left photo stands at the origin
with zero angles.
"""

from dataclasses import dataclass

import numpy as np

from pgm_lab.orientation._turns import cross_matrix

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
    by_base, by_turns : ndarray (..., n, 3)
        Derivatives of the distance by the base and by small turns of the right photo.
    """

    distance: np.ndarray
    left: np.ndarray
    right: np.ndarray
    by_base: np.ndarray
    by_turns: np.ndarray


def condition(base, R, left, right) -> np.ndarray:
    """F (..., n) of (2.31) for rays left and right (n, 3) in the frames of the photos.

    Parameters
    ----------
    base : ndarray (..., 3)
        (bx, by, bz).
    R : ndarray (..., 3, 3)
        Rotation of the right photo, image to object.
    left, right : ndarray (n, 3)
        Rays (x, y, -c).

    References
    ----------
    Muliawan 2013, (2.30) to (2.35).

    Examples
    --------
    >>> left, right = np.array([[10.0, 5.0, -50.0]]), np.array([[-20.0, 5.0, -50.0]])
    >>> condition(np.array([60.0, 0.0, 0.0]), np.eye(3), left, right)
    array([0.])
    """
    return np.einsum("ni,...ij,nj->...n", left, _essential(base, R), right)


def distances(base, R, left, right) -> Coplanarity:
    """Distance of each pair of image points from the surface of coplanar ones.

    The corrections v are least in v'v under F(l + v) = 0, so they are parallel to the
    gradient of F in l + v. When a parameter p changes, the surface moves by
    dF/dp / |dF/dl| at that foot point: the derivative of the distance. Hence a
    Gauss-Markov adjustment of the distances is that of the conditions (2.37).

    Parameters
    ----------
    base : ndarray (..., 3)
        (bx, by, bz).
    R : ndarray (..., 3, 3)
        Rotation of the right photo, image to object.
    left, right : ndarray (n, 3)
        Observed rays (x, y, -c) in the frames of the photos.

    References
    ----------
    Muliawan 2013, (2.36), (2.37); Lindstrom 2010, "Triangulation made easy", CVPR, for
    the iteration to the foot point.
    """
    E = _essential(base, R)
    bend = E[..., :2, :2]  # second derivatives of F by x', y' and x'', y''
    F = np.einsum("ni,...ij,nj->...n", left, E, right)
    g1 = (right @ np.swapaxes(E, -1, -2))[..., :2]
    g2 = (left @ E)[..., :2]
    n1, n2 = g1, g2
    for _ in range(FOOT_STEPS):
        t = _way_to_surface(F, g1, g2, n1, n2, bend)[..., None]
        n1, n2 = g1 - t * (n2 @ np.swapaxes(bend, -1, -2)), g2 - t * (n1 @ bend)
    t = _way_to_surface(F, g1, g2, n1, n2, bend)
    slope = np.sqrt(np.sum(n1**2, axis=-1) + np.sum(n2**2, axis=-1))
    v1, v2 = -t[..., None] * n1, -t[..., None] * n2
    u1 = corrected(left, v1)
    u2 = corrected(right, v2) @ np.swapaxes(R, -1, -2)
    base = np.broadcast_to(base[..., None, :], u1.shape)
    distance = t * slope
    slope = np.where(slope > 0, slope, np.inf)[..., None]
    return Coplanarity(
        distance=distance,
        left=v1,
        right=v2,
        by_base=np.cross(u1, u2) / slope,
        by_turns=np.cross(u2, np.cross(base, u1)) / slope,
    )


def _essential(base, R) -> np.ndarray:
    """Matrix E with F = u' . E u'' for rays in the frames of their photos."""
    return -cross_matrix(base) @ R


def _way_to_surface(F, g1, g2, n1, n2, bend) -> np.ndarray:
    """The t nearest to zero with F(l - t n) = 0, which is quadratic in t."""
    slope = np.sum(g1 * n1, axis=-1) + np.sum(g2 * n2, axis=-1)
    curvature = np.sum((n1 @ bend) * n2, axis=-1)
    root = np.sqrt(np.maximum(slope**2 - 4 * F * curvature, 0))
    divisor = slope + root
    return 2 * F / np.where(divisor > 0, divisor, np.inf)


def corrected(rays, v) -> np.ndarray:
    """Add the corrections v (..., n, 2) to x and y of rays (n, 3)."""
    corrected = np.array(np.broadcast_to(rays, (*v.shape[:-1], 3)))
    corrected[..., :2] += v
    return corrected
