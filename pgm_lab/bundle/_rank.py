"""What a network does not determine, by name."""

import numpy as np

from pgm_lab import imaging, normal, rotation
from pgm_lab.bundle._datum import MOTIONS, Motions
from pgm_lab.bundle._reduced import Reduced
from pgm_lab.bundle.network import Network
from pgm_lab.normal import NullSpace, RankDefect

ANGLES = ("omega", "kappa")


class NetworkDefect(RankDefect):
    """The network does not determine all unknowns; the message says which, and why.

    `null_space.names` are the unknowns, or motions, that stay free.
    """

    def __init__(self, message: str, names: tuple[str, ...], vectors=None):
        vectors = np.zeros((0, len(names))) if vectors is None else vectors
        self.null_space = NullSpace(vectors, names)
        ValueError.__init__(self, message)


def check_counts(network: Network) -> None:
    """Refuse points with fewer than two rays and photos with fewer than three.

    A coordinate that is held, or observed as a control coordinate, needs no ray.
    """
    known = network.held
    if network.control is not None:
        index, _, sigma = network.control
        known[index] |= np.isfinite(sigma)
    rays = network.rays_of_points
    weak = 2 * rays < 3 - known.sum(axis=1)
    if np.any(weak):
        counted = _listed(
            [
                f"{network.point_names[i]} ({rays[i]} ray{'' if rays[i] == 1 else 's'})"
                for i in np.flatnonzero(weak)
            ]
        )
        raise NetworkDefect(
            f"a point needs at least two rays; too few has point {counted}. Measure it"
            " in more photos, leave it out, or give it as a control point",
            tuple(f"point {network.point_names[i]}" for i in np.flatnonzero(weak)),
        )
    rays = network.rays_of_photos
    weak = np.flatnonzero(rays < 3)
    if len(weak):
        counted = _listed([f"{network.photo_names[i]} ({rays[i]})" for i in weak])
        raise NetworkDefect(
            "a photo needs at least three points for its six unknowns; too few has"
            f" photo {counted}. Measure more points in it, or leave it out",
            tuple(f"photo {network.photo_names[i]}" for i in weak),
        )


def check_attitudes(network: Network, exteriors: np.ndarray) -> None:
    """Refuse photos at the gimbal lock, where omega and kappa turn about one axis."""
    M = imaging.attitude(exteriors)
    locked = np.flatnonzero(rotation.is_gimbal(M, cosine=1e-6))
    if len(locked):
        names = [str(network.photo_names[i]) for i in locked]
        raise NetworkDefect(
            f"photo {_listed(names)} has phi = +-90 degrees (gimbal lock): omega and"
            " kappa cannot be told apart. Turn the object frame, for example by 90"
            " degrees about Z",
            tuple(f"{angle} of photo {i}" for i in names for angle in ANGLES),
        )


def check_datum(network: Network, datum: str, move: Motions) -> None:
    """Refuse a network that may move, if its datum does not stop that."""
    d = move.number
    if not d or datum in ("inner", "photos"):
        return
    names = MOTIONS[:d] if d == 7 else (f"{d} of the 7 motions",)
    which = ", ".join(names) if d > 5 else f"{d} of its 7 motions"
    raise NetworkDefect(
        f"the datum is not determined, rank defect {d}: no image notices {which}."
        " Take datum='inner' (inner constraints), in a network without control, or more"
        " control coordinates: at least seven, on three points that do not lie in one"
        " line",
        tuple(names),
        move.kept,
    )


def check_points(network: Network, reduced: Reduced) -> None:
    """Refuse points whose rays do not intersect."""
    bad = np.flatnonzero(~reduced.determined)
    if len(bad):
        names = [str(network.point_names[i]) for i in bad]
        raise NetworkDefect(
            f"the rays of point {_listed(names)} are parallel or fall together: they do"
            " not say how far away it is. Measure it in a photo from another side, or"
            " leave it out",
            tuple(f"point {name}" for name in names),
        )


def refuse_kept(scaled: np.ndarray, names: tuple[str, ...]) -> None:
    """Name the interior and exterior unknowns that a singular matrix leaves free.

    `scaled` is the reduced normal matrix, scaled by the diagonal before the reduction:
    what is left of a direction says how much of it the points have not taken away.
    """
    eigenvalues, vectors = np.linalg.eigh(scaled)
    free = vectors[:, eigenvalues < len(names) / normal.INFLATION_LIMIT]
    free = free if free.size else vectors[:, :1]
    part = np.linalg.norm(free, axis=1)
    some = tuple(name for name, p in zip(names, part) if p > 0.1 * part.max())
    raise NetworkDefect(
        f"the reduced normal matrix has rank {len(names) - free.shape[1]} of"
        f" {len(names)}: the rays do not determine {_listed(some)}. Add"
        " photos that converge and are rolled by 90 degrees, leave parameters out of"
        " `estimate`, or, where there are control points, add some at other depths",
        some,
        free,
    )


def _listed(names) -> str:
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return ", ".join(map(str, names[:8])) + more
