"""Feedback on exercises: which property of the reader's function fails, in plain words.

A check calls the reader's function on several inputs, tests one property after the
other and names those that fail. It never shows the answer. The checks of a chapter
stand in the module of its number, ``pgm_book.ch01.checks`` and so on.
"""

import contextlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextvars import ContextVar
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from pgm_book.common.own_program import CheckFailed as CheckFailed
from pgm_book.common.own_program import keep as keep
from pgm_book.common.own_program import own as own
from pgm_book.common.predict import predict as predict
from pgm_lab import _validate

T = TypeVar("T")

# --- The inputs of a check: in a notebook always the same, when graded others ---

_SECRET: ContextVar[int | None] = ContextVar("secret", default=None)


@contextlib.contextmanager
def hidden(secret: int) -> Iterator[None]:
    """Let checks try a function on inputs that a secret decides.

    Who has seen the inputs of the notebooks and their answers knows none of them.
    """
    token = _SECRET.set(secret)
    try:
        yield
    finally:
        _SECRET.reset(token)


def chance(number: int) -> np.random.Generator:
    """Return the random stream of a check, which has a number of its own.

    Examples
    --------
    >>> seen = chance(7).integers(1000)
    >>> with hidden(2013):
    ...     print(chance(7).integers(1000) == seen)
    False
    """
    secret = _SECRET.get()
    return np.random.default_rng(number if secret is None else [number, secret])


def varied(number: int, fixed: T, drawn: Callable[[np.random.Generator], T]) -> T:
    """Return the fixed inputs of a check, or under a secret what is drawn for them.

    Examples
    --------
    >>> varied(7, 20.0, lambda rng: rng.uniform(10, 30))
    20.0
    """
    return fixed if _SECRET.get() is None else drawn(chance(number))


def shaken(number: int, fixed: Any, share: float = 0.1) -> Any:
    """Return fixed numbers; under a secret, each larger or smaller by up to a share.

    Examples
    --------
    >>> with hidden(2013):
    ...     a, b = shaken(7, (20.0, 30.0))
    >>> 18 < a < 22 and 27 < b < 33
    True
    """

    def drawn(rng: np.random.Generator) -> Any:
        numbers = fixed * (1 + share * rng.uniform(-1, 1, np.shape(fixed)))
        return numbers if isinstance(fixed, np.ndarray) else numbers.tolist()

    return varied(number, fixed, drawn)


def shuffled(number: int, n: int) -> list[int]:
    """Return the numbers from 0 to n - 1; under a secret, in another order.

    Where answers are yes and no, who repeats those of the notebook is right otherwise.

    Examples
    --------
    >>> shuffled(7, 3)
    [0, 1, 2]
    """
    return varied(number, list(range(n)), lambda rng: rng.permutation(n).tolist())


# --- What the reader's function answers ---


def answer_of(function: Callable, *arguments: Any, first: str = "") -> Any:
    """Call the reader's function on copies of its arguments; return its result.

    It raises `CheckFailed` if the function raises an error, returns nothing, or changes
    its input. `first` names the exercises whose functions this one uses, for a reader
    who left them out.
    """
    name = getattr(function, "__name__", "your function")
    if not callable(function):
        raise CheckFailed(f"{name} is not a function yet. Your turn!")
    copies = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
    try:
        answer = function(*copies)
    except NameError as error:
        raise CheckFailed(
            f"{name} uses {error.name}, which is not defined yet: is the exercise that"
            " defines it still open, or its cell not run? Your turn!"
        ) from error
    except Exception as error:
        if "ellipsis" in str(error):
            raise CheckFailed(f"{name}: a part is still `...`. Your turn!") from None
        if first and "NoneType" in str(error):
            raise CheckFailed(
                f"{name} got nothing from a function that it uses: do {first} first"
            ) from None
        said = f": {error}" if isinstance(error.args, tuple) and str(error) else ""
        raise CheckFailed(
            f"{name} stopped with {type(error).__name__}{said}"
        ) from error
    if answer is None or answer is ...:
        raise CheckFailed(f"{name} returns nothing yet. Your turn!")
    if isinstance(answer, tuple | list) and any(part is ... for part in answer):
        raise CheckFailed(f"{name}: a part of the answer is still `...`. Your turn!")
    for before, after in zip(arguments, copies, strict=True):
        if isinstance(before, np.ndarray) and not np.array_equal(before, after):
            raise CheckFailed(f"{name} changes its input; work on a copy")
    return answer


