"""What is no number: flags, words, functions, cameras, sequences."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np

from pgm_lab._validate._numbers import shown

Kind = TypeVar("Kind")

WORDS: dict[type, str] = {str: "texts", dict: "rows"}


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


def function(value: Any, name: str) -> Callable:
    """Return `value` if it can be called."""
    if callable(value):
        return value
    raise ValueError(f"{name} must be a function; got {shown(value)}")


def several(values: Any, name: str, kind: type | None = None) -> list:
    """Return the members of a sequence, all of one kind; a text is none."""
    what = "values" if kind is None else WORDS.get(kind, f"{kind.__name__}s")
    try:
        members = None if isinstance(values, str | bytes | Mapping) else list(values)
    except Exception:  # whatever the iteration of a stranger's object raises
        members = None
    if members is None or not all(isinstance(one, kind or object) for one in members):
        raise ValueError(f"{name} must be a sequence of {what}; got {shown(values)}")
    return members


def mapping(values: Any, name: str) -> Mapping:
    """Return `values` if it is a mapping."""
    if isinstance(values, Mapping):
        return values
    raise ValueError(f"{name} must be a mapping of names; got {shown(values)}")


def texts(values: Any, name: str, length: int | None = None) -> list[str]:
    """Return a list of texts, as many as `length` says."""
    given = several(values, name, str)
    if length is not None and len(given) != length:
        raise ValueError(f"{name} must be {length} texts; got {len(given)}")
    return given


def text(value: str, name: str) -> str:
    """Return `value` if it is a text with something in it."""
    if isinstance(value, str) and value.strip():
        return value
    raise ValueError(f"{name} must be a text that is not empty; got {shown(value)}")


def choice(value: str, name: str, allowed: tuple[str, ...]) -> str:
    """Return `value` if it is one of the allowed words."""
    if not isinstance(value, str) or value not in allowed:
        words = ", ".join(repr(word) for word in allowed)
        raise ValueError(f"{name} must be one of {words}; got {shown(value)}")
    return value
