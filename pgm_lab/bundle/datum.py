"""The datum of a network: seven motions that no image notices, and how to stop them.

An image does not change when the whole network, points and cameras, is shifted, rotated
or scaled: these are the columns of G (M 2.95), here for the exterior orientations too.
A solution of the singular normal equations is brought into any other datum by such a
motion alone (S-transformation, Baarda 1973).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import normal
from pgm_lab.bundle.dense import G
from pgm_lab.bundle.equations import State
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.reduced import Reduced, flat

DATUMS = ("inner", "photos", "fixed", "none")
MOTIONS = (
    "shift in X",
    "shift in Y",
    "shift in Z",
    "rotation about X",
    "rotation about Y",
    "rotation about Z",
    "scale",
)


@dataclass(frozen=True)
class Motions:
    """Directions in which the network may move without a change in any image.

    `kept` (U + 6 m, d) is their part in the interior (0) and exterior orientations,
    `points` (d, 3, n) that in the points: the transposed G of (M 2.95).
    """

    kept: np.ndarray
    points: np.ndarray

    @property
    def number(self) -> int:
        """How many directions there are, d."""
        return self.kept.shape[1]


def motions(positions: ArrayLike, centre: ArrayLike = (0, 0, 0)) -> np.ndarray:
    """Displacements of points by the seven motions that no photo notices.

    Parameters
    ----------
    positions : array_like (n, 3)
        Projection centres or object points.
    centre : array_like (3,)
        Fixed point of rotations and scale.

    Returns
    -------
    ndarray (7, n, 3)
        Three shifts by 1, three rotations by 1 rad, a scale of 1 + 1, all linear.

    References
    ----------
    Muliawan 2013, (M 2.95): `dense.G` holds these as columns, about the origin.

    Examples
    --------
    >>> motions([[0.0, 2.0, 0.0]])[[0, 3, 6], 0]
    array([[1., 0., 0.],
           [0., 0., 2.],
           [0., 2., 0.]])
    """
    positions = _validate.of_shape(positions, (None, 3), "positions")
    centre = _validate.one_point(centre, 3, "centre")
    return G(positions - centre).reshape(-1, 3, 7).transpose(2, 0, 1)


def all_motions(state: State, interior: int) -> Motions:
    """All seven motions (`MOTIONS`), about the centre of the points, of similar size.

    A rotation by the vector w moves a point by w x X, and changes the angles so that
    M (X - X0) stays: the camera rotates by M w.
    """
    centre = state.points.mean(axis=0)
    everything = np.concatenate([state.exteriors[:, :3], state.points]) - centre
    size = np.linalg.norm(everything) / np.sqrt(everything.size) or 1.0
    m = len(state.exteriors)
    move = G(everything / size).reshape(-1, 3, 7)
    kept = np.zeros((interior + 6 * m, 7))
    exterior = kept[interior:].reshape(m, 6, 7)
    exterior[:, :3] = move[:m]
    exterior[:, 3:, 3:6] = _angles_by_rotation(state.exteriors) / size
    return Motions(kept, np.ascontiguousarray(move[m:].T))


def _angles_by_rotation(exteriors: np.ndarray) -> np.ndarray:
    """Changes of (omega, phi, kappa), the rows, by rotations about X, Y, Z."""
    # The axes of the three angles in the object frame, X, (0, cos omega, sin omega) and
    # the third row of M, times their changes are the rotation
    (so, sp, _), (co, cp, _) = np.sin(exteriors.T[3:]), np.cos(exteriors.T[3:])
    by = np.zeros((3, 3, len(exteriors)))
    by[1, 1:] = co, so
    by[2, 1:] = -so / cp, co / cp
    by[0] = -sp * by[2]
    by[0, 0] = 1
    return by.transpose(2, 0, 1)


def free_motions(network: Network, state: State, interior: int) -> Motions:
    """The motions that neither control points nor scale bars prevent."""
    every = all_motions(state, interior)
    bars = len(network.scale_bars) > 0
    if not is_controlled(network):
        d = 6 if bars else 7
        return Motions(every.kept[:, :d], every.points[:d])
    point, axis = np.nonzero(network.known)
    rows = np.concatenate([np.eye(7)[6:][:bars], every.points[:, axis, point].T])
    _, size, directions = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.sum(size > 1e-8 * max(len(rows), 1)))
    free = directions[rank:].T
    return Motions(every.kept @ free, np.einsum("qin,qd->din", every.points, free))


def is_controlled(network: Network) -> bool:
    """Whether the network has control points, held or weighted."""
    return len(network.fixed) > 0 or network.control is not None


def choose(network: Network, datum: str | None) -> str:
    """The datum asked for, or the natural one of the network."""
    controlled = is_controlled(network)
    if datum is None:
        return "fixed" if controlled else "inner"
    datum = _validate.choice(datum, "datum", DATUMS)
    if datum in ("inner", "photos") and controlled:
        raise ValueError(
            f"datum={datum!r} is for networks without control: control points fix the"
            " datum already. Leave `fixed` and `control` out, or take datum='fixed'"
        )
    if datum == "fixed" and not controlled:
        raise ValueError(
            "datum='fixed' needs `fixed` or `control` points in the network"
        )
    return datum


# --- Inner constraints ---


def constraint(network: Network, datum: str, move: Motions) -> Motions:
    """The inner constraints: rows R of kept and points, R times all unknowns is 0.

    Scaled so that R times the motions is the unit matrix.
    """
    kept, points = _parts_in_datum(network, datum, move)
    inverse = np.linalg.inv(_product(kept, points, move))
    of_points = (inverse @ flat(points)).reshape(points.shape)
    return Motions(kept @ inverse.T, of_points)


def check_constraint(network: Network, datum: str, move: Motions) -> None:
    """Refuse a datum that lies in one line: it does not stop the rotation about it."""
    kept, points = _parts_in_datum(network, datum, move)
    GH = _product(kept, points, move)
    if move.number and normal.null_space(GH).defect:
        raise ValueError(
            "the datum needs at least three points that do not lie in one line; take"
            " more datum_points"
            if datum == "inner"
            else "datum='photos' needs at least three projection centres that do not"
            " lie in one line; take datum='inner'"
        )


def _parts_in_datum(
    network: Network, datum: str, move: Motions
) -> tuple[np.ndarray, np.ndarray]:
    """The motions of the datum points, or of the projection centres; 0 elsewhere."""
    kept, points = np.zeros_like(move.kept), np.zeros_like(move.points)
    if datum == "inner":
        some = network.datum_points
        chosen = slice(None) if some is None else some
        points[..., chosen] = move.points[..., chosen]
    else:
        m = len(network.exteriors)
        centres = len(kept) - 6 * m + 6 * np.arange(m)[:, None] + np.arange(3)
        kept[centres] = move.kept[centres]
    return kept, points


def _product(kept: np.ndarray, points: np.ndarray, move: Motions) -> np.ndarray:
    return kept.T @ move.kept + flat(points) @ flat(move.points).T


def s_transformation(
    reduced: Reduced,
    Q: np.ndarray,
    points: np.ndarray,
    move: Motions,
    constraint: Motions,
) -> tuple[np.ndarray, np.ndarray]:
    """Cofactors of the kept unknowns and of the points (3, 3, n) in the datum.

    S-transformation x - H t with the motions t = R x. With Q(t, x) and Q(t, t) by
    propagation, the new cofactors of x are Q - H Q(t, x) - Q(x, t) Hᵀ + H Q(t, t) Hᵀ.
    """
    R, R_points = constraint.kept, constraint.points
    H, H_points = move.kept, move.points
    lever = R - reduced.times_points(R_points)  # Q(t, kept) = lever' Q
    Q_t_kept = lever.T @ Q
    VR = np.einsum("ijn,qjn->qin", reduced.V_inverse, R_points)
    RVR = flat(VR) @ flat(R_points).T
    if (bars := reduced.bars) is not None:
        RC = flat(R_points) @ flat(bars.C).T
        RVR -= RC @ bars.K @ RC.T
        VR -= np.einsum("qs,sin->qin", RC @ bars.K, bars.C)
    Q_tt = RVR + Q_t_kept @ lever
    Q_t_points = VR - reduced.times_kept(Q_t_kept.T)

    HQ = H @ Q_t_kept
    kept = Q - HQ - HQ.T + H @ Q_tt @ H.T
    HQ = np.einsum("qin,qjn->ijn", H_points, Q_t_points)
    QH = np.einsum("qr,rjn->qjn", Q_tt, H_points)
    HQH = np.einsum("qin,qjn->ijn", H_points, QH)
    return kept, points - HQ - HQ.swapaxes(0, 1) + HQH
