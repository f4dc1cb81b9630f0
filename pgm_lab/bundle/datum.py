"""The datum of a network: seven motions that no image notices, and how to stop them.

An image does not change when the whole network, points and cameras, is shifted, turned
or scaled: these are the columns of G (M 2.95), here for the exterior orientations too.
A solution of the singular normal equations is brought into any other datum by such a
motion alone (S-transformation, Baarda 1973).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import normal
from pgm_lab.bundle._coupling import flat
from pgm_lab.bundle.dense import G
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.rays import State

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
NEGLIGIBLE = 1e-9


@dataclass(frozen=True)
class Motions:
    """Directions in which the network may move without a change in any image.

    Attributes
    ----------
    kept : ndarray (U + 6 m, d)
        Their part in the interior (0) and exterior orientations.
    points : ndarray (d, 3, n)
        Their part in the points: the transposed G of (M 2.95).
    """

    kept: np.ndarray
    points: np.ndarray

    @property
    def number(self) -> int:
        """How many directions there are, d."""
        return self.kept.shape[1]

    def some(self, which: slice | np.ndarray) -> "Motions":
        """Return some of the motions, by a slice or their indices."""
        return Motions(self.kept[:, which], self.points[which])


def motions(positions: ArrayLike, centre: ArrayLike = (0, 0, 0)) -> np.ndarray:
    """Displacements of points by the seven motions that no photo notices.

    Parameters
    ----------
    positions : array_like (n, 3)
        Projection centres or object points.
    centre : array_like (3,)
        What the rotations and the scale leave in place.

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
    positions = _validate.points(positions, 3, "positions")
    centre = _validate.one_point(centre, 3, "centre")
    arms = _validate.points(positions, 3, "positions") - centre
    return G(arms).reshape(-1, 3, 7).transpose(2, 0, 1)


def all_motions(state: State, interior: int) -> Motions:
    """All seven motions (`MOTIONS`), about the centre of the points, of similar size.

    A turn by the vector w moves a point by w x X, and changes the angles so that
    M (X - X0) stays: the camera turns about M w.
    """
    centre = state.points.mean(axis=0)
    everything = np.concatenate([state.exteriors[:, :3], state.points]) - centre
    size = np.linalg.norm(everything) / np.sqrt(everything.size) or 1.0
    m = len(state.exteriors)
    move = G(everything / size).reshape(-1, 3, 7)
    kept = np.zeros((interior + 6 * m, 7))
    exterior = kept[interior:].reshape(m, 6, 7)
    exterior[:, :3] = move[:m]
    exterior[:, 3:, 3:6] = _angles_by_turn(state.exteriors) / size
    return Motions(kept, np.ascontiguousarray(move[m:].T))


def _angles_by_turn(exteriors: np.ndarray) -> np.ndarray:
    """Changes of (omega, phi, kappa), the rows, by turns about X, Y and Z: (m, 3, 3).

    The axes of omega, phi and kappa in the object frame, X, (0, cos omega, sin omega)
    and the third row of M, times the changes of the angles are the turn.
    """
    (so, sp, _), (co, cp, _) = np.sin(exteriors.T[3:]), np.cos(exteriors.T[3:])
    by = np.zeros((3, 3, len(exteriors)))
    by[1, 1:] = co, so
    by[2, 1:] = -so / cp, co / cp
    by[0] = -sp * by[2]
    by[0, 0] = 1
    return by.transpose(2, 0, 1)


def free_motions(network: Network, state: State, interior: int) -> Motions:
    """The motions that neither control points nor scale bars forbid."""
    all_seven = all_motions(state, interior)
    if not is_controlled(network):
        return all_seven.some(slice(6)) if len(network.scale_bars) else all_seven
    stopped = [np.eye(7)[6:]] if len(network.scale_bars) else []
    point, axis = np.nonzero(network.known)
    stopped.append(all_seven.points[:, axis, point].T)
    rows = np.concatenate(stopped)
    _, size, directions = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.sum(size > 1e-8 * max(len(rows), 1)))
    free = directions[rank:].T
    return Motions(
        all_seven.kept @ free, np.einsum("qin,qd->din", all_seven.points, free)
    )


def is_controlled(network: Network) -> bool:
    """Whether the network has control points, held or weighted."""
    return len(network.fixed) > 0 or network.control is not None


def choose(network: Network, datum: str | None) -> str:
    """The datum asked for, or the natural one of the network."""
    if datum is not None:
        datum = _validate.choice(datum, "datum", DATUMS)
    controlled = is_controlled(network)
    if datum is None:
        return "fixed" if controlled else "inner"
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


def constraint(network: Network, datum: str, move: Motions) -> Motions:
    """The inner constraints: rows R of kept and points, R times all unknowns is 0.

    Scaled so that R times the motions is the unit matrix.
    """
    kept, points = _parts_in_datum(network, datum, move)
    inverse = np.linalg.inv(_product(kept, points, move))
    of_points = (inverse @ flat(points)).reshape(points.shape)
    return Motions(kept @ inverse.T, of_points)


def check_constraint(network: Network, datum: str, move: Motions) -> None:
    """Refuse a datum that lies in one line: it does not stop the turn about it."""
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
