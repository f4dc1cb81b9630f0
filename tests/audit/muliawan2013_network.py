"""The network of Muliawan 2013, correctly adjusted, and its normal matrix.

Dense and plain on purpose: the core of chapter A1, the derivatives of the collinearity
equations, seven inner constraints on the points. Unknowns stand in the order of (2.90):
exteriors of nine photos, ten interior parameters, fifty points.
"""

from functools import lru_cache

import numpy as np

from pgm_lab import adjustment, datasets
from pgm_lab.camera import BLOCKS, imaging

PRINTED = datasets.muliawan2013()
PHOTO, POINT = PRINTED.photo, PRINTED.point
PHOTOS, POINTS = 9, 50
SIGMA = 0.001  # mm, of Tables 4.4 to 4.12
EXTERIOR = slice(0, 6 * PHOTOS)
INTERIOR = slice(6 * PHOTOS, 6 * PHOTOS + 10)
OBJECT = slice(6 * PHOTOS + 10, 6 * PHOTOS + 10 + 3 * POINTS)
ANGLES = np.arange(54).reshape(9, 6)[:, 3:].ravel()
STATIONS = np.arange(54).reshape(9, 6)[:, :3].ravel()


def pack(interior, exteriors, points):
    return np.concatenate([np.ravel(exteriors), interior, np.ravel(points)])


def unpack(x):
    """Interior (10,), exteriors (9, 6), points (50, 3)."""
    return x[INTERIOR], x[EXTERIOR].reshape(-1, 6), x[OBJECT].reshape(-1, 3)


START = pack(PRINTED.interior, PRINTED.exteriors, PRINTED.object_points)
PUBLISHED = pack(
    PRINTED.published_interior,
    PRINTED.published_exteriors,
    PRINTED.published_object_points,
)


def misclosure(x):
    """Computed - observed (450, 2) in mm, and its derivatives (900, 214)."""
    interior, exteriors, points = unpack(x)
    v, _, by = imaging.misclosure(
        interior, exteriors[PHOTO], points[POINT], PRINTED.xy, "backward", BLOCKS
    )
    A = np.zeros((len(PHOTO), len(x), 2))
    A[:, INTERIOR] = by["interior"].swapaxes(1, 2)
    rays = np.arange(len(PHOTO))[:, None]
    A[rays, 6 * PHOTO[:, None] + np.arange(6)] = by["exterior"].swapaxes(1, 2)
    columns = OBJECT.start + 3 * POINT[:, None] + np.arange(3)
    A[rays, columns] = by["point"].swapaxes(1, 2)
    return v, A.swapaxes(1, 2).reshape(-1, len(x))


def rms(x):
    """Root mean square of the residuals of one coordinate, in mm."""
    return float(np.sqrt(np.mean(misclosure(x)[0] ** 2)))


def helmert(points):
    """G (3n, 7) of (2.95) as printed: shifts, turns about X, Y, Z, scale."""
    rows = [
        [(1, 0, 0, 0, Z, -Y, X), (0, 1, 0, -Z, 0, X, Y), (0, 0, 1, Y, -X, 0, Z)]
        for X, Y, Z in points
    ]
    return np.array(rows).reshape(-1, 7)


def constraints(points):
    """(214, 7): G at the points and zeros elsewhere, the border of (2.94)."""
    G = np.zeros((len(START), 7))
    G[OBJECT] = helmert(points)
    return G


def cofactor(N, border):
    """Upper left block of the inverse of N with a border, columns scaled to one."""
    s = np.sqrt(np.diag(N))
    B = border / s[:, None]
    B = B / np.linalg.norm(B, axis=0)
    k = B.shape[1]
    whole = np.block([[N / np.outer(s, s), B], [B.T, np.zeros((k, k))]])
    return np.linalg.inv(whole)[: len(s), : len(s)] / np.outer(s, s)


def adjust(start, without=()):
    """Adjust everything as a free network; `without`: rays left out. Result, x."""
    weights = np.full((len(PHOTO), 2), SIGMA**-2)
    weights[list(without)] = 0

    def computed(x):
        v, A = misclosure(x)
        return (v + PRINTED.xy).ravel(), A

    def inner(x):
        return np.zeros(7), constraints(unpack(x)[2]).T

    result = adjustment.adjust(
        computed,
        start,
        PRINTED.xy.ravel(),
        weights=weights.ravel(),
        constraints=inner,
        sigma0_prior=1.0,
    )
    return result, result.x


@lru_cache
def adjusted(without=()):
    """The same from the printed start values, computed once."""
    return adjust(START, without)
