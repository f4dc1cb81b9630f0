"""What would explain a y parallax: an element of orientation, exchanged photos."""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from pgm_lab import matching
from pgm_lab.camera.photo import Photo
from pgm_lab.stereo._frame import normal_places, rotation

NAMES = ("by", "bz", "omega", "phi", "kappa")

# Unknowns are counted in a hundredth of the base or of a radian, so that all are alike
UNIT = 0.01

# Points that are needed for a trend over the image, and one to check it
FEWEST = 6

# Residuals larger than this (px) count less and less: wrong matches among them
LARGE = 0.1


@dataclass(frozen=True)
class Element:
    """One element of the right photo's orientation, corrected alone.

    Attributes
    ----------
    name : str
        "by", "bz", "omega", "phi" or "kappa".
    correction : float
        What to add to it: radians; by and bz in the unit of the base, along the y and
        the z axis of the normal images.
    remaining : float
        RMSE of the y parallax that this correction leaves, in pixels.
    """

    name: str
    correction: float
    remaining: float

    def __str__(self) -> str:
        if self.name in ("by", "bz"):
            value = f"{self.correction:+.3g} (in the unit of the base)"
        else:
            value = f"{np.degrees(self.correction):+.3f} degrees"
        return f"{self.name} corrected by {value}, which leaves {self.remaining:.2f} px"


def parallaxes(
    left: Photo, right: Photo, one: np.ndarray, other: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """X and y parallax (n,) in mm of pixels (n, 2) of two photos, in their normal case.

    NaN where a ray does not look at the ground.
    """
    R = rotation(left, right)
    a, b = (
        normal_places(photo.rays(pixels), R, left.camera.c)
        for photo, pixels in ((left, one), (right, other))
    )
    return a[:, 0] - b[:, 0], a[:, 1] - b[:, 1]


def explanations(
    photos: tuple[Photo, Photo], one: np.ndarray, other: np.ndarray, pixel_size: float
) -> tuple[tuple[Element, ...], float]:
    """Each element corrected alone, the best first, and what all five together leave.

    `one` and `other` are pixels (n, 2) of the same points in the left and right photo.
    """
    left, right = photos
    base = float(np.linalg.norm(right.exterior[:3] - left.exterior[:3]))
    axes = rotation(left, right)[1:]
    units = UNIT * np.array([base, base, 1, 1, 1])

    def remaining(corrections: np.ndarray) -> np.ndarray:
        exterior = np.array(right.exterior)
        exterior[:3] += corrections[:2] @ axes
        exterior[3:] += corrections[2:]
        turned = replace(right, exterior=exterior)
        return parallaxes(left, turned, one, other)[1] / pixel_size

    def best(which: list[int]) -> tuple[np.ndarray, float]:
        def residuals(x: np.ndarray) -> np.ndarray:
            corrections = np.zeros(5)
            corrections[which] = x * units[which]
            return remaining(corrections)

        found = scipy.optimize.least_squares(
            residuals, np.zeros(len(which)), loss="soft_l1", f_scale=LARGE
        )
        return found.x * units[which], float(np.sqrt(np.mean(found.fun**2)))

    alone = []
    for k, name in enumerate(NAMES):
        value, rmse = best([k])
        alone.append(Element(name, float(value[0]), rmse))
    return tuple(sorted(alone, key=lambda e: e.remaining)), best([0, 1, 2, 3, 4])[1]


def exchanged(photos: tuple[Photo, Photo] | None) -> bool:
    """Whether the photos fit their exterior orientations better the other way round."""
    if photos is None:
        return False
    left, right = photos
    try:
        found = matching.match(left.grey, right.grey, number=50)
    except ValueError:
        return False
    if (good := found.accepted).sum() < FEWEST:
        return False
    crossed = (
        replace(left, exterior=right.exterior),
        replace(right, exterior=left.exterior),
    )
    here, there = (
        np.mean(parallaxes(one, other, found.chosen[good], found.points[good])[0] > 0)
        for one, other in (photos, crossed)
    )
    return bool(here < 0.5 < there)
