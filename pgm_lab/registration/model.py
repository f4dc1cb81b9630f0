"""Where the sensed image lies, everywhere: fitted to the shifts, applied to the image.

Blunders among the shifts are found by the least median of squares.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
import scipy
from numpy.typing import ArrayLike

from pgm_lab import _validate, image
from pgm_lab.adjustment import UNCONTROLLED, adjust
from pgm_lab.adjustment.result import residual_statistics
from pgm_lab.image.grey import as_type
from pgm_lab.io.geotiff import MAX_PIXELS, without_data
from pgm_lab.registration import field as smooth_field
from pgm_lab.registration.chips import Registration
from pgm_lab.registration.field import LIMIT, Field

NAMES = {
    "shift": ("a0", "b0"),
    "affine": ("a0", "a1", "a2", "b0", "b1", "b2"),
    "local": ("a0", "b0"),
}
# Half of all residuals are not longer than this many standard deviations of one
# coordinate, if normal: the median of the chi distribution with two degrees of freedom.
CIRCULAR_SD = np.sqrt(2 * np.log(2))  # 1.1774
DRAWS = 500  # of the fewest points that determine the model
SAMPLE = 2000  # points by which a draw is judged
MAX_ITERATIONS = 50  # of selecting the points that agree
MAX_CONDITION = 1e12  # of the equations of a draw: above, its points lie on one line

STRIP = 1_000_000  # pixels that are resampled at a time
# Pixels around a point on which a cubic spline depends: the weight of a pixel falls to
# 0.27 of its neighbour's
REACH = 20
AROUND = np.ones((4, 4), np.uint8)


@dataclass(frozen=True, eq=False)
class Model:
    """Where a sensed image lies on the reference image, everywhere.

    With x, y the column and row in the reference image, minus those of `centre`, the
    shift is ``dx = a0 + a1 x + a2 y``, ``dy = b0 + b1 x + b2 y``; of a "shift" it is
    ``dx = a0``, ``dy = b0``. The position in the sensed image is x + dx, y + dy, plus
    `offset`.

    Attributes
    ----------
    kind : str
        "shift" or "affine".
    parameters : ndarray (u,)
        (a0, b0), or (a0, a1, a2, b0, b1, b2); a0 and b0 in pixels, the others without
        unit.
    covariance : ndarray (u, u)
        Of the parameters, with the estimated sigma0.
    sigma0 : float
        Standard deviation of unit weight: errors relative to the predicted ones.
    redundancy : int
        Number of coordinates used minus parameters.
    residuals : ndarray (n, 2)
        Of (dx, dy), computed - observed, in pixels; NaN where nothing was accepted.
    used : ndarray (n,) of bool
        Accepted by the matching, and not a blunder.
    centre : ndarray (2,)
        (column, row) in the reference image that x and y are counted from.
    offset : ndarray (2,)
        As given to `register`.
    """

    kind: str
    parameters: np.ndarray
    covariance: np.ndarray
    sigma0: float
    redundancy: int
    residuals: np.ndarray = field(repr=False)
    used: np.ndarray = field(repr=False)
    centre: np.ndarray
    offset: np.ndarray

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return NAMES[self.kind]

    @property
    def sd(self) -> np.ndarray:
        """Standard deviations of the parameters (u,)."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def matrix(self) -> np.ndarray:
        """The 2 x 3 matrix that maps (column, row, 1) to the sensed image."""
        a0, b0 = self.apply(np.zeros(2))
        (a1, b1), (a2, b2) = self.apply(np.eye(2)) - (a0, b0)
        return np.array([[a1, a2, a0], [b1, b2, b0]])

    def apply(self, points: ArrayLike) -> np.ndarray:
        """Return where points of the reference image lie in the sensed image.

        Both (..., 2), (column, row) in pixels.
        """
        points = _validate.points(points, 2, "points")
        parameters = self.parameters.reshape(2, -1)
        places = points + (self.offset + parameters[:, 0])
        if self.kind == "affine":
            places += (points - self.centre) @ parameters[:, 1:].T
        return places


