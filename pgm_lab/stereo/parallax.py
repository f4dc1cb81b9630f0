"""Y parallax: the row differences in a normal pair show how well it is oriented.

In the normal images of two photos that are oriented well, each point lies in the same
row of both. So points are matched freely, in two dimensions, and their rows compared.
"""

from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, matching
from pgm_lab._robust import nmad
from pgm_lab.camera.photo import Photo
from pgm_lab.stereo import slips
from pgm_lab.stereo.normal import NormalPair, normal_frame, to_normal

MAX_RMSE = 0.1  # px, RMSE of the y parallax up to which a pair counts as well oriented
MAX_NMADS = 5.0  # from the trend; a match beyond counts as wrong
LOSS_SCALE = 0.1  # px; larger residuals, as of wrong matches, count less and less
MIN_POINTS = 6  # for a trend over the image, and to check it
UNIT = 0.01  # of the base, or radians: unknowns in this unit have similar effects
ELEMENTS = ("by", "bz", "omega", "phi", "kappa")


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


@dataclass(frozen=True, eq=False)
class YParallax:
    """Y parallaxes of a normal pair, and what they mean.

    Attributes
    ----------
    points, matched : ndarray (n, 2)
        (column, row) in the left and in the right normal image; NaN in `matched` where
        the point was not found.
    values : ndarray (n,)
        y' - y'' in pixels, that is the right row minus the left one; NaN unless used.
    status : ndarray (n,) of str
        "used"; "off the trend" (more than five NMADs, so probably a wrong match); or
        the status from `matching.match` of a point it did not find.
    trend : ndarray (3,)
        Y parallax at the centre of the left image, in pixels, and its change from the
        left to the right edge and from the upper to the lower one.
    elements : tuple of Element
        Each element of the right photo's orientation, corrected alone to explain the y
        parallax, the best first; empty if the pair was not made from photos.
    together : float
        RMSE that all five elements together leave, in pixels: a new relative
        orientation. NaN without photos.
    verdict : str
        One of "well oriented", "no trend" (above 0.1 px, but random),
        "wrong orientation", "photos exchanged", "too few points".
    slip : str
        What was probably given in a wrong unit, such as angles in degrees or heights in
        feet, where the photos fit without it; empty if nothing was.
    """

    points: np.ndarray = field(repr=False)
    matched: np.ndarray = field(repr=False)
    values: np.ndarray = field(repr=False)
    status: np.ndarray = field(repr=False)
    trend: np.ndarray
    elements: tuple[Element, ...]
    together: float
    verdict: str
    slip: str = ""

    @property
    def used(self) -> np.ndarray:
        """Whether the status is "used": ndarray (n,) of bool."""
        return self.status == "used"

    @property
    def n(self) -> int:
        """How many points were used."""
        return int(self.used.sum())

    @property
    def mean(self) -> float:
        """Mean of the values, in pixels; NaN without any."""
        return float(self.values[self.used].mean()) if self.n else np.nan

    @property
    def rmse(self) -> float:
        """Root mean square of the values, in pixels; NaN without any."""
        return _rms(self.values[self.used]) if self.n else np.nan

    @property
    def nmad(self) -> float:
        """1.4826 times the median distance from the median; NaN without any."""
        return float(nmad(self.values[self.used])) if self.n else np.nan

    @property
    def message(self) -> str:
        """What it means, in plain words."""
        measured = (
            f"The y parallax of {self.n} points is {self.mean:.2f} px in the mean, and"
            f" its RMSE {self.rmse:.2f} px. "
        )
        if self.slip and self.verdict in ("photos exchanged", "too few points"):
            return f"{self.slip}."
        if self.verdict == "too few points":
            return (
                f"Only {self.n} points of the left normal image were found in the right"
                " one, too few for a verdict. Either they do not show the same ground"
                " (check photos and exterior orientations), or it has no texture, as"
                " water has none."
            )
        if self.slip and self.verdict != "wrong orientation":
            return measured + (
                "So far it is well oriented, but the ground lies beyond the limits that"
                f" were given. {self.slip}."
            )
        if self.verdict == "well oriented":
            return measured + "The pair is well oriented."
        if self.verdict == "no trend":
            return measured + (
                "It has no trend over the image: noise of the matching, as with weak"
                " texture, or a poorly known lens; not the orientation."
            )
        why = f"{self.slip}." if self.slip else self._explained()
        return measured + f"The relative orientation is wrong. {why}"

    def _explained(self) -> str:
        if not self.elements:
            return "Orient the photos again."
        limit = max(MAX_RMSE, 1.5 * self.together, 1.5 * self.elements[0].remaining)
        likely = [str(e) for e in self.elements if e.remaining <= limit]
        again = (
            f"a new relative orientation leaves {self.together:.2f} px"
            " (orientation.relative)"
        )
        if self.elements[0].remaining > max(MAX_RMSE, 3 * self.together):
            return f"No element of the right photo alone explains it; {again}."
        one = "This one explains it" if len(likely) == 1 else "Each explains it alone"
        return f"{one}: {'; or '.join(likely)}. Check it, or orient again: {again}."


