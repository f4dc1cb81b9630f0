"""The network of Muliawan 2013 in a correct adjustment, as the proofs compare with it.

Dense and plain on purpose: the core of chapter A1, derivatives of the collinearity
equations, seven inner constraints on the points. Unknowns stand in the order of the
normal matrix of (2.90): exteriors of nine photos, ten interior parameters, fifty points.
"""

from functools import lru_cache

import numpy as np

from pgm_lab import adjustment, datasets, imaging
from pgm_lab.camera import BLOCKS

PRINTED = datasets.muliawan2013()
PHOTO, POINT = PRINTED.photo, PRINTED.point
PHOTOS, POINTS = 9, 50
EXTERIOR = slice(0, 6 * PHOTOS)
INTERIOR = slice(6 * PHOTOS, 6 * PHOTOS + 10)
OBJECT = slice(6 * PHOTOS + 10, None)


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
    """Computed - observed (450, 2) in mm, and its derivatives (450, 2, 214)."""
    interior, exteriors, points = unpack(x)
    v, _, by = imaging.misclosure(
        interior, exteriors[PHOTO], points[POINT], PRINTED.xy, "backward", BLOCKS
    )
    A = np.zeros((len(PHOTO), 2, len(x)))
    A[:, :, INTERIOR] = by["interior"]
    rows = np.arange(len(PHOTO))[:, None]
    A[rows, :, 6 * PHOTO[:, None] + np.arange(6)] = np.moveaxis(by["exterior"], 1, 2)
    columns = OBJECT.start + 3 * POINT[:, None] + np.arange(3)
    A[rows, :, columns] = np.moveaxis(by["point"], 1, 2)
    return v, A


def rms(x):
    """Root mean square of the residuals of one coordinate, in mm."""
    return np.sqrt(np.mean(misclosure(x)[0] ** 2))


def helmert(points):
    """G (150, 7) of (2.95) as printed: shifts, turns about X, Y, Z, scale."""
    X, Y, Z = np.asarray(points).T
    one, nil = np.ones_like(X), np.zeros_like(X)
    rows = [
        [one, nil, nil, nil, Z, -Y, X],
        [nil, one, nil, -Z, nil, X, Y],
        [nil, nil, one, Y, -X, nil, Z],
    ]
    return np.moveaxis(np.array(rows), -1, 0).reshape(-1, 7)


@lru_cache
def adjusted(estimated=10, kept=None):
    """Adjust the first `estimated` interior parameters, everything else, free network.

    kept: tuple of 450 bool, the rays that take part; all when missing.
    """
    held = np.zeros(len(START), bool)
    held[INTERIOR.start + estimated : INTERIOR.stop] = True
    weights = np.ones(900) / 0.001**2
    if kept is not None:
        weights *= np.repeat(kept, 2)

    def full(x):
        whole = START.copy()
        whole[~held] = x
        return whole

    def computed(x):
        v, A = misclosure(full(x))
        return (v + PRINTED.xy).ravel(), A.reshape(900, -1)[:, ~held]

    def inner(x):
        G = np.zeros((7, len(START)))
        G[:, OBJECT] = helmert(unpack(full(x))[2]).T
        return np.zeros(7), G[:, ~held]

    result = adjustment.adjust(
        computed,
        START[~held],
        PRINTED.xy.ravel(),
        weights=weights,
        constraints=inner,
        sigma0_prior=1.0,
    )
    return result, full(result.x)
