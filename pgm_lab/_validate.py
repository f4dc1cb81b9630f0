"""Checks of what a caller hands over; each names the argument and what was expected."""

import math

import numpy as np
from numpy.typing import ArrayLike


def finite(values: ArrayLike, name: str) -> np.ndarray:
    """Return `values` as a float array without NaN or infinity."""
    if np.iscomplexobj(values):
        raise ValueError(f"{name} must be real numbers; got complex ones")
    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values. Leave them out before the call")
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


def positive(values: ArrayLike, name: str, unit: str) -> np.ndarray:
    """Return `values` as a float array of numbers above zero."""
    array = finite(values, name)
    if np.any(array <= 0):
        raise ValueError(f"{name} must be positive ({unit}); got {array.tolist()}")
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


def number(value: ArrayLike, name: str) -> float:
    """Return `value` as one finite float."""
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    array = finite(value, name)
    if array.ndim:
        raise ValueError(f"{name} must be one number; got shape {array.shape}")
    return float(array)


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


def choice(value: str, name: str, allowed: tuple[str, ...]) -> str:
    """Return `value` if it is one of the allowed words."""
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(repr(word) for word in allowed)
        raise ValueError(f"{name} must be one of {words}; got {value!r}")
    return value


def standard_deviation(sigma: ArrayLike | None, name: str = "sigma") -> float | None:
    """Return a standard deviation as one number above zero, or None if not known."""
    if sigma is None:
        return None
    if not (value := number(sigma, name)) > 0:
        raise ValueError(
            f"{name} must be positive, or None if not known; got {sigma!s}"
        )
    return value


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


def window(size: int, name: str, smallest: int = 3) -> int:
    """Return the size of a window: an odd number of pixels, so that it has a middle."""
    value = number(size, name)
    if value != round(value) or value < smallest or value % 2 == 0:
        raise ValueError(
            f"{name} must be an odd number of pixels, at least {smallest}, so that one"
            f" is its middle; got {size}"
        )
    return int(value)


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


def image(values: ArrayLike, name: str = "image", least: int = 1) -> np.ndarray:
    """Return one grey image as a float array (rows, columns), finite throughout."""
    array = finite(values, name)
    if array.ndim != 2:
        raise ValueError(
            f"{name} must have shape (rows, columns); got shape {array.shape}."
            " Take one channel of a colour image, or turn it into grey"
        )
    if min(array.shape) < least:
        raise ValueError(
            f"{name} must have at least {least} x {least} pixels; got {array.shape}"
        )
    return array


def whole(value: ArrayLike, name: str, least: int) -> int:
    """Return `value` as one whole number, not below `least`."""
    as_number = number(value, name)
    if as_number != round(as_number) or as_number < least:
        raise ValueError(
            f"{name} must be a whole number, at least {least}; got {as_number:g}"
        )
    return int(as_number)


def probability(value: ArrayLike, name: str) -> float:
    """Return `value` as one number between 0 and 1, neither of them."""
    if 0 < (one := number(value, name)) < 1:
        return one
    raise ValueError(f"{name} must lie between 0 and 1, as a probability; got {one:g}")
