"""Observation equations of a network: collinearity, control points, scale bars.

v + A1 d1 + A2 d2 + A3 d3 = f of (M 2.78), with exterior orientations d1, points d2 and
interior parameters d3. Rays are ordered by photo, and have the last axis of an array:
entry (i, j) of all small matrices lies side by side in the memory, and einsum
multiplies them at once.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy

from pgm_lab import _validate
from pgm_lab.bundle.network import Network
from pgm_lab.camera import PARAMETERS, imaging

RAYS_AT_ONCE = 5_000  # what is computed for them stays in the cache


@dataclass(frozen=True)
class State:
    """All unknowns: interior (cameras, 10), exteriors (m, 6), points (n, 3)."""

    interior: np.ndarray
    exteriors: np.ndarray
    points: np.ndarray


@dataclass(frozen=True)
class Equations:
    """Observation equations of the rays, divided by sigma and decorrelated: P = 1.

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


# --- The rays, ordered by photo ---


@dataclass(frozen=True)
class Rays:
    """The rays of a network, ordered by photo, and the unknowns they depend on.

    The kept unknowns, which remain when the points are eliminated, are U interior
    parameters, u of each camera, and 6 m of the exterior orientations. `unknowns` tells
    those of each photo: its own exterior orientation, then the interior parameters of
    its camera.
    """

    order: np.ndarray  # (k,), index of each ray in the network
    photo: np.ndarray  # (k,)
    point: np.ndarray  # (k,)
    camera: np.ndarray  # (k,)
    unknowns: np.ndarray  # (m, 6 + u)
    points: int  # how many, n
    cameras: int  # how many, U / u
    measured: np.ndarray  # (k, 2), mm
    per_sigma: np.ndarray  # (2, k), 1 / sigma
    rho: np.ndarray | None  # (k,), correlation of x and y

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
        """Successive photos with equally many rays, and their rays: stacked."""
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

    @cached_property
    def place(self) -> np.ndarray:
        """Where each ray is added up (k,): n places for each camera, one a point."""
        return self.camera * self.points + self.point

    @cached_property
    def _at_places(self) -> "scipy.sparse.csc_array":
        """Matrix (cameras n, k) with ones where a ray belongs to a place."""
        k = len(self.place)
        shape = self.cameras * self.points, k
        return scipy.sparse.csc_array(
            (np.ones(k), self.place, np.arange(k + 1)), shape=shape
        )

    def total_by_camera(self, values: np.ndarray) -> np.ndarray:
        """Sum values (..., k) by camera and point: (..., cameras, n)."""
        sums = self._at_places @ values.reshape(-1, values.shape[-1]).T
        shape = (*values.shape[:-1], self.cameras, self.points)
        return np.ascontiguousarray(sums.T).reshape(shape)

    def total(self, values: np.ndarray) -> np.ndarray:
        """Sum values (..., k) over the rays of each point: (..., n)."""
        return self.total_by_camera(values).sum(axis=-2)


def by_photo(values: np.ndarray, photos: slice) -> np.ndarray:
    """Values (rows, 2, k) of the rays of some photos, as many of each: (p, rows, q).

    `photos` and the k rays are from `Rays.stacks`; q = 2 k / p are the image
    coordinates of a photo, all x before all y.
    """
    rows, p = len(values), photos.stop - photos.start
    stack = values.reshape(rows, 2, p, -1).transpose(2, 0, 1, 3)
    return stack.reshape(p, rows, -1)


