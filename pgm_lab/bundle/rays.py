"""The rays of a network in the order of the photos, and their observation equations.

Arrays of this package have the ray, or the point, in the last axis: entry (i, j) of all
small matrices lies side by side in the memory, and einsum multiplies them at once.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy import sparse

from pgm_lab.bundle._correlated import whiten
from pgm_lab.bundle.network import Network
from pgm_lab.camera import imaging

RAYS_AT_ONCE = 5_000  # what is computed for them stays in the cache


@dataclass(frozen=True)
class State:
    """Where an adjustment is: the values of all unknowns.

    Attributes
    ----------
    interior : ndarray (cameras, 10)
    exteriors : ndarray (m, 6)
    points : ndarray (n, 3)
    """

    interior: np.ndarray
    exteriors: np.ndarray
    points: np.ndarray


@dataclass(frozen=True)
class Rays:
    """The rays of a network, ordered by photo, and the unknowns they depend on.

    The kept unknowns are U interior parameters, u of each camera, and 6 m of the
    exterior orientations.

    Attributes
    ----------
    order : ndarray (k,)
        Index of each ray in the network.
    photo, point, camera : ndarray (k,)
    unknowns : ndarray (m, 6 + u)
        Which of the kept unknowns each photo depends on: its own exterior orientation,
        then the interior parameters of its camera.
    points, cameras : int
        How many there are, n and U / u.
    measured : ndarray (k, 2)
        In mm.
    per_sigma : ndarray (2, k)
        1 / sigma: observation equations are divided by sigma, then P = 1.
    rho : ndarray (k,) or None
        Correlation of x and y, from which the equations are freed; None without.
    """

    order: np.ndarray
    photo: np.ndarray
    point: np.ndarray
    camera: np.ndarray
    unknowns: np.ndarray
    points: int
    cameras: int
    measured: np.ndarray
    per_sigma: np.ndarray
    rho: np.ndarray | None

    @classmethod
    def of(cls, network: Network, u: int) -> "Rays":
        """Sort the rays of a network by photo; u interior parameters are unknowns."""
        order = np.argsort(network.photo, kind="stable")
        m, cameras = len(network.exteriors), len(network.cameras)
        interior = u * network.camera[:, None] + np.arange(u)
        exterior = u * cameras + np.arange(6 * m).reshape(m, 6)
        return cls(
            order,
            network.photo[order],
            network.point[order],
            network.camera[network.photo[order]],
            np.concatenate([exterior, interior], axis=1),
            len(network.points),
            cameras,
            network.xy[order],
            np.ascontiguousarray(1 / network.sigma[order].T),
            None if network.covariance is None else network.correlation[order],
        )

    @property
    def interior(self) -> int:
        """Number U of interior unknowns."""
        return int(self.unknowns[0, 0])

    @property
    def kept(self) -> int:
        """Number U + 6 m of kept unknowns."""
        return int(self.unknowns[-1, 5]) + 1

    @cached_property
    def level(self) -> float:
        """Length of all image coordinates over sigma."""
        return float(np.linalg.norm(self.measured.T * self.per_sigma))

    @cached_property
    def photos(self) -> list[slice]:
        """The rays of each photo."""
        ends = np.searchsorted(self.photo, np.arange(len(self.unknowns) + 1))
        return [slice(*pair) for pair in pairwise(ends)]

    @cached_property
    def stacks(self) -> list[tuple[slice, slice]]:
        """Successive photos with equally many rays, and their rays: taken at once."""
        counts = np.bincount(self.photo, minlength=len(self.unknowns))
        stacks, first = [], 0
        for photo, own in enumerate(self.photos):
            last = photo + 1 == len(counts) or counts[photo + 1] != counts[photo]
            if last or own.stop - self.photos[first].start >= RAYS_AT_ONCE:
                rays = slice(self.photos[first].start, own.stop)
                stacks.append((slice(first, photo + 1), rays))
                first = photo + 1
        return stacks

    @cached_property
    def in_N(self) -> np.ndarray:
        """Where the block of each photo lies in N (m, 6 + u, 6 + u): entries of N."""
        return self.unknowns[:, :, None] * self.kept + self.unknowns[:, None]

    @cached_property
    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Each ray with each later ray of the same point, ordered by their photos."""
        ray = np.argsort(self.point, kind="stable")
        count = np.bincount(self.point)
        later = np.repeat(np.cumsum(count), count) - np.arange(len(ray)) - 1
        first = np.repeat(np.arange(len(ray)), later)
        nth = np.arange(len(first)) - np.repeat(np.cumsum(later) - later, later)
        first, second = ray[first], ray[first + 1 + nth]
        order = np.lexsort((self.photo[second], self.photo[first]))
        return first[order], second[order]

    @property
    def both_ways(self) -> tuple[np.ndarray, np.ndarray]:
        """Each ray with each other ray of the same point, ordered by the first."""
        first, second = self.pairs
        first, second = np.concatenate([[first, second], [second, first]], axis=1)
        order = np.argsort(first, kind="stable")
        return first[order], second[order]

    @cached_property
    def place(self) -> np.ndarray:
        """Where each ray is added up (k,): n places for each camera, one a point."""
        return self.camera * self.points + self.point

    @cached_property
    def _at_places(self) -> sparse.csc_array:
        """Matrix (cameras n, k) with ones where a ray belongs to a place."""
        k = len(self.place)
        shape = self.cameras * self.points, k
        return sparse.csc_array((np.ones(k), self.place, np.arange(k + 1)), shape=shape)

    def total_by_camera(self, values: np.ndarray) -> np.ndarray:
        """Sum values (..., k) by camera and point: (..., cameras, n)."""
        sums = self._at_places @ values.reshape(-1, values.shape[-1]).T
        shape = (*values.shape[:-1], self.cameras, self.points)
        return np.ascontiguousarray(sums.T).reshape(shape)

    def total(self, values: np.ndarray) -> np.ndarray:
        """Sum values (..., k) over the rays of each point: (..., n)."""
        return self.total_by_camera(values).sum(axis=-2)


