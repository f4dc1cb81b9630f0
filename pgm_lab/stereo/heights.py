"""Space intersection of all matched cells at once, with standard deviations."""

from dataclasses import dataclass, field

import numpy as np

from pgm_lab import _validate
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
    covariance : ndarray (n, 3, 3), optional
        Of X, Y, Z, if it was asked for.
    """

    xyz: np.ndarray = field(repr=False)
    sd: np.ndarray = field(repr=False)
    r: np.ndarray = field(repr=False)
    cells: np.ndarray = field(repr=False)
    covariance: np.ndarray | None = field(default=None, repr=False)


def intersect(
    pair: NormalPair,
    match: DenseMatch,
    *,
    step: int = 1,
    pointing: float = 0.0,
    covariance: bool = False,
) -> Points:
    """Object points of all matched cells, or of every `step`-th row and column.

    In the normal case both rays of a cell lie in one plane and meet, so the point
    stands at (x, y, -c) B / p in the normal frame, B the base and p the parallax. Its
    standard deviation is that of the disparity, carried over: with photos that look
    straight down from the height H,

        sigma_Z = H^2 / (B c) sigma_p = (H / B) GSD sigma_px

    since a parallax of sigma_px pixels is sigma_px GSD c / H. The orientation counts as
    free of errors.

    Parameters
    ----------
    pair : NormalPair
    match : DenseMatch
        Of this pair.
    step : int
        Take every so manyth row and column.
    pointing : float
        Standard deviation, in px, of column and row of the left pixel. None in
        matching, which asks for the point of a given left pixel; otherwise how far the
        detail that was meant may lie from it.
    covariance : bool
        Whether to give the covariances, too: the errors of X, Y and Z hang together,
        since they run along the ray.

    Returns
    -------
    Points

    Raises
    ------
    ValueError
        If an argument is not what is described here, or the match is of another pair.

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
    pointing = _validate.not_negative(pointing, "pointing", "in pixels")
    covariance = _validate.flag(covariance, "covariance")
    if match.status.shape != pair.left.shape:
        raise ValueError(
            f"the match has {match.status.shape} cells (rows, columns) and the left"
            f" image {pair.left.shape} pixels: they are not of the same pair"
        )
    rows, columns = step * np.stack(np.nonzero(match.status[::step, ::step] == 0))
    d, sd = (a[rows, columns].astype(float) for a in (match.disparity, match.sd))
    xyz = pair.object_points(columns, rows, d)
    met = ~np.isnan(xyz[:, 0])  # others meet behind the photos
    if not met.all():
        rows, columns, d, sd, xyz = (a[met] for a in (rows, columns, d, sd, xyz))
    # How the point moves with a pixel of disparity, column and row, each by its sd
    p = pair.parallax(d)
    along = -(xyz - pair.stations[0]) * (pair.pixel_size * sd / p)[:, None]
    aside = (pair.base * pair.pixel_size * pointing / p)[:, None]
    moves = (along, aside * pair.rotation[0], aside * -pair.rotation[1])
    return Points(
        xyz,
        np.sqrt(sum(move**2 for move in moves)),
        match.r[rows, columns],
        np.stack([columns, rows], -1),
        sum(m[:, :, None] * m[:, None] for m in moves) if covariance else None,
    )
