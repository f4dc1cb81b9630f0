"""A thin elastic plate on known heights, which spans what is between them."""

import cv2
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

STIFFNESS = 1.0  # smooths over about a cell of the plate, and hardly more


def lay(z: np.ndarray, known: np.ndarray, side: int) -> np.ndarray:
    """Heights (rows, columns) of a plate on the known ones.

    The plate has cells of `side` by `side` and carries the mean of the known heights in
    each, by their number; it has the least bending energy (thin plate spline).
    """
    if np.sum(known.any(0)) < 2 or np.sum(known.any(1)) < 2 or known.sum() < 10:
        raise ValueError(
            "too little of the surface is ground: all the rest stands out as objects."
            " Give a larger slope, least or most, or a smaller widest"
        )
    n = _sum(known.astype(float), side)
    mean = _sum(np.where(known, z, 0.0), side) / np.maximum(n, 1)
    level = mean[n > 0].mean()
    weight = (n / side**2).ravel()
    normal = sparse.diags(weight) + STIFFNESS * _bending(n.shape)
    right = weight * (mean.ravel() - level)
    plate = spsolve(normal.tocsc(), right, permc_spec="MMD_AT_PLUS_A").reshape(n.shape)
    rows, columns = z.shape
    wide = cv2.resize(
        plate.astype(np.float32), None, fx=side, fy=side, interpolation=cv2.INTER_CUBIC
    )
    return level + wide[:rows, :columns]


def _sum(values: np.ndarray, side: int) -> np.ndarray:
    """Sums over cells of side by side, the last ones filled up with zeros."""
    rows, columns = (-n % side for n in values.shape)
    filled = np.pad(values, ((0, rows), (0, columns)))
    return filled.reshape(
        filled.shape[0] // side, side, filled.shape[1] // side, side
    ).sum((1, 3))


def _bending(shape: tuple[int, int]) -> sparse.csr_matrix:
    """Energy of a plate: squares of its second differences, xx + 2 xy + yy."""
    rows, columns = shape
    xx = sparse.kron(sparse.eye(rows), _second(columns))
    yy = sparse.kron(_second(rows), sparse.eye(columns))
    xy = sparse.kron(_first(rows), _first(columns))
    return xx.T @ xx + 2 * xy.T @ xy + yy.T @ yy


def _second(n: int) -> sparse.spmatrix:
    return sparse.diags([1.0, -2.0, 1.0], [0, 1, 2], shape=(max(n - 2, 0), n))


def _first(n: int) -> sparse.spmatrix:
    return sparse.diags([-1.0, 1.0], [0, 1], shape=(n - 1, n))
