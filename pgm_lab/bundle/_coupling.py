"""Z = W V^-1 between the kept unknowns and the points, held in one of two ways.

A small network has it as a matrix, with zeros where a photo does not see a point: what
is done with it is a matrix product. In a large one almost everything would be zero, and
only the blocks of the rays are held; W Zᵀ is then a sum over pairs of rays. Numbers are
the same to rounding.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pgm_lab.bundle.rays import Rays, totals_of_runs

WHOLE = 250_000  # numbers in Z up to which zeros cost less than pairs of rays
PAIRS_AT_ONCE = 5_000  # their products stay in the cache


class Coupling(Protocol):
    """What the reduction does with Z (U + 6 m, 3 n)."""

    @property
    def times_W(self) -> np.ndarray:
        """W Zᵀ (U + 6 m, U + 6 m)."""

    def times_points(self, R: np.ndarray) -> np.ndarray:
        """Z Rᵀ (U + 6 m, q) for a matrix R (q, 3, n) of the points."""

    def times_kept(self, B: np.ndarray) -> np.ndarray:
        """(ZᵀB)' (q, 3, n) for a matrix B (U + 6 m, q) of the kept unknowns."""

    def propagate(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Blocks ZᵀQZ (3, 3, n) of the points, and what the rays need of QZ.

        That is (6 + u, 3, k): the rows of the unknowns of a ray's photo, the columns
        of its point.
        """


def couple(
    rays: Rays, W: np.ndarray, W_interior: np.ndarray, V_inverse: np.ndarray
) -> Coupling:
    """Z from W and the inverse blocks V^-1 (3, 3, n) of the points.

    Parameters
    ----------
    W : ndarray (6, 3, k)
        At each ray, rows of the exterior orientation of its photo.
    W_interior : ndarray (u, 3, cameras, n)
        At each point, rows of the interior parameters of each camera.
    """
    W_interior = W_interior.transpose(2, 0, 1, 3).reshape(-1, 3, rays.points)
    whole = rays.kept * 3 * rays.points <= WHOLE
    return (Whole if whole else ByRays).of(rays, W, W_interior, V_inverse)


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
        whole[: rays.interior] = W_interior
        exterior = whole[rays.interior :].reshape(-1, 6, 3, rays.points)
        exterior[rays.photo, :, :, rays.point] = W.transpose(2, 0, 1)
        return cls(rays, whole, np.einsum("ain,ijn->ajn", whole, V_inverse))

    @property
    def times_W(self) -> np.ndarray:
        return flat(self.W) @ flat(self.Z).T

    def times_points(self, R: np.ndarray) -> np.ndarray:
        return flat(self.Z) @ flat(R).T

    def times_kept(self, B: np.ndarray) -> np.ndarray:
        return (B.T @ flat(self.Z)).reshape(-1, *self.Z.shape[1:])

    def propagate(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
        Z_interior = np.einsum("ain,ijn->ajn", W_interior, V_inverse)
        Z = np.einsum("aik,ijk->ajk", W, V_inverse.take(rays.point, axis=-1))
        return cls(rays, W_interior, W, Z_interior, Z)

    @property
    def times_W(self) -> np.ndarray:
        U = self.rays.interior
        product = np.zeros((self.rays.kept, self.rays.kept))
        product[:U, :U] = flat(self.W_interior) @ flat(self.Z_interior).T
        product[U:, U:] = self._between_photos()
        for photo, own in enumerate(self.rays.photos):
            e = slice(U + 6 * photo, U + 6 * photo + 6)
            Z = flat(self.Z[..., own])
            W_interior = self.W_interior.take(self.rays.point[own], axis=-1)
            product[:U, e] = flat(W_interior) @ Z.T
            product[e, e] = flat(self.W[..., own]) @ Z.T
        return np.triu(product) + np.triu(product, 1).T

    def _between_photos(self) -> np.ndarray:
        """Part of W Zᵀ between each photo and the later ones: (6 m, 6 m)."""
        photo, m = self.rays.photo, len(self.rays.photos)
        blocks = np.zeros((6, 6, m * m))
        for a, b in _in_portions(*self.rays.pairs):
            W, Z = self.W.take(a, axis=-1), self.Z.take(b, axis=-1)
            product = np.einsum("aip,cip->acp", W, Z)
            photos, sums = totals_of_runs(product, photo[a] * m + photo[b])
            blocks[..., photos] += sums
        return blocks.reshape(6, 6, m, m).transpose(2, 0, 3, 1).reshape(6 * m, 6 * m)

    def times_points(self, R: np.ndarray) -> np.ndarray:
        interior = flat(self.Z_interior) @ flat(R).T
        exterior = [
            flat(self.Z[..., own]) @ flat(R[..., self.rays.point[own]]).T
            for own in self.rays.photos
        ]
        return np.concatenate([interior, *exterior])

    def times_kept(self, B: np.ndarray) -> np.ndarray:
        U, q = self.rays.interior, B.shape[1]
        exterior = B[U:].reshape(-1, 6, q).transpose(2, 1, 0)
        exterior = exterior.take(self.rays.photo, axis=-1)
        interior = (B[:U].T @ flat(self.Z_interior)).reshape(q, 3, self.rays.points)
        return interior + self.rays.total(np.einsum("qak,ajk->qjk", exterior, self.Z))

    def propagate(self, Q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rays, U = self.rays, self.rays.interior
        to_interior = np.empty((U, *self.Z.shape[1:]))
        QZ = np.empty_like(self.Z)
        for photo, own in enumerate(rays.photos):
            e = slice(U + 6 * photo, U + 6 * photo + 6)
            Z = flat(self.Z[..., own])
            Z_interior = flat(self.Z_interior.take(rays.point[own], axis=-1))
            to_interior[..., own] = (Q[:U, e] @ Z).reshape(to_interior[..., own].shape)
            QZ[..., own] = (Q[e, e] @ Z + Q[e, :U] @ Z_interior).reshape(6, 3, -1)
        self._add_other_photos(Q[U:, U:], QZ)
        QZ_interior = (Q[:U, :U] @ flat(self.Z_interior)).reshape(-1, 3, rays.points)
        QZ_interior += rays.total(to_interior)
        of_points = np.einsum("ain,ajn->ijn", self.Z_interior, QZ_interior)
        of_points += rays.total(np.einsum("aik,ajk->ijk", self.Z, QZ))
        by_camera = QZ_interior.reshape(rays.cameras, -1, 3, rays.points)
        by_place = by_camera.transpose(1, 2, 0, 3).reshape(
            -1, 3, rays.cameras * rays.points
        )
        return of_points, np.concatenate([QZ, by_place.take(rays.place, axis=-1)])

    def _add_other_photos(self, Q: np.ndarray, QZ: np.ndarray) -> None:
        """Add to QZ (6, 3, k) what comes from the other rays of the same point."""
        photo, m = self.rays.photo, len(self.rays.photos)
        between = Q.reshape(m, 6, m, 6).transpose(1, 3, 0, 2).reshape(36, m * m)
        for a, b in _in_portions(*self.rays.both_ways):
            Q_ab = between.take(photo[a] * m + photo[b], axis=-1).reshape(6, 6, -1)
            product = np.einsum("acp,cjp->ajp", Q_ab, self.Z.take(b, axis=-1))
            ray, sums = totals_of_runs(product, a)
            QZ[..., ray] += sums


def flat(blocks: np.ndarray) -> np.ndarray:
    """Lay the last two axes of (rows, i, k) side by side."""
    rows, i, k = blocks.shape
    return blocks.reshape(rows, i * k)


def _in_portions(
    first: np.ndarray, second: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Pairs of rays, so few at once that what they need stays in the cache."""
    for start in range(0, len(first), PAIRS_AT_ONCE):
        some = slice(start, start + PAIRS_AT_ONCE)
        yield first[some], second[some]
