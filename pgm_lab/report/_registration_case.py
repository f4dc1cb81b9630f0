"""What the report of a registration is about, and the numbers that it begins with."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pgm_lab._rounding import fixed, plain
from pgm_lab.registration import Model, Raster, Registration, fit
from pgm_lab.registration.accuracy import ROBUST_SD

# What all points may be off together, in px, by how they were refined: rounding, pixel
# locking, alias, two resamplings. Their scatter does not show it. As a real scene gave
# it, averaged down 2 to 4 times, and two scenes of one pass, each resampled by itself.
COMMON = {None: 1 / np.sqrt(12), "parabola": 0.05, "lsm": 0.01}
FEW = 12  # points
UNSMOOTHED = 0.03  # the same of "lsm", where the alias was left
WORDS = (
    ("the right window", "the window of the sensed image"),
    ("the right photo", "the sensed image"),
    ("from the right", "from the sensed image"),
    ("left-right check", "check from the sensed image"),
    ("the left photo", "the reference image"),
    ("a photo that is less exposed", "an image that is less exposed"),
    ("one of the photos sees", "one of the images shows"),
    ("photos", "images"),
    ("photo", "image"),
    ("in the template", "in the chip"),
    ("the template", "the chip"),
    ("template", "chip"),
    ("enlarge the search", "enlarge the radius"),
    ("improve the start, or give its shape", "give an offset"),
    ("improve the start", "give an offset"),
    ("search less, along the epipolar line", "a smaller radius"),
    (", or give its shape", ""),
)


def say(words: str) -> str:
    """Put what is said of two photos into the words of two images."""
    for of_photos, of_images in WORDS:
        words = words.replace(of_photos, of_images)
    return words


@dataclass(frozen=True, eq=False)
class Case:
    """Two images, what was asked and what was found.

    Attributes
    ----------
    found : Registration
    reference, sensed : Raster
    model : Model or None
    asked : dict
        Arguments of `register`, with the defaults of those that were not given.
    pixel_size : ndarray (2,) or None
        Across and down, in metres.
    """

    found: Registration
    reference: Raster
    sensed: Raster
    model: Model | None
    asked: dict[str, Any]
    pixel_size: np.ndarray | None

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows of the reference image."""
        rows, columns = self.reference.grey.shape
        return columns, rows

    @property
    def offset(self) -> np.ndarray:
        """Column and row of the reference image's first pixel in the sensed one."""
        given = self.asked["offset"]
        return np.zeros(2) if given is None else np.asarray(given, float)

    @property
    def radius(self) -> int:
        """How far was searched, in pixels."""
        return int(self.asked["radius"])

    @property
    def north_up(self) -> bool:
        """Whether columns count to the east and rows to the south, as it is known."""
        if self.reference.transform is None:
            return False
        (a, b, _), (d, e, _) = self.reference.transform
        return bool(a > 0 > e and b == d == 0)

    @cached_property
    def shift(self) -> np.ndarray:
        """Median shift (2,) of the accepted points in pixels."""
        a = self.found.accuracy
        return np.array([a.median_x, a.median_y])

    @cached_property
    def known(self) -> float:
        """Standard deviation of a coordinate of that shift, in pixels.

        From the scatter of the shifts, as that of a median, or from what the chips
        predict if that is more; and what all points may be off together.
        """
        a, good = self.found.accuracy, self.found.accepted
        scatter = np.sqrt(np.pi / 2) * max(a.spread_x, a.spread_y)
        predicted = float(np.median(self.found.sd[good]))
        own = max(scatter, predicted) / np.sqrt(a.n)
        refine = self.asked["refine"]
        if refine is None:  # rounded, perhaps all of them alike
            return float(max(own, COMMON[None]))
        left = refine == "lsm" and self.asked["smooth"] == 0
        return float(np.hypot(own, UNSMOOTHED if left else COMMON[refine]))

    @cached_property
    def errors(self) -> np.ndarray:
        """How far each shift (n, 2) is off the model, or the median shift, in px."""
        if self.model is not None:
            return self.model.residuals
        d = np.column_stack([self.found.dx, self.found.dy]) - self.shift
        d[~self.found.accepted] = np.nan
        return d

    @property
    def chance(self) -> float:
        """What the shifts of a coordinate would scatter by chance: sd in pixels.

        All places of the search window alike, but for its border, which is refused.
        """
        return float(np.sqrt(((2 * self.radius - 1) ** 2 - 1) / 12))

    @cached_property
    def affine(self) -> Model | None:
        """The shifts as a shift, scales, turn and shear; None if that is left open."""
        if self.model is not None and self.model.kind == "affine":
            return self.model
        try:
            return fit(self.found, "affine", offset=self.offset)
        except ValueError:  # too few points, or all on one line
            return None

    @cached_property
    def agrees(self) -> bool:
        """Whether the shifts tell one thing, or are spread as if by chance.

        An affine transformation is tried too; through a few points it always goes.
        """
        good = self.found.accepted
        if np.sum(good) < 3 or self.chance == 0:
            return bool(np.any(good))
        found = [self.errors]
        if np.sum(good) >= FEW and self.affine is not None:
            found.append(self.affine.residuals)
        spreads = [ROBUST_SD * np.median(np.abs(v[good]), axis=0).max() for v in found]
        return bool(min(spreads) < self.chance / 2)

    def length(self, x: float, decimals: float, axis: int) -> str:
        """Write a length in pixels, and in metres where a pixel's size is known."""
        words = f"{fixed(np.array([x]), decimals)[0]} px"
        if self.pixel_size is None:
            return words
        size = self.pixel_size[axis]
        metres = fixed(np.array([x * size]), decimals - np.floor(np.log10(size) + 0.5))
        return f"{words} ({metres[0]} m)"