@dataclass(frozen=True)
class Equations:
    """Observation equations, divided by sigma and freed from correlation: P = 1.

    Attributes
    ----------
    A : ndarray (6 + u + 1 + 3, 2, k)
        In this order: derivatives by the exterior orientation of the ray's photo, by
        the u interior parameters of its camera; computed - observed; derivatives by
        (X, Y, Z), 0 for held coordinates. They are A1, A3, -f and A2 of (M 2.78).
    """

    A: np.ndarray

    @property
    def camera(self) -> np.ndarray:
        """Derivatives (6 + u, 2, k) by the unknowns of the photo and its camera."""
        return self.A[:-4]

    @property
    def v(self) -> np.ndarray:
        """Computed - observed (2, k)."""
        return self.A[-4]

    @property
    def point(self) -> np.ndarray:
        """Derivatives (3, 2, k) by the point."""
        return self.A[-3:]


def equations(
    network: Network, rays: Rays, state: State, estimated: np.ndarray, free: np.ndarray
) -> Equations:
    """Observation equations at a state.

    Parameters
    ----------
    estimated : ndarray (u,)
        Indices of the interior parameters that are unknowns.
    free : ndarray (3, n) of bool
        Coordinates that are unknowns.
    """
    interior = state.interior[network.camera]
    if len(network.cameras) == 1:
        interior = state.interior[0]
    wrt = ("interior", "exterior", "point")
    k = len(rays.photo)
    A = np.empty((10 + len(estimated), 2, k))
    for some in (slice(i, i + RAYS_AT_ONCE) for i in range(0, k, RAYS_AT_ONCE)):
        with np.errstate(all="ignore"):  # a step too far is refused by its vᵀPv
            v, _, by = imaging.equations(
                interior,
                state.exteriors,
                state.points.T.take(rays.point[some], axis=-1).T,
                rays.measured[some],
                network.cameras[0].lens,
                wrt,
                rays.photo[some],
            )
        per_sigma = rays.per_sigma[:, some]
        np.multiply(by["exterior"], per_sigma, out=A[:6, :, some])
        np.multiply(by["interior"][estimated], per_sigma, out=A[6:-4, :, some])
        np.multiply(v, per_sigma, out=A[-4, :, some])
        np.multiply(by["point"], per_sigma, out=A[-3:, :, some])
    if not free.all():
        A[-3:] *= free[:, None, rays.point]
    if rays.rho is not None:
        whiten(A, rays.rho)
    return Equations(A)


def by_photo(values: np.ndarray, photos: slice) -> np.ndarray:
    """Values (rows, 2, k) of the rays of some photos, as many of each: (p, rows, q).

    `photos` and the k rays are from `Rays.stacks`; q = 2 k / p are the image
    coordinates of a photo, all x before all y.
    """
    rows, p = len(values), photos.stop - photos.start
    stack = values.reshape(rows, 2, p, -1).transpose(2, 0, 1, 3)
    return stack.reshape(p, rows, -1)


def totals_of_runs(
    values: np.ndarray, index: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sum values (..., k) over runs of the same index, which ascends.

    Returns
    -------
    index : ndarray (runs,)
    sums : ndarray (..., runs)
    """
    start = np.flatnonzero(np.diff(index, prepend=-1))
    return index[start], np.add.reduceat(values, start, axis=-1)


def behind(network: Network, exteriors: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the indices of rays whose point does not lie in front of its photo."""
    ray, _ = imaging.ray(exteriors, points[network.point], network.photo)
    return np.flatnonzero(ray[:, 2] >= 0)
