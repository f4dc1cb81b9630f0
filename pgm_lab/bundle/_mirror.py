"""Images and objects that are the wrong way round.

An image with one axis turned round fits no better and no worse than the right one: the
camera, or the object, comes out as its mirror image.
"""

import numpy as np

from pgm_lab.bundle._rays import State, behind
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.result import Bundle
from pgm_lab.camera import Camera

# How many times better a mirror image must fit. Points in a plane fit one as well as
# the other, and their errors then decide which fits a little better.
BETTER = 2.0

AXES = "x must point right and y up, seen in the photo."
LOOKING = (
    "The camera looks along its -z axis here. If your angles are those of a camera that"
    " looks along +z, with y downwards as in OpenCV, change the sign of y and of the"
    " last two rows of each rotation matrix"
)


def cameras(network: Network, state: State, status: str) -> tuple[Camera, ...]:
    """Return the adjusted cameras, or refuse one with a c that no camera has."""
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
    return tuple(Camera(*interior, lens=lens) for interior in state.interior)


def _cause(network: Network, state: State, status: str, b1: float) -> str:
    """Say why c came out negative, from where the points lie and from what b1 does."""
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
    """Say that the affinity of a camera turns the image over."""
    several = len(result.cameras) > 1
    turned = [
        f"b1{f' of camera {number}' if several else ''} = {camera.b1:.3f}"
        for number, camera in enumerate(result.cameras, start=1)
        if 1 + camera.b1 < 0
    ]
    if result.status != "converged" or not turned:
        return None
    return (
        f"{', '.join(turned)} turns x round, as x (1 + b1) has the other sign: is x"
        f" counted to the left, y downwards, or are the two exchanged? {AXES} Correct"
        " the image coordinates and adjust again: these K, P and b are not those of"
        " the lens."
    )


def mirrored_object(result: Bundle) -> str | None:
    """Say that the adjusted points are a mirror image of their start values.

    Of all rotations R and scales, v'v of the start values is least by the singular
    values s of their product with the adjusted points; the last counts negative if the
    best R would be a reflection (Umeyama 1991).
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
    if rotated < BETTER * mirrored:
        return None
    return (
        f"The points fit their start values {rotated / mirrored:.0f} times better as"
        " a mirror image than as they are. Is y of the image counted downwards, x to"
        f" the left, or are the two exchanged? {AXES} Or are the start values mirrored?"
    )
