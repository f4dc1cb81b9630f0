"""Where a point of the left photo lies in the right one, as its neighbours tell."""

from dataclasses import dataclass

import numpy as np
import scipy

NEIGHBOURS = 16  # features that tell where a point lies
STIFF = 30.0  # px: features spread less than that cannot tell the shape of a window
STEPS = 5  # of robust weighting


@dataclass(frozen=True, eq=False)
class Field:
    """Points that were found in both photos, left and right (m, 2).

    `noise` is their uncertainty in pixels. `F` is the fundamental matrix: (u, v, 1) F
    (x, y, 1) = 0 for (x, y) left and (u, v) right. It is None where one plane, or the
    turn of a camera, explains all of them.
    """

    left: np.ndarray
    right: np.ndarray
    noise: float = 1.5
    F: np.ndarray | None = None

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (n, 2) in the right photo, and shapes (n, 2, 2), of left points.

        An affine transformation of the nearest neighbours, weighted by their distance
        and without those that do not fit to the others. Its shape is drawn to that of
        all points, the more the closer the neighbours stand to each other.
        """
        middle = self.left.mean(axis=0, keepdims=True)
        m = len(self.left)
        all_of_them = np.arange(m)[None]
        position, shape = self._affine(middle, all_of_them, np.eye(2), 1.0)
        distance, near = scipy.spatial.cKDTree(self.left).query(
            points, min(NEIGHBOURS, m)
        )
        distance, near = (
            distance.reshape(len(points), -1),
            near.reshape(len(points), -1),
        )
        reach = np.median(distance, axis=1, keepdims=True) + 1.0
        weight = 1 / (1 + (distance / reach) ** 2)
        return self._affine(points, near, shape[0], weight)

    def width(self, shape: np.ndarray) -> float:
        """How far from its line a point may lie, in pixels of the left photo."""
        scale = np.sqrt(np.abs(np.linalg.det(shape)))
        return max(1.0, 2 * self.noise / float(np.median(scale))) if len(scale) else 1.0

    def lines(self, points: np.ndarray) -> np.ndarray | None:
        """Epipolar lines (n, 3) in the right photo, if there is one a point."""
        if self.F is None:
            return None
        return np.c_[points, np.ones(len(points))] @ self.F.T

    def _affine(
        self,
        points: np.ndarray,
        near: np.ndarray,
        prior: np.ndarray,
        weight: np.ndarray | float,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Affine transformations of the features `near` (n, k), robustly."""
        offset = self.left[near] - points[:, None]
        # What the prior does not explain: right = prior offset + t + M offset
        rest = self.right[near] - offset @ prior.T
        A = np.concatenate([np.ones((*near.shape, 1)), offset], axis=2)
        P = np.diag([0.0, STIFF**2, STIFF**2])
        p = np.broadcast_to(weight, near.shape)
        t = np.median(rest, axis=1)
        v = np.linalg.norm(rest - t[:, None], axis=2)
        for _ in range(STEPS):
            scale = np.maximum(np.median(v, axis=1, keepdims=True), 0.5)
            w = p / (1 + (v / (2 * scale)) ** 2)
            N = np.einsum("nki,nk,nkj->nij", A, w, A) + P
            x = np.linalg.solve(N, np.einsum("nki,nk,nkj->nij", A, w, rest))
            v = np.linalg.norm(rest - A @ x, axis=2)
        return x[:, 0], prior + np.swapaxes(x[:, 1:], 1, 2)
