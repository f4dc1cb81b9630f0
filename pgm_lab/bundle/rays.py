"""The rays of a network in the order of the photos, and their observation equations.

Arrays of this package have the ray, or the point, in the last axis: entry (i, j) of all
small matrices lies side by side in the memory, and einsum multiplies them at once.
"""

from dataclasses import dataclass

import numpy as np

from pgm_lab.bundle._correlated import whiten
from pgm_lab.bundle.network import Network
from pgm_lab.camera import imaging
from pgm_lab.camera._stacks import of_photo


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
    """The rays of a network, ordered by photo.

    Attributes
    ----------
    order : ndarray (k,)
        Index of each ray in the network.
    photo, point : ndarray (k,)
    start : ndarray (m + 1,)
        First ray of each photo.
    measured : ndarray (k, 2)
        In mm.
    per_sigma : ndarray (2, k)
        1 / sigma: observation equations are divided by sigma, then P = 1.
    rho : ndarray (k,) or None
        Correlation of x and y, from which the equations are freed; None without.
    first, second : ndarray (pairs,)
        Pairs of rays of the same point, `first` in the photo that comes first; the
        pairs of two photos stand together.
    """

    order: np.ndarray
    photo: np.ndarray
    point: np.ndarray
    start: np.ndarray
    measured: np.ndarray
    per_sigma: np.ndarray
    first: np.ndarray
    second: np.ndarray
    rho: np.ndarray | None = None

    @classmethod
    def of(cls, network: Network) -> "Rays":
        """Sort the rays of a network by photo."""
        order = np.argsort(network.photo, kind="stable")
        photo, point = network.photo[order], network.point[order]
        m = len(network.exteriors)
        return cls(
            order,
            photo,
            point,
            np.searchsorted(photo, np.arange(m + 1)),
            network.xy[order],
            np.ascontiguousarray(1 / network.sigma[order].T),
            *_pairs(photo, point),
            rho=None if network.covariance is None else network.correlation[order],
        )

    @property
    def photos(self) -> list[slice]:
        """The rays of each photo."""
        return [slice(*ends) for ends in zip(self.start[:-1], self.start[1:])]

    @property
    def both_ways(self) -> tuple[np.ndarray, np.ndarray]:
        """Each ray with each other ray of the same point, ordered by the first."""
        first = np.concatenate([self.first, self.second])
        second = np.concatenate([self.second, self.first])
        order = np.argsort(first, kind="stable")
        return first[order], second[order]


@dataclass(frozen=True)
class Equations:
    """Observation equations, divided by sigma.

    Attributes
    ----------
    v : ndarray (2, k)
        Computed - observed.
    camera : ndarray (u + 6, 2, k)
        Derivatives by the u interior parameters of the ray's camera, then by the
        exterior orientation of its photo.
    point : ndarray (3, 2, k)
        Derivatives by (X, Y, Z); 0 for held coordinates.
    """

    v: np.ndarray
    camera: np.ndarray
    point: np.ndarray


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
    with np.errstate(all="ignore"):  # a step too far is refused by its v'Pv
        v, _, by = imaging.misclosure(
            interior,
            state.exteriors,
            of_photo(state.points, rays.point),
            rays.measured,
            network.cameras[0].lens,
            ("interior",) * bool(len(estimated)) + ("exterior", "point"),
            rays.photo,
        )
    camera = np.empty((len(estimated) + 6, *v.shape[::-1]))
    for row, column in enumerate(estimated):
        camera[row] = by["interior"][..., column].T * rays.per_sigma
    camera[len(estimated) :] = by["exterior"].T * rays.per_sigma
    point = by["point"].T * rays.per_sigma
    if not free.all():
        point *= free[:, None, rays.point]
    v = v.T * rays.per_sigma
    if rays.rho is not None:
        for values in (v, camera, point):
            whiten(values, rays.rho)
    return Equations(v, camera, point)


def total(values: np.ndarray, index: np.ndarray, size: int) -> np.ndarray:
    """Sum values (..., k) over the rays of each point or photo: (..., size)."""
    rows = values.reshape(-1, values.shape[-1])
    sums = [np.bincount(index, row, size) for row in rows]
    return np.reshape(sums, (*values.shape[:-1], size))


def totals_of_runs(values: np.ndarray, index: np.ndarray):
    """Sum values (..., k) over runs of the same index, which ascends.

    Returns
    -------
    index : ndarray (runs,)
    sums : ndarray (..., runs)
    """
    start = np.flatnonzero(np.diff(index, prepend=-1))
    return index[start], np.add.reduceat(values, start, axis=-1)


def _pairs(photo: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each ray with each later ray of the same point, ordered by their photos."""
    ray = np.argsort(point, kind="stable")
    count = np.bincount(point) if len(point) else np.zeros(0, int)
    later = np.repeat(np.cumsum(count), count) - np.arange(len(ray)) - 1
    first = np.repeat(np.arange(len(ray)), later)
    nth = np.arange(len(first)) - np.repeat(np.cumsum(later) - later, later)
    first, second = ray[first], ray[first + 1 + nth]
    order = np.lexsort((photo[second], photo[first]))
    return first[order], second[order]


def behind(network: Network, exteriors: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the indices of rays whose point does not lie in front of its photo."""
    ray, _ = imaging.ray(exteriors, points[network.point], network.photo)
    return np.flatnonzero(ray[:, 2] >= 0)
