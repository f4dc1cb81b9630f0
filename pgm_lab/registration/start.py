"""Where to begin: the shifts of large chips in reduced images, from coarse to fine."""

import itertools
from dataclasses import dataclass

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, matching, ncc
from pgm_lab._robust import nmad
from pgm_lab.image.grey import eight_bit
from pgm_lab.io.geotiff import without_data
from pgm_lab.registration.field import LIMIT, Field, fit

COARSEST = 400  # pixels along the longer side of the smallest images
FINEST = 2000  # the same of the largest images
NUMBER = 500  # chips of a level, where there is room for as many
RADIUS = 4  # px around what the level before predicts
TOLERANCE = 3.0  # px in the smallest images, from one affine transformation for all
DRAWS = 5000  # of three points that determine it
CHANCE = 1e-4  # of so much agreement among positions at random, at most
SMALL = 1000  # pixels along the longer side of images in which features are found
FEATURES = 3000  # of an image
TURNED, SCALED = 3.0, 0.05  # degrees and share: less is no cause
CONFIRMED = 12  # features that agree: by chance six do
DOUBTFUL = 0.01  # share of chips at a wrong place whose r is higher than `chance`


@dataclass(frozen=True, eq=False)
class Start:
    """The shifts of two images, roughly.

    Attributes
    ----------
    field : Field
        Shifts of large chips, as a smooth function of the place.
    found, tried : int
        Chips of the smallest images that agree, of how many.
    scale : int
        Pixels along a pixel of the largest images that were used.
    """

    field: Field
    found: int
    tried: int
    scale: int

    def shifts(self, points: ArrayLike) -> np.ndarray:
        """Return shifts (n, 2) expected at points (n, 2): `start` of `register`."""
        return self.field.at(_validate.point_list(points, "points"))

    @property
    def typical(self) -> np.ndarray:
        """Median shift (2,) in pixels."""
        return np.median(self.field.at(self.field.spline.knots), axis=0)

    @property
    def range(self) -> np.ndarray:
        """Smallest and largest shift (2, 2) of the chips, in pixels."""
        shifts = self.field.at(self.field.spline.knots)
        return np.array([shifts.min(axis=0), shifts.max(axis=0)])

    @property
    def radius(self) -> int:
        """Whole pixels that have to be searched around them, at least 3."""
        off = nmad(self.field.residuals[self.field.used])
        return int(np.clip(np.ceil(LIMIT * off), 3, 2 * RADIUS * self.scale))


