"""Many small vectors and matrices at once, stored entry by entry.

All values of one entry, `a[..., 0, 1]`, lie side by side in the memory: that makes
hundreds of thousands of points fast without a loop over them.
"""

import numpy as np
from numpy.typing import ArrayLike


def entries(values: np.ndarray) -> np.ndarray:
    """View (n, ...) of values (..., n): unpacks into their entries."""
    return values.transpose(-1, *range(values.ndim - 1))


def stacked(entries: np.ndarray) -> np.ndarray:
    """View (..., n) of entries (n, ...)."""
    return entries.transpose(*range(1, entries.ndim), 0)


def of_photo(values: np.ndarray, photo: np.ndarray | None) -> np.ndarray:
    """Values (k, ...) of each point's photo from those (photos, ...) of the photos."""
    if photo is None:
        return values
    return entries(stacked(values).take(photo, axis=-1))


def vector(*parts: ArrayLike) -> np.ndarray:
    """Array (..., n) of n entries that broadcast, stored entry by entry."""
    out = np.empty((len(parts), *np.broadcast(*parts).shape), np.result_type(*parts))
    for i, part in enumerate(parts):
        out[i] = part
    return stacked(out)


def matrix(*rows: list[ArrayLike]) -> np.ndarray:
    """Array (..., n, m) of n rows of m entries that broadcast, stored likewise."""
    flat = entries(vector(*(entry for row in rows for entry in row)))
    return stacked(stacked(flat.reshape(len(rows), len(rows[0]), *flat.shape[1:])))


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Matrix product a @ b, written out: faster than @ for many small matrices."""
    rows, inner, columns = range(a.shape[-2]), range(a.shape[-1]), range(b.shape[-1])
    return matrix(
        *(
            [sum(a[..., i, k] * b[..., k, j] for k in inner) for j in columns]
            for i in rows
        )
    )


def side_by_side(*blocks: np.ndarray) -> np.ndarray:
    """Join matrices (..., n, k) column by column; leading axes broadcast."""
    columns = [block[..., j] for block in blocks for j in range(block.shape[-1])]
    return matrix(*([column[..., i] for column in columns] for i in range(2)))