def y_parallax(
    pair: NormalPair,
    points: ArrayLike | None = None,
    *,
    number: int = 100,
    template: int = 21,
) -> YParallax:
    """Measure the y parallax of a normal pair at well textured points.

    The search is two-dimensional, so that the orientation may be wrong: features give
    start values, least squares matching measures the points.

    Parameters
    ----------
    pair : NormalPair
    points : array_like (n, 2), optional
        (column, row) in the left normal image; default: `number` points with texture,
        spread over what both images show.
    number : int
        How many points to pick.
    template : int
        Width of the window that is matched, in pixels, odd, at least 5.

    Returns
    -------
    YParallax
        Values, trend, verdict; `YParallax.message` in plain words.

    Raises
    ------
    ValueError
        If an argument is not as described here. If nothing can be matched, the verdict
        says so.

    Notes
    -----
    In the normal case small errors of the right photo make a y parallax of

        p = c by / Z + y bz / Z - c (1 + y²/c²) omega + (x'' y / c) phi - x'' kappa

    each with its sign: by and omega, and bz and phi, have similar effects over a narrow
    part of the photo, and only the whole overlap separates them. The elements are found
    from the exact equations, by iteration.

    References
    ----------
    Kraus 2007, "Photogrammetry", 2nd ed., 4.3.2; (M 2.37) for relative orientation.

    Examples
    --------
    >>> from pgm_lab import simulate, stereo
    >>> scene = simulate.aerial_pair(part=(240, 180))
    >>> pair = stereo.epipolar_pair(scene.left, scene.right, heights=(0, 60))
    >>> found = stereo.y_parallax(pair)
    >>> found.verdict, found.rmse < 0.1
    ('well oriented', True)
    """
    _validate.instance(pair, NormalPair, "pair")
    number = _validate.whole(number, "number", 1)
    template = _validate.window(template, "template", 5)
    if points is not None:
        points = _validate.point_list(points, "points")
    try:
        found = matching.match(
            pair.left, pair.right, points, number=number, template=template
        )
    except ValueError:  # too few features fit together, or there is no texture at all
        one = np.zeros((0, 2)) if points is None else points
        other = np.full(one.shape, np.nan)
        status = np.full(len(one), "nothing fits", "<U40")
    else:
        one, other = found.chosen, found.points
        status = np.where(found.accepted, "used", found.status).astype("<U40")
    good = status == "used"
    values = np.where(good, other[:, 1] - one[:, 1], np.nan)
    trend, together, verdict = np.full(3, np.nan), np.nan, "too few points"
    elements: tuple[Element, ...] = ()
    pixels: slips.Pixels | None = None
    if good.sum() >= MIN_POINTS:
        # Matches far from the trend are wrong
        trend, off = _trend(one, values, pair.left.shape)
        limit = max(MAX_NMADS * float(nmad(off[good])), LOSS_SCALE)
        status[np.abs(off) > limit] = "off the trend"
        used = status == "used"
        values = np.where(used, values, np.nan)
        if pair.photos is not None:
            pixels = pair.to_photo(0, one[used]), pair.to_photo(1, other[used])
            elements, together = explanations(pair.photos, *pixels, pair.pixel_size)
        # Noise alone makes a trend of this size
        chance = 3 * nmad(off[used]) * np.sqrt(3 / used.sum())
        verdict = "wrong orientation"
        if _rms(values[used]) < MAX_RMSE:
            verdict = "well oriented"
        elif _rms((values - off)[used]) < max(MAX_RMSE, chance):
            verdict = "no trend"
    slip = ""
    if pair.photos and pair.within:
        slip = slips.likely(pair.photos, *pair.within, pixels)
    if slips.EXCHANGED in slip:
        verdict = "photos exchanged"
    return YParallax(
        one, other, values, status, trend, elements, together, verdict, slip
    )


def _rms(v: np.ndarray) -> float:
    return float(np.sqrt(np.mean(v**2)))


def _trend(
    points: np.ndarray, values: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Trend (3,) over the image, and the differences of the values (n,) from it."""
    size = np.array(shape[::-1])
    A = np.insert((points - (size - 1) / 2) / size, 0, 1, axis=1)
    known = np.isfinite(values)

    def off(x: np.ndarray) -> np.ndarray:
        return A[known] @ x - values[known]

    start = np.array([np.median(values[known]), 0, 0])
    trend = scipy.optimize.least_squares(
        off, start, loss="soft_l1", f_scale=LOSS_SCALE
    ).x
    return trend, values - A @ trend


# --- Which element of orientation explains it ---


def explanations(
    photos: tuple[Photo, Photo], one: np.ndarray, other: np.ndarray, pixel_size: float
) -> tuple[tuple[Element, ...], float]:
    """Each element corrected alone, the best first, and the RMSE after all five."""
    # `one` and `other` are pixels (n, 2) of the same points in the left and right photo
    left, right = photos
    base = float(np.linalg.norm(right.exterior[:3] - left.exterior[:3]))
    axes = normal_frame(left, right)[1:]
    units = UNIT * np.array([base, base, 1, 1, 1])

    def best(which: list[int], ftol: float = 1e-8) -> tuple[np.ndarray, float]:
        def remaining(x: np.ndarray) -> np.ndarray:
            corrections, exterior = np.zeros(5), np.array(right.exterior)
            corrections[which] = x * units[which]
            exterior[:3] += corrections[:2] @ axes
            exterior[3:] += corrections[2:]
            corrected = replace(right, exterior=exterior)
            R, c = normal_frame(left, corrected), left.camera.c
            a, b = left.rays(one), corrected.rays(other)
            # NaN for rays to the sky
            return (to_normal(a, R, c) - to_normal(b, R, c))[:, 1] / pixel_size

        found = scipy.optimize.least_squares(
            remaining,
            np.zeros(len(which)),
            ftol=ftol,
            loss="soft_l1",
            f_scale=LOSS_SCALE,
        )
        return found.x * units[which], float(np.sqrt(np.mean(found.fun**2)))

    alone = []
    for k, name in enumerate(ELEMENTS):
        value, rmse = best([k])
        alone.append(Element(name, float(value[0]), rmse))
    # Over a narrow part all five hardly differ: what remains is known long before them
    together = best([0, 1, 2, 3, 4], ftol=1e-3)[1]
    return tuple(sorted(alone, key=lambda e: e.remaining)), together
