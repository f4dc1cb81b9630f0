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


def vector(*parts: np.ndarray) -> np.ndarray:
    """Array (..., n) of n entries of the same shape."""
    return last(np.array(parts))


def matrix(*rows: Sequence[np.ndarray]) -> np.ndarray:
    """Array (..., n, k) of n rows of k entries of the same shape."""
    return last(np.array(rows), 2)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Matrix product a @ b: faster than @ for many small matrices."""
    lead = np.broadcast(a[..., 0, 0], b[..., 0, 0]).shape
    out = empty(lead, (a.shape[-2], b.shape[-1]), a, b)
    return np.einsum("...ij,...jk->...ik", a, b, out=out)


def first(values: np.ndarray, leading: int, axes: int = 1) -> np.ndarray:
    """View of values (..., n) or (..., n, k) with the last axes first.

    The others become as many as `leading`, so that they broadcast as they did.
    """
    missing = leading + axes - values.ndim
    values = values[(None,) * missing] if missing else values
    return values.transpose(*range(leading, values.ndim), *range(leading))


def last(values: np.ndarray, axes: int = 1) -> np.ndarray:
    """View of values (n, ...) or (n, k, ...) with the first axes last."""
    return values.transpose(*range(axes, values.ndim), *range(axes))
