"""The report of a registration: the shift, how sure it is, and what to check."""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate, matching, registration
from pgm_lab._robust import SD_OF_MAD, nmad
from pgm_lab._rounding import fixed, plain, rounded, scientific
from pgm_lab.registration import Model, Raster, Registration, fit
from pgm_lab.registration.start import Start, cause
from pgm_lab.report import _page, _points
from pgm_lab.report._page import Table, as_html, as_text

__all__ = ["html", "text"]

TITLE = "Image registration"

# What the settings mean, for the command line and the report
SETTINGS = {
    "points": "where the chips are taken from in the reference image",
    "number": "how many points to pick, where the texture is good and spread",
    "grid": "pixels from one point to the next, on a grid",
    "chip": "pixels across a chip of the reference image; odd",
    "radius": "whole pixels that are searched to each side",
    "refine": "how the shift is refined below a pixel: not at all, by a parabola, by"
    " least squares matching",
    "threshold": "least correlation r of the chip and what is found",
    "ratio": "a second place above this share of r makes a point ambiguous",
    "largest_sd": "largest predicted standard deviation of a shift, in pixels",
    "smooth": "standard deviation in pixels of the Gaussian that removes aliasing",
    "start": "shift expected at each point, from reduced images",
    "offset": "column and row of the reference image's first pixel in the sensed one",
}

# Statuses of points: name, meaning, what helps, in words of images
WORDS = {status: (status, *words) for status, words in matching.STATUSES.items()}
WORDS |= vars(_page.SENTENCES.get_template("registration_statuses.j2").module)["WORDS"]

ROUNDING = 0.28  # px; the sd of a whole pixel is 1 / sqrt(12), or more
FINEST = 1e-3  # px; a smaller standard deviation adds no more digits
# What all points may be off together, in px, by how they were refined: rounding, pixel
# locking, alias, two resamplings. Their scatter does not show it. As a real scene gave
# it, averaged down 2 to 4 times, and two scenes of one pass, each resampled by itself.
COMMON = {None: 1 / np.sqrt(12), "parabola": 0.05, "lsm": 0.01}
UNSMOOTHED = 0.03  # the same of "lsm", where the alias was left

# Limits of the findings
FEW = 12  # points
BORDER = 0.1  # of the points
CHANGED = 0.2  # of the points
FAR = 0.5  # of the radius
NOISE = 2.0  # sigma0
EXPLAINED = 1.5  # sigma0
STILL = 1e-3  # px
PARTS, LEAST = 16, 3  # of the image, with their points: do neighbours share an error?
BENT = 0.5  # of what an affine model leaves
TREND = 3.0  # times what the shift is known to
CORNER, PLATEAU = 8, 0.05  # px of one grey value, and the share of all that have it


def html(
    found: Registration,
    reference: Raster | ArrayLike,
    sensed: Raster | ArrayLike,
    *,
    model: Model | None = None,
    start: Start | None = None,
    pixel_size: float | None = None,
    settings: Mapping[str, object] | None = None,
    about: str = "",
) -> str:
    """Report a registration as an HTML page that needs no other file.

    Parameters
    ----------
    found : Registration
        What `registration.register` returned.
    reference, sensed : Raster or array_like (rows, columns)
        The images that were registered.
    model : Model, optional
        What `registration.fit` returned; without it, nothing is resampled.
    start : Start, optional
        What `registration.approximate` returned, if the search began there.
    pixel_size : float, optional
        Of the reference image in metres, where the image itself does not say it.
    settings : mapping {name: value}, optional
        Arguments that `registration.register` was given, `refine` among them if it was;
        the report shows the defaults of the others.
    about : str
        A sentence for the head of the report: the place, the files, the date.

    Returns
    -------
    str
        The page with its figures, for light and dark screens and for paper.

    Raises
    ------
    ValueError
        If an argument is not what is described here.
    """
    from pgm_lab.report import _figures  # matplotlib only when it is needed

    case = Case(found, reference, sensed, model, start, pixel_size, settings)
    draw = _figures.of_registration(case)
    return as_html(TITLE, case.sections(about, False, draw), {about} - {""})


