"""Heights of matched cells by space intersection, and how good they are."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab import _validate
from pgm_lab._robust import nmad
from pgm_lab.stereo.dense import DenseMatch
from pgm_lab.stereo.normal import NormalPair


@dataclass(frozen=True, eq=False)
class Points:
    """Object points of a dense match.

    Attributes
    ----------
    xyz : ndarray (n, 3)
        In the unit of the stations.
    sd : ndarray (n, 3)
        Standard deviations of X, Y, Z.
    r : ndarray (n,)
        Correlation coefficient of the match.
    cells : ndarray (n, 2) of int
        (column, row) in the left normal image.
    crs : str, optional
        Coordinate reference system, where the photos name one (`Photo.crs`).
    """

    xyz: np.ndarray = field(repr=False)
    sd: np.ndarray = field(repr=False)
    r: np.ndarray = field(repr=False)
    cells: np.ndarray = field(repr=False)
    crs: str | None = field(default=None, repr=False)


def intersect(pair: NormalPair, match: DenseMatch, *, step: int = 1) -> Points:
    """Object points of all matched cells, or of every `step`-th row and column.

    In the normal case both rays of a cell lie in one plane and meet, so the point
    lies at (x, y, -c) B / p in the normal frame, B the base and p the parallax. Its
    standard deviation is propagated from that of the disparity: for photos that look
    straight down from the height H,

        sigma_Z = H^2 / (B c) sigma_p = (H / B) GSD sigma_px

    since a parallax of sigma_px pixels is sigma_px GSD c / H. The orientation is
    treated as free of errors. Errors of X, Y and Z are those along one ray.

    Parameters
    ----------
    pair : NormalPair
    match : DenseMatch
        Of this pair.
    step : int
        Use every n-th row and column.

    Returns
    -------
    Points

    Raises
    ------
    ValueError
        If an argument is not as described here, or the match is of another pair.

    References
    ----------
    Harintaka 2020: (H 2) to (H 5), whose scale factors of both rays are B / p here.
    Kraus 2007, "Photogrammetry", 2nd ed., 2.1.4 and 4.1 (accuracy in the normal case).

    Examples
    --------
    From 1000 m, with a base of 400 m and a GSD of 0.2 m, half a pixel is 0.25 m:

    >>> from pgm_lab.stereo import DenseMatch, NormalPair
    >>> grey, origin = np.zeros((1, 1)), np.array([(5.0, 0.0), (-5.0, 0.0)])
    >>> stations = np.array([(0.0, 0.0, 1000.0), (400.0, 0.0, 1000.0)])
    >>> pair = NormalPair(grey, grey, np.eye(3), stations, 25.0, 0.005, origin)
    >>> match = DenseMatch(grey, grey + 0.9, grey + 0.5, np.zeros((1, 1), np.uint8))
    >>> points = intersect(pair, match)
    >>> points.xyz, points.sd[0, 2].round(3)
    (array([[200.,   0.,   0.]]), np.float64(0.25))
    """
    _validate.instance(pair, NormalPair, "pair")
    _validate.instance(match, DenseMatch, "match")
    step = _validate.whole(step, "step", 1)
    if match.status.shape != pair.left.shape:
        raise ValueError(
            f"the match has {match.status.shape} cells (rows, columns) and the left"
            f" image {pair.left.shape} pixels: they are not of the same pair"
        )
    rows, columns = step * np.stack(np.nonzero(match.status[::step, ::step] == 0))
    d, sd = (a[rows, columns].astype(float) for a in (match.disparity, match.sd))
    xyz = pair.object_points(columns, rows, d)
    met = np.isfinite(xyz.sum(axis=1) + sd)  # the others meet behind the photos
    if not met.all():
        rows, columns, d, sd, xyz = (a[met] for a in (rows, columns, d, sd, xyz))
    # How the point moves along the ray with the sd of the disparity
    share = pair.pixel_size * sd / pair.parallax(d)
    moves = (pair.stations[0] - xyz) * share[:, None]
    return Points(
        xyz,
        np.abs(moves),
        match.r[rows, columns],
        np.stack([columns, rows], -1),
        pair.crs,
    )


# --- Compared with the truth ---


@dataclass(frozen=True)
class Quality:
    """Errors of heights, all but the counts in the unit of the heights.

    Attributes
    ----------
    n : int
        Heights that were compared.
    mean, rmse : float
        Mean error (height minus truth) and root mean square error.
    nmad : float
        1.4826 times the median distance from the median: the sd for normal errors,
        robust against blunders.
    completeness : float
        Share of the requested cells that have a height.
    le95 : float
        Absolute error that 95 % of the errors do not exceed.
    """

    n: int
    mean: float
    rmse: float
    nmad: float
    completeness: float
    le95: float


def quality(
    heights: ArrayLike, truth: ArrayLike, where: ArrayLike | None = None
) -> Quality:
    """Compare heights with the truth.

    Parameters
    ----------
    heights : array_like (...)
        NaN where there are none.
    truth : array_like (...)
        Of the same shape; NaN where it is unknown and nothing is compared.
    where : array_like (...) of bool, optional
        Which to compare; default: all.

    Returns
    -------
    Quality
        Its errors are NaN if no height is left to compare.

    Raises
    ------
    ValueError
        If shapes do not fit, or a height is infinite.

    References
    ----------
    Höhle and Höhle 2009, Accuracy assessment of digital elevation models by means of
    robust statistical methods, ISPRS J. of Photogrammetry and Remote Sensing 64(4).

    Examples
    --------
    >>> quality([1.1, 1.9, 3.1, np.nan], [1.0, 2.0, 3.0, 4.0]).completeness
    0.75
    """
    heights = _validate.real(heights, "heights")
    truth = _validate.real(truth, "truth")
    if heights.shape != truth.shape:
        raise ValueError(
            f"heights and truth must have one shape; got {heights.shape} and"
            f" {truth.shape}"
        )
    for name, values in (("heights", heights), ("truth", truth)):
        _validate.refuse(np.isinf(values), name + "{} are infinite")
    asked = np.isfinite(truth)
    if where is not None:
        mask = np.asarray(where)
        if mask.dtype != bool or mask.shape != truth.shape:
            raise ValueError(
                f"where must be True or False in shape {truth.shape}; got {mask.dtype}"
                f" in shape {mask.shape}"
            )
        asked = asked & mask
    error = (heights - truth)[asked]
    known = error[np.isfinite(error)]
    if not known.size:
        return Quality(0, np.nan, np.nan, np.nan, 0.0 if error.size else np.nan, np.nan)
    return Quality(
        n=known.size,
        mean=float(known.mean()),
        rmse=float(np.sqrt(np.mean(known**2))),
        nmad=float(nmad(known)),
        completeness=known.size / error.size,
        le95=float(np.quantile(np.abs(known), 0.95)),
    )
