"""What is wrong with the image coordinates: their unit, or the way their axes point.

A free network adjusts in any unit: coordinates in metres give a camera of c = 0.035 mm
and a sigma0 that looks splendid. So they are compared with what the start values make
of them: measured = A computed + t, with A (2, 2) near the identity if all is well and
t of each photo, which takes up most of the error of rough angles.
"""

import numpy as np

from pgm_lab._rounding import plain
from pgm_lab.bundle.network import Network
from pgm_lab.bundle.result import Bundle
from pgm_lab.camera import imaging
from pgm_lab.report._layout import Finding
from pgm_lab.report._words import UM

COORDINATES = "Image coordinates"

# Distances from the middle of a photo in mm that no camera has: the smallest endoscope
# is 0.6 mm wide, the largest aerial photo 230 mm x 460 mm
NEAREST, FARTHEST = 0.25, 300.0
FINEST = 1e-5  # mm; nobody has measured an image to 10 nm
SCALE = 3.0  # by which usable start values never miss the size of the image, or c
UNEXPLAINED = 0.4  # of the spread of the coordinates; start values are too rough above
NARROW = 0.3  # smaller singular value of A over the larger: points in a line below
WIDE = 2.0  # x / c of 63 degrees off the axis

# 2 theta of the reflection (cos, sin; sin, -cos), and what turns axes so
REFLECTED = {
    0: ("count y downwards", "Change the sign of y"),
    90: ("have x and y exchanged", "Exchange the columns x and y (and sx, sy)"),
    180: ("count x to the left", "Change the sign of x"),
    -90: (
        "have x and y exchanged, both with the wrong sign",
        "Exchange the columns and change both signs",
    ),
}


def doubt(network: Network) -> Finding | None:
    """Say that the image coordinates are no mm with x to the right and y up."""
    found = compared(network)
    words, advice = _unit(network, found)
    if not words and found is not None:
        words, advice = _reflected(found)
    if words:
        return Finding(COORDINATES, f"The image coordinates seem to {words}. {advice}.")
    sigma = float(np.median(network.sigma))
    if sigma < FINEST:
        return Finding(
            "Unit of the standard deviations",
            f"Image coordinates are said to have a standard deviation of {sigma:.2g}"
            f" mm. Nobody measures to {UM * UM * FINEST:g} nm: are sx and sy in metres,"
            " or is the exponent wrong? Give them in mm (1 µm is 0.001).",
        )
    return None


def changed_c(result: Bundle) -> Finding | None:
    """Say that a principal distance is not at all what the start value says."""
    start = result.network.interior[:, 0]
    c = np.array([camera.c for camera in result.cameras])
    ratio = np.maximum(c / start, start / c)
    worst = int(np.argmax(ratio))
    if result.status != "converged" or ratio[worst] <= SCALE:
        return None
    return Finding(
        "Principal distance",
        f"c became {plain(c[worst], 3)} mm from a start value of"
        f" {plain(start[worst], 3)} mm. If that one is right, the image coordinates are"
        " not in millimetres, or the start values of stations and points have"
        " different units.",
    )


def compared(network: Network) -> np.ndarray | None:
    """Return A (2, 2) of measured = A computed + t; None if start values are rough.

    `computed` are the image coordinates of the start values, without lens and x0, y0.
    """
    computed, usable = _computed(network)
    if np.sum(usable) < max(6, 0.8 * len(usable)):
        return None
    photo = network.photo[usable]
    p, m = (_reduced(xy[usable], photo) for xy in (computed, network.xy))
    A = np.linalg.lstsq(p, m, rcond=None)[0].T
    unexplained = np.linalg.norm(m - p @ A.T)
    s = np.linalg.svd(A, compute_uv=False)
    if unexplained > UNEXPLAINED * np.linalg.norm(m) or s[1] <= NARROW * s[0]:
        return None
    return A


def _computed(network: Network) -> tuple[np.ndarray, np.ndarray]:
    """Return computed coordinates (k, 2), and where they lie within a photo."""
    of_ray = network.interior[network.camera[network.photo]]
    c = of_ray[:, :1]
    ray, _ = imaging.ray(
        network.exteriors[network.photo], network.points[network.point]
    )
    front = ray[:, 2] < 0
    tangents = -ray[:, :2] / np.where(front, ray[:, 2], -1.0)[:, None]
    return c * tangents, front & (np.hypot(*tangents.T) < WIDE)


def _reduced(xy: np.ndarray, photo: np.ndarray) -> np.ndarray:
    """Return coordinates (k, 2) less the mean of their photo."""
    rays = np.maximum(np.bincount(photo), 1)
    means = np.stack([np.bincount(photo, a) / rays for a in xy.T], axis=1)
    return xy - means[photo]


def _unit(network: Network, A: np.ndarray | None) -> tuple[str, str]:
    """Return what unit the image coordinates have, if it is not mm, and what to do."""
    farthest = float(np.hypot(*network.xy.T).max())
    times = 1.0 if A is None else float(np.sqrt(np.abs(np.linalg.det(A))))
    there = f"the farthest point is {plain(farthest, 3)} from the middle of its photo"
    if 1 / SCALE <= times <= SCALE:
        if NEAREST <= farthest <= FARTHEST:
            return "", ""
        # all of the input in one wrong unit, or no start values to compare with
        times = 1e3 if farthest > FARTHEST else 1e-3
    else:
        ratio = max(times, 1 / times)
        size = "too large" if times > 1 else "too small"
        there += f", {plain(ratio, 2)} times {size} for c and the start values"
    if times > 1:
        return (
            f"be in pixels or micrometres, not in millimetres: {there}",
            "Columns and rows of pixels become x = (column - middle column) times the"
            " size of a pixel in mm, and y = (middle row - row) times that size; c, sx"
            " and sy are in mm too",
        )
    unit = "be in centimetres" if times > 0.03 else "be in metres"
    factor = 10 if times > 0.03 else 1000
    return (
        f"{unit}, not in millimetres: {there}",
        f"Multiply x and y by {factor}, and sx and sy (and c) where they have the same"
        " unit",
    )


def _reflected(A: np.ndarray) -> tuple[str, str]:
    """Return which axes of the image are the wrong way round, and what to do."""
    if np.linalg.det(A) > 0:
        return "", ""
    twice = np.degrees(np.arctan2(A[0, 1] + A[1, 0], A[0, 0] - A[1, 1]))
    nearest = int(90 * np.round(twice / 90))
    words, advice = REFLECTED[180 if abs(nearest) == 180 else nearest]
    return (
        f"{words}, compared with the start values",
        f"{advice}: x must point right and y up, seen in the photo. If that is so, the"
        " start values are a mirror image",
    )
