"""Covariances of a bundle adjustment, block by block.

Of the inverse of the whole normal matrix only the part of the kept unknowns, Q = S^-1,
is a full matrix. With M' = Z'Q the rest follows for each ray and point:

    Q(kept, point) = -M,    Q(point, point) = V^-1 + Z'M
"""

from dataclasses import dataclass

import numpy as np

from pgm_lab.bundle.datum import Motions
from pgm_lab.bundle.rays import Equations, Rays, total, totals_of_runs
from pgm_lab.bundle.reduced import Reduced, _flat, pairs, times_kept, times_points


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
    camera: np.ndarray,
    reduced: Reduced,
    Q: np.ndarray,
    move: Motions,
    constraint: Motions | None,
) -> Cofactors:
    """Cofactors of kept unknowns, points and rays.

    Parameters
    ----------
    camera : ndarray (m,)
        Camera of each photo.
    Q : ndarray (U + 6 m, U + 6 m)
        Any symmetric generalised inverse of S.
    move : Motions
        The motions that the observations leave free.
    constraint : Motions or None
        The inner constraints that stop them, from `datum.constraint`.
    """
    M_interior, M = _with_points(rays, reduced, Q)
    points = _points(rays, reduced, Q, M_interior, M)
    of_rays = _of_rays(rays, eq, eq, camera, Q, points, M_interior, M)
    across = None
    if rays.rho is not None:
        other = Equations(eq.v[::-1], eq.camera[:, ::-1], eq.point[:, ::-1])
        both = _of_rays(rays, eq, other, camera, Q, points, M_interior, M)
        across = both.mean(axis=0)
    if constraint is not None:
        Q, points = _transformed(rays, reduced, Q, points, move, constraint)
    return Cofactors(Q, points, of_rays, across)


def bars_redundancy(reduced: Reduced, Q: np.ndarray, sigma: np.ndarray) -> np.ndarray:
    """Redundancy numbers (s,) of scale bars.

    They are 1 - (B Q B') / sigma^2; since K^-1 = sigma^2 + B V^-1 B', this is sigma^2
    times the diagonal of K - K F'QF K.
    """
    if reduced.bars is None:
        return np.zeros(0)
    K, F = reduced.bars.K, reduced.bars.F
    return sigma**2 * np.diagonal(K - K @ F.T @ Q @ F @ K)


def _with_points(rays: Rays, reduced: Reduced, Q: np.ndarray):
    """M: rows of the interior (U, 3, n) at points, of the photo (6, 3, k) at rays."""
    Z, Z_interior = reduced.Z_exterior, reduced.Z_interior
    (U, _, n), m = Z_interior.shape, len(rays.start) - 1
    M = np.empty_like(Z)
    to_interior = np.empty((U, *Z.shape[1:]))
    for photo, own in enumerate(rays.photos):
        e = slice(U + 6 * photo, U + 6 * photo + 6)
        Z_own = _flat(Z[..., own])
        at_points = _flat(Z_interior.take(rays.point[own], axis=-1))
        M[..., own] = (Q[e, e] @ Z_own + Q[e, :U] @ at_points).reshape(6, 3, -1)
        to_interior[..., own] = (Q[:U, e] @ Z_own).reshape(U, 3, own.stop - own.start)
    M_interior = (Q[:U, :U] @ _flat(Z_interior)).reshape(Z_interior.shape)
    M_interior += total(to_interior, rays.point, n)

    between = Q[U:, U:].reshape(m, 6, m, 6).transpose(1, 3, 0, 2).reshape(36, m * m)
    for a, b in pairs(*rays.both_ways):
        Q_ab = between.take(rays.photo[a] * m + rays.photo[b], axis=-1)
        product = np.einsum("acp,cjp->ajp", Q_ab.reshape(6, 6, -1), Z.take(b, axis=-1))
        ray, sums = totals_of_runs(product, a)
        M[..., ray] += sums
    if (bars := reduced.bars) is not None:
        QFK = Q @ bars.F @ bars.K
        M_interior -= np.einsum("as,sin->ain", QFK[:U], bars.C)
        of_photos = np.take(QFK[U:].reshape(m, 6, -1), rays.photo, axis=0)
        M -= np.einsum("kas,sik->aik", of_photos, bars.C[..., rays.point])
    return M_interior, M


