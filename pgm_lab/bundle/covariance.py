"""Covariances of a bundle adjustment, block by block.

Of the inverse of the whole normal matrix only the part of the kept unknowns, Q = S^-1,
is a full matrix. With Z = W V^-1 the rest follows for each ray and point:

    Q(kept, point) = -QZ,    Q(point, point) = V^-1 + ZᵀQZ
"""

from dataclasses import dataclass

import numpy as np

from pgm_lab.bundle._coupling import flat
from pgm_lab.bundle.datum import Motions
from pgm_lab.bundle.rays import Equations, Rays, by_photo
from pgm_lab.bundle.reduced import Reduced, times_kept, times_points


@dataclass(frozen=True)
class Cofactors:
    """Cofactors of all unknowns, as far as anybody wants to know them.

    Attributes
    ----------
    kept : ndarray (U + 6 m, U + 6 m)
        Interior and exterior orientations.
    points : ndarray (3, 3, n)
    rays : ndarray (2, k)
        Of the computed image coordinates over sigma: 1 - redundancy number. Of the
        whitened ones if x and y are correlated.
    across : ndarray (k,) or None
        Between the two of a ray, if they are correlated.
    """

    kept: np.ndarray
    points: np.ndarray
    rays: np.ndarray
    across: np.ndarray | None


def cofactors(
    rays: Rays,
    eq: Equations,
    reduced: Reduced,
    Q: np.ndarray,
    move: Motions,
    constraint: Motions | None,
) -> Cofactors:
    """Cofactors of kept unknowns, points and rays.

    Parameters
    ----------
    Q : ndarray (U + 6 m, U + 6 m)
        Any symmetric generalised inverse of S.
    move : Motions
        The motions that the observations leave free.
    constraint : Motions or None
        The inner constraints that stop them, from `datum.constraint`.
    """
    ZQZ, QZ = reduced.Z.propagate(Q)
    points = reduced.V_inverse + ZQZ
    if reduced.bars is not None:
        points, QZ = _with_bars(rays, reduced, Q, points, QZ)
    of_rays, across = _of_rays(rays, eq, eq, Q, points, QZ), None
    if rays.rho is not None:
        other = Equations(eq.A[:, ::-1])
        across = _of_rays(rays, eq, other, Q, points, QZ).mean(axis=0)
    if constraint is not None:
        Q, points = _in_datum(reduced, Q, points, move, constraint)
    return Cofactors(Q, points, of_rays, across)


def bars_redundancy(reduced: Reduced, Q: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Redundancy numbers (s,) of scale bars.

    They are 1 - (B Q Bᵀ) / sigma^2; since K^-1 = sigma^2 + B V^-1 Bᵀ, this is sigma^2
    times the diagonal of K - K FᵀQF K.
    """
    if reduced.bars is None:
        return np.zeros(0)
    K, F = reduced.bars.K, reduced.bars.F
    return sigma**2 * np.diagonal(K - K @ F.T @ Q @ F @ K)


def _with_bars(
    rays: Rays, reduced: Reduced, Q: np.ndarray, points: np.ndarray, QZ: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Put V^-1 - C K Cᵀ in the place of V^-1, and Z - F K Cᵀ in that of Z."""
    assert reduced.bars is not None
    C, K = reduced.bars.C, reduced.bars.K
    QFK = Q @ reduced.bars.F @ K
    QFK_of_rays = QFK[rays.unknowns].take(rays.photo, axis=0)
    QZ = QZ - np.einsum("kas,sik->aik", QFK_of_rays, C[..., rays.point])
    across = np.einsum("sin,sjn->ijn", times_kept(reduced, QFK), C)
    own = np.einsum("sin,st,tjn->ijn", C, K + K @ reduced.bars.F.T @ QFK, C)
    return points - own - across - across.swapaxes(0, 1), QZ


def _of_rays(
    rays: Rays,
    eq: Equations,
    other: Equations,
    Q: np.ndarray,
    points: np.ndarray,
    QZ: np.ndarray,
) -> np.ndarray:
    """Diagonal of A Q Aᵀ (2, k), or of A Q Bᵀ with other equations; in any datum."""
    of_points = points.take(rays.point, axis=-1)
    by_point = np.einsum("irk,ijk->jrk", eq.point, of_points)
    by_point -= 2 * np.einsum("ark,ajk->jrk", eq.camera, QZ)
    found = np.einsum("jrk,jrk->rk", by_point, other.point)
    own = Q.take(rays.in_N)
    for photos, some in rays.stacks:
        QA = own[photos] @ by_photo(eq.camera[..., some], photos)
        A = by_photo(other.camera[..., some], photos)
        AQA = np.einsum("pac,pac->pc", A, QA).reshape(len(A), 2, -1)
        found[:, some] += AQA.swapaxes(0, 1).reshape(2, -1)
    return found


def _in_datum(
    reduced: Reduced,
    Q: np.ndarray,
    points: np.ndarray,
    move: Motions,
    constraint: Motions,
) -> tuple[np.ndarray, np.ndarray]:
    """S-transformation of the cofactors: x - H t with the motions t = R x.

    With Q(t, x) and Q(t, t) by propagation, the new cofactors of x are
    Q - H Q(t, x) - Q(x, t) Hᵀ + H Q(t, t) Hᵀ.
    """
    R, R_points = constraint.kept, constraint.points
    H, H_points = move.kept, move.points
    lever = R - times_points(reduced, R_points)  # Q(t, kept) = lever' Q
    Q_t_kept = lever.T @ Q
    VR = np.einsum("ijn,qjn->qin", reduced.V_inverse, R_points)
    RVR = flat(VR) @ flat(R_points).T
    if (bars := reduced.bars) is not None:
        RC = flat(R_points) @ flat(bars.C).T
        RVR -= RC @ bars.K @ RC.T
        VR -= np.einsum("qs,sin->qin", RC @ bars.K, bars.C)
    Q_tt = RVR + Q_t_kept @ lever
    Q_t_points = VR - times_kept(reduced, Q_t_kept.T)

    HQ = H @ Q_t_kept
    kept = Q - HQ - HQ.T + H @ Q_tt @ H.T
    HQ = np.einsum("qin,qjn->ijn", H_points, Q_t_points)
    QH = np.einsum("qr,rjn->qjn", Q_tt, H_points)
    HQH = np.einsum("qin,qjn->ijn", H_points, QH)
    return kept, points - HQ - HQ.swapaxes(0, 1) + HQH
