"""Answers that somebody gives who has done nothing."""

from collections.abc import Callable, Iterator
from itertools import product
from typing import Any

import numpy as np

CONSTANTS = (0, 1, -1, np.nan, True, False, None)


def _shaped(like: Any, filled: Callable[[tuple[int, ...]], Any]) -> Any:
    """What is filled in the shape of an answer, part by part of a tuple."""
    if isinstance(like, tuple):
        return tuple(_shaped(part, filled) for part in like)
    return filled(np.shape(like))


def _unit(shape: tuple[int, ...]) -> np.ndarray:
    return np.eye(*shape) if len(shape) == 2 else np.ones(shape)


FILLED: dict[str, Callable] = {
    "zeros": np.zeros,
    "ones": np.ones,
    "NaN": lambda shape: np.full(shape, np.nan),
    "identity": _unit,
}


def _of_a_shape(solution: Callable) -> Callable:
    """A function that answers arguments of the same shapes alike."""
    known: dict[tuple, Any] = {}

    def answer(*arguments: Any) -> Any:
        shapes = tuple(np.shape(one) for one in arguments)
        if shapes not in known:
            known[shapes] = solution(*arguments)
        return known[shapes]

    return answer


def functions(solution: Callable) -> Iterator[tuple[str, Callable]]:
    """Give functions that return the same always, or what they were given."""
    solution = _of_a_shape(solution)
    for value in CONSTANTS:
        yield repr(value), lambda *a, value=value: value
    for k, value in product(range(2, 5), CONSTANTS[:-1]):
        yield f"{k} times {value}", lambda *a, all_of_it=(value,) * k: all_of_it
    for k in (0, 1, -1):
        yield f"argument {k}", lambda *a, k=k: a[k]
        yield f"argument {k}, negative", lambda *a, k=k: -np.asarray(a[k])
        for n in (2, 3, 4):
            yield f"argument {k}, {n} times", lambda *a, k=k, n=n: (a[k],) * n
    for name, filled in FILLED.items():
        yield name, lambda *a, filled=filled: _shaped(solution(*a), filled)
    for name, other in product(FILLED, repeat=2):
        if name != other:
            yield f"{name} and {other}", _two(solution, FILLED[name], FILLED[other])


def _two(solution: Callable, first: Callable, rest: Callable) -> Callable:
    """A function whose first part is filled in one way, the others in another."""

    def answer(*arguments: Any) -> Any:
        right = solution(*arguments)
        if not isinstance(right, tuple):
            return _shaped(right, rest)
        one, *others = right
        return _shaped(one, first), *_shaped(tuple(others), rest)

    return answer


def values(right: Any) -> Iterator[tuple[str, Any]]:
    """Give constants, also in the shape of the right answer, and empty lists."""
    yield from ((repr(value), value) for value in (0, 1, np.nan, True, False, None))
    yield from ((repr(value), value) for value in ([], (), ..., ""))
    try:
        shape = np.shape(np.asarray(right, float))
    except ValueError:  # a text
        return
    yield from ((name, filled(shape)) for name, filled in FILLED.items())