@dataclass(frozen=True, eq=False)
class Local(Model):
    """A shift that changes smoothly over the image, in no simpler way.

    `parameters` is the shift at the mean of the points; the residuals of those used are
    what the others predict of them, minus their shifts.

    Attributes
    ----------
    field : Field
        The shifts as a function of the place, counted from `centre`.
    """

    field: Field

    def apply(self, points: ArrayLike) -> np.ndarray:
        """Return where points of the reference image lie in the sensed image."""
        points = _validate.points(points, 2, "points")
        return points + self.offset + self.field.at(points - self.centre)

    def sd_at(self, points: ArrayLike) -> np.ndarray:
        """Standard deviations (n, 2) of the shifts at points (n, 2), in pixels."""
        points = _validate.point_list(points, "points")
        return self.field.spline.sd_at(points - self.centre)


def fit(
    found: Registration,
    kind: str = "shift",
    *,
    offset: ArrayLike = (0.0, 0.0),
) -> Model:
    """Fit one shift, one affine transformation or a smooth field to registered chips.

    Accepted shifts are weighted by their predicted covariance. The start is the least
    median of squares, over models through the fewest points. Points whose residual
    exceeds 3.72 robust standard deviations (one good point in 1000) are rejected, and
    the others adjusted, until the selection no longer changes.

    A local model is a thin-plate spline, as smooth as the shifts and their standard
    deviations make likely (restricted maximum likelihood).

    Parameters
    ----------
    found : Registration
        From `register`.
    kind : {"shift", "affine", "local"}
        An affine transformation has a scale for each axis, a rotation and a shear too;
        a local model changes as the shifts do.
    offset : array_like (2,)
        As given to `register`.

    Returns
    -------
    Model
        A `Local` one where asked.

    Raises
    ------
    ValueError
        If fewer than two points were accepted (four for "affine", eight for "local"),
        or the model is no shift and all points that agree, or all but one, lie on one
        line.

    Notes
    -----
    Nearly half of the points may be blunders, even if they agree with each other. A
    sigma0 well above 1 means that the images differ in more than a shift and white
    noise (alias, terrain, resampling), or that the model is too simple. The covariance,
    and what counts as a blunder, follow it. Errors are assumed independent from point
    to point: whole-pixel shifts, which may all be rounded to one side, are not.

    References
    ----------
    Rousseeuw 1984, "Least median of squares regression".

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> from pgm_lab.registration import grid, register
    >>> image = landsat().grey[:300, :300]
    >>> moved = np.roll(image, (-2, -1), axis=(0, 1))
    >>> found = register(image, moved, grid(image.shape, 40, 20), refine="lsm")
    >>> print(fit(found).parameters.round(3))
    [-1. -2.]
    """
    _validate.instance(found, Registration, "found")
    kind = _validate.choice(kind, "kind", tuple(NAMES))
    offset = _validate.of_shape(offset, (2,), "offset")
    k = np.flatnonzero(found.accepted)
    points, shifts = found.points[k], found.shifts[k]
    if kind == "local":
        return _local(found, k, shifts, offset)
    fewest = len(NAMES[kind]) // 2  # points that determine the model
    if len(k) <= fewest:
        raise ValueError(
            f"{len(k)} of {len(found.points)} points were accepted, and the model"
            f" '{kind}' needs at least {fewest + 1}, one of them as a check."
            " Look at found.status for the reasons"
        )
    centre = points.mean(axis=0)
    A = _design(kind, points - centre)
    _refuse_one_line(kind, points)

    # In units of its standard deviations, along the axes of its error ellipse, each
    # shift has two independent coordinates of weight 1.
    whiten = np.linalg.inv(np.linalg.cholesky(found.covariance[k]))
    WA, Ws = whiten @ A, np.einsum("nij,nj->ni", whiten, shifts)

    # Start robustly, then select the points that agree, and adjust them
    start = _least_median(WA, Ws, fewest)
    good = _agree(WA, Ws, start)
    for _ in range(MAX_ITERATIONS):
        _refuse_one_line(kind, points[good])
        used, B = good, WA[good].reshape(-1, 2 * fewest)
        adjusted = adjust(
            lambda x, B=B: (B @ x, B), start, Ws[good].ravel(), names=NAMES[kind]
        )
        good = _agree(WA, Ws, adjusted.x)
        if np.array_equal(used, good):
            break

    # Residuals in pixels, of all points; which of those used are controlled by others
    residuals = np.full((len(found.points), 2), np.nan)
    residuals[k] = A @ adjusted.x - shifts
    u = k[used]
    weights = np.linalg.inv(found.covariance[u])
    shares, _ = residual_statistics(
        A[used], residuals[u], weights, adjusted.cofactor[None]
    )
    if (alone := shares.sum(axis=1) <= UNCONTROLLED).any():
        column, row = found.points[u][alone][0]
        raise ValueError(
            f"the point ({column:g}, {row:g}) alone determines a part of the affine"
            " transformation: all others lie on one line. Take points beside it,"
            " or fit a 'shift'"
        )
    return Model(
        kind,
        adjusted.x,
        adjusted.covariance,
        float(adjusted.sigma0),
        int(adjusted.redundancy),
        residuals,
        np.isin(np.arange(len(found.points)), u),
        centre,
        offset,
    )


