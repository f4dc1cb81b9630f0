"""One transformation for a whole image, from many shifts with blunders among them."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab.adjustment import UNCONTROLLED, Adjustment, adjust
from pgm_lab.adjustment.result import residual_statistics
from pgm_lab.registration.result import Registration

NAMES = {"shift": ("a0", "b0"), "affine": ("a0", "a1", "a2", "b0", "b1", "b2")}
# Half of all residuals are not longer than this many standard deviations of one
# coordinate, if normal: the median of the chi distribution with two degrees of freedom.
CIRCULAR_SD = np.sqrt(2 * np.log(2))  # 1.1774
ALPHA = 0.001  # share of good points that are taken for blunders
LIMIT = np.sqrt(-2 * np.log(ALPHA))  # 3.72 standard deviations, in two dimensions
DRAWS = 500  # of the fewest points that fix the model
LOOKED_AT = 2000  # points that a draw is judged by
ROUNDS = 50
SINGULAR = 1e12  # condition of the equations of points on one line


@dataclass(frozen=True, eq=False)
class Model:
    """Where a sensed image lies on the reference image, everywhere.

    With x, y the column and row in the reference image, less those of `centre`, the
    shift is ``dx = a0 + a1 x + a2 y``, ``dy = b0 + b1 x + b2 y``; of a "shift" it is
    ``dx = a0``, ``dy = b0``. The place in the sensed image is x + dx, y + dy, plus
    `offset`.

    Attributes
    ----------
    kind : str
        "shift" or "affine".
    parameters : ndarray (u,)
        (a0, b0), or (a0, a1, a2, b0, b1, b2); a0 and b0 in pixels, the others have no
        unit.
    covariance : ndarray (u, u)
        Of the parameters, a posteriori: with the estimated sigma0.
    sigma0 : float
        Estimated standard deviation of unit weight: how many of its predicted standard
        deviations a shift is really off.
    redundancy : int
        Coordinates of the points used, less parameters.
    residuals : ndarray (n, 2)
        Of (dx, dy), computed - observed, in pixels; NaN where nothing was accepted.
    redundancy_numbers : ndarray (n, 2)
        Share of each coordinate in the redundancy; NaN unless used.
    standardized : ndarray (n, 2)
        Residuals over their standard deviations, from the estimated sigma0: Pope's tau.
        NaN unless used.
    used : ndarray (n,) of bool
        Accepted by the matching, and no blunder.
    centre : ndarray (2,)
        (column, row) in the reference image that x and y are counted from.
    offset : ndarray (2,)
        As `register` was given it.
    """

    kind: str
    parameters: np.ndarray
    covariance: np.ndarray
    sigma0: float
    redundancy: int
    residuals: np.ndarray = field(repr=False)
    redundancy_numbers: np.ndarray = field(repr=False)
    standardized: np.ndarray = field(repr=False)
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
        """The 2 x 3 matrix that takes (column, row, 1) to the sensed image."""
        a0, b0 = self.apply(np.zeros(2))
        (a1, b1), (a2, b2) = self.apply(np.eye(2)) - (a0, b0)
        return np.array([[a1, a2, a0], [b1, b2, b0]])

    def apply(self, points: ArrayLike) -> np.ndarray:
        """Return where points of the reference image lie in the sensed image.

        Parameters
        ----------
        points : array_like (..., 2)
            (column, row) in the reference image, in pixels.

        Returns
        -------
        ndarray (..., 2)
            (column, row) in the sensed image, in pixels.

        Raises
        ------
        ValueError
            If points are not (..., 2) or not finite.
        """
        points = _validate.points(points, 2, "points")
        parameters = self.parameters.reshape(2, -1)
        places = points + (self.offset + parameters[:, 0])
        if self.kind == "affine":
            places += (points - self.centre) @ parameters[:, 1:].T
        return places


def fit(
    found: Registration,
    kind: str = "shift",
    *,
    offset: ArrayLike = (0.0, 0.0),
) -> Model:
    """Fit one shift, or one affine transformation, to what was registered.

    Each accepted shift is an observation, weighted by its predicted covariance. The
    start is the least median of squares: of many models through the fewest points that
    fix one, that with the smallest median of the residuals. Then points whose residual
    is longer than 3.72 robust standard deviations (one good point in 1000) are left
    out, and the others adjusted, until the choice no longer changes.

    Parameters
    ----------
    found : Registration
        From `register`.
    kind : {"shift", "affine"}
        An affine transformation has a scale for each axis, a rotation and a shear too.
    offset : array_like (2,)
        As given to `register`: (columns, rows) that the sensed image's pixels are
        counted ahead of those of the reference, in pixels.

    Returns
    -------
    Model

    Raises
    ------
    ValueError
        If fewer than two points were accepted (four for "affine"), or all that agree,
        or all but one, lie on one line and the model is affine.

    Notes
    -----
    Up to nearly half of the points may be blunders, wherever they lie and even if they
    agree with each other: the median does not see them (breakdown point 50 per cent).
    If more agree on something else than on the truth, the model is something else.

    sigma0 is 1 where the predicted standard deviations hold. Well above 1, they are too
    small: the images differ in more than a shift and white noise (alias, terrain,
    another resampling), or this model is too simple. The covariance, and what counts as
    a blunder, follow sigma0; residuals within 3.72 predicted standard deviations are
    never taken for blunders. All this supposes errors that are independent from point
    to point. Whole-pixel shifts are not: all may be rounded to the same side. Refine
    them first.

    References
    ----------
    Rousseeuw 1984, "Least median of squares regression"; Pope 1976 for tau.

    Examples
    --------
    >>> from pgm_lab.datasets import landsat
    >>> from pgm_lab.registration import grid, register
    >>> image = landsat().grey[:300, :300]
    >>> found = register(image, image[2:, 1:], grid((290, 290), 40, 20), refine="lsm")
    >>> print(fit(found).parameters.round(3))
    [-1. -2.]
    """
    _validate.instance(found, Registration, "found")
    kind = _validate.choice(kind, "kind", tuple(NAMES))
    offset = _validate.of_shape(offset, (2,), "offset")
    k = np.flatnonzero(found.accepted)
    points, shifts = found.points[k], np.stack([found.dx, found.dy], axis=1)[k]
    fewest = len(NAMES[kind]) // 2  # points that fix the model
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
    start = _least_median(WA, Ws, fewest)
    good = _agree(WA, Ws, start)
    for _ in range(ROUNDS):
        _refuse_one_line(kind, points[good])
        adjusted = _adjust(WA[good], Ws[good], start, NAMES[kind])
        before, good = good, _agree(WA, Ws, adjusted.x)
        if np.array_equal(before, good):
            break
    return _model(kind, found, k, A, shifts, before, adjusted, centre, offset)


def _design(kind: str, points: np.ndarray) -> np.ndarray:
    """Derivatives of (dx, dy) with respect to the parameters (..., 2, u)."""
    f = np.ones((*points.shape[:-1], 1))
    if kind == "affine":
        f = np.concatenate([f, points], axis=-1)  # 1, x, y
    none = np.zeros_like(f)
    return np.stack([np.concatenate([f, none], -1), np.concatenate([none, f], -1)], -2)


def _refuse_one_line(kind: str, points: np.ndarray) -> None:
    along, across = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[:2]
    if kind == "affine" and across <= 1e-9 * along:
        raise ValueError(
            f"the {len(points)} points that agree lie on one line, which leaves an"
            " affine transformation open: take points on both sides of it, or fit a"
            " 'shift'"
        )


def _least_median(A: np.ndarray, shifts: np.ndarray, fewest: int) -> np.ndarray:
    """Parameters through a few points, with the smallest median residual."""
    n, _, u = A.shape
    random = np.random.default_rng(1)
    draws = random.integers(n, size=(DRAWS, fewest))
    some = random.choice(n, min(n, LOOKED_AT), replace=False)
    N, l = A[draws].reshape(-1, u, u), shifts[draws].reshape(-1, u)  # noqa: E741
    fixed = np.linalg.cond(N) < SINGULAR  # not the same point twice, nor on one line
    models = np.linalg.solve(N[fixed], l[fixed, :, None])[..., 0]
    lengths = np.linalg.norm(A[some] @ models.T - shifts[some, :, None], axis=1)
    # Of all residuals `fewest` may be zero because the model goes through them.
    middle = len(some) // 2 + (fewest + 1) // 2 - 1
    return models[np.argmin(np.partition(lengths, middle, axis=0)[middle])]


def _agree(A: np.ndarray, shifts: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Whether a point is no blunder (n,), by the median of all residuals."""
    length = np.linalg.norm(A @ x - shifts, axis=1)  # in predicted standard deviations
    return length <= LIMIT * max(1.0, np.median(length) / CIRCULAR_SD)


