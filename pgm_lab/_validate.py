"""Argument validation: each message names the argument and what was expected.

Functions return the checked value, arrays as float arrays. They serve where data come
in: public functions, readers of files, commands. Private functions don't check again.
"""

import math
import numbers
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

MAX_NUMBERS = 10**8  # in an array that a function makes: 800 MB
AXES = {
    2: "(x, y)",
    3: "(X, Y, Z)",
    6: "(X0, Y0, Z0, omega, phi, kappa)",
    10: "(c, x0, y0, K1, K2, K3, P1, P2, b1, b2)",
}
Kind = TypeVar("Kind")


# --- Numbers, one or many ---


def finite(values: Any, name: str) -> np.ndarray:
    """Return `values` as a float array without NaN or infinity."""
    array = real(values, name)
    if not np.all(np.isfinite(array)):
        bad = np.argwhere(~np.isfinite(array))
        where = f"{name}{bad[0].tolist()}" if array.ndim else name
        raise ValueError(
            f"{where} is not a finite number; {len(bad)} value(s) are NaN or infinite."
            " Leave such values out before the call"
        )
    return array


def real(values: Any, name: str) -> np.ndarray:
    """Return `values` as a float array, in which NaN and infinity may stand."""
    if type(values) is np.ndarray and values.dtype == float:
        return values
    return np.asarray(numeric(values, name), dtype=float)


def numeric(values: Any, name: str) -> np.ndarray:
    """Return `values` as an array of real numbers of their own type."""
    if np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values. Leave them out before the call")
    try:
        array = np.asarray(values)
    except ValueError:  # ragged
        array = np.asarray(None)
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name} must be numbers; got {shown(values)}")
    return array