def text(
    found: Registration,
    reference: Raster | ArrayLike,
    sensed: Raster | ArrayLike,
    *,
    model: Model | None = None,
    start: Start | None = None,
    pixel_size: float | None = None,
    settings: Mapping[str, object] | None = None,
    about: str = "",
    short: bool = False,
) -> str:
    """Report a registration in plain text.

    Parameters
    ----------
    found, reference, sensed, model, start, pixel_size, settings, about
        As for `html`.
    short : bool
        Leave out the points and how they were computed.

    Returns
    -------
    str
        Lines of at most 88 characters, but for wide tables.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> scene = landsat().grey
    >>> pair = scene[:200, :200], scene[2:202, 1:201]
    >>> points = registration.pick(pair[0], 9)
    >>> found = registration.register(*pair, points, refine="lsm")
    >>> words = text(found, *pair, settings={"refine": "lsm"}, short=True)
    >>> print(words.splitlines()[3][:61])
    The sensed image lies 1.00 px farther to the left and 2.00 px
    """
    case = Case(found, reference, sensed, model, start, pixel_size, settings)
    return as_text(TITLE, case.sections(about, short))


def reason(found: Registration) -> str:
    """Say why nothing was accepted, for a command that reports nothing then."""
    why = _points.lost(found, WORDS)[0]
    return (
        f"none of {len(found.points)} points was accepted; most often ({why.number})"
        f' the reason is "{why.name}": {why.advice}'
    )


def unmarked(reference: Raster, sensed: Raster) -> str:
    """Say which grey value may stand for missing data, though nothing says so."""
    words = ""
    for name, image in (("reference", reference), ("sensed", sensed)):
        ends = slice(CORNER), slice(-CORNER, None)
        corners = [image.values[i, j] for i in ends for j in ends]
        flat = {float(np.ma.min(one)) for one in corners if np.ma.ptp(one) == 0}
        for value in sorted(flat):
            share = np.ma.mean(image.values[::4, ::4] == value)
            if share >= PLATEAU:
                words += (
                    f"{100 * share:.0f} % of the {name} image have the value {value:g},"
                    " a corner among them. If it stands for missing data, --nodata"
                    f" {value:g} leaves it out. "
                )
    return words


def _of_parts(points: np.ndarray, shifts: np.ndarray) -> float:
    """Standard deviation of the mean of the medians of parts of the image."""
    parts = [np.arange(len(points))]
    while len(parts) < PARTS and min(map(len, parts)) >= 2 * LEAST:
        # Each in two halves, across its longer side
        longer = [np.ptp(points[k], axis=0).argmax() for k in parts]
        sorted_ = [k[np.argsort(points[k, i])] for k, i in zip(parts, longer)]
        parts = [half for k in sorted_ for half in np.array_split(k, 2)]
    if len(parts) == 1:
        return 0.0
    medians = [np.median(shifts[k], axis=0) for k in parts]
    return float(np.std(medians, axis=0, ddof=1).max() / np.sqrt(len(parts)))


def _raster(image: Raster | ArrayLike, name: str) -> Raster:
    if isinstance(image, Raster):
        return image
    values = matching.read(image, name)
    return Raster(np.ma.getdata(values), np.ma.getmaskarray(values))