def call(
    function: Callable,
    *arguments: Any,
    shape: tuple[int, ...],
    first: str = "",
    single: bool = False,
    nan: bool = False,
    column: bool = True,
) -> np.ndarray:
    """Call the reader's function and return its answer as an array of that shape.

    `first` as in `answer_of`; `single`: whether single precision will do; `nan`:
    whether NaN may stand in it; `column`: whether a column will do for a vector, as it
    will not where the next cell takes it.

    Examples
    --------
    >>> call(lambda x: 2 * x, 1.5, shape=())
    array(3.)
    """
    answer = answer_of(function, *arguments, first=first)
    must = f"{getattr(function, '__name__', 'your function')} must return"
    wanted = f"shape {shape}" if shape else "one number"
    try:
        array = _validate.real(answer, "the answer")
    except ValueError as error:
        if shapes := _shapes(answer):
            raise CheckFailed(
                f"{must} {wanted} here; got parts of shapes {shapes}"
            ) from None
        kind = "" if "must be numbers" in str(error) else f" ({error})"
        raise CheckFailed(
            f"{must} numbers, not {type(answer).__name__}{kind}"
        ) from None
    if column or array.shape != (*shape, 1):
        array = _without_ones(array, shape)
    if array.shape != shape:
        tip = _turned(shape) if array.shape == shape[::-1] else ""
        got = array.shape if shape else f"an array of shape {array.shape}"
        raise CheckFailed(f"{must} {wanted} here; got {got}{tip}")
    if not (nan or np.all(np.isfinite(array))):
        what = "NaN" if np.isnan(array).any() else "infinity"
        raise CheckFailed(
            f"{must} finite numbers here; got {what}: look for a division"
        )
    if not single and np.asarray(answer).dtype in (np.float32, np.float16):
        raise CheckFailed(
            f"{must} all digits; it returns single precision: work with float64"
        )
    return array


@contextlib.contextmanager
def in_words(hint: str) -> Iterator[None]:
    """Say what it means if shapes do not fit, within NumPy or in the answer."""
    try:
        yield
    except CheckFailed as error:
        if isinstance(error.__cause__, ValueError) or "of shape" in str(error):
            raise CheckFailed(f"{error}. {hint}") from error.__cause__
        raise


