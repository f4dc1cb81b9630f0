"""The likely slip behind two photos that do not fit: named only if the images prove it.

Points that both images show are matched without any orientation. A slip is likely if
with what was given their rays do not meet on the ground, and without the slip they do.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import matching
from pgm_lab.camera.photo import Photo
from pgm_lab.orientation.rays import nearest_factors

MIN_POINTS = 6  # matched points from which they prove anything
MOST = 0.8  # of the points; the others may be wrong matches
ROUGH = 0.005  # radians: a direct orientation by GNSS and IMU is no worse
CLOSE = 0.001  # radians: nor does so little prove anything if the depth is off too
CONVERGENCE = 0.05  # radians: at most between the grid of a map and true north
BETTER = 10  # times closer the rays have to pass each other without the slip
FAR = 2.0  # times the depth: limits that are no slip are not so far off, feet farther
ALIKE = 2e-4  # radians: rays that miss each other by so much more fit as well
NEAR = 0.1  # of the depth, outside its limits: no more is left without the slip
FOOT = 0.3048  # m
EARTH = 6.371e6  # m, radius
EXCHANGED = "Are the photos exchanged?"  # how the sentence about them begins
SAME = 0.05  # px: no two photos show all points nearer to the same pixels
TIMES = np.geomspace(0.1, 30, 200)  # pixel size by focal length: right by given
TIMES = TIMES[(TIMES < 0.6) | (TIMES > 1.5)]  # nearer, wrong limits look alike
ANGLES = {  # what they may be: times what they are right
    "in degrees": ("pi / 180", np.pi / 180),
    "in gon": ("pi / 200", np.pi / 200),
    "in gon, converted as if in degrees": ("9 / 10", 9 / 10),
    "in degrees, converted as if in gon": ("10 / 9", 10 / 9),
    "in radians, converted as if in degrees": ("180 / pi", 180 / np.pi),
}

Photos = tuple[Photo, Photo]
Pixels = tuple[np.ndarray, np.ndarray]


def common_points(photos: Photos) -> Pixels | None:
    """Pixels (n, 2) of the same points in both photos; None if they do not show any."""
    try:
        found = matching.match(photos[0].grey, photos[1].grey, number=50)
    except ValueError:  # no texture, or nothing fits together
        return None
    good = found.accepted
    enough = good.sum() >= MIN_POINTS
    return (found.chosen[good], found.points[good]) if enough else None


def likely(
    photos: Photos, along: str, limits: np.ndarray, pixels: Pixels | None = None
) -> str:
    """Sentence that names the slip and the cure; empty if the images prove none.

    `along` is "heights" or "depths", `limits` are the (least, greatest) of them;
    `pixels` are `common_points`, if they are known.
    """
    if pixels is None and (pixels := common_points(photos)) is None:
        left, right = photos
        if common_points((replace(left, grey=np.fliplr(left.grey)), right)) is None:
            return ""
        return (
            "Is one photo mirrored, as film scanned from its other side? The mirror"
            " image of the left one fits the right one: mirror back the wrong one"
        )
    if np.median(np.abs(pixels[0] - pixels[1])) < SAME:
        return "Is it the same photo twice? All points lie at the same pixels of both"
    given, ratio = _misfit(photos, pixels, along, limits)
    right_depth = 1 / FAR <= ratio <= FAR
    if right_depth and given <= (ROUGH if abs(ratio - 1) <= NEAR else CLOSE):
        return ""
    fitting = []
    for words, cured, at, within, most in _without_slip(photos, pixels, along, limits):
        misfit, depth = _misfit(cured, at, along, within)
        # What makes a wrong depth right explains it, but some reduction always could
        scale = cured[0].pixel_size / photos[0].pixel_size
        reduced = scale != 1 and TIMES[0] <= scale <= TIMES[-1]
        proved = misfit * BETTER < given or not (right_depth or reduced)
        if proved and misfit <= most and abs(depth - 1) <= NEAR:
            fitting.append((misfit, words))
    # Photos without tilt do not tell exchanged from turned and mirrored ones
    fitting.sort()
    questions: dict[str, str] = {}
    for misfit, words in fitting:
        if misfit <= fitting[0][0] + ALIKE:
            questions.setdefault(words.partition("?")[0], words)
    return ". Or: ".join(questions.values())


def _misfit(
    photos: Photos, pixels: Pixels, along: str, limits: np.ndarray
) -> tuple[float, float]:
    """Median angle by which rays miss each other, and depth in what the limits allow.

    The depth is 1 between the limits, else the ratio to the nearer one. Infinite and
    NaN if most rays do not meet in front of the photos.
    """
    left, right = photos
    try:
        u, v = (photo.rays(at) for photo, at in zip(photos, pixels))
    except ValueError:  # beyond what the lens can image
        return np.inf, np.nan
    b = right.exterior[:3] - left.exterior[:3]
    factors, parallel = nearest_factors(b, u, v)
    ahead = ~parallel & (factors > 0).all(-1)
    if ahead.mean() < MOST:
        return np.inf, np.nan
    # Angle between the right ray and the epipolar plane of the left one
    normal = np.cross(b, u[ahead])
    size = np.linalg.norm(normal, axis=-1) * np.linalg.norm(v[ahead], axis=-1)
    sine = np.abs(np.sum(normal * v[ahead], axis=-1)) / np.maximum(size, 1e-300)
    down = -u[ahead, 2] if along == "heights" else np.full(len(u), left.camera.c)[ahead]
    depth = np.median(factors[ahead, 0] * down)
    near, far = limits if along == "depths" else left.exterior[2] - limits[::-1]
    if min(depth, far) <= 0:
        return np.inf, np.nan
    return float(np.median(sine)), float(depth / np.clip(depth, max(near, 0), far))


def _without_slip(
    photos: Photos, pixels: Pixels, along: str, limits: np.ndarray
) -> Iterator[tuple[str, Photos, Pixels, np.ndarray, float]]:
    """What may be wrong, all that is given without it, and the misfit that is left."""

    def changed(times: ArrayLike, turns: tuple[int, int] = (0, 0)) -> Photos:
        one, other = (
            replace(p, exterior=p.exterior * times + np.r_[np.zeros(5), np.radians(k)])
            for p, k in zip(photos, turns)
        )
        return one, other

    def scaled(times: float) -> Photos:
        one, other = (replace(p, pixel_size=times * p.pixel_size) for p in photos)
        return one, other

    # Angles
    for unit, (factor, times) in ANGLES.items():
        words = (
            f"Are the angles {unit}? Times {factor} they fit what the images show; give"
            " omega, phi and kappa in radians"
        )
        cured = changed(np.r_[np.ones(3), np.full(3, times)])
        yield words, cured, pixels, limits, ROUGH
    # Files
    for turn in (180, 90, -90):
        turned = {"each": (turn, turn), "the left": (turn, 0), "the right": (0, turn)}
        for which, turns in turned.items():
            words = (
                f"Is {which} photo turned, or kappa counted from another axis? With"
                f" {turn} degrees added to kappa it fits what the images show; turn the"
                " file back, or add them"
            )
            yield words, changed(1, turns), pixels, limits, ROUGH
    for axis, how in enumerate(("left to right", "upside down")):
        words = (
            f"Are the photos mirrored, {how}, as film scanned from its other side?"
            " Mirrored back they fit what the images show"
        )
        a, b = (
            np.where(np.arange(2) == axis, p.grey.shape[1 - axis] - 1 - at, at)
            for p, at in zip(photos, pixels)
        )
        yield words, photos, (a, b), limits, ROUGH
    # Stations
    words = (
        f"{EXCHANGED} With the exterior orientation of the other one, each fits what"
        " the images show: exchange the images, or their exterior orientations"
    )
    one, other = (replace(a, exterior=b.exterior) for a, b in (photos, photos[::-1]))
    yield words, (one, other), pixels, limits, ROUGH
    words = (
        "Are X and Y exchanged? The other way round they fit what the images show; give"
        " X to the east and Y to the north"
    )
    one, other = (replace(p, exterior=p.exterior[[1, 0, 2, 3, 4, 5]]) for p in photos)
    yield words, (one, other), pixels, limits, ROUGH
    X, Y, _ = np.transpose([photo.exterior[:3] for photo in photos])
    for east, north, order in ((X, Y, [0, 1]), (Y, X, [1, 0])):
        if np.abs(east).max() > 180 or np.abs(north).max() > 90:
            continue
        words = (
            "Are X and Y longitude and latitude? Projected to a map they fit what the"
            " images show; give metres east and north, as UTM has them"
        )
        metres = EARTH * np.radians(1) * np.array([np.cos(np.radians(north[0])), 1])
        one, other = (
            replace(p, exterior=np.r_[p.exterior[order] * metres, p.exterior[2:]])
            for p in photos
        )
        yield words, (one, other), pixels, limits, CONVERGENCE
    # Feet
    for what, cured, within in (
        ("Z of the stations", changed(np.r_[1, 1, FOOT, 1, 1, 1]), limits),
        ("the stations", changed(np.r_[np.full(3, FOOT), 1, 1, 1]), limits),
        (f"the {along}", photos, limits * FOOT),
    ):
        words = (
            f"Are {what} in feet? In metres, times {FOOT}, they fit what the images"
            " show"
        )
        yield words, cured, pixels, within, ROUGH
    # Cameras
    words = (
        "Is the principal point in pixels, or counted from a corner? In the middle of"
        " the photo it fits what the images show; give it in mm from there"
    )
    one, other = (replace(p, camera=replace(p.camera, x0=0, y0=0)) for p in photos)
    yield words, (one, other), pixels, limits, ROUGH
    words = "Is the focal length in pixels? Times the pixel size it fits; give it in mm"
    one, other = (
        replace(p, camera=replace(p.camera, c=p.camera.c * p.pixel_size))
        for p in photos
    )
    yield words, (one, other), pixels, limits, ROUGH
    for unit, focal, times in (
        ("micrometres", "metres", 1e-3),
        ("metres", "micrometres", 1e3),
    ):
        words = (
            f"Is the pixel size in {unit}, or the focal length in {focal}? With both in"
            " mm they fit what the images show"
        )
        yield words, scaled(times), pixels, limits, ROUGH
    for times in TIMES:
        words = (
            "Is the pixel size that of the photos before they were reduced, or the"
            f" focal length that of another camera? About {times:.2g} times as large a"
            " pixel, or as short a focal length, fits what the images show"
        )
        yield words, scaled(times), pixels, limits, ROUGH