def shown(value: object) -> str:
    """Return a value in a few words, for a message."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"a {type(value).__name__}"


def number(value: Any, name: str) -> float:
    """Return `value` as one finite float."""
    if isinstance(value, float) and math.isfinite(value):
        return float(value)
    if isinstance(value, bool | np.bool_):
        raise ValueError(f"{name} must be a number; got {value}")
    array = finite(value, name)
    if array.ndim:
        raise ValueError(f"{name} must be one number; got shape {array.shape}")
    return float(array)


def positive(values: ArrayLike, name: str, unit: str) -> np.ndarray:
    """Return `values` as a float array of numbers above zero."""
    array = finite(values, name)
    if np.any(array <= 0):
        raise ValueError(f"{name} must be positive ({unit}); got {array.tolist()}")
    return array


def positive_number(value: ArrayLike, name: str, unit: str) -> float:
    """Return `value` as one number above zero."""
    if (one := number(value, name)) > 0:
        return one
    raise ValueError(f"{name} must be positive ({unit}); got {one:g}")


def not_negative(value: ArrayLike, name: str, unit: str) -> float:
    """Return `value` as one number, zero or above."""
    if (one := number(value, name)) >= 0:
        return one
    raise ValueError(f"{name} must not be negative ({unit}); got {one:g}")


def probability(value: ArrayLike, name: str) -> float:
    """Return `value` as one number between 0 and 1, both excluded."""
    if 0 < (one := number(value, name)) < 1:
        return one
    raise ValueError(f"{name} must lie between 0 and 1, as a probability; got {one:g}")


def between(value: ArrayLike, name: str, least: float, most: float) -> float:
    """Return `value` as one number from `least` to `most`."""
    if least <= (one := number(value, name)) <= most:
        return one
    raise ValueError(f"{name} must lie between {least} and {most}; got {one:g}")


def standard_deviation(sigma: ArrayLike | None, name: str = "sigma") -> float | None:
    """Return a standard deviation as one number above zero, or None if not known."""
    if sigma is None or (value := number(sigma, name)) > 0:
        return None if sigma is None else value
    raise ValueError(f"{name} must be positive, or None if not known; got {sigma!s}")


def whole(value: Any, name: str, least: int, most: int = MAX_NUMBERS) -> int:
    """Return `value` as one whole number from `least` to `most`."""
    as_number = number(value, name)
    if as_number != round(as_number) or as_number < least:
        raise ValueError(
            f"{name} must be a whole number, at least {least}; got {as_number:g}"
        )
    if as_number > most:
        raise ValueError(f"{name} must be at most {most}; got {as_number:.16g}")
    return int(value) if isinstance(value, numbers.Integral) else int(as_number)


def window(size: int, name: str, smallest: int = 3) -> int:
    """Return the size of a window: an odd number of pixels, which has a central one."""
    value = number(size, name)
    if value != round(value) or value < smallest or value % 2 == 0:
        raise ValueError(
            f"{name} must be an odd number of pixels, at least {smallest}, so that one"
            f" is its middle; got {value:g}"
        )
    return whole(size, name, smallest, 10**4 + 1)


def smoothing(smooth: float) -> float:
    """Return the standard deviation of a Gaussian in pixels, or 0 for none."""
    value = number(smooth, "smooth")
    if value != 0 and not 0.3 <= value <= 3:
        raise ValueError(f"smooth must be 0, or from 0.3 to 3 px; got {value:g}")
    return value


def size(name: str, *counts: int) -> None:
    """Reject an array of too many numbers before it is allocated."""
    if math.prod(counts) > MAX_NUMBERS:
        raise ValueError(
            f"{name} asks for {' x '.join(map(str, counts))} numbers at once; the limit"
            f" is {MAX_NUMBERS}: make it smaller, or in parts"
        )


def pair(values: ArrayLike, name: str, unit: str) -> np.ndarray:
    """Return one positive number, or a positive (x, y), as an array (2,)."""
    array = positive(values, name, unit)
    if array.shape not in ((), (1,), (2,)) or np.asarray(values).dtype == bool:
        raise ValueError(
            f"{name} must be one number or (x, y) in {unit}; got {shown(values)}"
        )
    return np.broadcast_to(array, (2,))


# --- Arrays of a certain shape ---


def of_shape(values: ArrayLike, shape: tuple[int | None, ...], name: str) -> np.ndarray:
    """Return finite numbers in this shape; None stands for any length."""
    array = finite(values, name)
    if len(shape) != array.ndim or any(
        wanted not in (None, n) for wanted, n in zip(shape, array.shape)
    ):
        text = ", ".join("n" if n is None else str(n) for n in shape)
        comma = "," if len(shape) == 1 else ""
        raise ValueError(
            f"{name} must have shape ({text}{comma}); got shape {array.shape}"
        )
    return array


def points(values: ArrayLike, dimension: int, name: str) -> np.ndarray:
    """Return `values` as a float array (..., dimension), finite throughout."""
    array = finite(values, name)
    if array.ndim == 0 or array.shape[-1] != dimension:
        raise ValueError(
            f"{name} must have shape (..., {dimension}), one {AXES[dimension]} in the"
            f" last axis; got shape {array.shape}"
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


def point_list(values: ArrayLike, name: str, n: int | None = None) -> np.ndarray:
    """Return points (n, 2) of an image."""
    array = points(values, 2, name)
    if array.ndim != 2 or n not in (None, len(array)):
        raise ValueError(
            f"{name} must have shape ({'n' if n is None else n}, 2), one (column, row)"
            f" a point; got shape {array.shape}"
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


def image_size(size: ArrayLike) -> np.ndarray:
    """Return `size` as (columns, rows), two whole numbers above zero."""
    array = positive(size, "image_size", "px")
    if array.shape != (2,) or np.any(array != np.round(array)):
        raise ValueError(
            "image_size must be (columns, rows), two whole numbers of pixels;"
            f" got {array.tolist()}. From an array, it is image.shape[1::-1]"
        )
    return array


def image(values: ArrayLike, name: str = "image", least: int = 1) -> np.ndarray:
    """Return one grey image as a float array (rows, columns), finite throughout."""
    return grey_image(finite(values, name), name, least)


def grey_image(values: ArrayLike, name: str = "image", least: int = 1) -> np.ndarray:
    """Return one grey image as it is: a mask, NaN and infinity may stand in it."""
    masked = isinstance(values, np.ma.MaskedArray)
    array = numeric(np.ma.getdata(values) if masked else values, name)
    if array.ndim != 2:
        raise ValueError(
            f"{name} must have shape (rows, columns); got shape {array.shape}."
            " Take one channel of a colour image, or convert it to grey"
        )
    if min(array.shape) < least:
        raise ValueError(
            f"{name} must have at least {least} x {least} pixels; got {array.shape}"
        )
    return np.ma.array(array, mask=np.ma.getmask(values)) if masked else array


def window_shapes(shape: ArrayLike | None, n: int) -> np.ndarray:
    """Return ((a1, a2), (b1, b2)) of n windows (n, 2, 2); the identity when missing."""
    array = np.eye(2) if shape is None else finite(shape, "shape")
    if array.shape not in ((2, 2), (n, 2, 2)):
        raise ValueError(
            "shape must be ((a1, a2), (b1, b2)), one for all points or one for each,"
            f" (2, 2) or ({n}, 2, 2); got {array.shape}"
        )
    return np.broadcast_to(array, (n, 2, 2))


def covariances(values: ArrayLike, name: str, *, singular: bool = True) -> np.ndarray:
    """Return covariances (..., 2, 2): symmetric and positive semi-definite."""
    array = finite(values, name)
    if array.shape[-2:] != (2, 2):
        raise ValueError(f"{name} must have shape (..., 2, 2); got shape {array.shape}")
    xx, xy, yx, yy = np.moveaxis(array.reshape(*array.shape[:-2], 4), -1, 0)
    rounding = 1e-12 * (np.abs(xx) + np.abs(yy))
    refuse(np.abs(xy - yx) > rounding, name + "{} is not symmetric")
    smaller = (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)  # the smaller eigenvalue
    refuse(smaller < -rounding, name + "{} is not positive semi-definite")
    if not singular:
        refuse(
            smaller <= rounding,
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


# --- Other arguments: flags, words, functions, sequences ---


def flag(value: bool, name: str) -> bool:
    """Return `value` if it is True or False."""
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise ValueError(f"{name} must be True or False; got {shown(value)}")


def instance(value: Any, kind: type[Kind], name: str) -> Kind:
    """Return `value` if it is of this kind, such as a Camera."""
    if isinstance(value, kind):
        return value
    raise ValueError(f"{name} must be a {kind.__name__}; got {shown(value)}")


def several(values: Any, name: str, kind: type = object) -> list:
    """Return the members of a sequence, all of one kind; a text is none."""
    none = isinstance(values, str | bytes | Mapping) or not np.iterable(values)
    members = None if none else list(values)
    if members is None or not all(isinstance(one, kind) for one in members):
        what = {object: "values", str: "texts", dict: "rows"}.get(kind)
        raise ValueError(
            f"{name} must be a sequence of {what or kind.__name__ + 's'}; got"
            f" {shown(values)}"
        )
    return members


def mapping(values: Any, name: str) -> Mapping:
    """Return `values` if it is a mapping."""
    if isinstance(values, Mapping):
        return values
    raise ValueError(f"{name} must be a mapping of names; got {shown(values)}")


def texts(values: Any, name: str, length: int | None = None) -> list[str]:
    """Return a list of texts, as many as `length` says."""
    given = several(values, name, str)
    if length not in (None, len(given)):
        raise ValueError(f"{name} must be {length} texts; got {len(given)}")
    return given


def text(value: str, name: str) -> str:
    """Return `value` if it is a text with something in it."""
    if isinstance(value, str) and value.strip():
        return value
    raise ValueError(f"{name} must be a text that is not empty; got {shown(value)}")


def choice(value: str, name: str, allowed: tuple[str, ...]) -> str:
    """Return `value` if it is one of the allowed words."""
    if isinstance(value, str) and value in allowed:
        return value
    words = ", ".join(map(repr, allowed))
    raise ValueError(f"{name} must be one of {words}; got {shown(value)}")
