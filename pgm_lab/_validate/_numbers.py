"""Numbers, one or many, and how many of them at most."""

import math
import numbers
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

MOST = 10**8  # numbers in an array that a function makes: 800 MB


def finite(values: Any, name: str) -> np.ndarray:
    """Return `values` as a float array without NaN or infinity."""
    array = real(values, name)
    if not np.all(np.isfinite(array)):
        bad = np.argwhere(~np.isfinite(array))
        where = f"{name}{[int(i) for i in bad[0]]}" if array.ndim else name
        raise ValueError(
            f"{where} is not a finite number; {len(bad)} value(s) are NaN or infinite."
            " Leave such values out before the call"
        )
    return array


def real(values: Any, name: str) -> np.ndarray:
    """Return `values` as a float array, in which NaN and infinity may stand."""
    if type(values) is np.ndarray and values.dtype == float:
        return values
    with np.errstate(over="ignore"):  # infinity says it
        return np.asarray(numeric(values, name), dtype=float)


def numeric(values: Any, name: str) -> np.ndarray:
    """Return `values` as an array of real numbers of their own type."""
    try:
        masked = np.ma.is_masked(values) or (
            isinstance(values, list | tuple) and any(map(np.ma.is_masked, values))
        )
        array = np.asarray(values if not masked else 0.0)
        if array.dtype == object:
            array = _of_objects(array)
    except Exception:  # whatever the conversion of a stranger's object raises
        raise ValueError(f"{name} must be numbers; got {shown(values)}") from None
    if masked:
        raise ValueError(f"{name} has masked values. Leave them out before the call")
    if array.dtype.kind == "c":
        raise ValueError(f"{name} must be real numbers; got complex ones")
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name} must be numbers; got {shown(values)}")
    return array


def _of_objects(array: np.ndarray) -> np.ndarray:
    """Array of objects that are all real numbers as an array of floats."""
    if not all(isinstance(one, numbers.Real | np.bool_) for one in array.flat):
        return array
    whole = all(isinstance(one, numbers.Integral) for one in array.flat)
    return array.astype(np.int64 if whole and array.size else float)


def shown(value: object) -> str:
    """Return a few words on a value, whatever it is."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # of a stranger's object
        text = ""
    return text if 0 < len(text) <= 60 else f"a {type(value).__name__}"


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
    """Return `value` as one number between 0 and 1, neither of them."""
    if 0 < (one := number(value, name)) < 1:
        return one
    raise ValueError(f"{name} must lie between 0 and 1, as a probability; got {one:g}")


def standard_deviation(sigma: ArrayLike | None, name: str = "sigma") -> float | None:
    """Return a standard deviation as one number above zero, or None if not known."""
    if sigma is None:
        return None
    if not (value := number(sigma, name)) > 0:
        raise ValueError(
            f"{name} must be positive, or None if not known; got {sigma!s}"
        )
    return value


def whole(value: Any, name: str, least: int, most: int = MOST) -> int:
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
    """Return the size of a window: an odd number of pixels, so that it has a middle."""
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
    """Refuse an array of so many numbers before it is made."""
    if math.prod(counts) > MOST:
        text = " x ".join(map(str, counts))
        raise ValueError(
            f"{name} asks for {text} numbers at once; the limit is {MOST}: make it"
            " smaller, or in parts"
        )


def pair(values: ArrayLike, name: str, unit: str) -> np.ndarray:
    """Return one positive number, or a positive (x, y), as an array (2,)."""
    array = positive(values, name, unit)
    if array.shape not in ((), (1,), (2,)):
        raise ValueError(
            f"{name} must be one number or (x, y) in {unit}; got shape {array.shape}"
        )
    return np.broadcast_to(array, (2,))
