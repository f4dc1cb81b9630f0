"""Arrays of a certain shape: points, images, covariances."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pgm_lab._validate._numbers import finite, numeric, positive


def points(values: ArrayLike, dimension: int, name: str) -> np.ndarray:
    """Return `values` as a float array (..., dimension), finite throughout."""
    array = finite(values, name)
    if array.ndim == 0 or array.shape[-1] != dimension:
        axes = {
            2: "(x, y)",
            3: "(X, Y, Z)",
            6: "(X0, Y0, Z0, omega, phi, kappa)",
            10: "(c, x0, y0, K1, K2, K3, P1, P2, b1, b2)",
        }[dimension]
        raise ValueError(
            f"{name} must have shape (..., {dimension}), one {axes} in the last axis;"
            f" got shape {array.shape}"
        )
    return array


def one_point(values: ArrayLike, dimension: int, name: str) -> np.ndarray:
    """Return one point (dimension,)."""
    array = points(values, dimension, name)
    if array.ndim != 1:
        raise ValueError(
            f"{name} must have shape ({dimension},), one only; got {array.shape}"
        )
    return array


def of_shape(values: ArrayLike, shape: tuple[int | None, ...], name: str) -> np.ndarray:
    """Return finite numbers in this shape; None stands for any length."""
    array = finite(values, name)
    fits = len(shape) == array.ndim and all(
        wanted in (None, n) for wanted, n in zip(shape, array.shape)
    )
    if not fits:
        text = ", ".join("n" if n is None else str(n) for n in shape)
        comma = "," if len(shape) == 1 else ""
        raise ValueError(
            f"{name} must have shape ({text}{comma}); got shape {array.shape}"
        )
    return array


def indices(values: Any, size: int, name: str, length: int | None = None) -> np.ndarray:
    """Return `values` as indices (length,) from 0 to size - 1."""
    array = numeric(values, name)
    whole = not array.size or array.dtype.kind in "iu"
    if array.ndim != 1 or not whole or length not in (None, len(array)):
        raise ValueError(
            f"{name} must be whole numbers in one row"
            + (f" of {length}" if length is not None else "")
            + f"; got shape {array.shape} of {array.dtype}"
        )
    if array.size and (array.min() < 0 or array.max() >= size):
        raise ValueError(
            f"{name} must be indices from 0 to {size - 1}; got {array.min()} to"
            f" {array.max()}. Numbers in a file often count from 1"
        )
    return array.astype(int)


def point_list(values: ArrayLike, name: str, n: int | None = None) -> np.ndarray:
    """Return points (n, 2) of an image."""
    array = points(values, 2, name)
    if array.ndim != 2 or (n is not None and len(array) != n):
        expected = f"({'n' if n is None else n}, 2)"
        raise ValueError(
            f"{name} must have shape {expected}, one (column, row) a point; got shape"
            f" {array.shape}"
        )
    return array


def image_size(size: ArrayLike) -> np.ndarray:
    """Return `size` as (columns, rows), two whole numbers above zero."""
    array = positive(size, "image_size", "px")
    if array.shape != (2,) or np.any(array != np.round(array)):
        raise ValueError(
            "image_size must be (columns, rows), two whole numbers of pixels;"
            f" got {array.tolist()}. From an array, it is image.shape[1::-1]"
        )
    return array


def not_exchanged(size: np.ndarray, pixels: np.ndarray) -> None:
    """Refuse an image size that holds the pixels only with rows for columns."""
    if not pixels.size:
        return
    x, y = pixels[..., 0], pixels[..., 1]
    low, high = np.array([[x.min(), y.min()], [x.max(), y.max()]])

    def fit(size: np.ndarray) -> np.bool_:
        return np.all(low >= -0.5) and np.all(high <= size - 0.5)

    if not fit(size) and fit(size[::-1]):
        columns, rows = size.astype(int)
        raise ValueError(
            f"the pixels lie outside an image of {columns} columns and {rows} rows, but"
            " inside one with the two exchanged: image_size must be (columns, rows),"
            " and image.shape is (rows, columns)"
        )


def image(values: ArrayLike, name: str = "image", least: int = 1) -> np.ndarray:
    """Return one grey image as a float array (rows, columns), finite throughout."""
    array = finite(values, name)
    _rows_and_columns(array, name, least)
    return array


def grey_image(values: ArrayLike, name: str = "image", least: int = 1) -> np.ndarray:
    """Return one grey image (rows, columns) as it is: neither converted nor copied.

    A masked array remains one; NaN and infinity may stand in it. No grey value is
    looked at, so that a large image costs nothing where nobody needs it.
    """
    masked = isinstance(values, np.ma.MaskedArray)
    array = numeric(np.ma.getdata(values) if masked else values, name)
    _rows_and_columns(array, name, least)
    return np.ma.array(array, mask=np.ma.getmask(values)) if masked else array


def _rows_and_columns(array: np.ndarray, name: str, least: int) -> None:
    if array.ndim != 2:
        raise ValueError(
            f"{name} must have shape (rows, columns); got shape {array.shape}."
            " Take one channel of a colour image, or turn it into grey"
        )
    if min(array.shape) < least:
        raise ValueError(
            f"{name} must have at least {least} x {least} pixels; got {array.shape}"
        )


def covariances(values: ArrayLike, name: str, *, singular: bool = True) -> np.ndarray:
    """Return `values` as covariances (..., 2, 2): symmetric, no variance below zero.

    With `singular` False a direction without any error is refused too.
    """
    array = finite(values, name)
    if array.shape[-2:] != (2, 2):
        raise ValueError(f"{name} must have shape (..., 2, 2); got shape {array.shape}")
    xx, xy, yx, yy = np.moveaxis(array.reshape(*array.shape[:-2], 4), -1, 0)
    rounding = 1e-12 * (np.abs(xx) + np.abs(yy))
    refuse(
        np.abs(xy - yx) > rounding,
        name + "{} is not symmetric, as each covariance is",
    )
    least = (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)  # the smaller eigenvalue
    refuse(
        least < -rounding,
        name + "{} is no covariance: it gives a direction a negative variance",
    )
    if not singular:
        refuse(
            least <= rounding,
            name + "{} says that a direction has no error at all: no observation is"
            " exact. Give it a small variance instead",
        )
    return array


def broadcast(**arrays: np.ndarray) -> None:
    """Refuse arrays whose leading axes (all but the last) do not fit together."""
    try:
        np.broadcast_shapes(*(array.shape[:-1] for array in arrays.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
        raise ValueError(
            f"the leading axes do not broadcast: {shapes}. For n points in each of p"
            " photos use exterior (p, 1, 6), points (n, 3), image points (p, n, 2)"
        ) from None


def refuse(bad: np.ndarray, message: str) -> None:
    """Raise `message`, with the indices of what is bad for its {}, if anything is."""
    if np.any(bad):
        first = [tuple(map(int, index)) for index in np.argwhere(bad)[:5]]
        named = ", ".join(str(i[0] if len(i) == 1 else i) for i in first)
        more = f", ... ({np.sum(bad)} in all)" if np.sum(bad) > len(first) else ""
        raise ValueError(message.format(f"[{named}{more}]" if np.ndim(bad) else ""))


def noise_ratio(noise: ArrayLike) -> tuple[float, float]:
    """Return standard deviations of left and right grey values, the larger as one."""
    array = of_shape(noise, (2,), "noise")
    if np.any(array < 0) or not np.any(array > 0):
        raise ValueError(
            "noise must be the standard deviations of the left and of the right grey"
            f" values, not negative and not both zero; got {array.tolist()}"
        )
    left, right = array / array.max()
    return float(left), float(right)


def window_shapes(shape: ArrayLike | None, n: int) -> np.ndarray:
    """Return ((a1, a2), (b1, b2)) of n windows (n, 2, 2); the identity when missing."""
    array = np.eye(2) if shape is None else finite(shape, "shape")
    if array.shape not in ((2, 2), (n, 2, 2)):
        raise ValueError(
            "shape must be ((a1, a2), (b1, b2)), one for all points or one for each,"
            f" (2, 2) or ({n}, 2, 2); got {array.shape}"
        )
    return np.broadcast_to(array, (n, 2, 2))
