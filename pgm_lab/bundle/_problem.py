"""A network with what stays the same from iteration to iteration."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pgm_lab import _validate
from pgm_lab.bundle.datum import choose
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.rays import Equations, Rays, State, equations
from pgm_lab.bundle.reduced import Reduced, reduce
from pgm_lab.camera import PARAMETERS


@dataclass(frozen=True)
class Problem:
    """A network, its rays, the columns of `camera.PARAMETERS` to estimate, its datum.

    Attributes
    ----------
    network : Network
    rays : Rays
    estimated : ndarray (u,)
    datum : str
    """

    network: Network
    rays: Rays
    estimated: np.ndarray
    datum: str

    @classmethod
    def of(
        cls, network: Network, estimate: Sequence[str], datum: str | None
    ) -> "Problem":
        """Check the names of interior parameters and datum, and sort the rays."""
        _validate.instance(network, Network, "network")
        if isinstance(estimate, str):
            estimate = (estimate,)
        for name in _validate.several(estimate, "estimate"):
            _validate.choice(name, "estimate", PARAMETERS)
        estimated = [i for i, name in enumerate(PARAMETERS) if name in estimate]
        datum = choose(network, datum)
        rays = Rays.of(network, len(estimated))
        return cls(network, rays, np.array(estimated, int), datum)

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

    def redundancy(self, constraints: int) -> int:
        """Observations - unknowns + constraints."""
        network = self.network
        observed = np.count_nonzero(self.control_weight)
        observations = network.xy.size + observed + len(network.scale_bars)
        coordinates = np.count_nonzero(~self.held)
        unknowns = self.rays.kept + coordinates
        return int(observations - unknowns + constraints)

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
        """VᵀPv of everything observed; v (2, k) of the rays is over sigma already."""
        phi = np.vdot(v, v) + np.sum(self.control_weight * self.control(state) ** 2)
        if (bars := self.bars(state)) is not None:
            phi += np.sum((bars[1] / bars[2]) ** 2)
        return float(phi)

    def equations(self, state: State) -> Equations:
        """Observation equations of the rays."""
        return equations(self.network, self.rays, state, self.estimated, ~self.held)

    def normal_equations(self, state: State, eq: Equations) -> Reduced:
        """Normal equations, reduced by the points."""
        return reduce(
            self.rays,
            eq,
            self.control_weight + self.held,
            -self.control_weight * self.control(state),
            self.bars(state),
        )

    def moved(self, state: State, dx: np.ndarray, dx_points: np.ndarray) -> State:
        """The state after corrections of the kept unknowns and of the points (3, n)."""
        U, interior = self.rays.interior, state.interior.copy()
        interior[:, self.estimated] += dx[:U].reshape(len(interior), -1)
        exteriors = state.exteriors + dx[U:].reshape(-1, 6)
        return State(interior, exteriors, state.points + dx_points.T)