def _without_ones(array: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Take an array whose shape differs by axes of length 1 only as one of `shape`."""
    same = [n for n in array.shape if n != 1] == [n for n in shape if n != 1]
    return array.reshape(shape) if same else array


def _shapes(answer: object) -> str:
    """Shapes of the parts of an answer that do not make one array; "" if none has."""
    try:
        shapes = [np.shape(part) for part in answer]  # type: ignore[attr-defined]
    except Exception:  # no parts, or parts without a shape
        return ""
    return ", ".join(map(str, shapes)) if len(set(shapes)) > 1 else ""


def _turned(shape: tuple[int, ...]) -> str:
    """What to do about an array of the transposed shape."""
    if len(shape) == 2 and min(shape) > 3:
        return ": rows and columns are exchanged"
    wide = len(shape) == 2 and 1 < shape[0] < shape[1]
    return f"; use np.{'array' if wide else 'column_stack'}([...])"


def numbers(
    name: str, answer: object, shape: tuple[int, ...] = (), wanted: str = "one number"
) -> np.ndarray:
    """Return the value that a reader gives a name as an array of that shape.

    `wanted` says in words what a right answer looks like.

    Examples
    --------
    >>> numbers("my_sum", 3)
    array(3.)
    """
    if answer is ... or answer is None:
        raise CheckFailed(f"{name} is still empty. Your turn!")
    try:
        number = float(answer) if isinstance(answer, str) else answer
        array = _without_ones(_validate.finite(number, name), shape)
    except ValueError:
        raise CheckFailed(f"{name} must be {wanted}") from None
    if array.shape != shape:
        got = f"; got {array.shape}" if array.shape else ""
        raise CheckFailed(f"{name} must be {wanted}{got}")
    return array


def report(
    name: str, properties: Iterable[tuple[str, bool | None, str]], right: str = ""
) -> None:
    """Print the properties that hold, or raise `CheckFailed` with hints to the others.

    `properties` are (property, whether it holds, hint), in plain words; None stands for
    one that says nothing, because another has to hold first. `right` is printed for
    many properties in place of each of them.

    Examples
    --------
    >>> report("my_sum", [("adds", True, "it does not add")])
    ✓ my_sum: adds.
    """
    properties = list(properties)
    results = tuple(
        (text, None if holds is None else bool(holds)) for text, holds, _ in properties
    )
    hints = [hint for _, holds, hint in properties if not (holds is None or holds)]
    if hints:
        whole = f"{name}: " + "; ".join(hints).replace("?; ", "? ")
        failed = CheckFailed(whole if whole.endswith(("?", "!")) else whole + ".")
        failed.properties = results
        raise failed
    right = right or "; ".join(text for text, holds in results if holds)
    print(f"✓ {name}: {right}.")


def along_with(holds: bool, other: bool) -> bool | None:
    """Whether a property holds that counts only if another one does; else None.

    So is treated what a function has that does nothing: zeros add up, and what is the
    same for all inputs has the right answer for some of them.

    Examples
    --------
    >>> along_with(True, True), along_with(True, False), along_with(False, False)
    (True, None, False)
    """
    return None if holds and not other else bool(holds)


def near(answer: ArrayLike, expected: ArrayLike, tolerance: float = 1e-9) -> bool:
    """True if all numbers agree to a tolerance relative to the largest of them."""
    found, wanted = np.asarray(answer, float), np.asarray(expected, float)
    scale = max(1.0, float(np.max(np.abs(wanted), initial=0.0)))
    return bool(np.all(np.abs(found - wanted) <= tolerance * scale))


def first_slip(
    answer: ArrayLike,
    slips: Iterable[tuple[ArrayLike, str]],
    otherwise: str,
    tolerance: float = 1e-6,
) -> str:
    """Hint to the first slip that explains the whole answer.

    `slips` are (wrong answer, hint): the results of common slips.

    Examples
    --------
    >>> first_slip(2.0, [(-4.0, "the sign"), (2.0, "a factor of two")], "no idea")
    'a factor of two'
    """
    for wrong, hint in slips:
        if near(answer, wrong, tolerance):
            return hint
    return otherwise


def compare(
    function: Callable,
    cases: Iterable[tuple],
    right: Callable,
    slips: Mapping[str, Callable],
    otherwise: str,
) -> tuple[bool, str]:
    """Whether the reader's function is right in all cases, and the hint if it is not.

    `cases` are tuples of arguments; `slips` has a function with one slip for each hint.

    Examples
    --------
    >>> slips = {"the sign is reversed": lambda x: -2 * x}
    >>> compare(lambda x: -2 * x, [(1,), (3,)], lambda x: 2 * x, slips, "no idea")
    (False, 'the sign is reversed')
    """
    cases = list(cases)
    answers = [call(function, *c, shape=np.shape(right(*c))) for c in cases]

    def explains(other: Callable) -> bool:
        return all(near(a, other(*c), 1e-8) for a, c in zip(answers, cases))

    if explains(right):
        return True, ""
    return False, next((h for h, wrong in slips.items() if explains(wrong)), otherwise)
