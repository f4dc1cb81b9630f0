"""A smooth field through scattered shifts: thin-plate spline and kriging in one.

The spline that smooths by the standard deviations of the shifts is the best linear
prediction of a random field in white noise. The variances of both follow from the
shifts by restricted maximum likelihood, and from these the field's own uncertainty.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy

FEWEST = 8  # points: three for the plane, and some to tell noise from the field
KNOTS = 500  # points that the spline is fitted to, at most: all are solved for at once
NEIGHBOURS = 8  # around a point, which should have moved alike
ALPHA = 0.001  # share of good points that are taken for blunders
LIMIT = np.sqrt(-2 * np.log(ALPHA))  # 3.72 standard deviations, in two dimensions
MAX_ITERATIONS = 5  # of selecting the points that agree
RATIOS = np.logspace(-6, 12, 73)  # variance of the field over that of the noise
LATTICE = 4  # points of the lattice from one knot to the next, for many places
AT_ONCE = 5000  # places, for the rest on a lattice


@dataclass(frozen=True, eq=False)
class Field:
    """Shifts (dx, dy) as a smooth function of the place."""

    used: np.ndarray  # (n,) which of the points that were given fit it
    # (n, 2) field minus shift of all of them; what was used is predicted by the others
    residuals: np.ndarray
    free: np.ndarray  # (n, 2) share that the others do not determine: 1 where not used
    sigma0: np.ndarray  # (2,) noise relative to the given standard deviations, >= 1
    spline: "Spline" = field(repr=False)

    def at(self, places: np.ndarray) -> np.ndarray:
        """Shifts (..., 2) at places (..., 2): where there are many, on a lattice."""
        flat = places.reshape(-1, 2)
        if len(flat) <= AT_ONCE:
            return self.spline.at(flat).reshape(places.shape)
        knots = self.spline.knots
        spacing = np.sqrt(np.prod(np.ptp(knots, axis=0)) / len(knots))
        step = max(spacing / LATTICE, 1.0)
        # Three points more on each side: a cubic spline bends at its ends
        low = flat.min(axis=0) - 3 * step
        number = np.ceil((flat.max(axis=0) - low) / step).astype(int) + 4
        x, y = (a + step * np.arange(n) for a, n in zip(low, number))
        values = self.spline.at(np.stack(np.meshgrid(x, y), -1).reshape(-1, 2))
        values = values.reshape(len(y), len(x), 2)
        rows = ((flat - low) / step).T[::-1]
        found = [
            scipy.ndimage.map_coordinates(values[..., i], rows, mode="nearest")
            for i in range(2)
        ]
        return np.stack(found, axis=-1).reshape(places.shape)


@dataclass(frozen=True, eq=False)
class Spline:
    """The equations of a field, solved.

    In units of the standard deviations, with the kernel K of the knots and a plane P:
    (ratio K + I) a + P b = d, Pᵀ a = 0, for dx and dy each with its own ratio.
    """

    knots: np.ndarray  # (m, 2)
    sd: np.ndarray  # (m,)
    ratio: np.ndarray  # (2,)
    sigma0: np.ndarray  # (2,)
    inverse: np.ndarray  # (2, m + 3, m + 3)
    solution: np.ndarray  # (2, m + 3)

    @classmethod
    def through(cls, knots: np.ndarray, shifts: np.ndarray, sd: np.ndarray) -> "Spline":
        """Estimate the ratios, and solve."""
        m = len(knots)
        plane, kernel = _basis(knots, knots)
        K, P, d = kernel / sd / sd[:, None], plane / sd[:, None], shifts / sd[:, None]
        # Without the plane and along the eigenvectors of the kernel, the shifts are
        # independent, of variance sigma0^2 (1 + ratio e)
        Z = scipy.linalg.qr(P)[0][:, 3:]
        e, U = scipy.linalg.eigh(Z.T @ K @ Z, driver="evd")
        variance = 1 + RATIOS[:, None] * np.maximum(e, 0)
        profile = (1 / variance) @ (U.T @ (Z.T @ d)) ** 2 / (m - 3)  # (ratios, 2)
        sigma2 = np.maximum(profile, 1.0)  # where the field is rough it takes the noise
        minus_log = (m - 3) * (np.log(sigma2) + profile / sigma2)
        minus_log += np.log(variance).sum(axis=1)[:, None]
        best = minus_log.argmin(axis=0)
        # Solve
        A = np.zeros((2, m + 3, m + 3))
        A[:, :m, :m] = RATIOS[best, None, None] * K + np.eye(m)
        A[:, :m, m:], A[:, m:, :m] = P, P.T
        inverse = np.linalg.inv(A)
        solution = np.stack([one[:, :m] @ b for one, b in zip(inverse, d.T)])
        sigma0 = np.sqrt(sigma2[best, [0, 1]])
        return cls(knots, sd, RATIOS[best], sigma0, inverse, solution)

    @property
    def free(self) -> np.ndarray:
        """Share (m, 2) of each shift that the others do not determine."""
        m = len(self.knots)
        return np.diagonal(self.inverse, axis1=1, axis2=2)[:, :m].T

    @property
    def left_out(self) -> np.ndarray:
        """What the others predict of each shift, minus the shift (m, 2), in pixels."""
        return -self.sd[:, None] * self.solution[:, : len(self.knots)].T / self.free

    def at(self, places: np.ndarray) -> np.ndarray:
        """Shifts (n, 2)."""
        found = np.zeros((len(places), 2))
        for part in (slice(i, i + AT_ONCE) for i in range(0, len(places), AT_ONCE)):
            for i in range(2):
                found[part, i] = self._equations(places[part], i) @ self.solution[i]
        return found

    def sd_at(self, places: np.ndarray) -> np.ndarray:
        """Standard deviations (n, 2) of the field, in pixels."""
        # A field may be smoother than the spline takes it for: judged by how far each
        # shift is from what the others predict of it
        found = np.zeros((len(places), 2))
        off = self.left_out * np.sqrt(self.free) / (self.sigma0 * self.sd[:, None])
        judged = np.sqrt(np.mean(off**2, axis=0))
        for i in range(2):
            b = self._equations(places, i)
            variance = -np.sum((b @ self.inverse[i]) * b, axis=1)
            sd = self.sigma0[i] * np.sqrt(np.maximum(variance, 0))
            found[:, i] = judged[i] * sd
        return found

    def _equations(self, places: np.ndarray, i: int) -> np.ndarray:
        plane, kernel = _basis(places, self.knots)
        return np.hstack([self.ratio[i] * kernel / self.sd, plane])


def fit(points: np.ndarray, shifts: np.ndarray, sd: np.ndarray) -> Field | None:
    """Fit a field to shifts (n, 2) of some points; None where no `FEWEST` agree."""
    # Points that do not move as the field says are left out: first by their neighbours,
    # then by the field of the others
    good = _as_neighbours(points, shifts, sd)
    found = None
    for _ in range(MAX_ITERATIONS):
        k = _some(np.flatnonzero(good))
        if len(k) < FEWEST or np.linalg.matrix_rank(points[k] - points[k[0]]) < 2:
            return None
        spline = Spline.through(points[k], shifts[k], sd[k])
        # Compare each shift with what the others say of it
        off, free = spline.at(points) - shifts, np.ones_like(shifts)
        of_off = np.hypot(spline.sd_at(points), sd[:, None] * spline.sigma0)
        off[k], free[k] = spline.left_out, spline.free
        of_off[k] = spline.sigma0 * sd[k, None] / np.sqrt(spline.free)
        standardized = off / np.maximum(of_off, np.finfo(float).tiny)
        found = Field(good, off, free, spline.sigma0, spline)
        good = np.linalg.norm(standardized, axis=1) <= LIMIT
        if np.array_equal(found.used, good):
            break
    return found


def _as_neighbours(
    points: np.ndarray, shifts: np.ndarray, sd: np.ndarray
) -> np.ndarray:
    """Which points (n,) have moved about as those around them."""
    if len(points) < FEWEST:
        return np.ones(len(points), bool)
    number = min(NEIGHBOURS + 1, len(points))
    _, near = scipy.spatial.cKDTree(points).query(points, number)
    off = shifts - np.median(shifts[near[:, 1:]], axis=1)
    length = np.linalg.norm(off, axis=1)
    return length <= LIMIT * max(np.median(length), np.median(sd))


def _some(k: np.ndarray) -> np.ndarray:
    """All of them, or as many as can be knots."""
    if len(k) <= KNOTS:
        return k
    return np.sort(np.random.default_rng(1).choice(k, KNOTS, replace=False))


def _basis(places: np.ndarray, knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The plane (n, 3) and the kernel r^2 log r^2 (n, m), in the size of the knots."""
    centre, size = knots.mean(axis=0), np.ptp(knots, axis=0).max()
    a, b = (places - centre) / size, (knots - centre) / size
    r2 = scipy.spatial.distance.cdist(a, b, "sqeuclidean")
    return np.column_stack([np.ones(len(a)), a]), scipy.special.xlogy(r2, r2)