def behind(network: Network, exteriors: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the indices of rays whose point does not lie in front of its photo."""
    ray, _ = imaging.ray(exteriors, points[network.point], network.photo)
    return np.flatnonzero(ray[:, 2] >= 0)


# --- Everything that was observed ---


@dataclass(frozen=True)
class Problem:
    """A network, its rays and the indices of the interior parameters to estimate."""

    network: Network
    rays: Rays
    estimated: np.ndarray

    @classmethod
    def of(cls, network: Network, estimate: Sequence[str]) -> "Problem":
        """Validate the names of the interior parameters, and sort the rays."""
        _validate.instance(network, Network, "network")
        if isinstance(estimate, str):
            estimate = (estimate,)
        for name in _validate.several(estimate, "estimate"):
            _validate.choice(name, "estimate", PARAMETERS)
        estimated = [i for i, name in enumerate(PARAMETERS) if name in estimate]
        rays = Rays.of(network, len(estimated))
        return cls(network, rays, np.array(estimated, int))

    @property
    def estimate(self) -> tuple[str, ...]:
        """Names of the interior parameters that are unknowns."""
        return tuple(PARAMETERS[i] for i in self.estimated)

    @property
    def start(self) -> State:
        """The start values of the network, held coordinates where they are given."""
        network, points = self.network, self.network.points.copy()
        if network.control is not None:
            index, coordinates, sigma = network.control
            points[index] = np.where(sigma == 0, coordinates, points[index])
        return State(network.interior, network.exteriors, points)

    @cached_property
    def held(self) -> np.ndarray:
        """Coordinates (3, n) that are no unknowns, as bool."""
        return self.network.held.T

    @cached_property
    def control_weight(self) -> np.ndarray:
        """Weights (3, n) of coordinates that are observed; 0 for the others."""
        weight = np.zeros(self.network.points.shape)
        if self.network.control is not None:
            index, _, sigma = self.network.control
            weight[index] = np.where(sigma > 0, sigma, np.inf) ** -2.0
        return weight.T

    def redundancy(self, constraints: int) -> int:
        """Observations - unknowns + constraints."""
        network = self.network
        observed = np.count_nonzero(self.control_weight)
        observations = network.xy.size + observed + len(network.scale_bars)
        unknowns = self.rays.kept + np.count_nonzero(~self.held)
        return int(observations - unknowns + constraints)

    def equations(self, state: State) -> Equations:
        """Collinearity equations of the rays at a state, (M 2.81) to (M 2.89)."""
        network, rays = self.network, self.rays
        one = len(network.cameras) == 1
        interior = state.interior[0] if one else state.interior[network.camera]
        k = len(rays.photo)
        A = np.empty((10 + len(self.estimated), 2, k))
        for some in (slice(i, i + RAYS_AT_ONCE) for i in range(0, k, RAYS_AT_ONCE)):
            with np.errstate(all="ignore"):  # a step too far is rejected by its vᵀPv
                v, _, by = imaging.equations(
                    interior,
                    state.exteriors,
                    state.points.T.take(rays.point[some], axis=-1).T,
                    rays.measured[some],
                    network.cameras[0].lens,
                    ("interior", "exterior", "point"),
                    rays.photo[some],
                )
            per_sigma = rays.per_sigma[:, some]
            np.multiply(by["exterior"], per_sigma, out=A[:6, :, some])
            np.multiply(by["interior"][self.estimated], per_sigma, out=A[6:-4, :, some])
            np.multiply(v, per_sigma, out=A[-4, :, some])
            np.multiply(by["point"], per_sigma, out=A[-3:, :, some])
        if self.held.any():
            A[-3:] *= ~self.held[:, None, rays.point]
        if rays.rho is not None:
            whiten(A, rays.rho)
        return Equations(A)

    def control(self, state: State) -> np.ndarray:
        """Misclosures (3, n) of the control points; 0 for the others."""
        v = np.zeros(state.points.shape)
        if self.network.control is not None:
            index, coordinates, _ = self.network.control
            v[index] = state.points[index] - coordinates
        return v.T

    def bars(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Scale bars: derivatives (s, 3, n), misclosures (s,), standard deviations."""
        bars = self.network.scale_bars
        if not len(bars):
            return None
        a, b = bars[:, :2].T.astype(int)
        difference = state.points[b] - state.points[a]
        distance = np.linalg.norm(difference, axis=1)
        direction = difference / distance[:, None]
        B = np.zeros((len(bars), *state.points.T.shape))
        B[np.arange(len(bars)), :, b] = direction
        B[np.arange(len(bars)), :, a] = -direction
        return B * ~self.held, distance - bars[:, 2], bars[:, 3]

    def objective(self, state: State, v: np.ndarray) -> float:
        """vᵀPv of everything observed; v (2, k) of the rays is over sigma already."""
        phi = np.vdot(v, v) + np.sum(self.control_weight * self.control(state) ** 2)
        if (bars := self.bars(state)) is not None:
            phi += np.sum((bars[1] / bars[2]) ** 2)
        return float(phi)

    def moved(self, state: State, dx: np.ndarray, dx_points: np.ndarray) -> State:
        """The state after corrections of the kept unknowns and of the points (3, n)."""
        U, interior = self.rays.interior, state.interior.copy()
        interior[:, self.estimated] += dx[:U].reshape(len(interior), -1)
        exteriors = state.exteriors + dx[U:].reshape(-1, 6)
        return State(interior, exteriors, state.points + dx_points.T)


# --- Correlated x and y: P has blocks of 2 x 2 ---
#
# Divided by sigma, a ray's coordinates have the covariance R of ones and the
# correlation rho, and R = L Lᵀ with L = ((1, 0), (rho, s)), s^2 = 1 - rho^2.
# Observation equations times L^-1 have P = 1 like all others, and nothing else of the
# adjustment notices. What is said of a single coordinate afterwards needs the way back.
# Foerstner and Wrobel 2016, section 4.6; the same as in `adjustment.result`.


def whiten(values: np.ndarray, rho: np.ndarray) -> None:
    """Multiply equations (..., 2, k) by L^-1, in place."""
    values[..., 1, :] -= rho * values[..., 0, :]
    values[..., 1, :] /= np.sqrt(1 - rho**2)


def unwhiten(values: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Whitened values (2, k) times L: what they were."""
    first, second = values
    return np.array([first, rho * first + np.sqrt(1 - rho**2) * second])


def shares(
    H: np.ndarray, across: np.ndarray, rho: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Redundancy numbers and testable shares (2, k) of the coordinates.

    They are the diagonals of Qvv P = 1 - L A Q Aᵀ L^-1, and of P Qvv P over P with
    P Qvv P = L^-T (1 - A Q Aᵀ) L^-1. Of A Q Aᵀ of the whitened equations, H (2, k) is
    the diagonal, `across` (k,) the element between the two rows of a ray.
    """
    s = np.sqrt(1 - rho**2)
    redundancy_numbers = 1 - H + np.array([across, -across]) * rho / s
    (g_x, g_y), g_xy = 1 - H, -across
    first = g_x * s**2 - 2 * g_xy * rho * s + g_y * rho**2
    return redundancy_numbers, np.array([first, g_y])


def residuals_alone(v: np.ndarray, sigma: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Residuals (k, 2) less what the other coordinate predicts: (P v)_i / P_ii."""
    return v - rho[:, None] * sigma / sigma[:, ::-1] * v[:, ::-1]
