"""Values as plain data: what travels into the box and out of it, and nothing else.

A value becomes JSON: numbers, texts, lists as they are, everything else in a dict with
one key that says what it is. Nothing is pickled, so that reading a value runs no code.
It stands alone, since the worker in the box uses it too.
"""

import base64
import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

KINDS = "biufcUM"  # of arrays: truth values, numbers, texts, dates


def packed(value: Any, function: Callable[[Callable], int] | None = None) -> Any:
    """Return a value as JSON has it.

    `function` gives a number to a function among the values, which stays where it is.

    Raises
    ------
    TypeError
        If there is something in it that is no plain data.
    """

    def each(values: Any) -> list:
        return [packed(one, function) for one in values]

    if value is None or value is ... or isinstance(value, bool | str):
        return {"dots": 0} if value is ... else value
    if isinstance(value, int):
        return int(value) if abs(value) < 2**63 else {"int": str(int(value))}
    if type(value) is float:
        return value if math.isfinite(value) else {"float": str(value)}
    if isinstance(value, complex):
        return {"complex": [value.real, value.imag]}
    if isinstance(value, np.ndarray | np.generic):
        return {"scalar" if isinstance(value, np.generic) else "array": _array(value)}
    if isinstance(value, tuple):
        return {"tuple": each(value)}
    if isinstance(value, list):
        return each(value)
    if isinstance(value, Mapping):
        return {"dict": [each(pair) for pair in value.items()]}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        return {"fields": packed(fields, function)}
    if function is not None and callable(value):
        return {"function": function(value)}
    if hasattr(value, "__array__"):  # a table of pandas, a tensor
        return packed(np.asarray(value), function)
    raise TypeError(f"no plain data: {type(value).__name__}")


def unpacked(said: Any, function: Callable[[int], Callable] | None = None) -> Any:
    """Return the value that JSON describes; it may come from a stranger.

    Raises
    ------
    ValueError
        If it describes none.
    """
    if isinstance(said, list):
        return [unpacked(one, function) for one in said]
    if not isinstance(said, dict):
        return said
    try:
        ((kind, what),) = said.items()
        if kind == "dots":
            return ...
        if kind == "int":
            return int(str(what)[:1000])
        if kind == "float":
            return float(what)
        if kind == "complex":
            return complex(*what)
        if kind in ("array", "scalar"):
            array = _array_of(*what)
            return array if kind == "array" else array[()]
        if kind == "tuple":
            return tuple(unpacked(what, function))
        if kind == "dict":
            return {unpacked(k, function): unpacked(v, function) for k, v in what}
        if kind == "fields":
            return Fields(**unpacked(what, function))
        if kind == "function" and function is not None:
            return function(what)
    except (TypeError, ValueError, AttributeError, KeyError) as error:
        raise ValueError(f"no plain data: {type(error).__name__}") from None
    raise ValueError("no plain data: an unknown kind")


class Fields:
    """The fields of a result, by their names.

    NumPy would read the memory that a field ``__array_interface__`` points to.
    """

    def __init__(self, **fields: Any) -> None:
        if any(name.startswith("__") for name in fields):
            raise ValueError("not a field")
        vars(self).update(fields)


def _array(value: np.ndarray | np.generic) -> list:
    """An array's type, shape and bytes."""
    array = np.asarray(value)
    if array.dtype.kind not in KINDS:
        raise TypeError(f"no plain data: array of {array.dtype}")
    whole = base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()
    return [array.dtype.str, list(array.shape), whole]


def _array_of(dtype: str, shape: list[int], whole: str) -> np.ndarray:
    """An array from its type, shape and bytes."""
    kind = np.dtype(str(dtype))
    if kind.kind not in KINDS or not all(type(n) is int and n >= 0 for n in shape):
        raise ValueError("not an array of numbers")
    return np.frombuffer(base64.b64decode(whole), kind).reshape(shape).copy()
