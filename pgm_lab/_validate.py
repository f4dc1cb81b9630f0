"""Checks of what a caller hands over; each names the argument and what was expected."""

import numpy as np
from numpy.typing import ArrayLike


def finite(values: ArrayLike, name: str) -> np.ndarray:
    """Return `values` as a float array without NaN or infinity."""
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be numbers; got {values!r}") from None
    if not np.all(np.isfinite(array)):
        bad = np.argwhere(~np.isfinite(array))
        where = f"{name}{[int(i) for i in bad[0]]}" if array.ndim else name
        raise ValueError(
            f"{where} is not a finite number; {len(bad)} value(s) are NaN or infinite."
            " Leave such values out before the call"
        )
    return array


def points(values: ArrayLike, dimension: int, name: str) -> np.ndarray:
    """Return `values` as a float array (..., dimension), finite throughout."""
    array = finite(values, name)
    if array.ndim == 0 or array.shape[-1] != dimension:
        axes = {2: "(x, y)", 3: "(X, Y, Z)"}[dimension]
        raise ValueError(
            f"{name} must have shape (..., {dimension}), one {axes} in the last axis;"
            f" got shape {array.shape}"
        )
    return array


def positive(values: ArrayLike, name: str, unit: str) -> np.ndarray:
    """Return `values` as a float array of numbers above zero."""
    array = finite(values, name)
    if np.any(array <= 0):
        raise ValueError(f"{name} must be positive ({unit}); got {values}")
    return array


def pair(values: ArrayLike, name: str, unit: str) -> np.ndarray:
    """Return one positive number, or a positive (x, y), as an array (2,)."""
    array = positive(values, name, unit)
    if array.shape not in ((), (1,), (2,)):
        raise ValueError(
            f"{name} must be one number or (x, y) in {unit}; got shape {array.shape}"
        )
    return np.broadcast_to(array, (2,))


def image_size(size: ArrayLike) -> np.ndarray:
    """Return `size` as (columns, rows), two whole numbers above zero."""
    array = positive(size, "image_size", "px")
    if array.shape != (2,) or np.any(array != np.round(array)):
        raise ValueError(
            "image_size must be (columns, rows), two whole numbers of pixels;"
            f" got {size}. From an array, it is image.shape[1::-1]"
        )
    return array


def not_exchanged(size: np.ndarray, pixels: np.ndarray) -> None:
    """Refuse an image size that holds the pixels only with rows for columns."""
    if not pixels.size:
        return
    x, y = pixels[..., 0], pixels[..., 1]
    low, high = np.array([[x.min(), y.min()], [x.max(), y.max()]])

    def fit(size):
        return np.all(low >= -0.5) and np.all(high <= size - 0.5)

    if not fit(size) and fit(size[::-1]):
        columns, rows = size.astype(int)
        raise ValueError(
            f"the pixels lie outside an image of {columns} columns and {rows} rows, but"
            " inside one with the two exchanged: image_size must be (columns, rows),"
            " and image.shape is (rows, columns)"
        )


def number(value: ArrayLike, name: str) -> float:
    """Return `value` as one finite float."""
    array = finite(value, name)
    if array.ndim:
        raise ValueError(f"{name} must be one number; got shape {array.shape}")
    return float(array)