def _local(
    found: Registration, k: np.ndarray, shifts: np.ndarray, offset: np.ndarray
) -> Local:
    """The smooth field of the accepted points k."""
    n, points = len(found.points), found.points[k]
    fitted = smooth_field.fit(points, shifts, found.sd[k])
    if fitted is None:
        raise ValueError(
            f"{len(k)} of {n} points were accepted, and of those fewer than"
            f" {smooth_field.FEWEST} agree with their neighbours, or all lie on one"
            " line: a local model needs more. Take more points, or fit a 'shift'"
        )
    residuals = np.full((n, 2), np.nan)
    residuals[k] = fitted.residuals
    middle = points[fitted.used].mean(axis=0, keepdims=True)
    return Local(
        "local",
        fitted.at(middle)[0],
        np.diag(fitted.spline.sd_at(middle)[0] ** 2),
        float(np.sqrt(np.mean(fitted.sigma0**2))),
        int(np.rint(fitted.free[fitted.used].sum())),
        residuals,
        np.isin(np.arange(n), k[fitted.used]),
        np.zeros(2),
        offset,
        fitted,
    )


def _design(kind: str, points: np.ndarray) -> np.ndarray:
    """Derivatives of (dx, dy) with respect to the parameters (n, 2, u)."""
    f = np.ones((len(points), 1))
    if kind == "affine":
        f = np.concatenate([f, points], axis=-1)  # 1, x, y
    return np.kron(np.eye(2), f[:, None])


def _refuse_one_line(kind: str, points: np.ndarray) -> None:
    along, across = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[:2]
    if kind == "affine" and across <= 1e-9 * along:
        raise ValueError(
            f"the {len(points)} points that agree lie on one line, which leaves an"
            " affine transformation undetermined: take points beside it, or fit a"
            " 'shift'"
        )


def _least_median(A: np.ndarray, shifts: np.ndarray, fewest: int) -> np.ndarray:
    """Parameters through a few points, with the smallest median residual."""
    n, _, u = A.shape
    random = np.random.default_rng(1)
    # Solve the model of each draw
    draws = random.integers(n, size=(DRAWS, fewest))
    some = random.choice(n, min(n, SAMPLE), replace=False)
    N, l = A[draws].reshape(-1, u, u), shifts[draws].reshape(-1, u)  # noqa: E741
    fixed = np.linalg.cond(N) < MAX_CONDITION  # no point twice, not on one line
    models = np.linalg.solve(N[fixed], l[fixed, :, None])[..., 0]
    # Take the one with the smallest median length of the residuals
    lengths = np.linalg.norm(A[some] @ models.T - shifts[some, :, None], axis=1)
    # Of all residuals `fewest` are zero where the model passes through the points.
    middle = len(some) // 2 + (fewest + 1) // 2 - 1
    return models[np.argmin(np.partition(lengths, middle, axis=0)[middle])]