def _adjust(
    A: np.ndarray, shifts: np.ndarray, start: np.ndarray, names: tuple[str, ...]
) -> Adjustment:
    """Adjust shifts of weight 1 by least squares."""
    A = A.reshape(-1, len(start))
    return adjust(lambda x: (A @ x, A), start, shifts.ravel(), names=names)


def _model(
    kind: str,
    found: Registration,
    k: np.ndarray,
    A: np.ndarray,
    shifts: np.ndarray,
    good: np.ndarray,
    adjusted: Adjustment,
    centre: np.ndarray,
    offset: np.ndarray,
) -> Model:
    """What the adjustment says, back in pixels and for all points."""
    residuals, numbers, tau = np.full((3, len(found.points), 2), np.nan)
    residuals[k] = A @ adjusted.x - shifts
    used = np.zeros(len(found.points), bool)
    used[k[good]] = True
    weights = np.linalg.inv(found.covariance[used])
    numbers[used], w = residual_statistics(
        A[good], residuals[used], weights, adjusted.cofactor[None]
    )
    if (alone := numbers[used].sum(axis=1) <= UNCONTROLLED).any():
        column, row = found.points[used][alone][0]
        raise ValueError(
            f"the point ({column:g}, {row:g}) alone fixes a part of the affine"
            " transformation: all others lie on one line. Take more points beside it,"
            " or fit a 'shift'"
        )
    sigma0 = float(adjusted.sigma0)
    tau[used] = w / (sigma0 if sigma0 > 0 else np.inf)
    return Model(
        kind,
        adjusted.x,
        adjusted.covariance,
        sigma0,
        int(adjusted.redundancy),
        residuals,
        numbers,
        tau,
        used,
        centre,
        offset,
    )
