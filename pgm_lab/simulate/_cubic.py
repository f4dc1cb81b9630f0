"""Cubic convolution with unrounded places.

As OpenCV 5 does it (a = -0.75); older ones round to a 32nd of a pixel.
"""

import numpy as np

A = -0.75


def cubic(layer: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values at (row, column) of cells; the edge goes on."""
    rows, columns = layer.shape
    flat = np.pad(layer, 2, mode="edge").ravel()
    row, column = (
        np.clip(x, -0.999, n - 0.001) for x, n in ((row, rows), (column, columns))
    )
    i, j = (np.floor(x).astype(np.intp) for x in (row, column))
    first = (i + 1) * (columns + 4) + j + 1
    across = weights(column - j)
    out = np.zeros(row.shape, np.float32)
    for k, down in enumerate(weights(row - i)):
        at = first + k * (columns + 4)
        out += down * sum(w * flat[at + m] for m, w in enumerate(across))
    return out


def enlarged(coarse: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values (rows, columns) on the mesh of rows (rows,) and columns (columns,)."""
    down, across = (matrix(x, n) for x, n in zip((row, column), coarse.shape))
    return (down @ coarse @ across.T).astype(np.float32)


def matrix(x: np.ndarray, n: int) -> np.ndarray:
    """Weights (places, n) of n values at places inside, from 1 to n - 2."""
    at = np.floor(x).astype(np.intp)
    out = np.zeros((len(x), n))
    for k, w in enumerate(weights(x - at)):
        out[np.arange(len(x)), at + k - 1] = w
    return out


def weights(t: np.ndarray) -> list[np.ndarray]:
    """Weights of the four cells around a place, a part t (0 to 1) past the second."""

    def near(s: np.ndarray) -> np.ndarray:
        return ((A + 2) * s - (A + 3)) * s**2 + 1

    def far(s: np.ndarray) -> np.ndarray:
        return A * (((s - 5) * s + 8) * s - 4)

    return [far(1 + t), near(t), near(1 - t), far(2 - t)]
