"""Normal equations of a network, reduced by the points.

The points hang together only through the photos: their part V of the normal matrix
(M 2.90) consists of blocks of 3 x 3. Eliminated point by point they leave the reduced
normal equations of the kept unknowns, interior and exterior orientations:

    S = N - W V^-1 Wᵀ,    S dx = n - W V^-1 n_p,    dx_p = V^-1 (n_p - Wᵀ dx)

Brown 1976; Triggs et al. 2000, section 6.1 (the Schur complement).
"""

from dataclasses import dataclass, replace

import numpy as np

from pgm_lab.adjustment import normal
from pgm_lab.bundle._coupling import Coupling, couple, flat
from pgm_lab.bundle.rays import Equations, Rays, by_photo


@dataclass(frozen=True)
class Bars:
    """Scale bars B, which add BᵀPB to V.

    With C = V^-1 Bᵀ and F = Z Bᵀ the inverse becomes V^-1 - C K Cᵀ, and W times it
    Z - F K Cᵀ.

    Attributes
    ----------
    C : ndarray (s, 3, n)
    K : ndarray (s, s)
        (P^-1 + B V^-1 Bᵀ)^-1.
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
    Z : Coupling
        W V^-1, without scale bars.
    bars : Bars or None
        What scale bars change.
    """

    S: np.ndarray
    right: np.ndarray
    diagonal: np.ndarray
    V_inverse: np.ndarray
    V_diagonal: np.ndarray
    n_point: np.ndarray
    Z: Coupling
    bars: Bars | None = None

    @property
    def determined(self) -> np.ndarray:
        """Points (n,) that their rays determine."""
        diagonal = _diagonal(self.V_inverse)
        with np.errstate(invalid="ignore"):
            inflation = diagonal * self.V_diagonal
            return np.all(
                (inflation > 0) & (inflation < normal.INFLATION_LIMIT), axis=0
            )


def reduce(
    rays: Rays,
    eq: Equations,
    point_weight: np.ndarray,
    point_right: np.ndarray,
    bars: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
) -> Reduced:
    """Set up the normal equations and eliminate the points.

    Parameters
    ----------
    point_weight, point_right : ndarray (3, n)
        What control points add to V and n_p; weight 1 where a coordinate is held.
    bars : tuple, optional
        Scale bars: derivatives (s, 3, n), misclosures (s,), standard deviations (s,).
    """
    N, n_kept = _of_photos(rays, eq)
    W = np.einsum("arc,irc->aic", eq.A[:6], eq.point)
    sums = rays.total_by_camera(np.einsum("arc,irc->aic", eq.A[6:], eq.point))
    V, n_point = sums[-3:].sum(axis=-2), point_right - sums[-4].sum(axis=-2)
    V_diagonal = _diagonal(V)
    V_diagonal += point_weight
    V_inverse = _inverse(V)
    Z = couple(rays, W, sums[:-4], V_inverse)
    reduced = Reduced(
        S=N - Z.times_W,
        right=n_kept - Z.times_points(n_point[None])[:, 0],
        diagonal=np.diagonal(N),
        V_inverse=V_inverse,
        V_diagonal=V_diagonal,
        n_point=n_point,
        Z=Z,
    )
    return reduced if bars is None else _with_bars(reduced, bars)


def _of_photos(rays: Rays, eq: Equations) -> tuple[np.ndarray, np.ndarray]:
    """Part N and n of the kept unknowns: first photo by photo, then added up."""
    blocks = np.empty((*rays.unknowns.shape, len(eq.A) - 3))
    for photos, own in rays.stacks:
        A = by_photo(eq.A[:-3, :, own], photos)
        np.matmul(A[:, :-1], A.swapaxes(1, 2), out=blocks[photos])
    u = rays.kept
    N = np.bincount(rays.in_N.ravel(), blocks[..., :-1].ravel(), u * u).reshape(u, u)
    return N, -np.bincount(rays.unknowns.ravel(), blocks[..., -1].ravel(), u)


def _with_bars(reduced: Reduced, bars: tuple[np.ndarray, ...]) -> Reduced:
    """Add scale bars, which join two points: V + BᵀPB by the Woodbury identity."""
    B, v, sigma = bars
    C = np.einsum("ijn,sjn->sin", reduced.V_inverse, B)
    K = np.linalg.inv(np.diag(sigma**2) + flat(B) @ flat(C).T)
    F = times_points(reduced, B)
    n_bars = np.einsum("sin,s->in", B, -v / sigma**2)
    n_point = reduced.n_point + n_bars
    right = reduced.right - times_points(reduced, n_bars[None])[:, 0]
    return replace(
        reduced,
        S=reduced.S + F @ K @ F.T,
        right=right + F @ K @ (flat(C) @ n_point.ravel()),
        n_point=n_point,
        bars=Bars(C, K, F),
    )


def points_alone(reduced: Reduced) -> np.ndarray:
    """V^-1 n_p (3, n): corrections of the points if the kept unknowns stay."""
    own = np.einsum("ijn,jn->in", reduced.V_inverse, reduced.n_point)
    if (bars := reduced.bars) is not None:
        pull = bars.K @ (flat(bars.C) @ reduced.n_point.ravel())
        own -= np.einsum("sin,s->in", bars.C, pull)
    return own


def times_kept(reduced: Reduced, B: np.ndarray) -> np.ndarray:
    """(ZᵀB)' for a matrix B (U + 6 m, q) of the kept unknowns: (q, 3, n)."""
    product = reduced.Z.times_kept(B)
    if (bars := reduced.bars) is not None:
        product -= np.einsum("sin,sq->qin", bars.C, bars.K @ bars.F.T @ B)
    return product


def times_points(reduced: Reduced, R: np.ndarray) -> np.ndarray:
    """Z Rᵀ for a matrix R (q, 3, n) of the points: (U + 6 m, q)."""
    product = reduced.Z.times_points(R)
    if (bars := reduced.bars) is not None:
        product -= bars.F @ bars.K @ (flat(bars.C) @ flat(R).T)
    return product


def _inverse(V: np.ndarray) -> np.ndarray:
    """Inverse of symmetric matrices (3, 3, n), by cofactors; not finite if singular."""
    (a, b, c), (_, d, e), (_, _, f) = V
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    D, E, F = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * A + b * B + c * C
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.array([[A, B, C], [B, D, E], [C, E, F]]) / determinant


def _diagonal(blocks: np.ndarray) -> np.ndarray:
    """View (3, n) of the diagonals of blocks (3, 3, n)."""
    return np.einsum("iin->in", blocks)
