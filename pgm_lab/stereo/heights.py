"""Space intersection of all matched cells at once, with standard deviations."""

from dataclasses import dataclass, field

import numpy as np

from pgm_lab.stereo.dense import DenseMatch
from pgm_lab.stereo.normal import NormalPair


@dataclass(frozen=True, eq=False)
class Points:
    """Object points of a dense match.

    Attributes
    ----------
    xyz : ndarray (n, 3)
    sd : ndarray (n, 3)
        Standard deviations of X, Y, Z.
    r : ndarray (n,)
    cells : ndarray (n, 2) of int
        (column, row) in the left normal image.
    """

    xyz: np.ndarray = field(repr=False)
    sd: np.ndarray = field(repr=False)
    r: np.ndarray = field(repr=False)
    cells: np.ndarray = field(repr=False)


def intersect(pair: NormalPair, match: DenseMatch, *, step: int = 1) -> Points:
    """Object points of all matched cells (of every `step`-th row and column)."""
    good = np.zeros(match.status.shape, bool)
    good[::step, ::step] = match.status[::step, ::step] == 0
    rows, columns = np.nonzero(good)
    d, sd = match.disparity[good].astype(float), match.sd[good].astype(float)
    xyz = pair.object_points(columns, rows, d)
    # sigma_Z = H^2 / (B c) sigma_p, along the left ray (x, y, -c)
    along = (xyz - pair.stations[0]) / pair.parallax(d)[:, None]
    sigma = np.abs(along) * (pair.pixel_size * sd)[:, None]
    return Points(xyz, sigma, match.r[good], np.stack([columns, rows], -1))
