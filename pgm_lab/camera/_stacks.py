"""Many small vectors and matrices at once, stored entry by entry.

All values of one entry, `a[..., 0, 1]`, lie side by side in the memory: that makes
hundreds of thousands of points fast without a loop over them.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike


def empty(lead: Sequence[int], shape: Sequence[int], *parts: ArrayLike) -> np.ndarray:
    """Array (*lead, *shape) that can hold the numbers of the parts, without values."""
    out = np.empty((*shape, *lead), np.result_type(*parts))
    return out.transpose(*range(len(shape), out.ndim), *range(len(shape)))


def entries(values: np.ndarray) -> np.ndarray:
    """View (n, ...) of values (..., n): unpacks into their entries."""
    return values.transpose(-1, *range(values.ndim - 1))


def of_photo(values: np.ndarray, photo: np.ndarray | None) -> np.ndarray:
    """Values (k, ...) of each point's photo from those (photos, ...) of the photos."""
    if photo is None:
        return values
    return values.T.take(photo, axis=-1).T


def vector(*parts: ArrayLike) -> np.ndarray:
    """Array (..., n) of n entries that broadcast."""
    out = empty(np.broadcast(*parts).shape, (len(parts),), *parts)
    for i, part in enumerate(parts):
        out[..., i] = part
    return out


def matrix(*rows: Sequence[ArrayLike]) -> np.ndarray:
    """Array (..., n, k) of n rows of k entries that broadcast."""
    parts = [part for row in rows for part in row]
    lead = np.broadcast(*parts).shape
    out = np.empty((len(parts), *lead), np.result_type(*parts))
    for i, part in enumerate(parts):
        out[i] = part
    out = out.reshape(len(rows), len(rows[0]), *lead)
    return out.transpose(*range(2, out.ndim), 0, 1)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Matrix product a @ b: faster than @ for many small matrices."""
    lead = np.broadcast(a[..., 0, 0], b[..., 0, 0]).shape
    out = empty(lead, (a.shape[-2], b.shape[-1]), a, b)
    return np.einsum("...ij,...jk->...ik", a, b, out=out)


def side_by_side(*blocks: np.ndarray) -> np.ndarray:
    """Join matrices (..., n, k) of n rows column by column; leading axes broadcast."""
    *lead, n = np.broadcast(*(block[..., 0] for block in blocks)).shape
    ends = np.cumsum([block.shape[-1] for block in blocks])
    out = empty(lead, (n, ends[-1]), *blocks)
    for block, end in zip(blocks, ends):
        out[..., end - block.shape[-1] : end] = block
    return out
