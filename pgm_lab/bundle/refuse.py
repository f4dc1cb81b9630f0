"""What a network does not determine, by name, and images that are mirrored.

An image with one axis reversed fits no better and no worse than the right one: the
camera, or the object, comes out as its mirror image.
"""

from collections.abc import Sequence

import numpy as np

from pgm_lab.adjustment import normal
from pgm_lab.adjustment.normal import NullSpace, RankDefect
from pgm_lab.bundle.datum import MOTIONS, Motions
from pgm_lab.bundle.equations import State, behind
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.reduced import Reduced
from pgm_lab.bundle.result import Bundle
from pgm_lab.camera import PARAMETERS, Camera

ANGLES = ("omega", "kappa")
GIMBAL_LOCK = 1e-6  # cos phi below which omega and kappa have one axis

# How many times better a mirror image must fit: points in a plane fit both equally
# well, but for their errors
MIRROR_RATIO = 2.0

AXES = "x must point right and y up, seen in the photo."
LOOKING = (
    "The camera looks along its -z axis here. If your angles are those of a camera that"
    " looks along +z, with y downwards as in OpenCV, change the sign of y and of the"
    " last two rows of each rotation matrix"
)


class NetworkDefect(RankDefect):
    """The network does not determine all unknowns; the message says which, and why.

    `null_space.names` are the unknowns, or motions, that stay free.
    """

    def __init__(
        self,
        message: str,
        names: tuple[str, ...],
        vectors: np.ndarray | None = None,
    ):
        vectors = np.zeros((0, len(names))) if vectors is None else vectors
        self.null_space = NullSpace(vectors, names)
        ValueError.__init__(self, message)


def check_counts(network: Network) -> None:
    """Refuse points with fewer than two rays and photos with fewer than three.

    A coordinate that is held, or observed as a control coordinate, needs no ray.
    """
    for what, names, rays, weak, message in (
        (
            "point",
            network.point_names,
            network.rays_of_points,
            network.too_few_rays,
            "a point needs at least two rays: point {}. Measure it in more photos,"
            " leave it out, or give it as a control point",
        ),
        (
            "photo",
            network.photo_names,
            network.rays_of_photos,
            network.rays_of_photos < 3,
            "a photo needs at least three points for its six unknowns: photo {}."
            " Measure more points in it, or leave it out",
        ),
    ):
        if np.any(weak):
            found = [(names[i], rays[i] or "none") for i in np.flatnonzero(weak)]
            counted = [f"{name} has {number}" for name, number in found]
            raise NetworkDefect(
                message.format(_listed(counted)),
                tuple(f"{what} {name}" for name, _ in found),
            )


def check_attitudes(network: Network, exteriors: np.ndarray) -> None:
    """Refuse photos at the gimbal lock, where omega and kappa have one axis."""
    locked = np.flatnonzero(np.abs(np.cos(exteriors[:, 4])) < GIMBAL_LOCK)
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
            f"the rays of point {_listed(names)} are parallel or coincide: they do not"
            " determine its distance. Measure it in a photo taken from another side, or"
            " leave it out",
            tuple(f"point {name}" for name in names),
        )


def refuse_kept(scaled: np.ndarray, names: tuple[str, ...]) -> None:
    """Name the interior and exterior unknowns that a singular matrix leaves free.

    `scaled` is the reduced normal matrix, scaled by the diagonal before the reduction:
    what is left of a direction is not yet absorbed by the points.
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
        " `estimate` or, where there are control points, add some at other depths",
        some,
        free,
    )


def _listed(names: Sequence) -> str:
    """Join the first eight names, and count the others."""
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return ", ".join(map(str, names[:8])) + more


def cameras(network: Network, state: State, status: str) -> tuple[Camera, ...]:
    """Return the adjusted cameras; a c that is not positive is an error."""
    wrong = np.flatnonzero(~(state.interior[:, 0] > 0))
    if len(wrong):
        c, b1 = state.interior[wrong[0], [0, 8]]
        several = len(network.cameras) > 1
        of_camera = f" of camera {wrong[0] + 1}" if several else ""
        raise ValueError(
            f"the adjustment ends with c{of_camera} = {c:.4g} mm, which must be"
            f" positive. {_cause(network, state, status, b1)}"
        )
    lens = network.cameras[0].lens
    return tuple(
        Camera(**dict(zip(PARAMETERS, interior)), lens=lens)
        for interior in state.interior.tolist()
    )


def _cause(network: Network, state: State, status: str, b1: float) -> str:
    """Why c came out negative: by the side of the points, and by b1."""
    if status != "converged":
        return (
            "Is the image mirrored: y counted downwards, x to the left, or the two"
            f" exchanged? {AXES} If that is so, check the start values, or estimate"
            " fewer parameters"
        )
    if 2 * len(behind(network, state.exteriors, state.points)) > len(network.xy):
        return f"Most points lie behind their photos: the image is mirrored. {LOOKING}"
    if 1 + b1 < 0:
        return (
            "The image is mirrored: is y counted downwards, as rows of pixels are?"
            f" {AXES} Change the sign of y and adjust again"
        )
    return (
        "The image is mirrored in x and in y, that is turned by 180 degrees: is y"
        f" counted downwards and x to the left? {AXES} Change both signs, or add pi to"
        " each kappa, and adjust again"
    )


def mirrored_image(result: Bundle) -> str | None:
    """Warning if the affinity of a camera mirrors the image, else None."""
    several = len(result.cameras) > 1
    reversed_x = [
        f"b1{f' of camera {number}' if several else ''} = {camera.b1:.3f}"
        for number, camera in enumerate(result.cameras, start=1)
        if 1 + camera.b1 < 0
    ]
    if result.status != "converged" or not reversed_x:
        return None
    return (
        f"{', '.join(reversed_x)} reverses x, as x (1 + b1) has the other sign: is x"
        f" counted to the left, y downwards, or are the two exchanged? {AXES} Correct"
        " the image coordinates and adjust again: these K, P and b are not those of"
        " the lens."
    )


def mirrored_object(result: Bundle) -> str | None:
    """Warning if the adjusted points are a mirror image of their start values.

    By the singular values s of their product (Umeyama 1991): the last counts negative
    if the best rotation would be a reflection.
    """
    start, points = (X - X.mean(axis=0) for X in (result.network.points, result.points))
    U, s, Vt = np.linalg.svd(start.T @ points)
    if result.status != "converged" or np.linalg.det(U @ Vt) > 0:
        return None
    signs = np.array([[1, 1, -1], [1, 1, 1]])  # of the rotation, and of the reflection
    size = np.sum(start**2)
    rotated, mirrored = np.sqrt(
        np.maximum(size - (signs @ s) ** 2 / np.sum(points**2), 1e-12 * size)
    )
    if rotated < MIRROR_RATIO * mirrored:
        return None
    return (
        f"The points fit their start values {rotated / mirrored:.0f} times better as"
        " a mirror image than as they are. Is y of the image counted downwards, x to"
        f" the left, or are the two exchanged? {AXES} Or are the start values mirrored?"
    )