def _agree(A: np.ndarray, shifts: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Whether a point is not a blunder (n,), by the median of all residuals."""
    length = np.linalg.norm(A @ x - shifts, axis=1)  # in predicted standard deviations
    return length <= LIMIT * max(1.0, np.median(length) / CIRCULAR_SD)


def resample(
    sensed: ArrayLike,
    model: Model,
    shape: tuple[int, int],
) -> np.ma.MaskedArray:
    """Resample the sensed image into the pixels of the reference image, strip by strip.

    Grey values between pixels are those of a cubic spline, as in `image.resample`.

    Parameters
    ----------
    sensed : array_like (rows, columns)
        Grey values, 8 or 16 bit or float; masked or NaN where there are none.
    model : Model
        From `fit`.
    shape : (int, int)
        (rows, columns) of the reference image.

    Returns
    -------
    MaskedArray (rows, columns)
        In the type of the sensed image, rounded and clipped to its range. Masked
        outside the sensed image, and where one of the 4 x 4 pixels around has no data;
        0 under the mask.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> from pgm_lab.registration import fit, grid, register
    >>> image = landsat().grey[:300, :300]
    >>> moved = np.roll(image, (-2, -1), axis=(0, 1))
    >>> found = register(image, moved, grid(image.shape, 40, 20), refine="lsm")
    >>> again = resample(moved, fit(found), image.shape)
    >>> again.shape, again.dtype, abs(again.astype(float) - image).mean() < 1
    ((300, 300), dtype('uint16'), np.True_)
    """
    sensed = _validate.grey_image(sensed, "sensed", least=2)
    grey, bad = np.ma.getdata(sensed), without_data(sensed)
    _validate.instance(model, Model, "model")
    rows, columns = (
        _validate.whole(n, "shape", 1) for n in _validate.of_shape(shape, (2,), "shape")
    )
    if rows * columns > MAX_PIXELS:
        raise ValueError(
            f"shape asks for {rows} x {columns} pixels; the limit is {MAX_PIXELS}. It"
            " must be (rows, columns) of the reference image"
        )
    values = np.zeros((rows, columns), grey.dtype)
    mask = np.ones((rows, columns), bool)
    step = max(1, STRIP // columns)
    for top in range(0, rows, step):
        strip = slice(top, min(top + step, rows))
        row, column = np.mgrid[strip, 0:columns]
        places = model.apply(np.stack([column, row], axis=-1))
        _resample_strip(values[strip], mask[strip], grey, bad, places)
    return np.ma.array(values, mask=mask)


def _resample_strip(
    values: np.ndarray,
    mask: np.ndarray,
    grey: np.ndarray,
    bad: np.ndarray,
    places: np.ndarray,
) -> None:
    """Write grey values into a strip, and clear its mask where there are any."""
    size = columns, rows = np.array(grey.shape[::-1])
    x, y = np.moveaxis(places, -1, 0)
    inside = (x >= 0) & (y >= 0) & (x <= columns - 1) & (y <= rows - 1)
    if not inside.any():
        return
    # Cut out the window of the sensed image that the strip depends on
    places = places[inside]
    first = np.maximum(np.floor(places.min(axis=0)).astype(int) - REACH, 0)
    last = np.minimum(np.floor(places.max(axis=0)).astype(int) + REACH + 2, size)
    first = np.minimum(first, last - 2)
    window = np.s_[first[1] : last[1], first[0] : last[0]]
    piece, holes, places = grey[window].astype(float), bad[window], places - first
    known = np.ones(len(places), bool)
    if holes.any():
        if holes.all():
            return
        # Where all of the 4 x 4 pixels around have data
        near = cv2.dilate(holes.astype(np.uint8), AROUND, anchor=(1, 1))
        column, row = places.astype(int).T
        known = near[row, column] == 0
        # Fill the holes from their nearest pixels, or a spline would oscillate there
        nearest = scipy.ndimage.distance_transform_edt(
            holes, return_distances=False, return_indices=True
        )
        piece = piece[tuple(nearest)]
    found = image.resample(piece, places[known])
    k = np.flatnonzero(inside)[known]
    values.reshape(-1)[k] = as_type(found, grey.dtype)
    mask.reshape(-1)[k] = False