def _points(rays: Rays, reduced: Reduced, Q: np.ndarray, M_interior, M) -> np.ndarray:
    """Q(point, point) in the datum of Q: (3, 3, n)."""
    n = M_interior.shape[-1]
    points = reduced.V_inverse + np.einsum(
        "ain,ajn->ijn", reduced.Z_interior, M_interior
    )
    points += total(np.einsum("aik,ajk->ijk", reduced.Z_exterior, M), rays.point, n)
    if (bars := reduced.bars) is not None:
        # M holds Z - F K C' on the right; here it is put on the left too
        ZQFK = times_kept(reduced, rays, Q @ bars.F @ bars.K)
        C = bars.C
        points -= np.einsum("sin,st,tjn->ijn", C, bars.K, C)
        points -= np.einsum("sin,sjn->ijn", C, ZQFK)
    return points


def _of_rays(rays, eq, other, camera, Q, points, M_interior, M) -> np.ndarray:
    """Diagonal of A Q A' (2, k), or of A Q B' with other equations B; in any datum."""
    u = len(eq.camera) - 6
    of_point = np.einsum("irk,ijk->jrk", eq.point, points.take(rays.point, axis=-1))
    of_point -= 2 * np.einsum("ark,ajk->jrk", eq.camera[u:], M)
    found = np.einsum("jrk,jrk->rk", of_point, other.point)
    for photo, own in enumerate(rays.photos):
        interior = np.arange(u * camera[photo], u * (camera[photo] + 1))
        exterior = np.arange(6) + len(M_interior) + 6 * photo
        these = np.concatenate([interior, exterior])
        J = eq.camera[..., own]
        QJ = (Q[np.ix_(these, these)] @ _flat(J)).reshape(J.shape)
        found[:, own] += np.einsum("ark,ark->rk", other.camera[..., own], QJ)
        M_own = M_interior[interior].take(rays.point[own], axis=-1)
        A_point = other.point[..., own]
        found[:, own] -= 2 * np.einsum("ark,ajk,jrk->rk", J[:u], M_own, A_point)
    return found


def _transformed(rays, reduced, Q, points, move, constraint):
    """S-transformation of the cofactors: x - H t with the motion t = R x."""
    R, R_points, H, H_points = (
        constraint.kept,
        constraint.points,
        move.kept,
        move.points,
    )
    # Q(t, kept) = R Q(kept or point, kept), the same for t and for the points
    ZR = times_points(reduced, rays, R_points)
    lever = R - ZR
    Q_kept = lever.T @ Q
    VR = np.einsum("ijn,qjn->qin", reduced.V_inverse, R_points)
    own = _flat(VR) @ _flat(R_points).T
    if (bars := reduced.bars) is not None:
        RC = _flat(R_points) @ _flat(bars.C).T
        own -= RC @ bars.K @ RC.T
        VR -= np.einsum("qs,sin->qin", RC @ bars.K, bars.C)
    Q_tt = own + lever.T @ Q @ lever
    Q_points = VR - times_kept(reduced, rays, Q_kept.T)
    HQ = H @ Q_kept
    kept = Q - HQ - HQ.T + H @ Q_tt @ H.T
    HQ = np.einsum("qin,qjn->ijn", H_points, Q_points)
    turned = np.einsum("qr,rjn->qjn", Q_tt, H_points)
    turned = np.einsum("qin,qjn->ijn", H_points, turned)
    return kept, points - HQ - HQ.swapaxes(0, 1) + turned
