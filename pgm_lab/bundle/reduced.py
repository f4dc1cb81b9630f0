"""Normal equations of a network, reduced by the points: the Schur complement.

The points hang together only through the photos: their part V of the normal matrix
(M 2.90) consists of blocks of 3 x 3. Eliminated point by point they leave the reduced
normal equations of the kept unknowns, interior and exterior orientations:

    S = N - W V^-1 Wᵀ,    S dx = n - W V^-1 n_p,    dx_p = V^-1 (n_p - Wᵀ dx)

Of the inverse of the whole normal matrix only the part of the kept unknowns, Q = S^-1,
is a full matrix. With Z = W V^-1 the rest follows for each ray and point:

    Q(kept, point) = -QZ,    Q(point, point) = V^-1 + ZᵀQZ

Brown 1976; Triggs et al. 2000, section 6.1.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pgm_lab.adjustment import normal
from pgm_lab.bundle.equations import Equations, Problem, Rays, State, by_photo

WHOLE = 250_000  # numbers in Z up to which zeros cost less than pairs of rays
PAIRS_AT_ONCE = 5_000  # their products stay in the cache


@dataclass(frozen=True)
class Bars:
    """Scale bars B, which add BᵀPB to V, by the Woodbury identity.

    With C = V^-1 Bᵀ (s, 3, n), K = (P^-1 + B V^-1 Bᵀ)^-1 (s, s) and F = Z Bᵀ
    (U + 6 m, s) the inverse becomes V^-1 - C K Cᵀ, and W times it Z - F K Cᵀ.
    """

    C: np.ndarray
    K: np.ndarray
    F: np.ndarray


@dataclass(frozen=True)
class Reduced:
    """Reduced normal equations; kept unknowns are U interior and 6 m exterior ones."""

    S: np.ndarray  # (U + 6 m, U + 6 m), reduced normal matrix
    right: np.ndarray  # (U + 6 m,), its right-hand side
    diagonal: np.ndarray  # (U + 6 m,), of N, before the reduction
    V_inverse: np.ndarray  # (3, 3, n), inverse blocks of the points, without scale bars
    V_diagonal: np.ndarray  # (3, n)
    n_point: np.ndarray  # (3, n), right-hand sides of the points
    Z: "Whole | ByRays"  # W V^-1, without scale bars
    bars: Bars | None  # what scale bars change

    @classmethod
    def of(cls, problem: Problem, state: State, eq: Equations) -> "Reduced":
        """Set up the normal equations and eliminate the points."""
        rays, weight = problem.rays, problem.control_weight

        # Normal equations: N and n of the kept unknowns, V and n_p of the points, W
        N, n_kept = _normal_equations_of_photos(rays, eq)
        W = np.einsum("arc,irc->aic", eq.A[:6], eq.point)
        sums = rays.total_by_camera(np.einsum("arc,irc->aic", eq.A[6:], eq.point))
        V, W_interior = sums[-3:].sum(axis=-2), sums[:-4]
        n_point = -weight * problem.control(state) - sums[-4].sum(axis=-2)
        V_diagonal = np.einsum("iin->in", V)  # a view
        V_diagonal += weight + problem.held  # held ones: any number, their rows are 0

        # Elimination of the points
        V_inverse = _inverse(V)
        whole = rays.kept * 3 * rays.points <= WHOLE
        Z = (Whole if whole else ByRays).of(rays, W, W_interior, V_inverse)
        S = N - Z.times_W
        right = n_kept - Z.times_points(n_point[None])[:, 0]
        bars = None
        if (given := problem.bars(state)) is not None:
            B, v, sigma = given
            C = np.einsum("ijn,sjn->sin", V_inverse, B)
            K = np.linalg.inv(np.diag(sigma**2) + flat(B) @ flat(C).T)
            F = Z.times_points(B)
            bars = Bars(C, K, F)
            n_bars = np.einsum("sin,s->in", B, -v / sigma**2)
            n_point = n_point + n_bars
            S = S + F @ K @ F.T
            right = right - Z.times_points(n_bars[None])[:, 0]
            right = right + F @ K @ (flat(C) @ n_point.ravel())
        diagonal = np.diagonal(N)
        return cls(S, right, diagonal, V_inverse, V_diagonal, n_point, Z, bars)

    @property
    def determined(self) -> np.ndarray:
        """Points (n,) that their rays determine."""
        with np.errstate(invalid="ignore"):
            inflation = np.einsum("iin->in", self.V_inverse) * self.V_diagonal
            good = (inflation > 0) & (inflation < normal.INFLATION_LIMIT)
        return np.all(good, axis=0)

    def points_alone(self) -> np.ndarray:
        """V^-1 n_p (3, n): corrections of the points if the kept unknowns stay."""
        own = np.einsum("ijn,jn->in", self.V_inverse, self.n_point)
        if (bars := self.bars) is not None:
            pull = bars.K @ (flat(bars.C) @ self.n_point.ravel())
            own -= np.einsum("sin,s->in", bars.C, pull)
        return own

    def times_kept(self, B: np.ndarray) -> np.ndarray:
        """(ZᵀB)' for a matrix B (U + 6 m, q) of the kept unknowns: (q, 3, n)."""
        product = self.Z.times_kept(B)
        if (bars := self.bars) is not None:
            product -= np.einsum("sin,sq->qin", bars.C, bars.K @ bars.F.T @ B)
        return product

    def times_points(self, R: np.ndarray) -> np.ndarray:
        """Z Rᵀ for a matrix R (q, 3, n) of the points: (U + 6 m, q)."""
        product = self.Z.times_points(R)
        if (bars := self.bars) is not None:
            product -= bars.F @ bars.K @ (flat(bars.C) @ flat(R).T)
        return product

    def cofactors(self, rays: Rays, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Cofactors (3, 3, n) of the points, and QZ (6 + u, 3, k) for the rays."""
        # The rows of QZ are the unknowns of a ray's photo, the columns those of its
        # point; Q is any symmetric generalised inverse of S
        ZQZ, QZ = self.Z.propagate(Q)
        points = self.V_inverse + ZQZ
        if (bars := self.bars) is not None:
            C, QFK = bars.C, Q @ bars.F @ bars.K
            of_rays = QFK[rays.unknowns].take(rays.photo, axis=0)
            QZ = QZ - np.einsum("kas,sik->aik", of_rays, C[..., rays.point])
            across = np.einsum("sin,sjn->ijn", self.times_kept(QFK), C)
            own = np.einsum("sin,st,tjn->ijn", C, bars.K + bars.K @ bars.F.T @ QFK, C)
            points = points - own - across - across.swapaxes(0, 1)
        return points, QZ


def flat(blocks: np.ndarray) -> np.ndarray:
    """Lay the last two axes of (rows, i, k) side by side."""
    rows, i, k = blocks.shape
    return blocks.reshape(rows, i * k)


def _normal_equations_of_photos(
    rays: Rays, eq: Equations
) -> tuple[np.ndarray, np.ndarray]:
    """Part N and n of the kept unknowns: first photo by photo, then added up."""
    blocks = np.empty((*rays.unknowns.shape, len(eq.A) - 3))
    for photos, own in rays.stacks:
        A = by_photo(eq.A[:-3, :, own], photos)
        np.matmul(A[:, :-1], A.swapaxes(1, 2), out=blocks[photos])
    u = rays.kept
    N = np.bincount(rays.in_N.ravel(), blocks[..., :-1].ravel(), u * u).reshape(u, u)
    return N, -np.bincount(rays.unknowns.ravel(), blocks[..., -1].ravel(), u)


def _inverse(V: np.ndarray) -> np.ndarray:
    """Inverse of symmetric matrices (3, 3, n), by cofactors; not finite if singular."""
    (a, b, c), (_, d, e), (_, _, f) = V
    A, B, C = d * f - e * e, c * e - b * f, b * e - c * d
    D, E, F = a * f - c * c, b * c - a * e, a * d - b * b
    determinant = a * A + b * B + c * C
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.array([[A, B, C], [B, D, E], [C, E, F]]) / determinant


# --- Z = W V^-1 between the kept unknowns and the points, held in one of two ways ---
#
# A small network has it as a matrix, with zeros where a photo does not see a point:
# what is done with it is a matrix product. In a large one almost everything would be
# zero, and only the blocks of the rays are held; W Zᵀ is then a sum over pairs of rays.
# Numbers are the same to rounding. Both are made of W (6, 3, k) at each ray, rows of
# the exterior orientation, and W_interior (u, 3, cameras, n) at each point.


@dataclass(frozen=True)
class Whole:
    """W and Z as matrices (U + 6 m, 3, n)."""

    rays: Rays
    W: np.ndarray
    Z: np.ndarray

    @classmethod
    def of(
        cls, rays: Rays, W: np.ndarray, W_interior: np.ndarray, V_inverse: np.ndarray
    ) -> "Whole":
        """Lay the blocks of the rays into the matrix, below those of the cameras."""
        whole = np.zeros((rays.kept, 3, rays.points))
        whole[: rays.interior] = _by_unknown(W_interior)
        exterior = whole[rays.interior :].reshape(-1, 6, 3, rays.points)
        exterior[rays.photo, :, :, rays.point] = W.transpose(2, 0, 1)
        return cls(rays, whole, np.einsum("ain,ijn->ajn", whole, V_inverse))

    @property
    def times_W(self) -> np.ndarray:
        """W Zᵀ (U + 6 m, U + 6 m)."""
        return flat(self.W) @ flat(self.Z).T

    def times_points(self, R: np.ndarray) -> np.ndarray:
        """Z Rᵀ (U + 6 m, q) for a matrix R (q, 3, n) of the points."""
        return flat(self.Z) @ flat(R).T

    def times_kept(self, B: np.ndarray) -> np.ndarray:
        """(ZᵀB)' (q, 3, n) for a matrix B (U + 6 m, q) of the kept unknowns."""
        return (B.T @ flat(self.Z)).reshape(-1, *self.Z.shape[1:])

    def propagate(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Blocks ZᵀQZ (3, 3, n) of the points, and QZ (6 + u, 3, k) at the rays."""
        QZ = (Q @ flat(self.Z)).reshape(self.Z.shape)
        rows = self.rays.unknowns.T[:, None, self.rays.photo]
        at_rays = QZ[rows, np.arange(3)[:, None], self.rays.point]
        return np.einsum("ain,ajn->ijn", self.Z, QZ), at_rays


@dataclass(frozen=True)
class ByRays:
    """W and Z of the interior (U, 3, n), and of the exterior (6, 3, k) at each ray."""

    rays: Rays
    W_interior: np.ndarray
    W: np.ndarray
    Z_interior: np.ndarray
    Z: np.ndarray

    @classmethod
    def of(
        cls, rays: Rays, W: np.ndarray, W_interior: np.ndarray, V_inverse: np.ndarray
    ) -> "ByRays":
        """Multiply the blocks as they are."""
        W_interior = _by_unknown(W_interior)
        Z_interior = np.einsum("ain,ijn->ajn", W_interior, V_inverse)
        Z = np.einsum("aik,ijk->ajk", W, V_inverse.take(rays.point, axis=-1))
        return cls(rays, W_interior, W, Z_interior, Z)

    @property
    def times_W(self) -> np.ndarray:
        """W Zᵀ (U + 6 m, U + 6 m)."""
        U, photo, m = self.rays.interior, self.rays.photo, len(self.rays.photos)
        product = np.zeros((self.rays.kept, self.rays.kept))
        product[:U, :U] = flat(self.W_interior) @ flat(self.Z_interior).T

        # Between each photo and the later ones: pairs of rays
        blocks = np.zeros((6, 6, m * m))
        for a, b in _in_portions(*self.rays.pairs):
            W, Z = self.W.take(a, axis=-1), self.Z.take(b, axis=-1)
            of_pairs = np.einsum("aip,cip->acp", W, Z)
            _add_runs(blocks, of_pairs, photo[a] * m + photo[b])
        by_photos = blocks.reshape(6, 6, m, m).transpose(2, 0, 3, 1)
        product[U:, U:] = by_photos.reshape(6 * m, 6 * m)

        # Of each photo with the cameras and with itself
        for i, own in enumerate(self.rays.photos):
            e = slice(U + 6 * i, U + 6 * i + 6)
            Z = flat(self.Z[..., own])
            W_interior = self.W_interior.take(self.rays.point[own], axis=-1)
            product[:U, e] = flat(W_interior) @ Z.T
            product[e, e] = flat(self.W[..., own]) @ Z.T
        return np.triu(product) + np.triu(product, 1).T

    def times_points(self, R: np.ndarray) -> np.ndarray:
        """Z Rᵀ (U + 6 m, q) for a matrix R (q, 3, n) of the points."""
        interior = flat(self.Z_interior) @ flat(R).T
        exterior = [
            flat(self.Z[..., own]) @ flat(R[..., self.rays.point[own]]).T
            for own in self.rays.photos
        ]
        return np.concatenate([interior, *exterior])

    def times_kept(self, B: np.ndarray) -> np.ndarray:
        """(ZᵀB)' (q, 3, n) for a matrix B (U + 6 m, q) of the kept unknowns."""
        U, q = self.rays.interior, B.shape[1]
        exterior = B[U:].reshape(-1, 6, q).transpose(2, 1, 0)
        exterior = exterior.take(self.rays.photo, axis=-1)
        interior = (B[:U].T @ flat(self.Z_interior)).reshape(q, 3, self.rays.points)
        return interior + self.rays.total(np.einsum("qak,ajk->qjk", exterior, self.Z))

    def propagate(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Blocks ZᵀQZ (3, 3, n) of the points, and QZ (6 + u, 3, k) at the rays."""
        rays, U, m = self.rays, self.rays.interior, len(self.rays.photos)
        to_interior = np.empty((U, *self.Z.shape[1:]))
        QZ = np.empty_like(self.Z)

        # From the ray itself and the cameras
        for photo, own in enumerate(rays.photos):
            e = slice(U + 6 * photo, U + 6 * photo + 6)
            Z = flat(self.Z[..., own])
            Z_interior = flat(self.Z_interior.take(rays.point[own], axis=-1))
            to_interior[..., own] = (Q[:U, e] @ Z).reshape(to_interior[..., own].shape)
            QZ[..., own] = (Q[e, e] @ Z + Q[e, :U] @ Z_interior).reshape(6, 3, -1)

        # From the other rays of the same point: each pair both ways, by the first
        by_photos = Q[U:, U:].reshape(m, 6, m, 6).transpose(1, 3, 0, 2)
        between = by_photos.reshape(36, m * m)
        one, other = rays.pairs
        first, second = np.concatenate([[one, other], [other, one]], axis=1)
        order = np.argsort(first, kind="stable")
        for a, b in _in_portions(first[order], second[order]):
            Q_ab = between.take(rays.photo[a] * m + rays.photo[b], axis=-1)
            Q_ab, Z = Q_ab.reshape(6, 6, -1), self.Z.take(b, axis=-1)
            _add_runs(QZ, np.einsum("acp,cjp->ajp", Q_ab, Z), a)

        # Of the cameras, and the sums over the rays of each point
        QZ_interior = (Q[:U, :U] @ flat(self.Z_interior)).reshape(-1, 3, rays.points)
        QZ_interior += rays.total(to_interior)
        of_points = np.einsum("ain,ajn->ijn", self.Z_interior, QZ_interior)
        of_points += rays.total(np.einsum("aik,ajk->ijk", self.Z, QZ))
        by_camera = QZ_interior.reshape(rays.cameras, -1, 3, rays.points)
        by_place = by_camera.transpose(1, 2, 0, 3)
        by_place = by_place.reshape(-1, 3, rays.cameras * rays.points)
        return of_points, np.concatenate([QZ, by_place.take(rays.place, axis=-1)])


def _by_unknown(W_interior: np.ndarray) -> np.ndarray:
    """Rows of the interior unknowns (U, 3, n) from (u, 3, cameras, n)."""
    u, _, cameras, n = W_interior.shape
    return W_interior.transpose(2, 0, 1, 3).reshape(u * cameras, 3, n)


def _in_portions(
    first: np.ndarray, second: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of rays, so few at once that what they need stays in the cache."""
    for start in range(0, len(first), PAIRS_AT_ONCE):
        some = slice(start, start + PAIRS_AT_ONCE)
        yield first[some], second[some]


def _add_runs(total: np.ndarray, values: np.ndarray, index: np.ndarray) -> None:
    """Add values (..., k) to the columns of an index, which ascends, in place."""
    start = np.flatnonzero(np.diff(index, prepend=-1))
    total[..., index[start]] += np.add.reduceat(values, start, axis=-1)
