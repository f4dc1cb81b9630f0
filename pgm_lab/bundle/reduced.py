"""Normal equations of a network, reduced by the points.

The points hang together only through the photos: their part V of the normal matrix
(2.90) consists of blocks of 3 x 3. Eliminated point by point they leave the reduced
normal equations of the kept unknowns, interior and exterior orientations:

    S = N - W V^-1 W',    S dx = n - W V^-1 n_p,    dx_p = V^-1 (n_p - W' dx)

Brown 1976; Triggs et al. 2000, section 6.1 (the Schur complement).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pgm_lab.adjustment import normal
from pgm_lab.bundle.rays import Equations, Rays, total, totals_of_runs

PAIRS_AT_ONCE = 5_000  # their products stay in the cache


@dataclass(frozen=True)
class Bars:
    """Scale bars B, which add B'PB to V.

    With C = V^-1 B' and F = Z B' the inverse becomes V^-1 - C K C', and W times it
    Z - F K C'.

    Attributes
    ----------
    C : ndarray (s, 3, n)
    K : ndarray (s, s)
        (P^-1 + B V^-1 B')^-1.
    F : ndarray (U + 6 m, s)
    """

    C: np.ndarray
    K: np.ndarray
    F: np.ndarray


@dataclass(frozen=True)
class Reduced:
    """Reduced normal equations; kept unknowns are U interior and 6 m exterior ones.

    Attributes
    ----------
    S : ndarray (U + 6 m, U + 6 m)
        Reduced normal matrix.
    right : ndarray (U + 6 m,)
        Its right-hand side.
    diagonal : ndarray (U + 6 m,)
        Diagonal of N, before the reduction.
    V_inverse : ndarray (3, 3, n)
        Inverse blocks of the points.
    V_diagonal : ndarray (3, n)
    n_point : ndarray (3, n)
        Right-hand sides of the points.
    Z_interior : ndarray (U, 3, n)
        W V^-1, rows of the interior.
    Z_exterior : ndarray (6, 3, k)
        W V^-1 of each ray: rows of the exterior orientation of its photo, columns of
        its point.
    bars : Bars or None
        What scale bars change.
    """

    S: np.ndarray
    right: np.ndarray
    diagonal: np.ndarray
    V_inverse: np.ndarray
    V_diagonal: np.ndarray
    n_point: np.ndarray
    Z_interior: np.ndarray
    Z_exterior: np.ndarray
    bars: "Bars | None" = None

    @property
    def determined(self) -> np.ndarray:
        """Points (n,) that their rays determine."""
        diagonal = np.einsum("iin->in", self.V_inverse)
        with np.errstate(invalid="ignore"):
            inflation = diagonal * self.V_diagonal
            return np.all(
                (inflation > 0) & (inflation < normal.INFLATION_LIMIT), axis=0
            )


def reduce(
    rays: Rays,
    eq: Equations,
    camera: np.ndarray,
    n: int,
    point_weight: np.ndarray,
    point_right: np.ndarray,
    bars: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
) -> Reduced:
    """Set up the normal equations and eliminate the points.

    Parameters
    ----------
    camera : ndarray (m,)
        Camera of each photo.
    n : int
        Number of points.
    point_weight, point_right : ndarray (3, n)
        What control points add to V and n_p; weight 1 where a coordinate is held.
    bars : tuple, optional
        Scale bars: derivatives (s, 3, n), misclosures (s,), standard deviations (s,).
    """
    u, m = len(eq.camera) - 6, len(camera)
    U = u * (camera.max() + 1)
    V = total(np.einsum("irk,jrk->ijk", eq.point, eq.point), rays.point, n)
    V[range(3), range(3)] += point_weight
    V_inverse = _inverse(V)
    n_point = -total(np.einsum("irk,rk->ik", eq.point, eq.v), rays.point, n)
    n_point += point_right

    W = np.einsum("arc,irc->aic", eq.camera, eq.point)
    W_interior = np.zeros((U, 3, n))
    for number in np.unique(camera) if u else ():
        own = np.flatnonzero(camera[rays.photo] == number)
        block = slice(u * number, u * (number + 1))
        W_interior[block] = total(W[:u, :, own], rays.point[own], n)
    Z_interior = np.einsum("ain,ijn->ajn", W_interior, V_inverse)
    W = W[u:]
    Z = np.einsum("aik,ijk->ajk", W, V_inverse.take(rays.point, axis=-1))

    S = np.zeros((U + 6 * m, U + 6 * m))
    for photo, own in enumerate(rays.photos):
        i = slice(u * camera[photo], u * (camera[photo] + 1))
        e = slice(U + 6 * photo, U + 6 * photo + 6)
        A = _flat(eq.camera[..., own])
        N, Z_own = A @ A.T, _flat(Z[..., own])
        S[i, i] += N[:u, :u]
        S[i, e] += N[:u, u:]
        S[:U, e] -= _flat(W_interior.take(rays.point[own], axis=-1)) @ Z_own.T
        S[e, e] += N[u:, u:] - _flat(W[..., own]) @ Z_own.T
    S[:U, :U] -= _flat(W_interior) @ _flat(Z_interior).T
    S[U:, U:] += _between_photos(rays, W, Z, m)
    diagonal = _by_photo(rays, np.einsum("ark,ark->ak", eq.camera, eq.camera), camera)
    right = -_by_photo(rays, np.einsum("ark,rk->ak", eq.camera, eq.v), camera)
    of_points = np.einsum("ajk,jk->ak", Z, n_point.take(rays.point, axis=-1))
    right[U:] -= total(of_points, rays.photo, m).T.ravel()
    right[:U] -= _flat(Z_interior) @ n_point.ravel()
    S = np.triu(S) + np.triu(S, 1).T
    V_diagonal = np.einsum("iin->in", V)
    reduced = Reduced(S, right, diagonal, V_inverse, V_diagonal, n_point, Z_interior, Z)
    return reduced if bars is None else _with_bars(reduced, rays, bars)


def _by_photo(rays: Rays, values: np.ndarray, camera: np.ndarray) -> np.ndarray:
    """Sum values (u + 6, k) of the rays by kept unknown: (U + 6 m,)."""
    sums = total(values, rays.photo, len(camera))
    interior = total(sums[:-6], camera, camera.max() + 1)
    return np.concatenate([interior.T.ravel(), sums[-6:].T.ravel()])


def _with_bars(reduced: Reduced, rays: Rays, bars: tuple[np.ndarray, ...]) -> Reduced:
    """Add scale bars, which join two points: V + B'PB by the Woodbury identity."""
    B, v, sigma = bars
    C = np.einsum("ijn,sjn->sin", reduced.V_inverse, B)
    K = np.linalg.inv(np.diag(sigma**2) + _flat(B) @ _flat(C).T)
    F = times_points(reduced, rays, B)
    n_bars = np.einsum("sin,s->in", B, -v / sigma**2)
    n_point = reduced.n_point + n_bars
    right = reduced.right - times_points(reduced, rays, n_bars[None])[:, 0]
    return replace(
        reduced,
        S=reduced.S + F @ K @ F.T,
        right=right + F @ K @ (_flat(C) @ n_point.ravel()),
        n_point=n_point,
        bars=Bars(C, K, F),
    )


def points_alone(reduced: Reduced) -> np.ndarray:
    """V^-1 n_p (3, n): corrections of the points if the kept unknowns stay."""
    own = np.einsum("ijn,jn->in", reduced.V_inverse, reduced.n_point)
    if (bars := reduced.bars) is not None:
        pull = bars.K @ (_flat(bars.C) @ reduced.n_point.ravel())
        own -= np.einsum("sin,s->in", bars.C, pull)
    return own


def times_kept(reduced: Reduced, rays: Rays, B: np.ndarray) -> np.ndarray:
    """(Z'B)' for a matrix B (U + 6 m, q) of the kept unknowns: (q, 3, n)."""
    Z_interior, Z = reduced.Z_interior, reduced.Z_exterior
    U, n = len(Z_interior), Z_interior.shape[-1]
    exterior = B[U:].reshape(-1, 6, B.shape[1]).transpose(2, 1, 0)
    of_rays = np.einsum("qak,ajk->qjk", exterior.take(rays.photo, axis=-1), Z)
    interior = (B[:U].T @ _flat(Z_interior)).reshape(-1, 3, n)
    product = interior + total(of_rays, rays.point, n)
    if (bars := reduced.bars) is not None:
        product -= np.einsum("sin,sq->qin", bars.C, bars.K @ bars.F.T @ B)
    return product


def times_points(reduced: Reduced, rays: Rays, R: np.ndarray) -> np.ndarray:
    """Z R' for a matrix R (q, 3, n) of the points: (U + 6 m, q)."""
    Z_interior, Z = reduced.Z_interior, reduced.Z_exterior
    interior = _flat(Z_interior) @ _flat(R).T
    own = ((_flat(Z[..., s]), _flat(R[..., rays.point[s]])) for s in rays.photos)
    product = np.concatenate([interior, *(Z_s @ R_s.T for Z_s, R_s in own)])
    if (bars := reduced.bars) is not None:
        product -= bars.F @ bars.K @ (_flat(bars.C) @ _flat(R).T)
    return product


def pairs(first: np.ndarray, second: np.ndarray) -> Iterator[tuple[np.ndarray, ...]]:
    """Pairs of rays, so few at once that what they need stays in the cache."""
    for start in range(0, len(first), PAIRS_AT_ONCE):
        some = slice(start, start + PAIRS_AT_ONCE)
        yield first[some], second[some]


def _between_photos(rays: Rays, W: np.ndarray, Z: np.ndarray, m: int) -> np.ndarray:
    """Part of S between each photo and the later ones: (6 m, 6 m)."""
    blocks = np.zeros((6, 6, m * m))
    for a, b in pairs(rays.first, rays.second):
        product = np.einsum("aip,cip->acp", W.take(a, axis=-1), Z.take(b, axis=-1))
        photos, sums = totals_of_runs(product, rays.photo[a] * m + rays.photo[b])
        blocks[..., photos] -= sums
    return blocks.reshape(6, 6, m, m).transpose(2, 0, 3, 1).reshape(6 * m, 6 * m)


def _flat(blocks: np.ndarray) -> np.ndarray:
    """Lay the last two axes of (rows, i, k) side by side."""
    rows, i, k = blocks.shape
    return blocks.reshape(rows, i * k)


def _inverse(V: np.ndarray) -> np.ndarray:
    """Inverse of symmetric matrices (3, 3, n), by cofactors; not finite if singular."""
    (a, b, c), (_, d, e), (_, _, f) = V
    cofactors = np.array(
        [
            [d * f - e * e, c * e - b * f, b * e - c * d],
            [c * e - b * f, a * f - c * c, b * c - a * e],
            [b * e - c * d, b * c - a * e, a * d - b * b],
        ]
    )
    determinant = a * cofactors[0, 0] + b * cofactors[0, 1] + c * cofactors[0, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return cofactors / determinant