def approximate(
    reference: ArrayLike,
    sensed: ArrayLike,
    chip: int = 21,
    *,
    offset: ArrayLike = (0.0, 0.0),
) -> Start | None:
    """Find out roughly how two images are shifted, however far and however unevenly.

    In both images, reduced to 400 pixels at most, chips twice as wide as `chip` are
    found by Pearson's correlation, up to a quarter of the image away. Those that agree
    with one affine transformation are the start; in each finer level a smooth field
    predicts where to search.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        As for `register`.
    chip : int
        Pixels across a chip of `register`, odd.
    offset : array_like (2,)
        As for `register`.

    Returns
    -------
    Start or None
        None if no more chips agree than would by chance.

    Raises
    ------
    ValueError
        If an image has no data.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> scene = landsat().grey
    >>> start = approximate(scene[:800, :800], scene[40:840, 25:825])
    >>> print(start.typical.round(), start.radius)
    [-25. -40.] 3
    """
    reference = _validate.grey_image(reference, "reference")
    sensed = _validate.grey_image(sensed, "sensed")
    for image, name in ((reference, "reference"), (sensed, "sensed")):
        if without_data(image).all():
            raise ValueError(f"{name} has no data: all its pixels are without a value")
    size = 2 * _validate.window(chip, "chip", 5) - 1
    offset = _validate.of_shape(offset, (2,), "offset")
    longest = max(*reference.shape, *sensed.shape)
    top, bottom = (
        max(0, int(np.ceil(np.log2(longest / most)))) for most in (COARSEST, FINEST)
    )
    found, number, tried = None, 0, 0
    for level in range(top, bottom - 1, -1):
        scale = 2**level
        pair = _reduced(reference, scale), _reduced(sensed, scale)
        if min(*pair[0].shape, *pair[1].shape) < size:
            return None
        points = matching.pick(pair[0], NUMBER, size)
        full = scale * (points + 0.5) - 0.5
        radius, expected = RADIUS, np.zeros_like(full)
        if found is None:
            radius = max(RADIUS, min(pair[0].shape) // 4)
        else:
            expected = found.at(full)
        place = (full + offset + expected + 0.5) / scale - 0.5
        search = size + 2 * radius
        match = ncc.match(
            *pair, points, place, size, search, 0.0, 1.0, refine="parabola"
        )
        k = np.flatnonzero(match.accepted)
        if found is None:
            agree = _affine(points[k], match.points[k], radius)
            number, tried = len(agree), len(points)
            k = k[agree]
        shifts = scale * (match.points[k] + 0.5) - 0.5 - offset - full[k]
        found = fit(full[k], shifts, scale * match.sd[k])
        if found is None:
            return None
    assert found is not None
    return Start(found, number, tried, scale)


def _affine(points: np.ndarray, found: np.ndarray, radius: int) -> np.ndarray:
    """Indices of the points that one affine transformation explains; none by chance."""
    nothing = np.zeros(0, int)
    if len(points) < 4:
        return nothing
    _, fits = cv2.estimateAffine2D(
        *(points, found),
        method=cv2.RANSAC,
        ransacReprojThreshold=TOLERANCE,
        maxIters=DRAWS,
        confidence=0.99999,
    )
    k = np.flatnonzero(fits)
    # Of positions at random in the search, as many agree beside the three of a draw
    share = min(1.0, np.pi * TOLERANCE**2 / (2 * radius + 1) ** 2)
    by_chance = DRAWS * scipy.special.bdtrc(len(k) - 4, len(points) - 3, share)
    return k if len(k) > 4 and by_chance < CHANCE else nothing


def _reduced(image: np.ndarray, scale: int) -> np.ma.MaskedArray:
    """Means of scale x scale pixels; masked where any has no data."""
    grey, none = np.ma.getdata(image), without_data(image)
    if scale == 1:
        return np.ma.array(grey, mask=none)
    rows, columns = (n // scale * scale for n in grey.shape)
    grey, none = grey[:rows, :columns], none[:rows, :columns]
    small = columns // scale, rows // scale
    if grey.dtype not in (np.uint8, np.uint16, np.int16, np.float32, np.float64):
        grey = grey.astype(np.float32)
    if grey.dtype.kind == "f" and none.any():
        grey = np.where(none, 0, grey)
    means = cv2.resize(grey, small, interpolation=cv2.INTER_AREA)
    mask = none.reshape(small[1], scale, small[0], scale).any(axis=(1, 3))
    return np.ma.array(means, mask=mask)


def chance(
    reference: np.ndarray,
    sensed: np.ndarray,
    points: np.ndarray,
    start: np.ndarray,
    chip: int,
    radius: int,
) -> float:
    """Pearson's r that one of a hundred chips reaches where it does not belong."""
    # At the place of another chip; `start` is where they are in the sensed image
    elsewhere = np.roll(start, len(start) // 2, axis=0)
    search = chip + 2 * radius
    r = ncc.match(reference, sensed, points, elsewhere, chip, search, -1.0, 1.0).r
    known = r[np.isfinite(r)]
    return float(np.quantile(known, 1 - DOUBTFUL)) if len(known) else np.nan


def cause(reference: np.ndarray, sensed: np.ndarray) -> str:
    """Say how the sensed image is turned, scaled, mirrored or inverted, and the cure.

    From features of both, reduced, the sensed one also mirrored and inverted; nothing
    if hardly any agree, or the images lie alike.
    """
    scale = -(-max(*reference.shape, *sensed.shape) // SMALL)
    one, other = (_reduced(image, scale) for image in (reference, sensed))
    if one.mask.all() or other.mask.all():
        return ""
    known, found = _features(one), []
    for mirrored, inverted in itertools.product((False, True), repeat=2):
        seen = _features(other[:, ::-1] if mirrored else other, inverted)
        found.append((*_similarity(known, seen), mirrored, inverted))
    number, M, mirrored, inverted = max(found, key=lambda way: way[0])
    turn, times = np.degrees(np.arctan2(M[1, 0], M[0, 0])), np.hypot(*M[:, 0])
    # From pixel to pixel of the images themselves
    M[:, 2] = scale * M[:, 2] + (scale - 1) / 2 * (1 - M[:, :2].sum(axis=1))
    if mirrored:
        M[0] = (0, 0, scale * other.shape[1] - 1) - M[0]
    way = "clockwise" if turn > 0 else "counter-clockwise"
    moved = {
        f"turned by {abs(turn):.0f} degrees {way}": abs(turn) >= TURNED,
        f"{times:.2f} times as large": abs(times - 1) >= SCALED,
        "mirrored, left to right": mirrored,
    }
    ways = moved | {"inverted, dark where the other is bright": inverted}
    words = " and ".join(word for word, true in ways.items() if true)
    if number < CONFIRMED or not words:
        return ""
    cure = "sensed.max() - sensed" if inverted else "sensed"
    if any(moved.values()):
        cure = (
            f"cv2.warpAffine({cure}, np.array({M.round(5).tolist()}),"
            f" {reference.shape[::-1]}, flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP)"
        )
    return (
        f"Compared with the reference, the sensed image is {words}. Take in its place,"
        f" in Python, {cure}."
    )


def _features(
    image: np.ma.MaskedArray, inverted: bool = False
) -> tuple[np.ndarray, np.ndarray | None]:
    """Features (m, 2) of an image, or of its negative, and descriptors (m, 128)."""
    grey = np.ascontiguousarray(eight_bit(image.astype(np.float32)) ^ (255 * inverted))
    shown = np.ascontiguousarray(~np.ma.getmaskarray(image), np.uint8)
    # Without a threshold: bright clouds would leave the ground no features
    sift = cv2.SIFT.create(FEATURES, contrastThreshold=0, enable_precise_upscale=True)
    points, descriptors = sift.detectAndCompute(grey, shown)
    return np.array([one.pt for one in points]), descriptors


def _similarity(known: tuple, seen: tuple) -> tuple[int, np.ndarray]:
    """How many features of two images agree in one similarity, and this (2, 3)."""
    enough = min(len(known[0]), len(seen[0])) >= CONFIRMED
    pairs = cv2.BFMatcher(crossCheck=True).match(known[1], seen[1]) if enough else ()
    if len(pairs) < CONFIRMED:
        return 0, np.eye(2, 3)
    i, j = np.array([(pair.queryIdx, pair.trainIdx) for pair in pairs]).T
    M, fits = cv2.estimateAffinePartial2D(
        known[0][i], seen[0][j], ransacReprojThreshold=TOLERANCE, maxIters=DRAWS
    )
    return (0, np.eye(2, 3)) if M is None else (int(fits.sum()), M)
