"""Warnings: what the reader of a bundle adjustment should look at, in words."""

import numpy as np

from pgm_lab._rounding import plain
from pgm_lab.bundle.refuse import LOOKING, mirrored_image, mirrored_object
from pgm_lab.bundle.reliability import correlations, significance
from pgm_lab.bundle.result import Bundle
from pgm_lab.report._input import COORDINATES, changed_c, doubt
from pgm_lab.report._layout import NUMBERS, Finding, count, listed
from pgm_lab.report._misfit import ALPHA, blunders, control, gross, ray, sigma0
from pgm_lab.report._words import UM

CORRELATED = 0.9
HARDLY = 0.1  # redundancy number below which nine tenths of a blunder stay hidden
FEW_RAYS = 6  # three points orient a photo without any control
WEAK = 3.0  # times the median standard deviation of the projection centres


def findings(result: Bundle) -> list[Finding]:
    """List all warnings of a result; none when nothing is wrong.

    A wrong unit or frame of the image coordinates comes first, and explains what c,
    sigma0 and mirror images only hint at.
    """
    wrong = doubt(result.network)
    turned = wrong is not None and wrong.title == COORDINATES
    checks = (
        _not_converged,
        *(() if turned else (_mirrored_image, _mirrored_object, changed_c)),
        _behind,
        *(() if wrong else (sigma0,)),
        control,
        blunders,
        _correlated,
        _insignificant,
        _uncontrolled,
        _two_rays,
        _weak_photos,
    )
    found = (wrong, *(check(result) for check in checks))
    return [finding for finding in found if finding is not None]


def _not_converged(result: Bundle) -> Finding | None:
    if result.status == "converged":
        return None
    return Finding(
        "No solution",
        f"The iteration ended with the status {result.status!r}: no number below is"
        " a result. Check the start values, above all angles and ids, and that x points"
        " right and y up.",
    )


def _mirrored_image(result: Bundle) -> Finding | None:
    words = mirrored_image(result)
    return Finding("Mirrored image", words) if words else None


def _mirrored_object(result: Bundle) -> Finding | None:
    words = mirrored_object(result)
    return Finding("Mirrored object", words) if words else None


def _behind(result: Bundle) -> Finding | None:
    behind = result.behind
    if not len(behind):
        return None
    most = 2 * len(behind) > len(result.network.xy)
    cause = f"the image is mirrored. {LOOKING}." if most else "check the start values."
    return Finding(
        "Behind the camera",
        f"{count(len(behind), 'ray').capitalize()} would come from behind the camera:"
        f" {listed(ray(result, k) for k in behind)}. This is a solution of the"
        f" equations, but not of the task: {cause}",
    )


def _correlated(result: Bundle) -> Finding | None:
    pairs = correlations(result, CORRELATED)
    if not pairs:
        return None
    interior = set(result.interior_names)
    shared = [len(interior & {one, other}) for one, other, _ in pairs]
    camera, mixed, exterior = (
        [pair for pair, of_camera in zip(pairs, shared) if of_camera == number]
        for number in (2, 1, 0)
    )
    words = []
    if camera:
        words.append(
            f"Within the camera: {listed(map(_pair, camera))}. Each of the two is"
            " uncertain, what they do together is not: never use one without the other."
            " K1, K2 and K3 always correlate, as they share one curve."
        )
    if mixed:
        words.append(
            f"Between camera and photos: {count(len(mixed), 'pair')}, led by"
            f" {_pair(mixed[0])}. Convergent photos, some rolled by 90 degrees, and"
            " depth in the object tell them apart."
        )
    if exterior:
        words.append(
            f"Between photos: {count(len(exterior), 'pair')}, led by"
            f" {_pair(exterior[0])}, since the photos move together within the datum."
        )
    return Finding(f"Correlations above {CORRELATED}", " ".join(words))


def _pair(pair: tuple[str, str, float]) -> str:
    one, other, r = pair
    return f"{one} with {other} ({r:.3f})"


def _insignificant(result: Bundle) -> Finding | None:
    weak = [one for one in significance(result, ALPHA) if not one.significant]
    if not weak:
        return None
    names = listed(
        f"{one.name} (t = {one.t:.1f}, at most {plain(UM * one.effect)} µm in the"
        " image)"
        for one in weak
    )
    if gross(result):
        return Finding(
            "Insignificant parameters",
            "First the blunders: as long as they make sigma0"
            f" {plain(result.sigma0, 3)}, nothing is known of {names}.",
        )
    return Finding(
        "Insignificant parameters",
        f"{names}: not different from zero at the {100 * ALPHA:.0f} % level. Leave out"
        " one at a time, the one with the smallest t first, and adjust again.",
    )


def _uncontrolled(result: Bundle) -> Finding | None:
    least = np.min(result.redundancy_numbers, axis=1)
    rays = np.flatnonzero(least < HARDLY)
    if not len(rays) or not result.redundancy > 0:
        return None
    rays = rays[np.argsort(least[rays], kind="stable")]
    names = listed(f"{ray(result, k)} ({max(least[k], 0):.2f})" for k in map(int, rays))
    return Finding(
        "Hardly controlled observations",
        f"{count(len(rays), 'ray').capitalize()} with a redundancy number below"
        f" {HARDLY}: {names}. The network follows a blunder there, and its residual"
        " shows less than a tenth of it.",
    )


def _two_rays(result: Bundle) -> Finding | None:
    network = result.network
    free = ~np.all(network.held, axis=1)
    two = np.flatnonzero((network.rays_of_points == 2) & free)
    if not len(two):
        return None
    names = listed(network.point_names[j] for j in two.tolist())
    return Finding(
        "Points with two rays",
        f"{names}. A blunder along the epipolar line moves such a point and leaves no"
        " residual; a third photo shows it.",
    )


def weak_photos(result: Bundle) -> np.ndarray:
    """Indices of photos with few rays or an uncertain projection centre."""
    rays = result.network.rays_of_photos
    sd = np.linalg.norm(result.sd_exteriors[:, :3], axis=1)
    uncertain = sd > WEAK * np.median(sd)
    return np.flatnonzero((rays < FEW_RAYS) | uncertain)


def _weak_photos(result: Bundle) -> Finding | None:
    weak = weak_photos(result)
    if not len(weak):
        return None
    network = result.network
    names = listed(
        f"{network.photo_names[i]} ({count(network.rays_of_photos[i], 'ray')})"
        for i in weak
    )
    return Finding(
        "Weak photos",
        f"{names}: fewer than {NUMBERS[FEW_RAYS]} rays, or a projection centre more"
        f" than {NUMBERS[int(WEAK)]} times as uncertain as usual. More points, spread"
        " over the whole photo, strengthen them.",
    )
