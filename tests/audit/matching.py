"""An image whose grey values and gradients are known at every point, and the least
squares matching of Bani 2010 written out in it, for the proofs.

Nothing is resampled here: what the proofs show is due to the formulas alone."""

import numpy as np

from pgm_lab import datasets

# What the log of IV.1.3 prints, character by character
LOG = {row["quantity"]: row["value"] for row in datasets.rows("bani2010_lsm_log.csv")}


def printed(*names):
    return np.array([float(LOG[name]) for name in names])


START = printed("start X", "start Y")
PRINTED_A, PRINTED_B = printed("a0", "a1", "a2"), printed("b0", "b1", "b2")
PRINTED = np.concatenate([PRINTED_A, PRINTED_B])
PRINTED_POINT = printed("corrected X", "corrected Y")
PRINTED_S0 = float(LOG["So"])

_rng = np.random.default_rng(2010)
_ANGLE, _RADIUS = _rng.uniform(0, 2 * np.pi, 80), 0.2 * np.sqrt(_rng.uniform(0, 1, 80))
FREQUENCIES = 2 * np.pi * _RADIUS * np.array([np.cos(_ANGLE), np.sin(_ANGLE)])
PHASES = _rng.uniform(0, 2 * np.pi, 80)


def grey(x, y, contrast=40.0):
    """Grey values of 80 plane waves with at least five pixels a wave; complex x, y go
    as well."""
    waves = np.cos(np.multiply.outer(x, FREQUENCIES[0]) + _y(y) + PHASES)
    return 120 + contrast * np.sqrt(2 / 80) * waves.sum(axis=-1)


def gradient(x, y, contrast=40.0):
    """Derivatives of `grey` by x and by y."""
    waves = -np.sin(np.multiply.outer(x, FREQUENCIES[0]) + _y(y) + PHASES)
    return contrast * np.sqrt(2 / 80) * np.moveaxis(waves @ FREQUENCIES.T, -1, 0)


def _y(y):
    return np.multiply.outer(y, FREQUENCIES[1])


def window(half=8, centre=(0.0, 0.0)):
    """x and y of the pixels of a square window, row by row; 17 x 17 by default."""
    steps = np.arange(-half, half + 1.0)
    y, x = np.meshgrid(steps, steps, indexing="ij")
    return x.ravel() + centre[0], y.ravel() + centre[1]


def affine(p, x, y):
    """(2.8) and (2.9): x', y' for the parameters a0, a1, a2, b0, b1, b2."""
    return p[0] + p[1] * x + p[2] * y, p[3] + p[4] * x + p[5] * y


def design(gx, gy, x, y):
    """The six columns of Table 2.2 and of the listing."""
    return np.stack([gx, gx * x, gx * y, gy, gy * x, gy * y], axis=-1)


def computed(p, x, y, contrast=40.0):
    """f of (2.10) for a0, a1, a2, b0, b1, b2, h0, h1, the right image being `grey`."""
    return p[6] + p[7] * grey(*affine(p, x, y), contrast)


def derivatives(p, x, y, contrast=40.0):
    """The eight derivatives printed below (2.11), in the order of (2.18)."""
    at = affine(p, x, y)
    gx, gy = p[7] * gradient(*at, contrast)
    g = grey(*at, contrast)
    return np.column_stack([design(gx, gy, x, y), np.ones_like(g), g])


def adjusted(left, p, x, y, steps=12, contrast=40.0):
    """Repeat (2.14a) with P = I; return the parameters, V and L of the last step."""
    p = np.array(p, dtype=float)
    for _ in range(steps):
        A = derivatives(p, x, y, contrast)
        L = left - p[6] - p[7] * A[:, 7]  # (2.10), by the grey values in A
        X = np.linalg.lstsq(A, L)[0]
        V = A @ X - L
        p += X
    return p, V, L
