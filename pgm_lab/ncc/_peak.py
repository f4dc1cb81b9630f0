"""Peaks of correlation maps: the highest, the second, the place between the pixels."""

import numpy as np

from pgm_lab.ncc._map import centred, surfaces


def peaks(maps: np.ndarray) -> tuple[np.ndarray, ...]:
    """Row, column and r of the highest peak of each map, and r of the second."""
    k, rows, columns = maps.shape
    highest = maps.reshape(k, -1).argmax(axis=1)
    row, column = np.divmod(highest, columns)
    r = maps.reshape(k, -1)[np.arange(k), highest]

    padded = np.full((k, rows + 2, columns + 2), -1.0)
    padded[:, 1:-1, 1:-1] = maps
    across = np.maximum(padded[:, :, :-2], padded[:, :, 2:])
    np.maximum(across, padded[:, :, 1:-1], out=across)
    around = np.maximum(across[:, :-2], across[:, 2:])
    np.maximum(around, across[:, 1:-1], out=around)
    others = np.where(maps >= around, maps, -1.0)  # the peaks
    padded[:, 1:-1, 1:-1] = others
    beside = np.arange(3)
    padded[
        np.arange(k)[:, None, None],
        row[:, None, None] + beside[:, None],
        column[:, None, None] + beside,
    ] = -1.0
    return row, column, r, padded.max(axis=(1, 2))


def paraboloid(
    maps: np.ndarray, row: np.ndarray, column: np.ndarray, templates: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Top of the paraboloid through 3 x 3 values, its covariance, and ridges.

    r = r0 + D x - xᵀ K x / 2 with central differences for D and K.
    """
    k, rows, columns = maps.shape
    row, column = np.clip(row, 1, rows - 2), np.clip(column, 1, columns - 2)
    beside = np.arange(-1, 2)
    r = maps[
        np.arange(k)[:, None, None],
        row[:, None, None] + beside[:, None],
        column[:, None, None] + beside,
    ]
    step, D, K, ridge = _top(r)
    ridge |= np.abs(step).max(axis=1) > 1  # the top is not at this peak
    r0 = r[:, 1, 1]
    # The paraboloid may rise above 1, and then would tell of less than no noise
    top = np.minimum(r0 + np.sum(step * D, axis=1) / 2, 1 - (1 - r0) / 10)

    t = centred(templates)
    gx = (t[:, 1:-1, 2:] - t[:, 1:-1, :-2]) / 2
    gy = (t[:, 2:, 1:-1] - t[:, :-2, 1:-1]) / 2
    g = np.stack([gx.reshape(k, -1), gy.reshape(k, -1)], axis=1)
    G = g @ g.swapaxes(1, 2) / g.shape[2] / t.var(axis=(1, 2))[:, None, None]
    inverse = np.linalg.inv(K)
    noise = 2 * (1 - top) / t[0].size
    Q = inverse @ G @ inverse * noise[:, None, None]
    return step, Q, ridge | (np.trace(Q, axis1=1, axis2=2) > 1)


def systematic_errors(
    templates: np.ndarray, wider: np.ndarray, step: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the paraboloid without noise, in pixels: two vectors each.

    The correlation of the template with its own surroundings (`wider` by one pixel on
    each side) ought to have its top in the middle. It does not, because other pixels
    enter and leave the window: its offset is the first error. The second is pixel
    locking: of a wave of w radians per pixel the top is found at
    tan(w s) / (2 tan(w/2)) instead of s, short of s by about s (1 - 4 s^2) w^2 / 12.
    """
    offset, _, K, _ = _top(surfaces(templates, wider))
    t = centred(templates)
    inner = t[:, 1:-1, 1:-1]
    second = (
        t[:, 1:-1, :-2] - 2 * inner + t[:, 1:-1, 2:],
        t[:, :-2, 1:-1] - 2 * inner + t[:, 2:, 1:-1],
    )
    bend = np.stack([np.mean(d * d, axis=(1, 2)) for d in second], axis=1)
    w2 = bend / np.diagonal(K, axis1=1, axis2=2) / t.var(axis=(1, 2))[:, None]
    locking = -w2 / 12 * step * (1 - 4 * step**2)
    # A top further off than a pixel would have been called a ridge
    return np.clip(offset, -1, 1), np.clip(locking, -1, 1)


def _top(r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Top, slope (k, 2), curvature (k, 2, 2) of 3 x 3 values, and where it is none."""
    r0 = r[:, 1, 1]
    D = np.stack([r[:, 1, 2] - r[:, 1, 0], r[:, 2, 1] - r[:, 0, 1]], axis=1) / 2
    Kxx = 2 * r0 - r[:, 1, 2] - r[:, 1, 0]
    Kyy = 2 * r0 - r[:, 2, 1] - r[:, 0, 1]
    Kxy = (r[:, 0, 2] + r[:, 2, 0] - r[:, 0, 0] - r[:, 2, 2]) / 4
    K = np.stack([Kxx, Kxy, Kxy, Kyy], axis=1).reshape(-1, 2, 2)
    ridge = Kxx * Kyy - Kxy**2 <= 1e-6 * (Kxx + Kyy) ** 2
    K[ridge] = np.eye(2)
    return np.linalg.solve(K, D[..., None])[..., 0], D, K, ridge