def headline(case: Case) -> str:
    """Say in one sentence how the sensed image lies."""
    n, m = len(case.found.points), int(np.sum(case.found.accepted))
    if not m:
        return (
            f"None of {n} points was accepted: how the images lie to each other is not"
            " known."
        )
    if not case.agrees:
        return (
            f"No common shift was found: {m} of {n} points were accepted, and their"
            " shifts do not agree with each other."
        )
    decimals = max(0.0, -np.floor(np.log10(case.known)))
    known = case.length(case.known, decimals, 0)
    if np.all(np.abs(case.shift) < 2 * case.known):
        return (
            f"The sensed image lies on the reference image: a shift of {m} points is"
            f" not found, and would be noticed from about {_twice(case, decimals)} on."
        )
    ways = ("east", "west"), ("south", "north")
    of = "of the reference image"
    if not case.north_up:
        ways = ("farther to the right", "farther to the left"), ("lower", "higher")
        of = "than the reference image"
    parts = [
        f"{case.length(abs(x), decimals, axis)} {ways[axis][int(x < 0)]}"
        for axis, x in enumerate(case.shift)
        if abs(x) >= 0.5 * 10**-decimals
    ]
    return f"The sensed image lies {' and '.join(parts)} {of}, known to about {known}."


def _twice(case: Case, decimals: float) -> str:
    return case.length(2 * case.known, decimals, 0)


def scatter(case: Case) -> str:
    """Say from how many points that follows, and how they scatter."""
    a, n = case.found.accuracy, len(case.found.points)
    words = (
        f"{a.n} of {n} points were accepted. RMSE_T, with the common shift in it, is"
        f" {_total(case, a.rmse_t)}, and nine tenths of the shifts are not longer than"
        f" {_total(case, a.ce90)} (CE90)."
    )
    left = _left(case)
    if a.n > 2 and left < 0.5 * a.rmse_t:
        words += (
            f" Most of that is systematic, and resampling removes it;"
            f" {_total(case, left)} would be left."
        )
    return words


def _left(case: Case) -> float:
    """RMSE_T of the shifts less the model, or less their mean, in pixels."""
    if case.model is not None:
        v = case.model.residuals[case.found.accepted]
        return float(np.sqrt(np.mean(np.sum(v**2, axis=1))))
    a = case.found.accuracy
    return float(np.sqrt(max(a.rmse_t**2 - a.mean_x**2 - a.mean_y**2, 0.0)))


def _total(case: Case, px: float) -> str:
    """Write a length in no certain direction."""
    words = f"{plain(px, 3)} px"
    if case.pixel_size is None or case.pixel_size[0] != case.pixel_size[1]:
        return words
    return f"{words} ({plain(px * case.pixel_size[0], 3)} m)"