class Case(_points.Points):
    """Two images, what was asked and what was found: all that the sentences need.

    `pixel_size` (2,) is across and down in metres, or None.
    """

    NAME, FEW, WORDS, SETTINGS = "registration", FEW, WORDS, SETTINGS
    found: Registration

    def __init__(
        self,
        found: Registration,
        reference: Raster | ArrayLike,
        sensed: Raster | ArrayLike,
        model: Model | None = None,
        start: Start | None = None,
        pixel_size: float | None = None,
        settings: Mapping[str, object] | None = None,
    ) -> None:
        _validate.instance(found, Registration, "found")
        if model is not None:
            _validate.instance(model, Model, "model")
            if len(model.used) != len(found.points):
                raise ValueError(
                    f"model is of {len(model.used)} points, and found has"
                    f" {len(found.points)}: fit it to this registration"
                )
        super().__init__(
            found, _points.asked(registration.register, settings, SETTINGS)
        )
        sd = found.sd[found.accepted]
        if self.asked["refine"] is None and np.any(sd < ROUNDING):
            raise ValueError(
                "settings must say how the shifts were refined, for example"
                " {'refine': 'lsm'}: those of found are known better than whole pixels"
            )
        self.reference = _raster(reference, "reference")
        self.sensed = _raster(sensed, "sensed")
        self.model, self.start = model, start
        self.pixel_size = self.reference.pixel_size
        if self.pixel_size is None and pixel_size is not None:
            self.pixel_size = _validate.pair(pixel_size, "pixel_size", "m")
        self.size = self.reference.grey.shape[::-1]
        offset = self.asked["offset"]
        self.offset = np.zeros(2) if offset is None else np.asarray(offset, float)
        self.radius = int(self.asked["radius"])

    @staticmethod
    def label(status: str) -> str:
        """Name of a status, in words of images."""
        return WORDS.get(status, (status,))[0]

    @property
    def north_up(self) -> bool:
        """Whether columns count to the east and rows to the south, as it is known."""
        if self.reference.transform is None:
            return False
        (a, b, _), (d, e, _) = self.reference.transform
        return bool(a > 0 > e and b == d == 0)

    @cached_property
    def given(self) -> bool:
        """Whether an offset was given that is not what their maps say."""
        if self.asked["offset"] is None:
            return False
        try:
            on_map = registration.offset(self.reference, self.sensed)
        except ValueError:  # no part of the map in common, or no map
            on_map = np.zeros(2)
        return not np.allclose(self.offset, on_map, rtol=0, atol=1e-6)

    @cached_property
    def unmarked(self) -> str:
        """Which grey value may stand for missing data."""
        return unmarked(self.reference, self.sensed)

    # --- The shift, and how sure it is ---

    @cached_property
    def shift(self) -> np.ndarray:
        """Median shift (2,) of the accepted points in pixels."""
        a = self.found.accuracy
        return np.array([a.median_x, a.median_y])

    @cached_property
    def known(self) -> float:
        """Standard deviation of a coordinate of that shift, in pixels.

        From the scatter of the shifts, as that of a median, and of parts of the image,
        which is larger where neighbours share an error; of few points what they
        predict, if that is more. And what all may be off together.
        """
        a, good = self.found.accuracy, self.found.accepted
        own = np.sqrt(np.pi / 2 / a.n) * max(a.spread_x, a.spread_y)
        if a.n < FEW:
            own = max(own, float(np.median(self.found.sd[good])) / np.sqrt(a.n))
        else:
            own = max(own, _of_parts(self.found.points[good], a.shifts))
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
        d = self.found.shifts - self.shift
        d[~self.found.accepted] = np.nan
        return d

    @property
    def chance(self) -> float:
        """What the shifts of a coordinate would scatter by chance: sd in pixels.

        All positions of the search window alike, but for its border, which is refused.
        """
        return float(np.sqrt(((2 * self.radius - 1) ** 2 - 1) / 12))

    @cached_property
    def affine(self) -> Model | None:
        """The affine model of the shifts; None if they do not determine it."""
        return self._model("affine")

    @cached_property
    def local(self) -> Model | None:
        """The local model of the shifts; None if they do not determine it."""
        return self._model("local")

    def _model(self, kind: str) -> Model | None:
        if self.model is not None and self.model.kind == kind:
            return self.model
        try:
            return fit(self.found, kind, offset=self.offset)
        except ValueError:  # too few points, or all on one line
            return None

    @cached_property
    def agrees(self) -> bool:
        """Whether the shifts agree, or are spread as if by chance.

        With each other, with the start or, if they are many, with another model.
        """
        good = self.found.accepted
        if np.sum(good) < 3 or self.chance == 0:
            return bool(np.any(good)) and bool(2 * np.sum(good) >= len(good))
        found = [self.errors]
        if self.start is not None:  # large chips found these shifts too
            found.append(self.found.shifts - self.start.shifts(self.found.points))
        if np.sum(good) >= FEW:
            models = self.affine, self.local
            found += [one.residuals for one in models if one is not None]
        spreads = [SD_OF_MAD * np.median(np.abs(v[good]), axis=0).max() for v in found]
        return bool(min(spreads) < self.chance / 2)

    @cached_property
    def cause(self) -> str:
        """How the sensed image is turned or inverted, where few points were found."""
        if self.agrees and self.found.accepted.mean() >= _points.HALF:
            return ""
        return cause(self.reference.values, self.sensed.values)

    @property
    def left(self) -> float:
        """RMSE_T of the shifts minus the model, or minus their median, in pixels."""
        v = self.errors[self.found.accepted]
        return float(np.sqrt(np.mean(np.sum(v**2, axis=1))))

    # --- Lengths in words ---

    @property
    def decimals(self) -> float:
        """Decimals of a shift in pixels, as many as are known."""
        return max(0.0, -np.floor(np.log10(self.known)))

    def length(self, x: float, axis: int = 0) -> str:
        """Write a length in pixels, and in metres where a pixel's size is known."""
        words = f"{fixed(np.array([x]), self.decimals)[0]} px"
        if self.pixel_size is None:
            return words
        size = self.pixel_size[axis]
        decimals = self.decimals - np.floor(np.log10(size) + 0.5)
        return f"{words} ({fixed(np.array([x * size]), decimals)[0]} m)"

    def total(self, px: float) -> str:
        """Write a length in no certain direction."""
        words = f"{plain(px, 3)} px"
        if self.pixel_size is None or self.pixel_size[0] != self.pixel_size[1]:
            return words
        return f"{words} ({plain(px * self.pixel_size[0], 3)} m)"

    @property
    def directions(self) -> list[str]:
        """The shift by axis, such as "1.25 px farther to the right"."""
        ways = ("farther to the right", "farther to the left"), ("lower", "higher")
        if self.north_up:
            ways = ("east", "west"), ("south", "north")
        return [
            f"{self.length(abs(x), axis)} {ways[axis][int(x < 0)]}"
            for axis, x in enumerate(self.shift)
            if abs(x) >= 0.5 * 10**-self.decimals
        ]

    # --- What to look at ---

    def number(self, *statuses: str) -> int:
        """Return how many points have one of some statuses."""
        return int(np.sum(np.isin(self.found.status, statuses)))

    @property
    def twice(self) -> bool:
        """Whether both images seem to be the same."""
        found, good = self.found, self.found.accepted
        still = np.abs(found.shifts[good]) <= STILL
        return bool(np.any(good) and still.all() and found.r[good].min() >= 0.9999)

    @cached_property
    def crowded(self) -> tuple[float, str] | None:
        """Which part of the image the points span, and where, if it is small."""
        return _points.crowded(self.found.points[self.found.accepted], self.size)

    @cached_property
    def trend(self) -> float | None:
        """By how many pixels the shift changes to a corner, if that is significant."""
        affine = self.affine
        if affine is None or affine is self.model or not self.agrees or self.bent:
            return None
        a1, a2, b1, b2 = affine.parameters[[1, 2, 4, 5]]
        half = np.ptp(self.found.points[affine.used], axis=0) / 2
        change = np.abs([(a1, a2), (b1, b2)]) @ half  # in a corner, against the middle
        variances = np.diagonal(affine.covariance)[[1, 2, 4, 5]]
        sd = np.sqrt(variances).reshape(2, 2) @ half
        if np.all(change < TREND * np.maximum(self.known, sd)):
            return None
        return float(change.max())

    @cached_property
    def bent(self) -> tuple[float, float] | None:
        """What an affine model and a local one leave, in pixels, if that is far less.

        Of each point, predicted by the others: the robust standard deviation.
        """
        affine, local, good = self.affine, self.local, self.found.accepted
        if affine is None or local is None or not self.agrees:
            return None
        left = [float(nmad(one.residuals[good])) for one in (affine, local)]
        return (left[0], left[1]) if left[1] < BENT * left[0] else None

    @cached_property
    def blunders(self) -> np.ndarray:
        """Indices of accepted points that do not fit the model."""
        if self.model is None or not self.agrees:
            return np.array([], int)
        return np.flatnonzero(self.found.accepted & ~self.model.used)

    # --- Tables ---

    def accuracy_table(self) -> Table:
        """Return means, root mean squares and quantiles, in pixels and metres."""
        a = self.found.accuracy
        kinds = [a] if self.pixel_size is None else [a, a.times(self.pixel_size)]
        right, down = ("east", "south") if self.north_up else ("to the right", "down")
        rows = [
            (name, *fixed(np.array([getattr(one, field) for one in kinds]), 3), words)
            for name, field, words in (
                ("mean dx", "mean_x", f"common shift, {right} if positive"),
                ("mean dy", "mean_y", f"common shift, {down} if positive"),
                ("RMSE_x", "rmse_x", "root mean square of dx, with its mean"),
                ("RMSE_y", "rmse_y", "the same of dy"),
                ("RMSE_T", "rmse_t", "of both: root of RMSE_x^2 + RMSE_y^2"),
                ("CE90", "ce90", "nine tenths of the shifts are not longer"),
                ("CE90 if normal", "ce90_normal", "1.517 times RMSE_T"),
                ("median dx", "median_x", "a few blunders hardly move it"),
                ("median dy", "median_y", "the same of dy"),
                ("spread dx", "spread_x", "robust standard deviation of dx"),
                ("spread dy", "spread_y", "the same of dy"),
            )
        ]
        header = ["measure", *["px", "m"][: len(kinds)], "what it says"]
        return Table(f"Accuracy from {a.n} accepted points", header, rows)

    def model_table(self) -> Table:
        """Return the parameters of the model with their standard deviations."""
        assert self.model is not None
        model = self.model
        rows = [
            (name, *scientific(x, sd), "px" if name.endswith("0") else "px a pixel")
            for name, x, sd in zip(model.names, model.parameters, model.sd)
        ]
        header = ("parameter", "value", "sd", "unit")
        return Table(f"Model: {model.kind}", header, rows)

    def points_table(self) -> Table:
        """Return the first points with their shifts."""
        found = self.found
        n = min(_points.MAX_ROWS, len(found.points))
        sd = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))
        digits = np.maximum(found.sd, FINEST)
        second = np.where(found.second > -1, found.second, np.nan)
        columns = [
            [str(i) for i in range(n)],
            *(fixed(one, 2) for one in found.points[:n].T),
            *(rounded(one, digits)[:n] for one in (found.dx, found.dy)),
            *(rounded(one, digits)[:n] for one in sd.T),
            fixed(found.r[:n], 3),
            fixed(second[:n], 3),
            [self.label(str(one)) for one in found.status[:n]],
        ]
        header = "point", "column", "row", "dx", "dy", "sd dx", "sd dy", "r", "second r"
        caption = (
            "Points in the reference image and their shifts in pixels, columns to the"
            " right and rows down, from 0"
        )
        caption = _points.first_rows(caption, len(found.points))
        return Table(caption, (*header, "status"), list(zip(*columns)))
