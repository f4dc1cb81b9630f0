"""Chips of a reference image found in a sensed one by Pearson's correlation."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import ArrayLike

from pgm_lab import _validate, lsm, ncc
from pgm_lab._statuses import STATUSES, Table
from pgm_lab.io import text
from pgm_lab.registration.accuracy import Accuracy, accuracy

REFINEMENTS = ("parabola", "lsm")
# Predicted standard deviation in px up to which a shift is accepted, by default; of
# "lsm" also that of a chip with a tenth of the weight of most others, up to half a px
LARGEST_SD = {None: 0.5, "parabola": 0.1, "lsm": 0.05}
TENTH = np.sqrt(10)  # times the median
HALF = 0.5  # px
MAX_STEP = 1.0  # px between the highest whole pixel and the least squares result

# Chips side by side around a chip, in its widths: their third difference does not know
# of a shift that changes smoothly, only of their errors
BESIDE = np.array([-1.5, -0.5, 0.5, 1.5])
THIRD = np.array([1.0, -3.0, 3.0, -1.0])
SAMPLE = 200  # chips by which the predicted covariances are judged
WITHIN = 0.6827  # of normal errors are within one standard deviation sigma
SD_OF_SIGMA = 0.962  # times sigma / sqrt(n), if n errors show it in this way
SURE = 2.58  # standard deviations; by chance one in a hundred is farther off

# A chip that changed is compared with its neighbours
NEIGHBOURS = 8  # accepted chips around it
MIN_ACCEPTED = 5  # to know what is typical
UNEXPLAINED = 0.5  # least share of its variance that the other image does not explain
SNR_RATIO = 4.0  # signal-to-noise ratio that is expected, over its own, at least

COLUMNS = (
    *("chip", "column in the reference (px)", "row in the reference (px)"),
    "shift of the column (px; sensed minus reference)",
    "shift of the row (px; sensed minus reference; down is positive)",
    *("r at the highest peak", "r at the second peak (-1: none)"),
    *("variance of the column (px2)", "covariance (px2)", "variance of the row (px2)"),
    "status",
)


@dataclass(frozen=True, eq=False)
class Registration(Table):
    """Where n chips of the reference image lie in the sensed one.

    Attributes
    ----------
    points : ndarray (n, 2)
        (column, row) in the reference image, in pixels, as given.
    dx, dy : ndarray (n,)
        Shift in pixels, sensed minus reference, beyond the offset, right and down. That
        of the highest peak, whatever the status; NaN where nothing was compared.
    r : ndarray (n,)
        Pearson's r at the highest whole pixel; NaN where nothing was compared.
    second : ndarray (n,)
        At the second highest peak; -1 where there is no other, NaN as for r.
    covariance : ndarray (n, 2, 2)
        Of (dx, dy) as predicted, in square pixels; NaN unless accepted.
    status : ndarray (n,) of str
        "accepted", or what went wrong first: one of `matching.STATUSES`.
    factor : float
        By how much the standard deviations of "lsm" were multiplied, as chips beside
        each other scatter.
    """

    points: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    r: np.ndarray
    second: np.ndarray
    covariance: np.ndarray
    status: np.ndarray
    factor: float = 1.0

    @property
    def shifts(self) -> np.ndarray:
        """(dx, dy) of all chips: (n, 2)."""
        return np.column_stack([self.dx, self.dy])

    @cached_property
    def accuracy(self) -> Accuracy:
        """Means, root mean squares and quantiles of the accepted shifts, in pixels."""
        if not self.accepted.any():
            raise ValueError(self._nothing_accepted())
        return accuracy(self.dx[self.accepted], self.dy[self.accepted])

    @property
    def rmse_t(self) -> float:
        """Of the accepted shifts, in pixels (Br 4)."""
        return self.accuracy.rmse_t

    @property
    def ce90(self) -> float:
        """Length that nine tenths of the accepted shifts do not exceed, in pixels."""
        return self.accuracy.ce90

    def _nothing_accepted(self) -> str:
        """What to do when nothing is accepted."""
        if not len(self.status):
            return "there are no chips, and so no shift. Give points"
        found = Counter(map(str, self.status)).most_common()
        counts = ", ".join(f"{number} {status}" for status, number in found)
        meaning, help = STATUSES[found[0][0]]
        return (
            f"none of {len(self.status)} chips is accepted, and the transformation is"
            f" undetermined: {counts}. For most, {meaning}: {help}. If the images show"
            " the same ground, their shift may be larger than the radius"
        )

    def csv(self) -> str:
        """Return the table that `save` writes."""
        C = self.covariance
        numbers = np.column_stack(
            [self.points, self.dx, self.dy, self.r, self.second, C[:, 0, 0],
             C[:, 0, 1], C[:, 1, 1]]
        )  # fmt: skip
        return text.written(COLUMNS, numbers, self.status)


def register(
    reference: ArrayLike,
    sensed: ArrayLike,
    points: ArrayLike,
    chip: int = 21,
    radius: int = 3,
    refine: str | None = None,
    *,
    threshold: float = 0.7,
    ratio: float = 0.9,
    largest_sd: float | None = None,
    smooth: float = 1.0,
    offset: ArrayLike | None = None,
    start: ArrayLike | None = None,
) -> Registration:
    """Find chips of the reference image in the sensed image, all in one call.

    The chip around each point is compared with every position up to `radius` pixels
    away in the sensed image; it matches where Pearson's r (Br 1) is highest; the shift
    is sensed minus reference.

    Parameters
    ----------
    reference, sensed : array_like (rows, columns)
        Grey values, 8 or 16 bit or float, one band. Pixels without data may be masked
        (`numpy.ma`), NaN or infinite. Of the same shape, unless `offset` is given.
    points : array_like (n, 2)
        (column, row) in the reference image, in pixels. The chip lies around the
        nearest whole pixel.
    chip : int
        Pixels across a chip, odd, at least 5.
    radius : int
        Whole pixels searched to each side, at least 1; a peak on that border is not
        accepted.
    refine : None, "parabola" or "lsm"
        Whole pixels, as in the paper; the vertex of the paraboloid through the peak
        and its eight neighbours; or least squares matching (`lsm.match`) from there.
    threshold : float
        Smallest r that is accepted.
    ratio : float
        A chip is ambiguous if its second peak is higher than this share of the first.
    largest_sd : float, optional
        Largest predicted standard deviation of a coordinate that is accepted, in
        pixels. Default: 0.5 (rounding to whole pixels alone gives 0.29), 0.1 with
        "parabola"; with "lsm" 3.2 times the median of all chips, so that none has less
        than a tenth of their weight in `fit`, but at least 0.05 and at most 0.5.
    smooth : float
        Standard deviation in pixels of the Gaussian by which "lsm" smooths both images,
        see there; 0 if nothing in them is finer than their pixels.
    offset : array_like (2,), optional
        (column, row) where the first pixel of the reference image should lie in the
        sensed one, if that begins elsewhere; the shifts are relative to it.
    start : array_like (n, 2), optional
        Shift expected at each point, such as that of `approximate`: the search is
        around it.

    Returns
    -------
    Registration
        Shifts, r, predicted covariance and status of each chip, and the accuracy of the
        accepted ones.

    Raises
    ------
    ValueError
        For a colour image, or images of two shapes without `offset`. What happens to a
        single chip is shown by its status.

    Notes
    -----
    The statuses are those of `ncc.match` and `lsm.match`, and two more. "not precise
    enough": the predicted standard deviation is above `largest_sd`. "changed": textured
    in both images, yet similar to nothing within the radius, as a ploughed field. With
    the eight nearest accepted chips (of at least five), of the variances V, a chip
    should reach an R with

        1 - R^2 = max(median(1 - r^2), min((1 - r^2) V) / V)

    in either image: the losses by sampling and by noise. It changed if R would have
    been accepted, but less than half of V is explained, and the signal-to-noise ratio
    r^2 : (1 - r^2) is below a quarter of that of R.

    Detail too fine for a pixel leaves an alias that does not move with the rest. In a
    Landsat image, reduced 2 to 4 times by averaging, 50 picked chips had errors
    (RMSE_T) of 0.04 to 0.05 px by "lsm" without smoothing, 0.02 smoothed by 1 px;
    "parabola" 0.07 to 0.11. Errors common to all chips are not predicted.

    References
    ----------
    Brahmantara 2015, (Br 1) to (Br 4).

    Examples
    --------
    >>> from pgm_lab import datasets, simulate
    >>> reference, sensed = simulate.shrunk_pair(datasets.landsat().grey, (3, -2), 4)
    >>> points = [(60, 50), (150, 80), (90, 200), (150, 250), (220, 150)]
    >>> found = register(reference, sensed, points, refine="lsm")
    >>> print(found.status[0], found.dx.round(2), found.dy.round(2))
    accepted [0.75 0.74 0.75 0.76 0.76] [-0.49 -0.49 -0.5  -0.48 -0.49]
    """
    points = _validate.point_list(points, "points")
    chip = _validate.window(chip, "chip", 5)
    radius = _validate.whole(radius, "radius", 1)
    if refine is not None:
        _validate.choice(refine, "refine", REFINEMENTS)
    if largest_sd is not None:
        largest_sd = _validate.positive_number(largest_sd, "largest_sd", "px")
    smooth = _validate.smoothing(smooth)
    reference = _validate.grey_image(reference, "reference")
    sensed = _validate.grey_image(sensed, "sensed")
    if offset is None:
        if reference.shape != sensed.shape:
            raise ValueError(
                "reference and sensed must show the same area, pixel on pixel; got"
                f" {reference.shape} and {sensed.shape}. Cut both to the area they have"
                " in common, or give in offset=(column, row) where the first pixel of"
                " the reference lies in the sensed image"
            )
        offset = (0.0, 0.0)
    origin = points + _validate.of_shape(offset, (2,), "offset")
    if start is None:
        start = np.zeros_like(points)
    start = origin + _validate.point_list(start, "start", len(points))

    # Find the peak of r
    found = ncc.match(
        *(reference, sensed, points, start, chip, chip + 2 * radius, threshold, ratio),
        refine="parabola" if refine == "parabola" else None,
    )
    place, covariance, status = found.points, found.covariance, found.status

    # Refine the accepted chips; where that fails, the peak stays
    factor = 1.0
    if refine == "lsm":
        k = np.flatnonzero(found.accepted)
        least = max(threshold, 0.0)
        match = partial(
            lsm.match, reference, sensed, template=chip, threshold=least, smooth=smooth
        )
        fine = match(points[k], place[k])
        step = np.abs(fine.points - place[k]).max(axis=1)  # NaN unless accepted
        status[k] = np.where(step > MAX_STEP, "diverged", fine.status)
        good = status[k] == "accepted"
        place = place.copy()  # that of whole pixels tells what changed
        place[k[good]] = fine.points[good]
        covariance[:] = np.nan
        k = k[good]
        factor = _factor(match, points[k], place[k], chip)
        covariance[k] = factor**2 * fine.covariance[good]

    # Refuse what is imprecise, or changed
    sd = found.sd
    if largest_sd is None:
        largest_sd = LARGEST_SD[refine]
        if refine == "lsm" and (status == "accepted").any():
            median = np.median(sd[status == "accepted"])
            largest_sd = np.clip(TENTH * median, largest_sd, HALF)
    status[sd > largest_sd] = "not precise enough"
    changed = _changed(reference, sensed, points, found, status, chip, threshold)
    status[changed] = "changed"
    covariance[status != "accepted"] = np.nan
    dx, dy = (place - origin).T
    r, second = found.r, found.second
    return Registration(points, dx, dy, r, second, covariance, status, factor)


# --- How far chips are off, beside what they predict ---


def _factor(
    match: Callable[..., lsm.Match], points: np.ndarray, place: np.ndarray, chip: int
) -> float:
    """Errors relative to the predicted ones; 1 unless more than chance."""
    some = slice(None, None, -(-len(points) // SAMPLE) or 1)
    points, place = points[some], place[some]
    # (n, axis, 4, 2): side by side along the columns, and along the rows
    beside = np.floor(BESIDE[:, None] * chip + 0.5) * np.eye(2)[:, None]
    at, start = (p[:, None, None] + beside for p in (points, place))
    found = match(at.reshape(-1, 2), start.reshape(-1, 2))
    d = THIRD @ (found.points.reshape(at.shape) - at)
    variances = np.diagonal(found.covariance, axis1=1, axis2=2).reshape(at.shape)
    errors = d / np.sqrt(THIRD**2 @ variances)
    known = np.isfinite(errors).all(axis=-1)
    if not known.any():
        return 1.0
    # Where the errors of some are predicted too large, the median of all would make
    # those of the others too small
    factor = float(np.quantile(np.abs(errors[known]), WITHIN))
    chance = SURE * SD_OF_SIGMA / np.sqrt(2 * _independent(at[known], chip))
    sure = factor > 0 and abs(np.log(factor)) > chance
    return factor if sure else 1.0


def _independent(at: np.ndarray, chip: int) -> float:
    """How many independent third differences those of chips (m, 4, 2) are worth."""
    # Chips that overlap share as much of their noise, and of their errors
    m, of_all = len(at), at.reshape(-1, 2)
    shared = np.maximum(1 - np.abs(of_all[:, None] - of_all) / chip, 0).prod(axis=-1)
    correlation = THIRD @ (shared.reshape(m, 4, m, 4) @ THIRD) / (THIRD @ THIRD)
    return m**2 / float(np.sum(correlation**2))


# --- Chips that changed: textured in both images, but matched by nothing ---


def _changed(
    reference: np.ndarray,
    sensed: np.ndarray,
    points: np.ndarray,
    found: ncc.Match,
    status: np.ndarray,
    chip: int,
    threshold: float,
) -> np.ndarray:
    """Which chips (n,) changed, by the rule in the notes of `register`."""
    changed = np.zeros(len(points), bool)
    accepted = np.flatnonzero(status == "accepted")
    if len(accepted) < MIN_ACCEPTED:
        return changed
    # Share of a chip's variance that the other image does not explain; NaN if flat
    share = 1 - np.maximum(found.r, 0) ** 2
    k = np.flatnonzero(share > UNEXPLAINED)
    # Allow a chip the loss of its neighbours by sampling, ...
    number = min(NEIGHBOURS, len(accepted))
    near = accepted[scipy.spatial.cKDTree(points[accepted]).query(points[k], number)[1]]
    expected = np.median(share[near], axis=1)
    # ... or by their least noise, relative to its texture, in either image
    some = np.unique(near)
    for image, at in ((reference, points), (sensed, found.points)):
        noise = np.zeros(len(points))
        noise[some] = share[some] * _variances(image, at[some], chip)
        with np.errstate(divide="ignore", invalid="ignore"):
            hidden = noise[near].min(axis=1) / _variances(image, at[k], chip)
        expected = np.fmin(np.maximum(expected, hidden), 1)  # 1 where it is flat
    # Compare the signal-to-noise ratios r^2 : (1 - r^2)
    far = (1 - share[k]) * expected < share[k] * (1 - expected) / SNR_RATIO
    changed[k] = far & (1 - expected >= max(threshold, 0) ** 2)
    return changed


def _variances(image: np.ndarray, at: np.ndarray, chip: int) -> np.ndarray:
    """Variances (n,) of the chips around whole pixels (n, 2), 2000 at a time."""
    windows = sliding_window_view(np.ma.getdata(image), (chip, chip))
    column, row = (np.floor(at + 0.5) - chip // 2).astype(int).T
    parts = [slice(i, i + 2000) for i in range(0, len(at), 2000)]
    found = [windows[row[p], column[p]].var(axis=(1, 2), dtype=float) for p in parts]
    return np.concatenate(found) if found else np.zeros(0)
